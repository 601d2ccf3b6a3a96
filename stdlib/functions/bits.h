// Rows: bit strings (IEC 61131-3:2013, tables 30 and 31).
#pragma once

#include "stdlib/arithmetic.h"
#include "stdlib/row.h"

namespace plc::stdlib::rows {

inline constexpr std::string_view kBitClause = "IEC 61131-3:2013, table 31";
inline constexpr std::string_view kShiftClause = "IEC 61131-3:2013, table 30";

struct And {
  static constexpr Example examples[] = {{"BOOL", "AND(TRUE, TRUE, FALSE)", "FALSE"},
                                         {"WORD", "AND(16#0FF0, 16#00FF)", "16#00F0"}};
  static constexpr FunctionSpec spec{.name = "AND",
                                     .t_categories = core::kAnyBit,
                                     .params = {{"IN1", kT}, {"IN2", kT}},
                                     .param_count = 2,
                                     .extensible = true,
                                     .result = kT,
                                     .clause = kBitClause,
                                     .summary = "Bit by bit: 1 where all inputs are 1.",
                                     .examples = examples};
  template <class V>
  static V eval(V a, V b, Event&) noexcept {
    return static_cast<V>(a & b);
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &folded<And, ValueOf<T>>;
};

struct Or {
  static constexpr Example examples[] = {{"BOOL", "OR(FALSE, FALSE, TRUE)", "TRUE"},
                                         {"BYTE", "OR(16#0F, 16#30)", "16#3F"}};
  static constexpr FunctionSpec spec{.name = "OR",
                                     .t_categories = core::kAnyBit,
                                     .params = {{"IN1", kT}, {"IN2", kT}},
                                     .param_count = 2,
                                     .extensible = true,
                                     .result = kT,
                                     .clause = kBitClause,
                                     .summary = "Bit by bit: 1 where any input is 1.",
                                     .examples = examples};
  template <class V>
  static V eval(V a, V b, Event&) noexcept {
    return static_cast<V>(a | b);
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &folded<Or, ValueOf<T>>;
};

struct Xor {
  static constexpr Example examples[] = {{"BOOL", "XOR(TRUE, TRUE, TRUE)", "TRUE"},
                                         {"DWORD", "XOR(16#FF, 16#0F)", "16#F0"}};
  static constexpr FunctionSpec spec{.name = "XOR",
                                     .t_categories = core::kAnyBit,
                                     .params = {{"IN1", kT}, {"IN2", kT}},
                                     .param_count = 2,
                                     .extensible = true,
                                     .result = kT,
                                     .clause = kBitClause,
                                     .summary = "Bit by bit: 1 where an odd number of inputs is 1.",
                                     .examples = examples};
  template <class V>
  static V eval(V a, V b, Event&) noexcept {
    return static_cast<V>(a ^ b);
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &folded<Xor, ValueOf<T>>;
};

struct Not {
  static constexpr Example examples[] = {{"BOOL", "NOT(TRUE)", "FALSE"}, {"BYTE", "NOT(16#0F)", "16#F0"}};
  static constexpr FunctionSpec spec{.name = "NOT",
                                     .t_categories = core::kAnyBit,
                                     .params = {{"IN", kT}},
                                     .param_count = 1,
                                     .result = kT,
                                     .clause = kBitClause,
                                     .summary = "Bit by bit: 1 where IN is 0.",
                                     .examples = examples};
  /// A BOOL is a byte of which one bit counts.
  template <TypeId T, TypeId>
  static Event call(void* result, const void* const* args, std::uint32_t) noexcept {
    using V = ValueOf<T>;
    constexpr V kOnes = T == TypeId::kBool ? V{1} : static_cast<V>(~V{0});
    return store(result, static_cast<V>(load<V>(args[0]) ^ kOnes));
  }
  template <TypeId T, TypeId U>
  static constexpr Kernel kernel = &call<T, U>;
};

/// Shifts and rotations move ANY_BIT by an ANY_INT; a BOOL is one bit wide.
template <class Row, TypeId T, TypeId U>
Event shifted(void* result, const void* const* args, std::uint32_t) noexcept {
  using V = ValueOf<T>;
  const auto n = load<ValueOf<U>>(args[1]);
  Event event = Event::kNone;
  auto places = static_cast<std::uint64_t>(n);
  if constexpr (std::is_signed_v<ValueOf<U>>) {
    if (n < 0) {
      event = Event::kOutOfRange;
      places = 0;
    }
  }
  const V value = load<V>(args[0]);
  if constexpr (T == TypeId::kBool) {
    return either(event, store(result, Row::kRotates || places == 0 ? value : V{0}));
  } else {
    return either(event, store(result, Row::eval(value, places)));
  }
}

#define PLC_SHIFT(Row, iec, function, rotates, text)                         \
  struct Row {                                                               \
    static constexpr bool kRotates = rotates;                                \
    static constexpr FunctionSpec spec{.name = iec,                          \
                                       .t_categories = core::kAnyBit,        \
                                       .u_categories = core::kAnyInt,        \
                                       .params = {{"IN", kT}, {"N", kU}},    \
                                       .param_count = 2,                     \
                                       .result = kT,                         \
                                       .events = events(Event::kOutOfRange), \
                                       .clause = kShiftClause,               \
                                       .summary = text,                      \
                                       .examples = Row##Examples::list};     \
    template <class V>                                                       \
    static V eval(V v, std::uint64_t n) noexcept {                           \
      return function(v, n);                                                 \
    }                                                                        \
    template <TypeId T, TypeId U>                                            \
    static constexpr Kernel kernel = &shifted<Row, T, U>;                    \
  }

struct ShlExamples {
  static constexpr Example list[] = {{"BYTE,INT", "SHL(16#81, 1)", "16#02"},
                                     {"WORD,INT", "SHL(16#FFFF, 16)", "16#0000"},
                                     {"WORD,INT", "SHL(16#00FF, -1)", "event:out_of_range 16#00FF"}};
};
struct ShrExamples {
  static constexpr Example list[] = {{"BYTE,USINT", "SHR(16#81, 1)", "16#40"},
                                     {"LWORD,DINT", "SHR(16#FF, 64)", "16#0"}};
};
struct RolExamples {
  static constexpr Example list[] = {{"BYTE,INT", "ROL(16#81, 1)", "16#03"}, {"BYTE,INT", "ROL(16#81, 9)", "16#03"}};
};
struct RorExamples {
  static constexpr Example list[] = {{"BYTE,INT", "ROR(16#81, 1)", "16#C0"}, {"BOOL,INT", "ROR(TRUE, 3)", "TRUE"}};
};

PLC_SHIFT(Shl, "SHL", shift_left, false,
          "IN shifted left by N bits, filled with zeros on the right; by the width or more 0; a negative N counts as 0 "
          "with an event.");
PLC_SHIFT(Shr, "SHR", shift_right, false,
          "IN shifted right by N bits, filled with zeros on the left; by the width or more 0; a negative N counts as 0 "
          "with an event.");
PLC_SHIFT(Rol, "ROL", rotate_left, true,
          "IN rotated left by N bits, modulo the width; a negative N counts as 0 with an event.");
PLC_SHIFT(Ror, "ROR", rotate_right, true,
          "IN rotated right by N bits, modulo the width; a negative N counts as 0 with an event.");

#undef PLC_SHIFT

/// The block UNPACK is the way back.
struct Pack {
  static constexpr Example examples[] = {{"", "PACK(TRUE, FALSE, TRUE, FALSE, FALSE, FALSE, FALSE, TRUE)", "16#85"},
                                         {"", "PACK(FALSE, TRUE, FALSE, FALSE, FALSE, FALSE, FALSE, FALSE)", "16#02"}};
  static constexpr ParamType kBit = fixed(TypeId::kBool);
  static constexpr FunctionSpec spec{.name = "PACK",
                                     .params = {{"B0", kBit},
                                                {"B1", kBit},
                                                {"B2", kBit},
                                                {"B3", kBit},
                                                {"B4", kBit},
                                                {"B5", kBit},
                                                {"B6", kBit},
                                                {"B7", kBit}},
                                     .param_count = 8,
                                     .result = fixed(TypeId::kByte),
                                     .clause = "not in the standard; as in CODESYS",
                                     .summary = "The byte of eight bits, B0 the lowest.",
                                     .examples = examples};
  static Event pack(void* result, const void* const* args, std::uint32_t count) noexcept {
    unsigned bits = 0;
    for (std::uint32_t i = 0; i < count; ++i) bits |= static_cast<unsigned>(load<std::uint8_t>(args[i])) << i;
    return store(result, static_cast<std::uint8_t>(bits));
  }
  template <TypeId, TypeId>
  static constexpr Kernel kernel = &pack;
};

using BitRows = Rows<And, Or, Xor, Not, Shl, Shr, Rol, Ror, Pack>;

}  // namespace plc::stdlib::rows
