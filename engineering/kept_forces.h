// Forces that are to hold over a warm start, in a file of the state folder.
//
// In: a list of forces. Out: `forces.json`, with those that are to be kept; the same list at the next start. A program
// on trial leaves the file as it is. Threads: any; blocks on the disk. Does not belong here: forcing
// (runtime/force_list.h).
#pragma once

#include <atomic>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/clock.h"
#include "runtime/force_list.h"

namespace plc::engineering {

/// Replaces the file. Empty, or why not; nothing to do without a folder.
std::string store_kept_forces(const std::string& folder, const std::vector<runtime::Force>& forces);

/// Forces again what the file has, but for what is over by now; others for the rest of their time, by the monotonic
/// clock, of which `now_ns` is. Before the tasks run. A sentence for each force that cannot hold any more, and for a
/// file that cannot be read.
std::vector<std::string> force_again(const std::string& folder, core::TimeNs utc_ns, core::TimeNs now_ns,
                                     runtime::ForceList& forces);

/// The same for a start that ends them: a sentence for each force of the file.
std::vector<std::string> ended_by_start(const std::string& folder);

/// When the file becomes what the list is: at once, or once it is known that the program stays.
class KeptForces {
 public:
  /// `forces` must outlive it.
  KeptForces(std::string folder, const runtime::ForceList& forces) : folder_(std::move(folder)), forces_(forces) {}

  /// The program is on trial: if it fails, the one before finds the file as it was.
  void hold() { held_ = true; }
  /// It stays. What was not stored meanwhile is due.
  void release() { held_ = false; }
  /// The list has changed, and somebody else is to store it.
  void note_change() { changed_ = true; }
  /// Whether store() has something to do. At once.
  [[nodiscard]] bool is_due() const { return changed_ && !held_; }
  /// Stores the list; between hold() and release() it becomes due instead. Empty, or why not: then it is due, too.
  std::string store();

 private:
  std::string folder_;
  const runtime::ForceList& forces_;
  std::mutex storing_;
  std::atomic<bool> held_{false}, changed_{false};
};

}  // namespace plc::engineering
