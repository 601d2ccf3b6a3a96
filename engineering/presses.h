// Presses: buttons that are held. A BOOL is TRUE from the press to the release, and at least until every cyclic task
// that takes it in has had a whole scan with it.
//
// In: presses and releases of clients, scans of tasks. Out: writes. Who presses says so again within kLeaseNs, or the
// button is released: a browser that is closed or loses its network holds nothing. Threads: any. Does not belong here:
// who may press what (hmi_pages.h).
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/clock.h"
#include "engineering/variables.h"

namespace plc::engineering {

class Presses {
 public:
  static constexpr core::TimeNs kLeaseNs = 3'000'000'000;
  /// Shortest time that a button is held, for tasks that look at it without scans: those released by its edge.
  static constexpr core::TimeNs kShortestNs = 20'000'000;
  static constexpr std::size_t kMost = 1000;

  /// Scans that a task has ended so far; nothing when it is stopped.
  using Scans = std::function<std::optional<std::uint64_t>(std::uint32_t task)>;

  Presses(Variables& variables, Scans scans) : variables_(variables), scans_(std::move(scans)) {}

  struct Holder {
    std::string user;
    std::uint64_t session = 0;
    auto operator<=>(const Holder&) const = default;
  };
  struct Pressed {
    bool fresh = false;  ///< it was not held by this holder before
    bool held = false;   ///< the holder holds it now
    std::optional<core::Problem> problem;
  };
  /// P7101, P7102 when it is no BOOL, P7106, P7107, P7717 when too many are held.
  /// `renews`: only where the holder holds it: what comes late over a line that stood still presses nothing again.
  Pressed press(const std::string& path, const Holder& holder, bool renews, core::TimeNs now_ns);
  /// False when the holder does not hold it.
  bool release(const std::string& path, const Holder& holder, core::TimeNs now_ns);

  struct Ended {
    std::string path;
    Holder holder;
  };
  /// Ends what is due; about every 100 ms. Leases that ran out.
  std::vector<Ended> service(core::TimeNs now_ns);
  /// Releases all, at once.
  void stop();

 private:
  struct Button {
    std::string path;
    std::map<Holder, core::TimeNs> holders;  ///< until when
    std::vector<Variables::Write> off;
    core::TimeNs since_ns = 0;
    std::vector<std::pair<std::uint32_t, std::uint64_t>> wanted;  ///< tasks, and scans that they have to end
  };
  [[nodiscard]] bool was_seen(const Button& button, core::TimeNs now_ns) const;
  /// Writes FALSE where nobody holds it any more and tasks have seen it. True when it is done.
  bool let_go(const Button& button, core::TimeNs now_ns);
  [[nodiscard]] std::vector<std::uint32_t> readers(std::uint32_t offset) const;

  Variables& variables_;
  Scans scans_;
  std::mutex mutex_;
  std::map<std::uint32_t, Button> buttons_;  ///< by place in the global table
};

}  // namespace plc::engineering
