// Rows: functions of one real, ATAN2, EXPT and IS_VALID (IEC 61131-3:2013, tables 28, 29 and 39).
//
// Results are computed by the C library, in double precision or where that is not enough in long double, and rounded
// once, so they are within 1 ulp; those of REAL are usually exact. The last bit may differ between C libraries: what is
// not exact is not folded at compile time. Outside its domain a function gives NaN or an infinity as IEEE 754 says,
// without an event.
#pragma once

#include "stdlib/arithmetic.h"
#include "stdlib/row.h"

namespace plc::stdlib::rows {

inline constexpr std::string_view kNumericClause = "IEC 61131-3:2013, table 28";

/// One row per function of one real: name, C function, whether it is exact, summary, examples.
#define PLC_REAL_FUNCTION(Row, iec, function, exact, text)                \
  struct Row {                                                            \
    static constexpr FunctionSpec spec{.name = iec,                       \
                                       .t_categories = core::kAnyReal,    \
                                       .params = {{"IN", kT}},            \
                                       .param_count = 1,                  \
                                       .result = kT,                      \
                                       .foldable = exact,                 \
                                       .clause = kNumericClause,          \
                                       .summary = text,                   \
                                       .examples = Row##Examples::list};  \
    template <class V>                                                    \
    static V eval(V v, Event&) noexcept {                                 \
      return canonical(static_cast<V>(function(static_cast<double>(v)))); \
    }                                                                     \
    template <TypeId T, TypeId>                                           \
    static constexpr Kernel kernel = &unary<Row, ValueOf<T>>;             \
  }

struct SqrtExamples {
  static constexpr Example list[] = {{"REAL", "SQRT(2.25)", "1.5"}, {"LREAL", "SQRT(-1.0)", "NaN"}};
};
struct LnExamples {
  static constexpr Example list[] = {{"REAL", "LN(1.0)", "0.0"}};
};
struct LogExamples {
  static constexpr Example list[] = {{"LREAL", "LOG(1000.0)", "3.0"}};
};
struct ExpExamples {
  static constexpr Example list[] = {{"REAL", "EXP(0.0)", "1.0"}};
};
struct SinExamples {
  static constexpr Example list[] = {{"REAL", "SIN(0.0)", "0.0"}};
};
struct CosExamples {
  static constexpr Example list[] = {{"REAL", "COS(0.0)", "1.0"}};
};
struct TanExamples {
  static constexpr Example list[] = {{"REAL", "TAN(0.0)", "0.0"}};
};
struct AsinExamples {
  static constexpr Example list[] = {{"REAL", "ASIN(0.0)", "0.0"}, {"REAL", "ASIN(2.0)", "NaN"}};
};
struct AcosExamples {
  static constexpr Example list[] = {{"REAL", "ACOS(1.0)", "0.0"}};
};
struct AtanExamples {
  static constexpr Example list[] = {{"REAL", "ATAN(1.0)", "0.7853981634"}};
};

/// WHY long double: the C library's log10 of a double is up to 2 ulp off.
inline double log10_of(double v) noexcept { return static_cast<double>(std::log10(static_cast<long double>(v))); }

// The double square root of a float, rounded to float, is the exact float square root: 53 >= 2 * 24 + 2 bits.
PLC_REAL_FUNCTION(Sqrt, "SQRT", std::sqrt, true, "Square root of IN; NaN below zero.");
PLC_REAL_FUNCTION(Ln, "LN", std::log, false, "Natural logarithm of IN.");
PLC_REAL_FUNCTION(Log, "LOG", log10_of, false, "Logarithm of IN to base 10.");
PLC_REAL_FUNCTION(Exp, "EXP", std::exp, false, "e to the power IN.");
PLC_REAL_FUNCTION(Sin, "SIN", std::sin, false, "Sine of IN in radians.");
PLC_REAL_FUNCTION(Cos, "COS", std::cos, false, "Cosine of IN in radians.");
PLC_REAL_FUNCTION(Tan, "TAN", std::tan, false, "Tangent of IN in radians.");
PLC_REAL_FUNCTION(Asin, "ASIN", std::asin, false, "Principal arc sine of IN, in radians.");
PLC_REAL_FUNCTION(Acos, "ACOS", std::acos, false, "Principal arc cosine of IN, in radians.");
PLC_REAL_FUNCTION(Atan, "ATAN", std::atan, false, "Principal arc tangent of IN, in radians.");

#undef PLC_REAL_FUNCTION

struct Atan2 {
  static constexpr Example examples[] = {{"LREAL", "ATAN2(0.0, 1.0)", "0.0"},
                                         {"REAL", "ATAN2(1.0, 0.0)", "1.5707963268"}};
  static constexpr FunctionSpec spec{.name = "ATAN2",
                                     .t_categories = core::kAnyReal,
                                     .params = {{"Y", kT}, {"X", kT}},
                                     .param_count = 2,
                                     .result = kT,
                                     .foldable = false,
                                     .clause = kNumericClause,
                                     .summary = "Angle between the X axis and the point (X, Y), in radians, -pi .. pi.",
                                     .examples = examples};
  template <class V>
  static V eval(V y, V x, Event&) noexcept {
    return canonical(static_cast<V>(std::atan2(static_cast<double>(y), static_cast<double>(x))));
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &binary<Atan2, ValueOf<T>>;
};

struct Expt {
  static constexpr Example examples[] = {{"REAL,INT", "EXPT(2.0, 10)", "1024.0"},
                                         {"LREAL,LREAL", "EXPT(2.25, 0.5)", "1.5"},
                                         {"REAL,DINT", "EXPT(2.0, -1)", "0.5"}};
  static constexpr FunctionSpec spec{.name = "EXPT",
                                     .t_categories = core::kAnyReal,
                                     .u_categories = core::kAnyNum,
                                     .params = {{"IN1", kT}, {"IN2", kU}},
                                     .param_count = 2,
                                     .result = kT,
                                     .foldable = false,
                                     .clause = "IEC 61131-3:2013, table 29",
                                     .summary = "IN1 to the power IN2.",
                                     .examples = examples};
  template <class V, class W>
  static V eval(V base, W exponent, Event&) noexcept {
    // WHY long double: a double rounds a 64-bit exponent, and with it whether the exponent is odd.
    using Exact = std::conditional_t<std::is_integral_v<W> && sizeof(W) == 8, long double, double>;
    return canonical(static_cast<V>(std::pow(static_cast<Exact>(base), static_cast<Exact>(exponent))));
  }
  template <TypeId T, TypeId U>
  static constexpr Kernel kernel = &binary<Expt, ValueOf<T>, ValueOf<U>>;
};

struct IsValid {
  static constexpr Example examples[] = {{"REAL", "IS_VALID(1.5)", "TRUE"}, {"LREAL", "IS_VALID(NaN)", "FALSE"}};
  static constexpr FunctionSpec spec{.name = "IS_VALID",
                                     .t_categories = core::kAnyReal,
                                     .params = {{"IN", kT}},
                                     .param_count = 1,
                                     .result = fixed(TypeId::kBool),
                                     .clause = "IEC 61131-3:2013, table 39",
                                     .summary = "TRUE if IN is a number, FALSE if it is NaN or infinite.",
                                     .examples = examples};
  template <class V>
  static std::uint8_t eval(V in, Event&) noexcept {
    return in - in == V{0} ? 1 : 0;  // infinity minus itself is NaN
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &unary<IsValid, ValueOf<T>>;
};

/// Under the name most tools have for it, and under OSCAT's.
#define PLC_DEADBAND(Row, iec)                                                                                        \
  struct Row {                                                                                                        \
    static constexpr Example examples[] = {                                                                           \
        {"REAL", iec "(3.0, 2.0)", "1.0"}, {"REAL", iec "(-1.5, 2.0)", "0.0"}, {"LREAL", iec "(-5.0, 2.0)", "-3.0"}}; \
    static constexpr FunctionSpec spec{                                                                               \
        .name = iec,                                                                                                  \
        .t_categories = core::kAnyReal,                                                                               \
        .params = {{"X", kT}, {"L", kT}},                                                                             \
        .param_count = 2,                                                                                             \
        .result = kT,                                                                                                 \
        .clause = "not in the standard; as in OSCAT",                                                                 \
        .summary =                                                                                                    \
            "X without its band around 0: 0 from -L to L, and X - L or X + L beyond them, so "                        \
            "without a step. An L below 0 counts as 0.",                                                              \
        .examples = examples};                                                                                        \
    template <class V>                                                                                                \
    static V eval(V x, V l, Event&) noexcept {                                                                        \
      const V width = l < V{0} ? V{0} : l;                                                                            \
      if (x > width) return sub(x, width);                                                                            \
      if (x < -width) return add(x, width);                                                                           \
      return x != x || l != l ? canonical(x + l) : V{0};                                                              \
    }                                                                                                                 \
    template <TypeId T, TypeId>                                                                                       \
    static constexpr Kernel kernel = &binary<Row, ValueOf<T>>;                                                        \
  };
PLC_DEADBAND(Deadband, "DEADBAND")
PLC_DEADBAND(DeadBand, "DEAD_BAND")
#undef PLC_DEADBAND

using NumericRows = Rows<Sqrt, Ln, Log, Exp, Sin, Cos, Tan, Asin, Acos, Atan, Atan2, Expt, IsValid, Deadband, DeadBand>;

}  // namespace plc::stdlib::rows
