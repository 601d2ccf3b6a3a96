// Loop walk: the instructions of a loop and a fixed point over its control flow, for analyses.
//
// In: a loop (loops.h), a domain of states. Out: the state before each instruction and at each exit. Compile time. Does
// not belong here: what states mean (range_analysis.cpp, nan_analysis.cpp).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "native/if_conversion.h"
#include "native/loops.h"
#include "native/translate.h"

namespace plc::native {

/// Loops with more are not analysed: it takes time by both.
inline constexpr std::size_t kMostInstructions = 4096;
inline constexpr std::size_t kMostVariables = 64;
/// A fixed point that was not reached by then says nothing.
inline constexpr int kMostWalks = 64;

/// The loop's instructions, by numbers in the body.
class LoopCode {
 public:
  LoopCode(const std::uint32_t* code, std::span<const runtime::LinkedInstruction> body, const Loop& loop)
      : code_(code), body_(body), loop_(loop) {
    for (std::size_t i = 0; i < body.size(); ++i) {
      const std::uint32_t to = target_of(operation_of(body[i].op).form, code + body[i].position);
      if (to != kNoTarget) jumps_.push_back({to, i});
    }
    std::sort(jumps_.begin(), jumps_.end());
  }

  [[nodiscard]] std::size_t first() const { return loop_.first; }
  [[nodiscard]] std::size_t last() const { return loop_.last; }
  [[nodiscard]] const std::uint32_t* code() const { return code_; }
  [[nodiscard]] Instruction at(std::size_t i) const {
    return {code_ + body_[i].position, body_[i].position, operation_of(body_[i].op)};
  }
  [[nodiscard]] std::vector<Access> accesses(std::size_t i) const {
    return accesses_of(code_, at(i)).value_or(std::vector<Access>{});
  }
  [[nodiscard]] std::size_t jumps_to(std::uint32_t position) const {
    return static_cast<std::size_t>(first_jump(position + 1) - first_jump(position));
  }
  /// Where instruction `i` jumps to: a number in the loop, or nothing.
  [[nodiscard]] std::optional<std::size_t> target(std::size_t i) const {
    const Instruction instruction = at(i);
    const std::uint32_t position = target_of(instruction.operation.form, instruction.words);
    if (position == kNoTarget || position < body_[first()].position || position > body_[last()].position) {
      return std::nullopt;
    }
    const auto found =
        std::lower_bound(body_.begin(), body_.end(), position,
                         [](const runtime::LinkedInstruction& a, std::uint32_t p) { return a.position < p; });
    return static_cast<std::size_t>(found - body_.begin());
  }
  [[nodiscard]] bool goes_on(std::size_t i) const {
    const Form form = at(i).operation.form;
    return form != Form::kReturn && form != Form::kJump && form != Form::kLoopJump;
  }
  /// Whether both sides of the jump may be computed, after which its BOOL says which one counts.
  [[nodiscard]] bool is_choice(const Emitter& emitter, std::size_t i) const {
    const auto short_if = short_if_at(code_, body_, i, [this](std::uint32_t p) { return jumps_to(p); });
    return short_if && written_by(emitter, code_, body_, *short_if);
  }
  /// The first of a few instructions before the loop that are executed whenever it is entered, one by one.
  [[nodiscard]] std::size_t straight_before() const {
    constexpr std::size_t kFew = 8;
    const auto others_come = [this](std::size_t i) {
      const std::uint32_t position = body_[i].position;
      return std::any_of(first_jump(position), first_jump(position + 1), [this, i](const Jump& jump) {
        return i != first() || jump.from < first() || jump.from > last();
      });
    };
    std::size_t i = first();
    while (i > 0 && first() - i < kFew && !others_come(i)) {
      const Form form = at(i - 1).operation.form;
      if (!goes_on(i - 1) || target_of(form, at(i - 1).words) != kNoTarget) break;
      --i;
    }
    return i;
  }

 private:
  struct Jump {
    std::uint32_t to = 0;  ///< position
    std::size_t from = 0;
    friend auto operator<=>(const Jump&, const Jump&) = default;
  };
  [[nodiscard]] std::vector<Jump>::const_iterator first_jump(std::uint32_t position) const {
    return std::lower_bound(jumps_.begin(), jumps_.end(), Jump{position, 0});
  }

  const std::uint32_t* code_;
  std::span<const runtime::LinkedInstruction> body_;
  const Loop& loop_;
  std::vector<Jump> jumps_;
};

/// Fixed point over the control flow of a loop, from the state where it is entered. A Domain has a State;
/// step(i, state) updates `state` to the state after instruction i and returns the state at its jump target, if the
/// jump is feasible; join() adds a state to another one and says whether that changed it.
template <class Domain>
class Walk {
 public:
  using State = typename Domain::State;
  Walk(const LoopCode& loop, Domain& domain) : loop_(loop), domain_(domain), at_(loop.last() - loop.first() + 1) {}

  /// False when it takes too long.
  bool run(const State& entry) {
    at_.front() = entry;
    for (int walks = 0; walks < kMostWalks; ++walks) {
      changed_ = false;
      once();
      if (!changed_) return true;
    }
    return false;
  }
  /// The state before an instruction; nothing when it is not reached.
  [[nodiscard]] const std::optional<State>& before(std::size_t i) const { return at_[i - loop_.first()]; }
  /// By position outside.
  [[nodiscard]] const std::map<std::uint32_t, State>& exits() const { return exits_; }

 private:
  void once() {
    for (std::size_t i = loop_.first(); i <= loop_.last(); ++i) {
      if (!before(i)) continue;
      State state = *before(i);
      const std::optional<State> jumped = domain_.step(i, state);
      if (loop_.goes_on(i) && domain_.possible(state)) add(i + 1, state, false);
      if (!jumped) continue;
      if (const auto target = loop_.target(i)) {
        add(*target, *jumped, *target <= i);
      } else {
        const Instruction instruction = loop_.at(i);
        const std::uint32_t to = target_of(instruction.operation.form, instruction.words);
        const auto [exit, is_new] = exits_.try_emplace(to, *jumped);
        if (is_new || domain_.join(exit->second, *jumped, false, loop_.last() + 1)) changed_ = true;
      }
    }
  }
  void add(std::size_t i, const State& state, bool back) {
    std::optional<State>& known = at_[i - loop_.first()];
    if (!known) {
      known = state;
      changed_ = true;
    } else if (domain_.join(*known, state, back, i)) {
      changed_ = true;
    }
  }

  const LoopCode& loop_;
  Domain& domain_;
  std::vector<std::optional<State>> at_;
  std::map<std::uint32_t, State> exits_;
  bool changed_ = false;
};

}  // namespace plc::native
