// Scans that leave out what did not change: what runs again, and that tables, events and faults are those of the
// interpreter whoever writes variables in between.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "runtime/access.h"
#include "runtime/compiled_task.h"
#include "stdlib/library.h"
#include "tests/support/engines.h"
#include "tests/support/image_builder.h"
#include "tests/support/random_image.h"
#include "tests/support/random_inputs.h"

namespace plc::test {
namespace {

constexpr core::TimeNs kPeriodNs = 10'000'000;
/// Scans after which what never changes is left out for certain.
constexpr int kScansToRest = 3 + static_cast<int>(native::ChangeTracker::kWholeScans);

/// One program in the interpreter and as native code that leaves out.
class Pair {
 public:
  explicit Pair(ImageBuilder& b, PouBuilder& main, std::uint32_t patience = native::kPatience) {
    b.task("Cyclic", kPeriodNs, {main.finish()});
    std::string problem;
    engines_ = Engines::load(b.build(), problem, {.loop_budget = 100}, {interpreter(), native_changed(patience)});
    EXPECT_NE(engines_, nullptr) << problem;
  }
  /// Inverts a BOOL from outside.
  void flip(const std::string& name) {
    for (std::size_t e = 0; e < 2; ++e) {
      const runtime::Access access((*engines_)[e]);
      const auto place = access.find_leaf("Main0." + name);
      ASSERT_TRUE(place) << place.error().message;
      (*engines_)[e].program(0).table().data()[place->offset] ^= std::byte{1};
    }
  }
  void scan(int scans = 1) {
    for (int i = 0; i < scans; ++i) ASSERT_EQ(engines_->scan(now_ns_ += kPeriodNs), "");
  }
  /// Scans at one and the same instant.
  void stand_still(int scans) {
    for (int i = 0; i < scans; ++i) ASSERT_EQ(engines_->scan(now_ns_), "");
  }
  /// How many groups ran in one more scan.
  std::uint64_t runs() {
    const std::uint64_t before = counts().runs;
    scan();
    return counts().runs - before;
  }
  [[nodiscard]] bool value(const std::string& name) {
    const runtime::Access access((*engines_)[1]);
    return (*engines_)[1].program(0).table().data()[access.find_leaf("Main0." + name)->offset] != std::byte{0};
  }
  const runtime::SkipCounts& counts() { return *(*engines_)[1].program(0).skipped(); }
  runtime::Program& program(std::size_t engine) { return (*engines_)[engine].program(0); }

