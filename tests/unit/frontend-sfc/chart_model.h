// A model of charts, the slow and obvious way, after the clauses alone (IEC 61131-3:2013, 6.7; docs/guides/charts.md):
// every step, action and transition is looked at in every scan. What frontend-sfc makes is compared with it.
//
// In: a net of steps, transitions and associations; inputs scan by scan. Out: marking, times, variables, runs of bodies
// in their order. Does not belong here: anything of the compiler.
#pragma once

#include <algorithm>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "tests/support/random_chart.h"

namespace plc::test {

class ChartModel {
 public:
  ChartModel(const ChartNet& net, bool final_scan) : net_(net), final_scan_(final_scan) {
    const std::size_t steps = net.steps.size();
    x.assign(steps, false);
    t.assign(steps, 0);
    since_.assign(steps, 0);
    value.assign(static_cast<std::size_t>(net.actions), false);
    q_.assign(static_cast<std::size_t>(net.actions), false);
    for (std::size_t s = 0; s < steps; ++s) {
      for (const ChartAssociation& a : net.steps[s].actions)
        parts_.push_back({static_cast<int>(s), a, false, false, -1});
      if (net.steps[s].initial) entered_.insert(static_cast<int>(s));
    }
    for (const Part& part : parts_) {
      if (std::find(actions_.begin(), actions_.end(), part.a.action) == actions_.end())
        actions_.push_back(part.a.action);
    }
    for (std::size_t i = 0; i < net.transitions.size(); ++i) order_.push_back(i);
    std::stable_sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) {
      const auto rank = [&](std::size_t k) {
        const int p = net.transitions[k].priority;
        return p < 0 ? 1 << 30 : p;
      };
      return rank(a) < rank(b);
    });
  }

  void scan(const std::vector<bool>& inputs, std::int64_t now_ms) {
    for (const int s : left_) x[index(s)] = false;
    for (const int s : entered_) {
      x[index(s)] = true;
      since_[index(s)] = now_ms;
    }
    for (std::size_t s = 0; s < x.size(); ++s) {
      if (x[s]) t[s] = now_ms - since_[s];
    }
    act(now_ms);
    decide(inputs);
  }

  std::vector<bool> x;
  std::vector<std::int64_t> t;
  std::vector<bool> value;  ///< by action: of its variable
  std::uint32_t log = 0;    ///< changes with each run of a body, by which and when

 private:
  struct Part {
    int step;
    ChartAssociation a;
    bool stored;         ///< flip-flop of S, SD, DS, SL
    bool before;         ///< edge memory of P, P0, P1
    std::int64_t began;  ///< of its timer; -1 = not running
  };

  static std::size_t index(int i) { return static_cast<std::size_t>(i); }

  /// On-delay: TRUE once `in` has been TRUE for `time`.
  static bool delayed(Part& part, bool in, std::int64_t now) {
    if (!in) {
      part.began = -1;
      return false;
    }
    if (part.began < 0) part.began = now;
    return now - part.began >= part.a.time_ms;
  }

  void act(std::int64_t now) {
    std::vector<int> ends, due;
    for (const int action : actions_) {
      bool reset = false;
      for (const Part& part : parts_) {
        reset = reset || (part.a.action == action && part.a.qualifier == "R" && x[index(part.step)]);
      }
      bool q = false, pulse = false;
      for (Part& part : parts_) {
        if (part.a.action != action) continue;
        const bool in = x[index(part.step)];
        const std::string& word = part.a.qualifier;
        if (word == "N") q = q || in;
        if (word == "S" || word == "SD" || word == "SL") part.stored = (part.stored || in) && !reset;
        if (word == "S") q = q || part.stored;
        if (word == "L") q = (in && !delayed(part, in, now)) || (!in && delayed(part, false, now)) || q;
        if (word == "D") q = delayed(part, in, now) || q;
        if (word == "SD") q = delayed(part, part.stored, now) || q;
        if (word == "SL") {
          const bool over = delayed(part, part.stored, now);
          q = q || (part.stored && !over);
        }
        if (word == "DS") {
          const bool set = delayed(part, in, now);
          part.stored = (part.stored || set) && !reset;
          q = q || part.stored;
        }
        if (word == "P") q = q || (in && !part.before);
        if (word == "P1") pulse = pulse || (in && !part.before);
        if (word == "P0") pulse = pulse || (!in && part.before);
        part.before = in;
      }
      q = q && !reset;
      const bool fell = q_[index(action)];
      if (action < net_.variables) {
        const bool on = q || pulse;
        if (on) value[index(action)] = true;
        if (!on && (fell || reset)) value[index(action)] = false;
        q_[index(action)] = on;
      } else {
        if (q || pulse) {
          due.push_back(action);
        } else if (fell && final_scan_) {
          ends.push_back(action);
        }
        q_[index(action)] = q;
      }
    }
    for (const std::vector<int>* list : {&ends, &due}) {
      for (const int action : *list) log = (log * 31 + static_cast<std::uint32_t>(action) + 1) % 1000003;
    }
  }

  [[nodiscard]] bool holds(const ChartCondition& c, const std::vector<bool>& inputs) const {
    const bool input = c.input < 0 || inputs[index(c.input)] != c.negated;
    return input && (c.timed < 0 || t[index(c.timed)] >= c.time_ms);
  }

  void decide(const std::vector<bool>& inputs) {
    left_.clear();
    entered_.clear();
    for (const std::size_t i : order_) {
      const ChartTransition& one = net_.transitions[i];
      const bool enabled =
          std::all_of(one.from.begin(), one.from.end(), [&](int s) { return x[index(s)] && left_.count(s) == 0; });
      if (!enabled || !holds(one.condition, inputs)) continue;
      left_.insert(one.from.begin(), one.from.end());
      entered_.insert(one.to.begin(), one.to.end());
    }
  }

  const ChartNet& net_;
  bool final_scan_;
  std::vector<std::int64_t> since_;
  std::vector<bool> q_;
  std::vector<Part> parts_;
  std::vector<int> actions_;  ///< as first written, which is the order of their bodies
  std::vector<std::size_t> order_;
  std::set<int> left_, entered_;
};

}  // namespace plc::test
