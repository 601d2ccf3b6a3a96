// Components of a test's own, from ST through compiler and linker to what they do.
#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "compiler/compile.h"
#include "core/clock.h"
#include "picard/taskblock.h"
#include "runtime/access.h"
#include "runtime/resource.h"
#include "taskblocks/registry.h"
#include "tests/support/run_tool.h"
#include "tests/taskblocks/project.h"

namespace plc::test {

struct Point {
  double x = 0;
  std::int16_t n = 0;
  picard::Text<10> name;
};

enum class Mode : std::int8_t { Off = 3, Manual = -1, Auto = 100 };
struct Order {
  Mode mode{};
  std::array<std::int16_t, 3> steps{};
};

}  // namespace plc::test

PICARD_STRUCT(plc::test::Point, "TEST_POINT", x, n, name)
PICARD_ENUM(plc::test::Mode, "TEST_MODE", Off, Manual, Auto)
PICARD_STRUCT(plc::test::Order, "TEST_ORDER", mode, steps)

namespace plc::test {
namespace {

int made = 0;
int destroyed = 0;

class Scale final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{.name = "SCALE_BY", .group = "Test", .summary = "OUT := IN * FACTOR."};
  picard::Input<double> in{this, "IN", "number"};
  picard::Config<double> factor{this, "FACTOR", "factor", {.initial = "2.0"}};
  picard::Output<double> out{this, "OUT", "product"};
  picard::Output<std::int64_t> address{this, "ADDRESS", "where IN is"};
  picard::Output<picard::Time> time{this, "TIME_SEEN", "the task's clock"};
  picard::Output<double> cycle{this, "PERIOD", "of the task", {.unit = "s"}};
  Scale() { ++made; }
  ~Scale() override { ++destroyed; }
  void ready() override { factor_ = factor; }
  void fire() override {
    out = in * factor_;
    address = static_cast<std::int64_t>(reinterpret_cast<std::intptr_t>(&in.get()));
    time = now();
    cycle = period();
  }

 private:
  double factor_ = 0;
};

/// Tells the operator, on the task's thread and on one of its own.
class Teller final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{.name = "TELLER", .group = "Test", .summary = "Tells the operator."};
  picard::Input<std::int32_t> times{this, "TIMES", "messages of an execution", {.initial = "1"}};
  picard::Input<bool> elsewhere{this, "ELSEWHERE", "by four threads, too"};
  void ready() override { tell(picard::Severity::Note, "ready"); }
  void fire() override {
    std::vector<std::thread> threads;
    for (int t = 0; elsewhere && t < 4; ++t) threads.emplace_back([this] { tell_times(); });
    tell_times();
    for (std::thread& thread : threads) thread.join();
  }

 private:
  void tell_times() const {
    for (std::int32_t i = 0; i < times; ++i) tell(picard::Severity::Warning, "number %d", i);
  }
};

/// Every shape a port may have.
class Shapes final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{.name = "SHAPES", .group = "Test", .summary = "Passes everything on."};
  picard::Input<std::array<std::array<std::int16_t, 3>, 2>> in_grid{this, "IN_GRID", ""};
  picard::Input<Point> in_point{this, "IN_POINT", ""};
  picard::Input<std::array<Point, 2>> in_points{this, "IN_POINTS", ""};
  picard::Input<picard::Text<5>> in_text{this, "IN_TEXT", ""};
  picard::Input<bool> in_flag{this, "IN_FLAG", ""};
  picard::Input<picard::Word> in_word{this, "IN_WORD", "", {.initial = "16#FF00"}};
  picard::Input<picard::Text<4, char16_t>> in_wide{this, "IN_WIDE", ""};
  picard::Output<std::array<std::array<std::int16_t, 3>, 2>> grid{this, "GRID", ""};
  picard::Output<Point> point{this, "POINT", ""};
  picard::Output<std::array<Point, 2>> points{this, "POINTS", ""};
  picard::Output<picard::Text<5>> text{this, "TEXT", ""};
  picard::Output<bool> flag{this, "FLAG", ""};
  picard::Output<picard::Word> word{this, "WORD_OUT", ""};
  picard::Output<picard::Text<4, char16_t>> wide{this, "WIDE", ""};
  void fire() override {
    grid = in_grid;
    point = in_point;
    points = in_points;
    text = in_text;
    flag = !in_flag;
    word = in_word;
    wide = in_wide;
  }
};

