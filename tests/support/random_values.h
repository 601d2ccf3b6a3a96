// Random numbers and values for generated programs: mostly those at which something changes.
//
// In: a seed, types of an image. Out: numbers, the bytes of values. Does not belong here: programs, places.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include "bytecode/image.h"
#include "core/types.h"

namespace plc::test {

/// The same on every machine (splitmix64), and ready at once.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed * 0xd1342543de82ef95u + 1) {}
  std::uint64_t bits() {
    std::uint64_t x = state_ += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }
  /// 0 .. n-1
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(bits() % n); }
  /// True in one of `n` calls.
  bool once_in(std::size_t n) { return below(n) == 0; }
  template <class T>
  const T& one_of(const std::vector<T>& items) {
    return items[below(items.size())];
  }
  template <class T, std::size_t n>
  const T& one_of(const T (&items)[n]) {
    return items[below(n)];
  }

 private:
  std::uint64_t state_;
};

template <class T>
T random_integer(Random& random) {
  static constexpr T kEdges[] = {
      0, 1, static_cast<T>(-1), 2, 3, 7, std::numeric_limits<T>::min(), std::numeric_limits<T>::max()};
  if (random.below(3) == 0) return static_cast<T>(random.bits() >> random.below(64));
  return random.one_of(kEdges);
}

template <class T>
T random_real(Random& random) {
  using Limits = std::numeric_limits<T>;
  static constexpr T kEdges[] = {0,
                                 static_cast<T>(-0.0),
                                 1,
                                 static_cast<T>(-2.5),
                                 static_cast<T>(0.5),
                                 Limits::infinity(),
                                 -Limits::infinity(),
                                 Limits::quiet_NaN(),
                                 Limits::max(),
                                 Limits::lowest(),
                                 Limits::min(),
                                 Limits::denorm_min(),
                                 static_cast<T>(2147483648.0),
                                 static_cast<T>(-9223372036854775808.0),
                                 static_cast<T>(18446744073709551615.0)};
  if (random.below(3) == 0) return static_cast<T>(static_cast<std::int32_t>(random.bits())) / 1000;
  return random.one_of(kEdges);
}

/// Durations that timers come to in a few cycles, and others.
inline std::int64_t random_duration(Random& random) {
  return random.below(3) == 0 ? random_integer<std::int64_t>(random)
                              : static_cast<std::int64_t>(random.below(8)) * 10'000'000;
}

/// Writes a value of a scalar or string type, within its limits. A string's header is there already.
inline void random_value(const bytecode::ImageType& type, Random& random, std::byte* to) {
  const auto put = [to](auto value) { std::memcpy(to, &value, sizeof value); };
  const auto integer = [&](auto zero) {
    using T = decltype(zero);
    if (!type.limited) return put(random_integer<T>(random));
    const auto count = static_cast<std::uint64_t>(type.upper) - static_cast<std::uint64_t>(type.lower) + 1;
    put(static_cast<T>(static_cast<std::uint64_t>(type.lower) + (count == 0 ? random.bits() : random.bits() % count)));
  };
  const auto text = [&](auto unit) {
    core::StringHeader header;
    std::memcpy(&header, to, sizeof header);
    header.length = static_cast<std::uint16_t>(random.below(header.capacity + std::size_t{1}));
    std::memcpy(to, &header, sizeof header);
    static constexpr char kCharacters[] = "0123456789abAB .-+#";
    for (std::size_t i = 0; i < header.length; ++i) {
      unit = static_cast<decltype(unit)>(kCharacters[random.below(sizeof kCharacters - 1)]);
      std::memcpy(to + sizeof header + i * sizeof unit, &unit, sizeof unit);
    }
  };
  if (type.kind == bytecode::TypeKind::kString) {
    return type.elementary == core::TypeId::kWstring ? text(char16_t{}) : text(char{});
  }
  if (type.elementary == core::TypeId::kTime || type.elementary == core::TypeId::kLtime) {
    return put(random_duration(random));
  }
  switch (core::rep_of(type.elementary)) {
    case core::Rep::kBool:
      return put(static_cast<std::uint8_t>(random.below(2)));
    case core::Rep::kI8:
      return integer(std::int8_t{});
    case core::Rep::kU8:
      return integer(std::uint8_t{});
    case core::Rep::kI16:
      return integer(std::int16_t{});
    case core::Rep::kU16:
      return integer(std::uint16_t{});
    case core::Rep::kI32:
      return integer(std::int32_t{});
    case core::Rep::kU32:
      return integer(std::uint32_t{});
    case core::Rep::kI64:
      return integer(std::int64_t{});
    case core::Rep::kU64:
      return integer(std::uint64_t{});
    case core::Rep::kF32:
      return put(random_real<float>(random));
    case core::Rep::kF64:
      return put(random_real<double>(random));
    default:
      return;
  }
}

}  // namespace plc::test
