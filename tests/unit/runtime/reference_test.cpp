// Checked references: MAKE_REF, INDEX_REF, FIELD_REF, COPY_FROM, COPY_TO, CALL_REF, RUN_REF.
#include "tests/unit/runtime/run_support.h"

namespace plc::test {
namespace {

struct Elements : OneProgram {
  std::uint32_t dint = b.type(TypeId::kDint);
  std::uint32_t array = b.array(dint, 4, 10);
  std::uint32_t ref_array = b.ref(array);
  std::uint32_t ref_dint = b.ref(dint);
  Word values = main.variable("values", array);
  Word index = main.variable("index", b.type(TypeId::kLint));
  Word out = main.variable("out", dint, FieldRole::kLocal, bytes_of<std::int32_t>(-1));
  Word whole = main.frame("whole", ref_array);
  Word element = main.frame("element", ref_dint);
};

TEST(References, ElementsCountFromTheDeclaredBound) {
  Elements p;
  p.main.op(Opcode::kMakeRef, {p.whole, p.values, p.array});
  p.main.op(Opcode::kIndexRef, {p.element, p.whole, p.index, p.array});
  p.main.op(Opcode::kCopyFrom, {p.out, p.element, p.dint});
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  set(*r, "Main0.values[10]", "100");
  set(*r, "Main0.values[13]", "103");
  set(*r, "Main0.index", "13");
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.out"), "103");
  set(*r, "Main0.index", "10");
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.out"), "100");
  EXPECT_EQ(r->program(0).event_total(), 0u);
}

TEST(References, OutOfBoundsIsNullAndReadsZeros) {
  for (const char* index : {"9", "14", "-9223372036854775808", "9223372036854775807"}) {
    Elements p;
    p.main.op(Opcode::kMakeRef, {p.whole, p.values, p.array});
    p.main.op(Opcode::kIndexRef, {p.element, p.whole, p.index, p.array});
    p.main.op(Opcode::kCopyFrom, {p.out, p.element, p.dint});
    auto r = p.load();
    ASSERT_NE(r, nullptr);
    set(*r, "Main0.index", index);
    r->program(0).execute({});
    EXPECT_EQ(value_of(*r, "Main0.out"), "0") << index;
    std::vector<stdlib::Event> kinds;
    for (const auto& e : r->program(0).events()) kinds.push_back(e.last);
    EXPECT_EQ(kinds.size(), 2u);
    EXPECT_NE(std::find(kinds.begin(), kinds.end(), stdlib::Event::kBadIndex), kinds.end());
    EXPECT_NE(std::find(kinds.begin(), kinds.end(), stdlib::Event::kNullReference), kinds.end());
  }
}

TEST(References, WritesGoThrough) {
  Elements p;
  p.main.op(Opcode::kMakeRef, {p.whole, p.values, p.array});
  p.main.op(Opcode::kIndexRef, {p.element, p.whole, p.index, p.array});
  p.main.op(Opcode::kCopyTo, {p.element, p.out, p.dint});
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  set(*r, "Main0.index", "12");
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.values"), "[0, 0, -1, 0]");
  set(*r, "Main0.index", "99");
  set(*r, "Main0.out", "55");
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.values"), "[0, 0, -1, 0]");
}

TEST(References, FieldsAndStringsOfNullKeepTheirCapacity) {
  OneProgram p;
  const std::uint32_t text = p.b.string(6);
  const std::uint32_t dint = p.b.type(TypeId::kDint);
  const std::uint32_t record = p.b.structure("Record", {{"n", dint}, {"text", text}});
  const Word it = p.main.variable("it", record);
  const Word copy = p.main.variable("copy", record);
  const Word n = p.main.variable("n", dint);
  const Word ref = p.main.variable("ref", p.b.ref(record));
  const Word field = p.main.variable("field", p.b.ref(dint));
  const Word null = p.main.variable("null", p.b.ref(record));
  p.main.op(Opcode::kMakeRef, {ref, it, record});
  p.main.op(Opcode::kFieldRef, {field, ref, record, 0});
  p.main.op(Opcode::kCopyFrom, {n, field, dint});
  p.main.op(Opcode::kCopyFrom, {copy, null, record});
  p.main.op(Opcode::kMoveStr, {copy + p.b.image.types[record].fields[1].offset, p.b.text("abcdefgh")});
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  set(*r, "Main0.it.n", "4711");
  set(*r, "Main0.copy.n", "1");
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.n"), "4711");
  EXPECT_EQ(value_of(*r, "Main0.copy"), "(n := 0, text := 'abcdef')");
}

TEST(References, CallsOnReferredInstances) {
  OneProgram p;
  PouBuilder counter = p.b.pou("Counter", PouKind::kFunctionBlock);
  const Word n = counter.variable("n", p.b.type(TypeId::kDint));
  counter.op(Opcode::kAdd32, {n, n, p.b.constant<std::int32_t>(TypeId::kDint, 1)});
  const std::uint32_t fb = counter.finish();
  const std::uint32_t fb_type = p.b.image.pous[fb].instance_type;
  const Word a = p.main.instance_of("a", fb);
  const Word ref = p.main.variable("ref", p.b.ref(fb_type));
  const Word edge = p.main.variable("edge", p.b.block_type("R_TRIG"));
  const Word edge_ref = p.main.variable("edge_ref", p.b.ref(p.b.block_type("R_TRIG")));
  p.main.op(Opcode::kCallRef, {fb, ref});  // null in the first scan
  p.main.op(Opcode::kRunRef, {p.b.block("R_TRIG"), edge_ref});
  p.main.op(Opcode::kMakeRef, {ref, a, fb_type});
  p.main.op(Opcode::kMakeRef, {edge_ref, edge, p.b.block_type("R_TRIG")});
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  set(*r, "Main0.edge.CLK", "1");
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.a.n"), "0");
  EXPECT_EQ(r->program(0).event_total(), 2u);
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.a.n"), "1");
  EXPECT_EQ(value_of(*r, "Main0.edge.Q"), "1");
  EXPECT_EQ(r->program(0).event_total(), 2u);
}

TEST(References, HandleOfAnotherTaskIsNull) {
  ImageBuilder b;
  const std::uint32_t dint = b.type(TypeId::kDint);
  const Word shared = b.global("shared", b.ref(dint));
  PouBuilder maker = b.pou("Maker", PouKind::kProgram);
  const Word own = maker.variable("own", dint, FieldRole::kLocal, bytes_of<std::int32_t>(7));
  maker.op(Opcode::kMakeRef, {shared, own, dint});
  const std::uint32_t maker_pou = maker.finish();
  PouBuilder user = b.pou("User", PouKind::kProgram);
  const Word got = user.variable("got", dint, FieldRole::kLocal, bytes_of<std::int32_t>(-1));
  user.op(Opcode::kCopyFrom, {got, shared, dint});
  const std::uint32_t user_pou = user.finish();
  b.task("A", 10'000'000, {maker_pou});
  b.task("B", 10'000'000, {user_pou});
  auto r = load(b);
  ASSERT_NE(r, nullptr);
  r->program(0).execute({});
  r->program(1).execute({});
  EXPECT_EQ(value_of(*r, "User0.got"), "0");
  EXPECT_EQ(r->program(1).event_total(), 1u);
}

}  // namespace
}  // namespace plc::test