/// Initial values of every kind, enumerations, texts.
class Values final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{.name = "VALUES", .group = "Test", .summary = "Shows its values."};
  picard::Input<Mode> mode{this, "MODE", "of work", {.initial = "Manual"}};
  picard::Input<Mode> plain{this, "PLAIN", "begins with the first value"};
  picard::Input<std::array<double, 4>> row{this, "ROW", "", {.initial = "[1.5, 2(-2.0), 1E3]"}};
  picard::Config<Mode> start{this, "START", "before the first order", {.initial = "TEST_MODE#Auto"}};
  picard::Config<std::array<std::array<std::int16_t, 2>, 2>> grid{this, "GRID", "", {.initial = "[[1, 2], [3, 4]]"}};
  picard::Config<Point> point{this, "POINT", "", {.initial = "(n := 7, name := 'it$'s')"}};
  picard::Input<Order> order{this, "ORDER", "", {.initial = "(mode := Auto, steps := [3(9)])"}};
  picard::Output<Mode> ready_with{this, "READY_WITH", "START, when it was ready"};
  picard::Output<Mode> out{this, "OUT", "MODE"};
  picard::Output<Order> last{this, "LAST", "ORDER"};
  picard::Output<picard::Text<4>> text{this, "TEXT", "of POINT"};
  picard::Output<double> sum{this, "SUM", "of ROW"};
  void ready() override {
    if (grid[1][0] != 3) throw picard::Failure::format("GRID[1][0] is %d, not %s", grid[1][0], "three");
    ready_with = start;
  }
  void fire() override {
    if (mode == Mode::Off && plain == Mode::Off) throw picard::Failure(std::string("nothing") + " to do");
    out = mode;
    last = order;
    text = point->name.view();
    sum = row[0] + row[1] + row[2] + row[3];
  }
};

class Faulty final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{.name = "FAULTY", .group = "Test", .summary = "Does what KIND says."};
  picard::Input<std::int16_t> kind{this, "KIND", "1 throws, 2 throws no std::exception, 3 gives no number, 4 too much"};
  picard::Config<bool> refuse{this, "REFUSE", "ready() throws"};
  picard::Output<double> out{this, "OUT", "0 .. 10", {.lowest = 0, .highest = 10}};
  picard::Output<std::int16_t> count{this, "COUNT", "0 .. 3", {.lowest = 0, .highest = 3}};
  void ready() override {
    if (refuse) throw picard::Failure("REFUSE is TRUE");
  }
  void fire() override {
    if (kind == 1) throw std::runtime_error("kind one");
    if (kind == 2) throw 2;  // NOLINT(hicpp-exception-baseclass)
    out = kind == 3 ? std::numeric_limits<double>::quiet_NaN() : kind == 4 ? 11.0 : 5.0;
    count = static_cast<std::int16_t>(count + 1);
  }
};

class Timed final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "TIMED", .group = "Test", .summary = "Has a budget.", .budget = std::chrono::microseconds(50)};
  picard::Output<std::int16_t> count{this, "COUNT", "executions"};
  void fire() override { count = static_cast<std::int16_t>(count + 1); }
};

PICARD_LINKED_LIBRARY(test_library, "test", "1.0.0", Scale, Shapes, Values, Faulty, Timed, Teller)

const taskblocks::Registry& registry() {
  static const taskblocks::Registry all = [] {
    taskblocks::Registry r;
    const auto problem = r.add(test_library());
    if (problem) throw std::logic_error(problem->message);
    return r;
  }();
  return all;
}

/// Moves on by `step` each time somebody looks.
class RunningClock final : public core::Clock {
 public:
  [[nodiscard]] core::TimeNs now_ns() const noexcept override { return now_ += step; }
  void sleep_until_ns(core::TimeNs) noexcept override {}
  core::TimeNs step = 0;

