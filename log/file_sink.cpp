#include "log/file_sink.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

namespace plc::log {

/// What the thread works on. Lines and flags are shared; the file is the thread's alone, or the owner's while there is
/// no thread.
class FileSink::Writer {
 public:
  explicit Writer(FileOptions options) : options_(std::move(options)) {}
  ~Writer() { close(); }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  void add(const Record& record) {
    std::string line = options_.line(record);
    const std::lock_guard lock(mutex_);
    if (bytes_ + line.size() > kMostWaiting) {
      ++lost_;
      return;
    }
    bytes_ += line.size();
    lines_.push_back({std::move(line), record});
    changed_.notify_all();
  }

  void run() {
    std::unique_lock lock(mutex_);
    while (!ending_) {
      // Also without lines: somebody may have taken the file away, and a disk may have space again.
      changed_.wait_for(lock, std::chrono::nanoseconds(options_.retry_ns), [this] { return ending_ || has_work(); });
      lock.unlock();
      work();
      lock.lock();
    }
    lock.unlock();
    work();
    lock.lock();
    ended_ = true;
    changed_.notify_all();
  }

  /// True when the thread has ended.
  bool end(core::TimeNs patience_ns) {
    std::unique_lock lock(mutex_);
    ending_ = true;
    changed_.notify_all();
    return changed_.wait_for(lock, std::chrono::nanoseconds(patience_ns), [this] { return ended_; });
  }

  /// Writes what waits, as far as it goes.
  void work() {
    if (!is_there()) close();
    for (;;) {
      std::string line;
      {
        const std::lock_guard lock(mutex_);
        if (lines_.empty()) break;
        line = lines_.front().bytes;
      }
      if (!open()) break;
      if (size_ != 0 && size_ + line.size() > options_.size) rotate();
      if (!open() || !put(line)) break;
      const std::lock_guard lock(mutex_);
      lines_.pop_front();
      bytes_ -= line.size();
    }
    say_lost();
  }

  [[nodiscard]] std::string problem() const {
    const std::lock_guard lock(mutex_);
    return problem_;
  }

  std::vector<Record> take_unshown(core::Severity least) {
    const std::lock_guard lock(mutex_);
    return take_unshown_of(lines_, least);
  }

  [[nodiscard]] std::uint64_t lost() const {
    const std::lock_guard lock(mutex_);
    return lost_;
  }

 private:
  /// While the lock is held.
  [[nodiscard]] bool has_work() const { return !lines_.empty() && problem_.empty(); }

  void close() {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }

  /// Whether the open file is still the one of that name.
  [[nodiscard]] bool is_there() const {
    struct stat open {
    }, named{};
    return fd_ >= 0 && ::fstat(fd_, &open) == 0 && ::stat(options_.path.c_str(), &named) == 0 &&
           open.st_dev == named.st_dev && open.st_ino == named.st_ino;
  }

  bool fail(const char* why) {
    close();
    const std::lock_guard lock(mutex_);
    problem_ = why;
    return false;
  }

  void succeed() {
    const std::lock_guard lock(mutex_);
    problem_.clear();
  }

  bool open() {
    if (fd_ >= 0) return true;
    fd_ = ::open(options_.path.c_str(), O_RDWR | O_APPEND | O_CREAT | O_CLOEXEC | O_NOCTTY | O_NONBLOCK, 0640);
    struct stat status {};
    if (fd_ < 0 || ::fstat(fd_, &status) != 0) return fail(std::strerror(errno));
    // Two that rename one file would lose each other's lines.
    if (S_ISREG(status.st_mode) && ::flock(fd_, LOCK_EX | LOCK_NB) != 0) return fail("another process writes it");
    size_ = S_ISREG(status.st_mode) ? static_cast<std::uint64_t>(status.st_size) : 0;
    regular_ = S_ISREG(status.st_mode);
    // What a loss of power or a full disk left of a line is ended.
    char last = '\n';
    torn_ = size_ != 0 && ::pread(fd_, &last, 1, status.st_size - 1) == 1 && last != '\n';
    return true;
  }

  bool put(const std::string& line) {
    const std::string whole = (torn_ ? "\n" : "") + line;
    for (std::size_t done = 0; done < whole.size();) {
      const ssize_t written = ::write(fd_, whole.data() + done, whole.size() - done);
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) {
        // The part that was written is taken back, so that the line comes once; where that fails it is ended later.
        const int why = written == 0 ? ENOSPC : errno;
        if (done != 0 && !(regular_ && ::ftruncate(fd_, static_cast<off_t>(size_)) == 0)) torn_ = true;
        return fail(std::strerror(why));
      }
      done += static_cast<std::size_t>(written);
    }
    torn_ = false;
    size_ += whole.size();
    succeed();
    return true;
  }

  [[nodiscard]] std::string name(std::uint32_t number) const {
    return number == 0 ? options_.path : fmt::format("{}.{}", options_.path, number);
  }

  /// A file that cannot be renamed grows on.
  void rotate() {
    if (!regular_) return;
    if (options_.keep == 0) {
      if (::ftruncate(fd_, 0) == 0) size_ = 0;
      return;
    }
    for (std::uint32_t number = options_.keep; number-- > 0;) {
      if (::rename(name(number).c_str(), name(number + 1).c_str()) != 0 && number == 0) return;
    }
    close();
    open();
  }

  void say_lost() {
    std::uint64_t lost = 0;
    {
      const std::lock_guard lock(mutex_);
      if (lost_ == 0 || !problem_.empty() || !lines_.empty()) return;
      lost = std::exchange(lost_, 0);
    }
    Record record;
    record.severity = core::Severity::kWarning;
    record.text = fmt::format("{} messages are lost: {} could not be written in time", lost, options_.path);
    record.utc_ns = core::SystemCalendar().utc_ns();
    if (fd_ >= 0 && put(options_.line(record))) return;
    const std::lock_guard lock(mutex_);
    lost_ += lost;
  }

  const FileOptions options_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Waiting> lines_;
  std::size_t bytes_ = 0;
  std::uint64_t lost_ = 0;
  std::string problem_;  ///< of the last attempt: the next one is in a second
  bool ending_ = false, ended_ = false;
  // the file
  int fd_ = -1;
  std::uint64_t size_ = 0;
  bool regular_ = true;
  bool torn_ = false;  ///< its last line has no end
};

FileSink::FileSink(FileOptions options) : writer_(std::make_shared<Writer>(std::move(options))) {}

FileSink::~FileSink() {
  if (started_) stop(0);
}

void FileSink::start() {
  if (started_) return;
  started_ = true;
  std::thread([writer = writer_] { writer->run(); }).detach();
}

void FileSink::write(const Record& record) { writer_->add(record); }

void FileSink::stop(core::TimeNs patience_ns) {
  if (started_) {
    writer_->end(patience_ns);
  } else {
    writer_->work();
  }
}

std::string FileSink::problem() const { return writer_->problem(); }

std::vector<Record> FileSink::take_unshown(core::Severity least) { return writer_->take_unshown(least); }

std::uint64_t FileSink::lost() const { return writer_->lost(); }

}  // namespace plc::log
