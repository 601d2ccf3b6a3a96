#include "shadow/record_thread.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <system_error>
#include <utility>

namespace plc::shadow {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kPeriod{100};
constexpr std::string_view kBegin = "plant-", kEnd = ".rec";

struct OldFile {
  fs::path path;
  std::uint64_t bytes = 0;
};
/// Recordings of the folder, the oldest first: their names have their times.
std::vector<OldFile> files_of(const std::string& folder) {
  std::vector<OldFile> files;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    std::error_code ignored;
    if (!name.starts_with(kBegin) || !name.ends_with(kEnd) || !at->is_regular_file(ignored)) continue;
    const std::uintmax_t bytes = at->file_size(ignored);
    if (!ignored) files.push_back({at->path(), bytes});
  }
  std::sort(files.begin(), files.end(), [](const OldFile& a, const OldFile& b) { return a.path < b.path; });
  return files;
}

}  // namespace

core::Result<std::unique_ptr<RecordThread>> RecordThread::start(runtime::Resource& resource, RecordFolder folder,
                                                                RecordingHead head) {
  std::unique_ptr<RecordThread> made(new RecordThread(std::move(folder), std::move(head)));
  std::error_code error;
  fs::create_directories(made->folder_.path, error);
  if (auto problem = made->next_file()) return *problem;
  RecordThread* const self = made.get();
  auto recording = Recording::start(resource, [self](std::span<const std::byte> block) { return self->write(block); });
  if (!recording) return recording.error();
  made->recording_ = std::move(*recording);
  made->tasks_ = static_cast<std::uint32_t>(resource.task_count());
  made->thread_ = std::thread([self] { self->run(); });
  return made;
}

RecordThread::~RecordThread() { stop(false); }

std::optional<core::Problem> RecordThread::next_file() {
  // All names are of one length, so that they are in the order of their times.
  auto now = std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
  std::string path;
  std::error_code error;
  do {
    const auto ms = now.time_since_epoch().count();
    path = fmt::format("{}/{}{:%Y%m%dT%H%M%S}.{:03}Z{}", folder_.path, kBegin, fmt::gmtime(ms / 1000), ms % 1000, kEnd);
    now += std::chrono::milliseconds(1);
  } while (fs::exists(path, error));
  auto writer = RecordWriter::open(path, head_);
  if (!writer) return writer.error();
  writer_ = std::move(*writer);
  const std::lock_guard lock(mutex_);
  file_ = path;
  return {};
}

void RecordThread::remove_oldest() {
  const std::vector<OldFile> files = files_of(folder_.path);
  std::uint64_t bytes = 0;
  for (const OldFile& file : files) bytes += file.bytes;
  for (const OldFile& file : files) {
    std::error_code error;
    if (bytes <= folder_.most_bytes || file.path == file_) return;
    if (fs::remove(file.path, error)) bytes -= file.bytes;
  }
}

bool RecordThread::write(std::span<const std::byte> block) {
  if (writer_->bytes() > folder_.file_bytes) {
    // Where there is no next file, the present one goes on.
    static_cast<void>(next_file());
    remove_oldest();
  }
  const bool written = writer_->write(block);
  if (written && in_trouble_) say("the recording is written again");
  if (!written && !in_trouble_)
    say(writer_->problem()->message + "; scans are left out of the recording until there is room");
  in_trouble_ = !written;
  return written;
}

void RecordThread::say(std::string text) {
  const std::lock_guard lock(mutex_);
  messages_.push_back(std::move(text));
}

std::vector<std::string> RecordThread::messages() {
  const std::lock_guard lock(mutex_);
  return std::exchange(messages_, {});
}

RecordingCounts RecordThread::counts() const {
  RecordingCounts sum;
  for (std::uint32_t task = 0; task < tasks_; ++task) {
    const RecordingCounts one = recording_->counts(task);
    sum.scans += one.scans;
    sum.lost += one.lost;
    sum.record_bytes += one.record_bytes;
    sum.stored_bytes += one.stored_bytes;
    sum.gaps += one.gaps;
  }
  return sum;
}

std::string RecordThread::file() const {
  const std::lock_guard lock(mutex_);
  return file_;
}

void RecordThread::run() {
  while (!ends_.load(std::memory_order_acquire)) {
    recording_->drain();
    std::this_thread::sleep_for(kPeriod);
  }
}

void RecordThread::stop(bool whole) {
  if (!thread_.joinable()) return;
  ends_.store(true, std::memory_order_release);
  thread_.join();
  if (whole) recording_->finish();
}

}  // namespace plc::shadow
