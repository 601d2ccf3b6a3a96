// BodyFlow: which instructions of a body run always, under conditions, in loops, or never.
//
// In: one Body. Out: read by the lints. Linear in the instructions. A condition counts as known when it follows from
// literals alone. Does not belong here: messages.
#pragma once

#include <cstdint>
#include <vector>

#include "ir/ir.h"

namespace plc::ir {

struct BodyFlow {
  enum class Known : std::uint8_t { kUnknown, kFalse, kTrue };
  static constexpr std::uint32_t kNowhere = 0xffffffffu;

  explicit BodyFlow(const Body& body);

  std::vector<Known> known;             ///< by instruction: BOOL values that follow from literals
  std::vector<std::uint32_t> label_at;  ///< by label: the position of its kLabel
  std::vector<bool> reached;            ///< by instruction
  /// By instruction: jumps that may skip it. RETURN does not count, nor does the entry of a FOR: 0 = runs whenever the
  /// body runs to its end.
  std::vector<std::uint32_t> skips;
  std::vector<std::uint32_t> loops;  ///< by instruction: jumps back that may repeat it

  /// Where the jump at `index` goes when taken; kNowhere for other instructions.
  [[nodiscard]] std::uint32_t target(const Body& body, std::uint32_t index) const;
  /// True when the instruction at `index` may be followed by the next one.
  [[nodiscard]] bool falls_through(const Body& body, std::uint32_t index) const;
  /// True when the jump at `index` may be taken.
  [[nodiscard]] bool may_jump(const Body& body, std::uint32_t index) const;

  /// True when a way through the body passes none of the instructions `stops` (ascending), none of which runs always.
  [[nodiscard]] bool can_avoid(const Body& body, const std::vector<std::uint32_t>& stops) const;
};

}  // namespace plc::ir
