// The CNC example as a whole, through `plc sim` and `plc-run`: what its README promises, from what was traced.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "examples/cnc/blocks/element.h"
#include "tests/support/golden.h"
#include "tests/support/run_tool.h"
#include "tests/unit/cnc/programmed_path.h"

namespace plc::test {
namespace {

using cnc::Point;

constexpr double kPeriod = 0.001;
constexpr double kAcceleration = 1000;
/// What the example promises (README.md), in mm.
constexpr double kPathTolerance = 0.01;
constexpr double kFollowingTolerance = 0.02;
/// Along the path there is half of it on arcs, less the share for steps; then the tasks have to see the button.
double stopping_seconds(double speed) { return speed / (kAcceleration * (1 - cnc::kStepShare) / 2) + 3 * kPeriod; }

std::string text_of(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// One millisecond of the machine.
struct Row {
  double seconds = 0;
  Point set{};
  Point actual{};
  double speed = 0;
  int line = 0;
  bool drives = false, in_cycle = false, hold = false, limit = false, resetting = false, held = false, limited = false,
       done = false, spindle = false, coolant = false, changer = false, running = false, fault = false, wait = false;
};
constexpr const char* kWatched[] = {"SetX",        "SetY",        "SetZ",      "ActualX",     "ActualY", "ActualZ",
                                    "Speed",       "Line",        "DrivesOn",  "InCycle",     "Hold",    "LimitStop",
                                    "Resetting",   "Held",        "Limited",   "Done",        "Spindle", "Coolant",
                                    "ToolChanger", "LampRunning", "LampFault", "LampOperator"};

using Trace = std::vector<Row>;

Trace read_trace(const std::string& file) {
  std::ifstream in(file);
  Trace trace;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    const char* at = line.c_str();
    const auto next = [&at] {
      char* end = nullptr;
      const double value = std::strtod(at, &end);
      at = *end == ',' ? end + 1 : end;
      return value;
    };
    next();  // the number of the cycle
    Row row;
    row.seconds = next() / 1000;
    for (double& value : row.set) value = next();
    for (double& value : row.actual) value = next();
    row.speed = next();
    row.line = static_cast<int>(next());
    for (bool* const value :
         {&row.drives, &row.in_cycle, &row.hold, &row.limit, &row.resetting, &row.held, &row.limited, &row.done,
          &row.spindle, &row.coolant, &row.changer, &row.running, &row.fault, &row.wait}) {
      *value = next() != 0;
    }
    trace.push_back(row);
  }
  return trace;
}

/// A place in it.
using At = Trace::const_iterator;

/// The first row from `from` on for which `what` holds.
template <class What>
At next(At from, const Trace& trace, What what) {
  return std::find_if(from, trace.end(), what);
}

class CncExample : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* file : {"cnc.xml", "plc.toml", "operator.csv", "part.nc"}) {
      std::filesystem::copy_file(source_root() / "examples/cnc" / file, folder.file(file));
      ::chmod(folder.file(file).c_str(), 0644);
    }
    std::filesystem::create_directory(folder.file("build"));
    ::chmod(folder.file("build").c_str(), 0755);
    std::filesystem::copy_file(PLC_CNC_BLOCKS, folder.file("build/libcnc.so"));
    ::chmod(folder.file("build/libcnc.so").c_str(), 0755);
  }
  /// In the folder of the example, as its README says.
  [[nodiscard]] ToolResult shell(const std::string& command, unsigned seconds = 120) const {
    return run_tool({"/bin/sh", "-ec", "cd \"$0\"; umask 022; PATH=\"$1:$2:$PATH\"\n" + command, folder.file(""),
                     std::filesystem::path(PLC_TOOL).parent_path(), std::filesystem::path(PLC_RUN_TOOL).parent_path()},
                    seconds);
  }
  void write(const std::string& file, const std::string& text) const { std::ofstream(folder.file(file)) << text; }
  /// The project with something else of it: the text must be there.
  void change(const std::string& from, const std::string& to) const {
    std::string project = text_of(folder.file("cnc.xml"));
    const std::size_t at = project.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    write("cnc.xml", project.replace(at, from.size(), to));
  }
  /// Runs `script`: rows of "time_ms,ResetButton,StartButton,HoldButton,DoorClosed,EmergencyOk,LimitBridge,
  /// OptionalStop".
  [[nodiscard]] Trace run(const std::string& script) const {
    write("script.csv",
          "time_ms,ResetButton,StartButton,HoldButton,DoorClosed,EmergencyOk,LimitBridge,OptionalStop\n" + script);
    std::string command = "plc sim cnc.xml --config plc.toml --stimulus script.csv --trace trace.csv";
    for (const char* name : kWatched) command += std::string(" --watch ") + name;
    const ToolResult result = shell(command);
    EXPECT_EQ(result.code, 0) << result.all();
    EXPECT_NE(result.out.find(" 0 events, 0 faults"), std::string::npos) << result.all();
    return read_trace(folder.file("trace.csv"));
  }
  ScratchFolder folder;
};