 private:
  mutable core::TimeNs now_ = 0;
};

struct Project : TaskblockProject {
  explicit Project(const std::string& text, const runtime::ProgramOptions& options = {})
      : TaskblockProject(registry(), text, options) {}
};

TEST(Taskblocks, RunWithTheirConfigurationInEachInstance) {
  static_cast<void>(registry());
  made = destroyed = 0;
  {
    Project p(in_task(
        "A : SCALE_BY; B : ARRAY[1..2] OF SCALE_BY := [2((FACTOR := 5.0))]; C : SCALE_BY; X : LREAL; i : INT;\n",
        "X := X + 1.0;\nA(IN := X, FACTOR := 3.0);\nFOR i := 1 TO 2 DO B[i](IN := X); END_FOR;\nC(IN := A.OUT);\n"));
    ASSERT_NE(p.resource, nullptr) << p.problem;
    EXPECT_EQ(made, 4);
    EXPECT_FALSE(p.scan(7'000'000));
    EXPECT_FALSE(p.scan(17'000'000));
    EXPECT_EQ(p.value("Main.A.OUT"), "6");
    EXPECT_EQ(p.value("Main.B[2].OUT"), "10");
    EXPECT_EQ(p.value("Main.C.OUT"), "12");
    EXPECT_EQ(p.value("Main.A.PERIOD"), "0.01");
    EXPECT_EQ(p.value("Main.A.TIME_SEEN"), "17000000");
    EXPECT_EQ(p.resource->program(0).reset(), std::nullopt);
    EXPECT_EQ(p.value("Main.A.OUT"), "0");
    EXPECT_FALSE(p.scan());
    EXPECT_EQ(p.value("Main.C.OUT"), "6");
  }
  EXPECT_EQ(made, 8);
  EXPECT_EQ(destroyed, 8);
}

TEST(Taskblocks, AWireCopiesNothing) {
  Project p(in_task("A, B : SCALE_BY; X : LREAL; Copied : LREAL;\n", "X := X + 1.0;\nA(IN := X);\nB(IN := A.OUT);\n"));
  ASSERT_NE(p.resource, nullptr) << p.problem;
  EXPECT_FALSE(p.scan());
  EXPECT_EQ(p.value("Main.B.OUT"), "4");
  // The input is where the output of the other one is, and whoever asks for it sees that.
  const runtime::Access access(*p.resource);
  const auto out = access.find("Main.A.OUT");
  const auto in = access.find("Main.B.IN");
  ASSERT_TRUE(out && in);
  EXPECT_EQ(out->offset, in->offset);
  const auto* const at = p.resource->program(0).table().data() + out->offset;
  EXPECT_EQ(p.value("Main.B.ADDRESS"), std::to_string(reinterpret_cast<std::intptr_t>(at)));
  EXPECT_EQ(p.resource->image().pous[0].wires.size(), 2u);
}

TEST(Taskblocks, AWireIsACopyWhereTheVariableChangesBefore) {
  struct Case {
    const char* statements;
    const char* result;  ///< of B.OUT in the second scan
  };
  for (const Case& c : {
           Case{"X := X + 1.0;\nA(IN := X);\nX := 100.0;\nB(IN := X);\nX := 1.0;\n", "200"},
           // Read elsewhere, so that it has to be there.
           Case{"X := X + 1.0;\nB(IN := X);\nCopied := B.IN;\nX := Copied;\n", "4"},
           // Executed twice.
           Case{"X := X + 1.0;\nB(IN := X);\nB(IN := A.OUT);\n", "0"},
           // In a branch.
           Case{"X := X + 1.0;\nIF X > 1.5 THEN B(IN := X); END_IF;\n", "4"},
       }) {
    Project p(in_task("A, B : SCALE_BY; X : LREAL; Copied : LREAL;\n", c.statements));
    ASSERT_NE(p.resource, nullptr) << p.problem << c.statements;
    EXPECT_FALSE(p.scan());
    EXPECT_FALSE(p.scan());
    EXPECT_EQ(p.value("Main.B.OUT"), c.result) << c.statements;
  }
}

