// Alarms of plc-run: when scans were to be recorded, and cannot be; of a program on trial.
#include "tools/plc-run/alarm_service.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "compiler/compile.h"
#include "runtime/resource.h"
#include "tests/tools/fixture.h"

namespace plc::tools {
namespace {

/// Alarms on a global, "High", and on a variable of a program, "Late".
std::unique_ptr<runtime::Resource> plant(const test::ScratchFolder& scratch) {
  test::write_text(scratch.file("plant.st"),
                   "VAR_GLOBAL Level : INT; END_VAR\n"
                   "PROGRAM Main VAR_EXTERNAL Level : INT; END_VAR VAR Scans : INT; END_VAR\n"
                   "  Level := Level + 1; Scans := Scans + 1;\nEND_PROGRAM\n"
                   "CONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#10ms, PRIORITY := 0);\n"
                   "  PROGRAM main WITH T : Main; END_RESOURCE END_CONFIGURATION\n");
  test::write_text(scratch.file("alarms.toml"),
                   "[[alarm]]\nname = \"High\"\ntext = \"high\"\nvariable = \"Level\"\nabove = 10.0\n"
                   "[[alarm]]\nname = \"Late\"\ntext = \"late\"\nvariable = \"main.Scans\"\nabove = 10.0\n");
  compiler::Compilation compilation;
  compiler::compile({scratch.file("plant.st"), {}, compiler::Goal::kRun}, compilation);
  EXPECT_TRUE(compilation.image);
  return std::move(*runtime::Resource::load(std::move(*compilation.image)));
}

TEST(AlarmService, SaysWhatIsLeftOutWithoutARecording) {
  const test::ScratchFolder scratch;
  const auto resource = plant(scratch);
  AlarmService service(scratch.file("alarms.toml"), *resource, /*recorded=*/true);
  ASSERT_EQ(service.alarms()->count(), 2u);
  std::vector<engineering::Said> said;
  service.open({}, nullptr, said);
  EXPECT_EQ(service.alarms()->count(), 1u);
  EXPECT_TRUE(service.alarms()->has("High"));
  const auto left_out = std::find_if(said.begin(), said.end(), [](const engineering::Said& one) {
    return one.text.find("P7720") != std::string::npos;
  });
  ASSERT_NE(left_out, said.end());
  EXPECT_EQ(left_out->severity, core::Severity::kWarning);
  EXPECT_EQ(left_out->text, "alarms: P7720: left out, since scans are not recorded: Late");
  service.stop(true);
}

TEST(AlarmService, KeepsNothingOfAProgramThatMayGiveWay) {
  const test::ScratchFolder scratch;
  std::vector<engineering::Said> said;
  const auto was_shelved = [&](bool settled, bool settled_at_the_end) {
    const auto resource = plant(scratch);
    AlarmService service(scratch.file("alarms.toml"), *resource, /*recorded=*/false);
    service.open(scratch.file("state"), nullptr, said);
    const auto state = service.alarms()->list(true).front().state;
    EXPECT_TRUE(service.alarms()->shelve("High", 10'000'000'000, {"anna", "trial", 0, 0}));
    service.service(0, 0, settled, said);
    service.stop(settled_at_the_end);
    return state == alarms::State::kShelved;
  };
  EXPECT_FALSE(was_shelved(false, false));
  EXPECT_FALSE(was_shelved(false, true)) << "the trial before left nothing";
  EXPECT_TRUE(was_shelved(true, true)) << "that it stays was known at the end";
}

}  // namespace
}  // namespace plc::tools
