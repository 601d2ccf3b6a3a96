// Integer and bit rows against 128-bit arithmetic, for every overload; reals against IEEE 754 rules.
#include "stdlib/arithmetic.h"

#include <algorithm>
#include <functional>
#include <limits>

#include "tests/unit/stdlib/values.h"

namespace plc::test {
namespace {

using stdlib::Event;
using stdlib::Overload;
__extension__ using Wide = __int128;
__extension__ using UnsignedWide = unsigned __int128;

bool is_integer(TypeId id) { return core::in_category(id, core::kAnyInt | core::kAnyBit | core::kAnyDuration); }
unsigned width(TypeId id) { return id == TypeId::kBool ? 1 : 8 * core::rep_bytes(core::rep_of(id)); }
bool is_signed(TypeId id) { return core::in_category(id, core::kAnySigned | core::kAnyDuration); }

/// The value of the low bits of `bits` as type `id`.
Wide value_of(TypeId id, std::uint64_t bits) {
  const unsigned w = width(id);
  const Wide raw = static_cast<Wide>(w == 64 ? bits : bits & ((std::uint64_t{1} << w) - 1));
  return is_signed(id) && (raw >> (w - 1)) != 0 ? raw - (static_cast<Wide>(1) << w) : raw;
}
std::uint64_t wrapped(TypeId id, Wide value) {
  const unsigned w = width(id);
  const auto bits = static_cast<std::uint64_t>(value);
  return w == 64 ? bits : bits & ((std::uint64_t{1} << w) - 1);
}
std::vector<std::uint64_t> samples(TypeId id) {
  const unsigned w = width(id);
  if (w == 1) return {0, 1};
  const std::uint64_t top = std::uint64_t{1} << (w - 1);
  std::vector<std::uint64_t> out = {0,
                                    1,
                                    2,
                                    3,
                                    7,
                                    10,
                                    100,
                                    top - 1,
                                    top,
                                    top + 1,
                                    0 - std::uint64_t{1},
                                    0 - std::uint64_t{2},
                                    0 - std::uint64_t{7},
                                    0x5555555555555555ull,
                                    0xaaaaaaaaaaaaaaaaull,
                                    0x123456789abcdef0ull};
  for (std::uint64_t& bits : out) bits = wrapped(id, static_cast<Wide>(bits));
  return out;
}

struct Outcome {
  Wide value;
  Event event = Event::kNone;
};
using Oracle = std::function<Outcome(TypeId, Wide, Wide)>;

void sweep_binary(std::string_view name, const Oracle& oracle) {
  std::size_t swept = 0;
  for (const Overload& o : stdlib::overloads_named(name)) {
    if (o.spec->u_categories != 0 || o.spec->t_categories == 0 || !is_integer(o.t)) continue;
    ++swept;
    for (const std::uint64_t a : samples(o.t)) {
      for (const std::uint64_t b : samples(o.t)) {
        std::vector<Value> args(2, Value(o.t));
        args[0].set_bits(a);
        args[1].set_bits(b);
        Value result(o.result_type());
        const Event event = call(o, result, args);
        const Outcome want = oracle(o.t, value_of(o.t, a), value_of(o.t, b));
        ASSERT_EQ(result.bits(), wrapped(o.result_type(), want.value)) << stdlib::key_of(o) << " " << a << " " << b;
        ASSERT_EQ(event, want.event) << stdlib::key_of(o) << " " << a << " " << b;
      }
    }
  }
  EXPECT_GT(swept, 4u) << name;
}

TEST(Arithmetic, IntegersWrapInEveryWidth) {
  sweep_binary("ADD", [](TypeId, Wide a, Wide b) { return Outcome{a + b}; });
  sweep_binary("SUB", [](TypeId, Wide a, Wide b) { return Outcome{a - b}; });
  sweep_binary("MUL", [](TypeId, Wide a, Wide b) {
    return Outcome{static_cast<Wide>(static_cast<UnsignedWide>(a) * static_cast<UnsignedWide>(b))};
  });
}
TEST(Arithmetic, DivisionTruncatesAndZeroIsAnEvent) {
  sweep_binary("DIV", [](TypeId, Wide a, Wide b) {
    return b == 0 ? Outcome{0, Event::kDivideByZero} : Outcome{a / b};
  });
  sweep_binary("MOD", [](TypeId, Wide a, Wide b) { return Outcome{b == 0 ? 0 : a % b}; });
}
TEST(Arithmetic, ComparesAndSelectsByValue) {
  sweep_binary("GT", [](TypeId, Wide a, Wide b) { return Outcome{a > b}; });
  sweep_binary("GE", [](TypeId, Wide a, Wide b) { return Outcome{a >= b}; });
  sweep_binary("EQ", [](TypeId, Wide a, Wide b) { return Outcome{a == b}; });
  sweep_binary("LE", [](TypeId, Wide a, Wide b) { return Outcome{a <= b}; });
  sweep_binary("LT", [](TypeId, Wide a, Wide b) { return Outcome{a < b}; });
  sweep_binary("NE", [](TypeId, Wide a, Wide b) { return Outcome{a != b}; });
  sweep_binary("MAX", [](TypeId, Wide a, Wide b) { return Outcome{std::max(a, b)}; });
  sweep_binary("MIN", [](TypeId, Wide a, Wide b) { return Outcome{std::min(a, b)}; });
}
TEST(Arithmetic, CombinesBits) {
  sweep_binary("AND", [](TypeId, Wide a, Wide b) { return Outcome{a & b}; });
  sweep_binary("OR", [](TypeId, Wide a, Wide b) { return Outcome{a | b}; });
  sweep_binary("XOR", [](TypeId, Wide a, Wide b) { return Outcome{a ^ b}; });
}

TEST(Arithmetic, UnaryIntegersWrap) {
  const auto sweep = [](std::string_view name, const std::function<Wide(TypeId, Wide)>& oracle) {
    for (const Overload& o : stdlib::overloads_named(name)) {
      if (!is_integer(o.t)) continue;
      for (const std::uint64_t a : samples(o.t)) {
        std::vector<Value> args(1, Value(o.t));
        args[0].set_bits(a);
        Value result(o.t);
        EXPECT_EQ(call(o, result, args), Event::kNone);
        EXPECT_EQ(result.bits(), wrapped(o.t, oracle(o.t, value_of(o.t, a)))) << stdlib::key_of(o) << " " << a;
      }
    }
  };
  sweep("NEG", [](TypeId, Wide a) { return -a; });
  sweep("ABS", [](TypeId, Wide a) { return a < 0 ? -a : a; });
  sweep("NOT", [](TypeId, Wide a) { return ~a; });
  sweep("MOVE", [](TypeId, Wide a) { return a; });
}

TEST(Arithmetic, ShiftsAndRotationsForEveryWidthAndCountType) {
  const auto rotated = [](Wide v, unsigned w, unsigned n) {
    n %= w;
    return n == 0 ? v : (v << n) | (v >> (w - n));
  };
  for (const std::string_view name : {"SHL", "SHR", "ROL", "ROR"}) {
    for (const Overload& o : stdlib::overloads_named(name)) {
      const unsigned w = width(o.t);
      for (const std::uint64_t bits : samples(o.t)) {
        for (const std::int64_t n : {std::int64_t{0}, std::int64_t{1}, std::int64_t{3}, std::int64_t{w} - 1,
                                     std::int64_t{w}, std::int64_t{w} + 1, std::int64_t{127}, std::int64_t{-1}}) {
          if (n < 0 && !is_signed(o.u)) continue;
          std::vector<Value> args;
          args.emplace_back(o.t).set_bits(bits);
          args.emplace_back(o.u).set_bits(static_cast<std::uint64_t>(n));
          Value result(o.t);
          const Event event = call(o, result, args);
          const auto v = static_cast<Wide>(bits);
          const auto count = static_cast<unsigned>(std::max<std::int64_t>(n, 0));
          const Wide want = name == "SHL"   ? (count >= w ? 0 : v << count)
                            : name == "SHR" ? (count >= w ? 0 : v >> count)
                            : name == "ROL" ? rotated(v, w, count)
                                            : rotated(v, w, w - count % w);
          ASSERT_EQ(result.bits(), wrapped(o.t, want)) << stdlib::key_of(o) << " " << bits << " by " << n;
          ASSERT_EQ(event, n < 0 ? Event::kOutOfRange : Event::kNone);
        }
      }
    }
  }
}

TEST(Arithmetic, ExtensibleFunctionsTakeAllInputs) {
  const auto run = [](const char* key, const std::vector<std::string>& literals) {
    const Overload& o = overload(key);
    std::vector<Value> args;
    for (std::size_t i = 0; i < literals.size(); ++i) args.emplace_back(o.param_type(i), literals[i]);
    Value result(o.result_type());
    call(o, result, args);
    return result.bits();
  };
  EXPECT_EQ(run("ADD:INT", {"1", "2", "3", "4", "5"}), 15u);
  EXPECT_EQ(run("MUL:USINT", {"16", "16", "3"}), 0u);
  EXPECT_EQ(run("XOR:BOOL", {"TRUE", "TRUE", "TRUE", "FALSE"}), 1u);
  EXPECT_EQ(run("LT:DINT", {"1", "2", "3", "3"}), 0u);
  EXPECT_EQ(run("LE:DINT", {"1", "2", "3", "3"}), 1u);
  EXPECT_EQ(run("EQ:DINT", {"1", "1", "2"}), 0u);
  EXPECT_EQ(run("MAX:DINT", {"1", "7", "2", "6"}), 7u);
  EXPECT_EQ(run("MUX:DINT,LINT", {"3", "10", "11", "12", "13", "14"}), 13u);
  std::vector<std::string> many(stdlib::kMaxArguments, "1");
  EXPECT_EQ(run("ADD:DINT", many), stdlib::kMaxArguments);
}

TEST(Arithmetic, MuxOutsideTakesTheNearestInputWithAnEvent) {
  for (const Overload& o : stdlib::overloads_named("MUX")) {
    if (o.t != TypeId::kInt) continue;
    for (const std::int64_t k : {0, 1, 2, 3, 127, -1, -128}) {
      if (k < 0 && !is_signed(o.u)) continue;
      std::vector<Value> args;
      args.emplace_back(o.u).set_bits(static_cast<std::uint64_t>(k));
      for (const std::uint64_t v : {10u, 20u, 30u}) args.emplace_back(o.t).set_bits(v);
      Value result(o.t);
      const Event event = call(o, result, args);
      EXPECT_EQ(result.bits(), k <= 0 ? 10u : k == 1 ? 20u : 30u) << stdlib::key_of(o) << " " << k;
      EXPECT_EQ(event, k >= 0 && k < 3 ? Event::kNone : Event::kBadIndex);
    }
  }
}

// ---- reals ------------------------------------------------------------------------------------------------------

constexpr std::uint32_t kNan32 = 0x7fc00000u;
constexpr std::uint64_t kNan64 = 0x7ff8000000000000ull;

TEST(Reals, EveryNanResultIsTheCanonicalOne) {
  const float bad32 = std::bit_cast<float>(0xffc12345u);
  const double bad64 = std::bit_cast<double>(0xfff8000000012345ull);
  for (const Overload& o : stdlib::overloads()) {
    if (o.result_type() != TypeId::kReal && o.result_type() != TypeId::kLreal) continue;
    // Moves hand on what tables hold, and those hold no other NaN.
    if (o.name == "MOVE" || o.name == "SEL" || o.name == "MUX" || o.name == "MAX" || o.name == "MIN" ||
        o.name == "LIMIT" || o.name.starts_with("TO_")) {
      continue;
    }
    if (o.name.ends_with("_ENDIAN")) continue;  // bytes to send, or as they came
    std::vector<Value> args;
    bool has_real = false;
    for (std::size_t i = 0; i < o.spec->param_count; ++i) {
      Value& arg = args.emplace_back(o.param_type(i));
      if (arg.type == TypeId::kReal) arg.set(bad32);
      if (arg.type == TypeId::kLreal) arg.set(bad64);
      has_real |= arg.type == TypeId::kReal || arg.type == TypeId::kLreal;
    }
    if (!has_real) continue;
    Value result(o.result_type());
    call(o, result, args);
    // A power with exponent 0 is 1 even of a NaN (IEEE 754, pown).
    if (o.name == "EXPT" && !core::in_category(o.u, core::kAnyReal)) {
      EXPECT_TRUE(result.same_as(Value(result.type, "1.0"))) << stdlib::key_of(o);
      continue;
    }
    EXPECT_EQ(result.bits(), result.type == TypeId::kReal ? kNan32 : kNan64) << stdlib::key_of(o);
  }
}

TEST(Reals, NewNansAreCanonical) {
  Event event = Event::kNone;
  EXPECT_EQ(std::bit_cast<std::uint32_t>(stdlib::div(0.0f, 0.0f, event)), kNan32);
  EXPECT_EQ(std::bit_cast<std::uint64_t>(stdlib::sub(HUGE_VAL, HUGE_VAL)), kNan64);
  EXPECT_EQ(std::bit_cast<std::uint64_t>(stdlib::mul(HUGE_VAL, 0.0)), kNan64);
  EXPECT_EQ(event, Event::kNone);
  Value result(TypeId::kReal);
  EXPECT_EQ(call(overload("LN:REAL"), result, {Value(TypeId::kReal, "-1.0")}), Event::kNone);
  EXPECT_EQ(result.bits(), kNan32);
  EXPECT_EQ(call(overload("NEG:REAL"), result, {Value(TypeId::kReal, "NaN")}), Event::kNone);
  EXPECT_EQ(result.bits(), kNan32);
}

TEST(Reals, DivisionByZeroIsAnInfinityWithoutEvent) {
  Event event = Event::kNone;
  EXPECT_EQ(stdlib::div(1.0, 0.0, event), HUGE_VAL);
  EXPECT_EQ(stdlib::div(-1.0f, 0.0f, event), -HUGE_VALF);
  EXPECT_EQ(event, Event::kNone);
}

TEST(Reals, AbsoluteAndNegatedZero) {
  EXPECT_FALSE(std::signbit(stdlib::abs(-0.0)));
  EXPECT_TRUE(std::signbit(stdlib::neg(0.0f)));
  EXPECT_EQ(stdlib::abs(-HUGE_VAL), HUGE_VAL);
}

TEST(Reals, RoundsHalfToEvenWhateverTheRoundingMode) {
  static_assert(stdlib::round_half_even(2.5) == 2.0);
  static_assert(stdlib::round_half_even(3.5) == 4.0);
  static_assert(stdlib::round_half_even(-2.5) == -2.0);
  for (const double v :
       {0.5, 1.5, -0.5, -1.5, 0.49999999999999994, 2.5000000000000004, 4503599627370495.5, 4503599627370494.5,
        -4503599627370495.5, 4503599627370496.0, 9007199254740993.0, 1e300, -1e300}) {
    EXPECT_EQ(stdlib::round_half_even(v), std::nearbyint(v)) << v;
  }
}

TEST(Reals, OrderOfNan) {
  const Value nan(TypeId::kReal, "NaN"), one(TypeId::kReal, "1.0");
  const auto holds = [&](const char* key, const Value& a, const Value& b) {
    Value result(TypeId::kBool);
    call(overload(key), result, {a, b});
    return result.bits() != 0;
  };
  EXPECT_FALSE(holds("EQ:REAL", nan, nan));
  EXPECT_TRUE(holds("NE:REAL", nan, nan));
  for (const char* key : {"LT:REAL", "LE:REAL", "GT:REAL", "GE:REAL"}) {
    EXPECT_FALSE(holds(key, nan, one)) << key;
    EXPECT_FALSE(holds(key, one, nan)) << key;
  }
}

/// Divisors of 2^63 and more, which no signed count holds.
TEST(Durations, DivisionByLargeUnsigned) {
  const Overload& o = overload("DIV:TIME,ULINT");
  const auto run = [&](std::int64_t t, std::uint64_t d) {
    std::vector<Value> args;
    args.emplace_back(TypeId::kTime).set(t);
    args.emplace_back(TypeId::kUlint).set(d);
    Value result(TypeId::kTime);
    EXPECT_EQ(call(o, result, args), d == 0 ? Event::kDivideByZero : Event::kNone);
    return result.get<std::int64_t>();
  };
  constexpr auto kLeast = std::numeric_limits<std::int64_t>::min();
  EXPECT_EQ(run(100, 7), 14);
  EXPECT_EQ(run(-100, 7), -14);
  EXPECT_EQ(run(100, 0), 0);
  EXPECT_EQ(run(kLeast, 0x8000000000000000ull), -1);
  EXPECT_EQ(run(kLeast, 0x8000000000000001ull), 0);
  EXPECT_EQ(run(kLeast + 1, 0x8000000000000000ull), 0);
}

TEST(Durations, RealFactorsSaturateWithAnEvent) {
  Value result(TypeId::kTime);
  EXPECT_EQ(call(overload("MUL:TIME,LREAL"), result, {Value(TypeId::kTime, "T#1d"), Value(TypeId::kLreal, "1e9")}),
            Event::kOutOfRange);
  EXPECT_EQ(result.get<std::int64_t>(), std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(call(overload("DIV:TIME,LREAL"), result, {Value(TypeId::kTime, "T#1d"), Value(TypeId::kLreal, "NaN")}),
            Event::kOutOfRange);
  EXPECT_EQ(result.get<std::int64_t>(), 0);
}

}  // namespace
}  // namespace plc::test
