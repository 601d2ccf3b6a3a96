// What plc-run says of tasks that may or will miss their deadlines.
#include "io-drivers/config/check_schedule.h"

#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "io-drivers/config/plan_tasks.h"
#include "io-drivers/machine/driver_types.h"

namespace plc::test {
namespace {

/// An image of two tasks that do nothing, "Fast" every 1 ms and "Slow" every 10 ms.
bytecode::Image two_tasks() {
  bytecode::Image image;
  image.types.emplace_back().kind = bytecode::TypeKind::kStruct;
  bytecode::ImagePou body;
  body.kind = bytecode::PouKind::kTask;
  body.code = {bytecode::opcode_word(bytecode::Opcode::kReturn)};
  image.pous.push_back(body);
  image.tasks.push_back({"Fast", 1'000'000, 0, {}, 0});
  image.tasks.push_back({"Slow", 10'000'000, 1, {}, 0});
  return image;
}

std::string said(const std::string& toml) {
  const bytecode::Image image = two_tasks();
  core::Diagnostics diagnostics;
  const auto configuration = io::read_configuration(toml, "plc.toml", io::driver_types(), diagnostics);
  EXPECT_TRUE(configuration.has_value());
  if (configuration) {
    const std::vector<int> cpus = {0, 1};
    const auto plan = io::plan_tasks(*configuration, image, cpus, runtime::FaultPolicy::kStop, diagnostics);
    EXPECT_TRUE(plan.has_value());
    if (plan) io::check_schedule(*configuration, image, *plan, cpus, diagnostics);
  }
  std::ostringstream out;
  diagnostics.render(out);
  return out.str();
}

TEST(CheckSchedule, SaysNothingOfWhatFits) {
  EXPECT_EQ(said(""), "");
  EXPECT_EQ(said("[tasks.Fast]\nexecution = \"830us\"\ncpu = 0\n[tasks.Slow]\nexecution = \"500us\"\ncpu = 0\n"), "");
}

TEST(CheckSchedule, WarnsOfWhatMayMiss) {
  // 60 us is less than the release of a scan takes, at the estimate's margin.
  const std::string early = said("[tasks.Slow]\ndeadline = \"1us\"\n");
  EXPECT_NE(early.find("plc.toml:1:"), std::string::npos) << early;
  EXPECT_NE(early.find("warning P7605: task \"Slow\" may end "), std::string::npos) << early;
  EXPECT_NE(early.find("its deadline is 1000 ns (estimated, with a margin of 100 %)"), std::string::npos) << early;
  // Tasks that may run anywhere are refused only when there is no room anywhere.
  const std::string behind = said("[tasks.Fast]\nexecution = \"900us\"\n[tasks.Slow]\nexecution = \"2ms\"\n");
  EXPECT_NE(
      behind.find("warning P7605: task \"Slow\" may fall behind without end: with the tasks before it, it needs 12"),
      std::string::npos)
      << behind;
}

TEST(CheckSchedule, LeadsAreWarnedOfAndNeverRefused) {
  const std::string tasks =
      "[tasks.Fast]\nexecution = \"700us\"\ncpu = 0\n[tasks.Slow]\nexecution = \"500us\"\ncpu = 0\n";
  EXPECT_EQ(said(tasks), "");
  const std::string warned = said("[scheduler]\nlead = \"250us\"\n" + tasks);
  EXPECT_NE(warned.find("warning P7605: task \"Slow\""), std::string::npos) << warned;
  EXPECT_EQ(warned.find("P7606"), std::string::npos) << "a task that is late has no lead\n" << warned;
}

TEST(CheckSchedule, RefusesWhatCannotFitByMeasuredTimes) {
  const std::string both = "[tasks.Fast]\nexecution = \"900us\"\ncpu = 1\n[tasks.Slow]\nexecution = \"2ms\"\ncpu = 1\n";
  const std::string refused = said(both);
  EXPECT_NE(refused.find("plc.toml:4:8: error P7606: task \"Slow\" cannot meet its deadline"), std::string::npos)
      << refused;
  EXPECT_EQ(refused.find("P7605"), std::string::npos) << refused;
  const std::string forced = said("[scheduler]\nunfit = \"run\"\n" + both);
  EXPECT_NE(forced.find("warning P7605: task \"Slow\" cannot meet its deadline"), std::string::npos) << forced;
  EXPECT_EQ(forced.find("P7606"), std::string::npos) << forced;
}

TEST(CheckSchedule, ACalibrationThatIsNoneIsAnError) {
  const std::string text = said("[scheduler]\ncalibration = \"nothing.toml\"\n");
  EXPECT_NE(text.find("plc.toml:2:"), std::string::npos) << text;
  EXPECT_NE(text.find("error P7607: calibration \"nothing.toml\" cannot be opened"), std::string::npos) << text;
}

}  // namespace
}  // namespace plc::test
