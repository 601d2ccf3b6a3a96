// Rows: arithmetic of numbers and durations (IEC 61131-3:2013, tables 28, 29 and 35).
#pragma once

#include "stdlib/arithmetic.h"
#include "stdlib/row.h"

namespace plc::stdlib::rows {

struct Add {
  static constexpr Example examples[] = {{"DINT", "ADD(1, 2, 3)", "6"},
                                         {"SINT", "ADD(127, 1)", "-128"},
                                         {"REAL", "ADD(0.5, 0.25)", "0.75"},
                                         {"TIME", "ADD(T#1s, T#500ms)", "T#1500ms"}};
  static constexpr FunctionSpec spec{.name = "ADD",
                                     .t_categories = core::kAnyMagnitude,
                                     .params = {{"IN1", kT}, {"IN2", kT}},
                                     .param_count = 2,
                                     .extensible = true,
                                     .result = kT,
                                     .clause = "IEC 61131-3:2013, table 29",
                                     .summary = "Sum of the inputs; integers wrap.",
                                     .examples = examples};
  template <class V>
  static V eval(V a, V b, Event&) noexcept {
    return add(a, b);
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &folded<Add, ValueOf<T>>;
};

struct Sub {
  static constexpr Example examples[] = {{"DINT", "SUB(1, 2)", "-1"},
                                         {"USINT", "SUB(0, 1)", "255"},
                                         {"LREAL", "SUB(0.5, 0.25)", "0.25"},
                                         {"TIME", "SUB(T#1s, T#1500ms)", "T#-500ms"}};
  static constexpr FunctionSpec spec{.name = "SUB",
                                     .t_categories = core::kAnyMagnitude,
                                     .params = {{"IN1", kT}, {"IN2", kT}},
                                     .param_count = 2,
                                     .result = kT,
                                     .clause = "IEC 61131-3:2013, table 29",
                                     .summary = "IN1 minus IN2; integers wrap.",
                                     .examples = examples};
  template <class V>
  static V eval(V a, V b, Event&) noexcept {
    return sub(a, b);
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &binary<Sub, ValueOf<T>>;
};

struct Mul {
  static constexpr Example examples[] = {
      {"DINT", "MUL(2, 3, 4)", "24"}, {"INT", "MUL(256, 128)", "-32768"}, {"REAL", "MUL(0.5, -4.0)", "-2.0"}};
  static constexpr FunctionSpec spec{.name = "MUL",
                                     .t_categories = core::kAnyNum,
                                     .params = {{"IN1", kT}, {"IN2", kT}},
                                     .param_count = 2,
                                     .extensible = true,
                                     .result = kT,
                                     .clause = "IEC 61131-3:2013, table 29",
                                     .summary = "Product of the inputs; integers wrap.",
                                     .examples = examples};
  template <class V>
  static V eval(V a, V b, Event&) noexcept {
    return mul(a, b);
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &folded<Mul, ValueOf<T>>;
};

struct Div {
  static constexpr Example examples[] = {{"DINT", "DIV(-7, 2)", "-3"},
                                         {"DINT", "DIV(1, 0)", "event:divide_by_zero 0"},
                                         {"SINT", "DIV(-128, -1)", "-128"},
                                         {"LREAL", "DIV(1.0, 4.0)", "0.25"}};
  static constexpr FunctionSpec spec{.name = "DIV",
                                     .t_categories = core::kAnyNum,
                                     .params = {{"IN1", kT}, {"IN2", kT}},
                                     .param_count = 2,
                                     .result = kT,
                                     .events = events(Event::kDivideByZero),
                                     .clause = "IEC 61131-3:2013, table 29",
                                     .summary =
                                         "IN1 divided by IN2, integers toward zero; an integer divided by zero is 0 "
                                         "with an event, reals follow IEEE 754.",
                                     .examples = examples};
  template <class V>
  static V eval(V a, V b, Event& event) noexcept {
    return div(a, b, event);
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &binary<Div, ValueOf<T>>;
};

struct Mod {
  static constexpr Example examples[] = {
      {"DINT", "MOD(-7, 2)", "-1"}, {"UINT", "MOD(7, 0)", "0"}, {"SINT", "MOD(-128, -1)", "0"}};
  static constexpr FunctionSpec spec{.name = "MOD",
                                     .t_categories = core::kAnyInt,
                                     .params = {{"IN1", kT}, {"IN2", kT}},
                                     .param_count = 2,
                                     .result = kT,
                                     .clause = "IEC 61131-3:2013, table 29",
                                     .summary = "Remainder of IN1 divided by IN2, with the sign of IN1; 0 if IN2 is 0.",
                                     .examples = examples};
  template <class V>
  static V eval(V a, V b, Event&) noexcept {
    return mod_wrap(a, b);
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &binary<Mod, ValueOf<T>>;
};

/// Unary minus of ST: no name of the standard's, so users do not draw it.
struct Neg {
  static constexpr Example examples[] = {
      {"DINT", "NEG(5)", "-5"}, {"INT", "NEG(-32768)", "-32768"}, {"REAL", "NEG(1.5)", "-1.5"}};
  static constexpr FunctionSpec spec{.name = "NEG",
                                     .t_categories = core::kAnyMagnitude,
                                     .params = {{"IN", kT}},
                                     .param_count = 1,
                                     .result = kT,
                                     .clause = "IEC 61131-3:2013, table 71 (unary minus)",
                                     .summary = "Minus IN; integers wrap.",
                                     .examples = examples};
  template <class V>
  static V eval(V a, Event&) noexcept {
    return neg(a);
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &unary<Neg, ValueOf<T>>;
};

struct Abs {
  static constexpr Example examples[] = {
      {"DINT", "ABS(-5)", "5"}, {"SINT", "ABS(-128)", "-128"}, {"REAL", "ABS(-1.5)", "1.5"}};
  static constexpr FunctionSpec spec{.name = "ABS",
                                     .t_categories = core::kAnyNum,
                                     .params = {{"IN", kT}},
                                     .param_count = 1,
                                     .result = kT,
                                     .clause = "IEC 61131-3:2013, table 28",
                                     .summary = "Magnitude of IN; the least integer wraps to itself.",
                                     .examples = examples};
  template <class V>
  static V eval(V a, Event&) noexcept {
    return stdlib::abs(a);
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &unary<Abs, ValueOf<T>>;
};

/// What ** and EXPT are where an integer is needed: no name of the standard's, as NEG.
struct IntegerPower {
  static constexpr Example examples[] = {{"DINT,INT", "INTEGER_POWER(2, 10)", "1024"},
                                         {"SINT,INT", "INTEGER_POWER(-3, 5)", "13"},
                                         {"DINT,INT", "INTEGER_POWER(2, -1)", "0"},
                                         {"DINT,INT", "INTEGER_POWER(0, -1)", "event:divide_by_zero 0"}};
  static constexpr FunctionSpec spec{
      .name = "INTEGER_POWER",
      .t_categories = core::kAnyInt,
      .u_categories = core::kAnyInt,
      .params = {{"IN1", kT}, {"IN2", kU}},
      .param_count = 2,
      .result = kT,
      .events = events(Event::kDivideByZero),
      .clause = "not in the standard; ** of integers where an integer is needed",
      .summary = "IN1 to the power IN2; integers wrap. Below 0 the power is cut to an integer, and an event for 0.",
      .examples = examples};
  template <class V, class W>
  static V eval(V base, W exponent, Event& event) noexcept {
    return power_wrap(base, exponent, event);
  }
  template <TypeId T, TypeId U>
  static constexpr Kernel kernel = &binary<IntegerPower, ValueOf<T>, ValueOf<U>>;
};

using ArithmeticRows = Rows<Add, Sub, Mul, Div, Mod, Neg, Abs, IntegerPower>;

}  // namespace plc::stdlib::rows
