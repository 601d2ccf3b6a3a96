#include "runtime/sched/longest_path.h"

#include <algorithm>
#include <utility>

namespace plc::runtime {
namespace {

/// Loops inside loops beyond this are taken together: a hostile image must not cost more than its size.
constexpr std::size_t kMaxNesting = 32;

class LongestPath {
 public:
  /// `loops` as loops_of() has them, with their rounds.
  LongestPath(const std::vector<Step>& steps, std::vector<Loop> loops)
      : steps_(steps), loops_(std::move(loops)), inside_(steps.size(), kNoStep), back_of_(steps.size(), kNoStep) {
    for (std::uint32_t l = 0; l < loops_.size(); ++l) {
      for (std::uint32_t s = loops_[l].first; s <= loops_[l].last; ++s) inside_[s] = l;
      for (const std::uint32_t back : loops_[l].backs) back_of_[back] = l;
    }
    reach_.resize(steps_.size());
    for (auto l = static_cast<std::uint32_t>(loops_.size()); l-- > 0;) {
      const Cost round = longest_round(l);
      Loop& loop = loops_[l];
      loop.extra.again = round.again * loop.rounds;
      // The way through a FOR is its first round; past a WHILE there may be none.
      const bool anew = !loop.counted && loop.rounds >= 1;
      loop.extra.first = loop.extra.again + (anew ? std::max(round.first - round.again, 0.0) : 0.0);
    }
  }

  /// From the first step to the end of the body.
  [[nodiscard]] Cost length() {
    if (steps_.empty()) return {};
    const auto end = static_cast<std::uint32_t>(steps_.size());
    arrive(0, entered(kNoStep, 0, kNoStep));
    Cost longest, stuck;
    bool ends = false;
    walk(0, end, kNoStep, [&](std::uint32_t step, const Cost& cost) {
      stuck = longer(stuck, cost);
      if (steps_[step].falls || steps_[step].target != kNoStep) return;
      longest = longer(longest, cost);
      ends = true;
    });
    return ends ? longest : stuck;  // a loop that nothing leaves ends by its budget
  }

 private:
  struct Reach {
    bool reached = false;
    Cost cost;
  };

  /// From a head of the loop to a jump back.
  Cost longest_round(std::uint32_t l) {
    const Loop& loop = loops_[l];
    for (const std::uint32_t back : loop.backs) {
      arrive(steps_[back].target, entered(kNoStep, steps_[back].target, l));
    }
    Cost longest;
    walk(loop.first, loop.last + 1, l, [&](std::uint32_t step, const Cost& cost) {
      if (back_of_[step] == l) longest = longer(longest, cost);
    });
    return longest;
  }

  void arrive(std::uint32_t step, const Cost& so_far) {
    const Cost cost = so_far + steps_[step].cost;
    Reach& reach = reach_[step];
    reach = {true, reach.reached ? longer(reach.cost, cost) : cost};
  }

  /// Goes forward from all steps arrived at; visit(step, longest way up to its end). Leaves no step reached.
  template <class Visit>
  void walk(std::uint32_t begin, std::uint32_t end, std::uint32_t within, Visit visit) {
    for (std::uint32_t s = begin; s < end; ++s) {
      const Reach here = std::exchange(reach_[s], {});
      if (!here.reached) continue;
      visit(s, here.cost);
      const auto go = [&](std::uint32_t to) {
        if (to > s && to < end) arrive(to, here.cost + entered(s, to, within));
      };
      if (steps_[s].falls) go(s + 1);
      if (steps_[s].target != kNoStep) go(steps_[s].target);
    }
  }

  /// What the rounds cost of the loops inside `around` that a way from `from` enters at `to`; `from` kNoStep: all there
  /// are.
  [[nodiscard]] Cost entered(std::uint32_t from, std::uint32_t to, std::uint32_t around) const {
    Cost cost;
    for (std::uint32_t l = inside_[to]; l != around && l != kNoStep; l = loops_[l].parent) {
      if (from != kNoStep && from >= loops_[l].first && from <= loops_[l].last) break;
      cost += loops_[l].extra;
    }
    return cost;
  }

  const std::vector<Step>& steps_;
  std::vector<Loop> loops_;
  std::vector<std::uint32_t> inside_;   ///< innermost loop of each step
  std::vector<std::uint32_t> back_of_;  ///< the loop whose jump back the step is
  std::vector<Reach> reach_;
};

}  // namespace

std::vector<Loop> loops_of(const std::vector<Step>& steps) {
  std::vector<Loop> found;
  for (std::uint32_t s = 0; s < steps.size(); ++s) {
    if (steps[s].target <= s) found.push_back({steps[s].target, s, kNoStep, {s}});
  }
  std::sort(found.begin(), found.end(),
            [](const Loop& a, const Loop& b) { return a.first != b.first ? a.first < b.first : a.last > b.last; });
  std::vector<Loop> loops;
  std::vector<std::uint32_t> open;  // into loops, each inside the one before
  for (Loop& loop : found) {
    while (!open.empty() && loops[open.back()].last < loop.first) open.pop_back();
    const bool overlaps = !open.empty() && loop.last > loops[open.back()].last;
    if (!overlaps && open.size() < kMaxNesting) {
      loop.parent = open.empty() ? kNoStep : open.back();
      open.push_back(static_cast<std::uint32_t>(loops.size()));
      loops.push_back(std::move(loop));
      continue;
    }
    // Into the outermost of the loops that it reaches out of.
    while (open.size() > 1 && loop.last > loops[open[open.size() - 2]].last) open.pop_back();
    Loop& into = loops[open.back()];
    into.last = std::max(into.last, loop.last);
    into.backs.push_back(loop.last);
  }
  return loops;
}

Cost longest_path(const std::vector<Step>& steps, std::vector<Loop> loops) {
  return LongestPath(steps, std::move(loops)).length();
}

}  // namespace plc::runtime
