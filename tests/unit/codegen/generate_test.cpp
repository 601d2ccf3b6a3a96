// Memory, calls, references and tasks: generated, verified and run.
#include "bytecode/codegen/generate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "ir/check.h"
#include "runtime/access.h"
#include "runtime/resource.h"
#include "tests/support/module_builder.h"

namespace plc {
namespace {

using core::TypeId;
using ir::Op;
using ir::Operand;
using ir::Role;
using test::literal;
using test::ModuleBuilder;
using test::type;

/// A module, generated, verified, linked.
struct Running {
  std::unique_ptr<runtime::Resource> resource;

  explicit Running(ModuleBuilder& m, const runtime::ProgramOptions& options = {}) {
    EXPECT_TRUE(ir::check(m.module, m.diagnostics)) << first(m.diagnostics);
    auto image = bytecode::generate(m.module, m.diagnostics);
    EXPECT_TRUE(image.has_value()) << first(m.diagnostics);
    if (!image) return;
    const std::string listing = bytecode::disassemble(*image);
    core::Diagnostics verdict;
    auto verified = bytecode::verify(std::move(*image), verdict);
    EXPECT_TRUE(verified.has_value()) << first(verdict) << "\n" << listing;
    if (!verified) return;
    auto loaded = runtime::Resource::load(std::move(*verified), options);
    EXPECT_TRUE(loaded.has_value());
    if (loaded) resource = std::move(*loaded);
  }
  static std::string first(const core::Diagnostics& d) { return d.all().empty() ? "" : d.all().front().message; }

