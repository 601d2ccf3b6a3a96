// Values of ports as IEC 61131-3 spells them, read into memory as a component sees it: for tests of components, which
// run without the compiler. In: a text, the type. Out: the value, or std::invalid_argument. Does not belong here:
// expressions and names of constants, which initial values of ports do not have.
#pragma once

#include <algorithm>
#include <cctype>
#include <charconv>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>

#include "picard/abi.h"

namespace picard {

namespace detail {

inline bool same_name(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::toupper(x) == std::toupper(y); });
}

/// The value that variables of a type begin with, in memory that is 0.
inline void begin_value(const picard_type& type, std::byte* at) {
  if (type.kind == PICARD_STRING) {
    const auto capacity = static_cast<std::uint16_t>(type.capacity);
    std::memcpy(at, &capacity, sizeof capacity);
  }
  if (type.kind == PICARD_ENUM_TYPE) std::memcpy(at, &type.enumerators[0].value, type.size);
  for (std::uint32_t i = 0; type.kind == PICARD_ARRAY && i < type.capacity; ++i) {
    begin_value(*type.element, at + std::size_t{i} * type.element->size);
  }
  for (std::uint32_t i = 0; i < type.field_count; ++i) begin_value(*type.fields[i].type, at + type.fields[i].offset);
}

/// Reads literals, [1, 2(0)], (X := 1, NAME := 'a'), names of enumerations.
class ValueReader {
 public:
  explicit ValueReader(std::string_view text) : text_(text) {}

  /// Throws std::invalid_argument when the text is no value of the type, or has more than one.
  void read(const picard_type& type, std::byte* at) {
    value(type, at);
    skip_blanks();
    if (!rest_.empty()) wrong();
  }

 private:
  [[noreturn]] void wrong() const { throw std::invalid_argument("no value of this type: " + std::string(text_)); }

  void skip_blanks() {
    while (!rest_.empty() && std::isspace(static_cast<unsigned char>(rest_.front())) != 0) rest_.remove_prefix(1);
  }
  bool take(std::string_view mark) {
    skip_blanks();
    if (!rest_.starts_with(mark)) return false;
    rest_.remove_prefix(mark.size());
    return true;
  }
  void expect(std::string_view mark) {
    if (!take(mark)) wrong();
  }
  /// Letters, digits and what else numbers, times and dates have.
  std::string_view word() {
    skip_blanks();
    std::size_t length = 0;
    while (length < rest_.size() && (std::isalnum(static_cast<unsigned char>(rest_[length])) != 0 ||
                                     std::string_view("_#.+-:").find(rest_[length]) != std::string_view::npos)) {
      if (rest_.substr(length).starts_with(":=")) break;
      ++length;
    }
    if (length == 0) wrong();
    const std::string_view found = rest_.substr(0, length);
    rest_.remove_prefix(length);
    return found;
  }

  void value(const picard_type& type, std::byte* at) {
    switch (type.kind) {
      case PICARD_ARRAY:
        return array(type, at);
      case PICARD_STRUCT_TYPE:
        return structure(type, at);
      case PICARD_ENUM_TYPE:
        return enumerator(type, at);
      case PICARD_STRING: {
        const std::u16string text = quoted();
        const auto length = static_cast<std::uint16_t>(std::min<std::size_t>(text.size(), type.capacity));
        const bool wide = std::string_view(type.name) == "WSTRING";
        std::memcpy(at + sizeof length, &length, sizeof length);
        for (std::size_t i = 0; i < length; ++i) character(text[i], at + 2 * sizeof length + i * (wide ? 2 : 1), wide);
        return;
      }
      default:
        return elementary(type.name, type.size, at);
    }
  }

