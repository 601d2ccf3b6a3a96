// plc dump: the listing of an image.
#include <iostream>
#include <string>

#include "tools/command_line.h"
#include "tools/plc/commands.h"
#include "tools/taskblock_libraries.h"

namespace plc::tools {
namespace {

struct Dump {
  std::string file, configuration;
  core::CompileOptions options;
  std::vector<std::string> libraries;
};

int run(const CLI::App& app, const Dump& dump) {
  taskblocks::Registry registry;
  if (const auto code = load_taskblocks(dump.configuration, registry)) return *code;
  Compilation compilation;
  if (const auto code =
          open_or_explain(app, {dump.file, dump.options, Goal::kRun, dump.libraries, {}, &registry}, compilation)) {
    return *code;
  }
  std::cout << bytecode::disassemble(compilation.image->image());
  return kExitOk;
}

}  // namespace

void add_dump(CLI::App& app, int& exit_code) {
  static Dump dump;
  CLI::App* command = app.add_subcommand("dump",
                                         "Prints the instructions and tables of an image, or of what a project compiles to.\n"
                                         "\n"
                                         "Examples:\n"
                                         "  plc dump plant.pbc\n"
                                         "  plc dump plant.xml --pou Mixer");
  command->add_option("FILE", dump.file, "image, or PLCopen XML or ST file")->required();
  add_library_option(*command, dump.libraries);
  add_taskblocks_option(*command, dump.configuration);
  add_compile_options(*command, dump.options);
  command->callback([&exit_code, command] { exit_code = run(*command, dump); });
}

}  // namespace plc::tools
