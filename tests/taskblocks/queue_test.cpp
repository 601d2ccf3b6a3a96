// Queues between tasks: in texts, in drawings, at the ports of components, and from threads at full speed.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "picard/taskblock.h"
#include "tests/taskblocks/project.h"

namespace plc::test {

struct Message {
  std::int32_t writer = 0;
  std::int64_t number = 0;
  std::array<std::int32_t, 5> copies{};  ///< of the number, so that a torn element would show
};

}  // namespace plc::test

PICARD_STRUCT(plc::test::Message, "TEST_MESSAGE", writer, number, copies)

namespace plc::test {
namespace {

/// Puts as much as fits, BURST at most.
class Source final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{.name = "SOURCE", .group = "Test", .summary = "Puts numbered messages."};
  picard::Config<std::int32_t> writer{this, "WRITER", "who"};
  picard::Config<std::int32_t> burst{this, "BURST", "messages in a cycle", {.initial = "7"}};
  picard::QueueWriter<Message> messages{this, "MESSAGES", "where they go"};
  picard::Output<std::int64_t> put{this, "PUT", "messages put"};
  picard::Output<std::int64_t> full{this, "FULL", "cycles in which the queue was full"};
  void fire() override {
    for (int i = 0; i < burst; ++i) {
      Message m{writer, put, {}};
      m.copies.fill(static_cast<std::int32_t>(m.number));
      const auto space = messages.space();
      const bool taken = messages.push(m);
      if (taken != (space != 0) && !taken) throw picard::Failure("a queue with space was full");
      if (!taken) {
        full = full + 1;
        return;
      }
      put = put + 1;
    }
  }
};

/// Takes everything there is, and looks whether it is what was put.
class Sink final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{.name = "SINK", .group = "Test", .summary = "Checks numbered messages."};
  picard::QueueReader<Message> messages{this, "MESSAGES", "where they come from"};
  picard::Output<std::array<std::int64_t, 4>> taken{this, "TAKEN", "messages of each writer"};
  picard::Output<std::int64_t> wrong{this, "WRONG", "messages lost, doubled, out of order or torn"};
  picard::Output<std::int64_t> empty{this, "EMPTY", "cycles in which there was nothing"};
  void fire() override {
    Message m;
    bool any = false;
    for (int i = 0; i < 100 && messages.pop(m); ++i) {
      any = true;
      auto numbers = taken.get();
      std::int64_t& next = numbers.at(static_cast<std::size_t>(m.writer));
      bool fine = m.number == next;
      for (const std::int32_t copy : m.copies) fine = fine && copy == static_cast<std::int32_t>(m.number);
      if (!fine) wrong = wrong + 1;
      next = m.number + 1;
      taken = numbers;
    }
    if (!any) empty = empty + 1;
  }
};

PICARD_LINKED_LIBRARY(queue_library, "queues", "1.0.0", Source, Sink)

const taskblocks::Registry& registry() {
  static const taskblocks::Registry all = [] {
    taskblocks::Registry r;
    const auto problem = r.add(queue_library());
    if (problem) throw std::logic_error(problem->message);
    return r;
  }();
  return all;
}

struct Project : TaskblockProject {
  explicit Project(const std::string& text) : TaskblockProject(registry(), text) {}
};

/// Programs P0, P1, .. with these bodies (declarations and statements), each in a task of its own.
std::string in_tasks(const std::string& globals, const std::vector<std::string>& bodies) {
  std::string text = globals, instances;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const std::string n = std::to_string(i);
    text += "PROGRAM P" + n + "\n" + bodies[i] + "\nEND_PROGRAM\n";
    instances += "    TASK T" + n + "(INTERVAL := T#10ms, PRIORITY := " + n + ");\n    PROGRAM p" + n + " WITH T" + n +
                 " : P" + n + ";\n";
  }
  return text + "CONFIGURATION C\n  RESOURCE R ON PLC\n" + instances + "  END_RESOURCE\nEND_CONFIGURATION\n";
}

