#include "taskblocks/signals/csv_log.h"

#include <fcntl.h>
#include <pthread.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace plc::blocks {

namespace {

constexpr std::chrono::milliseconds kPause{20};
constexpr std::size_t kBatchBytes = 64 * 1024;
constexpr int kHighestNumber = 9999;
/// Of CsvLog::go_on_in(): the file is another's, and stays as it is.
constexpr int kNotOurs = -1;
/// The clock of the world was set when it moved by more than this against the other one.
constexpr std::int64_t kStepNs = 1'000'000;

[[noreturn]] void refuse(const std::string& what) { throw std::runtime_error(what); }

bool is_alphanumeric(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'); }

bool is_file_name(std::string_view name) {
  return !name.empty() && name.front() != '.' && name.front() != '-' &&
         std::all_of(name.begin(), name.end(),
                     [](char c) { return is_alphanumeric(c) || c == '.' || c == '_' || c == '-'; });
}

bool is_column_name(std::string_view name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return is_alphanumeric(c) || c == '_' || c == '.' || c == '[' || c == ']';
  });
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

/// "log.csv" and 3: "log-3.csv".
std::string numbered(const std::string& file, int number) {
  const std::size_t dot = file.rfind('.');
  const std::string stem = file.substr(0, dot);
  return stem + '-' + std::to_string(number) + (dot == std::string::npos ? "" : file.substr(dot));
}

/// A descriptor that is closed with the block.
struct Descriptor {
  int fd;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

/// 0 and all of `text` is in the file, or a number of errno.
int write_all(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t done = ::write(fd, text.data(), text.size());
    if (done < 0 && errno != EINTR) return errno;
    if (done > 0) text.remove_prefix(static_cast<std::size_t>(done));
  }
  return 0;
}

/// Where the data of a file end. A loss of power leaves bytes of 0 where data had not reached the disk.
std::uint64_t end_of_data(int fd, std::uint64_t size) {
  std::array<char, 4096> part;
  while (size != 0) {
    const std::size_t bytes = std::min<std::uint64_t>(size, part.size());
    if (::pread(fd, part.data(), bytes, static_cast<off_t>(size - bytes)) != static_cast<ssize_t>(bytes)) return size;
    std::size_t left = bytes;
    while (left != 0 && part[left - 1] == '\0') --left;
    if (left != 0) return size - bytes + left;
    size -= bytes;
  }
  return 0;
}

std::int64_t monotonic_ns() noexcept {
  using namespace std::chrono;
  return duration_cast<nanoseconds>(steady_clock::now().time_since_epoch()).count();
}

void append_utc(std::string& text, std::int64_t ns) {
  using namespace std::chrono;
  const sys_time<microseconds> at{floor<microseconds>(nanoseconds(ns))};
  const auto day = floor<days>(at);
  const year_month_day date(day);
  const hh_mm_ss time(at - day);
  char field[40];
  const int length = std::snprintf(field, sizeof field, "%04d-%02u-%02uT%02d:%02d:%02d.%06dZ", int{date.year()},
                                   unsigned{date.month()}, unsigned{date.day()}, static_cast<int>(time.hours().count()),
                                   static_cast<int>(time.minutes().count()), static_cast<int>(time.seconds().count()),
                                   static_cast<int>(time.subseconds().count()));
  text.append(field, std::min(static_cast<std::size_t>(length), sizeof field - 1));
}

}  // namespace

std::vector<std::string> CsvLog::columns_of(std::string_view text) {
  std::vector<std::string> columns;
  for (bool more = true; more;) {
    const std::size_t comma = text.find(',');
    const std::string_view name = trimmed(text.substr(0, comma));
    if (!is_column_name(name)) refuse("COLUMNS has a name that is not of letters, digits, '_', '.', '[' and ']'");
    columns.emplace_back(name);
    more = comma != std::string_view::npos;
    if (more) text.remove_prefix(comma + 1);
  }
  if (columns.size() > kColumns) refuse("COLUMNS has more than 8 names");
  return columns;
}

