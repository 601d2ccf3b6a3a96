#include "engineering/tar.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
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

core::Result<std::string> tar_of(const std::string& folder, std::size_t most_bytes,
                                 const std::vector<std::string>& without) {
  std::error_code error;
  std::vector<std::string> names;
  for (auto it = fs::recursive_directory_iterator(folder, error); !error && it != fs::recursive_directory_iterator();
       it.increment(error)) {
    const bool left_out = it->path().filename().string().starts_with('.') ||
                          std::any_of(without.begin(), without.end(), [&it](const std::string& one) {
                            std::error_code none;
                            return !one.empty() && fs::equivalent(it->path(), one, none);
                          });
    if (left_out) {
      if (it->is_directory(error)) it.disable_recursion_pending();
      continue;
    }
    if (it->is_symlink(error) || !it->is_regular_file(error)) continue;
    names.push_back(fs::relative(it->path(), folder, error).generic_string());
  }
  if (error) return core::Problem{core::Code::P7001, "cannot read " + folder + ": " + error.message(), {}};
  std::sort(names.begin(), names.end());
  std::string archive;
  const core::Problem too_large{core::Code::P7717, folder + " is too large, or has too long names, to be sent", {}};
  for (const std::string& name : names) {
    const fs::path path = fs::path(folder) / name;
    const auto room = most_bytes - std::min(archive.size(), most_bytes);
    const std::uintmax_t size = fs::file_size(path, error);
    if (name.size() > kMostName || (!error && size > room)) return too_large;
    // It may grow meanwhile: no more is read than may be sent.
    std::string bytes(error ? 0 : static_cast<std::size_t>(size), '\0');
    std::ifstream in(path, std::ios::binary);
    in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    bytes.resize(static_cast<std::size_t>(in.gcount()));
    archive += header_of(name, bytes.size()) + bytes;
    archive.resize((archive.size() + kBlock - 1) / kBlock * kBlock, '\0');
  }
  archive.append(2 * kBlock, '\0');
  return archive;
}

}  // namespace plc::engineering