TEST(Taskblocks, PortsOfEveryShapeAreSeenAsDeclared) {
  Project p(in_task(
      "S : SHAPES; P : TEST_POINT := (x := 1.5, n := 7, name := 'abc'); Text : STRING[5] := 'hello';\n"
      "Points : ARRAY[0..1] OF TEST_POINT := [(x := 2.5), (n := 9)];\n"
      "Grid : ARRAY[0..1] OF ARRAY[0..2] OF INT := [[1,2,3],[4,5,6]]; Wide : WSTRING[4] := \"wxyz\";\n",
      "S(IN_GRID := Grid, IN_POINT := P, IN_POINTS := Points, IN_TEXT := Text, IN_FLAG := FALSE, IN_WIDE := Wide);\n"));
  ASSERT_NE(p.resource, nullptr) << p.problem;
  EXPECT_FALSE(p.scan());
  EXPECT_EQ(p.value("Main.S.GRID[1][2]"), "6");
  EXPECT_EQ(p.value("Main.S.POINT.x"), "1.5");
  EXPECT_EQ(p.value("Main.S.POINT.n"), "7");
  EXPECT_EQ(p.value("Main.S.POINT.name"), "'abc'");
  EXPECT_EQ(p.value("Main.S.POINTS[0].x"), "2.5");
  EXPECT_EQ(p.value("Main.S.POINTS[1].n"), "9");
  EXPECT_EQ(p.value("Main.S.TEXT"), "'hello'");
  EXPECT_EQ(p.value("Main.S.FLAG"), "1");
  EXPECT_EQ(p.value("Main.S.WORD_OUT"), "65280");
  EXPECT_EQ(p.value("Main.S.WIDE"), "\"wxyz\"");
}

TEST(Taskblocks, PortsHaveTheInitialValuesOfTheirDeclaration) {
  Project p(in_task("V : VALUES;\n", "V();\n"));
  ASSERT_NE(p.resource, nullptr) << p.problem;
  EXPECT_EQ(p.value("Main.V.PLAIN"), "3");
  EXPECT_EQ(p.value("Main.V.READY_WITH"), "100");
  EXPECT_FALSE(p.scan());
  EXPECT_EQ(p.value("Main.V.OUT"), "-1");
  EXPECT_EQ(p.value("Main.V.SUM"), "997.5");
  EXPECT_EQ(p.value("Main.V.TEXT"), "'it$'s'");
  EXPECT_EQ(p.value("Main.V.LAST.mode"), "100");
  EXPECT_EQ(p.value("Main.V.LAST.steps[2]"), "9");
  // What an instance says counts, and what it does not say stays.
  Project q(
      in_task("V : VALUES := (ROW := [4(1.0)], POINT := (name := 'longer'), ORDER := (steps := [1, 2]));\n", "V();\n"));
  ASSERT_NE(q.resource, nullptr) << q.problem;
  EXPECT_FALSE(q.scan());
  EXPECT_EQ(q.value("Main.V.SUM"), "4");
  EXPECT_EQ(q.value("Main.V.TEXT"), "'long'") << "cut";
  EXPECT_EQ(q.value("Main.V.POINT.n"), "7");
  EXPECT_EQ(q.value("Main.V.LAST.mode"), "100");
}

