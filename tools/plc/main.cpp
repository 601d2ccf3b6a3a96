// plc: checks, compiles, explains and simulates PLC projects on the engineer's machine. plc-run runs them on the plant.
#include <fmt/format.h>

#include <string>

#include "tools/command_line.h"
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
  const Program program("plc", description(), kVersionText);
#define PLC_COMMAND(name, example, purpose) add_##name(program);
#include "tools/plc/commands.def"
  return close_output("plc", program.parse(argc, argv).value_or(kExitOk));
}

}  // namespace
}  // namespace plc::tools

int main(int argc, char** argv) { return plc::tools::guarded("plc", plc::tools::run, argc, argv); }
