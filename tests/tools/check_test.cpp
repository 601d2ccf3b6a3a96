#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

TEST(Check, ExampleCompilesWithoutAWord) {
  const auto result = run_tool({PLC_TOOL, "check", tank()});
  EXPECT_EQ(result.code, 0);
  EXPECT_EQ(result.err, "");
  EXPECT_NE(result.out.find("ok"), std::string::npos) << result.out;
}

TEST(Check, ErrorsGoToStderrWithPlaceAndElement) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("bad.xml");
  write_text(file, small_project(true, kUnknownVariableBody));
  const auto result = run_tool({PLC_TOOL, "check", file});
  EXPECT_EQ(result.code, 1);
  EXPECT_NE(result.err.find(file + ":11:"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("Nowhere"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("[POU Main, contact 2]"), std::string::npos) << result.err;
}

TEST(Check, AllFilesAreCheckedAndTheWorstDecides) {
  const ScratchFolder scratch;
  const std::string bad = scratch.file("bad.xml");
  write_text(bad, small_project(true, kUnknownVariableBody));
  const auto result = run_tool({PLC_TOOL, "check", bad, tank()});
  EXPECT_EQ(result.code, 1);
  EXPECT_NE(result.out.find("tank.xml: ok"), std::string::npos) << result.out;
  EXPECT_EQ(run_tool({PLC_TOOL, "check", bad, scratch.file("absent.xml")}).code, 2);
}

TEST(Check, JsonIsOneDocumentOnStdout) {
  const ScratchFolder scratch;
  const std::string bad = scratch.file("bad.xml");
  write_text(bad, small_project(true, kUnknownVariableBody));
  const auto result = run_tool({PLC_TOOL, "check", "--json", bad, tank()});
  EXPECT_EQ(result.code, 1);
  EXPECT_EQ(result.err, "");
  const auto document = nlohmann::json::parse(result.out);
  ASSERT_EQ(document["files"].size(), 2u);
  EXPECT_FALSE(document["files"][0]["ok"]);
  EXPECT_TRUE(document["files"][1]["ok"]);
  bool found = false;
  for (const auto& row : document["diagnostics"]) {
    for (const char* key :
         {"file", "line", "column", "code", "severity", "pou", "element", "localId", "message", "help"}) {
      EXPECT_TRUE(row.contains(key)) << key;
    }
    found = found || (row["severity"] == "error" && row["line"] == 11 && row["pou"] == "Main" && row["localId"] == 2 &&
                      row["element"] == "contact");
  }
  EXPECT_TRUE(found) << result.out;
}

TEST(Check, JsonSurvivesBytesThatAreNoText) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("binary.xml");
  write_text(file, std::string("<project name=\"\xff\xfe\x80\">\x01\x02", 22));
  const auto result = run_tool({PLC_TOOL, "check", "--json", file});
  EXPECT_EQ(result.code, 1);
  EXPECT_TRUE(nlohmann::json::accept(result.out)) << result.out;
}

TEST(Check, BodiesThatAreNotReadAreNamedEach) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("chart.xml");
  write_text(file, R"(<Project xmlns="www.iec.ch/public/TC65SC65BWG7TF10"
  xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" schemaVersion="1"><FileHeader productName="tool"/>
<ContentHeader name="demo"/><Types><GlobalNamespace><Program name="Main"><MainBody><BodyContent xsi:type="SFC"/></MainBody>
</Program></GlobalNamespace></Types><Instances/></Project>)");
  const auto result = run_tool({PLC_TOOL, "check", file});
  EXPECT_EQ(result.code, 1);
  EXPECT_NE(result.err.find("P5101"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("\"Main\""), std::string::npos) << result.err;
  const auto stubbed = run_tool({PLC_TOOL, "check", file, "--stub-missing"});
  EXPECT_EQ(stubbed.code, 0) << stubbed.err;
  EXPECT_NE(stubbed.err.find("P5102"), std::string::npos) << stubbed.err;
}

TEST(Check, AProjectThatDrawsNothingSaysSo) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("empty.xml");
  write_text(file, small_project(true, "<LD/>"));
  const auto result = run_tool({PLC_TOOL, "check", file});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.err.find("P5103"), std::string::npos) << result.err;
}

