// What a new user stumbles over: libraries named once, commands in help lines, what is shown by --watch, what is said
// at the start and before it.
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/plc_run.h"
#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

constexpr const char* kTask = R"(
CONFIGURATION C
  RESOURCE R ON PLC
    TASK T(INTERVAL := T#10ms, PRIORITY := 0);
    PROGRAM main WITH T : Main;
  END_RESOURCE
END_CONFIGURATION
)";

/// A project that calls a block of lib/drives.st, and a plc.toml in the folder `etc` that names the library.
struct WithLibrary {
  ScratchFolder scratch;
  std::string project = scratch.file("plant.st"), library = scratch.file("lib/drives.st"),
              configuration = scratch.file("etc/plc.toml");
  WithLibrary() {
    std::filesystem::create_directories(scratch.file("lib"));
    std::filesystem::create_directories(scratch.file("etc"));
    write_text(library,
               "FUNCTION_BLOCK Drive VAR_INPUT Target : REAL; END_VAR VAR_OUTPUT Speed : REAL; END_VAR\n"
               "  Speed := Target; END_FUNCTION_BLOCK\n");
    write_text(project, std::string("PROGRAM Main VAR d : Drive; END_VAR VAR_EXTERNAL Wanted : REAL; END_VAR\n"
                                    "  d(Target := Wanted); END_PROGRAM\n"
                                    "VAR_GLOBAL Wanted : REAL; END_VAR\n") +
                            kTask);
    write_text(configuration, "[project]\nlibraries = [\"../lib/drives.st\"]\n[modbus]\nlisten = \"off\"\n");
  }
};

TEST(ProjectLibraries, JoinForEveryCommandThatTakesTheConfiguration) {
  const WithLibrary f;
  const std::vector<std::vector<std::string>> commands = {
      {PLC_TOOL, "check", f.project, "--config", f.configuration},
      {PLC_TOOL, "sim", f.project, "--cycles", "1", "--config", f.configuration},
      {PLC_TOOL, "compile", f.project, "-o", f.scratch.file("x.pbc"), "--config", f.configuration},
      {PLC_TOOL, "map", f.project, "--config", f.configuration},
      {PLC_TOOL, "dump", f.project, "--config", f.configuration},
      {PLC_TOOL, "explain", f.project, "--config", f.configuration},
      {PLC_TOOL, "explain", f.project, "--flow", "--config", f.configuration},
      {PLC_TOOL, "explain", f.project, "--schedule", "--config", f.configuration},
      {PLC_TOOL, "config", "init", f.project, "--config", f.configuration},
      {PLC_TOOL, "config", "check", f.configuration, f.project},
      plc_run({f.project, "--cycles", "1", "--config", f.configuration}),
  };
  for (const auto& command : commands) {
    const auto result = run_tool(command);
    EXPECT_EQ(result.code, 0) << command_line(command) << "\n" << result.all();
  }
  EXPECT_EQ(run_tool({PLC_TOOL, "check", f.project}).code, 1) << "without it, the block is not known";
  // An image holds what it needs: the libraries are not asked for again.
  const auto image = run_tool({PLC_TOOL, "sim", f.scratch.file("x.pbc"), "--cycles", "1", "--config", f.configuration});
  EXPECT_EQ(image.code, 0) << image.all();
}

TEST(ProjectLibraries, OnesThatAreNotThereAreReportedAtTheirLine) {
  const WithLibrary f;
  write_text(f.configuration, "[project]\nlibraries = [\"../lib/drives.st\", \"pumps.st\"]\n");
  const auto result = run_tool({PLC_TOOL, "check", f.project, "--config", f.configuration});
  EXPECT_EQ(result.code, 1);
  EXPECT_TRUE(has(result.err, f.configuration + ":2:34: error P7001: library")) << result.err;
  EXPECT_TRUE(has(result.err, "pumps.st")) << result.err;
  EXPECT_EQ(run_tool({PLC_TOOL, "config", "check", f.configuration, f.project}).code, 1);
  EXPECT_EQ(run_plant({f.project, "--cycles", "1", "--config", f.configuration}).code, 1);
}

