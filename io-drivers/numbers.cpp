#include "io-drivers/numbers.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

namespace plc::io {
namespace {

template <class T>
void put(double number, std::byte* value) {
  T whole{};
  if constexpr (std::is_floating_point_v<T>) {
    whole = static_cast<T>(number);
  } else if (std::isnan(number)) {
    whole = 0;
  } else {
    // The greatest LREAL that every integer of the type is at most is beyond the greatest of 64 bits.
    const double rounded = std::nearbyint(number);
    constexpr auto kLowest = static_cast<double>(std::numeric_limits<T>::lowest());
    constexpr auto kHighest = static_cast<double>(std::numeric_limits<T>::max());
    whole = rounded <= kLowest    ? std::numeric_limits<T>::lowest()
            : rounded >= kHighest ? std::numeric_limits<T>::max()
                                  : static_cast<T>(rounded);
  }
  std::memcpy(value, &whole, sizeof whole);
}
template <class T>
double get(const std::byte* value) {
  T whole;
  std::memcpy(&whole, value, sizeof whole);
  return static_cast<double>(whole);
}

/// Calls what(T{}) with the type that has values of this representation.
template <class What>
auto with_type(core::Rep rep, What what) {
  switch (rep) {
    case core::Rep::kI8:
      return what(std::int8_t{});
    case core::Rep::kI16:
      return what(std::int16_t{});
    case core::Rep::kU16:
      return what(std::uint16_t{});
    case core::Rep::kI32:
      return what(std::int32_t{});
    case core::Rep::kU32:
      return what(std::uint32_t{});
    case core::Rep::kI64:
      return what(std::int64_t{});
    case core::Rep::kU64:
      return what(std::uint64_t{});
    case core::Rep::kF32:
      return what(float{});
    case core::Rep::kF64:
      return what(double{});
    default:  // BOOL, too
      return what(std::uint8_t{});
  }
}

}  // namespace

void store_number(core::TypeId type, double number, std::byte* value) noexcept {
  if (type == core::TypeId::kBool) number = number != 0 && !std::isnan(number) ? 1 : 0;
  with_type(core::rep_of(type), [&](auto t) { put<decltype(t)>(number, value); });
}

double load_number(core::TypeId type, const std::byte* value) noexcept {
  return with_type(core::rep_of(type), [&](auto t) { return get<decltype(t)>(value); });
}

}  // namespace plc::io
