// ForceList: which variables of a resource are forced, by whom, since when and until when (memory/forces.h does it).
//
// In: paths and values as text, from people. Out: values that the tasks keep at both ends of their cycles, a list for
// whoever shows it. What is forced has its value whenever a scan begins and ends, and so have drivers, other tasks and
// HMIs; writes from outside are refused. Threads: any but the tasks', one call at a time inside. Does not belong here:
// who may force, where that is noted.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.h"
#include "core/result.h"
#include "runtime/access.h"
#include "runtime/resource.h"

namespace plc::runtime {

struct Force {
  std::string path;   ///< as it was asked for
  std::string value;  ///< as shown_value() writes it
  std::string owner;  ///< who forces it
  std::string reason;
  core::TimeNs since_ns = 0;             ///< UTC
  std::optional<core::TimeNs> until_ns;  ///< UTC, for people; nothing: until it is released
  bool kept = false;                     ///< it is to hold after a warm start, too: whoever keeps it asks for it
  /// The program may write it in the middle of a scan: from there to the end of the scan its own value counts.
  bool yields = false;
  /// When it is over, by the monotonic clock: UTC may be set meanwhile. Nothing: until it is released.
  std::optional<core::TimeNs> until_mono_ns{};
};

class ForceList {
 public:
  /// Before the tasks run. The resource outlives it.
  explicit ForceList(Resource& resource);

  /// Forces `force.path` to `force.value`, from the next scan of each task on; a force of the same variable is
  /// replaced. P7101, P7102 for the path, P7103 to P7106 for the value. What now holds, with the value in its usual
  /// form.
  core::Result<Force> set(Force force);
  /// False when the variable is not forced. `by`: who does it, for the log.
  bool release(std::string_view path, std::string_view by = {});
  /// All of `owner`; all when it is empty. How many.
  std::size_t release_all(std::string_view owner = {}, std::string_view by = {});
  /// Releases what is over at `now_ns` of the monotonic clock. Those.
  std::vector<Force> expire(core::TimeNs now_ns);
  /// What was forced, released and over since the last call, in words for the log.
  std::vector<std::string> take_changes();
  [[nodiscard]] std::vector<Force> list() const;
  [[nodiscard]] std::size_t size() const;
  /// Whether the variable at `place` is forced.
  [[nodiscard]] bool holds(const Place& place) const;

  static constexpr std::size_t kMost = 1000;

 private:
  struct Held {
    Force force;
    Place place;
    std::vector<std::byte> bytes;
  };
  template <class Is>
  std::vector<Force> remove(Is&& is, const std::string& how);
  /// Tells the tasks, and the global table.
  void apply();
  [[nodiscard]] bool exchanges(std::uint32_t task, std::uint32_t field) const { return exchanged_[task][field] != 0; }

  Resource& resource_;
  std::vector<std::vector<std::uint8_t>> exchanged_;  ///< by task and field of the global table: imported or exported
  mutable std::mutex mutex_;
  std::vector<Held> held_;
  std::vector<std::string> changes_;
};

}  // namespace plc::runtime
