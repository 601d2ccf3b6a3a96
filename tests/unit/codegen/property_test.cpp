// Random programs: what the generated code leaves in memory equals what the evaluator of tests/support says.
#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <string>
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

/// Appends random instructions to a body. Values made behind a forward jump are forgotten at its label.
class RandomBody {
 public:
  RandomBody(ModuleBuilder& m, std::uint32_t pou, std::mt19937& random)
      : m_(m), b_(m.body(pou)), pou_(pou), random_(random) {}

  void add_bool(ir::PlaceId p) { bool_places_.push_back(p); }
  void add_int(ir::PlaceId p) { int_places_.push_back(p); }
  void add_in_out(std::uint32_t variable) { in_outs_.push_back(variable); }
  void add_bool_array(ir::PlaceId p) { arrays_.push_back(p); }
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
    const auto element = b_.element_at(array, int_value());
    if (chance(2)) {
      bools_.push_back(b_.load(element));
    } else {
      b_.store(element, bool_value());
    }
  }

  void step() {
    switch (random_() % 16) {
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

  ModuleBuilder& m_;
  ir::Builder b_;
  std::uint32_t pou_;
  std::mt19937& random_;
  std::vector<ir::PlaceId> bool_places_, int_places_, arrays_, blocks_;
  std::vector<std::uint32_t> in_outs_;
  std::vector<ir::ValueId> bools_, ints_;
  std::vector<Open> open_;
};

struct Options {
  int instructions = 60;
  bool block = false;
  bool loop = false;
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

TEST(Property, ShortStraightBodies) { all_agree({12, false, false}); }
TEST(Property, LongStraightBodies) { all_agree({120, false, false}); }
TEST(Property, BodiesWithBlocksAndInOuts) { all_agree({60, true, false}); }
TEST(Property, BodiesWithLoops) { all_agree({40, false, true}); }
TEST(Property, BodiesWithEverything) { all_agree({80, true, true}); }

}  // namespace
}  // namespace plc
