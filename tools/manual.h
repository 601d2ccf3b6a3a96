// Manual pages, made of what a program says of its flags: --manual of Program (cli.h).
//
// In: a CLI11 application with all its commands. Out: a page for man(1). Does not belong here: what the flags mean,
// which the application says itself.
#pragma once

#include <string>

namespace CLI {
class App;
}  // namespace CLI

namespace plc::tools {

/// The page in the language of man(7): name, synopsis, what --help says, all flags, examples, exit codes.
std::string manual_page(const CLI::App& app);

/// "plc config check": the command with those it belongs to.
std::string full_name(const CLI::App& app);

}  // namespace plc::tools