TEST(HelpLines, PrintTheCommandWithItsFlags) {
  const WithLibrary f;
  const auto map = run_tool({PLC_TOOL, "map", f.project, "--lib", f.library, "--profile=overlay"});
  EXPECT_TRUE(has(map.err, "plc map " + f.project + " --profile=overlay --lib " + f.library + " --freeze")) << map.err;
  const auto run = run_plant({f.project, "--lib", f.library, "--cycles", "1", "--modbus", "127.0.0.1:0"});
  ASSERT_EQ(run.code, 0) << run.all();
  EXPECT_TRUE(has(run.out, "plc map " + f.project + " --lib " + f.library + " --freeze")) << run.out;
  const std::string blank = f.scratch.file("two words.st");
  write_text(blank, read_text(f.project));
  const auto quoted = run_tool({PLC_TOOL, "map", blank, "--lib", f.library});
  EXPECT_TRUE(has(quoted.err, "plc map '" + blank + "' --lib")) << quoted.err;
}

// ---- what is shown ----------------------------------------------------------------------------------------------

TEST(Watch, ListsEveryNameOnceAndOnePathForEach) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plant.st");
  write_text(file, std::string("PROGRAM Main VAR Motor AT %QX3.0 : BOOL; Valve AT %QX3.0 : BOOL; n : INT; END_VAR\n"
                               "VAR_EXTERNAL Level : INT; END_VAR\n"
                               "  n := n + 1; Motor := n > 1; Level := n; END_PROGRAM\n"
                               "VAR_GLOBAL Level : INT; A AT %QW0 : INT; B AT %QW0 : INT; END_VAR\n") +
                       kTask);
  const auto names = [&](const std::string& pattern) {
    const auto result = run_tool({PLC_TOOL, "sim", file, "--cycles", "2", "--watch", pattern});
    EXPECT_EQ(result.code, 0) << result.all();
    return result.out.substr(0, result.out.find('\n'));
  };
  EXPECT_EQ(names("*"), "cycle,time_ms,main.n,main.Motor,main.Valve,A,Level,B");
  EXPECT_EQ(names("*Level*"), "cycle,time_ms,Level");
  EXPECT_EQ(names("*Motor*"), "cycle,time_ms,main.Motor");
  EXPECT_EQ(names("*valve*"), "cycle,time_ms,main.Valve");
  EXPECT_EQ(names("%QX3.0"), "cycle,time_ms,%QX3.0");
  EXPECT_EQ(names("main.Level"), "cycle,time_ms,main.Level");
  const auto both = run_tool({PLC_TOOL, "sim", file, "--cycles", "2", "--watch", "*Motor", "--watch", "*Valve"});
  EXPECT_TRUE(has(both.out, "\n1,10,1,1\n")) << both.out;
}

TEST(Watch, ShowsEnumerationsByNameAndTimesAsLiterals) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plant.st");
  write_text(file, std::string("TYPE Step : (Idle, Filling, Draining); END_TYPE\n"
                               "PROGRAM Main VAR s : Step; t : TIME; d : DATE; END_VAR\n"
                               "  s := Filling; t := T#1s500ms; d := D#2024-02-29; END_PROGRAM\n") +
                       kTask);
  const auto watched = run_tool({PLC_TOOL, "sim", file, "--cycles", "1", "--watch", "main.*"});
  EXPECT_TRUE(has(watched.out, "\n0,0,Filling,T#1s500ms,D#2024-02-29\n")) << watched.out;
  const auto traced = run_tool({PLC_TOOL, "sim", file, "--cycles", "1", "--trace", "-"});
  EXPECT_TRUE(has(traced.out, "\n0,0,1,1500000000,")) << traced.out;
  const auto names = run_tool({PLC_TOOL, "sim", file, "--cycles", "1", "--trace", "-", "--values=names"});
  EXPECT_TRUE(has(names.out, "\n0,0,Filling,T#1s500ms,")) << names.out;
  const auto numbers = run_tool({PLC_TOOL, "sim", file, "--cycles", "1", "--watch", "main.s", "--values=numbers"});
  EXPECT_TRUE(has(numbers.out, "\n0,0,1\n")) << numbers.out;
  const auto live = run_plant({file, "--cycles", "30", "--watch", "main.*"});
  EXPECT_TRUE(has(live.out, "main.s=Filling main.t=T#1s500ms main.d=D#2024-02-29")) << live.out;
}

