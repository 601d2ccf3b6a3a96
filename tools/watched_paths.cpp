#include "tools/watched_paths.h"

#include <algorithm>

#include "runtime/access.h"

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

}  // namespace plc::tools
