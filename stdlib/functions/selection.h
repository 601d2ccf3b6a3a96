// Rows and bundle: selection and assignment (IEC 61131-3:2013, table 32), and SWITCH.
#pragma once

#include "stdlib/arithmetic.h"
#include "stdlib/row.h"

namespace plc::stdlib::rows {

inline constexpr std::string_view kSelectionClause = "IEC 61131-3:2013, table 32";

struct Move {
  static constexpr Example examples[] = {
      {"DINT", "MOVE(-7)", "-7"}, {"STRING", "MOVE('abc')", "'abc'"}, {"BOOL", "MOVE(TRUE)", "TRUE"}};
  static constexpr FunctionSpec spec{.name = "MOVE",
                                     .t_categories = core::kAnyElementary,
                                     .params = {{"IN", kT}},
                                     .param_count = 1,
                                     .result = kT,
                                     .events = events(Event::kTruncated),
                                     .clause = kSelectionClause,
                                     .summary = "IN; a string longer than the result is cut with an event.",
                                     .examples = examples};
  template <class V>
  static V eval(V a, Event&) noexcept {
    return a;
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &unary<Move, ValueOf<T>>;
};

struct Sel {
  static constexpr Example examples[] = {{"DINT", "SEL(FALSE, 1, 2)", "1"},
                                         {"DINT", "SEL(TRUE, 1, 2)", "2"},
                                         {"STRING", "SEL(TRUE, 'no', 'yes')", "'yes'"}};
  static constexpr FunctionSpec spec{.name = "SEL",
                                     .t_categories = core::kAnyElementary,
                                     .params = {{"G", fixed(TypeId::kBool)}, {"IN0", kT}, {"IN1", kT}},
                                     .param_count = 3,
                                     .result = kT,
                                     .events = events(Event::kTruncated),
                                     .clause = kSelectionClause,
                                     .summary = "IN0 if G is FALSE, IN1 if G is TRUE.",
                                     .examples = examples};
  template <class V>
  static V eval(std::uint8_t g, V in0, V in1, Event&) noexcept {
    return g != 0 ? in1 : in0;
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &ternary<Sel, std::uint8_t, ValueOf<T>>;
};

struct Max {
  static constexpr Example examples[] = {
      {"DINT", "MAX(1, 3, 2)", "3"}, {"REAL", "MAX(-1.5, -2.5)", "-1.5"}, {"STRING", "MAX('a', 'b')", "'b'"}};
  static constexpr FunctionSpec spec{
      .name = "MAX",
      .t_categories = core::kAnyElementary,
      .params = {{"IN1", kT}, {"IN2", kT}},
      .param_count = 2,
      .extensible = true,
      .result = kT,
      .events = events(Event::kTruncated),
      .clause = kSelectionClause,
      .summary = "The greatest input, the first of equal ones; a NaN after another input is passed over.",
      .examples = examples};
  template <class V>
  static V eval(V a, V b, Event&) noexcept {
    return stdlib::greatest(a, b);
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &folded<Max, ValueOf<T>>;
};

struct Min {
  static constexpr Example examples[] = {
      {"DINT", "MIN(2, 1, 3)", "1"}, {"UINT", "MIN(65535, 1)", "1"}, {"TIME", "MIN(T#1s, T#20ms)", "T#20ms"}};
  static constexpr FunctionSpec spec{
      .name = "MIN",
      .t_categories = core::kAnyElementary,
      .params = {{"IN1", kT}, {"IN2", kT}},
      .param_count = 2,
      .extensible = true,
      .result = kT,
      .events = events(Event::kTruncated),
      .clause = kSelectionClause,
      .summary = "The least input, the first of equal ones; a NaN after another input is passed over.",
      .examples = examples};
  template <class V>
  static V eval(V a, V b, Event&) noexcept {
    return stdlib::least(a, b);
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &folded<Min, ValueOf<T>>;
};

struct Limit {
  static constexpr Example examples[] = {{"DINT", "LIMIT(-5, 99, 10)", "10"},
                                         {"DINT", "LIMIT(-5, -99, 10)", "-5"},
                                         {"REAL", "LIMIT(0.0, 0.5, 1.0)", "0.5"}};
  static constexpr FunctionSpec spec{
      .name = "LIMIT",
      .t_categories = core::kAnyElementary,
      .params = {{"MN", kT}, {"IN", kT}, {"MX", kT}},
      .param_count = 3,
      .result = kT,
      .events = events(Event::kTruncated),
      .clause = kSelectionClause,
      .summary = "IN held within MN .. MX: MIN(MAX(IN, MN), MX), so MX wins when MN is greater.",
      .examples = examples};
  template <class V>
  static V eval(V mn, V in, V mx, Event&) noexcept {
    return stdlib::limit(mn, in, mx);
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &ternary<Limit, ValueOf<T>>;
};

struct Mux {
  static constexpr Example examples[] = {{"DINT,INT", "MUX(2, 10, 20, 30)", "30"},
                                         {"DINT,INT", "MUX(-1, 10, 20)", "event:bad_index 10"},
                                         {"DINT,USINT", "MUX(7, 10, 20)", "event:bad_index 20"}};
  static constexpr FunctionSpec spec{
      .name = "MUX",
      .t_categories = core::kAnyElementary,
      .u_categories = core::kAnyInt,
      .params = {{"K", kU}, {"IN0", kT}, {"IN1", kT}},
      .param_count = 3,
      .extensible = true,
      .result = kT,
      .events = events(Event::kBadIndex, Event::kTruncated),
      .clause = kSelectionClause,
      .summary = "The input numbered K, counted from 0; outside, the first or last one with an event.",
      .examples = examples};
  /// Moving is all there is to it, so it depends on the representation of T, and K is read by its own.
  template <class V, class K>
  static Event call(void* result, const void* const* args, std::uint32_t count) noexcept {
    const K k = load<K>(args[0]);
    const std::uint64_t inputs = count - 1;
    Event event = Event::kNone;
    auto index = static_cast<std::uint64_t>(k);
    if (k < K{0} || index >= inputs) {
      event = Event::kBadIndex;
      index = k < K{0} ? 0 : inputs - 1;
    }
    return either(event, store(result, load<V>(args[1 + index])));
  }
  template <TypeId T, TypeId U>
  static constexpr Kernel kernel = &call<ValueOf<T>, ValueOf<U>>;
};

// ---- SWITCH: one row per output, found by the bundle alone

#define PLC_SWITCH_OUTPUT(n)                                                                                  \
  struct Switch##n {                                                                                          \
    static constexpr Example examples[] = {{"", "SWITCH.S" #n "(" #n ")", "TRUE"},                            \
                                           {"", "SWITCH.S" #n "(-1)", "FALSE"}};                              \
    static constexpr FunctionSpec spec{.name = "SWITCH.S" #n,                                                 \
                                       .params = {{"K", fixed(TypeId::kDint)}},                               \
                                       .param_count = 1,                                                      \
                                       .result = fixed(TypeId::kBool),                                        \
                                       .clause = kSwitchClause,                                               \
                                       .summary = "Whether K is " #n ".",                                     \
                                       .examples = examples};                                                 \
    static std::uint8_t eval(std::int32_t k, Event&) noexcept { return static_cast<std::uint8_t>(k == (n)); } \
    template <TypeId, TypeId>                                                                                 \
    static constexpr Kernel kernel = &unary<Switch##n, std::int32_t>;                                         \
  }
inline constexpr std::string_view kSwitchClause = "not in the standard; PICARD's own";
PLC_SWITCH_OUTPUT(0);
PLC_SWITCH_OUTPUT(1);
PLC_SWITCH_OUTPUT(2);
PLC_SWITCH_OUTPUT(3);
PLC_SWITCH_OUTPUT(4);
PLC_SWITCH_OUTPUT(5);
PLC_SWITCH_OUTPUT(6);
PLC_SWITCH_OUTPUT(7);
#undef PLC_SWITCH_OUTPUT

using SelectionRows =
    Rows<Move, Sel, Max, Min, Limit, Mux, Switch0, Switch1, Switch2, Switch3, Switch4, Switch5, Switch6, Switch7>;

inline constexpr const FunctionSpec* kSwitchOutputs[] = {&Switch0::spec, &Switch1::spec, &Switch2::spec,
                                                         &Switch3::spec, &Switch4::spec, &Switch5::spec,
                                                         &Switch6::spec, &Switch7::spec};

inline constexpr BundleSpec kSelectionBundles[] = {{"SWITCH",
                                                    {"K", fixed(TypeId::kDint)},
                                                    kSwitchOutputs,
                                                    kSwitchClause,
                                                    "TRUE at the output that K numbers, FALSE at all others: wired to "
                                                    "EN of blocks, one group of them runs. Any other K "
                                                    "runs none.",
                                                    "SWITCH(K := mode, S0 => manual, S1 => automatic);"}};

}  // namespace plc::stdlib::rows
