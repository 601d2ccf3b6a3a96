// Files of Structured Text on every command.
#include <gtest/gtest.h>

#include "tests/support/plc_run.h"
#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

constexpr const char* kPlant = R"(VAR_GLOBAL speed : INT := 4; full AT %QX0.0 : BOOL; END_VAR
FUNCTION_BLOCK Part
VAR_INPUT go : BOOL R_EDGE; END_VAR
VAR k : INT := 7; END_VAR
END_FUNCTION_BLOCK
PROGRAM Filler
VAR_INPUT Speed, Mode : INT; END_VAR
VAR_OUTPUT Full : BOOL := TRUE; END_VAR
VAR p : Part; END_VAR
END_PROGRAM
CONFIGURATION Plant
  RESOURCE Cell ON PLC
    TASK Fast (INTERVAL := T#10ms, PRIORITY := 1);
    PROGRAM Line1 WITH Fast : Filler (Speed := speed, Mode := 3, Full => full);
  END_RESOURCE
  VAR_CONFIG Cell.Line1.p.k : INT := 9; END_VAR
END_CONFIGURATION
)";

struct Plant {
  ScratchFolder scratch;
  std::string file = scratch.file("plant.st");
  Plant() { write_text(file, kPlant); }
};

TEST(StructuredText, EveryCommandTakesIt) {
  const Plant plant;
  const auto check = run_tool({PLC_TOOL, "check", plant.file});
  EXPECT_EQ(check.code, 0) << check.all();
  EXPECT_NE(check.out.find("plant.st: ok"), std::string::npos) << check.out;
  const auto report = run_tool({PLC_TOOL, "report", plant.file});
  EXPECT_EQ(report.code, 0) << report.err;
  EXPECT_NE(report.out.find("Structured Text"), std::string::npos) << report.out;
  EXPECT_NE(report.out.find("program instance"), std::string::npos) << report.out;
  const std::string image = plant.scratch.file("plant.pbc");
  EXPECT_EQ(run_tool({PLC_TOOL, "compile", plant.file, "-o", image}).code, 0);
  const auto listing = run_tool({PLC_TOOL, "dump", plant.file});
  EXPECT_EQ(listing.code, 0) << listing.err;
  EXPECT_EQ(listing.out, run_tool({PLC_TOOL, "dump", image}).out);
  EXPECT_EQ(run_tool({PLC_TOOL, "explain", plant.file}).code, 0);
  EXPECT_EQ(run_tool({PLC_TOOL, "map", plant.file}).code, 0);
  const std::string toml = plant.scratch.file("plc.toml");
  EXPECT_EQ(run_tool({PLC_TOOL, "config", "init", plant.file, "-o", toml}).code, 0);
  const auto config = run_tool({PLC_TOOL, "config", "check", toml, plant.file});
  EXPECT_EQ(config.code, 0) << config.all();
  const auto run = run_plant({plant.file, "--duration", "50ms"});
  EXPECT_EQ(run.code, 0) << run.all();
}

TEST(StructuredText, ConnectionsAndConfiguredValuesReachTheInstance) {
  const Plant plant;
  const std::string trace = plant.scratch.file("trace.csv");
  const auto sim = run_tool(
      {PLC_TOOL, "sim", plant.file, "--cycles", "2", "--trace", trace, "--watch", "Line1.*", "--watch", "full"});
  ASSERT_EQ(sim.code, 0) << sim.all();
  const std::string text = read_text(trace);
  EXPECT_EQ(text,
            "cycle,time_ms,Line1.Speed,Line1.Mode,Line1.Full,Line1.p.go,Line1.p.k,full\n"
            "0,0,4,3,1,0,9,1\n"
            "1,10,4,3,1,0,9,1\n");
}

constexpr const char* kLoops = R"(PROGRAM Bad
VAR n : DINT; END_VAR
  WHILE TRUE DO
    n := n + 1;
  END_WHILE;
END_PROGRAM
PROGRAM Good
VAR i, n : DINT; END_VAR
  FOR i := 1 TO 50 DO n := n + 1; END_FOR;
END_PROGRAM
CONFIGURATION Plant
  RESOURCE Cell ON PLC
    TASK First (INTERVAL := T#10ms, PRIORITY := 0);
    TASK Second (INTERVAL := T#10ms, PRIORITY := 1);
    PROGRAM B WITH First : Bad;
    PROGRAM G WITH Second : Good;
  END_RESOURCE
END_CONFIGURATION
)";

TEST(StructuredText, AnEndlessLoopStopsItsTaskAtItsLineAndTheOtherGoesOn) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("loops.st");
  write_text(file, kLoops);
  for (const char* budget : {"100", "70000"}) {
    const auto sim = run_tool({PLC_TOOL, "sim", file, "--loop-budget", budget, "--cycles", "3", "--watch", "*.n"});
    EXPECT_EQ(sim.code, 1) << sim.all();
    EXPECT_NE(sim.err.find("fault R1001: loop budget exhausted in task First, cycle 0, at "), std::string::npos)
        << sim.err;
    EXPECT_NE(sim.err.find("loops.st:3"), std::string::npos) << sim.err;
    EXPECT_NE(sim.out.find("2,20," + std::string(budget) + ",150"), std::string::npos) << sim.out;
  }
  const auto run = run_plant({file, "--loop-budget", "100", "--duration", "100ms"});
  EXPECT_EQ(run.code, 1) << run.all();
  EXPECT_NE(run.err.find("fault R1001"), std::string::npos) << run.err;
  // The loop of the other task is too long for this one.
  const auto both = run_tool({PLC_TOOL, "sim", file, "--loop-budget", "10", "--cycles", "1"});
  EXPECT_NE(both.err.find("in task Second"), std::string::npos) << both.err;
  EXPECT_EQ(run_tool({PLC_TOOL, "sim", file, "--loop-budget", "0"}).code, 2);
  EXPECT_EQ(run_tool({PLC_TOOL, "sim", file, "--loop-budget", "5000000000"}).code, 2);
}