TEST(Check, AFileWithoutInstancesIsFine) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("library.xml");
  write_text(file, small_project(false));
  const auto result = run_tool({PLC_TOOL, "check", file});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("no task runs a program"), std::string::npos) << result.out;
}

/// A project with one finding of lint: a variable that is not used.
constexpr std::string_view kUnusedLocal = R"(PROGRAM Main
VAR
  In AT %IX0.0 : BOOL;
  Out AT %QX0.0 : BOOL;
  Spare : BOOL;
END_VAR
  Out := In;
END_PROGRAM
CONFIGURATION C
  RESOURCE R ON PLC
    TASK T(INTERVAL := T#10ms, PRIORITY := 0);
    PROGRAM main WITH T : Main;
  END_RESOURCE
END_CONFIGURATION
)";

TEST(Lint, FindingsAreWarningsWithPlaceAndHelp) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("spare.st");
  write_text(file, kUnusedLocal);
  const auto result = run_tool({PLC_TOOL, "check", file});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.err.rfind(file + ":5:3: warning P4301: variable \"Spare\" is not used [POU Main]\n", 0), 0u)
      << result.err;
  EXPECT_NE(result.err.find("  help: delete it\n"), std::string::npos) << result.err;
  EXPECT_NE(result.out.find("ok, 1 warning"), std::string::npos) << result.out;
  const auto document = nlohmann::json::parse(run_tool({PLC_TOOL, "check", "--json", file}).out);
  ASSERT_EQ(document["diagnostics"].size(), 1u);
  EXPECT_EQ(document["diagnostics"][0]["code"], "P4301");
  EXPECT_EQ(document["diagnostics"][0]["line"], 5);
}

TEST(Lint, SwitchesChooseByNameAndFlagsMayRepeat) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("spare.st");
  write_text(file, kUnusedLocal);
  const auto says = [&](std::vector<std::string> flags) {
    flags.insert(flags.begin(), {PLC_TOOL, "check"});
    flags.push_back(file);
    const auto result = run_tool(flags);
    EXPECT_EQ(result.code, 0) << command_line(flags) << "\n" << result.all();
    return result.err.find("P4301") != std::string::npos;
  };
  EXPECT_TRUE(says({"--lint=all"}));
  EXPECT_TRUE(says({"--lint", "none,unused-variable"}));
  EXPECT_TRUE(says({"--lint=-double-coil"}));
  EXPECT_FALSE(says({"--lint=none"}));
  EXPECT_FALSE(says({"--lint=-unused-variable"}));
  EXPECT_FALSE(says({"--lint=all", "--lint=-P4301"}));
}

TEST(Lint, SwitchesApplyToWhatTheCompilerFindsToo) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("coils.xml");
  const std::string coil =
      R"(<connectionPointIn><connection refLocalId="1"/></connectionPointIn><variable>Out</variable></coil>)";
  write_text(file, small_project(true, R"(<LD>
<leftPowerRail localId="1"><position x="0" y="0"/><connectionPointOut formalParameter=""/></leftPowerRail>
<coil localId="3"><position x="100" y="0"/>)" +
                                           coil + R"(<coil localId="4"><position x="100" y="50"/>)" + coil + "</LD>"));
  EXPECT_NE(run_tool({PLC_TOOL, "check", "--lint=none,double-coil", file}).err.find("P2002"), std::string::npos);
  EXPECT_EQ(run_tool({PLC_TOOL, "check", "--lint=none", file}).err, "");
  EXPECT_NE(run_tool({PLC_TOOL, "sim", "--cycles", "1", file}).err.find("P2002"), std::string::npos);
}

TEST(Lint, UnknownNamesAreUsageErrorsWithAGuess) {
  const auto result = run_tool({PLC_TOOL, "check", "--lint=unused-variables", tank()});
  EXPECT_EQ(result.code, 2);
  EXPECT_NE(result.err.find("\"unused-variables\""), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("did you mean \"unused-variable\"?"), std::string::npos) << result.err;
}

TEST(Lint, HelpListsEveryOneOfThem) {
  const auto help = run_tool({PLC_TOOL, "check", "--help"});
#define PLC_LINT(name, word, code, on, summary)              \
  EXPECT_NE(help.out.find(word), std::string::npos) << word; \
  EXPECT_NE(help.out.find(summary), std::string::npos) << word;
#include "ir/lints.def"
}

