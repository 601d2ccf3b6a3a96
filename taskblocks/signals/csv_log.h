// Lines of numbers go from a thread that must not wait to a CSV file, through a ring and a thread of its own. In:
// lines, a place for the file. Out: the file, counters. What is logged, and when, belongs to the block FILE_LOGGER.
//
//   push() ──► ring (one producer, one consumer) ──► writer thread, every 20 ms ──► write(2)
#pragma once

#include <array>
#include <atomic>
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
    Append   ///< if it has the same columns
  };
  struct Options {
    std::string directory;  ///< exists
    std::string file;       ///< a name in it: letters, digits, '.', '_', '-'; does not begin with '.'
    IfExists if_exists = IfExists::Number;
    std::vector<std::string> columns;  ///< 1 to kColumns names, without the two of the time
    std::size_t lines = 4096;          ///< that wait at most
    std::uint64_t limit = 0;           ///< bytes the file may have, 0 = any
  };
  struct Line {
    std::int64_t time_ns = 0;  ///< starts anywhere; the file counts from the first line
    std::array<double, kColumns> values{};
  };

  /// The names in "speed, current": letters, digits, '_', '.', '[' and ']', blanks around them removed. Throws
  /// std::runtime_error with a sentence when there are none, too many, or others.
  static std::vector<std::string> columns_of(std::string_view text);

  /// Opens the file and starts the thread. Throws std::runtime_error with a sentence that says what is wrong.
  explicit CsvLog(const Options& options);
  /// Writes what waits, down to the disk, and closes the file.
  ~CsvLog();
  CsvLog(const CsvLog&) = delete;
  CsvLog& operator=(const CsvLog&) = delete;

  /// RT, one thread: false when the line does not fit in or the file has failed; it is lost then.
  bool push(const Line& line) noexcept;

  /// RT: lines in the file.
  [[nodiscard]] std::uint64_t written() const noexcept { return written_.load(std::memory_order_relaxed); }
  /// RT: lines that push() took and that could not be written.
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_.load(std::memory_order_relaxed); }
  /// RT: why nothing more is written, a number of errno(3) (EFBIG: the limit is reached), or 0.
  [[nodiscard]] int error() const noexcept { return error_.load(std::memory_order_relaxed); }
  /// The name that IfExists::Number found.
  [[nodiscard]] const std::string& file() const noexcept { return file_; }

 private:
  void open(const Options& options);
  void open_existing(int directory, const std::string& header);
  void start_thread();
  void run();
  void drain();
  void write(std::string_view text, std::uint64_t lines);
  void append(std::string& text, const Line& line) const;

  std::size_t columns_;
  std::uint64_t limit_;
  std::string file_;
  int fd_ = -1;
  std::uint64_t size_ = 0;  ///< of the file, whole lines

  std::vector<Line> ring_;         ///< line n lies at n modulo its size
  std::int64_t first_ns_ = 0;      ///< task's clock of the first line; written before that is pushed
  std::int64_t first_utc_ns_ = 0;  ///< and the clock of the world, since 1970-01-01
  alignas(64) std::atomic<std::uint64_t> pushed_{0};
  alignas(64) std::atomic<std::uint64_t> taken_{0};
  std::atomic<std::uint64_t> written_{0};
  std::atomic<std::uint64_t> lost_{0};
  std::atomic<int> error_{0};

  std::mutex mutex_;  ///< of stopping_; push() needs none
  std::condition_variable stop_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace plc::blocks
