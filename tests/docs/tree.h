// Files of the source tree, for the tests of the documents.
//
// Out: paths and texts. Does not belong here: what must be true of them.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace plc::test {

inline const std::filesystem::path kRoot = PLC_SOURCE_DIR;

inline std::string text_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Files below a folder, without build folders at its top and what starts with a dot.
inline std::vector<std::filesystem::path> tree(const std::filesystem::path& root = kRoot) {
  namespace fs = std::filesystem;
  std::vector<fs::path> files;
  auto it = fs::recursive_directory_iterator(root);
  for (; it != fs::recursive_directory_iterator(); ++it) {
    const std::string name = it->path().filename().string();
    if (it->is_directory() && (name.front() == '.' || (it.depth() == 0 && name.rfind("build", 0) == 0))) {
      it.disable_recursion_pending();
    } else if (it->is_regular_file()) {
      files.push_back(it->path());
    }
  }
  return files;
}

}  // namespace plc::test
