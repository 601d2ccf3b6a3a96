// ProgramStart: which program this start of plc-run takes, FILE or one that was uploaded, and what comes after it.
//
// In: FILE, the folder of the state, wishes of the engineering server. Out: an image to run, when to end, and whether
// plc-run is started anew then (relaunch.h). A program that was uploaded is on trial for its first second: with a
// fault, or an end that nobody wanted, the one before is taken again. Threads: the main one's. Does not belong here:
// what is on the disk (engineering/program_store.h), loading, running.
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <streambuf>
#include <string>
#include <string_view>

#include "core/clock.h"
#include "engineering/program_control.h"
#include "retain/keeper.h"
#include "runtime/sched/ordinary_thread.h"
#include "tools/plc-run/run_log.h"

namespace plc::tools {

/// Passes on what is written, and keeps the end of it.
class KeptEnd final : public std::streambuf {
 public:
  explicit KeptEnd(std::ostream& stream) : stream_(stream), before_(stream.rdbuf(this)) {}
  ~KeptEnd() override { stream_.rdbuf(before_); }
  KeptEnd(const KeptEnd&) = delete;
  KeptEnd& operator=(const KeptEnd&) = delete;
  [[nodiscard]] const std::string& text() const { return text_; }

 protected:
  int sync() override { return before_->pubsync(); }
  int_type overflow(int_type character) override;
  std::streamsize xsputn(const char* text, std::streamsize count) override;

 private:
  std::ostream& stream_;
  std::streambuf* before_;
  std::string text_;
};

class ProgramStart {
 public:
  /// A program on trial is one for so long.
  static constexpr core::TimeNs kTrialNs = 1'000'000'000;

  /// `given`: FILE. `folder`: of the state, or empty. `log` must outlive it.
  ProgramStart(std::string given, const std::string& folder, RunLog& log);
  ~ProgramStart();
  ProgramStart(const ProgramStart&) = delete;
  ProgramStart& operator=(const ProgramStart&) = delete;

  /// P7753 when it is not known what to run.
  [[nodiscard]] const std::optional<core::Problem>& problem() const { return problem_; }
  /// The image in place of FILE; empty: FILE.
  [[nodiscard]] const std::string& image_file() const { return choice_.file; }
  [[nodiscard]] const std::string& image_hash() const { return choice_.program.image; }
  /// Of retained variables, when a call wants another one than the command line.
  [[nodiscard]] std::optional<retain::Start> start() const;
  /// What the server before has said for the one that follows; or empty.
  [[nodiscard]] const std::string& from_server() const { return from_server_; }
  [[nodiscard]] const std::string& from_log() const { return from_log_; }
  engineering::ProgramControl& control() { return control_; }
  /// The program that was tried right before this start, and did not; nothing: none was.
  [[nodiscard]] std::optional<engineering::FailedStart> failed_start() const {
    return failed_before_ && store_ ? store_->failed() : std::nullopt;
  }
  /// Who has asked for the start; empty: no call.
  [[nodiscard]] const std::string& asked_by() const { return asked_by_; }
  /// What runs, for people: FILE, or the program that was uploaded.
  [[nodiscard]] std::string title() const;

  /// What is kept on the disk may become this program's: it is on no trial, and that it is the one is on the disk.
  [[nodiscard]] bool settled() const { return settled_; }
  /// No more attempts to get there, but one when there was none yet.
  void end_keeping();

  /// The tasks run since `begin_ns`.
  void runs(core::TimeNs begin_ns);
  /// About every 20 ms while they do. True when they are to end. `fault`: of the latest fault, or empty.
  bool often(core::TimeNs now_ns, const std::string& fault);
  /// The tasks have ended; they were told to at `stop_ns`. Whether the process waits for a start by a call.
  bool ended(core::TimeNs stop_ns);
  /// About every 20 ms while it waits. True when that start has come.
  bool wants_start(core::TimeNs now_ns);
  /// Whether plc-run is to be started anew.
  [[nodiscard]] bool again() const { return again_; }
  /// Whether the process, or the one that follows it, goes on after the tasks have ended.
  [[nodiscard]] bool goes_on() const { return again_ || halts_; }
  /// For the process that follows.
  void hand_over(const std::string& from_server, const std::string& from_log);
  /// The server has something else to say to the one that follows: a process that dies on trial has said it by then.
  /// Any thread.
  void hand_over_on_trial(std::string from_server);
  /// The exit code of this process in place of `code`. `asked`: somebody wanted the end.
  int exit_code(int code, bool asked);

 private:
  void choose(const std::string& folder);
  void pass_on(const std::string& kind, core::TimeNs stopped_ns, const std::string& from_server,
               const std::string& from_log) const;
  void take(const engineering::ProgramControl::Wish& wish);
  void fail(const std::string& why);
  void start_keeping();
  void say_unkept();

  std::string given_;
  RunLog& log_;
  core::SystemCalendar calendar_;
  std::optional<core::Problem> problem_;
  std::unique_ptr<engineering::ProgramStore> store_;
  engineering::ProgramStore::Choice choice_;
  engineering::ProgramControl control_;
  std::unique_ptr<KeptEnd> errors_;  ///< of a trial
  runtime::OrdinaryThread keeping_;  ///< puts the choice on the disk
  std::mutex keep_mutex_;            ///< of what follows
  std::condition_variable keep_changed_;
  bool keep_ending_ = false;
  std::string unkept_;  ///< why it is not there yet
  std::string unkept_said_;
  std::atomic<bool> settled_{true};
  std::string start_, next_start_, from_server_, from_log_;
  std::mutex hand_over_mutex_;  ///< of from_server_ on trial, and of what the next process gets
  core::TimeNs begin_ns_ = 0, stopped_ns_ = 0, handed_stop_ns_ = 0;
  std::string asked_by_;
  bool restarted_ = false, halts_ = false, again_ = false;
  bool failed_ = false;         ///< this process was a trial that failed
  bool failed_before_ = false;  ///< the one before it was
};

/// ProgramControl::check for this command line. Is given up when `ending` becomes true.
std::string check_image(const std::string& file, const std::atomic<bool>& ending);

}  // namespace plc::tools
