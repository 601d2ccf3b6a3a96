// Manual pages, made of what a program says of its flags.
//
// In: a CLI11 application with all its commands. Out: a page for man(1). Does not belong here: what the flags mean,
// which the application says itself.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace plc::tools {

/// The page in the language of man(7): name, synopsis, what --help says, all flags, examples, exit codes.
std::string manual_page(const CLI::App& app);

/// Adds --manual, which prints it and ends the program.
void add_manual_option(CLI::App& app);

}  // namespace plc::tools
