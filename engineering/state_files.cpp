#include "engineering/state_files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace plc::engineering {
namespace {

constexpr std::uintmax_t kMostBytes = 64'000'000;

std::string refused(const std::string& path) { return "cannot write " + path + ": " + std::strerror(errno); }

bool write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

std::string make_private_folder(const std::string& folder) {
  std::error_code error;
  const std::filesystem::path path(folder);
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
  if (::mkdir(folder.c_str(), 0700) == 0 || errno == EEXIST) return {};
  return "cannot make " + folder + ": " + std::strerror(errno);
}

std::string write_private_file(const std::string& path, std::string_view bytes) {
  return write_file(path, bytes, 0600);
}

std::string write_file(const std::string& path, std::string_view bytes, unsigned mode) {
  const std::string made = path + ".new";
  const int file = ::open(made.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, mode);
  if (file < 0) return refused(made);
  const bool written = ::fchmod(file, mode) == 0 && write_all(file, bytes) && ::fsync(file) == 0;
  std::string why = written ? std::string() : refused(made);
  ::close(file);
  if (why.empty() && std::rename(made.c_str(), path.c_str()) != 0) why = refused(path);
  if (!why.empty()) {
    ::unlink(made.c_str());
    return why;
  }
  const std::string folder = std::filesystem::path(path).parent_path().string();
  const int directory = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory >= 0) {
    ::fsync(directory);
    ::close(directory);
  }
  return {};
}

std::optional<std::string> read_whole_file(const std::string& path, std::string& why) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) return std::nullopt;
  std::ifstream in(path, std::ios::binary);
  if (!in || status.type() != std::filesystem::file_type::regular) {
    why = "cannot read " + path + ": " + (errno != 0 && !in ? std::strerror(errno) : "it is no file");
    return std::nullopt;
  }
  if (std::filesystem::file_size(path, error) > kMostBytes || error) {
    why = path + " is too large";
    return std::nullopt;
  }
  return std::string{std::istreambuf_iterator<char>(in), {}};
}

FolderLock::~FolderLock() {
  if (directory_ >= 0) ::close(directory_);
}

std::string FolderLock::take(const std::string& folder) {
  if (directory_ >= 0 || folder.empty()) return {};
  const int directory = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory < 0) return {};
  if (::flock(directory, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) {
    directory_ = directory;
    return {};
  }
  ::close(directory);
  return "folder " + folder + " is in use by another plc-run";
}

}  // namespace plc::engineering