TEST(Lint, WarningsFailTheCheckOnRequest) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("spare.st");
  write_text(file, kUnusedLocal);
  EXPECT_EQ(run_tool({PLC_TOOL, "check", "--werror", file}).code, 1);
  EXPECT_EQ(run_tool({PLC_TOOL, "check", "--werror", "--lint=none", file}).code, 0);
  EXPECT_EQ(run_tool({PLC_TOOL, "check", "--werror", tank()}).code, 0);
}

TEST(Lint, NeitherCompilingNorRunningLints) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("spare.st");
  write_text(file, kUnusedLocal);
  EXPECT_EQ(run_tool({PLC_TOOL, "compile", file, "-o", scratch.file("x.pbc")}).err.find("P4301"), std::string::npos);
  EXPECT_EQ(run_tool({PLC_TOOL, "sim", "--cycles", "1", file}).err, "");
}

TEST(Lint, LibrariesAreLeftOut) {
  const ScratchFolder scratch;
  const std::string library = scratch.file("library.st"), file = scratch.file("plant.st");
  write_text(library,
             "FUNCTION Twice : INT VAR_INPUT A : INT; END_VAR VAR Spare : INT; END_VAR Twice := 2 * A; END_FUNCTION\n"
             "FUNCTION Unused : INT Unused := 1; END_FUNCTION\n");
  std::string text(kUnusedLocal);
  text.replace(text.find("Spare : BOOL"), 12, "Spare : INT := 1");
  text.replace(text.find("Out := In;"), 10, "Out := In; Spare := Twice(Spare);");
  write_text(file, text);
  const auto result = run_tool({PLC_TOOL, "check", "--lib", library, file});
  EXPECT_EQ(result.code, 0);
  EXPECT_EQ(result.err, "");
}

/// A program with 30 blanks inside of durations: as many warnings of one code, in plc check and where it runs.
std::string many_warnings() {
  std::string text = "PROGRAM Main VAR Out : BOOL;\n";
  for (int i = 0; i < 30; ++i) text += "t" + std::to_string(i) + " : TIME := T# " + std::to_string(i) + "s;\n";
  return text +
         "END_VAR Out := t0 = t1; END_PROGRAM\n"
         "CONFIGURATION C TASK T(INTERVAL := T#10ms, PRIORITY := 0); PROGRAM main WITH T : Main; END_CONFIGURATION\n";
}

TEST(Check, OfOneCodeTwentyWarningsArePrintedEverywhereAndAllOnRequest) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("many.st");
  write_text(file, many_warnings());
  const std::vector<std::vector<std::string>> commands = {
      {PLC_TOOL, "check", "--lint=none", file},
      {PLC_TOOL, "sim", "--cycles", "1", file},
      {PLC_TOOL, "compile", file, "-o", scratch.file("x.pbc")},
      {PLC_TOOL, "dump", file},
      {PLC_TOOL, "map", file},
      {PLC_TOOL, "config", "init", file},
      {PLC_RUN_TOOL, file, "--duration", "1ms", "--modbus", "off", "--engineering", "off"},
  };
  for (std::vector<std::string> command : commands) {
    const auto warnings = [](const std::string& text) {
      std::size_t count = 0;
      for (std::size_t i = text.find("P4065: blank"); i != std::string::npos; i = text.find("P4065: blank", i + 1))
        ++count;
      return count;
    };
    const auto some = run_tool(command);
    EXPECT_EQ(some.code, 0) << command_line(command) << some.err;
    EXPECT_EQ(warnings(some.err), 20u) << command_line(command) << some.err;
    EXPECT_NE(some.err.find("\nP4065: 10 more; --all shows them\n"), std::string::npos) << some.err;
    command.emplace_back("--all");
    const auto all = run_tool(command);
    EXPECT_EQ(warnings(all.err), 30u) << command_line(command) << all.err;
    EXPECT_EQ(all.err.find("more;"), std::string::npos) << all.err;
  }
  const auto json = run_tool({PLC_TOOL, "check", "--json", "--lint=none", file});
  const nlohmann::json document = nlohmann::json::parse(json.out);
  EXPECT_EQ(document["diagnostics"].size(), 30u);
}

