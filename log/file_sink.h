// A log file that is renamed when it is large, on a thread of its own: a disk that stalls delays nobody.
//
// In: lines. Out: FILE, and FILE.1 (the latest) to FILE.keep. A file that cannot be written is tried again every
// second: lines wait in memory meanwhile, up to kMostWaiting bytes; what is more is lost, and the file says so when it
// can be written again. Somebody else may rename or delete FILE (logrotate): it is made anew within a second. Does not
// belong here: what a line looks like (format.h).
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "log/sink.h"

namespace plc::log {

struct FileOptions {
  std::string path;
  std::uint64_t size = 10'000'000;  ///< bytes after which it is renamed
  std::uint32_t keep = 5;           ///< renamed files; 0 = the file begins anew
  std::string (*line)(const Record&) = nullptr;
  core::TimeNs retry_ns = 1'000'000'000;
};

class FileSink final : public Sink {
 public:
  static constexpr std::size_t kMostWaiting = 1'048'576;

  explicit FileSink(FileOptions options);
  /// Does not wait for a thread that hangs on the disk: it ends with the process.
  ~FileSink() override;
  FileSink(const FileSink&) = delete;
  FileSink& operator=(const FileSink&) = delete;

  void start() override;
  void write(const Record& record) override;
  /// Nothing to do: the thread writes at once.
  void flush() override {}
  void stop(core::TimeNs patience_ns) override;
  [[nodiscard]] std::string problem() const override;
  std::vector<Record> take_unshown(core::Severity least) override;
  [[nodiscard]] std::uint64_t lost() const override;

 private:
  class Writer;
  std::shared_ptr<Writer> writer_;  ///< shared with the thread, which may outlive the sink
  bool started_ = false;
};

}  // namespace plc::log
