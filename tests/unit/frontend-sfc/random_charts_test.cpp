// Random charts with random inputs do what the model of the clauses says: marking, times, variables, runs of bodies and
// their order, with and without the final scan.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "tests/support/random_chart.h"
#include "tests/unit/frontend-sfc/chart_model.h"
#include "tests/unit/frontend-sfc/compiled_chart.h"

namespace {

using plc::test::chart_program;
using plc::test::ChartModel;
using plc::test::ChartNet;
using plc::test::CompiledChart;
using plc::test::kChartInputs;
using plc::test::RandomChart;

constexpr int kScans = 25;

/// The first difference, or nothing.
std::string difference(CompiledChart& chart, const ChartModel& model, const ChartNet& net) {
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
  RandomChart maker(seed);
  const ChartNet net = maker.net();
  plc::core::CompileOptions options;
  const bool final_scan = seed % 2 == 1;
  options.sfc_final_scan = final_scan ? plc::core::FinalScan::kOn : plc::core::FinalScan::kOff;
  const std::string text = chart_program(net);
  SCOPED_TRACE("seed " + std::to_string(seed));
  CompiledChart chart(text, options);
  ASSERT_NE(chart.simulation, nullptr) << text << chart.errors();
  ChartModel model(net, final_scan);
  for (int scan = 0; scan < kScans; ++scan) {
    std::vector<bool> inputs;
    for (int i = 0; i < kChartInputs; ++i) {
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