TEST(Queues, AreWrittenAndReadInTexts) {
  Project p(in_tasks("VAR_GLOBAL Orders : ARRAY [1..3] OF INT; END_VAR\n",
                     {"VAR n : INT; ok : BOOL; space : UDINT; END_VAR\nn := n + 1;\nok := QUEUE_PUT(Orders, n * 10);\n"
                      "space := QUEUE_SPACE(Orders);",
                      "VAR n : INT := -1; ok : BOOL; count : UDINT; go : BOOL; END_VAR\ncount := QUEUE_COUNT(Orders);\n"
                      "IF go THEN ok := QUEUE_GET(QUEUE := Orders, OUT => n); END_IF;"}));
  ASSERT_NE(p.resource, nullptr) << p.problem;
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(p.scan(0, 0));
  EXPECT_EQ(p.value("p0.ok"), "0");  // full: three fit
  EXPECT_EQ(p.value("p0.space"), "0");
  EXPECT_FALSE(p.scan(0, 1));
  EXPECT_EQ(p.value("p1.count"), "3");
  EXPECT_EQ(p.value("p1.n"), "-1");
  const runtime::Access access(*p.resource);
  const auto go = access.find("p1.go");
  ASSERT_TRUE(go);
  *(p.resource->program(1).table().data() + go->offset) = std::byte{1};
  for (const char* expected : {"10", "20", "30"}) {
    EXPECT_FALSE(p.scan(0, 1));
    EXPECT_EQ(p.value("p1.ok"), "1");
    EXPECT_EQ(p.value("p1.n"), expected);
  }
  EXPECT_FALSE(p.scan(0, 1));
  EXPECT_EQ(p.value("p1.ok"), "0");
  EXPECT_EQ(p.value("p1.n"), "0");
  EXPECT_EQ(p.value("p1.count"), "0");
  // A cold start empties it.
  EXPECT_FALSE(p.scan(0, 0));
  p.resource->globals().reset();
  EXPECT_FALSE(p.scan(0, 1));
  EXPECT_EQ(p.value("p1.count"), "0");
}

TEST(Queues, TakeElementsOfAnyType) {
  struct Case {
    const char* type;
    const char* value;
    const char* path;
    const char* shown;
  };
  for (const Case& c :
       {Case{"BOOL", "TRUE", "", "1"}, Case{"LREAL", "2.5", "", "2.5"}, Case{"STRING[7]", "'abcdefg'", "", "'abcdefg'"},
        Case{"WSTRING[3]", "\"xyz\"", "", "\"xyz\""}, Case{"TIME", "T#3s", "", "3000000000"},
        Case{"Colour", "Blue", "", "1"}, Case{"Grid", "g", "[2]", "9"}, Case{"TEST_MESSAGE", "m", ".number", "42"}}) {
    Project p(in_tasks(
        "TYPE Colour : (Red, Blue); Grid : ARRAY [1..2] OF INT; END_TYPE\nVAR_GLOBAL Q : ARRAY [0..1] OF " +
            std::string(c.type) + "; END_VAR\n",
        {"VAR g : Grid := [8, 9]; m : TEST_MESSAGE := (number := 42); ok : BOOL; END_VAR\nok := QUEUE_PUT(Q, " +
             std::string(c.value) + ");",
         "VAR x : " + std::string(c.type) + "; ok : BOOL; END_VAR\nok := QUEUE_GET(Q, OUT => x);"}));
    ASSERT_NE(p.resource, nullptr) << p.problem << c.type;
    EXPECT_FALSE(p.scan(0, 0));
    EXPECT_FALSE(p.scan(0, 1));
    EXPECT_EQ(p.value("p1.ok"), "1") << c.type;
    EXPECT_EQ(p.value("p1.x" + std::string(c.path)), c.shown) << c.type;
  }
}

TEST(Queues, OfSeveralTasksAreMergedInTurns) {
  const std::string put = "VAR ok : BOOL; END_VAR\n";
  Project p(in_tasks("VAR_GLOBAL Q : ARRAY [0..9] OF INT; END_VAR\n",
                     {put + "ok := QUEUE_PUT(Q, 1); ok := QUEUE_PUT(Q, 2); ok := QUEUE_PUT(Q, 3);",
                      put + "ok := QUEUE_PUT(Q, 10);", put + "ok := QUEUE_PUT(Q, 100); ok := QUEUE_PUT(Q, 200);",
                      "VAR a : ARRAY [0..9] OF INT; i : INT; n : INT; END_VAR\ni := 0;\n"
                      "WHILE QUEUE_GET(Q, OUT => n) DO a[i] := n; i := i + 1; END_WHILE;"}));
  ASSERT_NE(p.resource, nullptr) << p.problem;
  for (std::size_t task = 0; task < 4; ++task) EXPECT_FALSE(p.scan(0, task));
  EXPECT_EQ(p.value("p3.i"), "6");
  const std::array<const char*, 6> expected = {"1", "10", "100", "2", "200", "3"};
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(p.value("p3.a[" + std::to_string(i) + "]"), expected[i]);
}

