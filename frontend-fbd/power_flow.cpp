#include "frontend-fbd/power_flow.h"

#include <algorithm>
#include <cstddef>

namespace plc::fbd {
namespace {

/// Contacts in series that are looked back over: a rung of any length is lowered in linear time.
constexpr std::size_t kLongestWay = 64;

}  // namespace

const PowerFlows::Step* PowerFlows::step_to(ir::ValueId flow) const {
  const auto at = std::lower_bound(steps_.begin(), steps_.end(), flow.index,
                                   [](const Step& step, std::uint32_t index) { return step.to < index; });
  return at == steps_.end() || at->to != flow.index ? nullptr : &*at;
}

std::vector<ir::ValueId> PowerFlows::way_to(ir::ValueId flow) const {
  std::vector<ir::ValueId> way = {flow};
  for (const Step* step = step_to(flow); step != nullptr && way.size() < kLongestWay; step = step_to(way.back())) {
    way.push_back(step->from);
  }
  return way;
}

std::optional<ir::ValueId> PowerFlows::between(ir::Builder& builder, ir::ValueId from, ir::ValueId flow) {
  std::optional<ir::ValueId> all;
  for (; flow != from; flow = step_to(flow)->from) {
    const ir::ValueId state = step_to(flow)->state;
    all = all ? builder.logic(ir::Op::kAnd, state, *all) : state;
  }
  return all;
}

ir::ValueId PowerFlows::series(ir::Builder& builder, ir::ValueId flow, ir::ValueId state) {
  const ir::ValueId after = builder.logic(ir::Op::kAnd, flow, state);
  steps_.push_back({after.index, flow, state});
  return after;
}

ir::ValueId PowerFlows::parallel(ir::Builder& builder, ir::ValueId a, ir::ValueId b) {
  const std::vector<ir::ValueId> way_to_a = way_to(a);
  const std::vector<ir::ValueId> way_to_b = way_to(b);
  const auto common = std::find_first_of(way_to_a.begin(), way_to_a.end(), way_to_b.begin(), way_to_b.end());
  if (common == way_to_a.end()) return builder.logic(ir::Op::kOr, a, b);
  const auto this_way = between(builder, *common, a);
  const auto that_way = between(builder, *common, b);
  if (!this_way || !that_way) return *common;  // a wire past the contacts
  return series(builder, *common, builder.logic(ir::Op::kOr, *this_way, *that_way));
}

}  // namespace plc::fbd
