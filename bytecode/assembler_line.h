// Line: the words of one line of assembler text, taken one by one.
//
// In: a line. Out: words, numbers, quoted texts; a Mistake for anything else, which never leaves assemble(). Internal
// to bytecode/assemble.cpp. Does not belong here: what the words mean.
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "bytecode/listing.h"

namespace plc::bytecode::listing {

/// What a line says that the assembler cannot take; caught in assemble() alone, where the line number is known.
struct Mistake {
  std::string what;
};
[[noreturn]] inline void fail(std::string what) { throw Mistake{std::move(what)}; }

/// The words of one line: blanks and commas separate, quotes hold together, ';' ends.
class Line {
 public:
  explicit Line(std::string_view text) : rest_(text) { skip(); }

  [[nodiscard]] bool empty() const { return rest_.empty(); }
  std::string_view word() {
    if (rest_.empty()) fail("the line ends too early");
    std::size_t end = 0;
    bool in_quotes = false;
    for (; end < rest_.size(); ++end) {
      const char c = rest_[end];
      if (c == '"') in_quotes = !in_quotes;
      if (!in_quotes && (c == ' ' || c == '\t' || c == '\r' || c == ',' || c == ';')) break;
    }
    if (in_quotes) fail("the quotes are not closed");
    const std::string_view word = rest_.substr(0, end);
    rest_.remove_prefix(end);
    skip();
    return word;
  }
  [[nodiscard]] std::string_view peek() const {
    Line copy = *this;
    return copy.empty() ? std::string_view{} : copy.word();
  }
  /// Takes the next word if it is `word`.
  bool accept(std::string_view word) {
    if (rest_.empty() || peek() != word) return false;
    this->word();
    return true;
  }
  void expect(std::string_view wanted) {
    const std::string_view found = word();
    if (found != wanted) fail(quoted(found) + " where " + quoted(wanted) + " belongs");
  }
  std::string text() {
    const std::string_view found = word();
    auto text = unquoted(found);
    if (!text) fail(std::string(found) + " is not a text in quotes");
    return std::move(*text);
  }
  template <class T>
  T number() {
    return to_number<T>(word());
  }
  /// A number after `letter`: "t12".
  std::uint32_t index(char letter) {
    const std::string_view found = word();
    if (found.size() < 2 || found[0] != letter) fail(quoted(found) + " where " + letter + "<number> belongs");
    return to_number<std::uint32_t>(found.substr(1));
  }
  /// The position of the next word among `words`, as an enumerator.
  template <class E>
  E one_of(std::span<const std::string_view> words) {
    const std::string_view found = word();
    const auto it = std::find(words.begin(), words.end(), found);
    if (it == words.end()) fail(quoted(found) + " is unknown here");
    return static_cast<E>(it - words.begin());
  }
  void end() const {
    if (!rest_.empty()) fail(quoted(rest_) + " is too much");
  }

  template <class T>
  static T to_number(std::string_view text) {
    T value{};
    const bool hex = text.size() > 2 && text[0] == '0' && text[1] == 'x';
    const char* const end = text.data() + text.size();
    std::from_chars_result result{};
    if constexpr (std::is_floating_point_v<T>) {
      if (text == "nan") return std::numeric_limits<T>::quiet_NaN();
      result = std::from_chars(text.data(), end, value);
    } else {
      result = std::from_chars(text.data() + (hex ? 2 : 0), end, value, hex ? 16 : 10);
    }
    if (result.ec != std::errc{} || result.ptr != end) fail(quoted(text) + " is not a number that fits here");
    return value;
  }

 private:
  void skip() {
    const std::size_t next = rest_.find_first_not_of(" \t\r,");
    rest_ = next == std::string_view::npos || rest_[next] == ';' ? std::string_view{} : rest_.substr(next);
  }
  std::string_view rest_;
};

}  // namespace plc::bytecode::listing
