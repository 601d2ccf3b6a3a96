// What other tools take and the standard does not know, of types: every pair of integers and bit strings against
// arithmetic in C, with the rules of docs/guides/conversions.md written down a second time.
#include <bit>

#include "tests/unit/frontend-st/fixture.h"

namespace plc::st::test {
namespace {

using core::Code;
__extension__ using Wide = __int128;
__extension__ using WideBits = unsigned __int128;

struct Kind {
  const char* name;
  unsigned bits;
  bool is_signed;
  bool is_bits;
};
constexpr Kind kKinds[] = {{"SINT", 8, true, false},    {"INT", 16, true, false},    {"DINT", 32, true, false},
                           {"LINT", 64, true, false},   {"USINT", 8, false, false},  {"UINT", 16, false, false},
                           {"UDINT", 32, false, false}, {"ULINT", 64, false, false}, {"BYTE", 8, false, true},
                           {"WORD", 16, false, true},   {"DWORD", 32, false, true},  {"LWORD", 64, false, true}};

std::uint64_t low_bits(Wide value, unsigned bits) {
  const auto all = static_cast<std::uint64_t>(value);
  return bits == 64 ? all : all & ((std::uint64_t{1} << bits) - 1);
}
/// The value that the low bits are.
Wide as(Wide value, unsigned bits, bool is_signed) {
  const std::uint64_t low = low_bits(value, bits);
  const bool negative = is_signed && (low >> (bits - 1) & 1) != 0;
  return negative ? Wide{low} - (Wide{1} << bits) : Wide{low};
}
Wide as(Wide value, const Kind& kind) { return as(value, kind.bits, kind.is_signed); }

std::vector<Wide> samples(const Kind& kind) {
  std::vector<Wide> out;
  for (const Wide value : {Wide{0}, Wide{1}, Wide{100}, Wide{-1}, Wide{1} << (kind.bits - 1),
                           (Wide{1} << (kind.bits - 1)) - 1, Wide{0x5a5a5a5a5a5a5a5a}}) {
    out.push_back(as(value, kind));
  }
  return out;
}

/// The type in which two operands are computed.
Kind computed(const Kind& a, const Kind& b) {
  const unsigned most = std::max(a.bits, b.bits);
  if (a.is_bits || b.is_bits) {
    if (a.is_signed || b.is_signed || most < 32) return kKinds[3];
    return most == 32 ? kKinds[6] : kKinds[7];
  }
  if (a.is_signed == b.is_signed) return a.bits >= b.bits ? a : b;
  const Kind& with = a.is_signed ? a : b;
  const Kind& without = a.is_signed ? b : a;
  for (const Kind& kind : {kKinds[0], kKinds[1], kKinds[2], kKinds[3]}) {
    if (kind.bits > without.bits && kind.bits >= with.bits) return kind;
  }
  return kKinds[3];
}

struct Operation {
  const char* name;
  const char* symbol;
  bool logic;
};
constexpr Operation kOperations[] = {{"add", "+", false}, {"sub", "-", false},   {"mul", "*", false},
                                     {"div", "/", false}, {"mod", "MOD", false}, {"band", "AND", true},
                                     {"bor", "OR", true}, {"bxor", "XOR", true}};
constexpr Operation kComparisons[] = {{"eq", "=", false}, {"lt", "<", false}, {"ge", ">=", false}};

Wide result_of(const Operation& operation, Wide x, Wide y, const Kind& a, const Kind& b) {
  const std::string symbol = operation.symbol;
  if (operation.logic) {
    const unsigned bits = std::max(a.bits, b.bits);
    const Wide out = symbol == "AND" ? (x & y) : symbol == "OR" ? (x | y) : (x ^ y);
    return as(out, bits, a.is_signed || b.is_signed);
  }
  const Kind in = computed(a, b);
  x = as(x, in);
  y = as(y, in);
  if (symbol == "+") return as(x + y, in);
  if (symbol == "-") return as(x - y, in);
  if (symbol == "*") return as(static_cast<Wide>(static_cast<WideBits>(x) * static_cast<WideBits>(y)), in);
  if (y == 0) return 0;
  return as(symbol == "/" ? x / y : x % y, in);
}

struct IdiomsTest : ::testing::Test {
  World world;
  std::uint32_t main = 0;
  void SetUp() override {
    std::vector<plcopen::Variable> variables;
    for (const Kind& kind : kKinds) {
      for (const char* prefix : {"x_", "y_"})
        variables.push_back(variable(std::string(prefix) + kind.name, named(kind.name)));
      for (const Operation& operation : kOperations) {
        variables.push_back(variable(std::string(operation.name) + "_" + kind.name, named(kind.name)));
      }
    }
    for (const Operation& comparison : kComparisons) variables.push_back(variable(comparison.name, named("BOOL")));
    for (const char* name : {"t", "u"}) variables.push_back(variable(name, named("BOOL")));
    for (const char* name : {"r", "q"}) variables.push_back(variable(name, named("REAL")));
    variables.push_back(variable("lr", named("LREAL")));
    variables.push_back(variable("tm", named("TIME")));
    variables.push_back(variable("arr", array_of(named("INT"), {{"0", "9"}})));
    world.program("Main", variables);
    world.declare_cleanly();
  }
  bool lower(std::string_view text) {
    world.module->pous[main].body = {};
    ir::Builder b(*world.module, main, world.diagnostics);
    return lower_statements(text, at_line(10, 5), b);
  }
  std::map<std::string, std::uint64_t> run(std::map<std::string, std::uint64_t> cells = {}) {
    Machine machine(*world.module, world.module->pous[main]);
    machine.cells = std::move(cells);
    machine.run();
    return machine.cells;
  }
  std::map<std::string, std::uint64_t> run(std::string_view text, std::map<std::string, std::uint64_t> cells = {}) {
    EXPECT_TRUE(lower(text)) << text << "\n" << world.rendered();
    return run(std::move(cells));
  }
  /// The codes that `text` reports, each once.
  std::string codes(std::string_view text) {
    world.diagnostics = {};
    world.diagnostics.add_file("test.xml");
    lower(text);
    std::string out;
    for (const core::Diagnostic& d : world.diagnostics.all()) {
      const std::string code(core::info(d.code).name);
      if (out.find(code) == std::string::npos) out += (out.empty() ? "" : " ") + code;
    }
    return out;
  }
};

TEST_F(IdiomsTest, EveryPairOfTypesComputesAsInC) {
  for (const Kind& a : kKinds) {
    for (const Kind& b : kKinds) {
      const std::string x = std::string("x_") + a.name;
      const std::string y = std::string("y_") + b.name;
      const unsigned most = std::max(a.bits, b.bits);
      std::string text;
      for (const Operation& operation : kOperations) {
        for (const Kind& to : kKinds) {
          const std::string statement =
              std::string(operation.name) + "_" + to.name + " := " + x + " " + operation.symbol + " " + y + ";\n";
          if (to.bits >= most) text += statement;
          if (to.bits < most) {
            EXPECT_FALSE(lower(statement)) << statement;
          }
        }
      }
      for (const Operation& comparison : kComparisons) {
        text += std::string(comparison.name) + " := " + x + " " + comparison.symbol + " " + y + ";\n";
      }
      world.diagnostics = {};
      world.diagnostics.add_file("test.xml");
      ASSERT_TRUE(lower(text)) << world.rendered();
      for (const Wide first : samples(a)) {
        for (const Wide second : samples(b)) {
          const auto cells = run({{x, low_bits(first, a.bits)}, {y, low_bits(second, b.bits)}});
          for (const Operation& operation : kOperations) {
            const Wide wanted = result_of(operation, first, second, a, b);
            for (const Kind& to : kKinds) {
              if (to.bits < most) continue;
              ASSERT_EQ(cells.at(std::string(operation.name) + "_" + to.name), low_bits(wanted, to.bits))
                  << a.name << " " << static_cast<std::int64_t>(first) << " " << operation.symbol << " " << b.name
                  << " " << static_cast<std::int64_t>(second) << " to " << to.name;
            }
          }
          // Only beside a signed operand does one without sign of 64 bits count as LINT.
          const bool as_lint = a.is_signed != b.is_signed && most == 64;
          const Wide left = as_lint ? as(first, 64, true) : first;
          const Wide right = as_lint ? as(second, 64, true) : second;
          ASSERT_EQ(cells.at("eq") != 0, left == right) << a.name << " " << b.name;
          ASSERT_EQ(cells.at("lt") != 0, left < right) << a.name << " " << b.name;
          ASSERT_EQ(cells.at("ge") != 0, left >= right) << a.name << " " << b.name;
        }
      }
    }
  }
}

TEST_F(IdiomsTest, EveryIntegerShiftsByEveryType) {
  for (const Kind& a : kKinds) {
    for (const Kind& count : kKinds) {
      const std::string x = std::string("x_") + a.name;
      const std::string n = std::string("y_") + count.name;
      const auto call = [&](const char* target, const char* function) {
        return std::string(target) + "_" + a.name + " := " + function + "(" + x + ", " + n + ");\n";
      };
      ASSERT_TRUE(lower(call("add", "SHL") + call("sub", "SHR") + call("mul", "ROL") + call("div", "ROR")))
          << world.rendered();
      for (const Wide value : samples(a)) {
        for (const unsigned places : {0u, 1u, 7u, 8u, 33u, 63u, 64u, 100u}) {
          const auto cells = run({{x, low_bits(value, a.bits)}, {n, places}});
          const std::uint64_t bits = low_bits(value, a.bits);
          const Wide left = places >= a.bits ? 0 : Wide{bits} << places;
          const Wide right =
              places >= a.bits ? (value < 0 ? -1 : 0) : value >> places;  // of signed types with the sign
          const unsigned turn = places % a.bits;
          const Wide rolled = turn == 0 ? Wide{bits} : (Wide{bits} << turn | Wide{bits} >> (a.bits - turn));
          const Wide back = turn == 0 ? Wide{bits} : (Wide{bits} >> turn | Wide{bits} << (a.bits - turn));
          const auto cell = [&](const char* target) { return cells.at(std::string(target) + "_" + a.name); };
          ASSERT_EQ(cell("add"), low_bits(left, a.bits)) << a.name << " by " << places;
          ASSERT_EQ(cell("sub"), low_bits(right, a.bits)) << a.name << " by " << places;
          ASSERT_EQ(cell("mul"), low_bits(rolled, a.bits)) << a.name << " by " << places;
          ASSERT_EQ(cell("div"), low_bits(back, a.bits)) << a.name << " by " << places;
        }
      }
    }
  }
}

TEST_F(IdiomsTest, EveryTypeGoesWhereItsSizeFits) {
  for (const Kind& from : kKinds) {
    for (const Kind& to : kKinds) {
      const std::string text = std::string("y_") + to.name + " := x_" + from.name + ";";
      ASSERT_EQ(lower(text), to.bits >= from.bits) << text;
      if (to.bits < from.bits) continue;
      for (const Wide value : samples(from)) {
        const auto cells = run({{std::string("x_") + from.name, low_bits(value, from.bits)}});
        ASSERT_EQ(cells.at(std::string("y_") + to.name), low_bits(value, to.bits)) << text;
      }
    }
    const std::string x = std::string("x_") + from.name;
    for (const Wide value : samples(from)) {
      const auto cells = run("r := " + x + "; lr := " + x + ";", {{x, low_bits(value, from.bits)}});
      EXPECT_EQ(std::bit_cast<float>(static_cast<std::uint32_t>(cells.at("r"))), static_cast<float>(value));
      EXPECT_EQ(std::bit_cast<double>(cells.at("lr")), static_cast<double>(value));
    }
    EXPECT_TRUE(lower("y_" + std::string(from.name) + " := t;"));
    EXPECT_FALSE(lower("t := " + x + ";"));
    EXPECT_FALSE(lower("IF " + x + " THEN t := TRUE; END_IF;"));
    EXPECT_FALSE(lower(x + " := r;"));
    EXPECT_FALSE(lower("tm := " + x + ";"));
  }
}

TEST_F(IdiomsTest, EachIdiomHasItsCode) {
  EXPECT_EQ(codes("x_BYTE := x_BYTE + 1;"), "P4330");
  EXPECT_EQ(codes("x_INT := x_BYTE + y_BYTE * 2 - x_BYTE;"), "P4330");
  EXPECT_EQ(codes("x_UINT := x_UINT AND 16#FF;"), "P4331");
  EXPECT_EQ(codes("x_DINT := NOT x_DINT;"), "P4331");
  EXPECT_EQ(codes("x_UINT := x_INT;"), "P4332");
  EXPECT_EQ(codes("t := x_ULINT > x_LINT;"), "P4332");
  EXPECT_EQ(codes("x_INT := x_INT + x_UINT;"), "P4332");
  EXPECT_EQ(codes("x_INT := x_WORD;"), "P4333");
  EXPECT_EQ(codes("t := x_INT = x_WORD;"), "P4333");
  EXPECT_EQ(codes("r := x_WORD;"), "P4333");
  EXPECT_EQ(codes("x_INT := t;"), "P4334");
  EXPECT_EQ(codes("x_INT := x_INT + t; r := r * t;"), "P4334");
  EXPECT_EQ(codes("x_UINT := -1; x_INT := 16#FFFF;"), "P4335");
  EXPECT_EQ(codes("x_DINT := x_DINT ** 2;"), "P4336");
  EXPECT_EQ(codes("r := x_DINT;"), "P4337");
  EXPECT_EQ(codes("r := r + x_DINT;"), "P4337");
  EXPECT_EQ(codes("x_WORD := SHL(x_WORD, x_BYTE);"), "P4338");
  EXPECT_EQ(codes("FOR x_BYTE := 1 TO 3 DO t := TRUE; END_FOR;"), "P4333");
}

TEST_F(IdiomsTest, WhatTheStandardKnowsHasNoNote) {
  EXPECT_EQ(codes("x_INT := x_INT + 1; x_DINT := x_INT + x_UINT; x_WORD := x_BYTE; lr := x_DINT; r := x_INT ** 2;"),
            "");
  EXPECT_EQ(codes("x_WORD := x_WORD AND 16#FF; x_WORD := SHL(x_WORD, 3); t := x_INT > x_UINT; x_BYTE := 255;"), "");
  EXPECT_EQ(codes("x_BYTE := USINT_TO_BYTE(BYTE_TO_USINT(x_BYTE) + 1); t := x_DINT > x_INT ** 2;"), "");
}

TEST_F(IdiomsTest, WhatLosesBitsIsRefused) {
  EXPECT_EQ(codes("x_BYTE := x_BYTE + x_INT;"), "P4330 P4101");
  EXPECT_EQ(codes("x_INT := x_DINT; x_INT := x_DWORD;"), "P4101");
  EXPECT_EQ(codes("x_BYTE := 300; x_BYTE := -129; x_INT := 40000; x_SINT := 16#1FF; t := 2;"), "P4107");
  EXPECT_EQ(codes("r := lr;"), "P4101");
  EXPECT_EQ(codes("x_INT := x_INT AND t;"), "P4103");
  EXPECT_EQ(codes("CASE x_INT OF TRUE: t := TRUE; END_CASE;"), "P4101");
}

TEST_F(IdiomsTest, MessagesNameWhatAValueStandsFor) {
  codes("x_BYTE := x_BYTE + x_WORD;");
  EXPECT_EQ(world.diagnostics.all().back().message, "variable \"x_BYTE\" needs BYTE, \"x_BYTE + x_WORD\" is WORD");
  EXPECT_EQ(world.diagnostics.all().back().help, "convert with WORD_TO_BYTE");
  codes("x_INT := SHL(x_INT, t);");
  EXPECT_NE(world.diagnostics.all().back().message.find("input \"N\" of SHL has type BOOL"), std::string::npos);
}

TEST_F(IdiomsTest, IntermediateResultsAreNotCut) {
  const auto cells =
      run("x_INT := y_BYTE + 100; x_BYTE := y_BYTE + 100; t := y_BYTE - 201 < 0; x_DINT := (y_BYTE + 100) * 2;"
          "x_LINT := y_WORD * y_WORD; u := TO_BYTE(y_BYTE + 56) = 0; x_UINT := arr[y_BYTE - 197]; x_SINT := "
          "BYTE_TO_SINT(y_BYTE + 1);",
          {{"y_BYTE", 200}, {"y_WORD", 65535}, {"arr[3]", 9}});
  const auto more =
      run("x_INT := SHR(y_BYTE + 100, 1); y_INT := (y_BYTE + 100) OR 1; x_DINT := (y_UINT + y_WORD) AND 16#FFFF;"
          "y_DINT := SHR(y_BYTE - 202, 1);",
          {{"y_BYTE", 200}, {"y_WORD", 5}, {"y_UINT", 65535}});
  EXPECT_EQ(more.at("x_INT"), 150u);
  EXPECT_EQ(more.at("y_INT"), 301u);
  EXPECT_EQ(more.at("x_DINT"), 4u);
  EXPECT_EQ(more.at("y_DINT"), 0xffffffffu);
  EXPECT_EQ(cells.at("x_INT"), 300u);
  EXPECT_EQ(cells.at("x_BYTE"), 44u);
  EXPECT_EQ(cells.at("t"), 1u);
  EXPECT_EQ(cells.at("x_DINT"), 600u);
  EXPECT_EQ(cells.at("x_LINT"), 4294836225u);
  EXPECT_EQ(cells.at("u"), 1u);
  EXPECT_EQ(cells.at("x_UINT"), 9u);
  EXPECT_EQ(cells.at("x_SINT"), 201u);
}

TEST_F(IdiomsTest, ResultsUnderEnAreNoWider) {
  const auto cells = run("x_BYTE := ADD(EN := t, IN1 := y_BYTE, IN2 := 100);", {{"y_BYTE", 200}, {"t", 1}});
  EXPECT_EQ(cells.at("x_BYTE"), 44u);
}

TEST_F(IdiomsTest, RealsBesideBitStrings) {
  const auto cells = run("r := y_WORD * 1.5; q := r + y_DWORD; lr := y_LWORD;",
                         {{"y_WORD", 3}, {"y_DWORD", 7}, {"y_LWORD", 1ull << 63}});
  EXPECT_EQ(std::bit_cast<float>(static_cast<std::uint32_t>(cells.at("r"))), 4.5f);
  EXPECT_EQ(std::bit_cast<float>(static_cast<std::uint32_t>(cells.at("q"))), 11.5f);
  EXPECT_EQ(std::bit_cast<double>(cells.at("lr")), 9223372036854775808.0);
}

TEST_F(IdiomsTest, PowersOfIntegersAreExact) {
  const auto cells = run("x_LINT := y_LINT ** 39; x_DINT := 2 ** y_INT; t := 399 < y_INT ** 2; x_WORD := y_WORD ** 2;",
                         {{"y_LINT", 3}, {"y_INT", 20}, {"y_WORD", 300}});
  EXPECT_EQ(cells.at("x_LINT"), 4052555153018976267u);
  EXPECT_EQ(cells.at("x_DINT"), 1048576u);
  EXPECT_EQ(cells.at("t"), 1u);
  EXPECT_EQ(cells.at("x_WORD"), 90000u & 0xffffu);
}

}  // namespace
}  // namespace plc::st::test
