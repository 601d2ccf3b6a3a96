// Relaunch: plc-run becomes itself again, in the same process, to run another program (docs/adr/0063).
//
// In: what this process was started with; a text for the next one. Out: the same command line, executed anew: with a
// guardian by that one, once the runtime has ended, so that the process that a service manager knows stays the same.
// Nothing of the run before is left but the text, which is in memory, and the sockets that systemd has passed. Threads:
// the main one's; guardian_ended() that of the guardian. Does not belong here: when, and which program.
#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace plc::tools {

/// What the runtime ends with to be started anew; nobody but the guardian sees it.
inline constexpr int kExitRelaunch = 75;

class Relaunch {
 public:
  static Relaunch& instance();

  /// First of all in main().
  void begin(int argc, char** argv);
  /// What the process before has handed over; nothing when there was none.
  [[nodiscard]] const std::optional<std::string>& handed_over() const { return handed_over_; }
  /// For the process that follows; the last text counts that was written to its end, whenever this process dies.
  void hand_over(std::string_view text) const;
  /// How many sockets systemd has passed, from descriptor 3 on.
  void keep_sockets(int count) { sockets_ = count; }
  /// While it is true, an end of the runtime that it did not choose leads to another start, too.
  void set_trial(bool trial);
  [[nodiscard]] bool on_trial() const;
  /// Whether this is the runtime of a guardian, which waits for its end.
  [[nodiscard]] bool has_guardian() const;
  /// The process that was this one's guardian, once it has died; else 0.
  [[nodiscard]] int dead_guardian() const;

  /// Last of all in main(): the exit code; or this process, when no guardian waits for it, is started anew: also after
  /// an end on trial that nobody wanted.
  int end(int code) const;
  /// In the guardian: starts anew, or gives the code to exit with. `asked`: a signal wants the end.
  int guardian_ended(int code, bool asked) const;
  /// The command line.
  [[nodiscard]] const std::vector<std::string>& arguments() const { return arguments_; }
  /// Of this program's file; /proc/self/exe when another one is at its place by now, as after an upgrade.
  [[nodiscard]] static std::string own_path();

 private:
  void execute() const;

  std::vector<std::string> arguments_;
  std::optional<std::string> handed_over_;
  std::string oom_score_;
  int policy_ = 0, priority_ = 0;  ///< of the scheduler
  int text_ = -1;                  ///< a file in memory that this process shares with the guardian
  int first_process_ = 0;
  int sockets_ = 0;
  std::atomic<bool>* trial_ = nullptr;  ///< shared with the guardian
};

}  // namespace plc::tools
