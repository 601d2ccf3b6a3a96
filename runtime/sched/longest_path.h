// The longest path through code that goes forward but for loops.
//
// In: steps with their costs and jumps, how often each loop goes round. Out: the cost of the longest way from the first
// step to the end of the body, in time linear in the number of steps. Does not belong here: what steps are or cost
// (estimate.cpp).
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "runtime/sched/cost_table.h"

namespace plc::runtime {

inline constexpr std::uint32_t kNoStep = std::numeric_limits<std::uint32_t>::max();

/// One instruction of a body, or several that are one to the interpreter.
struct Step {
  Cost cost;
  std::uint32_t target = kNoStep;  ///< step that a jump goes to; not beyond itself = a loop's jump back
  bool falls = true;               ///< goes on with the next step too
};

/// The steps [first, last]; the last one jumps back.
struct Loop {
  std::uint32_t first = 0;
  std::uint32_t last = 0;
  std::uint32_t parent = kNoStep;      ///< the loop around it
  std::vector<std::uint32_t> backs{};  ///< steps that jump back: several where loops were taken together
  double rounds = 0;                   ///< jumps back each time it is entered
  bool counted = false;                ///< a FOR, so that every way through it is one of its rounds
  Cost extra{};                        ///< of all those rounds; longest_path() computes it
};

/// The loops of a body, outer ones first, rounds unknown. They lie inside each other or apart: those that overlap,
/// which only jumps that were drawn can do, and those nested too deep are one.
std::vector<Loop> loops_of(const std::vector<Step>& steps);

/// `loops` as loops_of() has them, with their rounds. A body that never ends counts as far as it comes.
Cost longest_path(const std::vector<Step>& steps, std::vector<Loop> loops);

}  // namespace plc::runtime
