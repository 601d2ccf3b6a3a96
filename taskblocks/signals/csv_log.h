// Lines of numbers go from a thread that must not wait to a CSV file, through a ring and a thread of its own. In:
// lines, a place for the file. Out: the file, counters. A file that cannot be made or written is tried again, and lines
// wait in the ring meanwhile. What is logged, and when, belongs to the block FILE_LOGGER.
//
//   push() ──► ring (one producer, one consumer) ──► writer thread, every 20 ms ──► open(2), write(2)
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace plc::blocks {

class CsvLog {
 public:
  static constexpr std::size_t kColumns = 8;

  enum class IfExists {
    Refuse,
    Number,  ///< log.csv, log-1.csv, log-2.csv ..: the first that is not there
    Append   ///< of the same names the first that is not there or has the same columns
  };
  /// The clock of the world, ns since 1970-01-01. RT.
  static std::int64_t utc_now_ns() noexcept;
  struct Options {
    std::string directory;
    std::string file;  ///< a name in it: letters, digits, '.', '_', '-'; does not begin with '.'
    IfExists if_exists = IfExists::Number;
    std::vector<std::string> columns;                         ///< 1 to kColumns names, without the two of the time
    std::size_t lines = 4096;                                 ///< that wait at most
    std::uint64_t limit = 0;                                  ///< bytes the file may have, 0 = any
    std::chrono::milliseconds retry{1000};                    ///< between attempts at a file that fails
    std::int64_t (*utc_ns)() noexcept = &CsvLog::utc_now_ns;  ///< may be set at any time: `utc` of later lines follows
  };
  struct Line {
    std::int64_t time_ns = 0;  ///< starts anywhere; the file counts from the first line
    std::array<double, kColumns> values{};
  };

  /// The names in "speed, current": letters, digits, '_', '.', '[' and ']', blanks around them removed. Throws
  /// std::runtime_error with a sentence when there are none, too many, or others.
  static std::vector<std::string> columns_of(std::string_view text);

  /// Starts the thread, which opens the file: error() tells how that went. Throws std::runtime_error with a sentence
  /// when `file` is no name of a file, or no thread is left.
  explicit CsvLog(const Options& options);
  /// Writes what waits, down to the disk, and closes the file. What cannot be written now is lost.
  ~CsvLog();
  CsvLog(const CsvLog&) = delete;
  CsvLog& operator=(const CsvLog&) = delete;

  /// RT, one thread: false when the line does not fit in or the file is full (EFBIG); it is lost then.
  bool push(const Line& line) noexcept;

  /// RT: lines in the file.
  [[nodiscard]] std::uint64_t written() const noexcept { return written_.load(std::memory_order_relaxed); }
  /// RT: lines that push() took and that could not be written.
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_.load(std::memory_order_relaxed); }
  /// RT: why nothing is written at present, a number of errno(3), or 0. EFBIG is for good: the limit is reached.
  [[nodiscard]] int error() const noexcept { return error_.load(std::memory_order_relaxed); }

 private:
  using Clock = std::chrono::steady_clock;

  void start_thread();
  void run();
  void drain(bool last);
  [[nodiscard]] int open();
  [[nodiscard]] int go_on_in(int directory, const std::string& name);
  [[nodiscard]] int write_lines(std::uint64_t end);
  void fail(int error);
  void follow_clock();
  void append(std::string& text, const Line& line) const;

  const Options options_;
  std::string header_;
  std::uint64_t size_ = 0;  ///< of the file, whole lines; 0 = the header is still to be written
  Clock::time_point next_try_{};

  std::vector<Line> ring_;            ///< line n lies at n modulo its size
  std::int64_t first_ns_ = 0;         ///< task's clock of the first line; written before that is pushed
  std::int64_t first_utc_ns_ = 0;     ///< and the clock of the world, since 1970-01-01
  std::int64_t clocks_apart_ns_ = 0;  ///< that clock less the monotonic one, at the first line
  std::int64_t stepped_ns_ = 0;       ///< by how much it was set since
  alignas(64) std::atomic<std::uint64_t> pushed_{0};
  alignas(64) std::atomic<std::uint64_t> taken_{0};
  std::atomic<std::uint64_t> written_{0};
  std::atomic<std::uint64_t> lost_{0};
  std::atomic<int> error_{0};
  int fd_ = -1;

  std::mutex mutex_;  ///< of stopping_; push() needs none
  std::condition_variable stop_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace plc::blocks