  void scan(std::size_t task = 0, core::TimeNs now = 0) { EXPECT_FALSE(resource->program(task).execute({now})); }
  std::string read(const std::string& path) {
    runtime::Access access(*resource);
    const auto place = access.find(path);
    return place ? access.read(*place) : "no " + path;
  }
  void write(const std::string& path, const std::string& text) {
    runtime::Access access(*resource);
    const auto place = access.find(path);
    ASSERT_TRUE(place.has_value()) << path;
    EXPECT_FALSE(access.write(*place, text).has_value()) << path;
  }
};

ir::Constant number(TypeId id, std::uint64_t bits) { return {type(id), bits, {}}; }

struct Generate : testing::Test {
  ModuleBuilder m;
  std::uint32_t main = m.pou("Main");
  ir::TypeRef dint = type(TypeId::kDint);
  Generate() { m.task("T", main, "Main"); }
};

TEST_F(Generate, InitialValuesReachNestedInstances) {
  const auto fb = m.pou("Fb", ir::PouKind::kFunctionBlock);
  const auto k = m.variable(fb, "K", dint);
  m.module.pous[fb].variables[k].initial.push_back({{}, number(TypeId::kDint, 7)});
  const auto fbs = m.variable(main, "fbs", m.module.types.array(m.module.pous[fb].instance_type, 1, 2));
  m.module.pous[main].variables[fbs].initial.push_back({{1, k}, number(TypeId::kDint, 9)});
  const auto text = m.variable(main, "text", m.module.types.string(TypeId::kString, 5));
  m.module.pous[main].variables[text].initial.push_back({{}, {m.module.types.string(TypeId::kString, 2), 0, "ab"}});
  Running r(m);
  EXPECT_EQ(r.read("Main.fbs[1].K"), "7");
  EXPECT_EQ(r.read("Main.fbs[2].K"), "9");
  EXPECT_EQ(r.read("Main.text"), "'ab'");
}

TEST_F(Generate, VariablesInTheGlobalTableKeepTheirNamesInThePou) {
  const auto external = [this](std::uint32_t pou, const char* name, std::uint32_t global) {
    const auto v = m.variable(pou, name, m.module.globals[global].variable.type, Role::kExternal);
    m.module.pous[pou].variables[v].global = global;
    return v;
  };
  const auto level = m.global("Level", dint);
  const auto lamp = m.global("Fb.Lamp", ir::kBoolType);
  m.module.globals[lamp].variable.address = "%QX0.0";
  const auto other = m.global("Other", dint);
  const auto fb = m.pou("Fb", ir::PouKind::kFunctionBlock);
  const auto coil = external(fb, "Lamp", lamp);
  {
    auto b = m.body(fb);
    b.store(b.variable(coil), b.constant_bool(true));
  }
  const auto f = m.variable(main, "f", m.module.pous[fb].instance_type);
  const auto own = external(main, "lvl", level);
  external(main, "spare", other);
  auto b = m.body(main);
  b.store(b.variable(own), *b.convert(literal(5), dint, ""));
  b.run(b.variable(f));
  Running r(m);
  r.scan();
  for (const char* path : {"Main.lvl", "Level"}) EXPECT_EQ(r.read(path), "5") << path;
  for (const char* path : {"Main.f.Lamp", "Fb.Lamp", "%QX0.0"}) EXPECT_EQ(r.read(path), "1") << path;
  r.write("Main.spare", "6");
  EXPECT_EQ(r.read("Other"), "6");
  EXPECT_EQ(runtime::Access(*r.resource).list(), (std::vector<std::string>{"Main.f.Lamp", "Other", "Level"}));
}

TEST_F(Generate, FunctionCallsPassEveryKindOfParameter) {
  const auto f = m.pou("F", ir::PouKind::kFunction);
  const auto in = m.variable(f, "IN", dint, Role::kInput);
  const auto io = m.variable(f, "IO", dint, Role::kInOut);
  const auto out = m.variable(f, "OUT", ir::kBoolType, Role::kOutput);
  const auto result = m.variable(f, "F", dint, Role::kReturnValue);
  const auto start = m.variable(f, "start", dint);
  m.module.pous[f].variables[start].initial.push_back({{}, number(TypeId::kDint, 100)});
  {
    auto b = m.body(f);
    const std::vector<Operand> sum{Operand::of(b.load(b.variable(in))), Operand::of(b.load(b.variable(start)))};
    const auto v = *b.call("ADD", sum, {});
    b.store(b.variable(result), v);
    b.store(b.variable(start), v);
    b.store(b.variable(io), v);
    const std::vector<Operand> large{Operand::of(v), literal(105)};
    b.store(b.variable(out), *b.call("GT", large, {}));
  }
  const auto x = m.variable(main, "x", dint);
  const auto y = m.variable(main, "y", dint);
  const auto q = m.variable(main, "q", ir::kBoolType);
  auto b = m.body(main);
  const std::vector<ir::CallArg> args{
      {ir::CallArg::Kind::kInput, in, *b.convert(literal(6), dint, ""), {}},
      {ir::CallArg::Kind::kInOut, io, b.make_ref(b.variable(x)), {}},
      {ir::CallArg::Kind::kOutput, out, {}, b.variable(q)},
  };
  b.store(b.variable(y), b.call_pou(f, args));
  Running r(m);
  r.scan();
  r.scan();  // the frame starts anew in each call
  EXPECT_EQ(r.read("Main.x"), "106");
  EXPECT_EQ(r.read("Main.y"), "106");
  EXPECT_EQ(r.read("Main.q"), "1");
}

TEST_F(Generate, StructuresGoThroughInOutsAndCopies) {
  ir::Type point;
  point.kind = ir::TypeKind::kStruct;
  point.fields = {{"Name", m.module.types.string(TypeId::kString, 4)}, {"At", m.module.types.array(dint, 1, 3)}};
  m.module.types.declare("Point", point);
  const auto p = *m.module.types.find("Point");
  const auto fb = m.pou("Fb", ir::PouKind::kFunctionBlock);
  const auto io = m.variable(fb, "IO", p, Role::kInOut);
  const auto i = m.variable(fb, "I", dint, Role::kInput);
  {
    auto b = m.body(fb);
    const auto at = *b.member(b.variable(io), "At");
    const auto element = b.element_at(at, b.load(b.variable(i)));
    const std::vector<Operand> sum{Operand::of(b.load(element)), literal(5)};
    b.store(element, *b.call("ADD", sum, {}));
    b.store(b.element(*b.member(b.variable(io), "At"), 0), *b.convert(literal(1), dint, ""));
    b.store(*b.member(b.variable(io), "Name"), b.constant({m.module.types.string(TypeId::kString, 6), 0, "pump12"}));
  }
  const auto a = m.variable(main, "a", p);
  const auto c = m.variable(main, "c", p);
  const auto f = m.variable(main, "f", m.module.pous[fb].instance_type);
  auto b = m.body(main);
  const auto instance = b.variable(f);
  b.store(*b.member(instance, "IO"), b.make_ref(b.variable(a)));
  b.store(*b.member(instance, "I"), *b.convert(literal(3), dint, ""));
  b.run(instance);
  ASSERT_TRUE(b.assign(b.variable(c), Operand::of(b.load(b.variable(a))), "c"));
  Running r(m);
  r.scan();
  EXPECT_EQ(r.read("Main.c.At[1]"), "1");
  EXPECT_EQ(r.read("Main.c.At[3]"), "5");
  EXPECT_EQ(r.read("Main.c.Name"), "'pump'");  // cut to the capacity
}

TEST_F(Generate, AnIndexedElementIsOneInstruction) {
  const auto a = m.variable(main, "a", m.module.types.array(dint, 1, 3));
  const auto x = m.variable(main, "x", dint);
  const auto i = m.variable(main, "i", type(TypeId::kInt));
  auto b = m.body(main);
  b.store(b.variable(x), b.load(b.element_at(b.variable(a), b.load(b.variable(i)))));
  const auto image = bytecode::generate(m.module, m.diagnostics);
  ASSERT_TRUE(image);
  const std::string listing = bytecode::disassemble(*image);
  EXPECT_NE(listing.find("    LOAD_AT i:x, i:a, t"), std::string::npos) << listing;
  const auto body =
      std::find_if(image->pous.begin(), image->pous.end(), [](const auto& p) { return p.name == "Main"; });
  ASSERT_NE(body, image->pous.end());
  EXPECT_EQ(body->code.size(), 7u);  // LOAD_AT, three operands, one step; RETURN
}

TEST_F(Generate, AnEndlessLoopFaultsItsTaskAtItsLineAndTheOtherGoesOn) {
  const auto other = m.pou("Other");
  const auto n = m.variable(other, "n", dint);
  {
    auto b = m.body(main);
    const auto head = b.new_label();
    b.bind(head);
    core::SourceRef at;
    at.line = 17;
    b.set_source(at);
    b.jump(head);
  }
  {
    // 100 turns, far below the budget of one scan.
    auto b = m.body(other);
    const auto head = b.new_label();
    b.bind(head);
    const std::vector<Operand> sum{Operand::of(b.load(b.variable(n))), literal(1)};
    b.store(b.variable(n), *b.call("ADD", sum, {}));
    const std::vector<Operand> rest{Operand::of(b.load(b.variable(n))), literal(100)};
    const std::vector<Operand> more{Operand::of(*b.call("MOD", rest, {})), literal(0)};
    b.jump_if(*b.call("NE", more, {}), head);
  }
  m.task("Good", other, "Other");
  Running r(m, {.loop_budget = 1000});
  for (int scan = 1; scan <= 20; ++scan) {
    const runtime::Fault fault = r.resource->program(0).execute({});
    EXPECT_EQ(fault.kind, runtime::FaultKind::kLoopBudget);
    EXPECT_EQ(runtime::source_of(r.resource->image(), fault.pou, fault.word).line, 17u);
    // 99 turns a scan: the budget is of one scan, so ten scans and more do not use it up.
    EXPECT_FALSE(r.resource->program(1).execute({}));
    EXPECT_EQ(r.read("Other.n"), std::to_string(100 * scan));
  }
}

TEST_F(Generate, ComparisonsBeforeJumpsKeepTheirResult) {
  for (const TypeId id : {TypeId::kInt, TypeId::kDint, TypeId::kReal, TypeId::kLint}) {
    for (const char* name : {"LT", "LE", "GT", "GE", "EQ", "NE"}) {
      for (const bool when : {false, true}) {
        test::ModuleBuilder fresh;
        const auto pou = fresh.pou("Main");
        const auto x = fresh.variable(pou, "x", type(id));
        const auto y = fresh.variable(pou, "y", type(id));
        const auto q = fresh.variable(pou, "q", ir::kBoolType);
        const auto passed = fresh.variable(pou, "passed", dint);
        auto b = fresh.body(pou);
        const std::vector<Operand> args{Operand::of(b.load(b.variable(x))), Operand::of(b.load(b.variable(y)))};
        const auto result = *b.call(name, args, {});
        b.store(b.variable(q), result);
        const auto over = b.new_label();
        when ? b.jump_if(result, over) : b.jump_if_not(result, over);
        const std::vector<Operand> sum{Operand::of(b.load(b.variable(passed))), literal(1)};
        b.store(b.variable(passed), *b.call("ADD", sum, {}));
        b.bind(over);
        fresh.task("T", pou, "Main");
        Running r(fresh);
        int expected = 0;
        for (const auto& [left, right] : {std::pair(1, 2), std::pair(2, 2), std::pair(3, 2)}) {
          r.write("Main.x", std::to_string(left));
          r.write("Main.y", std::to_string(right));
          r.scan();
          const std::string op = name;
          const bool holds = op == "LT"   ? left < right
                             : op == "LE" ? left <= right
                             : op == "GT" ? left > right
                             : op == "GE" ? left >= right
                             : op == "EQ" ? left == right
                                          : left != right;
          expected += holds == when ? 0 : 1;
          EXPECT_EQ(r.read("Main.q"), holds ? "1" : "0") << name << " " << left << " " << right;
          EXPECT_EQ(r.read("Main.passed"), std::to_string(expected)) << name << " " << left << " " << right;
        }
      }
    }
  }
}

TEST_F(Generate, ASubrangeHoldsItsValueWithAnEvent) {
  ir::Type percent;
  percent.kind = ir::TypeKind::kSubrange;
  percent.elementary = TypeId::kInt;
  percent.upper = 100;
  m.module.types.declare("Percent", percent);
  const auto i = m.variable(main, "i", type(TypeId::kInt));
  const auto p = m.variable(main, "p", *m.module.types.find("Percent"));
  const auto ok = m.variable(main, "ok", ir::kBoolType);
  auto b = m.body(main);
  b.clear_event();
  ASSERT_TRUE(b.assign(b.variable(p), Operand::of(b.load(b.variable(i))), "p"));
  b.store(b.variable(ok), b.eno());
  Running r(m);
  r.write("Main.i", "100");
  r.scan();
  EXPECT_EQ(r.read("Main.p"), "100");
  EXPECT_EQ(r.read("Main.ok"), "1");
  r.write("Main.i", "101");
  r.scan();
  EXPECT_EQ(r.read("Main.p"), "100");
  EXPECT_EQ(r.read("Main.ok"), "0");
  EXPECT_EQ(r.resource->program(0).event_total(), 1u);
}

TEST_F(Generate, IndexOutOfBoundsIsAnEventAndNothingElse) {
  const auto a = m.variable(main, "a", m.module.types.array(dint, 1, 3));
  const auto i = m.variable(main, "i", type(TypeId::kUsint));
  const auto ok = m.variable(main, "ok", ir::kBoolType);
  auto b = m.body(main);
  b.clear_event();
  b.store(b.element_at(b.variable(a), b.load(b.variable(i))), *b.convert(literal(9), dint, ""));
  b.store(b.variable(ok), b.eno());
  Running r(m);
  r.write("Main.i", "3");
  r.scan();
  EXPECT_EQ(r.read("Main.a[3]"), "9");
  EXPECT_EQ(r.read("Main.ok"), "1");
  r.write("Main.i", "4");
  r.scan();
  EXPECT_EQ(r.read("Main.ok"), "0");
  EXPECT_EQ(r.resource->program(0).event_total(), 1u);
}

TEST_F(Generate, TempsStartAnewInEveryScan) {
  const auto t = m.variable(main, "t", dint, Role::kTemp);
  m.module.pous[main].variables[t].initial.push_back({{}, number(TypeId::kDint, 40)});
  const auto x = m.variable(main, "x", dint);
  auto b = m.body(main);
  const std::vector<Operand> sum{Operand::of(b.load(b.variable(t))), literal(2)};
  b.store(b.variable(t), *b.call("ADD", sum, {}));
  b.store(b.variable(x), b.load(b.variable(t)));
  Running r(m);
  r.scan();
  r.scan();
  EXPECT_EQ(r.read("Main.x"), "42");
}

TEST_F(Generate, StandardBlocksRunOnTheirPorts) {
  const auto t = m.variable(main, "t", *m.module.types.find("TON"));
  const auto q = m.variable(main, "q", ir::kBoolType);
  auto b = m.body(main);
  const auto ton = b.variable(t);
  ir::Constant second{type(TypeId::kTime), 1'000'000'000, {}};
  b.store(*b.member(ton, "IN"), b.constant_bool(true));
  b.store(*b.member(ton, "PT"), b.constant(second));
  b.run(ton);
  b.store(b.variable(q), b.load(*b.member(ton, "Q")));
  Running r(m);
  r.scan(0, 0);
  EXPECT_EQ(r.read("Main.q"), "0");
  r.scan(0, 1'000'000'000);
  EXPECT_EQ(r.read("Main.q"), "1");
}

TEST_F(Generate, ChainedSumsMayEndInTheirOwnArgument) {
  const auto x = m.variable(main, "x", dint);
  auto b = m.body(main);
  const auto v = Operand::of(b.load(b.variable(x)));
  const std::vector<Operand> sum{literal(1), literal(2), v, v};
  b.store(b.variable(x), *b.call("ADD", sum, {}));
  Running r(m);
  r.write("Main.x", "10");
  r.scan();
  EXPECT_EQ(r.read("Main.x"), "23");
}

TEST_F(Generate, ValueStoredOnOneWayOnlyIsKnownOnTheOther) {
  std::vector<std::uint32_t> in;
  for (int i = 0; i < 7; ++i) in.push_back(m.variable(main, "i" + std::to_string(i), ir::kBoolType));
  const auto skip = m.variable(main, "skip", ir::kBoolType);
  const auto x = m.variable(main, "x", ir::kBoolType);
  const auto y = m.variable(main, "y", ir::kBoolType);
  auto b = m.body(main);
  auto v = b.load(b.variable(in[0]));
  for (int i = 1; i < 7; ++i) v = b.logic(Op::kOr, v, b.load(b.variable(in[static_cast<std::size_t>(i)])));
  const auto label = b.new_label();
  b.jump_if(b.load(b.variable(skip)), label);
  b.store(b.variable(x), v);
  b.bind(label);
  b.store(b.variable(y), v);
  Running r(m);
  r.write("Main.skip", "1");
  r.write("Main.i5", "1");
  r.scan();
  EXPECT_EQ(r.read("Main.x"), "0");
  EXPECT_EQ(r.read("Main.y"), "1");
}

TEST_F(Generate, ListingOfARungAndAComparison) {
  const auto x = m.variable(main, "x", ir::kBoolType);
  const auto y = m.variable(main, "y", ir::kBoolType);
  const auto n = m.variable(main, "n", dint);
  auto b = m.body(main);
  b.store(b.variable(y), b.logic(Op::kAnd, b.load(b.variable(x)), b.not_(b.load(b.variable(y)))));
  const std::vector<Operand> large{Operand::of(b.load(b.variable(n))), literal(3)};
  b.store(b.variable(x), *b.call("GT", large, {}));
  const auto image = bytecode::generate(m.module, m.diagnostics);
  const std::string listing = bytecode::disassemble(*image);
  EXPECT_NE(listing.find("    BOOL_RUN\n"
                         "      | 0x22222222 i:y, i:x, i:y, i:x, i:x, i:x\n"
                         "    GT_I32 i:x, i:n, c:#c0\n"
                         "    RETURN\n"),
            std::string::npos)
      << listing;
}

TEST_F(Generate, SourcesOfRecordsAreTheirElements) {
  const auto x = m.variable(main, "x", ir::kBoolType);
  const auto y = m.variable(main, "y", ir::kBoolType);
  auto b = m.body(main);
  core::SourceRef at;
  at.kind = core::ElementKind::kCoil;
  for (const auto v : {x, y}) {
    at.local_id = v + 10;
    b.set_source(at);
    b.store(b.variable(v), b.not_(b.load(b.variable(v))));
  }
  const auto image = bytecode::generate(m.module, m.diagnostics);
  const auto& debug = image->pous[0].debug;
  ASSERT_EQ(debug.size(), 2u);
  EXPECT_EQ(debug[0].word, 0u);
  EXPECT_EQ(debug[0].at.local_id, 10);
  EXPECT_EQ(debug[1].word, 1 + bytecode::kRecordWords);
  EXPECT_EQ(debug[1].at.local_id, 11);
}

TEST_F(Generate, LongAlternatingChainsNeedNoStack) {
  const auto x = m.variable(main, "x", ir::kBoolType);
  const auto q = m.variable(main, "q", ir::kBoolType);
  auto b = m.body(main);
  auto v = b.load(b.variable(x));
  for (int i = 0; i < 200000; ++i) v = b.not_(b.logic(i % 2 != 0 ? Op::kAnd : Op::kOr, v, b.load(b.variable(x))));
  b.store(b.variable(q), v);
  Running r(m);
  r.scan();
  EXPECT_EQ(r.read("Main.q").size(), 1u);
}

TEST_F(Generate, TooMuchMemoryIsReported) {
  m.variable(main, "a", m.module.types.array(type(TypeId::kLint), 0, 2'000'000'000));
  EXPECT_FALSE(bytecode::generate(m.module, m.diagnostics).has_value());
  EXPECT_EQ(m.diagnostics.all().back().code, core::Code::P5001);
}

TEST_F(Generate, DeepCallsAreReported) {
  std::uint32_t callee = m.pou("F0", ir::PouKind::kFunction);
  for (int i = 1; i < 70; ++i) {
    const auto f = m.pou("F" + std::to_string(i), ir::PouKind::kFunction);
    m.body(f).call_pou(callee, {});
    callee = f;
  }
  m.body(main).call_pou(callee, {});
  EXPECT_FALSE(bytecode::generate(m.module, m.diagnostics).has_value());
  EXPECT_EQ(m.diagnostics.all().back().code, core::Code::P5002);
}

TEST(GenerateTasks, ExportsOfATaskAreOneRange) {
  ModuleBuilder m;
  std::vector<std::uint32_t> g;
  for (int i = 0; i < 8; ++i) g.push_back(m.global("g" + std::to_string(i), ir::kBoolType));
  const auto fast = m.pou("Fast");
  const auto slow = m.pou("Slow");
  auto bf = m.body(fast);
  auto bs = m.body(slow);
  for (const int i : {0, 2, 4}) bf.store(bf.global(g[static_cast<std::size_t>(i)]), bf.load(bf.global(g[7])));
  for (const int i : {1, 3, 4}) bs.store(bs.global(g[static_cast<std::size_t>(i)]), bs.load(bs.global(g[0])));
  m.task("A", fast, "Fast");
  m.task("B", slow, "Slow");
  const auto image = bytecode::generate(m.module, m.diagnostics);
  ASSERT_TRUE(image.has_value());
  using bytecode::Opcode;
  const auto count = [&](std::uint32_t task, Opcode opcode) {
    // Task bodies hold only instructions of two operands, and RETURN.
    const auto& code = image->pous[image->tasks[task].body].code;
    int n = 0;
    for (std::size_t at = 0; at + 1 < code.size(); at += 3) n += static_cast<Opcode>(code[at]) == opcode ? 1 : 0;
    return n;
  };
  for (const std::uint32_t task : {0u, 1u}) {
    EXPECT_EQ(count(task, Opcode::kWriteN), 1);
    EXPECT_EQ(count(task, Opcode::kWriteChangedN), 1);
  }
  const auto& fields = image->types[image->global_type].fields;
  for (std::size_t f = 0; f < fields.size(); ++f) {
    const std::uint32_t want = fields[f].name == "g4" ? 2 : fields[f].name >= "g5" ? 0 : 1;
    EXPECT_EQ(image->globals[f].writers, want) << fields[f].name;
  }
  Running r(m);
  r.write("g7", "1");
  r.scan(0);
  r.scan(1);
  EXPECT_EQ(r.read("g3"), "1");
}

TEST(GenerateTasks, UnreachedPousAreLeftOut) {
  ModuleBuilder m;
  m.pou("Unused", ir::PouKind::kFunctionBlock);
  m.task("T", m.pou("Main"), "Main");
  const auto image = bytecode::generate(m.module, m.diagnostics);
  ASSERT_EQ(image->pous.size(), 2u);
  EXPECT_EQ(image->pous[0].name, "Main");
}

}  // namespace
}  // namespace plc
