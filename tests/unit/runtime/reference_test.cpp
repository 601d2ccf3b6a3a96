// Parts of values: LOAD, STORE, REF, RUN and CALL, from a place (AT) and through checked references (VIA).
#include <limits>
#include <vector>

#include "tests/unit/runtime/run_support.h"

namespace plc::test {
namespace {

using stdlib::Event;

std::vector<Event> kinds(runtime::Resource& r, std::size_t task = 0) {
  std::vector<Event> found;
  for (const auto& e : r.program(task).events()) found.push_back(e.last);
  return found;
}

/// out := values[index], values[index] := in, directly and through a reference, for one type of elements and indices.
struct OneIndex : OneProgram {
  std::uint32_t element, array;
  Word values, index, in, out_at, out_via, ref;

  OneIndex(TypeId element_id, TypeId index_id, std::int64_t lower)
      : element(b.type(element_id)), array(b.array(element, 4, lower)) {
    values = main.variable("values", array);
    index = main.variable("index", b.type(index_id));
    in = main.variable("in", element);
    out_at = main.variable("out_at", element);
    out_via = main.variable("out_via", element);
    ref = main.variable("ref", b.ref(array));
    main.path(Opcode::kRefAt, {ref, values, array}, {});
    main.path(Opcode::kLoadAt, {out_at, values, array}, {{PathStep::kIndex, index}});
    main.path(Opcode::kLoadVia, {out_via, ref, array}, {{PathStep::kIndex, index}});
    const Word go = main.variable("go", b.boolean());
    const auto skip = main.jump(Opcode::kCondJump, {go});
    main.path(Opcode::kStoreAt, {values, in, array}, {{PathStep::kIndex, index}});
    main.path(Opcode::kLoadAt, {out_at, values, array}, {{PathStep::kIndex, index}});
    main.path(Opcode::kStoreVia, {ref, in, array}, {{PathStep::kIndex, index}});
    main.land(skip);
  }
};

TEST(Parts, EverySizeOfElementsAndEveryTypeOfIndex) {
  for (const TypeId element : {TypeId::kUsint, TypeId::kInt, TypeId::kReal, TypeId::kLint}) {
    for (const TypeId index : {TypeId::kSint, TypeId::kUsint, TypeId::kInt, TypeId::kUint, TypeId::kDint,
                               TypeId::kUdint, TypeId::kLint, TypeId::kUlint, TypeId::kWord}) {
      SCOPED_TRACE(std::string(core::name_of(element)) + " at " + std::string(core::name_of(index)));
      OneIndex p(element, index, 10);
      auto r = p.load();
      ASSERT_NE(r, nullptr);
      set(*r, "Main0.values[10]", "100");
      set(*r, "Main0.values[13]", "103");
      set(*r, "Main0.index", "13");
      r->program(0).execute({});
      EXPECT_EQ(value_of(*r, "Main0.out_at"), value_of(*r, "Main0.values[13]"));
      EXPECT_EQ(value_of(*r, "Main0.out_via"), value_of(*r, "Main0.values[13]"));
      set(*r, "Main0.index", "10");
      r->program(0).execute({});
      EXPECT_EQ(value_of(*r, "Main0.out_at"), value_of(*r, "Main0.values[10]"));
      EXPECT_EQ(value_of(*r, "Main0.out_via"), value_of(*r, "Main0.values[10]"));
      set(*r, "Main0.go", "1");
      set(*r, "Main0.in", "7");
      set(*r, "Main0.index", "11");
      r->program(0).execute({});
      EXPECT_EQ(value_of(*r, "Main0.values[11]"), value_of(*r, "Main0.in"));
      EXPECT_EQ(value_of(*r, "Main0.out_at"), value_of(*r, "Main0.in"));
      EXPECT_EQ(r->program(0).event_total(), 0u);
      // Two accesses before the jump and three after it.
      for (const char* bad : {"9", "14", "0", "127"}) {
        const std::uint64_t before = r->program(0).event_total();
        const std::string whole = value_of(*r, "Main0.values");
        set(*r, "Main0.index", bad);
        set(*r, "Main0.out_at", "5");
        r->program(0).execute({});
        EXPECT_EQ(r->program(0).event_total(), before + 5) << bad;
        EXPECT_EQ(value_of(*r, "Main0.values"), whole) << bad;
        EXPECT_EQ(std::stod(value_of(*r, "Main0.out_at")), 0.0) << bad;
        EXPECT_EQ(std::stod(value_of(*r, "Main0.out_via")), 0.0) << bad;
      }
      for (const Event kind : kinds(*r)) EXPECT_EQ(kind, Event::kBadIndex);
    }
  }
}

TEST(Parts, BoundsAtTheEndsOfTheNumbers) {
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min();
  struct Case {
    TypeId index;
    std::int64_t lower;
    const char* good;
    std::vector<const char*> bad;
  };
  const Case cases[] = {
      {TypeId::kLint, kMost - 3, "9223372036854775807", {"-9223372036854775808", "9223372036854775803", "-1", "0"}},
      {TypeId::kLint, kLeast, "-9223372036854775808", {"9223372036854775807", "-9223372036854775804", "0"}},
      {TypeId::kUlint, -1, "2", {"18446744073709551615", "18446744073709551614", "9223372036854775808", "3"}},
      {TypeId::kUlint, kMost - 3, "9223372036854775807", {"9223372036854775808", "18446744073709551615", "0"}},
      {TypeId::kDint, 2'147'483'645, "2147483647", {"-2147483648", "-2147483647", "0"}},
      {TypeId::kDint, -2'147'483'648, "-2147483648", {"2147483647", "-2147483644", "0"}},
      {TypeId::kDint, 4'294'967'295, "0", {}},
      {TypeId::kInt, 32'765, "32767", {"-32768", "-32767", "0"}},
      {TypeId::kSint, -128, "-128", {"127", "-124"}},
  };
  for (const Case& c : cases) {
    OneIndex p(TypeId::kDint, c.index, c.lower);
    auto r = p.load();
    ASSERT_NE(r, nullptr);
    set(*r, "Main0.index", c.good);
    r->program(0).execute({});
    // The array from 2^32 - 1 on has no element that a DINT can name.
    EXPECT_EQ(r->program(0).event_total(), c.bad.empty() ? 2u : 0u) << c.good << " from " << c.lower;
    for (const char* bad : c.bad) {
      const std::uint64_t before = r->program(0).event_total();
      set(*r, "Main0.index", bad);
      r->program(0).execute({});
      EXPECT_EQ(r->program(0).event_total(), before + 2) << bad << " from " << c.lower;
    }
  }
}

TEST(Parts, PathsOfFieldsElementsAndSeveralIndices) {
  OneProgram p;
  const std::uint32_t integer = p.b.type(TypeId::kInt);
  const std::uint32_t dint = p.b.type(TypeId::kDint);
  const std::uint32_t row = p.b.array(dint, 3, 1);
  const std::uint32_t cell = p.b.structure("Cell", {{"n", integer}, {"row", row}});
  const std::uint32_t grid = p.b.array(p.b.array(cell, 2, -1), 3, 5);
  const Word it = p.main.variable("it", grid);
  const Word i = p.main.variable("i", integer);
  const Word j = p.main.variable("j", p.b.type(TypeId::kSint));
  const Word k = p.main.variable("k", dint);
  const Word out = p.main.variable("out", dint);
  const Word whole = p.main.variable("whole", row);
  const Word fixed = p.main.variable("fixed", dint);
  const Word ref = p.main.variable("ref", p.b.ref(grid));
  const Word part = p.main.variable("part", p.b.ref(row));
  const Word through = p.main.variable("through", dint);
  const std::vector<PouBuilder::Step> to_row{{PathStep::kIndex, i}, {PathStep::kIndex, j}, {PathStep::kField, 1}};
  std::vector<PouBuilder::Step> to_leaf = to_row;
  to_leaf.push_back({PathStep::kIndex, k});
  p.main.path(Opcode::kRefAt, {ref, it, grid}, {});
  p.main.path(Opcode::kLoadAt, {out, it, grid}, to_leaf);
  p.main.path(Opcode::kLoadVia, {whole, ref, grid}, to_row);
  p.main.path(Opcode::kLoadAt, {fixed, it, grid},
              {{PathStep::kElement, 2}, {PathStep::kElement, 0}, {PathStep::kField, 1}, {PathStep::kElement, 2}});
  p.main.path(Opcode::kRefVia, {part, ref, grid}, to_row);
  p.main.path(Opcode::kLoadVia, {through, part, row}, {{PathStep::kIndex, k}});
  p.main.path(Opcode::kStoreAt, {it, p.b.constant<std::int32_t>(TypeId::kDint, 9), grid}, to_leaf);
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  set(*r, "Main0.it[7][-1].row[3]", "71");
  set(*r, "Main0.it[6][0].row[1]", "60");
  set(*r, "Main0.it[6][0].row[2]", "61");
  set(*r, "Main0.i", "6");
  set(*r, "Main0.j", "0");
  set(*r, "Main0.k", "2");
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.out"), "61");
  EXPECT_EQ(value_of(*r, "Main0.whole"), "[60, 61, 0]");
  EXPECT_EQ(value_of(*r, "Main0.fixed"), "71");
  EXPECT_EQ(value_of(*r, "Main0.through"), "61");
  EXPECT_EQ(value_of(*r, "Main0.it[6][0].row[2]"), "9");
  EXPECT_EQ(r->program(0).event_total(), 0u);
  set(*r, "Main0.j", "1");  // the middle index
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.out"), "0");
  EXPECT_EQ(value_of(*r, "Main0.whole"), "[0, 0, 0]");
  EXPECT_EQ(value_of(*r, "Main0.through"), "0");
  // One of each access; the load through the null reference that REF_VIA made is one of its own.
  EXPECT_EQ(r->program(0).event_total(), 5u);
}

TEST(Parts, StringsKeepTheirCapacity) {
  OneProgram p;
  const std::uint32_t text = p.b.string(6);
  const std::uint32_t texts = p.b.array(text, 2, 1);
  const Word it = p.main.variable("it", texts);
  const Word i = p.main.variable("i", p.b.type(TypeId::kInt));
  const Word shorter = p.main.variable("shorter", p.b.string(3));
  const Word longer = p.main.variable("longer", p.b.string(20));
  p.main.path(Opcode::kStoreAt, {it, p.b.text("abcdefgh"), texts}, {{PathStep::kIndex, i}});
  p.main.path(Opcode::kLoadAt, {shorter, it, texts}, {{PathStep::kIndex, i}});
  p.main.path(Opcode::kLoadAt, {longer, it, texts}, {{PathStep::kElement, 1}});
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  set(*r, "Main0.i", "2");
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.it"), "['', 'abcdef']");
  EXPECT_EQ(value_of(*r, "Main0.shorter"), "'abc'");
  EXPECT_EQ(value_of(*r, "Main0.longer"), "'abcdef'");
  EXPECT_EQ(kinds(*r), (std::vector<Event>{Event::kTruncated, Event::kTruncated}));
  set(*r, "Main0.i", "3");
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.shorter"), "''");
  EXPECT_EQ(r->program(0).event_total(), 4u);
}

TEST(Parts, StructuresOfNullKeepTheCapacitiesOfTheirStrings) {
  OneProgram p;
  const std::uint32_t text = p.b.string(6);
  const std::uint32_t dint = p.b.type(TypeId::kDint);
  const std::uint32_t record = p.b.structure("Record", {{"n", dint}, {"text", text}});
  const Word it = p.main.variable("it", record);
  const Word copy = p.main.variable("copy", record);
  const Word n = p.main.variable("n", dint);
  const Word ref = p.main.variable("ref", p.b.ref(record));
  const Word null = p.main.variable("null", p.b.ref(record));
  const Word no_n = p.main.variable("no_n", dint);
  p.main.path(Opcode::kRefAt, {ref, it, record}, {});
  p.main.path(Opcode::kLoadVia, {n, ref, record}, {{PathStep::kField, 0}});
  p.main.path(Opcode::kLoadVia, {no_n, null, record}, {{PathStep::kField, 0}});
  p.main.path(Opcode::kLoadVia, {copy, null, record}, {});
  p.main.path(Opcode::kStoreVia, {null, copy, record}, {});
  p.main.path(Opcode::kStoreVia, {null, n, record}, {{PathStep::kField, 0}});
  p.main.op(Opcode::kMoveStr, {copy + p.b.image.types[record].fields[1].offset, p.b.text("abcdef")});
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  set(*r, "Main0.it.n", "4711");
  set(*r, "Main0.copy.n", "1");
  set(*r, "Main0.no_n", "1");
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.n"), "4711");
  EXPECT_EQ(value_of(*r, "Main0.no_n"), "0");
  EXPECT_EQ(value_of(*r, "Main0.copy"), "(n := 0, text := 'abcdef')");
  EXPECT_EQ(r->program(0).event_total(), 4u);
  for (const Event kind : kinds(*r)) EXPECT_EQ(kind, Event::kNullReference);
}

TEST(Parts, BlocksInArraysAndThroughReferences) {
  OneProgram p;
  PouBuilder counter = p.b.pou("Counter", PouKind::kFunctionBlock);
  const Word n = counter.variable("n", p.b.type(TypeId::kDint));
  counter.op(Opcode::kAdd32, {n, n, p.b.constant<std::int32_t>(TypeId::kDint, 1)});
  const std::uint32_t fb = counter.finish();
  const std::uint32_t fb_type = p.b.image.pous[fb].instance_type;
  const std::uint32_t trigger = p.b.block_type("R_TRIG");
  const std::uint32_t station = p.b.structure("Station", {{"counter", fb_type}, {"edge", trigger}});
  const std::uint32_t line = p.b.array(station, 3, 1);
  const Word stations = p.main.variable("stations", line);
  const Word i = p.main.variable("i", p.b.type(TypeId::kInt));
  const Word ref = p.main.variable("ref", p.b.ref(line));
  const Word edge = p.main.variable("edge", p.b.ref(trigger));
  p.main.path(Opcode::kCallAt, {fb, stations, line}, {{PathStep::kIndex, i}, {PathStep::kField, 0}});
  p.main.path(Opcode::kRunAt, {p.b.block("R_TRIG"), stations, line}, {{PathStep::kIndex, i}, {PathStep::kField, 1}});
  p.main.path(Opcode::kCallVia, {fb, ref, line}, {{PathStep::kIndex, i}, {PathStep::kField, 0}});
  p.main.path(Opcode::kRunVia, {p.b.block("R_TRIG"), edge, trigger}, {});
  p.main.path(Opcode::kRefAt, {ref, stations, line}, {});
  p.main.path(Opcode::kRefVia, {edge, ref, line}, {{PathStep::kElement, 2}, {PathStep::kField, 1}});
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  set(*r, "Main0.i", "2");
  set(*r, "Main0.stations[2].edge.CLK", "1");
  set(*r, "Main0.stations[3].edge.CLK", "1");
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.stations[2].counter.n"), "1");
  EXPECT_EQ(value_of(*r, "Main0.stations[2].edge.Q"), "1");
  EXPECT_EQ(kinds(*r), (std::vector<Event>{Event::kNullReference, Event::kNullReference}));
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.stations[2].counter.n"), "3");
  EXPECT_EQ(value_of(*r, "Main0.stations[3].edge.Q"), "1");
  EXPECT_EQ(r->program(0).event_total(), 2u);
  const std::string before = value_of(*r, "Main0.stations");
  set(*r, "Main0.i", "0");
  set(*r, "Main0.stations[3].edge.CLK", "1");
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.stations[1].counter.n"), "0");
  EXPECT_EQ(value_of(*r, "Main0.stations[2].counter.n"), "3");
  EXPECT_EQ(r->program(0).event_total(), 5u);  // CALL_AT, RUN_AT, CALL_VIA: one each
}

TEST(Parts, ABodyOfSeveralInstancesReachesItsOwn) {
  ImageBuilder b;
  const std::uint32_t dint = b.type(TypeId::kDint);
  const std::uint32_t array = b.array(dint, 3, 1);
  PouBuilder fb = b.pou("Fb", PouKind::kFunctionBlock);
  const Word values = fb.variable("values", array);
  const Word i = fb.variable("i", b.type(TypeId::kInt));
  const Word out = fb.variable("out", dint);
  const Word ref = fb.variable("ref", b.ref(array));
  fb.path(Opcode::kStoreAt, {values, b.constant<std::int32_t>(TypeId::kDint, 5), array}, {{PathStep::kIndex, i}});
  fb.path(Opcode::kRefAt, {ref, values, array}, {});
  fb.path(Opcode::kLoadVia, {out, ref, array}, {{PathStep::kIndex, i}});
  const std::uint32_t fb_pou = fb.finish();
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  for (const char* name : {"one", "two"}) main.op(Opcode::kCallPou, {fb_pou, main.instance_of(name, fb_pou)});
  b.task("T", 10'000'000, {main.finish()});
  auto r = load(b);
  ASSERT_NE(r, nullptr);
  set(*r, "Main0.one.i", "1");
  set(*r, "Main0.two.i", "3");
  r->program(0).execute({});
  EXPECT_EQ(value_of(*r, "Main0.one.values"), "[5, 0, 0]");
  EXPECT_EQ(value_of(*r, "Main0.two.values"), "[0, 0, 5]");
  EXPECT_EQ(value_of(*r, "Main0.two.out"), "5");
}

TEST(Parts, HandleOfAnotherTaskIsNull) {
  ImageBuilder b;
  const std::uint32_t dint = b.type(TypeId::kDint);
  const Word shared = b.global("shared", b.ref(dint));
  PouBuilder maker = b.pou("Maker", PouKind::kProgram);
  const Word own = maker.variable("own", dint, FieldRole::kLocal, bytes_of<std::int32_t>(7));
  maker.path(Opcode::kRefAt, {shared, own, dint}, {});
  const std::uint32_t maker_pou = maker.finish();
  PouBuilder user = b.pou("User", PouKind::kProgram);
  const Word got = user.variable("got", dint, FieldRole::kLocal, bytes_of<std::int32_t>(-1));
  user.path(Opcode::kLoadVia, {got, shared, dint}, {});
  const std::uint32_t user_pou = user.finish();
  b.task("A", 10'000'000, {maker_pou});
  b.task("B", 10'000'000, {user_pou});
  auto r = load(b);
  ASSERT_NE(r, nullptr);
  r->program(0).execute({});
  r->program(1).execute({});
  EXPECT_EQ(value_of(*r, "User0.got"), "0");
  EXPECT_EQ(kinds(*r, 1), std::vector<Event>{Event::kNullReference});
}

TEST(Parts, BitsAndBytesOfWords) {
  struct Case {
    TypeId word, part;
    Word bit;
    const char *before, *value, *part_text, *after;
  };
  const Case cases[] = {
      {TypeId::kByte, TypeId::kBool, 7, "128", "0", "1", "0"},
      {TypeId::kWord, TypeId::kBool, 0, "65534", "1", "0", "65535"},
      {TypeId::kInt, TypeId::kBool, 15, "-1", "0", "1", "32767"},
      {TypeId::kDword, TypeId::kBool, 17, "131072", "0", "1", "0"},
      {TypeId::kLword, TypeId::kBool, 63, "0", "1", "0", "9223372036854775808"},
      {TypeId::kWord, TypeId::kByte, 8, "4660", "255", "18", "65332"},
      {TypeId::kDword, TypeId::kWord, 16, "65536", "2", "1", "131072"},
      {TypeId::kLword, TypeId::kByte, 56, "0", "1", "0", "72057594037927936"},
      {TypeId::kLword, TypeId::kDword, 32, "4294967297", "0", "1", "1"},
  };
  const auto number = [](const std::string& text) {
    const std::size_t sign = text.find('#');
    return sign == std::string::npos ? std::stoull(text) : std::stoull(text.substr(sign + 1), nullptr, 16);
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(std::string(core::name_of(c.word)) + " bit " + std::to_string(c.bit));
    OneProgram p;
    const Word w = p.main.variable("w", p.b.type(c.word));
    const Word copy = p.main.variable("copy", p.b.type(c.word));
    const Word v = p.main.variable("v", p.b.type(c.part));
    const Word got = p.main.variable("got", p.b.type(c.part));
    p.main.op(Opcode::kExtract, {got, w, c.bit});
    p.main.op(Opcode::kInsert, {copy, w, v, c.bit});
    p.main.op(Opcode::kInsert, {w, w, v, c.bit});
    auto r = p.load();
    ASSERT_NE(r, nullptr);
    set(*r, "Main0.w", c.before);
    set(*r, "Main0.v", c.value);
    r->program(0).execute({});
    const std::string after = value_of(*r, "Main0.w");
    EXPECT_EQ(value_of(*r, "Main0.copy"), after);
    EXPECT_EQ(after[0] == '-' ? after : std::to_string(number(after)), c.after);
    const std::string part = value_of(*r, "Main0.got");
    EXPECT_EQ(part == "TRUE" ? "1" : part == "FALSE" ? "0" : std::to_string(number(part)), c.part_text);
  }
}

TEST(Parts, ValuesOutsideASubrangeAreHeldInsideWithAnEvent) {
  OneProgram p;
  const Word x = p.main.variable("x", p.b.type(TypeId::kInt));
  const Word y = p.main.variable("y", p.b.type(TypeId::kInt));
  p.main.op(Opcode::kRangeI16,
            {y, x, p.b.constant<std::int16_t>(TypeId::kInt, -5), p.b.constant<std::int16_t>(TypeId::kInt, 100)});
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  const std::pair<const char*, const char*> cases[] = {{"-5", "-5"}, {"100", "100"}, {"0", "0"},
                                                       {"-6", "-5"}, {"101", "100"}, {"-32768", "-5"}};
  for (const auto& [given, held] : cases) {
    set(*r, "Main0.x", given);
    r->program(0).execute({});
    EXPECT_EQ(value_of(*r, "Main0.y"), held);
  }
  EXPECT_EQ(r->program(0).event_total(), 3u);
  EXPECT_EQ(kinds(*r), std::vector<Event>{Event::kOutOfRange});
}

}  // namespace
}  // namespace plc::test