  void array(const picard_type& type, std::byte* at) {
    expect("[");
    std::uint32_t filled = 0;
    const auto next = [&] {
      return filled < type.capacity ? at + std::size_t{filled++} * type.element->size : nullptr;
    };
    do {
      std::uint32_t times = 0;
      const auto [end, error] = (skip_blanks(), std::from_chars(rest_.data(), rest_.data() + rest_.size(), times));
      const bool repeated = error == std::errc() && end != rest_.data() + rest_.size() && *end == '(';
      if (repeated) rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()) + 1);
      std::byte* const first = next();
      if (first == nullptr || (repeated && times == 0)) wrong();
      value(*type.element, first);
      if (!repeated) continue;
      expect(")");
      for (std::uint32_t i = 1; i < times; ++i) {
        std::byte* const more = next();
        if (more == nullptr) wrong();
        std::memcpy(more, first, type.element->size);
      }
    } while (take(","));
    expect("]");
  }

  void structure(const picard_type& type, std::byte* at) {
    expect("(");
    do {
      const std::string_view name = word();
      expect(":=");
      const picard_field* const end = type.fields + type.field_count;
      const picard_field* const field =
          std::find_if(type.fields, end, [name](const picard_field& f) { return same_name(f.name, name); });
      if (field == end) wrong();
      value(*field->type, at + field->offset);
    } while (take(","));
    expect(")");
  }

  void enumerator(const picard_type& type, std::byte* at) {
    std::string_view name = word();
    const std::size_t hash = name.find('#');
    if (hash != std::string_view::npos && !same_name(name.substr(0, hash), type.name)) wrong();
    if (hash != std::string_view::npos) name.remove_prefix(hash + 1);
    for (std::uint32_t i = 0; i < type.enumerator_count; ++i) {
      if (same_name(type.enumerators[i].name, name)) return store(type.enumerators[i].value, type.size, at);
    }
    wrong();
  }

  /// 'text' or "text", with $ before what is special: $', $$, $N, $41.
  std::u16string quoted() {
    skip_blanks();
    const bool wide = take("\"");
    if (!wide) expect("'");
    const char end = wide ? '"' : '\'';
    std::u16string text;
    while (!rest_.empty() && rest_.front() != end) {
      char c = rest_.front();
      rest_.remove_prefix(1);
      if (c != '$') {
        text += static_cast<unsigned char>(c);
        continue;
      }
      const std::size_t digits = wide ? 4 : 2;
      unsigned code = 0;
      const std::string_view hex = rest_.substr(0, digits);
      const auto [at, error] = std::from_chars(hex.data(), hex.data() + hex.size(), code, 16);
      if (error == std::errc() && at == hex.data() + digits) {
        text += static_cast<char16_t>(code);
        rest_.remove_prefix(digits);
        continue;
      }
      if (rest_.empty()) wrong();
      c = rest_.front();
      rest_.remove_prefix(1);
      const std::size_t special = std::string_view("NnLlRrTtPp").find(c);
      text += static_cast<unsigned char>(special == std::string_view::npos ? c : "\n\n\n\n\r\r\t\t\f\f"[special]);
    }
    if (!take(wide ? "\"" : "'")) wrong();
    return text;
  }
  static void character(char16_t c, std::byte* at, bool wide) {
    if (wide) {
      std::memcpy(at, &c, sizeof c);
    } else {
      *at = static_cast<std::byte>(c);
    }
  }
  /// Runtime and table are little-endian, as every machine PICARD runs on.
  static void store(std::int64_t number, std::uint32_t bytes, std::byte* at) { std::memcpy(at, &number, bytes); }

  void elementary(std::string_view type, std::uint32_t bytes, std::byte* at) {
    if (type == "CHAR" || type == "WCHAR") {
      const std::u16string text = quoted();
      if (text.size() != 1) wrong();
      return character(text[0], at, type == "WCHAR");
    }
    std::string literal(word());
    // A type before #, but 16#FF.
    const std::size_t hash = literal.find('#');
    if (hash != std::string::npos && std::isalpha(static_cast<unsigned char>(literal[0])) != 0)
      literal.erase(0, hash + 1);
    std::erase(literal, '_');
    if (literal.empty()) wrong();
    if (type == "BOOL") {
      const bool on = same_name(literal, "TRUE") || literal == "1";
      if (!on && !same_name(literal, "FALSE") && literal != "0") wrong();
      store(on ? 1 : 0, bytes, at);
    } else if (type == "REAL" || type == "LREAL") {
      char* end = nullptr;
      const double number = std::strtod(literal.c_str(), &end);
      if (*end != '\0') wrong();
      const auto single = static_cast<float>(number);
      std::memcpy(at, bytes == sizeof single ? static_cast<const void*>(&single) : &number, bytes);
    } else if (type == "TIME" || type == "LTIME") {
      store(duration(literal), bytes, at);
    } else if (type.find("DATE") != std::string_view::npos || type.find("TIME") != std::string_view::npos) {
      store(moment(literal), bytes, at);
    } else {
      store(integer(literal), bytes, at);
    }
  }

  [[nodiscard]] std::int64_t integer(const std::string& literal) const {
    const std::size_t hash = literal.find('#');
    const std::string digits = hash == std::string::npos ? literal : literal.substr(hash + 1);
    const int base = hash == std::string::npos ? 10 : std::atoi(literal.c_str());
    if (digits.empty() || (base != 10 && base != 2 && base != 8 && base != 16)) wrong();
    char* end = nullptr;
    const bool negative = digits[0] == '-';
    const auto number = negative ? std::strtoll(digits.c_str(), &end, base)
                                 : static_cast<std::int64_t>(std::strtoull(digits.c_str(), &end, base));
    if (*end != '\0') wrong();
    return number;
  }

  /// "1h30m", "-2.5s": nanoseconds.
  [[nodiscard]] std::int64_t duration(const std::string& literal) const {
    struct Unit {
      std::string_view name;
      double ns;
    };
    static constexpr Unit kUnits[] = {{"ms", 1e6},   {"us", 1e3}, {"ns", 1}, {"d", 86400e9},
                                      {"h", 3600e9}, {"m", 60e9}, {"s", 1e9}};
    const bool negative = literal[0] == '-';
    const char* at = literal.c_str() + (negative ? 1 : 0);
    double sum = 0;
    do {
      char* end = nullptr;
      const double number = std::strtod(at, &end);
      const auto* const unit = std::find_if(std::begin(kUnits), std::end(kUnits), [end](const Unit& u) {
        return same_name(std::string_view(end).substr(0, u.name.size()), u.name);
      });
      if (end == at || unit == std::end(kUnits)) wrong();
      sum += number * unit->ns;
      at = end + unit->name.size();
    } while (*at != '\0');
    return static_cast<std::int64_t>(negative ? -sum : sum);
  }

  /// "2024-05-17", "12:30:00.5", "2024-05-17-12:30:00": nanoseconds since 1970-01-01 or midnight.
  [[nodiscard]] std::int64_t moment(const std::string& literal) const {
    int year = 1970, hour = 0, minute = 0, used = 0;
    unsigned month = 1, day = 1;
    double second = 0;
    const char* at = literal.c_str();
    if (literal.find('-') != std::string::npos) {
      if (std::sscanf(at, "%d-%u-%u%n", &year, &month, &day, &used) != 3) wrong();
      at += used;
      if (*at == '-') ++at;
    }
    if (*at != '\0') {
      if (std::sscanf(at, "%d:%d:%lf%n", &hour, &minute, &second, &used) != 3 || at[used] != '\0') wrong();
    }
    const std::chrono::nanoseconds date =
        std::chrono::sys_days(std::chrono::year(year) / static_cast<int>(month) / static_cast<int>(day))
            .time_since_epoch();
    return date.count() + (hour * 60 + minute) * 60'000'000'000 + static_cast<std::int64_t>(second * 1e9);
  }

  std::string_view text_;
  std::string_view rest_ = text_;
};

}  // namespace detail

}  // namespace picard
