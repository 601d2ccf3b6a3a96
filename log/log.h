// Log: what a plant that runs says, from whoever says it to where the operator looks.
//
// In: records. Out: those of the level that is asked for, not too often, through one sink. When the sink cannot write,
// that is said on stderr, and again when it can; meanwhile warnings and errors are written there as well, and at the
// end all that the sink has not written. Threads: the owner's; a cycle reaches the operator through rings that the
// owner empties. Does not belong here: who says what, command lines.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "log/limiter.h"
#include "log/sink.h"

namespace plc::log {

struct Options {
  core::Severity level = core::Severity::kNote;  ///< the least that is written
  core::TimeNs repeat_ns = 60'000'000'000;       ///< Limiter
  std::uint32_t most = 200;
};

class Log {
 public:
  /// `name` is what `aside` calls the sink when it fails, as a line of the text form.
  Log(const Options& options, std::unique_ptr<Sink> sink, std::string name, std::ostream& aside);

  /// Also told of every record that is written from now on, on the owner's thread; an empty function ends that.
  void also_tell(std::function<void(const Record&)> tell) { tell_ = std::move(tell); }
  /// From here on this process is the one that goes on.
  void start() { sink_->start(); }
  /// Without a time of its own the record gets the present one. Lines of its text after the first become details.
  void write(Record record);
  /// About every 20 ms: sums, what waits, what has become of the sink.
  void service();
  /// The end: all sums, and at most this time for what waits. What is not written by then goes to `aside`.
  void stop(core::TimeNs patience_ns);

 private:
  void look_at_sink();
  void emit(const Record& record);
  /// Writes to `aside` what waits in the sink and is shown nowhere.
  void show_waiting(core::Severity least);

  Options options_;
  std::unique_ptr<Sink> sink_;
  std::string name_;
  std::ostream& aside_;
  Limiter limiter_;
  core::MonotonicClock clock_;
  core::SystemCalendar calendar_;
  core::TimeNs next_sums_ns_ = 0;
  std::string problem_;
  std::function<void(const Record&)> tell_;
};

}  // namespace plc::log
