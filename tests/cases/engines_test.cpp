// Every case in every engine, instant by instant: all bytes of all tables are equal, not only what its trace watches.
#include "tests/support/engines.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "io-drivers/stimulus.h"
#include "runtime/sched/simulation.h"
#include "testing/case_file.h"
#include "testing/table.h"
#include "tests/support/compiled_image.h"

namespace plc::test {
using plc::tests::case_names;
using plc::tests::CaseFile;
using plc::tests::CaseRun;
using plc::tests::project_of;
using plc::tests::read_case;
using plc::tests::read_csv;
namespace {

namespace fs = std::filesystem;

/// What one engine makes of the case: its own stimulus, its own clock.
struct Simulated {
  explicit Simulated(runtime::Resource& resource) : simulation(resource) {}
  runtime::Simulation simulation;
  std::unique_ptr<io::Stimulus> stimulus;
};

void run_in_all_engines(const fs::path& folder, const bytecode::Image& image, std::size_t instants) {
  std::string problem;
  const auto engines = Engines::load(image, problem);
  ASSERT_NE(engines, nullptr) << problem;
  std::vector<std::unique_ptr<Simulated>> runs;
  for (std::size_t e = 0; e < engines->size(); ++e) {
    runs.push_back(std::make_unique<Simulated>((*engines)[e]));
    if (!fs::exists(folder / "stimulus.csv")) continue;
    auto stimulus = io::Stimulus::load((folder / "stimulus.csv").string(), (*engines)[e]);
    ASSERT_TRUE(stimulus.has_value()) << stimulus.error().message;
    runs[e]->stimulus = std::make_unique<io::Stimulus>(std::move(*stimulus));
    runs[e]->stimulus->attach(runs[e]->simulation);
  }
  for (std::size_t instant = 0; instant < instants; ++instant) {
    for (const auto& run : runs) run->simulation.step();
    ASSERT_EQ(engines->difference(), "") << "after instant " << instant;
  }
  const std::vector<runtime::TaskFault>& expected = runs[0]->simulation.faults();
  for (const auto& run : runs) {
    const std::vector<runtime::TaskFault>& found = run->simulation.faults();
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i].task, expected[i].task);
      EXPECT_EQ(found[i].cycle, expected[i].cycle);
      EXPECT_EQ(static_cast<int>(found[i].fault.kind), static_cast<int>(expected[i].fault.kind));
      EXPECT_EQ(found[i].fault.pou, expected[i].fault.pou);
      EXPECT_EQ(found[i].fault.word, expected[i].fault.word);
    }
  }
}

class CaseInEveryEngine : public ::testing::TestWithParam<std::string> {};

TEST_P(CaseInEveryEngine, TablesAreEqualAfterEveryInstant) {
  const fs::path folder = fs::path(PLC_CASES) / GetParam();
  const CaseFile the_case = read_case(folder);
  for (const CaseRun& run : the_case.runs) {
    SCOPED_TRACE("run " + run.expected + " " + command_line(run.options));
    std::vector<std::string> options = run.options;
    for (const std::string& library : the_case.libraries) {
      options.insert(options.end(), {"--lib", (folder / library).string()});
    }
    const auto image = compiled_image(PLC_TOOL, project_of(folder).string(), options);
    ASSERT_TRUE(image.has_value());
    run_in_all_engines(folder, *image, read_csv((folder / run.expected).string()).rows.size());
    if (HasFatalFailure()) return;
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, CaseInEveryEngine, ::testing::ValuesIn(case_names(PLC_CASES)), [](const auto& param) {
  std::string name = param.param;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '/' || c == '-'; }, '_');
  return name;
});

}  // namespace
}  // namespace plc::test
