// ReplicaSet: all tasks of a recorded image as replicas, and the globals as their scans have left them.
//
// In: the head of a recording, tables and records of its tasks. Out: a resource that Access reads as it reads one that
// runs. Threads: one. Does not belong here: in which order scans come (player.h, follower.h).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/diagnostics.h"
#include "core/result.h"
#include "core/time_zone.h"
#include "runtime/record/replay.h"
#include "runtime/resource.h"
#include "shadow/record_file.h"
#include "shadow/replica.h"

namespace plc::shadow {

class ReplicaSet {
 public:
  /// P6xxx or P7630 when the image is not sound, P9001 when it cannot be linked here.
  static core::Result<std::unique_ptr<ReplicaSet>> make(const RecordingHead& head, core::Diagnostics& diagnostics);

  /// The tasks; what runs them may be installed before the first scan.
  [[nodiscard]] runtime::Resource& resource() { return *resource_; }
  [[nodiscard]] std::size_t task_count() const { return replicas_.size(); }
  [[nodiscard]] const Replica& replica(std::uint32_t task) const { return replicas_[task]; }
  /// Tasks, the most urgent first: the order of scans of one instant.
  [[nodiscard]] const std::vector<std::uint32_t>& order() const { return order_; }
  /// Whether this machine has the time zone of the recording; without, local time is UTC.
  [[nodiscard]] bool has_zone() const noexcept { return zone_.has_value(); }

  /// The table of `task` before the scan that comes next. False, and nothing happened, when it is of another size.
  bool load(std::uint32_t task, std::span<const std::byte> table);
  /// Whether the table of `task` is that after a scan which ran here, so that it must be the next block's.
  [[nodiscard]] bool follows(std::uint32_t task) const { return follows_[task] != 0; }
  /// One scan of `task`.
  Replica::Outcome run(std::uint32_t task, std::span<const std::byte> record);
  /// What is not as in `table`, in words that name the first variable; empty when all is equal.
  [[nodiscard]] std::string difference(std::uint32_t task, std::span<const std::byte> table);
  /// The words for bytes [first, last] of the table of `task`: the first variable that lies there, and how many more.
  [[nodiscard]] std::string variables_at(std::uint32_t task, std::uint32_t first, std::uint32_t last);
  /// The globals as the scans that ran have left them; laid out as the global table.
  [[nodiscard]] std::span<const std::byte> globals() const { return globals_; }
  /// Brings the global table of resource() up to date with the scans that ran.
  void show_globals() { resource_->globals().reset(globals_); }

 private:
  struct Part {
    std::uint32_t at = 0, bytes = 0;
  };
  ReplicaSet() = default;
  void take_globals(std::uint32_t task);

  std::optional<core::TimeZone> zone_;
  std::vector<runtime::Replay> replays_;
  std::unique_ptr<runtime::Resource> resource_;
  std::vector<Replica> replicas_;
  std::vector<std::vector<Part>> seen_;  ///< by task, of the globals: what it exports, and inputs
  std::vector<std::uint8_t> follows_;    ///< by task
  std::vector<std::uint32_t> order_;
  std::vector<std::byte> globals_;
};

}  // namespace plc::shadow
