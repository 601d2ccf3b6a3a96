#include "tools/watched_paths.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "runtime/access.h"
#include "tools/command_line.h"

namespace plc::tools {

std::vector<std::string> watched_paths(const std::vector<std::string>& patterns, runtime::Resource& resource) {
  const runtime::Access access(resource);
  if (patterns.empty()) return access.list_names();
  std::vector<std::string> paths;
  for (const std::string& pattern : patterns) {
    for (std::string& path : access.list_names(pattern)) {
      if (std::find(paths.begin(), paths.end(), path) == paths.end()) paths.push_back(std::move(path));
    }
  }
  return paths;
}

std::optional<int> open_trace(const char* command, const std::string& file, const std::vector<std::string>& watch,
                              std::optional<runtime::ValueStyle> values, runtime::Resource& resource,
                              std::unique_ptr<io::TraceWriter>& trace) {
  if (file.empty() && watch.empty()) return {};
  const std::vector<std::string> paths = watched_paths(watch, resource);
  // A program without variables has an empty trace, and is none the worse for it.
  if (paths.empty() && !watched_paths({}, resource).empty()) {
    complain(command, fmt::format("no variable matches --watch {}", fmt::join(watch, " --watch ")),
             "paths begin with the name of a program instance or a global: --watch '*' lists all of them");
    return kExitUsage;
  }
  // Who looks at a few variables reads names; what a file is compared with has numbers.
  const auto usual = file.empty() ? runtime::ValueStyle::kNames : runtime::ValueStyle::kNumbers;
  auto writer = io::TraceWriter::open(file.empty() ? "-" : file, paths, resource, values.value_or(usual));
  if (!writer) return complain(writer.error()), exit_code_of(writer.error());
  trace = std::move(*writer);
  return {};
}

}  // namespace plc::tools
