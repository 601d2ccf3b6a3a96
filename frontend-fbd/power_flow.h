// PowerFlows: power through contacts in series and in parallel, as logic with what branches have in common outside.
//
// In: flow and state at each contact, flows that meet. Out: their AND and OR as IR values. Branches that leave one flow
// and meet again are flow AND (this OR that), not (flow AND this) OR (flow AND that): of a rung nothing is evaluated
// twice. Does not belong here: drawings.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "ir/builder.h"

namespace plc::fbd {

class PowerFlows {
 public:
  /// Power after a contact (IEC 61131-3:2013, 8.2.4).
  ir::ValueId series(ir::Builder& builder, ir::ValueId flow, ir::ValueId state);
  /// Power where two flows meet.
  ir::ValueId parallel(ir::Builder& builder, ir::ValueId a, ir::ValueId b);

 private:
  /// A flow that is another one AND something.
  struct Step {
    std::uint32_t to = 0;  ///< index of the flow
    ir::ValueId from{};
    ir::ValueId state{};
  };
  [[nodiscard]] const Step* step_to(ir::ValueId flow) const;
  /// All that the flow comes from, itself first.
  [[nodiscard]] std::vector<ir::ValueId> way_to(ir::ValueId flow) const;
  /// What is between a flow and one that it comes from; nothing when they are the same.
  std::optional<ir::ValueId> between(ir::Builder& builder, ir::ValueId from, ir::ValueId flow);

  std::vector<Step> steps_;  ///< in ascending order: values are numbered as they are made
};

}  // namespace plc::fbd
