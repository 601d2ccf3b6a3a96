// plc: checks, compiles, explains and simulates PLC projects on the engineer's machine. plc-run runs them on the plant.
#include <exception>
#include <new>

#include "tools/command_line.h"
#include "tools/plc/commands.h"
#include "tools/version.h"

int main(int argc, char** argv) {
  using namespace plc::tools;
  CLI::App app{
      "Checks, compiles, explains and simulates PLC projects drawn in LD or FBD and exported as PLCopen XML.\n"
      "\n"
      "Examples:\n"
      "  plc check plant.xml                          does it compile? all problems, with line and element\n"
      "  plc explain plant.xml Main                   in which order the elements execute, and why\n"
      "  plc explain plant.xml --schedule             do all tasks end in time? response times and margins\n"
      "  plc explain P3007                            what a problem code means, with a wrong and a right example\n"
      "  plc lib TON                                  what a function or block of the library means, with examples\n"
      "  plc blocks LOWPASS                           what a taskblock does: components in C++ that drawings use\n"
      "  plc sim plant.xml --cycles 500 --trace -     run it in virtual time, all variables as CSV\n"
      "  plc compile plant.xml -o plant.pbc           an image for plc-run\n"
      "  plc config init plant.xml -o plc.toml        devices and Modbus of this machine: a file to fill in\n"
      "  plc map plant.xml                            which Modbus address each variable has; files for HMIs\n"
      "\n"
      "Exit codes: 0 all is well, 1 the project has errors, 2 wrong flags or a file that cannot be opened.",
      "plc"};
  app.set_version_flag("--version", kVersionText);
  app.require_subcommand(1);
  int exit_code = kExitOk;
  add_blocks(app, exit_code);
  add_calibrate(app, exit_code);
  add_check(app, exit_code);
  add_compile(app, exit_code);
  add_config(app, exit_code);
  add_dump(app, exit_code);
  add_explain(app, exit_code);
  add_lib(app, exit_code);
  add_map(app, exit_code);
  add_sim(app, exit_code);
  add_report(app, exit_code);
  try {
    const auto code = parse(app, argc, argv);
    return close_output("plc", code.value_or(exit_code));
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