/// Of every axis, whatever happens.
void expect_limits(const Trace& trace) {
  double acceleration = 0;
  double following_error = 0;
  for (std::size_t i = 2; i < trace.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double step = trace[i].set[k] - 2 * trace[i - 1].set[k] + trace[i - 2].set[k];
      acceleration = std::max(acceleration, std::fabs(step) / (kPeriod * kPeriod));
      following_error = std::max(following_error, std::fabs(trace[i].set[k] - trace[i].actual[k]));
    }
  }
  EXPECT_LE(acceleration, kAcceleration * (1 + 1e-6));
  EXPECT_GT(acceleration, kAcceleration / 2) << "it moves";
  EXPECT_LE(following_error, kFollowingTolerance);
  EXPECT_GT(following_error, 0);
}

/// The greatest distance from the part program, which began at `begin`.
double path_deviation(At begin, At end, const std::string& program) {
  std::vector<Point> positions;
  std::vector<std::int32_t> lines;
  for (At row = begin; row != end; ++row) {
    positions.push_back(row->set);
    lines.push_back(row->line);
  }
  // Before the first segment LINE is that of another program.
  lines.front() = 0;
  for (std::size_t i = 1; i < lines.size() && positions[i] == positions[0]; ++i) lines[i] = 0;
  return cnc::worst_deviation(positions, lines, cnc::programmed(program, begin->set));
}

/// The axes come to rest in time after `row`, and how far they go until then.
At expect_stop(At row, const Trace& trace) {
  EXPECT_GT(row->speed, 5) << "it was moving";
  const At rest = next(row, trace, [](const Row& r) { return r.held; });
  EXPECT_NE(rest, trace.end());
  if (rest == trace.end()) return rest;
  EXPECT_LE(rest->seconds - row->seconds, stopping_seconds(row->speed)) << "at " << row->seconds << " s";
  EXPECT_EQ(rest->speed, 0);
  return rest;
}

const auto in_cycle = [](const Row& r) { return r.in_cycle; };
const auto not_in_cycle = [](const Row& r) { return !r.in_cycle; };

