// Player: executes the scans of a recording again, those of all tasks in the order of their times.
//
// In: a file of recorded scans. Out: one scan after the other, with the tables of all tasks and the globals as they
// were after it, which Access reads as from a resource that runs. Threads: one. Does not belong here: what is printed.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "shadow/record_file.h"
#include "shadow/replica_set.h"

namespace plc::shadow {

/// A scan that was executed again.
struct PlayedScan {
  std::uint32_t task = 0;
  std::uint64_t scan = 0;
  core::TimeNs now_ns = 0;
  bool after_gap = false;  ///< scans of the task before this one are not in the recording
  Replica::Outcome outcome;
};

class Player {
 public:
  /// P60xx when the image of the recording is not sound, P9001 when it cannot be linked here. The file outlives it.
  static core::Result<std::unique_ptr<Player>> make(const RecordFile& file, core::Diagnostics& diagnostics);

  /// The recorded tasks; what runs them may be installed before the first scan.
  [[nodiscard]] runtime::Resource& resource() { return replicas_->resource(); }
  [[nodiscard]] ReplicaSet& replicas() { return *replicas_; }
  /// Time of the first and of the last recorded scan, of all tasks; nothing without one.
  [[nodiscard]] std::optional<core::TimeNs> begin_ns() const;
  [[nodiscard]] std::optional<core::TimeNs> end_ns() const;
  /// From now on the time of a scan is the instant at which its task was released, not when it began: a plant begins
  /// some microseconds later. An offset of a task is not known here; its scans count as of the instant before it.
  void count_releases();
  /// Instant of release from which on scans of a cyclic task are missing, because the recording ends.
  [[nodiscard]] std::optional<core::TimeNs> missing_from_ns();
  /// Time of the scan that comes next; nothing at the end.
  [[nodiscard]] std::optional<core::TimeNs> next_ns() {
    const Task* const task = next_task();
    return task == nullptr ? std::nullopt : std::optional(task->now_ns);
  }
  /// The record of the scan that comes next, its task, and whether it follows the scan before it without a gap.
  struct Upcoming {
    std::uint32_t task = 0;
    std::span<const std::byte> record;
    bool follows = false;
  };
  [[nodiscard]] std::optional<Upcoming> upcoming();
  /// Executes it.
  std::optional<PlayedScan> step();
  /// Goes to where all scans up to this time have been executed, and none after it: at most the scans of one block of
  /// each task are executed for it. Backwards, too.
  void seek(core::TimeNs now_ns);
  /// Goes to where `scan` of `task` has been executed, and nothing after it. False when the recording does not have it.
  bool seek(std::uint32_t task, std::uint64_t scan);
  /// Brings the global table of resource() up to date with the scans that ran.
  void show_globals() { replicas_->show_globals(); }
  /// Whether this machine has the time zone of the recording; without, local time is UTC.
  [[nodiscard]] bool has_zone() const noexcept { return replicas_->has_zone(); }
  /// Blocks that could not be read.
  [[nodiscard]] std::uint64_t damaged_blocks() const noexcept { return damaged_blocks_; }

 private:
  struct Task {
    std::vector<const BlockInfo*> blocks;  ///< ascending
    std::size_t next_block = 0;
    Block block;
    std::size_t at = 0;                 ///< in block.records, after `record`
    std::span<const std::byte> record;  ///< that comes next; empty: there is none
    core::TimeNs now_ns = 0;            ///< of its scan, or the instant of its release
    std::uint64_t next_scan = 0;
    bool known = false;        ///< next_scan is that after the scan that was executed last
    bool gap = false;          ///< before the next record
    bool fresh = false;        ///< the next record is the first of its block
    core::TimeNs grid_ns = 0;  ///< distance of the instants of release
  };

  explicit Player(const RecordFile& file) : file_(file) {}
  /// Goes on to the next record of a task; loads its block.
  void advance(Task& task);
  /// Time of a scan of the task: see count_releases().
  [[nodiscard]] core::TimeNs time_of(const Task& task, const runtime::RecordHead& head) const;
  /// Goes to the first record of the block.
  void go_to_block(Task& task, std::size_t block);
  /// The task whose scan comes next; null at the end.
  [[nodiscard]] Task* next_task();

  const RecordFile& file_;
  std::unique_ptr<ReplicaSet> replicas_;
  std::vector<Task> tasks_;
  std::uint64_t damaged_blocks_ = 0;
  bool count_releases_ = false;
};

}  // namespace plc::shadow
