// Real project files, read where they lie beside the project: nothing of them is kept here. Each is compiled and run,
// or named in full where it cannot be yet; some have scenarios worked out by reading the drawing
// (corpus/<nn>/README.md).
//
// Does not belong here: the files themselves. Without the folder every test says that it is skipped and why.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "testing/case_file.h"
#include "testing/table.h"
#include "tests/support/compiled_image.h"
#include "tests/support/engines.h"
#include "tests/support/random_inputs.h"
#include "tests/support/run_tool.h"

namespace {

namespace fs = std::filesystem;
using plc::test::command_line;
using plc::test::run_tool;
using plc::test::ScratchFolder;
using plc::test::ToolResult;
using plc::tests::CsvTable;
using plc::tests::same_value;

const char* const kTool = PLC_TOOL;
const char* const kScenarios = PLC_SCENARIOS;

fs::path corpus() {
  const char* chosen = std::getenv("PLC_CORPUS");
  return chosen != nullptr ? fs::path(chosen) : fs::path(PLC_CORPUS_DEFAULT);
}

class Corpus : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::is_directory(corpus())) {
      GTEST_SKIP() << "no folder " << corpus() << ": real projects are not part of this repository (set PLC_CORPUS)";
    }
  }

  static std::string file(const std::string& name) { return (corpus() / name).string(); }

  /// `plc sim` for `cycles`; returns its result. The trace goes to a scratch file.
  static ToolResult simulate(const std::string& name, unsigned cycles, const std::vector<std::string>& options = {}) {
    const ScratchFolder scratch;
    std::vector<std::string> arguments = {kTool, "sim", file(name), "--cycles", std::to_string(cycles)};
    arguments.insert(arguments.end(), options.begin(), options.end());
    ToolResult result = run_tool(arguments, 120);
    result.err = command_line(arguments) + "\n" + result.err;
    return result;
  }
};

/// Lines of `text` that hold every one of `parts`.
bool line_with(const std::string& text, const std::vector<std::string>& parts) {
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (std::all_of(parts.begin(), parts.end(),
                    [&](const std::string& part) { return line.find(part) != std::string::npos; })) {
      return true;
    }
  }
  return false;
}

// ---- files that run as they are ---------------------------------------------------------------------------------

struct Runnable {
  const char* file;
  std::vector<std::string> options;
};

class Runs : public Corpus, public ::testing::WithParamInterface<Runnable> {};

