#include "engineering/tar.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

namespace plc::engineering {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBlock = 512;
constexpr std::size_t kMostName = 99;

void put(std::string& header, std::size_t at, std::string_view text) { header.replace(at, text.size(), text); }

std::string header_of(const std::string& name, std::size_t size) {
  std::string header(kBlock, '\0');
  put(header, 0, name);
  put(header, 100, "0000644");
  put(header, 108, "0000000");
  put(header, 116, "0000000");
  put(header, 124, fmt::format("{:011o}", size));
  put(header, 136, "00000000000");  // no time: the same files give the same archive
  put(header, 148, "        ");
  header[156] = '0';
  put(header, 257,
      std::string_view("ustar\0"
                       "00",
                       8));
  unsigned sum = 0;
  for (const char c : header) sum += static_cast<unsigned char>(c);
  put(header, 148, fmt::format("{:06o}", sum));
  header[154] = '\0';
  return header;
}

}  // namespace

core::Result<std::string> tar_of(const std::string& folder, std::size_t most_bytes) {
  std::error_code error;
  std::vector<std::string> names;
  for (auto it = fs::recursive_directory_iterator(folder, error); !error && it != fs::recursive_directory_iterator();
       it.increment(error)) {
    if (it->path().filename().string().starts_with('.')) {
      if (it->is_directory(error)) it.disable_recursion_pending();
      continue;
    }
    if (it->is_symlink(error) || !it->is_regular_file(error)) continue;
    names.push_back(fs::relative(it->path(), folder, error).generic_string());
  }
  if (error) return core::Problem{core::Code::P7001, "cannot read " + folder + ": " + error.message(), {}};
  std::sort(names.begin(), names.end());
  std::string archive;
  for (const std::string& name : names) {
    std::ifstream in(fs::path(folder) / name, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    if (name.size() > kMostName || archive.size() + bytes.size() > most_bytes) {
      return core::Problem{core::Code::P7717, folder + " is too large, or has too long names, to be sent", {}};
    }
    archive += header_of(name, bytes.size()) + bytes;
    archive.resize((archive.size() + kBlock - 1) / kBlock * kBlock, '\0');
  }
  archive.append(2 * kBlock, '\0');
  return archive;
}

}  // namespace plc::engineering
