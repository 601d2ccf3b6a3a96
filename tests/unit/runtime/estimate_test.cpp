// The estimator against programs counted by hand: with one cost set to 1 and all others to 0, the estimate is how often
// that kind is on the longest path.
#include "runtime/sched/estimate.h"

#include <gtest/gtest.h>

#include <chrono>
#include <random>
#include <string>

#include "tests/support/sample_image.h"

namespace plc::test {
namespace {

using runtime::Cost;
using runtime::CostKind;
using runtime::CostTable;
using runtime::estimate_task;
using runtime::kAssumedRounds;
using runtime::kCostKinds;
using runtime::TaskEstimate;

CostTable only(CostKind kind, double first = 1, double again = 1) {
  CostTable costs;
  costs[kind] = {first, again};
  return costs;
}
double count(const Image& image, CostKind kind, std::uint32_t task = 0) {
  return estimate_task(image, task, only(kind)).scan.first;
}

/// Main with a few DINTs, in one task.
struct Small {
  ImageBuilder b;
  std::uint32_t dint = b.type(TypeId::kDint);
  Word one = b.constant<std::int32_t>(TypeId::kDint, 1);
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  Word v = main.variable("v", dint);
  Word w = main.variable("w", dint);
  Word i = main.variable("i", dint);
  Word go = main.variable("go", b.boolean());
  Word test = main.frame("t#0", b.boolean(), FieldRole::kHidden);