TEST(Taskblocks, EnumerationsAreTypesOfTheProject) {
  Project p(in_task("V : VALUES := (START := Manual); M : TEST_MODE := Auto; N, First : TEST_MODE;\n",
                    "V(MODE := M, PLAIN := TEST_MODE#Manual);\n"
                    "CASE V.OUT OF Auto: N := Manual; Manual: N := Off; END_CASE;\nM := N;\n"));
  ASSERT_NE(p.resource, nullptr) << p.problem;
  EXPECT_EQ(p.value("Main.V.READY_WITH"), "-1");
  EXPECT_EQ(p.value("Main.First"), "3");
  EXPECT_FALSE(p.scan());
  EXPECT_EQ(p.value("Main.V.OUT"), "100");
  EXPECT_FALSE(p.scan());
  EXPECT_EQ(p.value("Main.V.OUT"), "-1");
  EXPECT_EQ(p.value("Main.N"), "3");
  EXPECT_NE(Project(in_task("V : VALUES;\n", "V(MODE := 1);\n")).problem, "");
  EXPECT_NE(Project(in_task("V : VALUES;\n", "V(MODE := Fast);\n")).problem, "");
  EXPECT_EQ(Project(in_task("V : VALUES; M : TEST_MODE;\n", "V(START := M);\n")).problem, "P4110 ");
}

TEST(Taskblocks, AnEnumerationOfTheProjectMustBeTheirs) {
  const auto with = [](const std::string& own) {
    return Project(in_task("V : VALUES;\n", "V();\n", "TYPE TEST_MODE : " + own + "; END_TYPE\n"));
  };
  EXPECT_EQ(with("SINT (Off := 3, Manual := -1, Auto := 100)").problem, "");
  const std::string all = taskblocks::declaration(*registry().find("VALUES")->block);
  EXPECT_EQ(Project(in_task("V : VALUES;\n", "V();\n", all)).problem, "") << "as editors bring it back";
  for (const char* own :
       {"INT (Off := 3, Manual := -1, Auto := 100)", "SINT (Off := 3, Manual := -1, Auto := 99)",
        "SINT (Off := 3, Manual := -1, Auto := 100, Last := 101)", "SINT (Hand := 3, Manual := -1, Auto := 100)"}) {
    EXPECT_TRUE(with(own).problem.starts_with("P7802")) << own << ": " << with(own).problem;
  }
}

TEST(Taskblocks, SayWhatTheyFoundWhenTheyFail) {
  EXPECT_EQ(Project(in_task("V : VALUES := (GRID := [[0, 0], [-5, 0]]);\n", "V();\n")).problem,
            "P7803: taskblock VALUES of main.V: GRID[1][0] is -5, not three");
  Project p(in_task("V : VALUES;\n", "V(MODE := Off);\n"));
  ASSERT_NE(p.resource, nullptr) << p.problem;
  EXPECT_EQ(p.resource->program(0).taskblock_text(p.scan()), "VALUES main.V: nothing to do");
}

TEST(Taskblocks, ConfigurationTakesConstantsOnly) {
  EXPECT_EQ(Project(in_task("A : SCALE_BY; X : LREAL;\n", "A(IN := X, FACTOR := X);\n")).problem, "P4110 ");
  EXPECT_EQ(Project(in_task("A : SCALE_BY; X : LREAL;\n", "A(IN := X, FACTOR := X + 1.0);\n")).problem, "P4110 ");
  EXPECT_EQ(Project(in_task("A : ARRAY[1..2] OF SCALE_BY; i : INT;\n", "A[i](FACTOR := 1.0);\n")).problem, "P4110 ");
  Project p(in_task("A : ARRAY[1..2] OF SCALE_BY;\n",
                    "A[1](IN := 1.0, FACTOR := 2.0 * 4.0);\nA[2](IN := 1.0, FACTOR := K);\n",
                    "VAR_GLOBAL CONSTANT K : LREAL := 9.0; END_VAR\n"));
  ASSERT_NE(p.resource, nullptr) << p.problem;
  EXPECT_FALSE(p.scan());
  EXPECT_EQ(p.value("Main.A[1].OUT"), "8");
  EXPECT_EQ(p.value("Main.A[2].OUT"), "9");
}

TEST(Taskblocks, GlobalInstancesBelongToTheTaskThatRunsThem) {
  Project p(in_task("X : LREAL;\n", "X := X + 1.0;\nShared(IN := X, FACTOR := 4.0);\n",
                    "VAR_GLOBAL Shared : SCALE_BY; END_VAR\n"));
  ASSERT_NE(p.resource, nullptr) << p.problem;
  EXPECT_FALSE(p.scan());
  EXPECT_FALSE(p.scan());
  EXPECT_EQ(p.value("Shared.OUT"), "8");
}