// Start, a feed hold in the middle, a limit switch near the end, reset with the switch bridged, and the whole part.
TEST_F(CncExample, MillsThePartThroughHoldLimitAndReset) {
  change("<value member=\"HIGH\"><simpleValue value=\"150.0\"/>",
         "<value member=\"HIGH\"><simpleValue value=\"100.0\"/>");
  const Trace trace =
      run("0,0,0,0,1,1,0,0\n"
          "200,1,,,,,,\n400,0,,,,,,\n"
          "600,,1,,,,,\n800,,0,,,,,\n"
          "20000,,,1,,,,\n20200,,,0,,,,\n"
          "22000,,1,,,,,\n22200,,0,,,,,\n"
          "70000,1,,,,,1,\n70200,0,,,,,,\n"
          "71000,,1,,,,,\n71200,,0,,,,,\n"
          "135000,,,,,,,\n");
  ASSERT_GT(trace.size(), 130000u);
  const std::string program = text_of(folder.file("part.nc"));
  expect_limits(trace);

  // The program: tool, then spindle, then coolant.
  const At begin = next(trace.begin(), trace, in_cycle);
  ASSERT_NE(begin, trace.end());
  EXPECT_NEAR(begin->seconds, 0.6, 0.02);
  const At changer = next(begin, trace, [](const Row& r) { return r.changer; });
  const At changed = next(changer, trace, [](const Row& r) { return !r.changer; });
  const At spindle = next(begin, trace, [](const Row& r) { return r.spindle; });
  const At coolant = next(begin, trace, [](const Row& r) { return r.coolant; });
  const At moved = next(begin, trace, [](const Row& r) { return r.speed > 0; });
  ASSERT_NE(coolant, trace.end());
  ASSERT_NE(moved, trace.end());
  EXPECT_NEAR(changed->seconds - changer->seconds, 1.5, 0.011);
  EXPECT_GE(spindle, changed);
  EXPECT_GE(moved->seconds - spindle->seconds, 0.2) << "the spindle is at its speed first";
  EXPECT_GT(moved, coolant);

  // The feed hold.
  const At hold = next(moved, trace, [](const Row& r) { return r.hold; });
  ASSERT_NE(hold, trace.end());
  EXPECT_NEAR(hold->seconds, 20, 0.02);
  const At rest = expect_stop(hold, trace);
  const At on = next(rest, trace, [](const Row& r) { return !r.hold; });
  ASSERT_NE(on, trace.end());
  EXPECT_NEAR(on->seconds, 22, 0.02);
  EXPECT_EQ((on - 1)->set, rest->set) << "nothing moves in a hold";
  EXPECT_TRUE(rest->spindle) << "but the spindle";
  EXPECT_FALSE(rest->running);

  // The limit switch: the outline goes to X = 103.
  const At limit = next(on, trace, [](const Row& r) { return r.limit; });
  ASSERT_NE(limit, trace.end());
  EXPECT_GE(limit->actual[0], 100);
  const At stopped = expect_stop(limit, trace);
  EXPECT_LE(stopped->set[0], 103);
  EXPECT_TRUE(stopped->limited);
  EXPECT_TRUE(next(stopped, trace, [](const Row& r) { return r.fault; }) - stopped < 20) << "the lamp";
  const At reset = next(stopped, trace, [](const Row& r) { return r.resetting; });
  ASSERT_NE(reset, trace.end());
  EXPECT_NEAR(reset->seconds, 70, 0.02);
  EXPECT_EQ(reset->set, stopped->set) << "it stays until reset";
  EXPECT_LE(path_deviation(begin, reset, program), kPathTolerance + 1e-6);

  // Everything is back.
  const At ready = next(reset, trace, [](const Row& r) { return !r.resetting; });
  ASSERT_NE(ready, trace.end());
  EXPECT_LT(ready->seconds - reset->seconds, 0.3);
  const At later = ready + 100;
  EXPECT_FALSE(later->limited || later->in_cycle || later->spindle || later->coolant || later->fault);
  EXPECT_EQ(later->set, stopped->set);

  const At again = next(ready, trace, in_cycle);
  ASSERT_NE(again, trace.end());
  EXPECT_EQ(again->set, stopped->set) << "the part begins from where the tool is";
  const At end = next(again, trace, not_in_cycle);
  ASSERT_NE(end, trace.end());
  EXPECT_TRUE(end->done);
  EXPECT_EQ(end->set, (Point{0, 0, 25}));
  EXPECT_FALSE(end->spindle || end->coolant) << "M30";
  EXPECT_LT(end->seconds - again->seconds, 62);
  const double deviation = path_deviation(again, end, program);
  EXPECT_LE(deviation, kPathTolerance + 1e-6);
  EXPECT_GT(deviation, kPathTolerance / 2) << "corners are rounded";
  std::vector<Point> positions;
  for (At row = again; row != end; ++row) positions.push_back(row->set);
  EXPECT_LE(cnc::worst_miss(positions, cnc::programmed(program, again->set)), kPathTolerance + 120 * kPeriod);

  // The picture of this part, with the figures that were computed here in another way.
  double following_error = 0;
  for (At row = again; row != end; ++row) {
    for (std::size_t k = 0; k < 3; ++k) {
      following_error = std::max(following_error, std::fabs(row->set[k] - row->actual[k]));
    }
  }
  const std::string picture = text_of(folder.file("path.svg"));
  std::smatch figures;
  ASSERT_TRUE(std::regex_search(
      picture, figures, std::regex("Set points at most ([0-9.]+) mm from the program, axes at most ([0-9.]+) mm")))
      << picture.substr(0, 300);
  EXPECT_NEAR(std::stod(figures[1]), deviation, 0.0001);
  EXPECT_NEAR(std::stod(figures[2]), following_error, 0.0001);
}

