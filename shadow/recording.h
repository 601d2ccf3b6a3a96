// Recording: the records of all tasks of a resource, packed into blocks for whoever keeps them.
//
// In: a resource that is about to run. Out: blocks as files have them (record_file.h), to a sink. Threads: start() and
// finish() while no task runs; drain() on one thread at any time, often enough that no ring fills up: ten times a
// second. Does not belong here: where blocks go.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/result.h"
#include "runtime/record/recorder.h"
#include "runtime/resource.h"
#include "shadow/crash_memory.h"
#include "shadow/record_file.h"

namespace plc::shadow {

struct RecordingOptions {
  std::size_t ring_bytes = 4u << 20;                       ///< of each task
  std::size_t most_record_bytes = std::size_t{64} * 1024;  ///< a scan that takes in more is left out
  std::size_t block_bytes = 1u << 20;                      ///< records of a block, about, before they are compressed
  core::TimeNs block_ns = 10'000'000'000;                  ///< and the time that they cover
  CrashMemory* crash_memory = nullptr;                     ///< has the rings, made for them; outlives the recording
};

/// What was recorded of a task.
struct RecordingCounts {
  std::uint64_t scans = 0;         ///< executed since the start
  std::uint64_t lost = 0;          ///< of these, in no record: the ring was full, or the record too large
  std::uint64_t record_bytes = 0;  ///< in rings
  std::uint64_t stored_bytes = 0;  ///< in blocks, compressed
  std::uint64_t gaps = 0;          ///< stretches that no block has
};

class Recording {
 public:
  /// Takes a block.
  using Sink = std::function<void(const BlockInfo& info, std::vector<std::byte> block)>;
  /// Is told that the open block of a task is about to end.
  using BeforeEnd = std::function<void(std::uint32_t task)>;

  /// Records all tasks from their next scan on. P9001 when there is no memory for the rings.
  static core::Result<std::unique_ptr<Recording>> start(runtime::Resource& resource, Sink sink,
                                                        const RecordingOptions& options = {});
  ~Recording();
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

  /// Takes what the tasks have recorded, and gives away the blocks that are complete.
  void drain();
  /// The last blocks. No task runs any more.
  void finish();
  [[nodiscard]] RecordingCounts counts(std::uint32_t task) const;

  // ---- for who looks at records before their block is complete; on the thread of drain()

  void set_before_end(BeforeEnd call) { before_end_ = std::move(call); }
  /// The block that grows; null while there is none.
  [[nodiscard]] const BlockBuilder* open_block(std::uint32_t task) const {
    return tasks_[task]->block.open() ? &tasks_[task]->block : nullptr;
  }
  /// Scans that ended with a fault, of all tasks.
  [[nodiscard]] std::uint64_t faults() const noexcept { return faults_; }

 private:
  struct Task {
    std::unique_ptr<runtime::RecordRing> ring;
    std::optional<runtime::Recorder> recorder;
    BlockBuilder block;
    core::TimeNs block_began_ns = 0;
    std::uint64_t stored_bytes = 0, gaps = 0;
  };

  Recording(runtime::Resource& resource, Sink sink, const RecordingOptions& options)
      : resource_(resource), sink_(std::move(sink)), options_(options) {}
  void take(std::uint32_t task, std::span<const std::byte> record);
  void begin(std::uint32_t task, std::uint64_t first_scan, std::span<const std::byte> table);
  void flush(Task& task);

  runtime::Resource& resource_;
  Sink sink_;
  RecordingOptions options_;
  BeforeEnd before_end_;
  std::vector<std::unique_ptr<Task>> tasks_;
  std::uint64_t faults_ = 0;
};

}  // namespace plc::shadow
