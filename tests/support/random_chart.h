// A random chart: steps with associations of every qualifier, transitions with conditions and priorities, as a net and
// as the text of a project.
//
// In: a seed. Out: a net, which need not be a sensible chart, and ST that the compiler accepts. Does not belong here:
// what the chart does (tests/unit/frontend-sfc/chart_model.h).
#pragma once

#include <cstdint>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace plc::test {

struct ChartAssociation {
  std::string qualifier;
  int action = 0;
  std::int64_t time_ms = 0;
};
struct ChartStep {
  bool initial = false;
  std::vector<ChartAssociation> actions;
};
/// TRUE when `input` (-1: always TRUE) is not `negated`, and step `timed` (-1: none) has lasted `time_ms`.
struct ChartCondition {
  int input = -1;
  bool negated = false;
  int timed = -1;
  std::int64_t time_ms = 0;
};
struct ChartTransition {
  std::set<int> from, to;
  int priority = -1;
  ChartCondition condition;
};
struct ChartNet {
  std::vector<ChartStep> steps;
  std::vector<ChartTransition> transitions;
  int variables = 0;  ///< actions 0 to here drive variables, the others are bodies
  int actions = 0;
};

inline constexpr int kChartInputs = 3;
inline constexpr const char* kChartQualifiers[] = {"N", "R", "S", "L", "D", "P", "P0", "P1", "SD", "DS", "SL"};

class RandomChart {
 public:
  explicit RandomChart(std::uint32_t seed) : random_(seed) {}

  ChartNet net() {
    ChartNet out;
    const int steps = 2 + below(below(8) == 0 ? 20 : 6);
    out.variables = 1 + below(4);
    out.actions = out.variables + 1 + below(below(8) == 0 ? 14 : 3);
    for (int s = 0; s < steps; ++s) {
      ChartStep step;
      step.initial = s == 0 || below(6) == 0;
      for (int a = below(4); a > 0; --a) {
        ChartAssociation one;
        one.qualifier = kChartQualifiers[below(std::size(kChartQualifiers))];
        one.action = below(out.actions);
        one.time_ms = 10 * (1 + below(4));
        step.actions.push_back(one);
      }
      out.steps.push_back(step);
    }
    for (int i = 1 + below(2 * steps); i > 0; --i) {
      ChartTransition one;
      for (int k = below(4) == 0 ? 2 : 1; k > 0; --k) one.from.insert(below(steps));
      for (int k = below(4) == 0 ? 2 : 1; k > 0; --k) one.to.insert(below(steps));
      if (below(3) == 0) one.priority = below(3);
      one.condition.input = below(5) == 0 ? -1 : below(kChartInputs);
      one.condition.negated = below(2) == 0;
      if (below(3) == 0) {
        one.condition.timed = below(steps);
        one.condition.time_ms = 10 * below(4);
      }
      out.transitions.push_back(one);
    }
    return out;
  }

  int below(std::size_t limit) {
    return static_cast<int>(std::uniform_int_distribution<std::size_t>(0, limit - 1)(random_));
  }
  int below(int limit) { return below(static_cast<std::size_t>(limit)); }

 private:
  std::mt19937 random_;
};

inline std::string chart_steps_text(const std::set<int>& steps) {
  std::string text;
  for (const int s : steps) text += (text.empty() ? "S" : ", S") + std::to_string(s);
  return steps.size() == 1 ? text : "(" + text + ")";
}

/// The chart as a project: inputs main.i0 .., driven variables main.a0 .., main.log changed by the bodies.
inline std::string chart_program(const ChartNet& net) {
  std::string text = "PROGRAM Logic\nVAR\n  log : UDINT;\n";
  for (int i = 0; i < kChartInputs; ++i) text += "  i" + std::to_string(i) + " : BOOL;\n";
  for (int a = 0; a < net.variables; ++a) text += "  a" + std::to_string(a) + " : BOOL;\n";
  text += "END_VAR\n";
  for (std::size_t s = 0; s < net.steps.size(); ++s) {
    text += std::string(net.steps[s].initial ? "INITIAL_STEP S" : "STEP S") + std::to_string(s) + ":\n";
    for (const ChartAssociation& a : net.steps[s].actions) {
      text += "  a" + std::to_string(a.action) + "(" + a.qualifier;
      const std::string& q = a.qualifier;
      if (q == "L" || q == "D" || q == "SD" || q == "DS" || q == "SL")
        text += ", T#" + std::to_string(a.time_ms) + "ms";
      text += ");\n";
    }
    text += "END_STEP\n";
  }
  for (const ChartTransition& t : net.transitions) {
    text += "TRANSITION ";
    if (t.priority >= 0) text += "(PRIORITY := " + std::to_string(t.priority) + ") ";
    text += "FROM " + chart_steps_text(t.from) + " TO " + chart_steps_text(t.to) + " := ";
    const std::string input = "i" + std::to_string(t.condition.input);
    text += t.condition.input < 0 ? "TRUE" : t.condition.negated ? "NOT " + input : input;
    if (t.condition.timed >= 0) {
      text += " AND S" + std::to_string(t.condition.timed) + ".T >= T#" + std::to_string(t.condition.time_ms) + "ms";
    }
    text += "; END_TRANSITION\n";
  }
  for (int a = net.variables; a < net.actions; ++a) {
    text += "ACTION a" + std::to_string(a) + ": log := (log * 31 + " + std::to_string(a + 1) +
            ") MOD 1000003; END_ACTION\n";
  }
  return text +
         "END_PROGRAM\nCONFIGURATION c\nRESOURCE r ON PLC\nTASK t(INTERVAL := T#10ms, PRIORITY := 0);\n"
         "PROGRAM main WITH t : Logic;\nEND_RESOURCE\nEND_CONFIGURATION\n";
}

}  // namespace plc::test