 private:
  std::unique_ptr<Engines> engines_;
  core::TimeNs now_ns_ = 0;
};

std::string numbered(const char* name, int n) { return name + std::to_string(n); }
constexpr std::uint32_t kCopy = 0xaaaaaaaa;  ///< look-up table: the first input

/// 300 chains of three contacts and coils, each behind an input of its own.
constexpr int kChains = 300;
void chains(ImageBuilder& b, PouBuilder& main) {
  for (int n = 0; n < kChains; ++n) {
    Word from = main.variable(numbered("in", n), b.boolean());
    for (const char* coil : {"a", "b", "c"}) {
      const Word to = main.variable(numbered(coil, n), b.boolean());
      main.record(kCopy, to, {from});
      from = to;
    }
  }
}

TEST(Changed, WhatFollowsFromAChangeRunsAndNothingElse) {
  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  chains(b, main);
  Pair pair(b, main);
  pair.scan(kScansToRest);
  EXPECT_EQ(pair.counts().groups, 3u * kChains + 1);  // and what leads the interpreter to arranged code
  EXPECT_EQ(pair.runs(), 0u);
  pair.flip("in7");
  EXPECT_EQ(pair.runs(), 3u);
  EXPECT_TRUE(pair.value("c7"));
  EXPECT_EQ(pair.runs(), 0u);
  // What was written from outside over a result is written again, by its writer alone.
  pair.flip("b9");
  EXPECT_EQ(pair.runs(), 1u);
  EXPECT_FALSE(pair.value("b9"));
}

TEST(Changed, AllReadersOfAResultRunHoweverMany) {
  for (const int readers : {1, 5, 6, 7, 8, 30}) {
    ImageBuilder b;
    PouBuilder main = b.pou("Main", PouKind::kProgram);
    chains(b, main);
    const Word in = main.variable("in", b.boolean());
    const Word result = main.variable("result", b.boolean());
    main.record(kCopy, result, {in});
    for (int n = 0; n < readers; ++n) {
      main.record(kCopy, main.variable(numbered("reader", n), b.boolean()), {result});
    }
    Pair pair(b, main);
    pair.scan(kScansToRest);
    pair.flip("in");
    EXPECT_EQ(pair.runs(), 1u + static_cast<unsigned>(readers));
    EXPECT_TRUE(pair.value(numbered("reader", readers - 1)));
    EXPECT_EQ(pair.runs(), 0u);
  }
}

TEST(Changed, WhenEverythingChangesWholeScansRun) {
  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  chains(b, main);
  Pair pair(b, main);
  pair.scan(kScansToRest);
  const std::uint64_t scans = pair.counts().scans, whole = pair.counts().whole_scans;
  for (int i = 0; i < 200; ++i) {
    for (int n = 0; n < kChains; ++n) pair.flip(numbered("in", n));
    pair.scan();
  }
  EXPECT_EQ(pair.counts().whole_scans - whole, pair.counts().scans - scans);
  pair.scan(kScansToRest);
  pair.flip("in0");
  EXPECT_EQ(pair.runs(), 3u);
}

TEST(Changed, ATimerRunsWhileItIsTiming) {
  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  const Word timer = main.variable("timer", b.block_type("TON"));
  const auto ton = std::find_if(stdlib::blocks().begin(), stdlib::blocks().end(),
                                [](const stdlib::BlockSpec& block) { return block.name == "TON"; });
  const Word preset = b.constant<std::int64_t>(TypeId::kTime, 5 * kPeriodNs);
  main.op(Opcode::kMove64, {timer + stdlib::field_named(*ton, "PT")->offset, preset});
  main.op(Opcode::kRunTb, {b.block("TON"), timer});
  Pair pair(b, main, native::kPatience * 100);
  pair.scan(kScansToRest);
  EXPECT_EQ(pair.runs(), 0u);
  pair.flip("timer.IN");
  for (int i = 0; i < 6; ++i) EXPECT_EQ(pair.runs(), 1u) << i;
  EXPECT_TRUE(pair.value("timer.Q"));
  pair.scan();
  EXPECT_EQ(pair.runs(), 0u);
}

TEST(Changed, ATimerThatIsSetBackInItsOwnGroupFollowsTheTime) {
  // Its pulse is over at once, and behind it somebody takes away that it has seen its input.
  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  const Word timer = main.variable("timer", b.block_type("TP"));
  const Word off = main.variable("off", b.boolean());
  const stdlib::BlockSpec& spec = *stdlib::block_named("TP");
  main.op(Opcode::kRunTb, {b.block("TP"), timer});
  main.op(Opcode::kMoveBool, {timer + stdlib::field_named(spec, "M")->offset, off});
  Pair pair(b, main, native::kPatience * 100);
  pair.flip("timer.IN");
  pair.scan();
  // Nothing changes while time stands still; when it goes on, START does.
  pair.stand_still(kScansToRest);
  pair.scan(3);
}

TEST(Changed, EventsAreRaisedInEveryScan) {
  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  const Word zero = main.variable("zero", b.type(TypeId::kInt));
  const Word result = main.variable("result", b.type(TypeId::kInt));
  main.op(Opcode::kDivI16, {result, zero, zero});
  Pair pair(b, main, kEndlessPatience);
  pair.scan(kScansToRest);
  const std::uint64_t events = pair.program(1).event_total();
  for (int i = 0; i < 5; ++i) EXPECT_EQ(pair.runs(), 1u);
  EXPECT_EQ(pair.program(1).event_total(), events + 5);
}

/// ENO counts from the CLEAR_EVENT in front of it, which is left out with others that count from it, or not at all.
TEST(Changed, AnEnoOutsideOfGroupsCountsFromItsClear) {
  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  const Word first = main.variable("first", b.boolean());
  const Word second = main.variable("second", b.boolean());
  const Word text = main.variable("text", b.string(3));
  main.op(Opcode::kMoveStr, {text, b.text("abcdef")});  // raises an event
  main.op(Opcode::kClearEvent);
  main.op(Opcode::kEno, {first});
  main.op(Opcode::kMoveStr, {text, b.text("abc")});  // is no part of a group
  main.op(Opcode::kEno, {second});
  Pair pair(b, main, kEndlessPatience);
  pair.scan(kScansToRest);
  EXPECT_TRUE(pair.value("first"));
  EXPECT_TRUE(pair.value("second"));
}

TEST(Changed, ARestartFindsWhatItChanged) {
  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  chains(b, main);
  Pair pair(b, main);
  pair.flip("in3");
  pair.scan(kScansToRest);
  ASSERT_TRUE(pair.value("c3"));
  for (std::size_t e = 0; e < 2; ++e) pair.program(e).reset();
  EXPECT_EQ(pair.runs(), 0u) << "all is as it would become";
  pair.flip("in3");
  EXPECT_EQ(pair.runs(), 3u);
}

/// Never, by default, and at the first change: whole scans, what is left out, and the ways between them.
TEST(Changed, RandomProgramsUnderEveryPatience) {
  std::uint64_t left_out = 0;
  for (std::uint32_t seed = 1; seed <= 300; ++seed) {
    RandomImage made(seed);
    const Image image = made.make(4 + seed % 60);
    std::string problem;
    const auto engines =
        Engines::load(image, problem, {.loop_budget = 200},
                      {interpreter(), native_changed(kEndlessPatience), native_changed(), native_changed(0)});
    ASSERT_NE(engines, nullptr) << problem;
    Random random(seed);
    RandomInputs inputs(image);
    for (int scan = 0; scan < 48; ++scan) {
      // At times nothing happens outside and time stands still, so that what is inside comes to rest.
      const bool quiet = scan / 8 % 2 == 1;
      if (!quiet) inputs.choose(random, 10);
      for (std::size_t e = 0; e < engines->size() && !quiet; ++e) inputs.write((*engines)[e]);
      ASSERT_EQ(engines->scan((quiet ? scan / 8 * 8 : scan) * kPeriodNs), "") << "seed " << seed << ", scan " << scan;
    }
    for (std::size_t task = 0; task < engines->tasks(); ++task) {
      const runtime::SkipCounts& counts = *(*engines)[1].program(task).skipped();
      left_out += (counts.scans - counts.whole_scans) * counts.groups - counts.runs;
    }
  }
  EXPECT_GT(left_out, 10'000u);
}

}  // namespace
}  // namespace plc::test
