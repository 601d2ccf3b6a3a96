// The examples of a page of docs/problems; docs/guides/problem-pages.md says how pages write them.
//
// In: the page's file. Out: what its wrong and its right example consist of. Does not belong here: running them.
#pragma once

#include <map>
#include <string>

namespace plc::test {

/// One example: files by name, and the commands to run, or none.
struct Example {
  std::map<std::string, std::string> files;
  std::string commands;
  [[nodiscard]] bool runs() const { return !files.empty() || !commands.empty(); }
};

/// The fenced blocks below "## `heading`" of the file `page`; nothing when there is no such file.
Example read_example(const std::string& page, const std::string& heading);

/// What plc.toml is checked against where the page brings no project.
extern const char* const kSmallProject;

/// True when the code is in `output` as a word.
bool names(const std::string& output, const std::string& code);

}  // namespace plc::test
