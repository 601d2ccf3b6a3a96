// What makes it hard to execute a scan again: one case each. Recorded in either engine, executed again in the other.
#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <fstream>
#include <thread>

#include "compiler/compile.h"
#include "native/compile.h"
#include "runtime/sched/simulation.h"
#include "shadow/player.h"
#include "shadow/recording.h"
#include "tests/support/run_tool.h"
#include "tests/unit/runtime/run_support.h"

namespace plc::test {
namespace {

using Bytes = std::vector<std::byte>;

constexpr const char* kOneTask =
    "CONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#10ms, PRIORITY := 0); PROGRAM main WITH T : Main; "
    "END_RESOURCE END_CONFIGURATION\n";
constexpr const char* kTwoTasks =
    "CONFIGURATION C RESOURCE R ON PLC TASK A(INTERVAL := T#10ms, PRIORITY := 0); TASK B(INTERVAL := T#10ms, PRIORITY "
    ":= "
    "1); PROGRAM first WITH A : First; PROGRAM second WITH B : Second; END_RESOURCE END_CONFIGURATION\n";

void compile_tasks(runtime::Resource& resource) {
  for (std::size_t task = 0; task < resource.task_count(); ++task) {
    auto compiled = native::compile(resource.program(task));
    ASSERT_TRUE(compiled) << compiled.error().message;
    resource.program(task).install(std::move(*compiled));
  }
}

class Adversary {
 public:
  Adversary(const std::string& text, bool native, shadow::RecordingOptions options = {}, std::uint32_t budget = 1000)
      : native_(native) {
    const ScratchFolder scratch;
    const std::string path = scratch.file("p.st");
    std::ofstream(path) << text;
    compiler::Compilation compilation;
    compiler::compile({path, {}, compiler::Goal::kRun}, compilation);
    EXPECT_TRUE(compilation.ok() && compilation.image);
    runtime::ProgramOptions program;
    program.loop_budget = budget;
    resource = std::move(*runtime::Resource::load(std::move(*compilation.image), program));
    if (native) compile_tasks(*resource);
    bytes_ = shadow::file_head({"PICARD test", "", 0, budget, "UTC", bytecode::save(resource->image())});
    auto started = shadow::Recording::start(
        *resource,
        [this](const shadow::BlockInfo&, const Bytes& block) {
          bytes_.insert(bytes_.end(), block.begin(), block.end());
        },
        options);
    EXPECT_TRUE(started);
    recording = std::move(*started);
  }

  runtime::Fault scan(std::uint32_t task) {
    now_ns += 10'000'000;
    return resource->program(task).execute({now_ns, 0, now_ns});
  }

  /// All scans again, in the other engine; how many, where each gives what it gave.
  std::uint64_t replayed() {
    recording->finish();
    const auto file = shadow::RecordFile::read(bytes_, "recording");
    EXPECT_TRUE(file);
    core::Diagnostics diagnostics;
    const auto player = shadow::Player::make(*file, diagnostics);
    EXPECT_TRUE(player);
    if (!native_) compile_tasks((*player)->resource());
    std::uint64_t scans = 0;
    while (const auto played = (*player)->step()) {
      EXPECT_TRUE(played->outcome.equal) << "task " << played->task << ", scan " << played->scan << ": "
                                         << played->outcome.differs;
      scans += played->outcome.ran ? 1 : 0;
      gaps += played->after_gap ? 1 : 0;
    }
    // After the last scan the tables are equal, whole: checksums look at a part of them only.
    for (std::uint32_t task = 0; whole && task < resource->task_count(); ++task) {
      const runtime::TaskTable& table = resource->program(task).table();
      EXPECT_EQ((*player)->replicas().difference(task, {table.data(), table.layout().total}), "") << "task " << task;
    }
    return scans;
  }

  std::unique_ptr<runtime::Resource> resource;
  std::unique_ptr<shadow::Recording> recording;
  core::TimeNs now_ns = 0;
  std::uint64_t gaps = 0;
  bool whole = true;

