// What a row of the library is made of: adapters that turn a typed `eval` into a Kernel, and short names for parameters.
//
// A row is a struct with `static constexpr FunctionSpec spec`, the meaning (`eval`, a template over the value type) and
// `template <TypeId T, TypeId U> static constexpr Kernel kernel`, which picks the adapter. Optional: `accepts(t, u)`
// narrows the product of the categories, `name<T, U>` gives conversions their names. Only library.cpp expands rows.
#pragma once

#include <cstddef>
#include <cstring>
#include <type_traits>
#include <utility>

#include "core/types.h"
#include "stdlib/library.h"

namespace plc::stdlib {

inline constexpr ParamType kT{ParamType::Kind::kT, TypeId::kBool};
inline constexpr ParamType kU{ParamType::Kind::kU, TypeId::kBool};
constexpr ParamType fixed(TypeId type) { return {ParamType::Kind::kFixed, type}; }

template <TypeId Id>
using ValueOf = core::cpp_of<Id>;

template <class V>
V load(const void* place) noexcept {
  V value;
  std::memcpy(&value, place, sizeof value);
  return value;
}
template <class V>
void store(void* place, V value) noexcept {
  std::memcpy(place, &value, sizeof value);
}

/// result := eval(a0, event). RT, as are all adapters.
template <class Row, class V>
Event unary(void* result, const void* const* args, std::uint32_t) noexcept {
  Event event = Event::kNone;
  store(result, Row::eval(load<V>(args[0]), event));
  return event;
}
/// result := eval(a0, a1, event), of one or two types.
template <class Row, class V, class W = V>
Event binary(void* result, const void* const* args, std::uint32_t) noexcept {
  Event event = Event::kNone;
  store(result, Row::eval(load<V>(args[0]), load<W>(args[1]), event));
  return event;
}
/// result := eval(a0, a1, a2, event).
template <class Row, class V>
Event ternary(void* result, const void* const* args, std::uint32_t) noexcept {
  Event event = Event::kNone;
  store(result, Row::eval(load<V>(args[0]), load<V>(args[1]), load<V>(args[2]), event));
  return event;
}
/// result := eval(.. eval(eval(a0, a1), a2) ..): extensible functions.
template <class Row, class V>
Event folded(void* result, const void* const* args, std::uint32_t count) noexcept {
  Event event = Event::kNone;
  V sum = load<V>(args[0]);
  for (std::uint32_t i = 1; i < count; ++i) sum = Row::eval(sum, load<V>(args[i]), event);
  store(result, sum);
  return event;
}
/// result := holds(a0, a1) AND holds(a1, a2) AND ..: extensible comparisons.
template <class Row, class V>
Event chained(void* result, const void* const* args, std::uint32_t count) noexcept {
  bool all = true;
  for (std::uint32_t i = 1; i < count; ++i) all &= Row::holds(load<V>(args[i - 1]), load<V>(args[i]));
  store(result, static_cast<std::uint8_t>(all));
  return Event::kNone;
}

}  // namespace plc::stdlib
