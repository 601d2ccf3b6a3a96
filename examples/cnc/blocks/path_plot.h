// Samples go from a thread that must not wait to a picture in a file, through a ring and a thread of its own.
//
//   push() --> ring (one producer, one consumer) --> thread, every 20 ms: PathDrawing --> file
//
// In: samples of one recording after the other. Out: a file with the picture of the last one. Not here: what is drawn
// (path_drawing.h), when is recorded.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "path_drawing.h"

namespace cnc {

class PathPlot {
 public:
  struct Options {
    std::string program;          ///< text of the part program
    std::string title;            ///< of the picture
    std::string file;             ///< for the picture; replaced as a whole
    double tool = 1;              ///< mm
    std::size_t samples = 65536;  ///< that wait at most
  };
  /// Starts the thread; throws std::system_error when there is none.
  explicit PathPlot(Options options);
  /// Draws what waits, and a recording that has no end yet.
  ~PathPlot();
  PathPlot(const PathPlot&) = delete;
  PathPlot& operator=(const PathPlot&) = delete;

  /// RT, one thread: false when there is no room.
  bool push(const PathSample& sample) noexcept;

  /// RT: pictures that were written; the figures are those of the last one.
  [[nodiscard]] std::uint32_t pictures() const noexcept { return pictures_.load(std::memory_order_acquire); }
  /// RT: why the last one could not be written, a number of errno(3), or 0.
  [[nodiscard]] int error() const noexcept { return error_.load(std::memory_order_relaxed); }
  /// RT: mm.
  [[nodiscard]] double deviation() const noexcept { return deviation_.load(std::memory_order_relaxed); }
  /// RT: mm.
  [[nodiscard]] double following_error() const noexcept { return following_error_.load(std::memory_order_relaxed); }

 private:
  void run();
  void drain();
  void finish();
  [[nodiscard]] int write(const std::string& text) const;

  Options options_;
  std::optional<PathDrawing> drawing_;  ///< of the recording that is under way

  std::vector<PathSample> ring_;  ///< sample n lies at n modulo its size
  alignas(64) std::atomic<std::uint64_t> pushed_{0};
  alignas(64) std::atomic<std::uint64_t> taken_{0};
  std::atomic<std::uint32_t> pictures_{0};
  std::atomic<int> error_{0};
  std::atomic<double> deviation_{0};
  std::atomic<double> following_error_{0};

  std::mutex mutex_;  ///< of stopping_; push() needs none
  std::condition_variable stop_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace cnc