TEST(Check, TablesBesideAProjectAreCheckedToo) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plant.xml");
  write_text(file, small_project());
  write_text(scratch.file("alarms.toml"), "[[alarm]]\nvariable = \"main.Out\"\ntext = \"on\"\n");
  write_text(scratch.file("historian.toml"), "[historian]\ntags = [\"main.In\", \"main.*\"]\n");
  const auto good = run_tool({PLC_TOOL, "check", "--lint=none", file});
  EXPECT_EQ(good.code, 0) << good.err;
  EXPECT_EQ(good.err, "");
  write_text(scratch.file("alarms.toml"), "[[alarm]]\nvariable = \"main.Oout\"\ntext = \"on\"\n");
  const auto alarm = run_tool({PLC_TOOL, "check", file});
  EXPECT_EQ(alarm.code, 1);
  EXPECT_NE(alarm.err.find("alarms.toml:"), std::string::npos) << alarm.err;
  EXPECT_NE(alarm.err.find("P7101"), std::string::npos) << alarm.err;
  write_text(scratch.file("alarms.toml"), "");
  write_text(scratch.file("historian.toml"), "[historian]\ntags = [\"main.In\", \"Nothing*\"]\n");
  const auto kept = run_tool({PLC_TOOL, "check", file});
  EXPECT_EQ(kept.code, 1);
  EXPECT_NE(kept.err.find("historian.toml:"), std::string::npos) << kept.err;
  // In the folder of plc.toml, where there is one.
  std::filesystem::create_directory(scratch.file("station"));
  write_text(scratch.file("station/plc.toml"), "");
  EXPECT_EQ(run_tool({PLC_TOOL, "check", "--config", scratch.file("station/plc.toml"), file}).code, 0);
}

TEST(Check, GlobalsThatAreNamedBesideTheProjectAreUsed) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plant.st"), configuration = scratch.file("plc.toml");
  write_text(file,
             "PROGRAM Main VAR n : INT; END_VAR\n  n := n + 1;\nEND_PROGRAM\n"
             "CONFIGURATION C\n"
             "  VAR_GLOBAL Forces, Programs, Hot, Quiet, Level, Shown, Plotted, Spare : BOOL; END_VAR\n"
             "  RESOURCE R ON PLC TASK T(INTERVAL := T#10ms, PRIORITY := 0); PROGRAM main WITH T : Main;\n"
             "  END_RESOURCE\n"
             "END_CONFIGURATION\n");
  const auto unused = [&] {
    const auto result = run_tool({PLC_TOOL, "check", "--config", configuration, file});
    std::string names;
    for (const char* const name : {"Forces", "Programs", "Hot", "Quiet", "Level", "Shown", "Plotted", "Spare"}) {
      if (result.err.find("P4301: global variable \"" + std::string(name) + "\" is not used") != std::string::npos)
        names += std::string(names.empty() ? "" : " ") + name;
    }
    return names;
  };
  write_text(configuration, "");
  EXPECT_EQ(unused(), "Forces Programs Hot Quiet Level Shown Plotted Spare");
  write_text(configuration, "[engineering]\nno_force = \"Forces\"\nno_program = \"programs\"\n");
  EXPECT_EQ(unused(), "Hot Quiet Level Shown Plotted Spare");
  write_text(scratch.file("alarms.toml"), "[[alarm]]\nvariable = \"Hot\"\nsuppress = \"Quiet\"\ntext = \"hot\"\n");
  EXPECT_EQ(unused(), "Level Shown Plotted Spare");
  write_text(scratch.file("historian.toml"), "[historian]\ntags = [\"Level\", \"*\"]\n");
  EXPECT_EQ(unused(), "Shown Plotted Spare") << "a pattern takes what there is";
  write_text(scratch.file("pages.toml"),
             "[[page]]\nname = \"p\"\ncolumns = 12\nrows = 8\n"
             "[[page.element]]\nkind = \"lamp\"\nx = 0\ny = 0\nwidth = 1\nheight = 1\nvariable = \"Shown\"\n"
             "[[page.element]]\nkind = \"plot\"\nx = 2\ny = 2\nwidth = 4\nheight = 3\nvariables = [\"Plotted\"]\n");
  EXPECT_EQ(unused(), "Spare");
}

TEST(Check, ReportAccountsForElements) {
  const auto result = run_tool({PLC_TOOL, "report", tank()});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("PLCopen TC6 2.01"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("Station"), std::string::npos);
  EXPECT_NE(result.out.find("\nUsed\n"), std::string::npos);
}

}  // namespace
}  // namespace plc::test
