// Sink: where records go. None waits for who reads them; what cannot be written now is kept for a while, then lost and
// counted.
//
// Threads: the owner's. Does not belong here: which records (limiter.h, log.h).
#pragma once

#include <cstdint>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "core/clock.h"
#include "log/record.h"

namespace plc::log {

class Sink {
 public:
  virtual ~Sink() = default;
  /// From here on this process is the one that goes on: threads may be made.
  virtual void start() {}
  virtual void write(const Record& record) = 0;
  /// What waits, as far as it can be written now.
  virtual void flush() = 0;
  /// The end: takes at most `patience_ns` for what waits.
  virtual void stop(core::TimeNs /*patience_ns*/) { flush(); }
  /// Why nothing is written at present; empty while all is well.
  [[nodiscard]] virtual std::string problem() const { return {}; }
  /// Records of at least this severity that wait and are shown nowhere; from now on they count as shown.
  virtual std::vector<Record> take_unshown(core::Severity /*least*/) { return {}; }
  /// Records that found no room among those that wait, and of which nothing has been written.
  [[nodiscard]] virtual std::uint64_t lost() const { return 0; }
};

/// A record that waits, and what is to be written of it.
struct Waiting {
  std::string bytes;
  Record record;
};
/// Those of at least this severity that are not shown; marks them as shown.
template <class Records>
std::vector<Record> take_unshown_of(Records& waiting, core::Severity least) {
  std::vector<Record> taken;
  for (Waiting& one : waiting) {
    if (one.record.shown || one.record.severity < least) continue;
    taken.push_back(one.record);
    one.record.shown = true;
  }
  return taken;
}

/// Lines for a stream that takes care of its reader itself.
std::unique_ptr<Sink> stream_sink(std::ostream& out, std::string (*line)(const Record&));
/// The socket of systemd's journal, or another one. It is never waited for.
inline constexpr const char* kJournalSocket = "/run/systemd/journal/socket";
std::unique_ptr<Sink> journal_sink(const std::string& socket);

}  // namespace plc::log