// Table 53 of the third edition: the body sees the edge, once, also when the input is not given again.
TEST(StructuredText, AfterTheOnlyTaskFaultedRunsEndAndTimeGoesOnAsItWould) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("only.st");
  std::ofstream(file) << R"(PROGRAM Main
VAR n : INT; END_VAR
n := n + 1;
WHILE n = 3 DO ; END_WHILE;
END_PROGRAM
CONFIGURATION C
  TASK T(INTERVAL := T#50ms, PRIORITY := 1);
  PROGRAM main WITH T : Main;
END_CONFIGURATION
)";
  const auto sim = run_tool({PLC_TOOL, "sim", file, "--loop-budget", "100", "--cycles", "5", "--watch", "main.n"});
  EXPECT_EQ(sim.code, 1) << sim.all();
  EXPECT_EQ(sim.out, "cycle,time_ms,main.n\n0,0,1\n1,50,2\n2,100,3\n3,150,3\n4,200,3\n") << sim.all();
  // Without its task the run has nothing left to count.
  const auto run = run_plant({file, "--loop-budget", "100", "--cycles", "1000000"});
  EXPECT_EQ(run.code, 1) << run.all();
  EXPECT_NE(run.err.find("fault R1001"), std::string::npos) << run.err;
}

TEST(StructuredText, EdgeInputsAreTrueForOneCall) {
  const ScratchFolder scratch;
  write_text(scratch.file("edges.st"), R"(FUNCTION_BLOCK Count
VAR_INPUT up : BOOL R_EDGE; down : BOOL F_EDGE; END_VAR
VAR_OUTPUT ups, downs : INT; END_VAR
  IF up THEN ups := ups + 1; END_IF;
  IF down THEN downs := downs + 1; END_IF;
END_FUNCTION_BLOCK
PROGRAM Main
VAR c : Count; n : INT; END_VAR
  n := n + 1;
  IF n <> 5 THEN c(up := n >= 3 AND n < 7, down := n >= 3 AND n < 7); ELSE c(); END_IF;
END_PROGRAM
)");
  const std::string trace = scratch.file("trace.csv");
  const auto sim = run_tool({PLC_TOOL, "sim", scratch.file("edges.st"), "--pou", "Main", "--cycles", "8", "--trace",
                             trace, "--watch", "Main.c.ups", "--watch", "Main.c.downs", "--watch", "Main.c.up"});
  ASSERT_EQ(sim.code, 0) << sim.all();
  // F_TRIG of the standard sees a falling edge in its first call.
  EXPECT_EQ(read_text(trace),
            "cycle,time_ms,Main.c.ups,Main.c.downs,Main.c.up\n"
            "0,0,0,1,0\n1,20,0,1,0\n2,40,1,1,1\n3,60,1,1,1\n4,80,1,1,1\n5,100,1,1,1\n6,120,1,2,0\n7,140,1,2,0\n");
}

TEST(StructuredText, IsKnownByItsNameOrItsContent) {
  const ScratchFolder scratch;
  for (const char* name : {"a.ST", "b.iecst", "c.txt", "noextension"}) {
    write_text(scratch.file(name), kPlant);
    EXPECT_EQ(run_tool({PLC_TOOL, "check", scratch.file(name)}).code, 0) << name;
  }
  write_text(scratch.file("project"), read_text(tank()));
  EXPECT_EQ(run_tool({PLC_TOOL, "check", scratch.file("project")}).code, 0);
  write_text(scratch.file("wrong.xml"), kPlant);
  const auto xml = run_tool({PLC_TOOL, "check", scratch.file("wrong.xml")});
  EXPECT_EQ(xml.code, 1);
  EXPECT_NE(xml.err.find("P1002"), std::string::npos) << xml.err;
}

TEST(StructuredText, MessagesShowTheLineAndACaret) {
  const ScratchFolder scratch;
  write_text(scratch.file("p.st"), "PROGRAM P\nVAR\n\tx : Nix;\nEND_VAR\nEND_PROGRAM\n");
  const auto check = run_tool({PLC_TOOL, "check", scratch.file("p.st")});
  EXPECT_EQ(check.code, 1);
  EXPECT_NE(check.err.find("p.st:3:6: error P4014"), std::string::npos) << check.err;
  EXPECT_NE(check.err.find("\n 3 | \tx : Nix;\n   | \t    ^\n  help: "), std::string::npos) << check.err;
  const auto json = run_tool({PLC_TOOL, "check", "--json", scratch.file("p.st")});
  EXPECT_EQ(json.out.find('^'), std::string::npos) << json.out;
}

}  // namespace
}  // namespace plc::test
