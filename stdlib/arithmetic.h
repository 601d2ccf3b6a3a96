// Arithmetic on IEC values: the one place where raw integer and real arithmetic is written (docs/guides/values.md).
//
// In: operands. Out: results, defined for every operand: integers wrap, shifts are bounded, divisions by zero and
// conversions out of range report an Event, every NaN is the canonical one. Kernels and the interpreter share these.
// Does not belong here: text, tables, opcodes.
#pragma once

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>

#include "stdlib/library.h"

namespace plc::stdlib {

/// Unsigned type of at least 32 bits that holds T: small types would be promoted to int, whose overflow is undefined.
template <class T>
using WideUnsigned = std::conditional_t<sizeof(T) <= 4, std::uint32_t, std::uint64_t>;

// ---- integers: two's complement, modulo 2^width -----------------------------------------------------------------

template <class T>
constexpr T wrap_add(T a, T b) noexcept {
  return static_cast<T>(static_cast<WideUnsigned<T>>(a) + static_cast<WideUnsigned<T>>(b));
}
template <class T>
constexpr T wrap_sub(T a, T b) noexcept {
  return static_cast<T>(static_cast<WideUnsigned<T>>(a) - static_cast<WideUnsigned<T>>(b));
}
template <class T>
constexpr T wrap_mul(T a, T b) noexcept {
  return static_cast<T>(static_cast<WideUnsigned<T>>(a) * static_cast<WideUnsigned<T>>(b));
}
template <class T>
constexpr T wrap_neg(T a) noexcept {
  return wrap_sub(T{}, a);
}
/// Truncates toward zero. Division by zero is 0 with an event; the least value divided by -1 wraps to itself.
template <class T>
constexpr T div_wrap(T a, T b, Event& event) noexcept {
  if (b == 0) {
    event = Event::kDivideByZero;
    return 0;
  }
  if constexpr (std::is_signed_v<T>) {
    if (b == -1) return wrap_neg(a);
  }
  return static_cast<T>(a / b);
}
/// Sign of the dividend; 0 for a zero divisor (the standard's own rule, so no event).
template <class T>
constexpr T mod_wrap(T a, T b) noexcept {
  if (b == 0) return 0;
  if constexpr (std::is_signed_v<T>) {
    if (b == -1) return 0;
  }
  return static_cast<T>(a % b);
}

/// `base` to the power `exponent`, the low bits of it. Below 0 it is 1 / base^n, toward zero: 0 but for 1 and -1; of 0
/// it is a division by zero.
template <class T, class N>
constexpr T power_wrap(T base, N exponent, Event& event) noexcept {
  if constexpr (std::is_signed_v<N>) {
    if (exponent < 0) {
      if (base == 0) {
        event = Event::kDivideByZero;
        return 0;
      }
      if (base == 1) return 1;
      if constexpr (std::is_signed_v<T>) {
        if (base == -1) return (exponent & 1) != 0 ? T{-1} : T{1};
      }
      return 0;
    }
  }
  T result = 1;
  for (auto n = static_cast<std::uint64_t>(exponent); n != 0; n >>= 1) {
    if ((n & 1) != 0) result = wrap_mul(result, base);
    base = wrap_mul(base, base);
  }
  return result;
}

// ---- reals: IEEE 754, one NaN -----------------------------------------------------------------------------------

/// `v`, or the canonical quiet NaN (positive, 0x7fc00000 or 0x7ff8000000000000) if it is any NaN.
/// By a jump: choosing one of two values takes three times as long as the addition before it.
constexpr float canonical(float v) noexcept {
  if (v != v) [[unlikely]] {
    if (!std::is_constant_evaluated()) asm("");  // what the compiler may not choose between
    return std::bit_cast<float>(0x7fc00000u);
  }
  return v;
}
constexpr double canonical(double v) noexcept {
  if (v != v) [[unlikely]] {
    if (!std::is_constant_evaluated()) asm("");
    return std::bit_cast<double>(0x7ff8000000000000ull);
  }
  return v;
}

constexpr bool is_finite(double v) noexcept { return v - v == 0; }

inline constexpr double kAllIntegers = 4503599627370496.0;  // from 2^52 on every double is an integer

/// Nearest integer of |v| < 2^52, ties to even (the mode in which threads begin). No jump: what is after the point of
/// measured values cannot be predicted.
constexpr std::int64_t nearest_integer(double v) noexcept {
#ifdef __SSE2__
  if (!std::is_constant_evaluated()) return _mm_cvtsd_si64(_mm_set_sd(v));
#endif
  const auto bits = std::bit_cast<std::int64_t>(v);
  const auto magnitude = std::bit_cast<double>(bits & std::numeric_limits<std::int64_t>::max());
  const auto whole = static_cast<std::int64_t>(magnitude);
  // Doubles from 0 on are in the order of their bits: those above a half, for odd numbers from a half on.
  const auto rest = std::bit_cast<std::int64_t>(magnitude - static_cast<double>(whole));
  const std::int64_t nearest = whole + ((rest + (whole & 1) > std::bit_cast<std::int64_t>(0.5)) ? 1 : 0);
  const std::int64_t sign = bits >> 63;
  return (nearest ^ sign) - sign;
}
/// The same for all, as the double that holds it. Infinities and NaN stay.
constexpr double round_half_even(double v) noexcept {
  return v > -kAllIntegers && v < kAllIntegers ? static_cast<double>(nearest_integer(v)) : v;
}
/// The integer part of `v` held within T: out of range saturates and NaN is 0, both with an event.
template <class T>
constexpr T saturate_cast(double v, Event& event) noexcept {
  constexpr auto kAbove = 2.0 * static_cast<double>((std::numeric_limits<T>::max() >> 1) + 1);
  constexpr auto kLeast = static_cast<double>(std::numeric_limits<T>::min());
  if (v != v) {
    event = Event::kOutOfRange;
    return 0;
  }
  const bool has_fraction = v > -kAllIntegers && v < kAllIntegers;
  const double whole = has_fraction ? static_cast<double>(static_cast<std::int64_t>(v)) : v;
  if (whole >= kAbove) {
    event = Event::kOutOfRange;
    return std::numeric_limits<T>::max();
  }
  if (whole < kLeast) {
    event = Event::kOutOfRange;
    return std::numeric_limits<T>::min();
  }
  return static_cast<T>(whole);
}
/// REAL to integer: rounds half to even, saturates with an event, NaN gives 0 with an event.
template <class T>
constexpr T real_to_int(double v, Event& event) noexcept {
#ifdef __SSE2__
  if (!std::is_constant_evaluated()) {
    // What does not fit into 64 bits, and NaN, becomes the least of them.
    const std::int64_t whole = _mm_cvtsd_si64(_mm_set_sd(v));
    if (std::in_range<T>(whole) && whole != std::numeric_limits<std::int64_t>::min()) [[likely]]
      return static_cast<T>(whole);
    return saturate_cast<T>(round_half_even(v), event);
  }
#endif
  if (v > -kAllIntegers && v < kAllIntegers) [[likely]] {
    const std::int64_t whole = nearest_integer(v);
    if (std::in_range<T>(whole)) [[likely]]
      return static_cast<T>(whole);
  }
  return saturate_cast<T>(round_half_even(v), event);
}

// ---- counts times and by reals: exact, then rounded once ----------------------------------------------------------

__extension__ using WideBits = unsigned __int128;

/// A finite number taken apart: (-1)^negative * mantissa * 2^exponent, mantissa < 2^53.
struct RealParts {
  bool negative;
  std::uint64_t mantissa;
  int exponent;
};
constexpr RealParts parts_of(double v) noexcept {
  constexpr std::uint64_t kImplicit = std::uint64_t{1} << 52;
  const auto bits = std::bit_cast<std::uint64_t>(v);
  const auto biased = static_cast<int>(bits >> 52 & 0x7ff);
  const std::uint64_t fraction = bits & (kImplicit - 1);
  return {bits >> 63 != 0, biased == 0 ? fraction : fraction | kImplicit, (biased == 0 ? 1 : biased) - 1075};
}
constexpr std::uint64_t magnitude(std::int64_t v) noexcept {
  return v < 0 ? std::uint64_t{0} - static_cast<std::uint64_t>(v) : static_cast<std::uint64_t>(v);
}
/// (-1)^negative * n / d * 2^exponent to the nearest integer, half to even; out of 64 bits the nearest with an event.
/// For n < 2^117 and 0 < d < 2^53: there everything is exact in 128 bits, or the result is known without them.
constexpr std::int64_t round_ratio(bool negative, WideBits n, WideBits d, int exponent, Event& event) noexcept {
  constexpr auto bits_of = [](WideBits v) {
    const auto high = static_cast<std::uint64_t>(v >> 64);
    return high != 0 ? 64 + static_cast<int>(std::bit_width(high))
                     : static_cast<int>(std::bit_width(static_cast<std::uint64_t>(v)));
  };
  constexpr int kRoom = 126;
  if (n == 0 || (exponent < 0 && bits_of(d) - exponent > kRoom)) return 0;
  const bool beyond = exponent > 0 && bits_of(n) + exponent > kRoom;
  if (exponent < 0) {
    d <<= -exponent;
  } else if (!beyond) {
    n <<= exponent;
  }
  const WideBits rest = n % d;
  const WideBits whole = n / d;
  const WideBits rounded = whole + (rest > d - rest || (rest == d - rest && (whole & 1) != 0) ? 1 : 0);
  const std::uint64_t limit = magnitude(std::numeric_limits<std::int64_t>::min()) - (negative ? 0 : 1);
  if (beyond || rounded > limit) {
    event = Event::kOutOfRange;
    return negative ? std::numeric_limits<std::int64_t>::min() : std::numeric_limits<std::int64_t>::max();
  }
  const auto count = static_cast<std::int64_t>(static_cast<std::uint64_t>(rounded));
  return negative ? wrap_neg(count) : count;
}
/// The product, exact before it is rounded half to even; saturates with an event, NaN is 0 with an event.
constexpr std::int64_t multiply_rounded(std::int64_t count, double factor, Event& event) noexcept {
  if (!is_finite(factor)) return real_to_int<std::int64_t>(static_cast<double>(count) * factor, event);
  const RealParts f = parts_of(factor);
  return round_ratio((count < 0) != f.negative, WideBits{magnitude(count)} * f.mantissa, 1, f.exponent, event);
}
/// The quotient by a divisor other than 0, as multiply_rounded.
constexpr std::int64_t divide_rounded(std::int64_t count, double divisor, Event& event) noexcept {
  if (!is_finite(divisor)) return real_to_int<std::int64_t>(static_cast<double>(count) / divisor, event);
  const RealParts d = parts_of(divisor);
  return round_ratio((count < 0) != d.negative, magnitude(count), d.mantissa, -d.exponent, event);
}
/// `count` / `divisor` as the nearest real: the quotient has 63 bits, of which the last stands for all that follow, and
/// is rounded once. For divisors from 2^19 to 2^20.
template <class Real>
Real nearest_ratio(std::int64_t count, std::uint64_t divisor) noexcept {
  if (count == 0) return 0;
  const int shift = 83 - static_cast<int>(std::bit_width(magnitude(count)));
  const WideBits scaled = WideBits{magnitude(count)} << shift;
  const auto quotient = static_cast<std::uint64_t>(scaled / divisor);
  const bool is_cut = WideBits{quotient} * divisor != scaled;
  const Real size = std::ldexp(static_cast<Real>(quotient | (is_cut ? 1u : 0u)), -shift);
  return count < 0 ? -size : size;
}

// ---- either: what the rows and the opcodes call -----------------------------------------------------------------

template <class T>
constexpr T add(T a, T b) noexcept {
  if constexpr (std::is_floating_point_v<T>) {
    return canonical(a + b);
  } else {
    return wrap_add(a, b);
  }
}
template <class T>
constexpr T sub(T a, T b) noexcept {
  if constexpr (std::is_floating_point_v<T>) {
    return canonical(a - b);
  } else {
    return wrap_sub(a, b);
  }
}
template <class T>
constexpr T mul(T a, T b) noexcept {
  if constexpr (std::is_floating_point_v<T>) {
    return canonical(a * b);
  } else {
    return wrap_mul(a, b);
  }
}
/// Integers as div_wrap; reals as IEEE 754 (x / 0 is an infinity or NaN, no event).
template <class T>
constexpr T div(T a, T b, Event& event) noexcept {
  if constexpr (std::is_floating_point_v<T>) {
    return canonical(a / b);
  } else {
    return div_wrap(a, b, event);
  }
}
template <class T>
constexpr T neg(T a) noexcept {
  if constexpr (std::is_floating_point_v<T>) {
    return canonical(-a);
  } else {
    return wrap_neg(a);
  }
}
/// Magnitude; the least integer wraps to itself.
template <class T>
constexpr T abs(T a) noexcept {
  if constexpr (std::is_floating_point_v<T>) {
    using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
    return canonical(std::bit_cast<T>(static_cast<Bits>(std::bit_cast<Bits>(a) & (static_cast<Bits>(-1) >> 1))));
  } else if constexpr (std::is_signed_v<T>) {
    return a < 0 ? wrap_neg(a) : a;
  } else {
    return a;
  }
}

/// The least and the greatest of two, the first of equal ones; a NaN after another value is passed over.
template <class T>
constexpr T least(T a, T b) noexcept {
  return b < a ? b : a;
}
template <class T>
constexpr T greatest(T a, T b) noexcept {
  return a < b ? b : a;
}
/// `in` within `mn` .. `mx`; `mx` wins when `mn` is greater.
template <class T>
constexpr T limit(T mn, T in, T mx) noexcept {
  return least(greatest(in, mn), mx);
}

// ---- bit strings ------------------------------------------------------------------------------------------------

template <class T>
inline constexpr unsigned kBits = sizeof(T) * 8;

/// Shifts fill with zeros; by the width or more the result is 0.
template <class T>
constexpr T shift_left(T v, std::uint64_t n) noexcept {
  return n >= kBits<T> ? T{} : static_cast<T>(static_cast<std::uint64_t>(v) << n);
}
template <class T>
constexpr T shift_right(T v, std::uint64_t n) noexcept {
  return n >= kBits<T> ? T{} : static_cast<T>(static_cast<std::uint64_t>(v) >> n);
}
/// Rotations count modulo the width.
template <class T>
constexpr T rotate_left(T v, std::uint64_t n) noexcept {
  return std::rotl(v, static_cast<int>(n % kBits<T>));
}
template <class T>
constexpr T rotate_right(T v, std::uint64_t n) noexcept {
  return std::rotr(v, static_cast<int>(n % kBits<T>));
}

}  // namespace plc::stdlib
