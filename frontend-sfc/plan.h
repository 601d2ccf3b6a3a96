// Plan: in which order the transitions of a chart are tested, and which of them exclude each other.
//
// In: Chart. Out: groups of transitions that share steps. Transitions of different groups never want the same step, so
// they may be tested in any order. Does not belong here: IR.
#pragma once

#include <cstdint>
#include <vector>

#include "frontend-sfc/chart.h"

namespace plc::sfc {

/// Transitions that share steps they leave, directly or through others of the group, in the order of their choice: one
/// is passed over only for an earlier one that clears in this evaluation.
struct Group {
  std::vector<std::uint32_t> transitions;
  std::vector<std::uint32_t> sources;  ///< all steps they leave, ascending
  /// Leaves one step only, so the first that clears ends the choice.
  [[nodiscard]] bool is_simple() const { return sources.size() == 1; }
};

struct Plan {
  std::vector<Group> groups;
  std::vector<std::uint32_t> group_of_step;         ///< of the step's only group; kNone = no transition leaves it
  std::vector<std::vector<std::uint32_t>> choices;  ///< by step: its transitions, first choice first
  static constexpr std::uint32_t kNone = 0xffffffffu;
};

/// Order of a choice: transitions with a priority by it, then the others, each as drawn or written (6.7.3).
Plan make_plan(const Chart& chart);

}  // namespace plc::sfc
