// Typed values for the tests of the library: room in a "table", set from and compared with literals.
// The literal reader is deliberately not the library's own.
#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/types.h"
#include "stdlib/library.h"

namespace plc::test {

using core::Rep;
using core::TypeId;

inline std::int64_t seconds_of_date(int year, int month, int day) {
  std::int64_t days = 0;
  const auto leap = [](int y) { return (y % 4 == 0 && y % 100 != 0) || y % 400 == 0; };
  for (int y = 1970; y < year; ++y) days += leap(y) ? 366 : 365;
  for (int y = year; y < 1970; ++y) days -= leap(y) ? 366 : 365;
  constexpr int kDays[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  for (int m = 1; m < month; ++m) days += kDays[m - 1] + (m == 2 && leap(year) ? 1 : 0);
  return (days + day - 1) * 86400;
}

/// One value with its own memory; strings get a capacity of 40.
struct Value {
  static constexpr std::uint16_t kCapacity = 40;

  TypeId type;
  alignas(8) std::byte bytes[sizeof(core::StringHeader) + 2 * kCapacity] = {};

  explicit Value(TypeId t) : type(t) {
    if (is_string()) set(core::StringHeader{kCapacity, 0});
  }
  Value(TypeId t, const std::string& literal) : Value(t) { assign(literal); }

  [[nodiscard]] bool is_string() const { return core::in_category(type, core::kAnyString); }
  template <class T>
  void set(T value) {
    std::memcpy(bytes, &value, sizeof value);
  }
  template <class T>
  [[nodiscard]] T get() const {
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
  }

  void assign(const std::string& s) {
    if (is_string()) {
      ASSERT_GE(s.size(), 2u) << s;
      const std::string body = s.substr(1, s.size() - 2);
      const auto n = static_cast<std::uint16_t>(body.size());
      set(core::StringHeader{kCapacity, n});
      for (std::size_t i = 0; i < body.size(); ++i) {
        if (type == TypeId::kString) {
          std::memcpy(bytes + 4 + i, &body[i], 1);
        } else {
          const auto c = static_cast<char16_t>(body[i]);
          std::memcpy(bytes + 4 + 2 * i, &c, 2);
        }
      }
    } else if (type == TypeId::kReal) {
      set(s == "NaN" ? std::bit_cast<float>(0x7fc00000u) : std::strtof(s.c_str(), nullptr));
    } else if (type == TypeId::kLreal) {
      set(s == "NaN" ? std::bit_cast<double>(0x7ff8000000000000ull) : std::strtod(s.c_str(), nullptr));
    } else {
      set_bits(integer(s));
    }
  }
  /// Low bytes of `bits`, as many as the type has.
  void set_bits(std::uint64_t bits) { std::memcpy(bytes, &bits, core::rep_bytes(core::rep_of(type))); }
  [[nodiscard]] std::uint64_t bits() const {
    std::uint64_t out = 0;
    std::memcpy(&out, bytes, core::rep_bytes(core::rep_of(type)));
    return out;
  }

  static std::uint64_t integer(const std::string& s) {
    if (s == "TRUE") return 1;
    if (s == "FALSE") return 0;
    const std::size_t hash = s.find('#');
    if (hash == std::string::npos) return std::strtoull(s.c_str(), nullptr, 10);
    const std::string prefix = s.substr(0, hash), rest = s.substr(hash + 1);
    if (prefix == "16") return std::strtoull(rest.c_str(), nullptr, 16);
    int y = 1970, mo = 1, d = 1, h = 0, mi = 0, sec = 0;
    if (prefix.ends_with("DT")) {
      EXPECT_EQ(std::sscanf(rest.c_str(), "%d-%d-%d-%d:%d:%d", &y, &mo, &d, &h, &mi, &sec), 6) << s;
    } else if (prefix.ends_with("TOD")) {
      EXPECT_EQ(std::sscanf(rest.c_str(), "%d:%d:%d", &h, &mi, &sec), 3) << s;
    } else if (prefix == "D" || prefix.ends_with("DATE")) {
      EXPECT_EQ(std::sscanf(rest.c_str(), "%d-%d-%d", &y, &mo, &d), 3) << s;
    } else {
      return static_cast<std::uint64_t>(duration(rest));
    }
    return static_cast<std::uint64_t>((seconds_of_date(y, mo, d) + h * 3600 + mi * 60 + sec) * 1'000'000'000);
  }
  static std::int64_t duration(const std::string& s) {
    const bool negative = s[0] == '-';
    std::int64_t total = 0;
    std::size_t i = negative ? 1 : 0;
    while (i < s.size()) {
      std::size_t used = 0;
      const std::int64_t n = std::stoll(s.substr(i), &used);
      i += used;
      std::string unit;
      while (i < s.size() && std::isalpha(static_cast<unsigned char>(s[i])) != 0) unit += s[i++];
      const std::int64_t scale = unit == "ns"   ? 1
                                 : unit == "us" ? 1'000
                                 : unit == "ms" ? 1'000'000
                                 : unit == "s"  ? 1'000'000'000
                                 : unit == "m"  ? 60'000'000'000
                                 : unit == "h"  ? 3'600'000'000'000
                                                : 86'400'000'000'000;
      total += n * scale;
    }
    return negative ? -total : total;
  }

  [[nodiscard]] std::string text() const {
    const auto header = get<core::StringHeader>();
    std::string out;
    for (std::size_t i = 0; i < header.length; ++i) {
      if (type == TypeId::kString) {
        out += static_cast<char>(bytes[4 + i]);
      } else {
        char16_t c;
        std::memcpy(&c, bytes + 4 + 2 * i, 2);
        out += c < 0x100 ? static_cast<char>(c) : '?';
      }
    }
    return out;
  }
  /// Reals compare within 1e-6: what the literals of the examples can say.
  [[nodiscard]] bool same_as(const Value& other) const {
    if (is_string()) return text() == other.text();
    if (type == TypeId::kReal || type == TypeId::kLreal) {
      if (bits() == other.bits()) return true;
      const double a = type == TypeId::kReal ? get<float>() : get<double>();
      const double b = type == TypeId::kReal ? other.get<float>() : other.get<double>();
      return std::fabs(a - b) < 1e-6;
    }
    return bits() == other.bits();
  }
};

/// Calls an overload on values; the result has a canary after it.
inline stdlib::Event call(const stdlib::Overload& overload, Value& result, const std::vector<Value>& args) {
  std::vector<const void*> places;
  for (const Value& arg : args) places.push_back(arg.bytes);
  return overload.kernel(result.bytes, places.data(), static_cast<std::uint32_t>(places.size()));
}
inline const stdlib::Overload& overload(std::string_view key) {
  const stdlib::Overload* found = stdlib::overload_with_key(key);
  if (found == nullptr) throw std::runtime_error("no overload " + std::string(key));
  return *found;
}

}  // namespace plc::test
