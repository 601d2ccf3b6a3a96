// Rows: comparisons (IEC 61131-3:2013, table 33). Strings compare code unit by code unit, BOOL orders FALSE before
// TRUE, a NaN is unequal to everything and in no order.
#pragma once

#include "stdlib/row.h"

namespace plc::stdlib::rows {

#define PLC_COMPARISON(Row, iec, symbol, is_extensible, text)                  \
  struct Row {                                                                 \
    static constexpr FunctionSpec spec{.name = iec,                            \
                                       .t_categories = core::kAnyElementary,   \
                                       .params = {{"IN1", kT}, {"IN2", kT}},   \
                                       .param_count = 2,                       \
                                       .extensible = is_extensible,            \
                                       .result = fixed(TypeId::kBool),         \
                                       .clause = "IEC 61131-3:2013, table 33", \
                                       .summary = text,                        \
                                       .examples = Row##Examples::list};       \
    template <class V>                                                         \
    static bool holds(V a, V b) noexcept {                                     \
      return a symbol b;                                                       \
    }                                                                          \
    template <TypeId T, TypeId>                                                \
    static constexpr Kernel kernel = &chained<Row, ValueOf<T>>;                \
  }

struct GtExamples {
  static constexpr Example list[] = {
      {"DINT", "GT(3, 2, 1)", "TRUE"}, {"DINT", "GT(3, 1, 2)", "FALSE"}, {"STRING", "GT('b', 'abc')", "TRUE"}};
};
struct GeExamples {
  static constexpr Example list[] = {
      {"INT", "GE(3, 3, -1)", "TRUE"}, {"UDINT", "GE(1, 2)", "FALSE"}, {"REAL", "GE(1.5, 1.5)", "TRUE"}};
};
struct EqExamples {
  static constexpr Example list[] = {
      {"WORD", "EQ(16#FF, 255, 255)", "TRUE"}, {"STRING", "EQ('a', 'A')", "FALSE"}, {"BOOL", "EQ(TRUE, TRUE)", "TRUE"}};
};
struct LeExamples {
  static constexpr Example list[] = {{"SINT", "LE(-1, 0, 0)", "TRUE"}, {"TIME", "LE(T#2s, T#1s)", "FALSE"}};
};
struct LtExamples {
  static constexpr Example list[] = {{"BOOL", "LT(FALSE, TRUE)", "TRUE"}, {"LREAL", "LT(1.0, 2.0, 2.0)", "FALSE"}};
};
struct NeExamples {
  static constexpr Example list[] = {{"DINT", "NE(1, 2)", "TRUE"}, {"WSTRING", "NE(\"ab\", \"ab\")", "FALSE"}};
};

PLC_COMPARISON(Gt, "GT", >, true, "TRUE when the inputs decrease strictly.");
PLC_COMPARISON(Ge, "GE", >=, true, "TRUE when no input is greater than the one before it.");
PLC_COMPARISON(Eq, "EQ", ==, true, "TRUE when all inputs are equal.");
PLC_COMPARISON(Le, "LE", <=, true, "TRUE when no input is less than the one before it.");
PLC_COMPARISON(Lt, "LT", <, true, "TRUE when the inputs increase strictly.");
PLC_COMPARISON(Ne, "NE", !=, false, "TRUE when the inputs differ.");

#undef PLC_COMPARISON

using ComparisonRows = Rows<Gt, Ge, Eq, Le, Lt, Ne>;

}  // namespace plc::stdlib::rows
