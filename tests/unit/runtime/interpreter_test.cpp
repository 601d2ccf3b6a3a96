#include <cmath>
#include <limits>

#include "tests/unit/runtime/run_support.h"

namespace plc::test {
namespace {

using runtime::FaultKind;
using runtime::Program;

/// Runs `op` once on two values of type `id` and returns what lands in a variable of type `result`.
std::string binary(Opcode op, TypeId id, std::string_view a, std::string_view b, TypeId result) {
  OneProgram p;
  const Word x = p.main.variable("x", p.b.type(id));
  const Word y = p.main.variable("y", p.b.type(id));
  const Word z = p.main.variable("z", p.b.type(result));
  p.main.op(op, {z, x, y});
  auto r = p.load();
  if (r == nullptr) return "refused";
  set(*r, "Main0.x", a);
  set(*r, "Main0.y", b);
  EXPECT_FALSE(r->program(0).execute({}));
  return value_of(*r, "Main0.z");
}
std::string binary(Opcode op, TypeId id, std::string_view a, std::string_view b) { return binary(op, id, a, b, id); }
std::string compare(Opcode op, TypeId id, std::string_view a, std::string_view b) {
  return binary(op, id, a, b, TypeId::kBool);
}

TEST(Interpreter, IntegerArithmeticWraps) {
  EXPECT_EQ(binary(Opcode::kAdd8, TypeId::kSint, "127", "1"), "-128");
  EXPECT_EQ(binary(Opcode::kAdd16, TypeId::kUint, "65535", "2"), "1");
  EXPECT_EQ(binary(Opcode::kSub32, TypeId::kDint, "-2147483648", "1"), "2147483647");
  EXPECT_EQ(binary(Opcode::kMul64, TypeId::kLint, "9223372036854775807", "2"), "-2");
  EXPECT_EQ(binary(Opcode::kMul16, TypeId::kUint, "65535", "65535"), "1");
}

TEST(Interpreter, DivisionIsDefinedForEveryDivisor) {
  EXPECT_EQ(binary(Opcode::kDivI32, TypeId::kDint, "-7", "2"), "-3");
  EXPECT_EQ(binary(Opcode::kDivI32, TypeId::kDint, "7", "0"), "0");
  EXPECT_EQ(binary(Opcode::kDivI64, TypeId::kLint, "-9223372036854775808", "-1"), "-9223372036854775808");
  EXPECT_EQ(binary(Opcode::kDivU8, TypeId::kUsint, "200", "3"), "66");
  EXPECT_EQ(binary(Opcode::kModI16, TypeId::kInt, "-7", "3"), "-1");
  EXPECT_EQ(binary(Opcode::kModU64, TypeId::kUlint, "7", "0"), "0");
}

TEST(Interpreter, RealsFollowIeee754WithOneNan) {
  EXPECT_EQ(binary(Opcode::kAddF32, TypeId::kReal, "0.1", "0.2"), "0.3");
  EXPECT_EQ(binary(Opcode::kAddF64, TypeId::kLreal, "0.1", "0.2"), "0.30000000000000004");
  EXPECT_EQ(binary(Opcode::kDivF64, TypeId::kLreal, "1", "0"), "inf");
  EXPECT_EQ(binary(Opcode::kDivF32, TypeId::kReal, "0", "0"), "nan");
  EXPECT_EQ(binary(Opcode::kSubF64, TypeId::kLreal, "inf", "inf"), "nan");
}

TEST(Interpreter, ComparisonsMindTheSign) {
  EXPECT_EQ(compare(Opcode::kLtI8, TypeId::kSint, "-1", "1"), "1");
  EXPECT_EQ(compare(Opcode::kLtU8, TypeId::kUsint, "255", "1"), "0");
  EXPECT_EQ(compare(Opcode::kGeI64, TypeId::kLint, "5", "5"), "1");
  EXPECT_EQ(compare(Opcode::kGtU32, TypeId::kUdint, "4294967295", "0"), "1");
  EXPECT_EQ(compare(Opcode::kLeI16, TypeId::kInt, "6", "5"), "0");
  EXPECT_EQ(compare(Opcode::kEq32, TypeId::kDint, "-1", "-1"), "1");
  EXPECT_EQ(compare(Opcode::kNe64, TypeId::kLword, "1", "1"), "0");
  EXPECT_EQ(compare(Opcode::kEqF64, TypeId::kLreal, "nan", "nan"), "0");
  EXPECT_EQ(compare(Opcode::kNeF32, TypeId::kReal, "nan", "nan"), "1");
  EXPECT_EQ(compare(Opcode::kLtF32, TypeId::kReal, "-0.5", "0.25"), "1");
}

TEST(Interpreter, BitStrings) {
  EXPECT_EQ(binary(Opcode::kAnd8, TypeId::kByte, "2#1100", "2#1010"), "8");
  EXPECT_EQ(binary(Opcode::kOr32, TypeId::kDword, "16#F0", "16#0F"), "255");
  EXPECT_EQ(binary(Opcode::kXor64, TypeId::kLword, "16#FFFF", "16#00FF"), "65280");
}

TEST(Interpreter, EventsAreCountedWithTheirInstruction) {
  OneProgram p;
  const Word zero = p.b.constant<std::int32_t>(TypeId::kDint, 0);
  const Word x = p.main.variable("x", p.b.type(TypeId::kDint));
  const Word eno = p.main.variable("eno", p.b.boolean());
  const Word later = p.main.variable("later", p.b.boolean());
  p.main.op(Opcode::kClearEvent);
  const std::uint32_t word = p.main.here();
  p.main.op(Opcode::kDivI32, {x, x, zero});
  p.main.op(Opcode::kEno, {eno});
  p.main.op(Opcode::kClearEvent);
  p.main.op(Opcode::kEno, {later});
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  Program& program = r->program(0);
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(program.execute({}));
  EXPECT_EQ(value_of(*r, "Main0.eno"), "0");
  EXPECT_EQ(value_of(*r, "Main0.later"), "1");
  const auto events = program.events();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].word, word);
  EXPECT_EQ(r->image().pous[events[0].pou].name, "Main");
  EXPECT_EQ(events[0].last, stdlib::Event::kDivideByZero);
  EXPECT_EQ(events[0].count, 3u);
  program.reset();
  EXPECT_EQ(program.event_total(), 0u);
}

