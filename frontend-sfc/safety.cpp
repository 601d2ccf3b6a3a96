#include "frontend-sfc/safety.h"

#include <algorithm>
#include <cstdint>
#include <deque>
#include <string>
#include <unordered_set>
#include <vector>

namespace plc::sfc {

using core::Code;

namespace {

/// Markings that are looked at, and steps that are copied for them: a few tens of milliseconds.
constexpr std::size_t kMaxMarkings = 50'000;
constexpr std::size_t kMaxWork = 20'000'000;

using Marking = std::vector<std::uint32_t>;  ///< active steps, ascending

struct MarkingHash {
  std::size_t operator()(const Marking& marking) const {
    std::uint64_t h = 1469598103934665603ull;
    for (const std::uint32_t step : marking) h = (h ^ step) * 1099511628211ull;
    return static_cast<std::size_t>(h ^ (h >> 29));
  }
};

class Exploration {
 public:
  Exploration(const Chart& chart, const Plan& plan, core::Diagnostics& diagnostics)
      : chart_(chart), plan_(plan), diagnostics_(diagnostics) {}

  void run() {
    active_.assign(chart_.steps.size(), false);
    tested_.assign(chart_.transitions.size(), false);
    doubled_.assign(chart_.steps.size(), false);
    Marking initial;
    for (std::uint32_t s = 0; s < chart_.steps.size(); ++s) {
      if (chart_.steps[s].initial) initial.push_back(s);
    }
    reach(initial);
    while (!open_.empty() && seen_.size() <= kMaxMarkings && work_ <= kMaxWork) {
      const Marking marking = std::move(open_.front());
      open_.pop_front();
      leave(marking);
    }
    complete_ = open_.empty();
    report();
  }

 private:
  void reach(const Marking& marking) {
    work_ += marking.size();
    for (const std::uint32_t step : marking) active_[step] = true;
    if (seen_.insert(marking).second) open_.push_back(marking);
  }

  static bool holds(const Marking& marking, const std::vector<std::uint32_t>& set) {
    return std::includes(marking.begin(), marking.end(), set.begin(), set.end());
  }

  /// Every transition by itself: what clears in one evaluation clears in some order of single ones, too.
  void leave(const Marking& marking) {
    for (const std::uint32_t step : marking) {
      for (const std::uint32_t t : plan_.choices[step]) {
        for (const auto& set : chart_.transitions[t].sources) {
          ++work_;
          if (set.front() == step && holds(marking, set)) clear(marking, t, set);
        }
      }
    }
  }

  void clear(const Marking& marking, std::uint32_t t, const std::vector<std::uint32_t>& set) {
    tested_[t] = true;
    Marking next;
    std::set_difference(marking.begin(), marking.end(), set.begin(), set.end(), std::back_inserter(next));
    for (const std::uint32_t target : chart_.transitions[t].targets) {
      const auto at = std::lower_bound(next.begin(), next.end(), target);
      if (at != next.end() && *at == target) {
        doubled_[target] = true;
      } else {
        next.insert(at, target);
      }
    }
    reach(next);
  }

  void report(Code code, const core::SourceRef& at, std::string message, std::string help) {
    diagnostics_.report(code, at, chart_.name, std::move(message), std::move(help));
  }

  void report() {
    for (std::uint32_t s = 0; s < chart_.steps.size(); ++s) {
      const Step& step = chart_.steps[s];
      if (doubled_[s]) {
        report(Code::P3116, step.at,
               "step \"" + step.name + "\" may be entered while it is active: two sequences become one",
               "join simultaneous branches by a simultaneous convergence before they go on");
      }
    }
    if (!complete_) {
      report(Code::P3119, chart_.at,
             "chart can be in more than " + std::to_string(kMaxMarkings) +
                 " situations: steps that never become active are not looked for",
             "it runs as drawn");
      return;
    }
    for (const Step& step : chart_.steps) {
      if (active_[static_cast<std::size_t>(&step - chart_.steps.data())]) continue;
      report(Code::P3114, step.at, "step \"" + step.name + "\" never becomes active",
             "no way leads to it from the initial step; draw one, or delete it");
    }
    for (std::uint32_t t = 0; t < chart_.transitions.size(); ++t) {
      const Transition& transition = chart_.transitions[t];
      if (tested_[t]) continue;
      // Where a source never becomes active, that was said.
      const bool sources = std::any_of(transition.sources.begin(), transition.sources.end(), [&](const auto& set) {
        return std::all_of(set.begin(), set.end(), [&](std::uint32_t s) { return active_[s]; });
      });
      if (!sources) continue;
      report(Code::P3117, transition.at,
             "the steps that this transition joins are never active together: it never clears",
             "simultaneous branches begin at one simultaneous divergence and end at one convergence");
    }
  }

  const Chart& chart_;
  const Plan& plan_;
  core::Diagnostics& diagnostics_;
  std::unordered_set<Marking, MarkingHash> seen_;
  std::deque<Marking> open_;
  std::vector<bool> active_, tested_, doubled_;
  std::size_t work_ = 0;
  bool complete_ = false;
};

}  // namespace

void report_unsafe(const Chart& chart, const Plan& plan, core::Diagnostics& diagnostics) {
  if (!chart.steps.empty()) Exploration(chart, plan, diagnostics).run();
}

}  // namespace plc::sfc
