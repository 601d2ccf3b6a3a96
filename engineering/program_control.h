// ProgramControl: what clients ask about the program as a whole, on its way to who runs the plant.
//
// In: wishes of calls, from any thread. Out: one at a time, for the thread that runs the plant; what became of it, for
// calls. Does not belong here: files (program_store.h), starting and stopping (tools/plc-run).
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/clock.h"
#include "core/result.h"
#include "engineering/program_store.h"
#include "engineering/signature.h"

namespace plc::engineering {

class ProgramControl {
 public:
  enum class State : std::uint8_t {
    kRuns,
    kTrial,    ///< a program that was not confirmed yet
    kStopped,  ///< no task runs, outputs are safe
    kEnds,     ///< another one is about to start, or plc-run ends
  };
  struct Wish {
    bool start = false;  ///< else stop
    std::string kind;    ///< of a start: "warm", "cold"
    std::string by;
    core::TimeNs at_ns = 0;
  };
  /// From the wish to the end of the tasks: so that who asked gets the answer.
  static constexpr core::TimeNs kAnswerNs = 50'000'000;

  // Before the server starts.
  ProgramStore* store = nullptr;  ///< null without a folder
  std::vector<PublicKey> keys;    ///< whose images are taken; empty: all
  bool wants_signature = false;   ///< there are to be keys, even if none could be read
  std::string given_path;         ///< FILE of plc-run
  StoredProgram running;          ///< `image` is that of the image that runs
  std::uint64_t starts = 0;       ///< by calls, since somebody started plc-run
  /// Whether the image in this file could run here: empty, or what was said about it. Blocks.
  std::function<std::string(const std::string& file)> check;

  /// Another program starts, or plc-run ends: what takes long in a call gives up. Any thread.
  std::atomic<bool> ending{false};

  /// Control stood for so long before this program; 0 = it did not. Any thread.
  std::atomic<core::TimeNs> stood_ns{0};

  /// Whether a wish for a start, or a stop, would be taken. Any thread.
  [[nodiscard]] bool may_ask(bool start) const {
    const std::lock_guard lock(mutex_);
    return is_free(start);
  }
  /// False when something is under way. Any thread.
  bool ask(Wish wish) {
    const std::lock_guard lock(mutex_);
    if (!is_free(wish.start)) return false;
    wish_ = std::move(wish);
    return true;
  }
  /// What is to be done now. The thread that runs the plant.
  std::optional<Wish> take(core::TimeNs now_ns) {
    const std::lock_guard lock(mutex_);
    if (!wish_ || now_ns - wish_->at_ns < kAnswerNs) return std::nullopt;
    if (wish_->start) {
      state_ = State::kEnds;  // here: no other wish gets in between
      ending = true;
    }
    return std::exchange(wish_, std::nullopt);
  }
  void set_state(State state) { state_.store(state); }
  [[nodiscard]] State state() const { return state_.load(); }

 private:
  [[nodiscard]] bool is_free(bool start) const {
    const State now = state_.load();
    return !wish_ && now != State::kEnds && now != State::kTrial && (start || now != State::kStopped);
  }

  mutable std::mutex mutex_;
  std::optional<Wish> wish_;
  std::atomic<State> state_{State::kRuns};
};

/// "runs", "trial", "stopped", "ends".
constexpr const char* word_of(ProgramControl::State state) {
  switch (state) {
    case ProgramControl::State::kRuns:
      return "runs";
    case ProgramControl::State::kTrial:
      return "trial";
    case ProgramControl::State::kStopped:
      return "stopped";
    case ProgramControl::State::kEnds:
      break;
  }
  return "ends";
}

}  // namespace plc::engineering