  void move(int times = 1) {
    for (int n = 0; n < times; ++n) main.op(Opcode::kMove32, {v, w});
  }
  void add(int times = 1) {
    for (int n = 0; n < times; ++n) main.op(Opcode::kAdd32, {v, v, w});
  }
  Word constant(std::int32_t value) { return b.constant<std::int32_t>(TypeId::kDint, value); }
  /// The head of FOR i := from TO .., and its end; `body` is what here() said in between.
  std::uint32_t for_from(std::int32_t from) {
    main.op(Opcode::kMove32, {i, constant(from)});
    return main.here();
  }
  void end_for(std::uint32_t body, Word limit, std::int32_t step) {
    main.op(step > 0 ? Opcode::kLtI32 : Opcode::kGtI32, {test, i, limit});
    const std::uint32_t out = main.jump(Opcode::kCondJump, {test});
    main.op(step > 0 ? Opcode::kAdd32 : Opcode::kSub32, {i, i, constant(std::abs(step))});
    main.op(Opcode::kLoopJump, {body});
    main.land(out);
  }
  Image image() {
    b.task("Cyclic", 10'000'000, {main.finish()});
    Image built = b.build();
    core::Diagnostics diagnostics;
    EXPECT_TRUE(bytecode::verify(built, diagnostics).has_value());
    return built;
  }
};

TEST(CostTable, EveryInstructionHasAKind) {
  for (std::size_t op = 0; op < bytecode::opcodes().size(); ++op) {
    const auto opcode = static_cast<Opcode>(op);
    EXPECT_EQ(runtime::cost_kind(opcode) == CostKind::kCount, opcode == Opcode::kBoolRun)
        << bytecode::opcodes()[op].mnemonic << " is missing in cost_kind()";
  }
}

TEST(Estimate, CountsInstructionsOfAStraightLine) {
  Small s;
  s.move(3);
  s.add(5);
  s.main.op(Opcode::kDivI32, {s.v, s.v, s.w});
  const Image image = s.image();
  EXPECT_EQ(count(image, CostKind::kMove), 3);
  EXPECT_EQ(count(image, CostKind::kCompute), 5);
  EXPECT_EQ(count(image, CostKind::kDivide), 1);
  EXPECT_EQ(count(image, CostKind::kCall), 1);
  EXPECT_EQ(count(image, CostKind::kJump), 2);  // the ends of both bodies
  EXPECT_EQ(count(image, CostKind::kScan), 1);
  EXPECT_EQ(count(image, CostKind::kRelease), 0);  // is no part of a scan
  EXPECT_EQ(count(image, CostKind::kBranch), 0);
}

TEST(Estimate, TakesTheLongerOfTwoBranches) {
  Small s;
  const std::uint32_t otherwise = s.main.jump(Opcode::kCondJump, {s.go});
  s.move(4);
  const std::uint32_t end = s.main.jump(Opcode::kJump);
  s.main.land(otherwise);
  s.add(3);
  s.main.land(end);
  const Image image = s.image();
  CostTable costs;
  costs[CostKind::kMove] = {1, 1};
  costs[CostKind::kCompute] = {1, 1};
  EXPECT_EQ(estimate_task(image, 0, costs).scan.first, 4);
  costs[CostKind::kCompute] = {2, 2};
  EXPECT_EQ(estimate_task(image, 0, costs).scan.first, 6);
}

TEST(Estimate, AComparisonAndItsJumpAreOne) {
  Small s;
  s.main.op(Opcode::kLtI32, {s.test, s.v, s.w});
  const std::uint32_t end = s.main.jump(Opcode::kCondJump, {s.test});
  s.move();
  s.main.land(end);
  const Image image = s.image();
  EXPECT_EQ(count(image, CostKind::kTest), 1);
  EXPECT_EQ(count(image, CostKind::kCompute), 0);
  EXPECT_EQ(count(image, CostKind::kBranch), 0);
}

TEST(Estimate, KnowsTheRoundsOfAForBetweenConstants) {
  struct Case {
    std::int32_t from, to, step, rounds;
  };
  for (const Case& c :
       {Case{1, 10, 1, 10}, {1, 20, 3, 7}, {20, 1, -1, 20}, {10, 1, -3, 4}, {4, 4, 1, 1}, {-3, 3, 2, 4}}) {
    Small s;
    const std::uint32_t body = s.for_from(c.from);
    s.main.op(Opcode::kMul32, {s.v, s.v, s.w});
    s.main.op(Opcode::kMove32, {s.w, s.v});
    // The loop goes on while the control variable lies a whole step before the final value.
    s.end_for(body, s.constant(c.to - c.step + (c.step > 0 ? 1 : -1)), c.step);
    const Image image = s.image();
    EXPECT_TRUE(estimate_task(image, 0, CostTable{}).assumed.empty());
    EXPECT_EQ(count(image, CostKind::kMove), 1 + c.rounds) << c.from << " to " << c.to << " by " << c.step;
    EXPECT_EQ(count(image, CostKind::kTest), c.rounds);
  }
}

TEST(Estimate, LaterRoundsCostWhatLaterRoundsCost) {
  Small s;
  const std::uint32_t body = s.for_from(1);
  s.main.op(Opcode::kDivI32, {s.v, s.v, s.w});
  s.end_for(body, s.constant(100), 1);
  const Cost scan = estimate_task(s.image(), 0, only(CostKind::kDivide, 50, 2)).scan;
  EXPECT_EQ(scan.first, 50 + 99 * 2);
  EXPECT_EQ(scan.again, 100 * 2);
}

TEST(Estimate, RoundsOfNestedLoopsMultiply) {
  Small s;
  const Word k = s.main.variable("k", s.dint);
  const std::uint32_t outer = s.for_from(1);
  s.main.op(Opcode::kMove32, {k, s.constant(1)});
  const std::uint32_t inner = s.main.here();
  s.main.op(Opcode::kDivI32, {s.v, s.v, s.w});
  s.main.op(Opcode::kLtI32, {s.test, k, s.constant(7)});
  const std::uint32_t out = s.main.jump(Opcode::kCondJump, {s.test});
  s.main.op(Opcode::kAdd32, {k, k, s.one});
  s.main.op(Opcode::kLoopJump, {inner});
  s.main.land(out);
  s.end_for(outer, s.constant(10), 1);
  const Image image = s.image();
  EXPECT_EQ(count(image, CostKind::kDivide), 70);
  EXPECT_EQ(count(image, CostKind::kMove), 11);
  EXPECT_EQ(count(image, CostKind::kTest), 70 + 10);
}

// Each is a FOR but for one thing, and could go round any number of times.
TEST(Estimate, AssumesRoundsWhereTheCodeDoesNotSay) {
  for (const std::string what : {"limit", "start", "written", "given away", "no start"}) {
    Small s;
    const std::uint32_t ref = s.b.ref(s.dint);
    const Word r = s.main.variable("r", ref);
    if (what == "start") {
      s.main.op(Opcode::kMove32, {s.i, s.v});
    } else if (what != "no start") {
      s.main.op(Opcode::kMove32, {s.i, s.one});
    } else {
      s.move();
    }
    const std::uint32_t body = s.main.here();
    s.main.op(Opcode::kDivI32, {s.v, s.v, s.w});
    if (what == "written") s.main.op(Opcode::kMove32, {s.i, s.w});
    if (what == "given away") s.main.path(Opcode::kRefAt, {r, s.i, s.dint}, {});
    s.end_for(body, what == "limit" ? s.w : s.constant(1000), 1);
    const Image image = s.image();
    const TaskEstimate estimate = estimate_task(image, 0, only(CostKind::kDivide));
    ASSERT_EQ(estimate.assumed.size(), 1u) << what;
    EXPECT_EQ(image.pous[estimate.assumed[0].pou].name, "Main");
    EXPECT_EQ(estimate.scan.first, 1 + kAssumedRounds) << what;
  }
}

// WHILE: the condition comes after the statements, and the first jump goes there.
TEST(Estimate, ALoopEnteredInItsMiddle) {
  Small s;
  const std::uint32_t entry = s.main.jump(Opcode::kJump);
  const std::uint32_t body = s.main.here();
  s.main.op(Opcode::kDivI32, {s.v, s.v, s.w});
  s.main.land(entry);
  s.move();
  const std::uint32_t out = s.main.jump(Opcode::kCondJump, {s.go});
  s.main.op(Opcode::kLoopJump, {body});
  s.main.land(out);
  const Image image = s.image();
  EXPECT_EQ(count(image, CostKind::kDivide), kAssumedRounds);
  EXPECT_EQ(count(image, CostKind::kMove), 1 + kAssumedRounds);
  // Its statements run for the first time when it goes round.
  EXPECT_EQ(estimate_task(image, 0, only(CostKind::kDivide, 100, 1)).scan.first, 100 + (kAssumedRounds - 1));
}

TEST(Estimate, ALoopThatNothingReachesIsNone) {
  Small s;
  const std::uint32_t past = s.main.jump(Opcode::kJump);
  const std::uint32_t body = s.main.here();
  s.main.op(Opcode::kDivI32, {s.v, s.v, s.w});
  s.main.op(Opcode::kLoopJump, {body});
  s.main.land(past);
  const Image image = s.image();
  EXPECT_EQ(count(image, CostKind::kDivide), 0);
  EXPECT_TRUE(estimate_task(image, 0, CostTable{}).assumed.empty());
}

TEST(Estimate, ALoopWithoutAWayOutCountsToo) {
  Small s;
  const std::uint32_t body = s.main.here();
  s.main.op(Opcode::kDivI32, {s.v, s.v, s.w});
  s.main.op(Opcode::kLoopJump, {body});
  EXPECT_EQ(count(s.image(), CostKind::kDivide), 1 + kAssumedRounds);
}

TEST(Estimate, NoLoopGoesRoundMoreThanItsBudget) {
  Small s;
  const std::uint32_t body = s.for_from(1);
  s.main.op(Opcode::kDivI32, {s.v, s.v, s.w});
  s.end_for(body, s.constant(2'000'000'000), 1);
  EXPECT_EQ(estimate_task(s.image(), 0, only(CostKind::kDivide), 1000).scan.first, 1001);
}

// Drawn jumps can lead from one loop into another: 1 back to 0, then 2 back to a place between.
TEST(Estimate, LoopsThatOverlapAreOne) {
  Small s;
  const std::uint32_t first = s.main.here();
  s.main.op(Opcode::kDivI32, {s.v, s.v, s.w});
  const std::uint32_t second = s.main.here();
  s.move();
  const std::uint32_t on = s.main.jump(Opcode::kCondJump, {s.go});
  s.main.op(Opcode::kLoopJump, {first});
  s.main.land(on);
  s.add();
  const std::uint32_t out = s.main.jump(Opcode::kJumpIf, {s.go});
  s.main.op(Opcode::kLoopJump, {second});
  s.main.land(out);
  const Image image = s.image();
  EXPECT_EQ(count(image, CostKind::kDivide), 1 + 2 * kAssumedRounds);
  EXPECT_EQ(count(image, CostKind::kMove), 1 + 2 * kAssumedRounds);
  EXPECT_EQ(count(image, CostKind::kCompute), 1 + 2 * kAssumedRounds);
}

// What a hostile image costs is in proportion to its size.
TEST(Estimate, DeepNestingTakesNoLonger) {
  Small s;
  constexpr int kDepth = 100'000;
  const std::uint32_t head = s.main.here();
  s.move();
  for (int n = 0; n < kDepth; ++n) {
    const std::uint32_t out = s.main.jump(Opcode::kJumpIf, {s.go});
    s.main.op(Opcode::kLoopJump, {head});
    s.main.land(out);
  }
  s.b.task("Cyclic", 10'000'000, {s.main.finish()});
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_GT(estimate_task(s.b.build(), 0, only(CostKind::kMove)).scan.first, kAssumedRounds);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
}

TEST(Estimate, CallsCostWhatTheyCall) {
  ImageBuilder b;
  const std::uint32_t dint = b.type(TypeId::kDint);
  PouBuilder part = b.pou("Part", PouKind::kFunctionBlock);
  const Word n = part.variable("n", dint);
  part.op(Opcode::kDivI32, {n, n, n});
  const std::uint32_t block = part.finish();
  PouBuilder function = b.pou("Twice", PouKind::kFunction);
  const Word a = function.frame("a", dint, FieldRole::kInput);
  const Word result = function.frame("Twice", dint, FieldRole::kReturnValue);
  function.op(Opcode::kAdd32, {result, a, a});
  const std::uint32_t twice = function.finish();
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  const Word first = main.instance_of("first", block);
  const Word second = main.instance_of("second", block);
  const Word v = main.variable("v", dint);
  main.op(Opcode::kCallPou, {block, first});
  main.op(Opcode::kCallPou, {block, second});
  main.list(Opcode::kCallFn, 2, {twice, 0, v, 1, v});
  b.task("Cyclic", 10'000'000, {main.finish()});
  const Image image = b.build();
  EXPECT_EQ(count(image, CostKind::kDivide), 2);
  EXPECT_EQ(count(image, CostKind::kCall), 3);
  EXPECT_EQ(count(image, CostKind::kFunction), 1);
  EXPECT_EQ(count(image, CostKind::kArgument), 2);
  EXPECT_EQ(count(image, CostKind::kByte), 8);  // the frame is made anew
  EXPECT_EQ(count(image, CostKind::kCompute), 1);
}

TEST(Estimate, FunctionsAndBlocksOfTheLibraryCostByName) {
  Small s;
  const std::uint32_t ton = s.b.block("TON");
  const Word timer = s.main.variable("timer", s.b.block_type("TON"));
  const Word timer2 = s.main.variable("timer2", s.b.block_type("TON"));
  const Word text = s.main.variable("text", s.b.string(160));
  s.main.op(Opcode::kRunTb, {ton, timer});
  s.main.op(Opcode::kRunTb, {ton, timer2});
  s.main.call_std("ABS:DINT", s.v, {s.w});
  s.main.call_std("MAX:DINT", s.v, {s.v, s.w, s.w, s.w});
  s.main.call_std("LEN:STRING", s.main.variable("n", s.b.type(TypeId::kInt)), {text});
  const Image image = s.image();
  CostTable costs;
  costs.blocks["TON"] = 7;
  EXPECT_EQ(estimate_task(image, 0, costs).scan.first, 2 * 7);
  costs.blocks.clear();
  costs.blocks["TOF"] = 9;  // of one that is not known: the slowest
  costs.blocks["SR"] = 2;
  EXPECT_EQ(estimate_task(image, 0, costs).scan.first, 2 * 9);
  costs.blocks = {{"TON", 0}};
  costs.functions = {{"ABS:DINT", 3}, {"MAX:DINT", 10}, {"LEN:STRING", 100}};
  // Four arguments in place of two, and twice as many characters as were measured.
  EXPECT_EQ(estimate_task(image, 0, costs).scan.first, 3 + 10 * 2 + 100 * 2);
  EXPECT_EQ(count(image, CostKind::kStandard), 3);
  EXPECT_EQ(count(image, CostKind::kBlock), 2);
  EXPECT_EQ(count(image, CostKind::kFetch), 4);
}

TEST(Estimate, BooleanRunsAreCountedAsTheLinkerMakesThem) {
  Small s;
  const Word other = s.main.variable("other", s.b.boolean());
  const Word far = s.main.variable("far", s.b.array(s.b.boolean(), 200'000));
  for (int n = 0; n < 20; ++n) s.main.record(0x2, s.go, {other, s.go});
  s.move();
  for (Word n = 0; n < 5; ++n) s.main.record(0x2, far + n, {far + 199'000 + n});
  const Image image = s.image();
  EXPECT_EQ(count(image, CostKind::kRecord), 20);
  EXPECT_EQ(count(image, CostKind::kWideRecord), 5);
  EXPECT_EQ(count(image, CostKind::kRun), 2);
}

TEST(Estimate, PartsOfValuesAreCountedAsTheLinkerMakesThem) {
  Small s;
  const std::uint32_t row = s.b.array(s.dint, 4, 1);
  const std::uint32_t grid = s.b.array(row, 3, 1);
  const Word g = s.main.variable("g", grid);
  const Word line = s.main.variable("line", row);
  s.main.path(Opcode::kLoadAt, {s.v, line, row}, {{PathStep::kElement, 2}});                         // a move
  s.main.path(Opcode::kLoadAt, {s.v, line, row}, {{PathStep::kIndex, s.i}});                         // an element
  s.main.path(Opcode::kLoadAt, {s.v, g, grid}, {{PathStep::kIndex, s.i}, {PathStep::kIndex, s.w}});  // a path
  s.main.path(Opcode::kStoreAt, {g, line, grid}, {{PathStep::kIndex, s.i}});                         // 16 bytes
  const Image image = s.image();
  EXPECT_EQ(count(image, CostKind::kMove), 1);
  EXPECT_EQ(count(image, CostKind::kElement), 1);
  EXPECT_EQ(count(image, CostKind::kAccess), 2);
  EXPECT_EQ(count(image, CostKind::kIndex), 3);
  EXPECT_EQ(count(image, CostKind::kByte), 16);
}

TEST(Estimate, GlobalsCostTheTaskThatCopiesThem) {
  ImageBuilder b;
  const std::uint32_t dint = b.type(TypeId::kDint);
  b.global("mine", b.array(dint, 10), {}, {.owner = 0});
  b.global("theirs", b.array(dint, 100), {}, {.owner = 1});
  b.global("both", b.array(dint, 1000));
  b.global("sensor", dint, {}, {.input = true});
  b.global("limit", dint, bytes_of(std::int32_t{5}), {.constant = true});
  PouBuilder first = b.pou("First", PouKind::kProgram);
  PouBuilder second = b.pou("Second", PouKind::kProgram);
  const std::uint32_t one = first.finish();
  const std::uint32_t two = second.finish();
  b.task("A", 10'000'000, {one}, 0);
  b.task("B", 20'000'000, {two}, 1);
  const Image image = b.build();
  EXPECT_EQ(count(image, CostKind::kImportByte, 0), 400 + 4);
  EXPECT_EQ(count(image, CostKind::kExportByte, 0), 40);
  EXPECT_EQ(count(image, CostKind::kImportByte, 1), 40 + 4);
  EXPECT_EQ(count(image, CostKind::kExportByte, 1), 400);
  EXPECT_EQ(count(image, CostKind::kShared, 0), 2000);  // in and out
  EXPECT_EQ(count(image, CostKind::kImport, 0), 1);
  EXPECT_EQ(count(image, CostKind::kExport, 0), 2);
}

TEST(Estimate, ListsTheBodyOfTheTask) {
  Small s;
  s.b.global("g", s.dint);
  s.move(4);
  const TaskEstimate estimate = estimate_task(s.image(), 0, only(CostKind::kMove));
  using What = runtime::BodyStep::What;
  ASSERT_EQ(estimate.body.size(), 4u);
  EXPECT_EQ(estimate.body[0].what, What::kCopy);
  EXPECT_EQ(estimate.body[0].count, 1u);
  EXPECT_EQ(estimate.body[1].what, What::kOther);
  EXPECT_EQ(estimate.body[1].ns, 4);
  EXPECT_EQ(estimate.body[2].what, What::kCopy);
}

// No cost makes a scan shorter by growing.
TEST(Estimate, GrowsWithEveryCost) {
  const Image image = sample_image().image;
  std::mt19937 random(7);
  const auto some = [&random] { return std::uniform_real_distribution<double>(0, 100)(random); };
  for (int round = 0; round < 50; ++round) {
    CostTable costs;
    for (Cost& cost : costs.kinds) cost = {some(), some()};
    costs.functions["ADD:INT"] = some();
    costs.blocks["TON"] = some();
    const Cost before = estimate_task(image, 0, costs).scan;
    for (std::size_t k = 0; k < kCostKinds; ++k) {
      CostTable more = costs;
      more.kinds[k] += {some(), some()};
      const Cost after = estimate_task(image, 0, more).scan;
      EXPECT_GE(after.first, before.first - 1e-6) << runtime::info(static_cast<CostKind>(k)).key;
      EXPECT_GE(after.again, before.again - 1e-6) << runtime::info(static_cast<CostKind>(k)).key;
    }
  }
}

}  // namespace
}  // namespace plc::test