TEST(Queues, AreBoundToThePortsOfComponents) {
  Project p(in_tasks(
      "VAR_GLOBAL Messages : ARRAY [0..9] OF TEST_MESSAGE; END_VAR\n",
      {"VAR a, b : SOURCE; END_VAR\na(WRITER := 0, MESSAGES := Messages);\nb(WRITER := 1, MESSAGES := Messages);",
       "VAR m : TEST_MESSAGE; ok : BOOL; END_VAR\nm.writer := 2;\nok := QUEUE_PUT(Messages, m);\nm.number := m.number "
       "+ 1;\n"
       "m.copies[0] := m.copies[0] + 1; m.copies[1] := m.copies[0]; m.copies[2] := m.copies[0];\n"
       "m.copies[3] := m.copies[0]; m.copies[4] := m.copies[0];",
       "VAR s : SINK; END_VAR\ns(MESSAGES := Messages);"}));
  ASSERT_NE(p.resource, nullptr) << p.problem;
  for (int i = 0; i < 100; ++i) {
    for (std::size_t task = 0; task < 3; ++task) ASSERT_FALSE(p.scan(0, task));
  }
  EXPECT_EQ(p.value("p2.s.WRONG"), "0");
  // Ten places for both components of one task: seven of the one and three of the other, then full.
  EXPECT_EQ(p.value("p2.s.TAKEN[0]"), "700");
  EXPECT_EQ(p.value("p2.s.TAKEN[1]"), "300");
  EXPECT_EQ(p.value("p2.s.TAKEN[2]"), "100");
  EXPECT_EQ(p.value("p0.b.FULL"), "100");
}

TEST(Queues, AreNoVariables) {
  const std::string queue = "VAR_GLOBAL Q : ARRAY [0..9] OF INT; x : INT; END_VAR\n";
  const std::string body = "VAR ok : BOOL; n : INT; END_VAR\n";
  const auto problem = [&](const std::string& statements, const std::string& globals = {}) {
    return Project(in_tasks(globals.empty() ? queue : globals, {body + statements})).problem;
  };
  EXPECT_EQ(problem("ok := QUEUE_PUT(Q, 1); Q[1] := 2;"), "P4112 ");
  EXPECT_EQ(problem("n := Q[3]; ok := QUEUE_PUT(Q, 1);"), "P4112 ");
  EXPECT_EQ(problem("ok := QUEUE_PUT(x, 1);"), "P4111 ");
  EXPECT_EQ(problem("ok := QUEUE_PUT(n, 1);"), "P4111 ");
  EXPECT_EQ(problem("ok := QUEUE_PUT(Q, 1.5);"), "P4107 ");
  EXPECT_EQ(problem("ok := QUEUE_PUT();"), "P4010 ");
  EXPECT_EQ(problem("ok := QUEUE_PUT(Q, 1);", "VAR_GLOBAL RETAIN Q : ARRAY [0..9] OF INT; END_VAR\n"), "P4111 ");
  EXPECT_EQ(problem("ok := QUEUE_PUT(Q, 1);", "VAR_GLOBAL Q : ARRAY [0..9] OF INT := [1]; END_VAR\n"), "P4111 ");
  EXPECT_EQ(problem("ok := QUEUE_COUNT(Q) > 0;", "VAR_GLOBAL Q : ARRAY [0..9] OF TON; END_VAR\n"), "P4111 ");
  EXPECT_EQ(problem("ok := QUEUE_COUNT(Q) > 0;", "VAR_GLOBAL Q : ARRAY [0..9] OF REF_TO INT; END_VAR\n"), "P4111 ");
  EXPECT_EQ(Project(in_tasks(queue, {body + "ok := QUEUE_GET(Q, OUT => n);", body + "ok := QUEUE_GET(Q, OUT => n);"}))
                .problem,
            "P4205 ");
  // Of another type, not at all, and two for one port.
  const std::string messages = "VAR_GLOBAL Q : ARRAY [0..9] OF INT; M, N : ARRAY [0..9] OF TEST_MESSAGE; END_VAR\n";
  EXPECT_EQ(Project(in_tasks(messages, {"VAR s : SINK; END_VAR\ns(MESSAGES := Q);"})).problem, "P4111 ");
  EXPECT_EQ(Project(in_tasks(messages, {"VAR s : SINK; END_VAR\ns();"})).problem, "P4010 ");
  EXPECT_EQ(Project(in_tasks(messages, {"VAR s : SINK; END_VAR\ns(MESSAGES := M); s(MESSAGES := N);"})).problem,
            "P4111 ");
  EXPECT_EQ(
      Project(in_tasks(messages, {"VAR s : ARRAY [0..1] OF SINK; i : INT; END_VAR\ns[i](MESSAGES := M);"})).problem,
      "P4111 ");
}