TEST(Interpreter, EventsBeyondTheTableShareACounter) {
  OneProgram p;
  const Word zero = p.b.constant<std::int32_t>(TypeId::kDint, 0);
  const Word x = p.main.variable("x", p.b.type(TypeId::kDint));
  constexpr std::size_t kDivisions = 2 * Program::kEventSlots;
  for (std::size_t i = 0; i < kDivisions; ++i) p.main.op(Opcode::kDivI32, {x, x, zero});
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  r->program(0).execute({});
  const auto events = r->program(0).events();
  EXPECT_LE(events.size(), Program::kEventSlots);
  EXPECT_GT(events.size(), Program::kEventSlots / 2);
  EXPECT_EQ(events.size() + r->program(0).other_events(), kDivisions);
  EXPECT_EQ(r->program(0).event_total(), kDivisions);
}

TEST(Interpreter, EndlessLoopIsAFaultWithItsPlace) {
  OneProgram p;
  const Word n = p.main.variable("n", p.b.type(TypeId::kDint));
  const Word one = p.b.constant<std::int32_t>(TypeId::kDint, 1);
  const std::uint32_t top = p.main.here();
  p.main.op(Opcode::kAdd32, {n, n, one});
  const std::uint32_t word = p.main.here();
  p.main.op(Opcode::kLoopJump, {top});
  auto r = p.load({.loop_budget = 100});
  ASSERT_NE(r, nullptr);
  const runtime::Fault fault = r->program(0).execute({});
  EXPECT_EQ(fault.kind, FaultKind::kLoopBudget);
  EXPECT_EQ(fault.word, word);
  EXPECT_EQ(r->image().pous[fault.pou].name, "Main");
  EXPECT_EQ(value_of(*r, "Main0.n"), "101");
  // The budget is of one scan.
  EXPECT_TRUE(r->program(0).execute({}));
  EXPECT_EQ(value_of(*r, "Main0.n"), "202");
}