TEST_P(Runs, TenThousandCycles) {
  const ToolResult result = simulate(GetParam().file, 10'000, GetParam().options);
  EXPECT_EQ(result.code, 0) << result.all();
}

std::string file_number(const std::string& file) { return "file_" + file.substr(0, 2); }

const std::vector<Runnable> kRunnable = {{"01_openplc_ld_xor_xnor.xml", {}},
                                         {"02_openplc_ld_mixer_timers.xml", {}},
                                         {"03_openplc_ld_swat.xml", {}},
                                         {"04_openplc_ld_sail_plant.xml", {}},
                                         {"05_openplc_ld_st_vc999.xml", {}},
                                         {"06_openplc_ld_calls_st_fb.xml", {}},
                                         {"07_openplc_fbd_pid_motor.xml", {"--pou", "Two_Steps_Burner_PID"}},
                                         {"08_openplc_v4_ld_relay.xml", {}},
                                         {"09_beremiz_all_languages_first_steps.xml", {}},
                                         {"12_beremiz_fbd_st_modbus.xml", {}},
                                         {"19_openplc_oscat_fbd_st_arith.xml", {}},
                                         {"14_beremiz_fbd_toggle_switch.xml", {"--pou", "Toggle_Switch_4x"}},
                                         {"15_beremiz_fbd_bending_machine.xml", {"--pou", "Bending_Machine_Control"}},
                                         {"16_beremiz_fbd_execution_order.xml", {"--pou", "TC005"}},
                                         {"17_twincat_ld_execute.xml", {}},
                                         {"18_twincat_fbd_networks.xml", {"--pou", "POU"}}};

INSTANTIATE_TEST_SUITE_P(Corpus, Runs, ::testing::ValuesIn(kRunnable),
                         [](const auto& param) { return file_number(param.param.file); });

TEST_F(Corpus, AnInstanceOfAMissingProgramNamesThePouThatExists) {
  const ToolResult result = run_tool({kTool, "check", file("18_twincat_fbd_networks.xml")});
  EXPECT_EQ(result.code, 1) << result.all();
  EXPECT_TRUE(line_with(result.all(), {"18_twincat_fbd_networks.xml:33:", "MAIN"})) << result.all();
  EXPECT_TRUE(line_with(result.all(), {"POU"})) << result.all();
}

TEST_F(Corpus, APidOfTheProjectIsTheOneThatRuns) {
  // It has a variable that the library's PID does not have.
  const std::vector<std::string> options = {"--pou", "Two_Steps_Burner_PID", "--watch",
                                            "Two_Steps_Burner_PID.PID0.Sum"};
  EXPECT_NE(simulate("07_openplc_fbd_pid_motor.xml", 10, options).code, 0);
  std::vector<std::string> with_library = options;
  with_library.insert(with_library.end(), {"--lib", PLC_SCENARIOS "/pid.st"});
  const ToolResult run = simulate("07_openplc_fbd_pid_motor.xml", 10, with_library);
  EXPECT_EQ(run.code, 0) << run.all();
  EXPECT_FALSE(line_with(run.all(), {"hides"})) << run.all();
}

TEST_F(Corpus, AnEmptyLadderCompilesToNothingAndSaysSo) {
  const ToolResult result = run_tool({kTool, "check", file("20_plcopeneditor2007_v101_ld.xml")});
  EXPECT_EQ(result.code, 0) << result.all();
  EXPECT_TRUE(line_with(result.all(), {"20_plcopeneditor2007_v101_ld.xml:", "warning", "MAIN_TEST"})) << result.all();
  const ToolResult run = simulate("20_plcopeneditor2007_v101_ld.xml", 100);
  EXPECT_EQ(run.code, 0) << run.all();
}

TEST_F(Corpus, ExplicitExecutionOrderIsPrinted) {
  const ToolResult result = run_tool({kTool, "explain", file("16_beremiz_fbd_execution_order.xml")});
  EXPECT_EQ(result.code, 0) << result.all();
  EXPECT_TRUE(plc::tests::in_sequence({"1", "12", "3", "7", "8", "9"}, plc::test::explained_order(result.out)))
      << result.out;
}

// ---- files with parts that cannot be compiled yet ----------------------------------------------------------------

/// A file, the messages it must draw (every text in one line each), and the options with which it runs as stubs.
struct Partial {
  const char* file;
  std::vector<std::vector<std::string>> messages;
  std::vector<std::string> stub_options;
};

class NamesWhatIsMissing : public Corpus, public ::testing::WithParamInterface<Partial> {};

TEST_P(NamesWhatIsMissing, WithLineAndRunsWithStubs) {
  const Partial& partial = GetParam();
  const ToolResult check = run_tool({kTool, "check", file(partial.file)});
  EXPECT_EQ(check.code, 1) << check.all();
  // Nothing else is left: every error is one of those.
  std::istringstream lines(check.all());
  for (std::string line; std::getline(lines, line);) {
    if (line.find(": error ") == std::string::npos) continue;
    EXPECT_TRUE(std::any_of(partial.messages.begin(), partial.messages.end(), [&](const auto& m) {
      return line.find(m.back()) != std::string::npos;
    })) << line;
  }
  for (const std::vector<std::string>& message : partial.messages) {
    EXPECT_TRUE(line_with(check.all(), message)) << "no line with: " << command_line(message) << "\n" << check.all();
  }
  std::vector<std::string> options = {"--stub-missing"};
  options.insert(options.end(), partial.stub_options.begin(), partial.stub_options.end());
  const ToolResult run = simulate(partial.file, 1000, options);
  EXPECT_EQ(run.code, 0) << run.all();
  for (const std::vector<std::string>& message : partial.messages) {
    EXPECT_TRUE(line_with(run.all(), {message.back()})) << "not named as a stub: " << message.back() << "\n"
                                                        << run.all();
  }
}

const std::vector<Partial> kPartial = {{"10_beremiz_fbd_logging.xml", {{":234:", "LOGGER"}, {":39:", "LOGLEVEL"}}, {}},
                                       {"11_beremiz_fbd_connectors_langtest.xml", {{":1128:", "LOGGER"}}, {}}};

INSTANTIATE_TEST_SUITE_P(Corpus, NamesWhatIsMissing, ::testing::ValuesIn(kPartial),
                         [](const auto& param) { return file_number(param.param.file); });

// Conditions of its chart name variables that it does not declare; everything else of it compiles.
TEST_F(Corpus, AChartWithUnknownNamesIsNamed) {
  const ToolResult check = run_tool({kTool, "check", file("13_phoenix_grid_tc001.xml")});
  EXPECT_EQ(check.code, 1) << check.all();
  EXPECT_TRUE(line_with(check.all(), {":596:", "P4004", "Transition1"})) << check.all();
  EXPECT_TRUE(line_with(check.all(), {":616:", "P4004", "Transition2"})) << check.all();
  EXPECT_TRUE(line_with(check.all(), {":571:", "warning P3112"})) << check.all();
  std::istringstream lines(check.all());
  for (std::string line; std::getline(lines, line);) {
    if (line.find(": error ") != std::string::npos) {
      EXPECT_NE(line.find("Transition"), std::string::npos) << line;
    }
  }
}

TEST_F(Corpus, CountersInFiveLanguagesAreOne) {
  const ScratchFolder scratch;
  const std::string counter = "plc_task_instance.Counter";
  const std::vector<std::string> languages = {"ST0", "FBD0", "LD0", "IL0"};
  std::vector<std::string> arguments = {kTool, "sim", file("09_beremiz_all_languages_first_steps.xml"), "--cycles",
                                        "50"};
  arguments.insert(arguments.end(), {"--stimulus", scratch.file("stimulus.csv"), "--trace", scratch.file("trace.csv")});
  std::ofstream(scratch.file("stimulus.csv")) << "time_ms,plc_task_instance.Reset\n0,0\n1000,1\n1300,0\n";
  for (const std::string& language : languages) {
    for (const char* variable : {".Cnt", ".OUT"})
      arguments.insert(arguments.end(), {"--watch", counter + language + variable});
  }
  arguments.insert(arguments.end(), {"--watch", counter + "SFC0.Cnt"});
  const ToolResult result = run_tool(arguments);
  ASSERT_EQ(result.code, 0) << command_line(arguments) << "\n" << result.all();
  const CsvTable trace = plc::tests::read_csv(scratch.file("trace.csv"));
  ASSERT_EQ(trace.rows.size(), 50u);
  std::vector<std::size_t> columns;
  for (const std::string& language : languages) {
    for (const char* variable : {".Cnt", ".OUT"}) columns.push_back(trace.column(counter + language + variable));
  }
  for (const std::vector<std::string>& row : trace.rows) {
    for (const std::size_t column : columns) {
      ASSERT_LT(column, row.size());
      EXPECT_EQ(row[column], row[columns[0]]) << trace.header[column] << " in cycle " << row[0];
    }
  }
  EXPECT_EQ(trace.rows[9][columns[0]], "10");
  EXPECT_EQ(trace.rows[10][columns[0]], "17") << "reset at 1 s";
  // The chart acts, then tests: its first scan is that of Start, which counts nothing. Reset in cycle 10 leads over
  // Start (11) to ResetCounter (12, 13), and its end over Start (14) to Count (15).
  const std::size_t chart = trace.column(counter + "SFC0.Cnt");
  const std::vector<std::pair<std::size_t, std::string>> counted = {
      {0, "0"}, {1, "1"}, {9, "9"}, {10, "10"}, {11, "10"}, {12, "17"}, {13, "17"}, {14, "17"}, {15, "18"}, {20, "23"}};
  for (const auto& [cycle, value] : counted) EXPECT_EQ(trace.rows[cycle][chart], value) << "in cycle " << cycle;
  EXPECT_EQ(trace.rows[14][columns[0]], "19") << "and counting again";
}

// ---- engines ----------------------------------------------------------------------------------------------------

/// All that runs, as it is or with stubs.
std::vector<Runnable> all_runnable() {
  std::vector<Runnable> all = kRunnable;
  for (const Partial& partial : kPartial) {
    all.push_back({partial.file, partial.stub_options});
    all.back().options.emplace_back("--stub-missing");
  }
  all.push_back({"20_plcopeneditor2007_v101_ld.xml", {}});
  return all;
}

class InEveryEngine : public Corpus, public ::testing::WithParamInterface<Runnable> {};

// Random inputs into globals and the variables of the programs before each scan: all tables are equal after it.
TEST_P(InEveryEngine, AThousandScansLeaveTheSame) {
  constexpr std::uint64_t kScans = 1000;
  const auto image = plc::test::compiled_image(kTool, file(GetParam().file), GetParam().options);
  ASSERT_TRUE(image.has_value());
  std::string problem;
  const auto engines = plc::test::Engines::load(*image, problem);
  ASSERT_NE(engines, nullptr) << problem;
  constexpr unsigned kVariablesOfPrograms = 2;
  plc::test::RandomInputs inputs(*image, kVariablesOfPrograms);
  plc::test::Random random(1);
  plc::core::TimeNs now_ns = 0;
  std::uint64_t faults = 0;
  for (std::uint64_t scan = 0; scan < kScans; ++scan) {
    if (scan % 4 != 0) {
      inputs.choose(random, 8);
      for (std::size_t e = 0; e < engines->size(); ++e) inputs.write((*engines)[e]);
    }
    for (std::size_t task = 0; task < engines->tasks(); ++task) {
      ASSERT_EQ(engines->scan(task, now_ns), "") << "scan " << scan;
      faults += engines->fault() ? 1 : 0;
    }
    now_ns += static_cast<plc::core::TimeNs>(random.below(4)) * 20'000'000;
  }
  std::uint64_t events = 0;
  for (std::size_t task = 0; task < engines->tasks(); ++task) events += (*engines)[0].program(task).event_total();
  std::cout << GetParam().file << ": " << engines->tasks() << " tasks, " << kScans << " scans of each in "
            << engines->size() << " engines, " << inputs.places() << " inputs, " << events << " events, " << faults
            << " faults\n";
}

INSTANTIATE_TEST_SUITE_P(Corpus, InEveryEngine, ::testing::ValuesIn(all_runnable()),
                         [](const auto& param) { return file_number(param.param.file); });

// ---- scenarios ---------------------------------------------------------------------------------------------------

class Scenario : public Corpus, public ::testing::WithParamInterface<std::string> {};

TEST_P(Scenario, RowsEqualTheHandWorkedTable) {
  const fs::path folder = fs::path(kScenarios) / GetParam();
  std::string project;
  std::vector<std::string> options;
  std::ifstream in(folder / "case.txt");
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string key;
    words >> key;
    for (std::string word; words >> word;) {
      if (key == "file:") project = word;
      if (key == "options:") options.push_back(word);
    }
  }
  const CsvTable expected = plc::tests::read_csv((folder / "expected.csv").string());
  ASSERT_FALSE(expected.rows.empty());
  const ScratchFolder scratch;
  std::vector<std::string> arguments = {kTool,
                                        "sim",
                                        file(project),
                                        "--cycles",
                                        std::to_string(std::stoul(expected.rows.back()[0]) + 1),
                                        "--stimulus",
                                        (folder / "stimulus.csv").string(),
                                        "--trace",
                                        scratch.file("trace.csv")};
  for (std::size_t c = 2; c < expected.header.size(); ++c) {
    arguments.insert(arguments.end(), {"--watch", expected.header[c]});
  }
  arguments.insert(arguments.end(), options.begin(), options.end());
  const ToolResult result = run_tool(arguments);
  ASSERT_EQ(result.code, 0) << command_line(arguments) << "\n" << result.all();

  const CsvTable actual = plc::tests::read_csv(scratch.file("trace.csv"));
  for (std::size_t r = 0; r < expected.rows.size(); ++r) {
    const std::vector<std::string>& row = expected.rows[r];
    const std::size_t cycle = std::stoul(row[0]);
    ASSERT_LT(cycle, actual.rows.size());
    for (std::size_t c = 0; c < expected.header.size(); ++c) {
      if (row[c].empty()) continue;
      const std::size_t column = actual.column(expected.header[c]);
      ASSERT_LT(column, actual.header.size()) << "the trace has no column " << expected.header[c];
      EXPECT_TRUE(same_value(row[c], actual.rows[cycle][column]))
          << "expected.csv:" << expected.lines[r] << ": " << expected.header[c] << " in cycle " << cycle << " is "
          << actual.rows[cycle][column] << ", should be " << row[c];
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Corpus, Scenario, ::testing::Values("01", "02", "03", "04", "08", "14", "16", "17", "18"),
                         [](const auto& param) { return "file_" + param.param; });

}  // namespace
