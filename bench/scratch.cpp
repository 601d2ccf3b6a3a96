#include "bench/scratch.h"

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <system_error>

namespace plc::bench {

Scratch::Scratch() {
  std::string name = (std::filesystem::temp_directory_path() / "plc-bench-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  path_ = name;
}
Scratch::~Scratch() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace plc::bench