// As its README says; the picture there is this one.
TEST_F(CncExample, TheOperatorOfTheExampleGetsThePictureOfTheReadme) {
  const ToolResult result =
      shell("plc sim cnc.xml --config plc.toml --stimulus operator.csv --watch InCycle --watch Done | tail -n 1");
  ASSERT_EQ(result.code, 0) << result.all();
  EXPECT_EQ(result.out.substr(result.out.size() - 5), ",0,1\n") << result.out;
  const ToolResult lint = run_tool({"/usr/bin/env", "xmllint", "--noout", folder.file("path.svg")});
  if (lint.code != 127) {
    EXPECT_EQ(lint.code, 0) << lint.err;
  }
  EXPECT_LT(std::filesystem::file_size(folder.file("path.svg")), 60'000u);
  expect_golden("examples/cnc/path.svg", text_of(folder.file("path.svg")));
}

TEST_F(CncExample, TheProjectHasNoWarningsAndFitsItsConfiguration) {
  for (const char* command : {"plc check --werror cnc.xml --config plc.toml", "plc config check plc.toml cnc.xml"}) {
    const ToolResult result = shell(command);
    EXPECT_EQ(result.code, 0) << command << '\n' << result.all();
    EXPECT_EQ(result.all().find("warning:"), std::string::npos) << result.all();
  }
}

TEST_F(CncExample, TheLadderAnswersCodesDoorAndEmergencyStop) {
  write("part.nc", "M3 S1000\nM1\nG1 X60 F6000\nM0\nX0\nX60\nX0\nM2\n");
  const Trace trace =
      run("0,0,0,0,1,1,0,1\n"
          "200,1,,,,,,\n400,0,,,,,,\n"
          "600,,1,,,,,\n800,,0,,,,,\n"
          "1500,,1,,,,,\n1600,,0,,,,,\n"    // M1, with the switch for it
          "1800,,,,0,,,\n2000,,,,1,,,\n"    // the door, on the way
          "2500,,1,,,,,\n2600,,0,,,,,\n"    //
          "4000,,1,,,,,\n4100,,0,,,,,\n"    // M0
          "4300,,,,,0,,\n5500,,,,,1,,\n"    // emergency stop, on the way
          "6000,1,,,,,,\n6100,0,,,,,0,0\n"  // now M1 does not stop
          "6500,,1,,,,,\n6600,,0,,,,,\n"
          "9000,,1,,,,,\n9100,,0,,,,,\n"
          "13000,,,,,,,\n");
  ASSERT_GT(trace.size(), 12000u);
  expect_limits(trace);
  const auto at = [&trace](double seconds) {
    return next(trace.begin(), trace, [seconds](const Row& r) { return r.seconds >= seconds; });
  };
  EXPECT_TRUE(at(1.4)->wait);
  EXPECT_EQ(at(1.4)->set[0], 0);
  EXPECT_FALSE(at(1.6)->wait);

  const At opened = next(at(1.8), trace, [](const Row& r) { return r.hold; });
  EXPECT_NEAR(opened->seconds, 1.8, 0.012);
  EXPECT_FALSE(opened->spindle) << "at once";
  const At rest = expect_stop(opened, trace);
  EXPECT_EQ(at(2.4)->set, rest->set) << "a door that is closed starts nothing";
  EXPECT_FALSE(at(2.4)->spindle);
  const At on = next(at(2.5), trace, [](const Row& r) { return r.speed > 0; });
  EXPECT_GE(on->seconds, 2.7) << "the spindle first";
  EXPECT_TRUE(on->spindle);

  EXPECT_TRUE(at(3.9)->wait);
  EXPECT_EQ(at(3.9)->set[0], 60);
  EXPECT_FALSE(at(4.2)->wait);
  const At emergency = next(at(4.3), trace, [](const Row& r) { return r.hold; });
  const At braked = expect_stop(emergency, trace);
  EXPECT_TRUE(braked->drives) << "braked by the drives";
  const At off = next(braked, trace, [](const Row& r) { return !r.drives; });
  EXPECT_NEAR(off->seconds, 4.8, 0.02);
  EXPECT_FALSE((off + 20)->in_cycle);
  EXPECT_EQ(at(5.9)->drives, false) << "power comes back by Reset alone";
  EXPECT_TRUE(at(6.2)->drives);
  EXPECT_LE(std::fabs(at(6.4)->actual[0] - braked->actual[0]), 0.002) << "no jump";

  // From the beginning, from where the tool is; one M0, and to the end.
  EXPECT_TRUE(at(7.5)->in_cycle);
  EXPECT_TRUE(at(8.9)->wait);
  EXPECT_EQ(at(8.9)->set[0], 60);
  EXPECT_TRUE(trace.back().done);
  EXPECT_FALSE(trace.back().in_cycle || trace.back().spindle);
}

TEST_F(CncExample, AnAxisThatDoesNotFollowStopsAllAndComesBackByReset) {
  // As good as no axis can.
  change("<value member=\"LOW\"><simpleValue value=\"-20.0\"/></value>",
         "<value member=\"LOW\"><simpleValue value=\"-20.0\"/></value><value member=\"MAX_ERROR\"><simpleValue "
         "value=\"0.004\"/></value>");
  write("part.nc", "G0 X60 Y60\nM30\n");
  const Trace trace =
      run("0,0,0,0,1,1,0,0\n200,1,,,,,,\n400,0,,,,,,\n600,,1,,,,,\n800,,0,,,,,\n"
          "3000,1,,,,,,\n3200,0,,,,,,\n4000,,,,,,,\n");
  const At begin = next(trace.begin(), trace, in_cycle);
  const At off = next(begin, trace, [](const Row& r) { return !r.drives; });
  ASSERT_NE(off, trace.end());
  EXPECT_LT(off->seconds, 1);
  const At later = off + 200;
  EXPECT_TRUE(later->fault);
  EXPECT_FALSE(later->in_cycle);
  EXPECT_EQ(later->set, later->actual) << "set points go with the axes";
  const At on = next(later, trace, [](const Row& r) { return r.drives; });
  ASSERT_NE(on, trace.end());
  EXPECT_NEAR(on->seconds, 3, 0.02);
  EXPECT_EQ(trace.back().actual, later->actual) << "no jump";
  EXPECT_TRUE(trace.back().drives);
  EXPECT_FALSE(trace.back().fault);
}

TEST_F(CncExample, RunsInRealTime) {
  // Beside other tests a scan may have to wait long for a processor.
  write("plc.toml", std::regex_replace(text_of(folder.file("plc.toml")), std::regex("100ms"), "5s"));
  const ToolResult result = shell(
      "plc-run cnc.xml --config plc.toml --modbus off --engineering off --duration 4s --watch Spindle --watch "
      "ToolChanger");
  EXPECT_EQ(result.code, 0) << result.all();
  EXPECT_NE(result.out.find("ToolChanger=1"), std::string::npos) << result.all();
  EXPECT_NE(result.out.find("Spindle=1"), std::string::npos) << result.all();
  EXPECT_EQ(result.all().find("allocate"), std::string::npos) << result.all();
  EXPECT_TRUE(std::filesystem::exists(folder.file("path.svg"))) << "of what was done until then";
}

// What somebody does who has the installed package.
TEST_F(CncExample, IsInstalledAndBuiltAsItsReadmeSays) {
  const std::string cmake = PLC_CMAKE;
  const ToolResult result =
      shell(cmake + " --install " PLC_BUILD " --prefix \"$0/prefix\" > /dev/null\n" +
                "cp -r prefix/share/picard/cnc mine\ncd mine\n" + cmake +
                " -S blocks -B build -DCMAKE_PREFIX_PATH=\"$0/prefix\" -DCMAKE_CXX_COMPILER=" PLC_CXX
                " -DCMAKE_CXX_FLAGS='-Wall -Wextra -Werror'\n" +
                cmake + " --build build\nPATH=\"$0/prefix/bin:$PATH\"\nplc check --werror cnc.xml --config plc.toml\n" +
                "plc sim cnc.xml --config plc.toml --stimulus operator.csv --cycles 5000 --watch Spindle | tail -n 1\n",
            300);
  ASSERT_EQ(result.code, 0) << result.all();
  EXPECT_NE(result.out.find(",1\n"), std::string::npos) << result.all();
}

}  // namespace
}  // namespace plc::test
