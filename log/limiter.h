// Limiter: lets messages through until they come too often, and says later how many it has held back.
//
// In: records, and the time by a monotonic clock. Out: whether to write one now; from time to time records that say
// "... (412 times more in 60 s)". Memory is bounded by the number of sources. Threads: one. Does not belong here:
// severities, writing.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/clock.h"
#include "log/record.h"

namespace plc::log {

class Limiter {
 public:
  /// `window_ns`: within it a message that comes again is counted; 0 = everything is let through. `most`: messages that
  /// one source may have within it.
  Limiter(core::TimeNs window_ns, std::uint32_t most) : window_ns_(window_ns), most_(most) {}

  /// Whether the record is to be written now. Two are the same message when all that is said of them is, but for task
  /// scan and time.
  bool admit(const Record& record, core::TimeNs now_ns);
  /// Sums of what was held back in the windows that have ended by now; `all`: in those that have not, too.
  std::vector<Record> sums(core::TimeNs now_ns, core::TimeNs utc_ns, bool all = false);

 private:
  struct Message {
    Record record;
    core::TimeNs begin_ns = 0;
    std::uint64_t held = 0;  ///< since then
  };
  struct Source {
    core::TimeNs begin_ns = 0;
    std::uint32_t written = 0;  ///< since then
    std::uint64_t held = 0;     ///< since then, of new messages
    core::Severity worst = core::Severity::kNote;
  };
  [[nodiscard]] bool has_ended(core::TimeNs begin_ns, core::TimeNs now_ns) const {
    return now_ns - begin_ns >= window_ns_;
  }

  core::TimeNs window_ns_;
  std::uint32_t most_;
  std::unordered_map<std::string, Message> messages_;
  std::unordered_map<std::string, Source> sources_;
};

}  // namespace plc::log
