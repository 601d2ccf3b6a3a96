// Random programs: what the generated code leaves in memory equals what the evaluator of tests/support says.
#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "bytecode/codegen/generate.h"
#include "bytecode/image.h"
#include "ir/check.h"
#include "runtime/access.h"
#include "runtime/resource.h"
#include "tests/support/ir_evaluator.h"
#include "tests/support/module_builder.h"

namespace plc {
namespace {

using core::TypeId;
using ir::Op;
using test::ModuleBuilder;

/// Appends random instructions to a body. Values made after a forward jump are forgotten at its label.
class RandomBody {
 public:
  RandomBody(ModuleBuilder& m, std::uint32_t pou, std::mt19937& random) : b_(m.body(pou)), random_(random) {}

  void add_bool(ir::PlaceId p) { bool_places_.push_back(p); }
  void add_int(ir::PlaceId p) { int_places_.push_back(p); }
  void add_in_out(std::uint32_t variable) { in_outs_.push_back(variable); }
  void add_bool_array(ir::PlaceId p) { arrays_.push_back(p); }
  /// ARRAY OF STRUCT N : DINT; ROW : ARRAY OF DINT.
  void add_table(ir::PlaceId p) { tables_.push_back(p); }
  /// A DINT that only a loop counts.
  void add_counter(ir::PlaceId p) { counters_.push_back(p); }
  void set_subrange(ir::TypeRef t) { subrange_ = t; }
  /// An instance of function block `fb` with in-out IO, input I and output Q.
  void add_block(ir::PlaceId p) { blocks_.push_back(p); }
  ir::Builder& builder() { return b_; }

  void fill(int instructions) {
    for (int i = 0; i < instructions; ++i) step();
    while (!open_.empty()) close_label();
  }

  /// A loop of `count` turns around random instructions.
  void loop(ir::PlaceId counter, int count, int instructions) {
    while (!open_.empty()) close_label();
    b_.store(counter, *b_.convert(test::literal(0), ir::ref_of(TypeId::kDint), "counter"));
    const auto top = b_.new_label();
    b_.bind(top);
    fill(instructions);
    const std::vector<ir::Operand> sum{ir::Operand::of(b_.load(counter)), test::literal(1)};
    b_.store(counter, *b_.call("ADD", sum, {}));
    const std::vector<ir::Operand> less{ir::Operand::of(b_.load(counter)), test::literal(count)};
    const auto again = *b_.call("LT", less, {});
    if (chance(2)) {
      b_.jump_if(again, top);
    } else {
      b_.jump_if_not(b_.not_(again), top);
    }
  }

  /// WHILE counter < n DO .. EXIT .. CONTINUE .. END_WHILE, as ST has it. What is made inside is forgotten after it.
  void while_loop(int instructions) {
    if (loops_ >= counters_.size()) return;
    const ir::PlaceId counter = counters_[loops_++];
    const std::vector<Open> outside = std::exchange(open_, {});
    const std::size_t bools = bools_.size(), ints = ints_.size();
    const auto dint = ir::ref_of(TypeId::kDint);
    b_.store(counter, *b_.convert(test::literal(0), dint, "counter"));
    const auto head = b_.new_label(), next = b_.new_label(), end = b_.new_label();
    b_.bind(head);
    const std::vector<ir::Operand> less{ir::Operand::of(b_.load(counter)),
                                        test::literal(static_cast<std::int64_t>(random_() % 4))};
    b_.jump_if_not(*b_.call("LT", less, {}), end);
    const std::size_t inner_bools = bools_.size(), inner_ints = ints_.size();
    fill(instructions / 2);
    if (chance(2)) b_.jump_if(bool_value(), chance(2) ? end : next);
    if (chance(2)) while_loop(instructions / 2);
    fill(instructions / 2);
    bools_.resize(inner_bools);
    ints_.resize(inner_ints);
    b_.bind(next);
    const std::vector<ir::Operand> sum{ir::Operand::of(b_.load(counter)), test::literal(1)};
    b_.store(counter, *b_.call("ADD", sum, {}));
    b_.jump(head);
    b_.bind(end);
    bools_.resize(bools);
    ints_.resize(ints);
    open_ = outside;
    --loops_;
  }