TEST(Stimulus, TakesEnumerationValuesByName) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plant.st"), stimulus = scratch.file("in.csv");
  write_text(file, std::string("TYPE Step : (Idle, Filling, Draining); END_TYPE\n"
                               "PROGRAM Main VAR s : Step; n : INT; END_VAR n := n + 1; END_PROGRAM\n") +
                       kTask);
  write_text(stimulus, "time_ms,main.s\n0,filling\n10,Step#Draining\n20,Step.Idle\n30,2\n");
  const auto result = run_tool({PLC_TOOL, "sim", file, "--stimulus", stimulus, "--watch", "main.s"});
  EXPECT_EQ(result.code, 0) << result.all();
  EXPECT_TRUE(has(result.out, "\n0,0,Filling\n1,10,Draining\n2,20,Idle\n3,30,Draining\n")) << result.out;
  write_text(stimulus, "time_ms,main.s\n0,Stop#Idle\n");
  EXPECT_EQ(run_tool({PLC_TOOL, "sim", file, "--stimulus", stimulus}).code, 1);
}

TEST(Paths, AreSuggested) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plant.st"), stimulus = scratch.file("in.csv");
  write_text(file, std::string("PROGRAM Main VAR Start AT %IX0.0 : BOOL; Motor AT %QX0.0 : BOOL; t : TON; END_VAR\n"
                               "  t(IN := Start, PT := T#1s); Motor := t.Q; END_PROGRAM\n") +
                       kTask);
  const auto help = [&](const std::string& path) {
    write_text(stimulus, "time_ms," + path + "\n0,1\n");
    const auto result = run_tool({PLC_TOOL, "sim", file, "--stimulus", stimulus});
    EXPECT_EQ(result.code, 1) << path;
    return result.err;
  };
  EXPECT_TRUE(has(help("START"), "did you mean \"main.Start\"?"));
  EXPECT_TRUE(has(help("instance0.start"), "did you mean \"main.Start\"?"));
  EXPECT_TRUE(has(help("Plant.t.PT"), "did you mean \"main.t.PT\"?"));
  EXPECT_TRUE(has(help("Strat"), "did you mean \"main.Start\"?"));
  EXPECT_FALSE(has(help("Pressure"), "did you mean"));
}

// ---- what is said ------------------------------------------------------------------------------------------------

TEST(Taskblocks, LookAtTheirConfigurationWhenTheProjectIsChecked) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plant.st");
  const auto with = [&](const std::string& points) {
    write_text(file, "PROGRAM Main\nVAR\n  curve : LOOKUP_TABLE := (POINTS := 3, X := [" + points +
                         "]);\n  y : LREAL;\nEND_VAR\n  curve(IN := y);\n  y := curve.OUT;\nEND_PROGRAM\n" + kTask);
    return run_tool({PLC_TOOL, "check", file});
  };
  EXPECT_EQ(with("0.0, 1.0, 2.0").code, 0);
  const auto wrong = with("0.0, 2.0, 1.0");
  EXPECT_EQ(wrong.code, 1) << wrong.all();
  EXPECT_TRUE(has(wrong.err, file + ":3:3: error P7803: taskblock LOOKUP_TABLE of main.curve: ")) << wrong.err;
  EXPECT_TRUE(has(wrong.err, "[POU Main]")) << wrong.err;
  EXPECT_TRUE(has(wrong.out, "plant.st: 1 error")) << wrong.out;
}