TEST(Interpreter, FaultKeepsTheScanFromExporting) {
  OneProgram p;
  const Word g = p.b.global("g", p.b.type(TypeId::kDint));
  const Word one = p.b.constant<std::int32_t>(TypeId::kDint, 1);
  const std::uint32_t top = p.main.here();
  p.main.op(Opcode::kAdd32, {g, g, one});
  p.main.op(Opcode::kLoopJump, {top});
  auto r = p.load({.loop_budget = 3});
  ASSERT_NE(r, nullptr);
  EXPECT_TRUE(r->program(0).execute({}));
  EXPECT_EQ(value_of(*r, "g"), "0");
}

TEST(Interpreter, ConditionalJumpSkipsWhenFalse) {
  OneProgram p;
  const Word c = p.main.variable("c", p.b.boolean());
  const Word x = p.main.variable("x", p.b.type(TypeId::kInt));
  const Word one = p.b.constant<std::int16_t>(TypeId::kInt, 1);
  const std::uint32_t skip = p.main.jump(Opcode::kCondJump, {c});
  p.main.op(Opcode::kAdd16, {x, x, one});
  p.main.land(skip);
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.x"), "0");
  set(*r, "Main0.c", "TRUE");
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.x"), "1");
}

TEST(Interpreter, StringsAreCutWithAnEvent) {
  OneProgram p;
  const Word text = p.b.text("machine");
  const Word small = p.main.variable("small", p.b.string(4));
  const Word large = p.main.variable("large", p.b.string(20));
  p.main.op(Opcode::kMoveStr, {small, text});
  p.main.op(Opcode::kMoveStr, {large, text});
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.small"), "'mach'");
  EXPECT_EQ(value_of(*r, "Main0.large"), "'machine'");
  ASSERT_EQ(r->program(0).events().size(), 1u);
  EXPECT_EQ(r->program(0).events()[0].last, stdlib::Event::kTruncated);
}

TEST(Interpreter, OneBodyServesAllInstances) {
  OneProgram p;
  PouBuilder counter = p.b.pou("Counter", PouKind::kFunctionBlock);
  const Word n = counter.variable("n", p.b.type(TypeId::kDint));
  const Word step = counter.variable("step", p.b.type(TypeId::kDint), FieldRole::kInput);
  const Word sum = counter.frame("sum", p.b.type(TypeId::kDint));
  counter.op(Opcode::kAdd32, {sum, n, step});
  counter.op(Opcode::kMove32, {n, sum});
  const std::uint32_t fb = counter.finish();
  const Word a = p.main.instance_of("a", fb);
  const Word b = p.main.instance_of("b", fb);
  p.main.op(Opcode::kCallPou, {fb, a});
  p.main.op(Opcode::kCallPou, {fb, b});
  p.main.op(Opcode::kCallPou, {fb, b});
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  set(*r, "main0.A.step", "1");
  set(*r, "main0.b.step", "10");
  for (int i = 0; i < 3; ++i) r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.a.n"), "3");
  EXPECT_EQ(value_of(*r, "Main0.b.n"), "60");
  EXPECT_EQ(r->program(0).link_report().relative_bodies, 1u);
  EXPECT_EQ(r->program(0).link_report().fixed_bodies, 2u);
}

TEST(Interpreter, InstancesInsideSeveralInstancesAreRelativeToo) {
  OneProgram p;
  PouBuilder inner = p.b.pou("Inner", PouKind::kFunctionBlock);
  const Word n = inner.variable("n", p.b.type(TypeId::kInt));
  inner.op(Opcode::kAdd16, {n, n, p.b.constant<std::int16_t>(TypeId::kInt, 1)});
  const std::uint32_t inner_fb = inner.finish();
  PouBuilder outer = p.b.pou("Outer", PouKind::kFunctionBlock);
  outer.variable("padding", p.b.type(TypeId::kLint));
  const Word in = outer.instance_of("in", inner_fb);
  outer.op(Opcode::kCallPou, {inner_fb, in});
  const std::uint32_t outer_fb = outer.finish();
  const Word a = p.main.instance_of("a", outer_fb);
  const Word b = p.main.instance_of("b", outer_fb);
  p.main.op(Opcode::kCallPou, {outer_fb, a});
  p.main.op(Opcode::kCallPou, {outer_fb, b});
  p.main.op(Opcode::kCallPou, {outer_fb, b});
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.a.in.n"), "1");
  EXPECT_EQ(value_of(*r, "Main0.b.in.n"), "2");
}