TEST(Taskblocks, AThrowIsAFaultThatNamesThem) {
  for (const char* kind : {"1", "2"}) {
    Project p(in_task("F : FAULTY; Before, After : INT;\n",
                      "Before := Before + 1;\nF(KIND := " + std::string(kind) + ");\nAfter := After + 1;\n"));
    ASSERT_NE(p.resource, nullptr) << p.problem;
    const runtime::Fault fault = p.scan();
    EXPECT_EQ(fault.kind, runtime::FaultKind::kTaskblock);
    EXPECT_EQ(
        p.resource->program(0).taskblock_text(fault),
        kind == std::string("1") ? "FAULTY main.F: kind one" : "FAULTY main.F: an exception that is no std::exception");
    EXPECT_EQ(runtime::source_of(p.resource->image(), fault.pou, fault.word).line, 6u);
    EXPECT_EQ(p.value("Main.Before"), "1");
    EXPECT_EQ(p.value("Main.After"), "0");
  }
}

TEST(Taskblocks, OutputsOutsideTheirRangeAreLimitedAndCounted) {
  Project p(in_task("F : FAULTY;\n", "F(KIND := 3);\n"));
  ASSERT_NE(p.resource, nullptr) << p.problem;
  EXPECT_FALSE(p.scan());
  EXPECT_EQ(p.value("Main.F.OUT"), "0");
  EXPECT_EQ(p.resource->program(0).event_total(), 1u);
  Project q(in_task("F : FAULTY;\n", "F(KIND := 4);\n"));
  ASSERT_NE(q.resource, nullptr) << q.problem;
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(q.scan());
  EXPECT_EQ(q.value("Main.F.OUT"), "10");
  EXPECT_EQ(q.value("Main.F.COUNT"), "3");
  EXPECT_EQ(q.resource->program(0).event_total(), 5u);
  EXPECT_EQ(q.resource->program(0).events().front().last, stdlib::Event::kOutOfRange);
}

TEST(Taskblocks, TellTheOperator) {
  Project p(in_task("A : TELLER; B : TELLER := (TIMES := 2);\n", "A();\nB();\n"));
  ASSERT_NE(p.resource, nullptr) << p.problem;
  runtime::Program& program = p.resource->program(0);
  EXPECT_FALSE(program.execute({0, 0, 1000}));
  EXPECT_FALSE(program.execute({0, 0, 2000}));
  const auto told = program.messages();
  ASSERT_EQ(told.size(), 8u);
  EXPECT_EQ(told[0].taskblock, "TELLER main.A");
  EXPECT_EQ(told[0].text, "ready");
  EXPECT_EQ(told[0].utc_ns, 0) << "before the first scan";
  EXPECT_EQ(told[1].taskblock, "TELLER main.B");
  EXPECT_EQ(told[7].taskblock, "TELLER main.B");
  EXPECT_EQ(told[7].text, "number 1");
  EXPECT_EQ(told[7].severity, core::Severity::kWarning);
  EXPECT_EQ(told[7].scan, 1u);
  EXPECT_EQ(told[7].utc_ns, 2000);
  EXPECT_TRUE(program.messages().empty());
  EXPECT_EQ(program.lost_messages(), 0u);
}

TEST(Taskblocks, WhatTheyTellIsBoundedAndCounted) {
  Project p(in_task("A : TELLER := (TIMES := 200, ELSEWHERE := TRUE);\n", "A();\n"));
  ASSERT_NE(p.resource, nullptr) << p.problem;
  runtime::Program& program = p.resource->program(0);
  for (int scan = 0; scan < 20; ++scan) {
    EXPECT_FALSE(p.scan());
    const auto told = program.messages();
    EXPECT_LE(told.size(), runtime::MessageRing::kPlaces);
    EXPECT_GE(told.size(), 1u);
    EXPECT_EQ(told.size() + program.lost_messages(), 5u * 200 + (scan == 0 ? 1 : 0));
    for (const auto& one : told) EXPECT_TRUE(one.text.starts_with("number ") || one.text == "ready") << one.text;
  }
}

