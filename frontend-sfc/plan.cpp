#include "frontend-sfc/plan.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <numeric>

namespace plc::sfc {

namespace {

/// Steps in one set as far as some transition leaves them together or in turn.
class Sets {
 public:
  explicit Sets(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::uint32_t of(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) { parent_[of(b)] = of(a); }

 private:
  std::vector<std::uint32_t> parent_;
};

std::int64_t rank_of(const Transition& transition) {
  return transition.priority < 0 ? std::numeric_limits<std::int64_t>::max() : transition.priority;
}

/// The transitions of a group in an order that keeps the choice of each of its steps. Where the choices of two steps
/// contradict each other, the transition read first goes first.
void sort_group(Group& group, const std::vector<std::vector<std::uint32_t>>& choices) {
  std::vector<std::uint32_t> left = std::move(group.transitions);
  std::sort(left.begin(), left.end());
  group.transitions.clear();
  std::vector<std::size_t> next(group.sources.size(), 0);
  const auto is_left = [&](std::uint32_t t) { return std::binary_search(left.begin(), left.end(), t); };
  const auto may_go = [&](std::uint32_t t) {
    for (std::size_t s = 0; s < group.sources.size(); ++s) {
      const auto& choice = choices[group.sources[s]];
      while (next[s] < choice.size() && !is_left(choice[next[s]])) ++next[s];
      const auto at = std::find(choice.begin() + static_cast<std::ptrdiff_t>(next[s]), choice.end(), t);
      if (at != choice.end() && at != choice.begin() + static_cast<std::ptrdiff_t>(next[s])) return false;
    }
    return true;
  };
  while (!left.empty()) {
    auto chosen = std::find_if(left.begin(), left.end(), may_go);
    if (chosen == left.end()) chosen = left.begin();
    group.transitions.push_back(*chosen);
    left.erase(chosen);
  }
}

}  // namespace

Plan make_plan(const Chart& chart) {
  Plan plan;
  plan.group_of_step.assign(chart.steps.size(), Plan::kNone);
  for (const Step& step : chart.steps) {
    std::vector<std::uint32_t>& choice = plan.choices.emplace_back(step.leads);
    std::stable_sort(choice.begin(), choice.end(), [&](std::uint32_t a, std::uint32_t b) {
      return rank_of(chart.transitions[a]) < rank_of(chart.transitions[b]);
    });
    std::vector<std::uint32_t> once;
    for (const std::uint32_t t : choice) {
      if (std::find(once.begin(), once.end(), t) == once.end()) once.push_back(t);
    }
    choice = std::move(once);
  }
  Sets sets(chart.steps.size());
  for (const Transition& transition : chart.transitions) {
    for (const auto& set : transition.sources) {
      for (const std::uint32_t step : set) sets.join(transition.sources.front().front(), step);
    }
  }
  for (std::uint32_t t = 0; t < chart.transitions.size(); ++t) {
    const std::uint32_t root = sets.of(chart.transitions[t].sources.front().front());
    if (plan.group_of_step[root] == Plan::kNone) {
      plan.group_of_step[root] = static_cast<std::uint32_t>(plan.groups.size());
      plan.groups.emplace_back();
    }
    Group& group = plan.groups[plan.group_of_step[root]];
    group.transitions.push_back(t);
    for (const auto& set : chart.transitions[t].sources) {
      group.sources.insert(group.sources.end(), set.begin(), set.end());
    }
  }
  for (std::uint32_t g = 0; g < plan.groups.size(); ++g) {
    Group& group = plan.groups[g];
    std::sort(group.sources.begin(), group.sources.end());
    group.sources.erase(std::unique(group.sources.begin(), group.sources.end()), group.sources.end());
    for (const std::uint32_t step : group.sources) plan.group_of_step[step] = g;
    if (group.is_simple()) {
      group.transitions = plan.choices[group.sources.front()];
    } else {
      sort_group(group, plan.choices);
    }
  }
  return plan;
}

}  // namespace plc::sfc