 private:
  struct Open {
    ir::LabelId label;
    std::size_t bools, ints;
  };
  bool chance(unsigned n) { return random_() % n == 0; }
  template <class T>
  const T& any(const std::vector<T>& from) {
    // Recent values more often than old ones, so that cones grow; now and then one from far away.
    const std::size_t span = chance(5) ? from.size() : std::min<std::size_t>(from.size(), 6);
    return from[from.size() - 1 - random_() % span];
  }
  ir::PlaceId bool_place() {
    if (!in_outs_.empty() && chance(6)) return b_.variable(any(in_outs_));
    return bool_places_[random_() % bool_places_.size()];
  }
  ir::PlaceId int_place() { return int_places_[random_() % int_places_.size()]; }
  ir::ValueId bool_value() {
    if (bools_.empty() || chance(3)) bools_.push_back(b_.load(bool_place()));
    return any(bools_);
  }
  ir::ValueId int_value() {
    if (ints_.empty() || chance(3)) ints_.push_back(b_.load(int_place()));
    return any(ints_);
  }

  /// A tree of contacts: what a rung with parallel branches is.
  ir::ValueId nest(int depth) {
    if (depth == 0) return chance(8) ? b_.not_(b_.load(bool_place())) : b_.load(bool_place());
    const Op op = chance(8) ? Op::kXor : depth % 2 != 0 ? Op::kAnd : Op::kOr;
    ir::ValueId v = nest(depth - 1);
    for (unsigned n = random_() % 4; n > 0; --n) v = b_.logic(op, v, nest(depth - 1));
    return chance(6) ? b_.not_(v) : v;
  }

  void close_label() {
    b_.bind(open_.back().label);
    bools_.resize(open_.back().bools);
    ints_.resize(open_.back().ints);
    open_.pop_back();
  }

  void arithmetic() {
    static constexpr const char* kNames[] = {"ADD", "SUB", "MUL", "DIV", "MOD", "MAX", "LIMIT"};
    static constexpr const char* kCompare[] = {"GT", "LE", "EQ", "NE"};
    std::vector<ir::Operand> args{ir::Operand::of(int_value()), ir::Operand::of(int_value())};
    if (chance(4)) args[1] = test::literal(static_cast<std::int64_t>(random_() % 5));
    if (chance(3)) {
      bools_.push_back(*b_.call(kCompare[random_() % 4], args, {}));
      if (chance(2)) b_.store(bool_place(), bools_.back());
      return;
    }
    const std::string name = kNames[random_() % 7];
    if (name == "LIMIT" || (name == "ADD" && chance(2))) args.push_back(ir::Operand::of(int_value()));
    ints_.push_back(*b_.call(name, args, {}));
    if (chance(2)) b_.store(int_place(), ints_.back());
  }

  void call_block() {
    const ir::PlaceId fb = blocks_[random_() % blocks_.size()];
    b_.store(*b_.member(fb, "IO"), b_.make_ref(bool_places_[random_() % bool_places_.size()]));
    b_.store(*b_.member(fb, "I"), bool_value());
    b_.run(fb);
    if (chance(2)) bools_.push_back(b_.load(*b_.member(fb, "Q")));
  }

  void indexed() {
    const auto array = arrays_[random_() % arrays_.size()];
    const auto element = b_.element_at(array, index());
    if (chance(2)) {
      bools_.push_back(b_.load(element));
      b_.store(bool_place(), bools_.back());  // the event of a value that nobody uses is not promised
    } else {
      b_.store(element, bool_value());
    }
  }

  /// An index of one type or another, often inside of small bounds.
  ir::ValueId index() {
    const auto value = int_value();
    if (chance(3)) return b_.extract(value, ir::ref_of(chance(2) ? TypeId::kByte : TypeId::kWord), 0);
    return chance(3) ? b_.range(value, subrange_) : value;
  }