TEST(Interpreter, FunctionsStartWithAFreshFrame) {
  OneProgram p;
  PouBuilder f = p.b.pou("Twice", PouKind::kFunction);
  const std::uint32_t dint = p.b.type(TypeId::kDint);
  const Word in = f.frame("in", dint, FieldRole::kInput);
  const Word result = f.frame("Twice", dint, FieldRole::kReturnValue);
  const Word calls = f.frame("calls", dint, FieldRole::kLocal, bytes_of<std::int32_t>(100));
  const Word label = f.frame("label", p.b.string(3), FieldRole::kOutput);
  f.op(Opcode::kAdd32, {calls, calls, p.b.constant<std::int32_t>(TypeId::kDint, 1)});
  f.op(Opcode::kAdd32, {result, in, in});
  f.op(Opcode::kAdd32, {result, result, calls});
  f.op(Opcode::kMoveStr, {label, p.b.text("xyz")});
  const std::uint32_t twice = f.finish();
  const Word a = p.main.variable("a", dint);
  const Word b = p.main.variable("b", dint);
  const Word s = p.main.variable("s", p.b.string(10));
  p.main.list(Opcode::kCallFn, 3, {twice, 0, a, 1, b, 3, s});
  p.main.list(Opcode::kCallFn, 2, {twice, 0, b, 1, b});
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  set(*r, "Main0.a", "5");
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.b"), "323");
  EXPECT_EQ(value_of(*r, "Main0.s"), "'xyz'");
}

TEST(Interpreter, EventInsideACalleeReachesTheCallersEno) {
  OneProgram p;
  PouBuilder f = p.b.pou("Bad", PouKind::kFunction);
  const Word x = f.frame("x", p.b.type(TypeId::kDint), FieldRole::kLocal);
  f.op(Opcode::kDivI32, {x, x, x});
  f.op(Opcode::kClearEvent);  // of the callee's own drawing: not the caller's
  const std::uint32_t bad = f.finish();
  const Word eno = p.main.variable("eno", p.b.boolean());
  p.main.op(Opcode::kClearEvent);
  p.main.list(Opcode::kCallFn, 0, {bad});
  p.main.op(Opcode::kEno, {eno});
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  set(*r, "Main0.eno", "1");
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.eno"), "0");
}

TEST(Interpreter, StandardFunctionsAndBlocks) {
  OneProgram p;
  const std::uint32_t dint = p.b.type(TypeId::kDint);
  const Word x = p.main.variable("x", dint, FieldRole::kLocal, bytes_of<std::int32_t>(50));
  const Word y = p.main.variable("y", dint);
  const Word low = p.b.constant<std::int32_t>(TypeId::kDint, -3);
  const Word high = p.b.constant<std::int32_t>(TypeId::kDint, 7);
  p.main.call_std("LIMIT:DINT", y, {low, x, high});
  const Word timer = p.main.variable("timer", p.b.block_type("TON"));
  p.main.op(Opcode::kRunTb, {p.b.block("TON"), timer});
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  set(*r, "Main0.timer.IN", "1");
  set(*r, "Main0.timer.PT", "20000000");
  r->program(0).execute({.now_ns = 1'000'000});
  EXPECT_EQ(value_of(*r, "Main0.y"), "7");
  EXPECT_EQ(value_of(*r, "Main0.timer.Q"), "0");
  r->program(0).execute({.now_ns = 21'000'000});
  EXPECT_EQ(value_of(*r, "Main0.timer.Q"), "1");
  EXPECT_EQ(value_of(*r, "Main0.timer.ET"), "20000000");
}

TEST(Interpreter, CopyMovesWholeValues) {
  OneProgram p;
  const std::uint32_t array = p.b.array(p.b.type(TypeId::kInt), 3, 1);
  const Word a = p.main.variable("a", array);
  const Word b = p.main.variable("b", array);
  p.main.op(Opcode::kCopy, {b, a, array});
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  set(*r, "Main0.a[1]", "11");
  set(*r, "Main0.a[3]", "33");
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.b"), "[11, 0, 33]");
}

}  // namespace
}  // namespace plc::test
