#include "taskblocks/signals/csv_log.h"

#include <fcntl.h>
#include <pthread.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace plc::blocks {

namespace {

constexpr std::chrono::milliseconds kPause{20};
constexpr std::size_t kBatchBytes = 64 * 1024;
constexpr int kHighestNumber = 9999;

[[noreturn]] void refuse(const std::string& what) { throw std::runtime_error(what); }
[[noreturn]] void refuse(const std::string& what, int error) { refuse(what + ": " + std::strerror(error)); }

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

CsvLog::CsvLog(const Options& options)
    : columns_(options.columns.size()), limit_(options.limit), file_(options.file), ring_(options.lines) {
  open(options);
  start_thread();
}

CsvLog::~CsvLog() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
  }
  stop_.notify_one();
  thread_.join();
  ::fdatasync(fd_);
  ::close(fd_);
}

void CsvLog::open(const Options& options) {
  if (!is_file_name(options.file)) {
    refuse("FILE is not a name of letters, digits, '.', '_' and '-', without a folder and no '.' or '-' at the start");
  }
  const Descriptor directory{::open(options.directory.c_str(), O_DIRECTORY | O_RDONLY | O_CLOEXEC)};
  if (directory.fd < 0) refuse("the directory of logs '" + options.directory + "' cannot be opened", errno);

  std::string header = "utc,time_s";
  for (const std::string& column : options.columns) header += ',' + column;
  header += '\n';

  // WHY O_EXCL: a file that is made here is new. Nothing is overwritten, and no link leads elsewhere.
  constexpr int kNew = O_WRONLY | O_APPEND | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC;
  fd_ = ::openat(directory.fd, file_.c_str(), kNew, 0640);
  if (fd_ < 0 && errno == EEXIST && options.if_exists == IfExists::Append) {
    open_existing(directory.fd, header);
    return;
  }
  for (int i = 1; fd_ < 0 && errno == EEXIST && options.if_exists == IfExists::Number && i <= kHighestNumber; ++i) {
    file_ = numbered(options.file, i);
    fd_ = ::openat(directory.fd, file_.c_str(), kNew, 0640);
  }
  if (fd_ < 0) refuse("FILE '" + file_ + "' cannot be made in '" + options.directory + "'", errno);
  ::flock(fd_, LOCK_EX | LOCK_NB);
  if (const int error = write_all(fd_, header); error != 0) {
    ::close(fd_);
    refuse("FILE '" + file_ + "' cannot be written", error);
  }
  size_ = header.size();
}

void CsvLog::open_existing(int directory, const std::string& header) {
  // WHY O_NONBLOCK: opening a pipe would wait for a reader.
  Descriptor file{::openat(directory, file_.c_str(), O_RDWR | O_APPEND | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC)};
  struct stat about {};
  if (file.fd < 0 || ::fstat(file.fd, &about) != 0) refuse("FILE '" + file_ + "' cannot be opened", errno);
  if (!S_ISREG(about.st_mode)) refuse("FILE '" + file_ + "' is no regular file");
  if (::flock(file.fd, LOCK_EX | LOCK_NB) != 0) refuse("FILE '" + file_ + "' is being written by another logger");

  std::string there(header.size(), '\0');
  const ssize_t read = ::pread(file.fd, there.data(), there.size(), 0);
  if (about.st_size != 0 && (read < 0 || there != header)) refuse("FILE '" + file_ + "' has other columns");
  // A line that a loss of power left unfinished gets its end, so that it does not spoil the next one.
  char last = '\n';
  if (about.st_size != 0 && ::pread(file.fd, &last, 1, about.st_size - 1) != 1) last = '\n';
  const std::string_view first = about.st_size == 0 ? std::string_view(header) : last == '\n' ? "" : "\n";
  if (const int error = write_all(file.fd, first); error != 0) refuse("FILE '" + file_ + "' cannot be written", error);
  size_ = static_cast<std::uint64_t>(about.st_size) + first.size();
  fd_ = std::exchange(file.fd, -1);
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
    ::close(fd_);
    refuse("there is no thread left for the log");
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  pthread_setname_np(thread_.native_handle(), "file-logger");
}

// RT:
bool CsvLog::push(const Line& line) noexcept {
  const std::uint64_t at = pushed_.load(std::memory_order_relaxed);
  if (error_.load(std::memory_order_relaxed) != 0) return false;
  if (at - taken_.load(std::memory_order_acquire) >= ring_.size()) return false;
  if (at == 0) {
    using namespace std::chrono;
    first_ns_ = line.time_ns;
    first_utc_ns_ = duration_cast<nanoseconds>(system_clock::now().time_since_epoch()).count();
  }
  ring_[at % ring_.size()] = line;
  pushed_.store(at + 1, std::memory_order_release);
  return true;
}

void CsvLog::run() {
  std::unique_lock lock(mutex_);
  for (bool last = false; !last;) {
    last = stop_.wait_for(lock, kPause, [this] { return stopping_; });
    lock.unlock();
    drain();
    lock.lock();
  }
}

void CsvLog::drain() {
  std::string text;
  std::uint64_t lines = 0;
  const std::uint64_t end = pushed_.load(std::memory_order_acquire);
  for (std::uint64_t at = taken_.load(std::memory_order_relaxed); at != end; ++at) {
    append(text, ring_[at % ring_.size()]);
    ++lines;
    taken_.store(at + 1, std::memory_order_release);
    if (text.size() >= kBatchBytes || at + 1 == end) {
      write(text, lines);
      text.clear();
      lines = 0;
    }
  }
}

void CsvLog::write(std::string_view text, std::uint64_t lines) {
  if (error() == 0 && limit_ != 0 && size_ + text.size() > limit_) error_.store(EFBIG, std::memory_order_relaxed);
  if (error() == 0) {
    if (const int error = write_all(fd_, text); error != 0) {
      // A part may be there: the file shall end with a whole line. When that fails, too, the device is gone.
      [[maybe_unused]] const int cut = ::ftruncate(fd_, static_cast<off_t>(size_));
      error_.store(error, std::memory_order_relaxed);
    }
  }
  if (error() != 0) {
    lost_.fetch_add(lines, std::memory_order_relaxed);
  } else {
    size_ += text.size();
    written_.fetch_add(lines, std::memory_order_relaxed);
  }
}

void CsvLog::append(std::string& text, const Line& line) const {
  const std::int64_t passed = line.time_ns - first_ns_;  // the clock never runs back: not below 0
  append_utc(text, first_utc_ns_ + passed);
  char field[40];
  const int length = std::snprintf(field, sizeof field, ",%lld.%09lld", static_cast<long long>(passed / 1'000'000'000),
                                   static_cast<long long>(passed % 1'000'000'000));
  text.append(field, std::min(static_cast<std::size_t>(length), sizeof field - 1));
  for (std::size_t i = 0; i < columns_; ++i) {
    text += ',';
    text.append(field, std::to_chars(field, field + sizeof field, line.values[i]).ptr);
  }
  text += '\n';
}

}  // namespace plc::blocks