TEST(Taskblocks, ABudgetIsMeasuredWhereThereIsAClock) {
  RunningClock clock;
  const std::string text = in_task("B : TIMED;\n", "B();\n");
  Project p(text, {.budget_clock = &clock});
  ASSERT_NE(p.resource, nullptr) << p.problem;
  clock.step = 50'000;
  EXPECT_FALSE(p.scan());
  clock.step = 50'001;
  const runtime::Fault fault = p.scan();
  EXPECT_EQ(fault.kind, runtime::FaultKind::kBudget);
  EXPECT_EQ(p.resource->program(0).taskblock_text(fault), "TIMED main.B");
  Project q(text);
  EXPECT_FALSE(q.scan());
}

TEST(Taskblocks, WhatIsNotReadyIsNotLoaded) {
  Project p(in_task("F : FAULTY;\n", "F(REFUSE := TRUE);\n"));
  EXPECT_EQ(p.problem, "P7803: taskblock FAULTY of main.F: REFUSE is TRUE");
}

TEST(Taskblocks, AnImageForOtherBlocksIsRefused) {
  const ScratchFolder scratch;
  std::ofstream(scratch.file("test.st")) << in_task("A : SCALE_BY;\n", "A();\n");
  compiler::Compilation compilation;
  compiler::Request request{scratch.file("test.st"), {}, compiler::Goal::kRun};
  request.taskblocks = &registry();
  compiler::compile(request, compilation);
  ASSERT_TRUE(compilation.image);
  bytecode::Image image = compilation.image->image();
  const auto missing = runtime::Resource::load(std::move(*compilation.image), {});
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, core::Code::P7802);
  image.blocks[0].layout_hash ^= 1;
  core::Diagnostics diagnostics;
  auto verified = bytecode::verify(std::move(image), diagnostics);
  ASSERT_TRUE(verified);
  runtime::ProgramOptions options;
  options.taskblocks = &registry();
  const auto other = runtime::Resource::load(std::move(*verified), options);
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, core::Code::P7802);
}

TEST(Registry, RefusesWhatCannotBeUsed) {
  taskblocks::Registry r;
  picard_library library = *test_library();
  library.abi_version = 99;
  EXPECT_EQ(r.add(&library)->code, core::Code::P7801);
  library = *test_library();
  library.port_bytes += 8;
  EXPECT_TRUE(r.add(&library));
  library = *test_library();
  library.failure = "why";
  EXPECT_NE(r.add(&library)->message.find("why"), std::string::npos);
  const picard_type real = *picard::detail::type_of<double>();
  picard_type mode = *picard::detail::type_of<Mode>();
  mode.element = &real;
  const picard_port port{"MODE", &mode, PICARD_INPUT, "", "", "", 0, 0};
  picard_block block = test_library()->blocks[0];
  block.ports = &port;
  block.port_count = 1;
  library = *test_library();
  library.blocks = &block;
  library.block_count = 1;
  EXPECT_NE(r.add(&library)->message.find("an enumeration of LREAL"), std::string::npos);
  mode.enumerator_count = 0;
  EXPECT_NE(r.add(&library)->message.find("an enumeration without values"), std::string::npos);
  EXPECT_FALSE(r.add(test_library()));
  EXPECT_NE(r.add(test_library(), "second.so")->message.find("SCALE_BY is there already"), std::string::npos);
  EXPECT_EQ(r.entries().size(), 6u);
  EXPECT_NE(r.find("scale_by"), nullptr);
  EXPECT_EQ(r.find("nothing"), nullptr);
}

TEST(Registry, TakesLibrariesOfTheFirstInterface) {
  taskblocks::Registry r;
  picard_library library = *test_library();
  library.abi_version = 1;
  EXPECT_FALSE(r.add(&library));
  EXPECT_NE(r.find("SCALE_BY"), nullptr);
}

}  // namespace
}  // namespace plc::test