  void table_access() {
    const auto table = tables_[random_() % tables_.size()];
    const auto line =
        chance(4) ? b_.element(table, static_cast<std::uint32_t>(random_() % 3)) : b_.element_at(table, index());
    const auto row = *b_.member(line, "ROW");
    const auto number = chance(3)   ? *b_.member(line, "N")
                        : chance(3) ? b_.element(row, static_cast<std::uint32_t>(random_() % 2))
                                    : b_.element_at(row, index());
    switch (random_() % 5) {
      case 0:
      case 1:
        ints_.push_back(b_.load(number));
        b_.store(int_place(), ints_.back());
        return;
      case 2: {
        const std::vector<ir::Operand> sum{ir::Operand::of(b_.load(number)), ir::Operand::of(int_value())};
        b_.store(number, *b_.call("ADD", sum, {}));
        return;
      }
      case 3:
        b_.store(b_.element_at(table, index()), b_.load(line));
        return;
      default:
        b_.store(number, int_value());
    }
  }

  void parts() {
    const auto bit = static_cast<unsigned>(random_() % 32);
    switch (random_() % 3) {
      case 0:
        bools_.push_back(b_.extract(int_value(), ir::kBoolType, bit));
        return;
      case 1: {
        const auto place = int_place();
        b_.store(place, b_.insert(b_.load(place), bool_value(), bit));
        return;
      }
      default:
        ints_.push_back(b_.range(int_value(), subrange_));
        b_.store(int_place(), ints_.back());
    }
  }

  void step() {
    switch (random_() % 20) {
      case 16:
      case 17:
        if (!tables_.empty()) table_access();
        break;
      case 18:
        if (subrange_.valid()) parts();
        break;
      case 19:
        if (chance(3)) while_loop(8);
        break;
      case 0:
      case 1:
      case 2: {
        const Op ops[] = {Op::kAnd, Op::kOr, Op::kXor};
        const auto left = bool_value();
        bools_.push_back(b_.logic(ops[random_() % 3], left, bool_value()));
        break;
      }
      case 3:
        bools_.push_back(b_.not_(bool_value()));
        break;
      case 4:
      case 5:
        b_.store(bool_place(), bool_value());
        break;
      case 6:
        bools_.push_back(nest(static_cast<int>(random_() % 4)));
        if (chance(2)) b_.store(bool_place(), bools_.back());
        break;
      case 7: {
        const auto q = bool_place();  // a set or reset coil
        const auto flow = bool_value();
        if (chance(2)) {
          b_.store(q, b_.logic(Op::kOr, b_.load(q), flow));
        } else {
          b_.store(q, b_.logic(Op::kAnd, b_.load(q), b_.not_(flow)));
        }
        break;
      }
      case 8: {
        const auto x = bool_place();  // an edge
        const auto memory = bool_place();
        const auto now = b_.load(x);
        bools_.push_back(b_.logic(Op::kAnd, now, b_.not_(b_.load(memory))));
        b_.store(memory, now);
        break;
      }
      case 9:
      case 10:
        arithmetic();
        break;
      case 11:
        b_.store(int_place(), int_value());
        break;
      case 12:
        if (open_.size() < 3) {
          const auto label = b_.new_label();
          if (chance(2)) {
            b_.jump_if(bool_value(), label);
          } else {
            b_.jump_if_not(bool_value(), label);
          }
          open_.push_back({label, bools_.size(), ints_.size()});
        }
        break;
      case 13:
        if (!open_.empty()) close_label();
        break;
      case 14:
        if (!blocks_.empty()) call_block();
        break;
      default:
        if (chance(6)) {
          bools_.push_back(b_.constant_bool(chance(2)));
        } else if (!arrays_.empty()) {
          indexed();
        }
    }
  }

  ir::Builder b_;
  std::mt19937& random_;
  std::vector<ir::PlaceId> bool_places_, int_places_, arrays_, tables_, counters_, blocks_;
  ir::TypeRef subrange_{};
  std::size_t loops_ = 0;  ///< open ones
  std::vector<std::uint32_t> in_outs_;
  std::vector<ir::ValueId> bools_, ints_;
  std::vector<Open> open_;
};

struct Options {
  int instructions = 60;
  bool block = false;
  bool loop = false;
  bool table = false;  ///< arrays of structures, parts of words, subranges, nested loops with EXIT and CONTINUE
};

struct Case {
  ModuleBuilder m;
  std::vector<std::string> bools, ints;  ///< paths of leaves to compare

