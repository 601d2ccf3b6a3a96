#include "shadow/record_folder.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace plc::shadow {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPlant = "plant-", kEnd = ".rec";

struct OldFile {
  fs::path path;
  std::uint64_t bytes = 0;
};
/// Recordings of the folder whose names begin so, the oldest first: their names have their times.
std::vector<OldFile> files_of(const std::string& folder, std::string_view begin) {
  std::vector<OldFile> files;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    std::error_code ignored;
    if (!name.starts_with(begin) || !name.ends_with(kEnd) || !at->is_regular_file(ignored)) continue;
    const std::uintmax_t bytes = at->file_size(ignored);
    if (!ignored) files.push_back({at->path(), bytes});
  }
  std::sort(files.begin(), files.end(), [](const OldFile& a, const OldFile& b) { return a.path < b.path; });
  return files;
}

/// A name that no file has. All are of one length, so that they are in the order of their times.
std::string new_path(const std::string& folder, std::string_view begin) {
  auto now = std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
  for (;;) {
    const auto ms = now.time_since_epoch().count();
    std::string path =
        fmt::format("{}/{}{:%Y%m%dT%H%M%S}.{:03}Z{}", folder, begin, fmt::gmtime(ms / 1000), ms % 1000, kEnd);
    std::error_code error;
    if (!fs::exists(path, error)) return path;
    now += std::chrono::milliseconds(1);
  }
}

}  // namespace

core::Result<std::unique_ptr<RecordFolder>> RecordFolder::open(RecordFolderOptions options, RecordingHead head) {
  std::unique_ptr<RecordFolder> made(new RecordFolder(std::move(options), std::move(head)));
  std::error_code error;
  fs::create_directories(made->options_.path, error);
  if (auto problem = made->next_file()) return *problem;
  return made;
}

std::optional<core::Problem> RecordFolder::next_file() {
  const std::string path = new_path(options_.path, kPlant);
  auto writer = RecordWriter::open(path, file_head(head_));
  if (writer) {
    writer_ = std::move(*writer);
    const std::lock_guard lock(mutex_);
    file_ = path;
  }
  prune();
  if (!writer) return writer.error();
  return {};
}

void RecordFolder::prune() {
  const std::vector<OldFile> files = files_of(options_.path, kPlant);
  std::uint64_t bytes = 0;
  for (const OldFile& file : files) bytes += file.bytes;
  for (const OldFile& file : files) {
    std::error_code error;
    if (bytes <= options_.most_bytes) return;
    // It need not be the last one: a clock that was ahead has left names of later times.
    if (file.path == file_) continue;
    if (fs::remove(file.path, error)) bytes -= file.bytes;
  }
}

bool RecordFolder::write(std::span<const std::byte> block) {
  // Where there is no next file, the present one goes on.
  if (writer_->bytes() > options_.file_bytes) static_cast<void>(next_file());
  return writer_->write(block);
}

std::string RecordFolder::file() const {
  const std::lock_guard lock(mutex_);
  return file_;
}

core::Result<std::string> save_recording(const std::string& folder, std::string_view led_to,
                                         std::span<const std::byte> recording, std::size_t most_files) {
  std::error_code error;
  fs::create_directories(folder, error);
  const std::string begin = std::string(led_to) + "-";
  const std::string path = new_path(folder, begin);
  auto writer = RecordWriter::open(path, recording);
  if (!writer) return writer.error();
  std::vector<OldFile> others = files_of(folder, begin);
  // The new one stays, also where a clock that was ahead has left names of later times.
  std::erase_if(others, [&](const OldFile& file) { return file.path == path; });
  for (std::size_t i = 0; i + most_files < others.size() + 1 && i < others.size(); ++i)
    fs::remove(others[i].path, error);
  return path;
}

}  // namespace plc::shadow
