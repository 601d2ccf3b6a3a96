// plc dump: the listing of an image.
#include <fmt/format.h>

#include <iostream>
#include <string>
#include <vector>

#include "bytecode/drawings.h"
#include "native/compile.h"
#include "runtime/resource.h"
#include "tools/command_line.h"
#include "tools/open.h"
#include "tools/plc/commands.h"
#include "tools/statistics.h"
#include "tools/taskblock_libraries.h"

namespace plc::tools {
namespace {

struct Dump {
  std::string file, configuration;
  bool native = false;
  core::CompileOptions options;
  std::vector<std::string> libraries;
};

/// Per task: machine code of each POU, and the instructions that the interpreter runs.
int print_native(bytecode::VerifiedImage image, const taskblocks::Registry& registry) {
  runtime::ProgramOptions options;
  options.taskblocks = &registry;
  options.start_taskblocks = false;
  auto loaded = runtime::Resource::load(std::move(image), options);
  if (!loaded) return complain(loaded.error()), kExitErrors;
  runtime::Resource& resource = **loaded;
  for (std::size_t task = 0; task < resource.task_count(); ++task) {
    runtime::Program& program = resource.program(task);
    const auto compiled = native::compile(program);
    if (!compiled) return complain(compiled.error()), kExitErrors;
    const native::CompileReport& report = (*compiled)->report();
    std::cout << fmt::format("task {}: {} bytes of native code\n", program.task().name, report.code_bytes);
    std::vector<std::vector<std::string>> rows = {{"POU", "bytes"}};
    for (const native::CompileReport::Body& body : report.bodies) {
      rows.push_back({program.image().pous[body.pou].name, std::to_string(body.bytes)});
    }
    print_table(rows, std::cout);
    rows = {{"in the interpreter", "instructions"}};
    for (const auto& [op, count] : report.interpreted) {
      rows.push_back({std::string(native::name_of(op)), std::to_string(count)});
    }
    print_table(rows, std::cout);
  }
  return kExitOk;
}

/// The listing, with the size of the drawings in place of their bytes.
void print_listing(const bytecode::Image& image) {
  bytecode::Image listed = image;
  listed.drawings.clear();
  std::cout << bytecode::disassemble(listed);
  if (image.drawings.empty()) return;
  const auto drawings = bytecode::unpack(image.drawings);
  std::size_t elements = 0, statements = 0;
  for (const bytecode::DrawnBody& body : drawings->bodies) {
    elements += body.elements.size();
    statements += body.statements.size();
  }
  std::cout << fmt::format("; drawings of {} bodies with {} elements and {} statements: {} bytes\n",
                           drawings->bodies.size(), elements, statements, image.drawings.size());
}

int run(Command command, const Dump& dump) {
  taskblocks::Registry registry;
  std::vector<std::string> libraries = dump.libraries;
  if (const auto code = load_taskblocks(dump.configuration, registry, libraries)) return *code;
  Compilation compilation;
  if (const auto code = open_or_explain(command, {dump.file, dump.options, Goal::kRun, libraries, {}, &registry, true},
                                        compilation)) {
    return *code;
  }
  if (dump.native) return print_native(std::move(*compilation.image), registry);
  print_listing(compilation.image->image());
  return kExitOk;
}

}  // namespace

void add_dump(Command program) {
  static Dump dump;
  const Command command =
      program.sub("dump",
                  "Prints the instructions and tables of an image, or of what a project compiles to.\n"
                  "\n"
                  "Examples:\n"
                  "  plc dump plant.pbc\n"
                  "  plc dump plant.xml --native   what the native engine makes of it\n"
                  "  plc dump plant.xml --pou Mixer");
  command.option("FILE", dump.file, "image, or PLCopen XML or ST file").required();
  command.flag("--native", dump.native,
               "instead: per task the size of the native code of each POU, and which instructions run in the "
               "interpreter");
  add_library_option(command, dump.libraries);
  add_taskblocks_option(command, dump.configuration);
  add_compile_options(command, dump.options);
  command.on_run([command] { return run(command, dump); });
}

}  // namespace plc::tools
