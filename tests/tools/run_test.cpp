// plc-run in real time. Times are not judged here, only that it starts, stops and says what it did.
#include <gtest/gtest.h>

#include <csignal>
#include <string>

#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

TEST(Run, EndsAfterItsCyclesWithATable) {
  const auto result = run_tool({PLC_RUN_TOOL, tank(), "--cycles", "5", "--stats"});
  ASSERT_EQ(result.code, 0) << result.err;
  for (const char* word : {"options: order=drawing", "task Fast: every 20ms", "real time: ", "cycles", "period", "jitter",
                           "overruns", "MB resident"}) {
    EXPECT_NE(result.out.find(word), std::string::npos) << word << " is not in\n" << result.out;
  }
  const std::size_t row = result.out.find("\nFast");
  ASSERT_NE(row, std::string::npos) << result.out;
  EXPECT_NE(result.out.find(" 5 ", row), std::string::npos) << result.out;
}

TEST(Run, EndsAfterItsDuration) {
  const auto result = run_tool({PLC_RUN_TOOL, tank(), "--duration", "150ms"});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("overruns"), std::string::npos);
}

TEST(Run, RunsAnImage) {
  const ScratchFolder scratch;
  ASSERT_EQ(run_tool({PLC_TOOL, "compile", tank(), "-o", scratch.file("tank.pbc")}).code, 0);
  EXPECT_EQ(run_tool({PLC_RUN_TOOL, scratch.file("tank.pbc"), "--cycles", "2"}).code, 0);
}

TEST(Run, StopsInGoodOrderOnSignals) {
  for (const char* signal : {"INT", "TERM"}) {
    // The shell sends the signal half a second after the start.
    const std::string script = std::string("'") + PLC_RUN_TOOL + "' '" + tank() + "' & p=$!; sleep 0.5; kill -" + signal +
                               " $p; wait $p";
    const auto result = run_tool({"/bin/bash", "-c", "set -m; " + script});
    EXPECT_EQ(result.code, 0) << signal << ": " << result.all();
    EXPECT_NE(result.out.find("overruns"), std::string::npos) << signal << ": " << result.all();
  }
}

TEST(Run, ShowsWhatChangesWithoutATerminal) {
  const auto result = run_tool({PLC_RUN_TOOL, tank(), "--stimulus", tank_stimulus(), "--duration", "1200ms", "--watch",
                                "Running", "--watch", "Sequence.StepA"});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("Running=0"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("Running=1"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("Sequence.StepA=1"), std::string::npos) << result.out;
  EXPECT_EQ(result.out.find("\x1b["), std::string::npos) << "escape sequences in a pipe";
}

TEST(Run, WrongDurationIsAUsageError) {
  for (const char* duration : {"0s", "-5s", "soon", "10 parsecs"}) {
    EXPECT_EQ(run_tool({PLC_RUN_TOOL, tank(), std::string("--duration=") + duration}).code, 2) << duration;
  }
}

}  // namespace
}  // namespace plc::test