TEST(Taskblocks, ACheckLeavesNoFilesOfLoggers) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plant.st"), folder = scratch.file("logs");
  std::filesystem::create_directories(folder);
  write_text(file, std::string("PROGRAM Main VAR log : FILE_LOGGER; END_VAR log(IN1 := 1.0); END_PROGRAM\n") + kTask);
  const auto result = run_tool({"/bin/sh", "-c", "cd '" + folder + "' && '" PLC_TOOL "' check ../plant.st"});
  EXPECT_EQ(result.code, 0) << result.all();
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

TEST(Lints, AreNotRepeatedByCommandsThatAnswerQuestions) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("coils.xml");
  const std::string coil =
      R"(<connectionPointIn><connection refLocalId="1"/></connectionPointIn><variable>Out</variable></coil>)";
  write_text(file, small_project(true, R"(<LD>
<leftPowerRail localId="1"><position x="0" y="0"/><connectionPointOut formalParameter=""/></leftPowerRail>
<coil localId="3"><position x="100" y="0"/>)" +
                                           coil + R"(<coil localId="4"><position x="100" y="50"/>)" + coil + "</LD>"));
  const auto err = [&](std::vector<std::string> command) {
    const auto result = run_tool(command);
    EXPECT_EQ(result.code, 0) << command_line(command) << "\n" << result.all();
    return result.err;
  };
  EXPECT_TRUE(has(err({PLC_TOOL, "check", file}), "P2002"));
  EXPECT_TRUE(has(err({PLC_TOOL, "compile", file, "-o", scratch.file("x.pbc")}), "P2002"));
  EXPECT_FALSE(has(err({PLC_TOOL, "map", file}), "P2002"));
  EXPECT_FALSE(has(err({PLC_TOOL, "explain", file, "--flow"}), "P2002"));
  EXPECT_FALSE(has(err({PLC_TOOL, "explain", file, "--schedule"}), "P2002"));
  EXPECT_FALSE(has(err({PLC_TOOL, "config", "init", file}), "P2002"));
  EXPECT_FALSE(has(err({PLC_TOOL, "dump", file}), "P2002"));
}

TEST(Names, DeclaredTwiceSayWhereTheFirstOneIs) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plant.st"), library = scratch.file("lib.st");
  write_text(file,
             "TYPE Step : (Idle, Run,\n Idle); END_TYPE\n"
             "TYPE Pair : STRUCT a : INT;\n A : INT; END_STRUCT; END_TYPE\n"
             "PROGRAM Main VAR n : INT;\n N : INT; END_VAR n := 1; END_PROGRAM\n"
             "VAR_GLOBAL g : INT;\n G : INT; END_VAR\n"
             "FUNCTION F : INT F := 1; END_FUNCTION\nFUNCTION f : INT F := 1; END_FUNCTION\n");
  const auto result = run_tool({PLC_TOOL, "check", file});
  EXPECT_EQ(result.code, 1);
  for (const char* found :
       {"\"Idle\" of \"Step\" is declared twice, first at line 1",
        "\"A\" of \"Pair\" is declared twice, first at line 3", "variable \"N\" is declared twice, first at line 5",
        "global variable \"G\" is declared twice, first at line 7", "POU \"f\" is declared twice, first at line 9"}) {
    EXPECT_TRUE(has(result.err, found)) << found << " is not in\n" << result.err;
  }
}

