// The log of plc-run: where it goes, and how everything that is said on the way gets there.
//
// In: [log] of plc.toml, --log, --log-level; messages of the plant; lines that other code prints on stdout and stderr.
// Out: records (log/). Text on stderr, which is the default, is as it is printed; elsewhere lines that are printed
// before, beside and after the run are records, too, so that the log is whole. What a crash and the guardian say is
// written to stderr directly. Threads: the main one's alone. Does not belong here: forms, files, limits (log/).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <ostream>
#include <span>
#include <streambuf>
#include <string>
#include <utility>

#include "io-drivers/config/configuration.h"
#include "io-drivers/driver.h"
#include "log/log.h"
#include "runtime/resource.h"
#include "runtime/sched/task.h"
#include "tools/plc-run/output.h"

namespace plc::tools {

/// --log=FORMAT[:FILE]
struct LogPlace {
  io::LogFormat format = io::LogFormat::kAuto;
  std::string file;
};
/// "text", "json:plant.log", "journal"; nothing for anything else.
std::optional<LogPlace> parse_log_place(const std::string& text);

/// Lines of a stream as records, and, if asked to, as the lines they were.
class LineBuffer final : public std::streambuf {
 public:
  /// `also` may be null.
  LineBuffer(log::Log& log, std::streambuf* also) : log_(log), also_(also) {}
  ~LineBuffer() override { end_record(); }
  LineBuffer(const LineBuffer&) = delete;
  LineBuffer& operator=(const LineBuffer&) = delete;
  /// No more lines belong to what was printed last.
  void end_record();

 protected:
  int sync() override;
  int_type overflow(int_type character) override;
  std::streamsize xsputn(const char* text, std::streamsize count) override;

 private:
  void take_line(std::string line);

  log::Log& log_;
  std::streambuf* also_;
  std::string line_;                   ///< as far as it has come
  std::optional<log::Record> record_;  ///< lines that begin with a blank belong to it
};

/// The record that a line tells of: "plant.st:3:5: error P4001: .."; "error P7001: .." is of this severity, and the
/// rest its text. A line without severity is a note, one that begins with the name of the program an error.
log::Record record_of_line(std::string line);

class RunLog {
 public:
  /// `talk`: where lines for people go that are no trouble. `place`, `level`: of the command line.
  RunLog(const io::Configuration& configuration, const std::optional<LogPlace>& place,
         std::optional<core::Severity> level, Output& output, std::ostream& talk);
  ~RunLog();
  RunLog(const RunLog&) = delete;
  RunLog& operator=(const RunLog&) = delete;

  /// For lines about the run that are no trouble.
  std::ostream& talk() { return talk_; }
  /// Also told of every message from now on; an empty function ends that.
  void also_tell(std::function<void(const log::Record&)> tell) { log_->also_tell(std::move(tell)); }
  /// In the process that goes on.
  void start() { log_->start(); }

  void say(core::Severity severity, std::string text, std::string source = {});
  void say(const io::Sentence& sentence) { say(sentence.severity, sentence.text, sentence.source); }
  void say_fault(const runtime::Resource& resource, const runtime::TaskFault& fault);
  /// What taskblocks have told since the last call.
  void say_messages(runtime::Resource& resource);
  /// About every 20 ms.
  void service();
  /// The end; the guardian waits no longer than five seconds.
  void stop();

 private:
  void end_records();

  std::ostream err_;  ///< the stream itself, whatever std::cerr is by now
  std::unique_ptr<log::Log> log_;
  std::unique_ptr<LineBuffer> cerr_, talked_;  ///< null for text on stderr
  std::streambuf* cerr_before_ = nullptr;
  std::ostream talk_;
  bool stopped_ = false;
};

}  // namespace plc::tools