/// Elements per writer; PLC_ELEMENTS raises it for longer runs.
std::int64_t elements() {
  const char* const text = std::getenv("PLC_ELEMENTS");
  return text == nullptr ? 100'000 : std::atoll(text);
}

TEST(Queues, OfThreeTasksAtFullSpeedLoseDoubleAndReorderNothing) {
  // Three writers at different rates: two components, and a text that has its own numbers.
  Project p(in_tasks(
      "VAR_GLOBAL Messages : ARRAY [0..31] OF TEST_MESSAGE; END_VAR\n",
      {"VAR s : SOURCE; END_VAR\ns(WRITER := 0, BURST := 1, MESSAGES := Messages);",
       "VAR s : SOURCE; END_VAR\ns(WRITER := 1, BURST := 50, MESSAGES := Messages);",
       "VAR m : TEST_MESSAGE; i : INT; n, refused : LINT; END_VAR\nm.writer := 2;\nFOR i := 1 TO 5 DO\n"
       "  m.number := n; m.copies[0] := LINT_TO_DINT(n); m.copies[1] := m.copies[0]; m.copies[2] := m.copies[0];\n"
       "  m.copies[3] := m.copies[0]; m.copies[4] := m.copies[0];\n"
       "  IF QUEUE_PUT(Messages, m) THEN n := n + 1; ELSE refused := refused + 1; END_IF;\nEND_FOR;",
       "VAR s : SINK; END_VAR\ns(MESSAGES := Messages);"}));
  ASSERT_NE(p.resource, nullptr) << p.problem;
  const runtime::Access access(*p.resource);
  const auto number_at = [&](std::size_t task, const std::string& path) {
    const auto found = access.find(path);
    if (!found) return std::int64_t{-1};
    std::int64_t value = 0;
    std::memcpy(&value, p.resource->program(task).table().data() + found->offset, sizeof value);
    return value;
  };
  const std::array<std::string, 3> counters = {"p0.s.PUT", "p1.s.PUT", "p2.n"};
  std::atomic<int> running{3};
  std::atomic<bool> fault{false};
  std::vector<std::thread> threads;
  for (std::size_t task = 0; task < 3; ++task) {
    threads.emplace_back([&, task] {
      while (!fault && number_at(task, counters[task]) < elements()) {
        if (p.scan(0, task)) fault = true;
      }
      --running;
    });
  }
  threads.emplace_back([&] {
    // Once more when all have ended: what is left.
    for (bool last = false; !last && !fault;) {
      last = running == 0;
      for (int i = 0; i < (last ? 2 : 1); ++i) {
        if (p.scan(0, 3)) fault = true;
      }
    }
  });
  for (std::thread& thread : threads) thread.join();
  EXPECT_FALSE(fault);
  EXPECT_EQ(number_at(3, "p3.s.WRONG"), 0);
  for (std::size_t task = 0; task < 3; ++task) {
    EXPECT_GE(number_at(task, counters[task]), elements());
    EXPECT_EQ(number_at(3, "p3.s.TAKEN[" + std::to_string(task) + "]"), number_at(task, counters[task]));
  }
}

}  // namespace
}  // namespace plc::test
