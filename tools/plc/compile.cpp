// plc compile: project file to image file.
#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <string>
#include <system_error>

#include "io-drivers/modbus/address_map.h"
#include "tools/command_line.h"
#include "tools/open.h"
#include "tools/plc/commands.h"
#include "tools/taskblock_libraries.h"

namespace plc::tools {
namespace {

struct Compile {
  std::string file, output, configuration;
  bool drawings = false;
  core::CompileOptions options;
  std::vector<std::string> libraries;
};

int run(Command command, const Compile& compile) {
  Compilation compilation;
  if (is_image_path(compile.file)) {
    complain("plc compile", compile.file + " is an image already", "give the file it was made from");
    return kExitUsage;
  }
  std::error_code ignored;
  if (std::filesystem::equivalent(compile.file, compile.output, ignored)) {
    complain("plc compile", "-o " + compile.output + " would overwrite the project",
             "give the image a name of its own: X.pbc");
    return kExitUsage;
  }
  taskblocks::Registry registry;
  std::vector<std::string> libraries = compile.libraries;
  io::Configuration configuration;
  core::Diagnostics diagnostics;
  if (const auto code = load_taskblocks(compile.configuration, registry, libraries, configuration, diagnostics)) {
    diagnostics.render_with_lines(std::cerr);
    return *code;
  }
  Request request{compile.file, compile.options, Goal::kRun, libraries, {}, &registry};
  request.drawings = compile.drawings;
  if (const auto code = open_or_explain(command, request, compilation)) return *code;
  const auto frozen = modbus::read_frozen(modbus::lock_file_of(configuration, compile.file));
  if (!frozen) {
    complain(frozen.error());
    return exit_code_of(frozen.error());
  }
  std::vector<std::byte> bytes;
  if (frozen->entries.empty()) {
    bytes = bytecode::save(compilation.image->image());
  } else {
    // The addresses that clients know go where the image goes.
    bytecode::Image with_addresses = compilation.image->image();
    with_addresses.frozen_addresses = modbus::frozen_text(*frozen);
    bytes = bytecode::save(with_addresses);
  }
  if (bytes.size() > kMaxImageBytes) {
    complain("plc compile",
             fmt::format("the image would have {} bytes, at most {} are loaded", bytes.size(), kMaxImageBytes),
             "make arrays smaller");
    return kExitErrors;
  }
  if (compile.output == "-") {
    std::cout.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    return kExitOk;
  }
  std::string why;
  if (!write_file(compile.output, {reinterpret_cast<const char*>(bytes.data()), bytes.size()}, why)) {
    complain("plc compile", fmt::format("{} cannot be written: {}", compile.output, why));
    return kExitUsage;
  }
  std::cout << fmt::format("{}: {} bytes, {}\n", compile.output, bytes.size(), describe(compile.options));
  return kExitOk;
}

}  // namespace

void add_compile(Command program) {
  static Compile compile;
  const Command command =
      program.sub("compile",
                  "Compiles a project into an image, which plc-run and plc sim load without compiling.\n"
                  "\n"
                  "Example:\n"
                  "  plc compile plant.xml -o plant.pbc && plc-run plant.pbc");
  command.option("FILE", compile.file, "PLCopen XML or ST file, or source folder").required();
  command.option("-o,--output=X.pbc", compile.output, "image to write; - is standard output").required();
  command.flag("--drawings", compile.drawings,
               "put in what the POUs look like, for pictures of the running program (plc explain --svg)");
  add_library_option(command, compile.libraries);
  add_taskblocks_option(command, compile.configuration);
  add_compile_options(command, compile.options);
  command.on_run([command] { return run(command, compile); });
}

}  // namespace plc::tools
