// Wrong flags, absent files, help; and the small functions that they use.
#include <gtest/gtest.h>

#include <sstream>

#include "tests/tools/fixture.h"
#include "tools/command_line.h"
#include "tools/statistics.h"

namespace plc::test {
namespace {

using tools::duration_text;
using tools::parse_duration_ns;

TEST(Usage, UnknownFlagsAndCommandsExitWith2AndHelp) {
  for (const std::vector<std::string>& command : {std::vector<std::string>{PLC_TOOL},
                                                  {PLC_TOOL, "nonsense", tank()},
                                                  {PLC_TOOL, "check"},
                                                  {PLC_TOOL, "check", tank(), "--jsn"},
                                                  {PLC_TOOL, "sim", tank(), "--order=sideways"},
                                                  {PLC_TOOL, "sim", tank(), "--cycles", "many"},
                                                  {PLC_TOOL, "compile", tank()},
                                                  {PLC_RUN_TOOL},
                                                  {PLC_RUN_TOOL, tank(), "--fast"}}) {
    const auto result = run_tool(command);
    EXPECT_EQ(result.code, 2) << command_line(command);
    EXPECT_NE(result.err.find("--help"), std::string::npos) << command_line(command) << "\n" << result.err;
    EXPECT_EQ(result.out, "") << command_line(command);
  }
}

TEST(Usage, AMistypedCommandIsGuessed) {
  const auto result = run_tool({PLC_TOOL, "chekc", tank()});
  EXPECT_EQ(result.code, 2);
  EXPECT_NE(result.err.find("did you mean \"check\"?"), std::string::npos) << result.err;
}

TEST(Usage, AMistypedFlagIsGuessedAndSaidBeforeWhatIsMissing) {
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{PLC_TOOL, "sim", "--engin=native"}, {PLC_TOOL, "sim", tank(), "--engin", "auto"}}) {
    const auto result = run_tool(command);
    EXPECT_EQ(result.code, 2) << command_line(command);
    EXPECT_EQ(result.err,
              "plc sim: there is no flag --engin\n"
              "  help: did you mean \"--engine\"? plc sim --help shows every flag with examples\n");
  }
  // Dashes are no letters that agree.
  const auto far = run_tool({PLC_RUN_TOOL, "--foo"});
  EXPECT_EQ(far.err, "plc-run: there is no flag --foo\n  help: plc-run --help shows every flag with examples\n");
  const auto missing = run_tool({PLC_TOOL, "sim"});
  EXPECT_NE(missing.err.find("FILE is required"), std::string::npos) << missing.err;
}

// Before a server is asked: nobody listens there.
TEST(Usage, RemoteRefusesWhatItWouldNotUse) {
  const std::string url = "http://127.0.0.1:1";
  for (const char* const what : {"stop", "status", "tasks", "log", "alarms", "logout", "calls"}) {
    const auto result = run_tool({PLC_TOOL, "remote", url, what, "anything"});
    EXPECT_EQ(result.code, 2) << what << ": " << result.all();
    EXPECT_NE(result.err.find("plc remote: wrong arguments\n  help: plc remote " + url + " " + what + "\n"),
              std::string::npos)
        << result.err;
  }
  EXPECT_EQ(run_tool({PLC_TOOL, "remote", url, "stop"}).code, 1) << "nobody is there";
  const auto stream = run_tool({PLC_TOOL, "remote", url, "values.stream"});
  EXPECT_EQ(stream.code, 2);
  EXPECT_NE(stream.err.find("values.stream is a stream"), std::string::npos) << stream.err;
  EXPECT_NE(stream.err.find("values --follow"), std::string::npos) << stream.err;
  const std::string bytes = "0123456789ABCDEFabcdef0123456789ABCDEFabcdef0123456789ABCDEF0123";
  std::string good;
  for (std::size_t i = 0; i < bytes.size(); i += 2) good += (i == 0 ? "" : ":") + bytes.substr(i, 2);
  for (const std::string& wrong : {std::string("AB:CD"), bytes, good + ":00", "G" + good.substr(1)}) {
    const auto result = run_tool({PLC_TOOL, "remote", "https://127.0.0.1:1", "--fingerprint", wrong});
    EXPECT_EQ(result.code, 2) << wrong;
    EXPECT_NE(result.err.find("is no fingerprint"), std::string::npos) << result.err;
  }
  EXPECT_EQ(run_tool({PLC_TOOL, "remote", "https://127.0.0.1:1", "--fingerprint", good}).code, 1) << "it was taken";
}

TEST(Usage, RemoteSaysByItsCodeWhetherThereAreSuchVariables) {
  const ScratchFolder scratch;
  const std::string script =
      "\"$1\" \"$3\" --modbus off --engineering 127.0.0.1:0 --state \"$HOME/state\" > \"$HOME/out\" 2>&1 & "
      "for i in $(seq 150); do grep -q 'http://' \"$HOME/out\" && grep -qE '[A-Z0-9]{4}-[A-Z0-9]{4}-' \"$HOME/out\" "
      "&& break; sleep 0.1; done; "
      "url=$(grep -oE 'http://127.0.0.1:[0-9]+' \"$HOME/out\" | head -n 1); "
      "code=$(grep -oE '[A-Z0-9]{4}-[A-Z0-9]{4}-[A-Z0-9]{4}' \"$HOME/out\" | head -n 1); "
      "echo correct horse battery | \"$2\" remote $url first-user $code anna; "
      "for what in Running Nope 'Nope*' 'Run*'; do \"$2\" remote $url values \"$what\"; echo \"$what: $?\"; done; "
      "kill %1; wait";
  const auto result = run_tool({"/usr/bin/env", "-u", "XDG_CONFIG_HOME", "HOME=" + scratch.file(""), "/bin/bash", "-c",
                                script, "bash", PLC_RUN_TOOL, PLC_TOOL, tank()});
  for (const char* const part : {"Running: 0\n", "Nope: 1\n", "Nope*: 1\n", "Run*: 0\n"})
    EXPECT_NE(result.out.find(part), std::string::npos) << part << result.all();
  EXPECT_NE(result.err.find("no variable matches \"Nope*\""), std::string::npos) << result.err;
}

