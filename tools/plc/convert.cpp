// plc convert: a project of any form as one text.
#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <string>
#include <system_error>

#include "bytecode/fingerprint.h"
#include "convert/write.h"
#include "tools/command_line.h"
#include "tools/open.h"
#include "tools/plc/commands.h"
#include "tools/taskblock_libraries.h"

namespace plc::tools {
namespace {

struct Convert {
  std::string file, output, configuration;
  core::CompileOptions options;
  std::vector<std::string> libraries;
};

/// Reads what was written back, and says whether it is the same program.
int compare(const Convert& convert, const std::vector<std::string>& libraries, const taskblocks::Registry& registry,
            const std::vector<convert::Remark>& remarks) {
  Compilation original, written;
  open({convert.file, convert.options, Goal::kCheck, libraries, {}, &registry}, original);
  open({convert.output, convert.options, Goal::kCheck, libraries, {}, &registry}, written);
  if (!written.ok()) {
    written.diagnostics.render_with_lines(std::cerr);
    complain("plc convert", convert.output + " does not read back as the same project",
             "report it with the project: plc --version");
    return kExitErrors;
  }
  if (!original.image || !written.image) {
    std::cout << fmt::format("{}: written; no task runs a program, so that there are no images to compare\n",
                             convert.output);
    return kExitOk;
  }
  const bytecode::Image& a = original.image->image();
  const bytecode::Image& b = written.image->image();
  const std::string difference = bytecode::difference(a, b);
  if (difference.empty()) {
    std::cout << fmt::format("{}: same image as {}, fingerprint {:016x}\n", convert.output, convert.file,
                             bytecode::fingerprint(b));
    return kExitOk;
  }
  std::cout << fmt::format("{}: does what {} does; the image is another one ({})\n", convert.output, convert.file,
                           difference);
  for (const convert::Remark& remark : remarks) std::cout << fmt::format("  {} {}\n", remark.pou, remark.text);
  return kExitOk;
}

int run(Command command, const Convert& convert) {
  if (const auto code = refuse_options_of_image(command, convert.file)) return *code;
  if (is_image_path(convert.file)) {
    complain("plc convert", convert.file + " is an image: it has no declarations any more",
             "give the project it was made from");
    return kExitUsage;
  }
  std::error_code ignored;
  if (std::filesystem::equivalent(convert.file, convert.output, ignored)) {
    complain("plc convert", "-o " + convert.output + " would overwrite the project", "give the text a name of its own");
    return kExitUsage;
  }
  taskblocks::Registry registry;
  std::vector<std::string> libraries = convert.libraries;
  if (const auto code = load_taskblocks(convert.configuration, registry, libraries)) return *code;
  // All tasks are written, whatever --pou runs alone.
  core::CompileOptions whole = convert.options;
  whole.pou.clear();
  Compilation lowered;
  if (const auto code =
          open_or_explain(command, {convert.file, whole, Goal::kModule, libraries, {}, &registry}, lowered)) {
    return *code;
  }
  // Bodies were released as they were lowered: they are read once more.
  core::Diagnostics again;
  const auto project = compiler::read_project(convert.file, again, convert.options.defines);
  if (!project) return kExitErrors;
  core::Diagnostics problems;
  for (std::size_t i = 0; i < lowered.diagnostics.file_count(); ++i) {
    problems.add_file(lowered.diagnostics.file_name(static_cast<std::uint16_t>(i)));
  }
  const auto written = convert::write(*project, *lowered.module, problems);
  problems.render_with_lines(std::cerr);
  if (!written) return kExitErrors;
  if (convert.output == "-") {
    std::cout << written->text;
    return kExitOk;
  }
  std::string why;
  if (!write_file(convert.output, written->text, why)) {
    complain("plc convert", fmt::format("{} cannot be written: {}", convert.output, why));
    return kExitUsage;
  }
  return compare(convert, libraries, registry, written->remarks);
}

}  // namespace

void add_convert(Command program) {
  static Convert convert;
  const Command command = program.sub(
      "convert",
      "Writes a project as one text of Structured Text: types, variables, tasks as they are declared, bodies in ST as\n"
      "they are written, drawings as statements in the order of their execution, charts in words. Reads the text back\n"
      "and says whether it makes the same image; otherwise why not.\n"
      "\n"
      "Examples:\n"
      "  plc convert plant.xml -o plant.st\n"
      "  plc convert Plant.plcproj -o plant.st");
  command.option("FILE", convert.file, "PLCopen XML or ST file, or source folder").required();
  command.option("-o,--output=X.st", convert.output, "text to write; - is standard output, and nothing is compared")
      .required();
  add_library_option(command, convert.libraries);
  add_taskblocks_option(command, convert.configuration);
  add_compile_options(command, convert.options);
  command.on_run([command] { return run(command, convert); });
}

}  // namespace plc::tools
