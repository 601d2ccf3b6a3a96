// plc test: exit codes, what it prints and writes.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/support/problem_page.h"
#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

std::string text_of(const std::string& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

class TestCommand : public ::testing::Test {
 protected:
  void SetUp() override { write_text(scratch_.file("lamp.st"), kSmallProject); }
  /// Writes tests of the plant, and runs `plc test` on them.
  ToolResult run(const std::string& tests, const std::vector<std::string>& flags = {}) {
    write_text(tests_, tests);
    std::vector<std::string> arguments = {PLC_TOOL, "test", tests_};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    return run_tool(arguments);
  }
  ScratchFolder scratch_;
  std::string tests_ = scratch_.file("lamp_test.st");
};

const std::string kGood = "TEST 'on' main.Start := TRUE; RUN_CYCLES(1); ASSERT_TRUE(main.Motor); END_TEST\n";
const std::string kBad = "TEST 'off'\n  RUN_CYCLES(2);\n  ASSERT_TRUE(main.Motor, 'it is <on> & \"lit\"');\nEND_TEST\n";

TEST_F(TestCommand, PassesAndFailsByExitCode) {
  const ToolResult good = run(kGood);
  EXPECT_EQ(good.code, 0) << good.all();
  EXPECT_NE(good.out.find("  ok    on (1 cycle"), std::string::npos) << good.out;
  EXPECT_NE(good.out.find("1 test, 0 failed, 1 check\n"), std::string::npos) << good.out;
  const ToolResult bad = run(kGood + kBad);
  EXPECT_EQ(bad.code, 1);
  EXPECT_NE(bad.out.find(tests_ + ":4:3: main.Motor: expected TRUE, got FALSE, after 40ms, cycle 2: it is <on>"),
            std::string::npos)
      << bad.out;
  EXPECT_NE(bad.out.find("2 tests, 1 failed, 2 checks\n"), std::string::npos) << bad.out;
}

TEST_F(TestCommand, WithoutTasksSaysWhatIsMissing) {
  const std::string file = scratch_.file("blocks.st");
  const std::string block =
      "FUNCTION_BLOCK Twice VAR_INPUT i : INT; END_VAR VAR_OUTPUT o : INT; END_VAR o := 2 * i; "
      "END_FUNCTION_BLOCK\n";
  write_text(file, block + "TEST 'block' VAR t : Twice; END_VAR t(i := 4); ASSERT_EQ(8, t.o); END_TEST\n");
  // A block alone needs no task.
  const ToolResult alone = run_tool({PLC_TOOL, "test", file});
  EXPECT_EQ(alone.code, 0) << alone.all();
  EXPECT_EQ(alone.err, "");
  write_text(file, "PROGRAM Only VAR a : INT; END_VAR a := 1; END_PROGRAM\nTEST 'a' ASSERT_EQ(0, Only.a); END_TEST\n");
  const ToolResult program = run_tool({PLC_TOOL, "test", file});
  EXPECT_EQ(program.code, 1);
  EXPECT_NE(program.err.find(":2:23: error P7903: no task of the project runs program \"Only\""), std::string::npos)
      << program.err;
  const ToolResult run_alone = run_tool({PLC_TOOL, "test", file, "--pou", "Only"});
  EXPECT_EQ(run_alone.code, 0) << run_alone.all();
}

TEST_F(TestCommand, WrongTestsAndFilesAreSaid) {
  const ToolResult wrong = run("TEST 'x' ASSERT_EQ(main.Lmp, TRUE); END_TEST");
  EXPECT_EQ(wrong.code, 1);
  EXPECT_NE(wrong.err.find(tests_ + ":1:25: error P4005"), std::string::npos) << wrong.err;
  EXPECT_EQ(run_tool({PLC_TOOL, "test", scratch_.file("nothing.st")}).code, 2);
  EXPECT_EQ(run(kGood).code, 0);
  const ToolResult none = run_tool({PLC_TOOL, "test", scratch_.file("lamp.st"), "--filter", "nothing"});
  EXPECT_EQ(none.code, 2) << none.all();
  EXPECT_EQ(run("TEST 'x' END_TEST\nTEST 'y' (*").code, 1);
}

TEST_F(TestCommand, AConfigurationBesideTestsDoesNothing) {
  const ToolResult result = run(kGood +
                                "PROGRAM Other VAR a : INT; END_VAR a := 1; END_PROGRAM\n"
                                "CONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#1ms, PRIORITY := 0);\n"
                                "PROGRAM other WITH T : Other; END_RESOURCE END_CONFIGURATION\n");
  EXPECT_EQ(result.code, 0) << result.all();
  EXPECT_NE(result.err.find(tests_ + ":3:"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("warning P4030"), std::string::npos) << result.err;
}

TEST_F(TestCommand, OtherCommandsReadTheSyntaxAndNothingElse) {
  write_text(scratch_.file("both.st"), kSmallProject + kGood + "TEST 'calls what is nowhere' Foo(1); END_TEST\n");
  EXPECT_EQ(run_tool({PLC_TOOL, "check", scratch_.file("both.st")}).code, 0);
  const ToolResult dump = run_tool({PLC_TOOL, "dump", scratch_.file("both.st")});
  EXPECT_EQ(dump.out.find("TEST"), std::string::npos) << "no test is in an image";
  write_text(scratch_.file("both.st"), std::string(kSmallProject) + "TEST 'broken' ASSERT_TRUE(; END_TEST\n");
  const ToolResult broken = run_tool({PLC_TOOL, "check", scratch_.file("both.st")});
  EXPECT_EQ(broken.code, 1);
  EXPECT_NE(broken.err.find("TEST 'broken'"), std::string::npos) << broken.err;
}

TEST_F(TestCommand, TapIsOnStdoutAlone) {
  const ToolResult result = run(kGood + kBad, {"--tap"});
  EXPECT_EQ(result.code, 1);
  EXPECT_EQ(result.out.rfind("TAP version 14\n1..2\nok 1 - ", 0), 0u) << result.out;
  EXPECT_NE(result.out.find("\nnot ok 2 - "), std::string::npos);
  EXPECT_NE(result.out.find("      after: '40ms'\n      cycle: 2\n      text: 'it is <on> & \"lit\"'\n"
                            "      expected: 'TRUE'\n      got: 'FALSE'\n"),
            std::string::npos)
      << result.out;
  EXPECT_NE(result.err.find("2 tests, 1 failed"), std::string::npos);
}

TEST_F(TestCommand, JunitHasFailuresAsText) {
  run(kGood + kBad, {"--junit", scratch_.file("out.xml")});
  const std::string xml = text_of(scratch_.file("out.xml"));
  EXPECT_NE(xml.find("<testsuites tests=\"2\" failures=\"1\" errors=\"0\">"), std::string::npos) << xml;
  EXPECT_NE(xml.find("it is &lt;on&gt; &amp; &quot;lit&quot;</failure>"), std::string::npos) << xml;
  EXPECT_EQ(run_tool({"/bin/sh", "-c", "command -v xmllint >/dev/null || exit 0; xmllint --noout \"$0\"",
                      scratch_.file("out.xml")})
                .code,
            0);
  EXPECT_EQ(run(kGood, {"--junit", "/nonexistent/out.xml"}).code, 2);
}

TEST_F(TestCommand, FailuresThatAreNotKeptAreCounted) {
  std::string many = "TEST 'many'\n";
  for (int i = 0; i < 23; ++i) many += "  ASSERT_TRUE(FALSE);\n";
  const ToolResult result = run(many + "END_TEST\n", {"--tap", "--junit", scratch_.file("out.xml")});
  EXPECT_NE(result.out.find("\n  more: 'and 3 more'\n  ...\n"), std::string::npos) << result.out;
  EXPECT_NE(text_of(scratch_.file("out.xml")).find("<failure message=\"and 3 more\">and 3 more</failure>\n</testcase>"),
            std::string::npos);
}

TEST_F(TestCommand, FilterListAndSeed) {
  EXPECT_NE(run(kGood + kBad, {"--filter", "O?"}).out.find("1 test, 0 failed"), std::string::npos);
  EXPECT_EQ(run(kGood + kBad, {"--list"}).out,
            scratch_.file("lamp.st") + ": on\n" + scratch_.file("lamp.st") + ": off\n");
  std::string many;
  for (int i = 0; i < 20; ++i) many += "TEST 't" + std::to_string(i) + "' ASSERT_TRUE(TRUE); END_TEST\n";
  const std::string one = run(many, {"--seed", "1"}).out;
  EXPECT_EQ(one, run(many, {"--seed", "1"}).out);
  EXPECT_NE(one, run(many, {"--seed", "2"}).out);
  EXPECT_NE(one.find("seed 1"), std::string::npos);
}

TEST_F(TestCommand, AThousandTestsTakeLessThanASecond) {
  std::string many;
  for (int i = 0; i < 1000; ++i) {
    many += "TEST 't" + std::to_string(i) +
            "'\nVAR t : TON; END_VAR\n  main.Start := TRUE; RUN_CYCLES(3); t(IN := TRUE, PT := T#1s);\n"
            "  ASSERT_TRUE(main.Motor); ASSERT_FALSE(t.Q);\nEND_TEST\n";
  }
  const ToolResult result = run(many, {"--junit", scratch_.file("out.xml")});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("1000 tests, 0 failed, 2000 checks"), std::string::npos);
  // What the tests themselves took, without the compiler: a machine that is busy with other tests may take its time.
  const std::string xml = text_of(scratch_.file("out.xml"));
  const std::size_t at = xml.find(" time=\"") + 7;
  EXPECT_LT(std::stod(xml.substr(at)), 5.0) << xml.substr(0, 200);
}

TEST_F(TestCommand, CasesRunInTheirFolder) {
  const std::string folder = scratch_.file("case");
  std::filesystem::create_directory(folder);
  write_text(folder + "/project.st", kSmallProject);
  write_text(folder + "/stimulus.csv", "time_ms,main.Start\n20,1\n");
  write_text(folder + "/expected.csv", "cycle,time_ms,main.Motor\n0,0,0\n1,20,1\n");
  const ToolResult good = run_tool({PLC_TOOL, "test", folder});
  EXPECT_EQ(good.code, 0) << good.all();
  EXPECT_NE(good.out.find("1 test, 0 failed"), std::string::npos);
  write_text(folder + "/expected.csv", "cycle,time_ms,main.Motor\n0,0,0\n1,20,0\n");
  const ToolResult bad = run_tool({PLC_TOOL, "test", folder});
  EXPECT_EQ(bad.code, 1);
  EXPECT_NE(bad.out.find("expected.csv:3: main.Motor: expected 0, got 1"), std::string::npos) << bad.out;
}

TEST_F(TestCommand, CasesTakeCompileOptionsAndOrders) {
  const std::string folder = scratch_.file("case");
  std::filesystem::create_directory(folder);
  write_text(folder + "/project.st",
             "PROGRAM Main\nVAR x : INT; END_VAR\n  {IF hasvalue (MODE, 'fast')} x := 2; {ELSE} x := 1; {END_IF}\n"
             "END_PROGRAM\nCONFIGURATION C\nRESOURCE R ON PLC\nTASK T(INTERVAL := T#20ms, PRIORITY := 0);\n"
             "PROGRAM main WITH T : Main;\nEND_RESOURCE\nEND_CONFIGURATION\n");
  write_text(folder + "/slow.csv", "cycle,time_ms,main.x\n0,0,1\n");
  write_text(folder + "/fast.csv", "cycle,time_ms,main.x\n0,0,2\n");
  write_text(folder + "/case.txt",
             "run: slow.csv\nrun: fast.csv --define MODE=fast --order=document\nrun: fast.csv --define=MODE=fast\n");
  const ToolResult good = run_tool({PLC_TOOL, "test", folder});
  EXPECT_EQ(good.code, 0) << good.all();
  EXPECT_NE(good.out.find("3 tests, 0 failed"), std::string::npos) << good.out;
  for (const auto& [option, why] : {std::pair("--defines X", "is no compile option"), std::pair("--define 1", "1"),
                                    std::pair("--order=size", "has no value"), std::pair("--define", "no compile")}) {
    write_text(folder + "/case.txt", std::string("run: slow.csv ") + option + "\n");
    const ToolResult bad = run_tool({PLC_TOOL, "test", folder});
    EXPECT_EQ(bad.code, 1) << option << bad.all();
    EXPECT_NE(bad.all().find(why), std::string::npos) << bad.all();
  }
  const std::string drawn = scratch_.file("drawn");
  std::filesystem::create_directory(drawn);
  write_text(drawn + "/project.xml", small_project());
  write_text(drawn + "/expected.csv", "cycle,time_ms,main.Out\n0,0,0\n");
  write_text(drawn + "/case.txt", "order: 2 3\n");
  EXPECT_EQ(run_tool({PLC_TOOL, "test", drawn}).code, 0);
  write_text(drawn + "/case.txt", "order: 3 2\n");
  const ToolResult other = run_tool({PLC_TOOL, "test", drawn});
  EXPECT_EQ(other.code, 1);
  EXPECT_NE(other.out.find("order of execution: expected 3 2, got "), std::string::npos) << other.all();
}

TEST_F(TestCommand, CoverageIsATableAndAPicture) {
  const std::string folder = scratch_.file("svg");
  const ToolResult result =
      run_tool({PLC_TOOL, "test", std::string(PLC_EXAMPLES) + "/tank", "--coverage", "--svg", folder});
  EXPECT_EQ(result.code, 0) << result.all();
  EXPECT_NE(result.out.find("outcomes seen"), std::string::npos) << result.out;
  const std::string svg = text_of(folder + "/Station.svg");
  EXPECT_NE(svg.find("class=\"shape seen\""), std::string::npos);
  EXPECT_NE(svg.find(">StopButton</text>"), std::string::npos);
  EXPECT_EQ(run_tool({"/bin/sh", "-c", "command -v xmllint >/dev/null || exit 0; xmllint --noout \"$0\"",
                      folder + "/Station.svg"})
                .code,
            0);
}

TEST_F(TestCommand, CoverAllWantsEveryContactOrAReason) {
  const std::string tank = std::string(PLC_EXAMPLES) + "/tank/";
  std::filesystem::copy_file(tank + "tank.xml", scratch_.file("tank.xml"));
  const std::string tests = scratch_.file("tank_test.st");
  const std::string one = "TEST 'idle' RUN_CYCLES(1); ASSERT_FALSE(Running); END_TEST\n";
  write_text(tests, one);
  const ToolResult open = run_tool({PLC_TOOL, "test", tests, "--cover-all", "--svg", scratch_.file("open")});
  EXPECT_NE(text_of(scratch_.file("open") + "/Station.svg").find("class=\"value half\">not "), std::string::npos)
      << "what was not seen stands below";
  EXPECT_EQ(open.code, 1);
  EXPECT_NE(open.out.find("contact \"StopButton\" [localId 5]: not seen closed: no power reached it"),
            std::string::npos)
      << open.out;
  write_text(tests,
             one + "{not_covered Station 'StopButton' 'no \"stop\" here'}\n{not_covered Station 'Nobody' 'x'}\n");
  const ToolResult named = run_tool({PLC_TOOL, "test", tests, "--coverage"});
  EXPECT_EQ(named.code, 0) << named.all();
  EXPECT_NE(named.out.find("no power reached it; reason: no \"stop\" here"), std::string::npos) << named.out;
  EXPECT_NE(named.out.find("{not_covered Station 'Nobody' ..} names nothing"), std::string::npos) << named.out;
}

}  // namespace
}  // namespace plc::test