  Case(std::uint32_t seed, const Options& options) {
    std::mt19937 random(seed);
    const auto dint = ir::ref_of(TypeId::kDint);
    std::uint32_t fb = 0;
    if (options.block) {
      fb = m.pou("Fb", ir::PouKind::kFunctionBlock);
      const auto io = m.variable(fb, "IO", ir::kBoolType, ir::Role::kInOut);
      const auto in = m.variable(fb, "I", ir::kBoolType, ir::Role::kInput);
      const auto q = m.variable(fb, "Q", ir::kBoolType, ir::Role::kOutput);
      const auto s = m.variable(fb, "S", dint);
      const auto g = m.global("fb_global", ir::kBoolType);
      bools.push_back("fb_global");
      RandomBody body(m, fb, random);
      body.add_in_out(io);
      body.add_bool(body.builder().variable(in));
      body.add_bool(body.builder().variable(q));
      body.add_bool(body.builder().global(g));
      body.add_int(body.builder().variable(s));
      body.fill(12);
    }
    const auto main = m.pou("Main");
    std::vector<std::uint32_t> vars, globals;
    for (int i = 0; i < 5; ++i) {
      vars.push_back(m.variable(main, "v" + std::to_string(i), ir::kBoolType));
      globals.push_back(m.global("g" + std::to_string(i), ir::kBoolType));
      bools.push_back("Main.v" + std::to_string(i));
      bools.push_back("g" + std::to_string(i));
    }
    std::vector<std::uint32_t> numbers;
    for (int i = 0; i < 4; ++i) {
      numbers.push_back(m.variable(main, "n" + std::to_string(i), dint));
      ints.push_back("Main.n" + std::to_string(i));
    }
    const auto array = m.variable(main, "a", m.module.types.array(ir::kBoolType, -1, 2));
    for (int i = -1; i <= 2; ++i) bools.push_back("Main.a[" + std::to_string(i) + "]");
    const auto counter = m.variable(main, "count", dint);
    ir::Type limits;
    limits.kind = ir::TypeKind::kSubrange;
    limits.elementary = TypeId::kDint;
    limits.lower = -1;
    limits.upper = 3;
    m.module.types.declare("Small", limits);
    const auto subrange = *m.module.types.find("Small");
    std::vector<std::uint32_t> counters, tables;
    std::uint32_t shared = 0;
    if (options.table) {
      ir::Type line;
      line.kind = ir::TypeKind::kStruct;
      line.fields = {{"N", dint}, {"ROW", m.module.types.array(dint, 1, 2)}};
      m.module.types.declare("Line", line);
      const auto table = m.module.types.array(*m.module.types.find("Line"), 0, 2);
      for (int i = 0; i < 3; ++i) counters.push_back(m.variable(main, "c" + std::to_string(i), dint));
      for (const char* name : {"t1", "t2"}) tables.push_back(m.variable(main, name, table));
      shared = m.global("t3", table);
      for (const char* name : {"Main.t1", "Main.t2", "t3"}) {
        for (int i = 0; i < 3; ++i) {
          for (const char* leaf : {"].N", "].ROW[1]", "].ROW[2]"}) {
            ints.push_back(std::string(name) + "[" + std::to_string(i) + leaf);
          }
        }
      }
    }
    std::vector<std::uint32_t> instances;
    if (options.block) {
      for (const char* name : {"f1", "f2"}) {
        instances.push_back(m.variable(main, name, m.module.pous[fb].instance_type));
        for (const char* leaf : {".I", ".Q"}) bools.push_back("Main." + std::string(name) + leaf);
        ints.push_back("Main." + std::string(name) + ".S");
      }
    }
    RandomBody body(m, main, random);
    for (const auto v : vars) body.add_bool(body.builder().variable(v));
    for (const auto g : globals) body.add_bool(body.builder().global(g));
    for (const auto n : numbers) body.add_int(body.builder().variable(n));
    body.add_bool_array(body.builder().variable(array));
    body.add_bool(body.builder().element(body.builder().variable(array), 1));
    body.set_subrange(subrange);
    if (options.table) {
      for (const auto c : counters) body.add_counter(body.builder().variable(c));
      for (const auto t : tables) body.add_table(body.builder().variable(t));
      body.add_table(body.builder().global(shared));
      body.add_int(*body.builder().member(body.builder().element(body.builder().variable(tables[0]), 1), "N"));
    }
    for (const auto i : instances) {
      body.add_block(body.builder().variable(i));
      body.add_bool(*body.builder().member(body.builder().variable(i), "Q"));
    }
    body.fill(options.instructions);
    if (options.loop) {
      body.loop(body.builder().variable(counter), 3, options.instructions / 2);
      body.fill(options.instructions / 3);
    }
    m.task("T", main, "Main");
  }
};

/// Nothing when both agree after three scans from random memory; else what differs.
std::string difference(std::uint32_t seed, const Options& options) {
  Case c(seed, options);
  if (!ir::check(c.m.module, c.m.diagnostics)) return "check: " + c.m.diagnostics.all().front().message;
  auto image = bytecode::generate(c.m.module, c.m.diagnostics);
  if (!image) return "generate: " + c.m.diagnostics.all().front().message;
  const std::string listing = bytecode::disassemble(*image);
  core::Diagnostics verdict;
  auto verified = bytecode::verify(std::move(*image), verdict);
  if (!verified) return "verify: " + verdict.all().front().message + "\n" + ir::print(c.m.module) + listing;
  auto resource = runtime::Resource::load(std::move(*verified));
  if (!resource) return "link: " + resource.error().message;
  runtime::Access access(**resource);
  test::IrEvaluator evaluator(c.m.module);

  std::mt19937 random(seed + 1);
  const auto set = [&](const std::string& path, std::int64_t value) {
    const auto place = access.find(path);
    if (!place) return false;
    if (access.write(*place, std::to_string(value))) return false;
    evaluator.memory[path].bits = static_cast<std::uint32_t>(value);
    return true;
  };
  for (const std::string& path : c.bools) {
    if (!set(path, static_cast<std::int64_t>(random() % 2))) return "cannot write " + path;
  }
  for (const std::string& path : c.ints) {
    if (!set(path, static_cast<std::int64_t>(random() % 7) - 2)) return "cannot write " + path;
  }
  for (int scan = 0; scan < 3; ++scan) {
    if ((*resource)->program(0).execute({})) return "fault";
    if (!evaluator.run(c.m.module.tasks[0].programs[0].pou, "Main")) return "evaluator gave up";
    const std::uint64_t events = (*resource)->program(0).event_total();
    if (events != evaluator.events) {
      return "scan " + std::to_string(scan) + ": " + std::to_string(events) + " events, not " +
             std::to_string(evaluator.events) + "\n" + ir::print(c.m.module) + listing;
    }
    for (const auto* paths : {&c.bools, &c.ints}) {
      for (const std::string& path : *paths) {
        const auto got = access.read_integer(*access.find(path));
        const auto want = paths == &c.bools ? static_cast<std::int64_t>(evaluator.memory[path].bits)
                                            : static_cast<std::int32_t>(evaluator.memory[path].bits);
        if (got != want) {
          return "scan " + std::to_string(scan) + ": " + path + " is " + std::to_string(got.value_or(-1)) + ", not " +
                 std::to_string(want) + "\n" + ir::print(c.m.module) + listing;
        }
      }
    }
  }
  return {};
}

int rounds() {
  const char* wanted = std::getenv("PLC_PROPERTY_ROUNDS");
  return wanted == nullptr ? 150 : std::atoi(wanted);
}

void all_agree(const Options& options) {
  for (int seed = 1; seed <= rounds(); ++seed) {
    const std::string found = difference(static_cast<std::uint32_t>(seed), options);
    ASSERT_EQ(found, "") << "seed " << seed;
  }
}

TEST(Property, ShortStraightBodies) { all_agree({.instructions = 12}); }
TEST(Property, LongStraightBodies) { all_agree({.instructions = 120}); }
TEST(Property, BodiesWithBlocksAndInOuts) { all_agree({.instructions = 60, .block = true}); }
TEST(Property, BodiesWithLoops) { all_agree({.instructions = 40, .loop = true}); }
TEST(Property, BodiesWithArraysAndNestedLoops) { all_agree({.instructions = 40, .table = true}); }
TEST(Property, BodiesWithEverything) { all_agree({.instructions = 80, .block = true, .loop = true, .table = true}); }

}  // namespace
}  // namespace plc