std::int64_t CsvLog::utc_now_ns() noexcept {
  using namespace std::chrono;
  return duration_cast<nanoseconds>(system_clock::now().time_since_epoch()).count();
}

CsvLog::CsvLog(const Options& options) : options_(options), header_("utc,time_s"), ring_(options.lines) {
  if (!is_file_name(options.file)) {
    refuse("FILE is not a name of letters, digits, '.', '_' and '-', without a folder and no '.' or '-' at the start");
  }
  for (const std::string& column : options.columns) header_ += ',' + column;
  header_ += '\n';
  start_thread();
}

CsvLog::~CsvLog() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
  }
  stop_.notify_one();
  thread_.join();
  if (fd_ < 0) return;
  ::fdatasync(fd_);
  ::close(fd_);
}

/// 0 and fd_ is the file, or a number of errno.
int CsvLog::open() {
  const Descriptor directory{::open(options_.directory.c_str(), O_DIRECTORY | O_RDONLY | O_CLOEXEC)};
  if (directory.fd < 0) return errno;
  for (int i = 0; i <= kHighestNumber; ++i) {
    const std::string file = i == 0 ? options_.file : numbered(options_.file, i);
    // WHY O_EXCL: a file that is made here is new. Nothing is overwritten, and no link leads elsewhere.
    constexpr int kNew = O_WRONLY | O_APPEND | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC;
    fd_ = ::openat(directory.fd, file.c_str(), kNew, 0640);
    if (fd_ >= 0) {
      ::flock(fd_, LOCK_EX | LOCK_NB);
      size_ = 0;
      return 0;
    }
    if (errno != EEXIST || options_.if_exists == IfExists::Refuse) return errno;
    if (options_.if_exists == IfExists::Number) continue;
    if (const int error = go_on_in(directory.fd, file); error != kNotOurs) return error;
  }
  return EEXIST;
}

/// 0 and fd_ is the file, kNotOurs, or a number of errno.
int CsvLog::go_on_in(int directory, const std::string& name) {
  // WHY O_NONBLOCK: opening a pipe would wait for a reader.
  Descriptor file{::openat(directory, name.c_str(), O_RDWR | O_APPEND | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC)};
  if (file.fd < 0) return errno == ELOOP || errno == EISDIR || errno == ENXIO ? kNotOurs : errno;
  struct stat about {};
  if (::fstat(file.fd, &about) != 0) return errno;
  if (!S_ISREG(about.st_mode)) return kNotOurs;
  if (::flock(file.fd, LOCK_EX | LOCK_NB) != 0) return errno;

  const auto there = static_cast<std::uint64_t>(about.st_size);
  const std::uint64_t end = end_of_data(file.fd, there);
  std::string begin(std::min<std::uint64_t>(end, header_.size()), '\0');
  if (::pread(file.fd, begin.data(), begin.size(), 0) != static_cast<ssize_t>(begin.size())) return EIO;
  if (header_.compare(0, begin.size(), begin) != 0) return kNotOurs;
  // Less than a header is no data: it is written anew.
  const std::uint64_t keep = begin.size() < header_.size() ? 0 : end;
  if (keep != there && ::ftruncate(file.fd, static_cast<off_t>(keep)) != 0) return errno;
  size_ = keep;
  // A line that a loss of power left unfinished gets its end, so that it does not spoil the next one.
  char last = '\n';
  if (keep != 0 && ::pread(file.fd, &last, 1, static_cast<off_t>(keep - 1)) == 1 && last != '\n') {
    if (const int error = write_all(file.fd, "\n"); error != 0) return error;
    ++size_;
  }
  fd_ = std::exchange(file.fd, -1);
  return 0;
}

