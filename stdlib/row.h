// What a row of the library is made of: adapters that turn a typed `eval` into a Kernel, and short names for
// parameters.
//
// A row is a struct with `static constexpr FunctionSpec spec`, the meaning (`eval`, a template over the value type) and
// `template <TypeId T, TypeId U> static constexpr Kernel kernel`, which picks the adapter. Optional: `accepts(t, u)`
// narrows the product of the categories, `name_of(t, u)` and `kernel_of(t, u)` serve conversions. Only library.cpp
// expands rows.
// Values are C++ values; strings are views into the table, so a kernel may return one of its arguments.
#pragma once

#include <array>
#include <cstddef>
#include <cstring>
#include <string_view>
#include <type_traits>

#include "core/types.h"
#include "stdlib/library.h"
#include "stdlib/strings.h"

namespace plc::stdlib {

inline constexpr ParamType kT{ParamType::Kind::kT, TypeId::kBool};
inline constexpr ParamType kU{ParamType::Kind::kU, TypeId::kBool};
constexpr ParamType fixed(TypeId type) { return {ParamType::Kind::kFixed, type}; }

/// A list of rows; every header of rows ends with one, library.cpp and blocks.cpp expand them.
template <class... R>
struct Rows {};

/// A list of rows under a title for people: "Comparison".
template <class List>
struct Titled;
template <class... R>
struct Titled<Rows<R...>> {
  static constexpr std::size_t kCount = sizeof...(R);
  std::string_view title;
};

/// What `eval` sees of a value of type `Id`.
template <TypeId Id>
using ValueOf =
    std::conditional_t<core::rep_of(Id) == Rep::kStr, std::string_view,
                       std::conditional_t<core::rep_of(Id) == Rep::kWstr, std::u16string_view, core::cpp_of<Id>>>;

/// `Base` and the name of a type, as a constant: "CTU_" and DINT.
template <const std::string_view& Base, TypeId T>
struct TypedName {
  static constexpr std::size_t kSize = Base.size() + core::name_of(T).size();
  static constexpr std::array<char, kSize> kText = [] {
    std::array<char, kSize> out{};
    std::size_t n = 0;
    for (const char c : Base) out[n++] = c;
    for (const char c : core::name_of(T)) out[n++] = c;
    return out;
  }();
  static constexpr std::string_view value{kText.data(), kSize};
};

template <class V>
V load(const void* place) noexcept {
  if constexpr (std::is_class_v<V>) {
    return text_of<typename V::value_type>(place);
  } else {
    V value;
    std::memcpy(&value, place, sizeof value);
    return value;
  }
}
/// kTruncated when a string does not fit.
template <class V>
Event store(void* place, V value) noexcept {
  if constexpr (std::is_class_v<V>) {
    return write_text(place, value);
  } else {
    std::memcpy(place, &value, sizeof value);
    return Event::kNone;
  }
}
/// The first event that happened.
constexpr Event either(Event a, Event b) noexcept { return a != Event::kNone ? a : b; }

/// result := eval(a0, event). RT, as are all adapters.
template <class Row, class V>
Event unary(void* result, const void* const* args, std::uint32_t) noexcept {
  Event event = Event::kNone;
  const auto value = Row::eval(load<V>(args[0]), event);
  return either(event, store(result, value));
}
/// result := eval(a0, a1, event), of one or two types.
template <class Row, class V, class W = V>
Event binary(void* result, const void* const* args, std::uint32_t) noexcept {
  Event event = Event::kNone;
  const auto value = Row::eval(load<V>(args[0]), load<W>(args[1]), event);
  return either(event, store(result, value));
}
/// result := eval(a0, a1, a2, event), of up to three types.
template <class Row, class V, class W = V, class X = W>
Event ternary(void* result, const void* const* args, std::uint32_t) noexcept {
  Event event = Event::kNone;
  const auto value = Row::eval(load<V>(args[0]), load<W>(args[1]), load<X>(args[2]), event);
  return either(event, store(result, value));
}
/// result := eval(.. eval(eval(a0, a1), a2) ..): extensible functions.
template <class Row, class V>
Event folded(void* result, const void* const* args, std::uint32_t count) noexcept {
  Event event = Event::kNone;
  V value = load<V>(args[0]);
  for (std::uint32_t i = 1; i < count; ++i) value = Row::eval(value, load<V>(args[i]), event);
  return either(event, store(result, value));
}
/// result := holds(a0, a1) AND holds(a1, a2) AND ..: extensible comparisons.
template <class Row, class V>
Event chained(void* result, const void* const* args, std::uint32_t count) noexcept {
  bool all = true;
  for (std::uint32_t i = 1; i < count; ++i) all &= Row::holds(load<V>(args[i - 1]), load<V>(args[i]));
  return store(result, static_cast<std::uint8_t>(all));
}

}  // namespace plc::stdlib
