// Gathering what a running resource keeps into one set of values.
//
// In: the list of what is kept, answers of the tasks (runtime/memory/handover.h), snapshots of globals that no task has
// alone. Out: a set of values in which the variables of one task are of one of its scans. Threads: made before the
// tasks run; after that one thread. Does not belong here: when and where it is stored (keeper.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/clock.h"
#include "retain/layout.h"
#include "runtime/memory/global_ports.h"
#include "runtime/resource.h"

namespace plc::retain {

class Gatherer {
 public:
  /// Tells the tasks what is kept. Both must outlive it.
  Gatherer(runtime::Resource& resource, const Kept& kept);

  /// The values that the resource has now, into `values`. Not while tasks run.
  void copy_initial(std::span<std::byte> values) const;
  /// The other way round: runs on with these values, typed as the verifier demands. Before anything runs.
  void restore(std::span<const std::byte> values);

  /// Asks every task for its variables as they are at the end of a scan.
  void ask() noexcept;
  [[nodiscard]] bool answered() const noexcept;
  /// Puts what was answered since the last time, and the shared globals as they are published now, into `values`; the
  /// rest stays. The latest `now` of the scans that the answers are of; 0 without any.
  core::TimeNs take(std::span<std::byte> values);
  /// After its thread has ended: what the last scan of `task` has left is the answer, if it ended without a fault.
  /// After take(), for an older answer counts before it.
  void answer_for(std::uint32_t task) noexcept;

 private:
  struct Piece {
    std::uint64_t at = 0;  ///< in a set of values
    std::uint32_t offset = 0;
    std::uint32_t bytes = 0;
  };
  /// What a task keeps lies side by side in a set of values.
  struct Part {
    std::uint32_t task = 0;
    std::uint64_t at = 0;
    std::uint64_t bytes = 0;
  };
  [[nodiscard]] std::uint32_t size_of(std::size_t root) const {
    return kept_.layout.types[kept_.layout.roots[root].type].size;
  }

  runtime::Resource& resource_;
  const Kept& kept_;
  std::vector<Part> parts_;
  std::vector<Piece> shared_;
  std::optional<runtime::GlobalReader> reader_;  ///< only with shared ones
};

}  // namespace plc::retain
