// Random charts with random inputs do what the model of the clauses says: marking, times, variables, runs of bodies and
// their order, with and without the final scan.
#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/frontend-sfc/chart_model.h"
#include "tests/unit/frontend-sfc/compiled_chart.h"

namespace {

using plc::test::ChartModel;
using plc::test::CompiledChart;
using plc::test::ModelAssociation;
using plc::test::ModelNet;
using plc::test::ModelStep;
using plc::test::ModelTransition;

constexpr int kInputs = 3;
constexpr int kScans = 25;
constexpr const char* kWords[] = {"N", "R", "S", "L", "D", "P", "P0", "P1", "SD", "DS", "SL"};

class Maker {
 public:
  explicit Maker(std::uint32_t seed) : random_(seed) {}

  ModelNet net() {
    ModelNet out;
    const int steps = 2 + below(below(8) == 0 ? 20 : 6);
    out.variables = 1 + below(4);
    out.actions = out.variables + 1 + below(below(8) == 0 ? 14 : 3);
    for (int s = 0; s < steps; ++s) {
      ModelStep step;
      step.initial = s == 0 || below(6) == 0;
      for (int a = below(4); a > 0; --a) {
        ModelAssociation one;
        one.qualifier = kWords[below(std::size(kWords))];
        one.action = below(out.actions);
        one.time_ms = 10 * (1 + below(4));
        step.actions.push_back(one);
      }
      out.steps.push_back(step);
    }
    for (int i = 1 + below(2 * steps); i > 0; --i) {
      ModelTransition one;
      for (int k = below(4) == 0 ? 2 : 1; k > 0; --k) one.from.insert(below(steps));
      for (int k = below(4) == 0 ? 2 : 1; k > 0; --k) one.to.insert(below(steps));
      if (below(3) == 0) one.priority = below(3);
      one.condition.input = below(5) == 0 ? -1 : below(kInputs);
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

std::string steps_text(const std::set<int>& steps) {
  std::string text;
  for (const int s : steps) text += (text.empty() ? "S" : ", S") + std::to_string(s);
  return steps.size() == 1 ? text : "(" + text + ")";
}

std::string program(const ModelNet& net) {
  std::string text = "PROGRAM Logic\nVAR\n  log : UDINT;\n";
  for (int i = 0; i < kInputs; ++i) text += "  i" + std::to_string(i) + " : BOOL;\n";
  for (int a = 0; a < net.variables; ++a) text += "  a" + std::to_string(a) + " : BOOL;\n";
  text += "END_VAR\n";
  for (std::size_t s = 0; s < net.steps.size(); ++s) {
    text += std::string(net.steps[s].initial ? "INITIAL_STEP S" : "STEP S") + std::to_string(s) + ":\n";
    for (const ModelAssociation& a : net.steps[s].actions) {
      text += "  a" + std::to_string(a.action) + "(" + a.qualifier;
      const std::string& q = a.qualifier;
      if (q == "L" || q == "D" || q == "SD" || q == "DS" || q == "SL")
        text += ", T#" + std::to_string(a.time_ms) + "ms";
      text += ");\n";
    }
    text += "END_STEP\n";
  }
  for (const ModelTransition& t : net.transitions) {
    text += "TRANSITION ";
    if (t.priority >= 0) text += "(PRIORITY := " + std::to_string(t.priority) + ") ";
    text += "FROM " + steps_text(t.from) + " TO " + steps_text(t.to) + " := ";
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

/// The first difference, or nothing.
std::string difference(CompiledChart& chart, const ChartModel& model, const ModelNet& net) {
  for (std::size_t s = 0; s < net.steps.size(); ++s) {
    const std::string step = "main.S" + std::to_string(s);
    if (chart.read(step + ".X") != (model.x[s] ? "1" : "0")) return step + ".X is " + chart.read(step + ".X");
    if (chart.read(step + ".T") != std::to_string(model.t[s] * 1'000'000))
      return step + ".T is " + chart.read(step + ".T");
  }
  for (int a = 0; a < net.variables; ++a) {
    const std::string name = "main.a" + std::to_string(a);
    if (chart.read(name) != (model.value[static_cast<std::size_t>(a)] ? "1" : "0"))
      return name + " is " + chart.read(name);
  }
  const std::string log = chart.read("main.log");
  return log == std::to_string(model.log) ? "" : "main.log is " + log + ", not " + std::to_string(model.log);
}

void check(std::uint32_t seed) {
  Maker maker(seed);
  const ModelNet net = maker.net();
  plc::core::CompileOptions options;
  const bool final_scan = seed % 2 == 1;
  options.sfc_final_scan = final_scan ? plc::core::FinalScan::kOn : plc::core::FinalScan::kOff;
  const std::string text = program(net);
  SCOPED_TRACE("seed " + std::to_string(seed));
  CompiledChart chart(text, options);
  ASSERT_NE(chart.simulation, nullptr) << text << chart.errors();
  ChartModel model(net, final_scan);
  for (int scan = 0; scan < kScans; ++scan) {
    std::vector<bool> inputs;
    for (int i = 0; i < kInputs; ++i) {
      inputs.push_back(maker.below(2) == 0);
      chart.write("main.i" + std::to_string(i), inputs.back() ? "1" : "0");
    }
    ASSERT_TRUE(chart.simulation->step());
    model.scan(inputs, 10 * scan);
    const std::string found = difference(chart, model, net);
    ASSERT_EQ(found, "") << "in scan " << scan + 1 << (final_scan ? ", with the final scan, of\n" : ", of\n") << text;
  }
}

TEST(RandomCharts, DoWhatTheModelSays) {
  const char* const asked = std::getenv("PLC_RANDOM_CHARTS");
  const auto count = static_cast<std::uint32_t>(asked != nullptr ? std::atoi(asked) : 10'000);
  for (std::uint32_t seed = 1; seed <= count && !::testing::Test::HasFatalFailure(); ++seed) check(seed);
}

}  // namespace
