// plc: checks, compiles, explains and simulates PLC projects on the engineer's machine. plc-run runs them on the plant.
#include <fmt/format.h>

#include <exception>
#include <new>
#include <string>

#include "tools/command_line.h"
#include "tools/manual.h"
#include "tools/plc/commands.h"
#include "tools/version.h"

namespace plc::tools {
namespace {

std::string description() {
  std::string text =
      "Checks, compiles, explains and simulates PLC projects: PLCopen XML drawn in LD or FBD, and Structured Text.\n"
      "\n"
      "Examples:\n";
#define PLC_COMMAND(name, example, purpose) text += fmt::format("  {:<43}  {}\n", "plc " #name " " example, purpose);
#include "tools/plc/commands.def"
  return text +
         "\n"
         "Exit codes: 0 all is well, 1 the project has errors, 2 wrong flags or a file that cannot be opened.";
}

int run(int argc, char** argv) {
  CLI::App app(description(), "plc");
  app.set_version_flag("--version", kVersionText);
  add_manual_option(app);
  app.require_subcommand(1);
  int exit_code = kExitOk;
#define PLC_COMMAND(name, example, purpose) add_##name(app, exit_code);
#include "tools/plc/commands.def"
  const auto code = parse(app, argc, argv);
  return close_output("plc", code.value_or(exit_code));
}

}  // namespace
}  // namespace plc::tools

int main(int argc, char** argv) {
  using namespace plc::tools;
  try {
    return run(argc, argv);
  } catch (const std::bad_alloc&) {
    complain("plc", "error P5001: the project needs more memory than this machine gives",
             "look for arrays and instances of great size: plc explain P5001");
    return kExitErrors;
  } catch (const std::exception& error) {
    complain("plc", std::string("internal error P9001: ") + error.what(),
             "please report this with the file that caused it");
    return kExitErrors;
  }
}