void CsvLog::start_thread() {
  // WHY no signals: they are for the main thread; and a file larger than the process may have is then an error of
  // write(2) instead of the end of the process (SIGXFSZ).
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  try {
    thread_ = std::thread([this] { run(); });
  } catch (const std::system_error&) {
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    refuse("there is no thread left for the log");
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  pthread_setname_np(thread_.native_handle(), "file-logger");
}

// RT:
bool CsvLog::push(const Line& line) noexcept {
  const std::uint64_t at = pushed_.load(std::memory_order_relaxed);
  if (error() == EFBIG) return false;
  if (at - taken_.load(std::memory_order_acquire) >= ring_.size()) return false;
  if (at == 0) {
    first_ns_ = line.time_ns;
    first_utc_ns_ = options_.utc_ns();
    clocks_apart_ns_ = first_utc_ns_ - monotonic_ns();
  }
  ring_[at % ring_.size()] = line;
  pushed_.store(at + 1, std::memory_order_release);
  return true;
}

void CsvLog::run() {
  std::unique_lock lock(mutex_);
  for (bool last = false; !last;) {
    lock.unlock();
    drain(false);
    lock.lock();
    last = stop_.wait_for(lock, kPause, [this] { return stopping_; });
  }
  drain(true);
}

/// Writes what waits. What cannot be written goes on waiting, but for the last time.
void CsvLog::drain(bool last) {
  const std::uint64_t end = pushed_.load(std::memory_order_acquire);
  if (error() != EFBIG && (last || error() == 0 || Clock::now() >= next_try_)) {
    const int error = fd_ >= 0 ? 0 : open();
    fail(error != 0 ? error : write_lines(end));
  }
  if (!last && error() != EFBIG) return;
  lost_.fetch_add(end - taken_.load(std::memory_order_relaxed), std::memory_order_relaxed);
  taken_.store(end, std::memory_order_release);
}

void CsvLog::fail(int error) {
  if (error != 0) next_try_ = Clock::now() + options_.retry;
  error_.store(error, std::memory_order_relaxed);
}

/// 0, or a number of errno, and the file ends with a whole line.
int CsvLog::write_lines(std::uint64_t end) {
  std::uint64_t begin = taken_.load(std::memory_order_relaxed);
  if (begin != end) follow_clock();
  std::string text = size_ == 0 ? header_ : std::string();
  for (std::uint64_t at = begin; at != end || !text.empty();) {
    while (at != end && text.size() < kBatchBytes) append(text, ring_[at++ % ring_.size()]);
    if (options_.limit != 0 && size_ + text.size() > options_.limit) return EFBIG;
    if (const int error = write_all(fd_, text); error != 0) {
      // A part may be there. When it cannot be cut off either, the device is gone.
      [[maybe_unused]] const int cut = ::ftruncate(fd_, static_cast<off_t>(size_));
      return error;
    }
    size_ += text.size();
    written_.fetch_add(at - begin, std::memory_order_relaxed);
    taken_.store(at, std::memory_order_release);
    begin = at;
    text.clear();
  }
  return 0;
}

/// NTP sets the clock of a machine without a battery long after its start.
void CsvLog::follow_clock() {
  const std::int64_t before = monotonic_ns();
  const std::int64_t utc = options_.utc_ns();
  const std::int64_t after = monotonic_ns();
  if (after - before > kStepNs) return;  // interrupted between the two: not to be told from a step
  const std::int64_t stepped = utc - before - clocks_apart_ns_;
  if (std::abs(stepped - stepped_ns_) > kStepNs) stepped_ns_ = stepped;
}

void CsvLog::append(std::string& text, const Line& line) const {
  const std::int64_t passed = line.time_ns - first_ns_;  // the clock never runs back: not below 0
  append_utc(text, first_utc_ns_ + stepped_ns_ + passed);
  char field[40];
  const int length = std::snprintf(field, sizeof field, ",%lld.%09lld", static_cast<long long>(passed / 1'000'000'000),
                                   static_cast<long long>(passed % 1'000'000'000));
  text.append(field, std::min(static_cast<std::size_t>(length), sizeof field - 1));
  for (std::size_t i = 0; i < options_.columns.size(); ++i) {
    text += ',';
    text.append(field, std::to_chars(field, field + sizeof field, line.values[i]).ptr);
  }
  text += '\n';
}

}  // namespace plc::blocks
