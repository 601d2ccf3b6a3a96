// --date, --zone and SET_CLOCK: the date and time that programs have in virtual time.
#include <gtest/gtest.h>

#include <string>

#include "tests/support/plc_run.h"
#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

const char* const kProject =
    "PROGRAM Main VAR D, L : DT; T1 : TON; END_VAR\n"
    "  D := UTC_DT(); L := LOCAL_DT(); T1(IN := TRUE, PT := T#1s);\n"
    "END_PROGRAM\n"
    "CONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#10ms, PRIORITY := 0);\n"
    "  PROGRAM main WITH T : Main; END_RESOURCE END_CONFIGURATION\n";
const char* const kTests =
    "TEST 'begins with --date'\n"
    "  ASSERT_EQ(DT#2026-01-01-12:00:00, UTC_DT());\n"
    "  RUN_CYCLES(1);\n"
    "  ASSERT_EQ(DT#2026-01-01-12:00:00, main.D);\n"
    "  ASSERT_EQ(DT#2026-01-01-13:00:00, main.L);\n"
    "END_TEST\n"
    "TEST 'is set, and timers go on'\n"
    "  RUN_CYCLES(50);\n"
    "  SET_CLOCK(DT#2026-03-29-00:59:59.5);\n"
    "  ASSERT_EQ(DT#2026-03-29-00:59:59.5, UTC_DT());\n"
    "  RUN_CYCLES(1);\n"
    "  ASSERT_EQ(DT#2026-03-29-00:59:59.5, main.D);\n"
    "  ASSERT_FALSE(main.T1.Q);\n"
    "  ADVANCE_TIME(T#500ms);\n"
    "  ASSERT_EQ(DT#2026-03-29-03:00:00, main.L);\n"
    "  ASSERT_TRUE(main.T1.Q);\n"
    "  SET_CLOCK(LDT#1970-01-01-00:00:00);\n"
    "  RUN_CYCLES(1);\n"
    "  ASSERT_TRUE(main.T1.Q);\n"
    "END_TEST\n";
const char* const kZone = "CET-1CEST,M3.5.0,M10.5.0/3";

class DateOptions : public testing::Test {
 protected:
  void SetUp() override {
    write_text(scratch.file("plant.st"), kProject);
    write_text(scratch.file("plant_test.st"), kTests);
  }
  ScratchFolder scratch;
};

TEST_F(DateOptions, AreThoseOfTests) {
  const auto result =
      run_tool({PLC_TOOL, "test", scratch.file("plant_test.st"), "--date", "2026-01-01T12:00:00", "--zone", kZone});
  EXPECT_EQ(result.code, 0) << result.all();
  EXPECT_NE(result.out.find("2 tests, 0 failed"), std::string::npos) << result.all();
  EXPECT_EQ(run_tool({PLC_TOOL, "test", scratch.file("plant_test.st")}).code, 1) << "1970, UTC";
}

TEST_F(DateOptions, AreThoseOfASimulationInEveryEngine) {
  for (const char* const engine : {"interp", "native"}) {
    const auto result =
        run_tool({PLC_TOOL, "sim", scratch.file("plant.st"), "--date", "2026-03-29 00:59:59.99", "--zone", kZone,
                  "--cycles", "3", "--watch", "main.D", "--watch", "main.L", "--engine", engine});
    EXPECT_EQ(result.code, 0) << result.all();
    EXPECT_NE(result.out.find("0,0,DT#2026-03-29-00:59:59.99,DT#2026-03-29-01:59:59.99\n"
                              "1,10,DT#2026-03-29-01:00:00,DT#2026-03-29-03:00:00\n"
                              "2,20,DT#2026-03-29-01:00:00.01,DT#2026-03-29-03:00:00.01\n"),
              std::string::npos)
        << result.all();
  }
}

TEST_F(DateOptions, ThatAreWrongAreRefused) {
  for (const char* const command : {"sim", "test"}) {
    const auto date = run_tool({PLC_TOOL, command, scratch.file("plant.st"), "--date", "tomorrow"});
    EXPECT_EQ(date.code, 2);
    EXPECT_NE(date.err.find("--date \"tomorrow\" is not a date and time\n"), std::string::npos) << date.all();
    const auto zone = run_tool({PLC_TOOL, command, scratch.file("plant.st"), "--zone", "Nowhere"});
    EXPECT_EQ(zone.code, 2);
    EXPECT_NE(zone.err.find("there is no time zone \"Nowhere\" on this machine\n"), std::string::npos) << zone.all();
  }
}

TEST_F(DateOptions, APlantHasTheZoneOfItsConfiguration) {
  write_text(scratch.file("plc.toml"), "[modbus]\nlisten = \"off\"\n[clock]\nzone = \"XYZ-5\"\n");
  write_text(scratch.file("zone.st"),
             "PROGRAM Main VAR Offset : TIME; Clock : SYS_TIME; END_VAR Clock(); Offset := Clock.OFFSET; END_PROGRAM\n"
             "CONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#10ms, PRIORITY := 0);\n"
             "  PROGRAM main WITH T : Main; END_RESOURCE END_CONFIGURATION\n");
  const auto result = run_plant(
      {scratch.file("zone.st"), "--config", scratch.file("plc.toml"), "--duration", "600ms", "--watch", "main.Offset"});
  EXPECT_EQ(result.code, 0) << result.all();
  EXPECT_NE(result.out.find("main.Offset=T#5h"), std::string::npos) << result.all();
}

}  // namespace
}  // namespace plc::test
