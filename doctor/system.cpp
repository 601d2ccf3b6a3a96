#include "doctor/system.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/sysmacros.h>
#include <sys/timex.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <climits>
#include <ctime>
#include <filesystem>
#include <utility>

#include "core/text.h"

namespace plc::doctor {
namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 20;

Clocks kernel_clocks() {
  Clocks clocks;
  timex state{};
  clocks.synchronised = ::adjtimex(&state) != TIME_ERROR && (state.status & STA_UNSYNC) == 0;
  timespec time{};
  if (::clock_gettime(CLOCK_REALTIME, &time) == 0) clocks.time_of_day_s = time.tv_sec;
  if (::clock_getres(CLOCK_MONOTONIC, &time) == 0) clocks.resolution_ns = time.tv_sec * 1'000'000'000 + time.tv_nsec;
  return clocks;
}

std::optional<Space> space_at(const std::string& path) {
  struct statvfs found {};
  if (::statvfs(path.c_str(), &found) != 0) return std::nullopt;
  Space space;
  space.free_bytes = std::uint64_t{found.f_bavail} * found.f_frsize;
  space.free_files = found.f_files == 0 ? UINT64_MAX : found.f_favail;
  space.read_only = (found.f_flag & ST_RDONLY) != 0;
  return space;
}

}  // namespace

System System::here() { return System("", {.clocks = kernel_clocks, .space = space_at, .devices = true}); }

System::System(std::string root, Calls calls) : root_(std::move(root)), calls_(std::move(calls)) {
  while (!root_.empty() && root_.back() == '/') root_.pop_back();
}

std::string System::resolved(const std::string& path, bool last) const {
  if (!path.starts_with('/') || root_.empty()) return path;
  namespace fs = std::filesystem;
  constexpr int kMostLinks = 40;  // as the kernel has it
  fs::path inside;                // without links, from the root
  std::vector<fs::path> rest;     // the next one is the last
  const auto add = [&rest](const fs::path& names) {
    const auto at = static_cast<std::ptrdiff_t>(rest.size());
    for (const fs::path& name : names.relative_path()) rest.push_back(name);
    std::reverse(rest.begin() + at, rest.end());
  };
  add(path);
  for (int links = 0; !rest.empty();) {
    const fs::path name = rest.back();
    rest.pop_back();
    if (name.empty() || name == ".") continue;
    if (name == "..") {
      inside = inside.parent_path();  // that of the root is the root
      continue;
    }
    std::error_code none;
    const fs::path to = last || !rest.empty() ? fs::read_symlink(root_ / inside / name, none) : fs::path();
    if (to.empty()) {
      inside /= name;
      continue;
    }
    if (++links > kMostLinks) return {};
    if (to.is_absolute()) inside.clear();
    add(to);
  }
  return root_ + "/" + inside.string();
}

std::string System::named(const io::Configuration& configuration, const std::string& name) const {
  if (name.empty() || name.starts_with('/')) return name;
  std::string path = configuration.beside(name);
  if (root_.empty() || !path.starts_with('/')) return path;
  return std::filesystem::path(path).lexically_relative(std::filesystem::current_path()).string();
}

std::optional<std::string> System::read(const std::string& path) const {
  const int file = ::open(real(path).c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  if (file < 0) return std::nullopt;
  std::string text;
  char part[16384];
  ssize_t count = 0;
  while (text.size() < kMostBytes && (count = ::read(file, part, sizeof part)) > 0) {
    text.append(part, static_cast<std::size_t>(count));
  }
  ::close(file);
  if (count < 0) return std::nullopt;
  return text;
}

std::optional<std::string> System::line(const std::string& path) const {
  const auto text = read(path);
  if (!text) return std::nullopt;
  return std::string(core::trimmed(*text));
}

std::optional<std::int64_t> System::number(const std::string& path) const {
  const auto text = line(path);
  if (!text) return std::nullopt;
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value);
  if (error != std::errc{} || end != text->data() + text->size()) return std::nullopt;
  return value;
}

std::vector<std::string> System::list(const std::string& folder) const {
  std::vector<std::string> names;
  DIR* const open = ::opendir(real(folder).c_str());
  if (open == nullptr) return names;
  while (const dirent* const entry = ::readdir(open)) {
    const std::string name = entry->d_name;
    if (name != "." && name != "..") names.push_back(name);
  }
  ::closedir(open);
  std::sort(names.begin(), names.end());
  return names;
}

std::optional<FileFacts> System::facts(const std::string& path) const {
  struct stat found {};
  if (::stat(real(path).c_str(), &found) != 0) return std::nullopt;
  return FileFacts{found.st_mode, found.st_uid, found.st_gid, found.st_ino, major(found.st_dev), minor(found.st_dev)};
}

std::string System::link(const std::string& path) const {
  char to[PATH_MAX];
  const ssize_t count = ::readlink(resolved(path, false).c_str(), to, sizeof to);
  return count > 0 ? std::string(to, static_cast<std::size_t>(count)) : std::string{};
}

std::optional<Space> System::space(const std::string& path) const {
  return calls_.space ? calls_.space(real(path)) : std::nullopt;
}

}  // namespace plc::doctor
