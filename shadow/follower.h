// Follower: replicas of a plant that runs, which execute its scans soon after the plant has.
//
// In: the blocks of a Recording while they grow. Out: the state of all tasks as of their newest scans, and, since every
// scan is compared with its record, the first variable that is not as in the plant. Threads: one. Does not belong here:
// for whom, and when (shadow.h).
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "shadow/replica_set.h"
#include "shadow/scan_observer.h"

namespace plc::shadow {

/// What a replica has and the plant has not.
struct Difference {
  std::uint32_t task = 0;
  std::uint64_t scan = 0;
  std::string what;
};

class Follower {
 public:
  /// Makes what replicas run in, before their first scan: native code, or nothing.
  using Prepare = std::function<void(runtime::Resource&)>;
  using Deadline = std::optional<std::chrono::steady_clock::time_point>;

  /// As ReplicaSet::make().
  static core::Result<std::unique_ptr<Follower>> make(const RecordingHead& head, const Prepare& prepare,
                                                      core::Diagnostics& diagnostics);

  /// Executes what the open block of `task` has and was not executed yet, until the deadline. True when that was all.
  bool follow(std::uint32_t task, const BlockBuilder& block, Deadline deadline);
  /// Null: nobody is told.
  void set_observer(ScanObserver* observer) { observer_ = observer; }
  [[nodiscard]] ReplicaSet& replicas() { return *replicas_; }
  /// Scans of `task` that were executed since the start, or are known from the table that followed them.
  [[nodiscard]] std::uint64_t next_scan(std::uint32_t task) const { return tasks_[task].next_scan; }
  /// What was found since the last call: the first of each block.
  std::vector<Difference> take_differences() { return std::exchange(differences_, {}); }

 private:
  struct Task {
    bool in_block = false;  ///< of which first_scan is the first
    std::uint64_t first_scan = 0;
    std::uint64_t next_scan = 0;
    std::size_t at = 0;    ///< in the records of the block
    bool differs = false;  ///< a difference in this block was found
  };
  Follower() = default;
  void enter(std::uint32_t task, const BlockBuilder& block);
  void found(std::uint32_t task, std::uint64_t scan, std::string what);

  std::unique_ptr<ReplicaSet> replicas_;
  std::vector<Task> tasks_;
  std::vector<Difference> differences_;
  ScanObserver* observer_ = nullptr;
};

}  // namespace plc::shadow