 private:
  bool native_;
  Bytes bytes_;
};

class Adversaries : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Engines, Adversaries, testing::Bool(),
                         [](const auto& engine) { return engine.param ? "native" : "interpreter"; });

std::string two(const std::string& globals, const std::string& first, const std::string& second) {
  return "VAR_GLOBAL " + globals + " END_VAR\nPROGRAM First\nVAR n, q2 : DINT; END_VAR\nn := n + 1;\n" + first +
         "\nEND_PROGRAM\nPROGRAM Second\nVAR n, q : DINT; END_VAR\nn := n + 1;\n" + second + "\nEND_PROGRAM\n" +
         kTwoTasks;
}

TEST_P(Adversaries, ImportsAheadOfTheScanBelongToIt) {
  Adversary a(two("G, H : DINT;", "G := n;", "H := H + G;"), GetParam());
  for (int changes = 0; changes < 3; ++changes) {
    // Ahead without a change, with one, with two: what comes in twice is noted twice, and the last one counts.
    for (int change = 0; change < changes; ++change) {
      static_cast<void>(a.scan(0));
      a.resource->program(1).expect(4096);
    }
    a.resource->program(1).expect(4096);
    static_cast<void>(a.scan(1));
  }
  EXPECT_EQ(a.replayed(), 6u);
}

TEST_P(Adversaries, AnHmiWritesBetweenTheImportAheadAndTheScan) {
  Adversary a(two("G : DINT; Text : STRING[10];", "G := G + 1;", "q := q + G + LEN(Text);"), GetParam());
  for (int i = 0; i < 5; ++i) {
    set(*a.resource, "G", std::to_string(i * 1000));
    a.resource->program(0).expect(4096);
    set(*a.resource, "G", std::to_string(i * 1000 + 7));
    static_cast<void>(a.scan(0));
    a.resource->program(1).expect(4096);
    set(*a.resource, "Text", std::string(static_cast<std::size_t>(i), 'x'));
    static_cast<void>(a.scan(1));
  }
  EXPECT_EQ(a.replayed(), 10u);
  EXPECT_EQ(value_of(*a.resource, "G"), "4008");
}

TEST_P(Adversaries, AFaultLeavesASharedVariableThatOthersDoNotChange) {
  // What the faulted scan wrote is undone by the import of the next one, though nobody has changed it.
  Adversary a(
      two("S : DINT; Hang : BOOL;", "S := S + 1; WHILE Hang DO q2 := q2; END_WHILE;", "IF n = 1 THEN S := 100; END_IF"),
      GetParam());
  for (int i = 0; i < 12; ++i) {
    set(*a.resource, "Hang", i == 4 || i == 8 ? "1" : "0");
    EXPECT_EQ(static_cast<bool>(a.scan(0)), i == 4 || i == 8);
    if (i == 0 || i == 8) static_cast<void>(a.scan(1));
  }
  EXPECT_EQ(a.replayed(), 14u);
}

TEST_P(Adversaries, AFaultInTheFirstScan) {
  Adversary a(
      std::string("PROGRAM Main\nVAR n : DINT; END_VAR\nn := n + 1;\nWHILE n = 1 DO n := n; END_WHILE\nEND_PROGRAM\n") +
          kOneTask,
      GetParam());
  EXPECT_TRUE(a.scan(0));
  EXPECT_FALSE(a.scan(0));
  EXPECT_EQ(a.replayed(), 2u);
}

TEST_P(Adversaries, QueuesThatAreFullEmptyAndCounted) {
  Adversary a(
      two("Orders : ARRAY [1..3] OF DINT; Put, Taken, Many, Room : DINT; Puts : BOOL;",
          "IF Puts THEN IF QUEUE_PUT(Orders, n * 3) THEN Put := Put + 1; END_IF; END_IF; Room := QUEUE_SPACE(Orders);",
          "IF QUEUE_GET(Orders, OUT => q) THEN Taken := Taken + q; END_IF; Many := QUEUE_COUNT(Orders);"),
      GetParam());
  for (int i = 0; i < 40; ++i) {
    set(*a.resource, "Puts", i / 10 % 2 == 0 ? "1" : "0");
    static_cast<void>(a.scan(0));
    if (i % 3 == 0) static_cast<void>(a.scan(1));
  }
  EXPECT_EQ(a.replayed(), 54u);
}

TEST_P(Adversaries, NumbersThatAreNotNumbers) {
  Adversary a(two("X : LREAL; Y : REAL;", "X := X * 2.0;", "q := q + LREAL_TO_DINT(X); Y := Y / 3.0;"), GetParam());
  for (const char* const value : {"nan", "-0.0", "1e-310", "inf", "-inf", "4.9e-324", "1e308"}) {
    set(*a.resource, "X", value);
    set(*a.resource, "Y", value == std::string("1e308") || value == std::string("4.9e-324") ? "1e-44" : value);
    static_cast<void>(a.scan(0));
    static_cast<void>(a.scan(1));
  }
  EXPECT_EQ(a.replayed(), 14u);
}

TEST_P(Adversaries, TextsWithRestsOfLongerOnes) {
  Adversary a(
      two("A, B : STRING[30];", "IF n MOD 2 = 0 THEN A := 'y'; ELSE A := 'some thirty characters of text'; END_IF",
          "B := CONCAT(A, B); IF n MOD 3 = 0 THEN B := ''; END_IF"),
      GetParam());
  for (int i = 0; i < 20; ++i) {
    static_cast<void>(a.scan(0));
    static_cast<void>(a.scan(1));
  }
  EXPECT_EQ(a.replayed(), 40u);
}

TEST_P(Adversaries, ReferencesIntoFramesOfFunctions) {
  Adversary a(
      std::string("FUNCTION Bump : DINT\nVAR_IN_OUT x : DINT; END_VAR\nx := x + 1; Bump := x * 2;\nEND_FUNCTION\n"
                  "FUNCTION Twice : DINT\nVAR_INPUT y : DINT; END_VAR\nVAR local : ARRAY [1..4] OF DINT; END_VAR\n"
                  "local[y MOD 4 + 1] := y; Twice := Bump(local[y MOD 4 + 1]) + Bump(local[1]);\nEND_FUNCTION\n"
                  "PROGRAM Main\nVAR n, m : DINT; END_VAR\nn := n + 1; m := m + Twice(n) + Bump(n);\nEND_PROGRAM\n") +
          kOneTask,
      GetParam());
  for (int i = 0; i < 30; ++i) static_cast<void>(a.scan(0));
  EXPECT_EQ(a.replayed(), 30u);
}

TEST_P(Adversaries, AMegabyteTakenIn) {
  shadow::RecordingOptions options;
  options.ring_bytes = 8u << 20;
  options.most_record_bytes = 2u << 20;
  Adversary a(two("Many : ARRAY [0..262143] OF DINT;",
                  "Many[n] := n; IF n = 3 THEN FOR n := 0 TO 900 DO Many[n * 200] := n; END_FOR; END_IF",
                  "q := q + Many[n] + Many[262143 - n];"),
              GetParam(), options);
  for (int i = 0; i < 5; ++i) {
    for (std::uint32_t task = 0; task < 2; ++task) static_cast<void>(a.scan(task));
    a.recording->drain();
  }
  EXPECT_EQ(a.replayed(), 10u);
  EXPECT_EQ(a.recording->counts(1).lost, 0u);
}

TEST_P(Adversaries, ARecordOfExactlyTheLargestSize) {
  // Head, an entry of 4,000 bytes with its head; one more byte is too much.
  for (const std::size_t spare : {std::size_t{0}, runtime::kRecordAlign}) {
    shadow::RecordingOptions options;
    options.ring_bytes = 64 * 1024;
    options.most_record_bytes = sizeof(runtime::RecordHead) + sizeof(runtime::EntryHead) + 4000 - spare;
    Adversary a(two("Some : ARRAY [1..1000] OF DINT;", "Some[n] := n;", "q := q + Some[1] + Some[1000];"), GetParam(),
                options);
    a.whole = spare == 0;
    for (int i = 0; i < 6; ++i) {
      for (std::uint32_t task = 0; task < 2; ++task) static_cast<void>(a.scan(task));
      a.recording->drain();
    }
    const std::uint64_t scans = a.replayed();
    EXPECT_EQ(a.recording->counts(1).lost, spare == 0 ? 0u : 6u);
    EXPECT_EQ(scans, spare == 0 ? 12u : 6u);
  }
}

TEST_P(Adversaries, LoopsThatAreCutFromOutsideEndAStretch) {
  Adversary a(two("Hang : BOOL;", "WHILE Hang DO n := n + 1; END_WHILE", ""), GetParam(), {}, 4'000'000'000u);
  for (int i = 0; i < 9; ++i) {
    set(*a.resource, "Hang", i == 4 ? "1" : "0");
    std::atomic<bool> ended{false};
    std::thread cutter([&] {
      while (i == 4 && !ended) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        if (!ended) a.resource->program(0).cut_loops();
      }
    });
    EXPECT_EQ(static_cast<bool>(a.scan(0)), i == 4);
    ended = true;
    cutter.join();
    a.recording->drain();
  }
  // Where it was cut nobody knows; and the scan that was the next one ended with the checkpoint.
  EXPECT_EQ(a.replayed(), 7u);
  EXPECT_EQ(a.gaps, 1u);
}

TEST_P(Adversaries, AScanWithoutTheRightToPublish) {
  Adversary a(two("G : DINT; Hang : BOOL;", "G := n; WHILE Hang DO q2 := q2 + 1; END_WHILE", "q := G;"), GetParam(), {},
              4'000'000'000u);
  for (int i = 0; i < 6; ++i) {
    set(*a.resource, "Hang", i == 3 ? "1" : "0");
    std::atomic<bool> ended{false};
    std::thread watchdog([&] {
      while (i == 3 && !a.resource->program(0).revoke()) std::this_thread::yield();
      while (i == 3 && !ended) a.resource->program(0).cut_loops();
    });
    EXPECT_EQ(static_cast<bool>(a.scan(0)), i == 3);
    ended = true;
    watchdog.join();
    a.recording->drain();
    static_cast<void>(a.scan(1));
  }
  EXPECT_EQ(a.replayed(), 6u + 4u);
}

}  // namespace
}  // namespace plc::test