TEST(Usage, TablesCountCharactersAndPutTextsToTheLeft) {
  std::ostringstream out;
  tools::print_table({{"name", "state", "time", "share"},
                      {"a", "running", "12us", "-"},
                      {"K\xc3\xbchler", "off", "-1.5us", "4 %"},
                      {"b", "", "-", "12 %"}},
                     out);
  EXPECT_EQ(out.str(),
            "name    state      time  share\n"
            "a       running    12us      -\n"
            "K\xc3\xbchler  off      -1.5us    4 %\n"
            "b                     -   12 %\n");
}

TEST(Usage, FilesThatCannotBeOpenedExitWith2) {
  const ScratchFolder scratch;
  const std::string absent = scratch.file("absent.xml"), image = scratch.file("absent.pbc");
  for (const std::vector<std::string>& command : {std::vector<std::string>{PLC_TOOL, "check", absent},
                                                  {PLC_TOOL, "sim", absent},
                                                  {PLC_TOOL, "sim", image},
                                                  {PLC_TOOL, "dump", image},
                                                  {PLC_TOOL, "explain", absent},
                                                  {PLC_TOOL, "report", absent},
                                                  {PLC_TOOL, "sim", tank(), "--stimulus", scratch.file("no.csv")},
                                                  {PLC_RUN_TOOL, absent}}) {
    EXPECT_EQ(run_tool(command).code, 2) << command_line(command);
  }
}

TEST(Usage, HelpTeachesWithExamples) {
  for (const std::vector<std::string>& command : {std::vector<std::string>{PLC_TOOL, "--help"},
                                                  {PLC_TOOL, "check", "--help"},
                                                  {PLC_TOOL, "compile", "--help"},
                                                  {PLC_TOOL, "dump", "--help"},
                                                  {PLC_TOOL, "explain", "--help"},
                                                  {PLC_TOOL, "lib", "--help"},
                                                  {PLC_TOOL, "sim", "--help"},
                                                  {PLC_TOOL, "report", "--help"},
                                                  {PLC_RUN_TOOL, "--help"}}) {
    const auto result = run_tool(command);
    EXPECT_EQ(result.code, 0) << command_line(command);
    EXPECT_NE(result.out.find("Example"), std::string::npos) << command_line(command);
  }
}

TEST(Usage, ExplainPrintsThePageOfACode) {
  const auto result = run_tool({PLC_TOOL, "explain", "p5101"});
  EXPECT_EQ(result.code, 0);
  EXPECT_EQ(result.out.substr(0, 8), "# P5101:");
  EXPECT_EQ(run_tool({PLC_TOOL, "explain", "P0000"}).code, 2);
}

TEST(Usage, ExplainPrintsTheOrderWithReasons) {
  const auto result = run_tool({PLC_TOOL, "explain", tank(), "signals"});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("order=drawing"), std::string::npos);
  EXPECT_NE(result.out.find("TON Pause"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("value of the previous scan from"), std::string::npos) << result.out;
  const auto measure = run_tool({PLC_TOOL, "explain", tank(), "Measure"});
  for (const char* reason : {"read for block 5", "written with block 5", "position"}) {
    EXPECT_NE(measure.out.find(reason), std::string::npos) << reason << "\n" << measure.out;
  }
  EXPECT_EQ(result.out.find("HighAlarm"), std::string::npos) << "only the POU asked for";
  EXPECT_EQ(run_tool({PLC_TOOL, "explain", tank(), "Nowhere"}).code, 1);
}

TEST(Durations, AreReadWithUnits) {
  EXPECT_EQ(parse_duration_ns("20s"), 20'000'000'000);
  EXPECT_EQ(parse_duration_ns("1.5"), 1'500'000'000);
  EXPECT_EQ(parse_duration_ns("500ms"), 500'000'000);
  EXPECT_EQ(parse_duration_ns("2min"), 120'000'000'000);
  EXPECT_EQ(parse_duration_ns("T#1m30s"), 90'000'000'000);
  EXPECT_EQ(parse_duration_ns("1h"), 3'600'000'000'000);
  for (const char* wrong : {"", "s", "5x", "1..2s", "-1s", "T#"})
    EXPECT_EQ(parse_duration_ns(wrong), std::nullopt) << wrong;
}

TEST(Durations, AreWrittenShort) {
  EXPECT_EQ(duration_text(20e6), "20ms");
  EXPECT_EQ(duration_text(1500), "1.5us");
  EXPECT_EQ(duration_text(2e9), "2s");
  EXPECT_EQ(duration_text(12), "12ns");
}

}  // namespace
}  // namespace plc::test
