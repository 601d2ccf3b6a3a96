// Rows: character strings (IEC 61131-3:2013, table 34). Positions count from 1; STRING counts bytes, WSTRING UTF-16
// units.
//
// Lengths beyond the end mean "to the end". A negative length counts as 0 and a position outside the string selects
// nothing, both with kOutOfRange; a result longer than its variable is cut with kTruncated.
#pragma once

#include <array>

#include "stdlib/row.h"

namespace plc::stdlib::rows {

inline constexpr std::string_view kStringClause = "IEC 61131-3:2013, table 34";

/// A length: negative ones are 0 with an event.
template <class N>
std::size_t length_of(N n, Event& event) noexcept {
  if (n < N{0}) {
    event = Event::kOutOfRange;
    return 0;
  }
  return static_cast<std::size_t>(n);
}
/// Characters before position `p`, or an event and false when `p` is not in 1 .. `last`.
template <class N>
bool offset_of_position(N p, std::size_t last, std::size_t& offset, Event& event) noexcept {
  if (p < N{1} || static_cast<std::uint64_t>(p) > last) {
    event = Event::kOutOfRange;
    return false;
  }
  offset = static_cast<std::size_t>(p) - 1;
  return true;
}
/// The numbers after the strings are of one type U, widened by the caller; the kernels read them by that type.
template <TypeId U>
std::int64_t number(const void* place) noexcept {
  const auto n = load<ValueOf<U>>(place);
  constexpr auto kMax = std::numeric_limits<std::int64_t>::max();
  if constexpr (std::is_same_v<ValueOf<U>, std::uint64_t>) {
    return n > static_cast<std::uint64_t>(kMax) ? kMax : static_cast<std::int64_t>(n);
  } else {
    return n;
  }
}
template <TypeId T>
using CharOf = typename ValueOf<T>::value_type;

struct Len {
  static constexpr Example examples[] = {{"STRING", "LEN('ASTRING')", "7"}, {"WSTRING", "LEN(\"\")", "0"}};
  static constexpr FunctionSpec spec{.name = "LEN",
                                     .t_categories = core::kAnyString,
                                     .params = {{"IN", kT, "STR"}},
                                     .param_count = 1,
                                     .result = fixed(TypeId::kInt),
                                     .clause = kStringClause,
                                     .summary = "Characters in IN.",
                                     .examples = examples};
  template <class V>
  static std::int16_t eval(V in, Event&) noexcept {
    return static_cast<std::int16_t>(in.size());
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &unary<Len, ValueOf<T>>;
};

struct Left {
  static constexpr Example examples[] = {{"STRING,INT", "LEFT('ASTR', 3)", "'AST'"},
                                         {"STRING,INT", "LEFT('ASTR', -1)", "event:out_of_range ''"}};
  static constexpr FunctionSpec spec{.name = "LEFT",
                                     .t_categories = core::kAnyString,
                                     .u_categories = core::kAnyInt,
                                     .params = {{"IN", kT, "STR"}, {"L", kU, "SIZE"}},
                                     .param_count = 2,
                                     .result = kT,
                                     .events = events(Event::kOutOfRange, Event::kTruncated),
                                     .clause = kStringClause,
                                     .summary = "The first L characters of IN.",
                                     .examples = examples};
  template <class V, class N>
  static V eval(V in, N l, Event& event) noexcept {
    return in.substr(0, length_of(l, event));
  }
  template <TypeId T, TypeId U>
  static constexpr Kernel kernel = &binary<Left, ValueOf<T>, ValueOf<U>>;
};

struct Right {
  static constexpr Example examples[] = {{"STRING,INT", "RIGHT('ASTR', 3)", "'STR'"},
                                         {"WSTRING,UINT", "RIGHT(\"ab\", 5)", "\"ab\""}};
  static constexpr FunctionSpec spec{.name = "RIGHT",
                                     .t_categories = core::kAnyString,
                                     .u_categories = core::kAnyInt,
                                     .params = {{"IN", kT, "STR"}, {"L", kU, "SIZE"}},
                                     .param_count = 2,
                                     .result = kT,
                                     .events = events(Event::kOutOfRange, Event::kTruncated),
                                     .clause = kStringClause,
                                     .summary = "The last L characters of IN.",
                                     .examples = examples};
  template <class V, class N>
  static V eval(V in, N l, Event& event) noexcept {
    const std::size_t length = std::min(length_of(l, event), in.size());
    return in.substr(in.size() - length);
  }
  template <TypeId T, TypeId U>
  static constexpr Kernel kernel = &binary<Right, ValueOf<T>, ValueOf<U>>;
};

struct Mid {
  static constexpr Example examples[] = {{"STRING,INT", "MID('ASTR', 2, 2)", "'ST'"},
                                         {"STRING,INT", "MID('ASTR', 2, 5)", "event:out_of_range ''"}};
  static constexpr FunctionSpec spec{.name = "MID",
                                     .t_categories = core::kAnyString,
                                     .u_categories = core::kAnyInt,
                                     .params = {{"IN", kT, "STR"}, {"L", kU, "LEN"}, {"P", kU, "POS"}},
                                     .param_count = 3,
                                     .result = kT,
                                     .events = events(Event::kOutOfRange, Event::kTruncated),
                                     .clause = kStringClause,
                                     .summary = "L characters of IN from position P on.",
                                     .examples = examples};
  template <class V, class N>
  static V eval(V in, N l, N p, Event& event) noexcept {
    std::size_t at = 0;
    const std::size_t length = length_of(l, event);
    if (!offset_of_position(p, in.size(), at, event)) return {};
    return in.substr(at, length);
  }
  template <TypeId T, TypeId U>
  static constexpr Kernel kernel = &ternary<Mid, ValueOf<T>, ValueOf<U>>;
};

struct Concat {
  static constexpr Example examples[] = {{"STRING", "CONCAT('AB', 'CD', 'E')", "'ABCDE'"}};
  static constexpr FunctionSpec spec{.name = "CONCAT",
                                     .t_categories = core::kAnyString,
                                     .params = {{"IN1", kT, "STR1"}, {"IN2", kT, "STR2"}},
                                     .param_count = 2,
                                     .extensible = true,
                                     .result = kT,
                                     .events = events(Event::kTruncated),
                                     .clause = kStringClause,
                                     .summary = "The inputs one after another.",
                                     .examples = examples};
  template <class V>
  static Event call(void* result, const void* const* args, std::uint32_t count) noexcept {
    std::array<V, kMaxArguments> pieces;
    const std::size_t n = std::min<std::size_t>(count, kMaxArguments);
    for (std::size_t i = 0; i < n; ++i) pieces[i] = load<V>(args[i]);
    return write_text<typename V::value_type>(result, std::span<const V>{pieces.data(), n});
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &call<ValueOf<T>>;
};

/// Writes in1[0, at) + middle + in1[at + cut, end).
template <class V>
Event splice(void* result, V in1, std::size_t at, std::size_t cut, V middle, Event event) noexcept {
  const V tail = in1.substr(at);
  const V pieces[] = {in1.substr(0, at), middle, tail.substr(std::min(cut, tail.size()))};
  return either(event, write_text<typename V::value_type>(result, std::span<const V>{pieces}));
}

struct Insert {
  static constexpr Example examples[] = {{"STRING,INT", "INSERT('ABC', 'XY', 2)", "'ABXYC'"},
                                         {"STRING,INT", "INSERT('ABC', 'XY', 0)", "'XYABC'"},
                                         {"STRING,INT", "INSERT('ABC', 'XY', 4)", "event:out_of_range 'ABC'"}};
  static constexpr FunctionSpec spec{.name = "INSERT",
                                     .t_categories = core::kAnyString,
                                     .u_categories = core::kAnyInt,
                                     .params = {{"IN1", kT, "STR1"}, {"IN2", kT, "STR2"}, {"P", kU, "POS"}},
                                     .param_count = 3,
                                     .result = kT,
                                     .events = events(Event::kOutOfRange, Event::kTruncated),
                                     .clause = kStringClause,
                                     .summary = "IN2 put into IN1 after position P; P = 0 puts it at the start.",
                                     .examples = examples};
  template <TypeId T, TypeId U>
  static Event call(void* result, const void* const* args, std::uint32_t) noexcept {
    using V = ValueOf<T>;
    const V in1 = load<V>(args[0]);
    const std::int64_t p = number<U>(args[2]);
    if (p < 0 || static_cast<std::uint64_t>(p) > in1.size())
      return splice<V>(result, in1, 0, 0, {}, Event::kOutOfRange);
    return splice<V>(result, in1, static_cast<std::size_t>(p), 0, load<V>(args[1]), Event::kNone);
  }
  template <TypeId T, TypeId U>
  static constexpr Kernel kernel = &call<T, U>;
};

struct Delete {
  static constexpr Example examples[] = {{"STRING,INT", "DELETE('ABXYC', 2, 3)", "'ABC'"},
                                         {"STRING,INT", "DELETE('ABC', 1, 0)", "event:out_of_range 'ABC'"}};
  static constexpr FunctionSpec spec{.name = "DELETE",
                                     .t_categories = core::kAnyString,
                                     .u_categories = core::kAnyInt,
                                     .params = {{"IN", kT, "STR"}, {"L", kU, "LEN"}, {"P", kU, "POS"}},
                                     .param_count = 3,
                                     .result = kT,
                                     .events = events(Event::kOutOfRange, Event::kTruncated),
                                     .clause = kStringClause,
                                     .summary = "IN without L characters from position P on.",
                                     .examples = examples};
  template <TypeId T, TypeId U>
  static Event call(void* result, const void* const* args, std::uint32_t) noexcept {
    using V = ValueOf<T>;
    const V in = load<V>(args[0]);
    Event event = Event::kNone;
    std::size_t at = 0;
    std::size_t cut = length_of(number<U>(args[1]), event);
    if (!offset_of_position(number<U>(args[2]), in.size(), at, event)) cut = 0;
    return splice<V>(result, in, at, cut, {}, event);
  }
  template <TypeId T, TypeId U>
  static constexpr Kernel kernel = &call<T, U>;
};

struct Replace {
  static constexpr Example examples[] = {{"STRING,INT", "REPLACE('ABCDE', 'X', 2, 3)", "'ABXE'"},
                                         {"WSTRING,INT", "REPLACE(\"ab\", \"x\", 1, 3)", "event:out_of_range \"ab\""}};
  static constexpr FunctionSpec spec{.name = "REPLACE",
                                     .t_categories = core::kAnyString,
                                     .u_categories = core::kAnyInt,
                                     .params = {{"IN1", kT, "STR1"}, {"IN2", kT, "STR2"}, {"L", kU}, {"P", kU}},
                                     .param_count = 4,
                                     .result = kT,
                                     .events = events(Event::kOutOfRange, Event::kTruncated),
                                     .clause = kStringClause,
                                     .summary = "IN1 with L characters from position P on replaced by IN2.",
                                     .examples = examples};
  template <TypeId T, TypeId U>
  static Event call(void* result, const void* const* args, std::uint32_t) noexcept {
    using V = ValueOf<T>;
    const V in1 = load<V>(args[0]);
    Event event = Event::kNone;
    std::size_t at = 0;
    const std::size_t cut = length_of(number<U>(args[2]), event);
    if (!offset_of_position(number<U>(args[3]), in1.size(), at, event)) return splice<V>(result, in1, 0, 0, {}, event);
    return splice<V>(result, in1, at, cut, load<V>(args[1]), event);
  }
  template <TypeId T, TypeId U>
  static constexpr Kernel kernel = &call<T, U>;
};

struct Find {
  static constexpr Example examples[] = {
      {"STRING", "FIND('ABCBC', 'BC')", "2"}, {"STRING", "FIND('ABC', 'X')", "0"}, {"STRING", "FIND('ABC', '')", "0"}};
  static constexpr FunctionSpec spec{.name = "FIND",
                                     .t_categories = core::kAnyString,
                                     .params = {{"IN1", kT, "STR1"}, {"IN2", kT, "STR2"}},
                                     .param_count = 2,
                                     .result = fixed(TypeId::kInt),
                                     .clause = kStringClause,
                                     .summary = "Position of the first IN2 in IN1, or 0; 0 for an empty IN2.",
                                     .examples = examples};
  template <class V>
  static std::int16_t eval(V in1, V in2, Event&) noexcept {
    if (in2.empty()) return 0;
    const std::size_t at = in1.find(in2);
    return at == V::npos ? std::int16_t{0} : static_cast<std::int16_t>(at + 1);
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &binary<Find, ValueOf<T>>;
};

using StringRows = Rows<Len, Left, Right, Mid, Concat, Insert, Delete, Replace, Find>;

}  // namespace plc::stdlib::rows