TEST(Names, OfTheLibraryAreNotHiddenWithoutAWord) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plant.st"), library = scratch.file("lib.st");
  const auto pou = [](const std::string& name) {
    return "FUNCTION_BLOCK " + name + " VAR_INPUT a : INT; END_VAR VAR b : INT; END_VAR b := a; END_FUNCTION_BLOCK\n";
  };
  std::string text;
  for (const char* name : {"RAMP", "PID", "LAG1", "HYSTERESIS", "INTEGRAL", "DELAY", "SEMA", "RTC", "TON"})
    text += pou(name);
  write_text(library, text);
  const auto own = run_tool({PLC_TOOL, "check", "--lint=none", library});
  EXPECT_EQ(own.code, 0) << own.all();
  EXPECT_TRUE(has(own.out, "10 warnings")) << own.all();  // and that nothing is instantiated
  EXPECT_TRUE(has(own.err, "P4019: functionBlock \"RAMP\" hides the function block of this name in the library"))
      << own.err;
  EXPECT_TRUE(has(own.err, "P4019: functionBlock \"DELAY\" hides the function of this name in the library")) << own.err;
  EXPECT_TRUE(has(own.err, "P4019: functionBlock \"TON\" hides the standard function block")) << own.err;
  // Who names a library means what it has.
  write_text(file, std::string("PROGRAM Main VAR r : RAMP; END_VAR r(a := 1); END_PROGRAM\n") + kTask);
  const auto joined = run_tool({PLC_TOOL, "check", file, "--lib", library});
  EXPECT_EQ(joined.code, 0) << joined.all();
  EXPECT_FALSE(has(joined.err, "\"RAMP\"")) << joined.err;
  const auto without = run_tool({PLC_TOOL, "check", file});
  EXPECT_TRUE(has(without.err, "plc lib RAMP") && has(without.err, "--lib FILE")) << without.err;
}

TEST(Names, OfEnumerationValuesAreGuessed) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plant.st");
  const auto help = [&](const std::string& statement) {
    write_text(file, "TYPE Step : (Idle, Filling, Draining); END_TYPE\nPROGRAM Main VAR s : Step; b : BOOL; END_VAR\n" +
                         statement + " END_PROGRAM\n");
    const auto result = run_tool({PLC_TOOL, "check", file});
    EXPECT_EQ(result.code, 1) << statement;
    return result.err;
  };
  for (const char* statement : {"s := Fillin;", "s := Step#Fillin;", "s := Step.Fillin;", "b := s = Fillin;",
                                "CASE s OF Fillin: b := TRUE; END_CASE;"}) {
    EXPECT_TRUE(has(help(statement), "did you mean \"Filling\"?")) << statement << "\n" << help(statement);
  }
}

TEST(SimulateIo, RunsAConfigurationWithoutItsDevices) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plant.st"), configuration = scratch.file("plc.toml");
  write_text(file, std::string("PROGRAM Main VAR Start AT %IX0.0 : BOOL; Motor AT %QX0.0 : BOOL; n : INT; END_VAR\n"
                               "  Motor := Start; n := n + 1; END_PROGRAM\n") +
                       kTask);
  write_text(configuration,
             "[drivers.panel]\nkind = \"gpio\"\nchip = \"gpiochip99\"\n[modbus]\nlisten = \"off\"\n[inputs]\n"
             "\"%IX0.0\" = { driver = \"panel\", channel = 17, bias = \"pull-up\", latch = \"rising\" }\n"
             "[outputs]\n\"%QX0.0\" = { driver = \"panel\", channel = 22, drive = \"open-drain\" }\n");
  const auto without = run_plant({file, "--config", configuration, "--cycles", "3"});
  EXPECT_EQ(without.code, 4);
  EXPECT_TRUE(has(without.err, "P7401")) << without.err;
  write_text(scratch.file("in.csv"), "time_ms,%IX0.0\n0,1\n");
  const auto result = run_plant({file, "--config", configuration, "--cycles", "30", "--simulate-io", "--stimulus",
                                 scratch.file("in.csv"), "--watch", "main.Motor"});
  EXPECT_EQ(result.code, 0) << result.all();
  EXPECT_TRUE(has(result.out, "--simulate-io: no device is touched")) << result.out;
  EXPECT_TRUE(has(result.out, "main.Motor=1")) << result.out;
}

}  // namespace
}  // namespace plc::test
