// The commands of plc, one file each. add_*() declares the command's flags and what to call when it is chosen.
//
// In: the application, the place for the exit code. Out: the exit code once CLI11 has run the chosen command.
#pragma once

#include <CLI/CLI.hpp>

namespace plc::tools {

void add_blocks(CLI::App& app, int& exit_code);
void add_calibrate(CLI::App& app, int& exit_code);
void add_check(CLI::App& app, int& exit_code);
void add_compile(CLI::App& app, int& exit_code);
void add_config(CLI::App& app, int& exit_code);
void add_dump(CLI::App& app, int& exit_code);
void add_explain(CLI::App& app, int& exit_code);
void add_lib(CLI::App& app, int& exit_code);
void add_map(CLI::App& app, int& exit_code);
void add_sim(CLI::App& app, int& exit_code);
void add_report(CLI::App& app, int& exit_code);

}  // namespace plc::tools
