#include "frontend-st/lexer.h"

#include "core/text.h"
#include "core/utf8.h"
#include "frontend-st/literals.h"

namespace plc::st {

namespace {

bool is_blank(char c) { return c == ' ' || c == '\t'; }

}  // namespace

bool is_identifier(std::string_view text) {
  if (text.empty() || !is_identifier_start(text[0])) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (!is_identifier_char(text[i]) || stray_character(text.substr(i)) != 0) return false;
  }
  return true;
}

std::size_t stray_character(std::string_view text) {
  if (text.size() < 2 || static_cast<unsigned char>(text[0]) < 0xc2) return 0;
  std::size_t end = 0;
  const char32_t point = core::decode_utf8(text, end);
  const bool blank = point == 0xa0 || (point >= 0x2000 && point <= 0x200f) || (point >= 0x2028 && point <= 0x202f) ||
                     point == 0x2060 || point == 0x3000 || point == 0xfeff;
  const bool mark = (point >= 0x2010 && point <= 0x2027) || point == 0xab || point == 0xbb || point == 0x2212;
  return blank || mark ? end : 0;
}

std::string shown_token(std::string_view text) {
  std::string out = '"' + std::string(text) + '"';
  if (stray_character(text) == 0) return out;
  std::size_t end = 0;
  const auto point = static_cast<std::uint32_t>(core::decode_utf8(text, end));
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  out += " (U+";
  for (int shift = 12; shift >= 0; shift -= 4) out += kDigits[(point >> shift) & 0xfu];
  return out + ")";
}

bool has_blank_inside(const Token& token, std::string_view text) {
  if (token.kind != TokenKind::kTyped || text.find_first_of("'\"") != std::string_view::npos) return false;
  return text.find_first_of(" \t") != std::string_view::npos;
}

void Lexer::skip_identifier() {
  while (is_identifier_char(at(position_))) {
    if (static_cast<unsigned char>(at(position_)) >= 0xc2 && stray_character(text_.substr(position_)) != 0) return;
    ++position_;
  }
}

Token Lexer::make(TokenKind kind, std::size_t begin) {
  return {kind, static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(position_)};
}

// Skips blanks, comments and pragmas. False, with `bad` filled, when a comment does not end.
bool Lexer::skip_blanks(Token& bad) {
  for (;;) {
    const char c = at(position_);
    if (position_ >= text_.size()) return true;
    if (c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f' || c == '\v') {
      ++position_;
      continue;
    }
    const char next = at(position_ + 1);
    const std::size_t begin = position_;
    if (c == '/' && next == '/') {
      // A CR alone ends the comment too: XML makes a line end of it, and both kinds of files mean the same.
      const std::size_t end = text_.find_first_of("\r\n", position_);
      position_ = end == std::string_view::npos ? text_.size() : end;
      if (comments_ != nullptr) comments_->push_back(make(TokenKind::kUnknown, begin));
      continue;
    }
    if ((c == '(' || c == '/') && next == '*') {
      const char close = c == '(' ? ')' : '/';
      std::uint32_t depth = 1;
      position_ += 2;
      while (depth > 0 && position_ < text_.size()) {
        if (at(position_) == '*' && at(position_ + 1) == close) {
          --depth;
          position_ += 2;
        } else if (at(position_) == c && at(position_ + 1) == '*') {
          ++depth;
          position_ += 2;
        } else {
          ++position_;
        }
      }
      if (depth == 0) {
        if (comments_ != nullptr) comments_->push_back(make(TokenKind::kUnknown, begin));
        continue;
      }
      position_ = text_.size();
      bad = make(TokenKind::kUnterminatedComment, begin);
      return false;
    }
    if (c == '{') {
      const std::size_t end = pragma_end(position_);
      if (end != std::string_view::npos) {
        position_ = end;
        if (pragmas_ != nullptr) pragmas_->push_back(make(TokenKind::kUnknown, begin));
        continue;
      }
      position_ = text_.size();
      bad = make(TokenKind::kUnterminatedComment, begin);
      return false;
    }
    return true;
  }
}

// Past the pragma that begins at `begin`; npos when it has no end. Code in C may have braces of its own.
std::size_t Lexer::pragma_end(std::size_t begin) const {
  const std::size_t first = text_.find('}', begin);
  if (first == std::string_view::npos) return first;
  std::size_t open = 0;
  for (std::size_t i = text_.find_first_of("{}", begin); i != std::string_view::npos;
       i = text_.find_first_of("{}", i + 1)) {
    open = text_[i] == '{' ? open + 1 : open - 1;
    if (open == 0) return i + 1;
  }
  return first + 1;
}

Token Lexer::number(std::size_t begin) {
  const auto digits = [this] {
    while (is_digit(at(position_)) || at(position_) == '_') ++position_;
  };
  digits();
  TokenKind kind = TokenKind::kInteger;
  if (at(position_) == '#') {
    ++position_;
    while (is_identifier_char(at(position_))) ++position_;
    return make(kind, begin);
  }
  if (at(position_) == '.' && is_digit(at(position_ + 1))) {
    kind = TokenKind::kReal;
    ++position_;
    digits();
  }
  if (core::fold(at(position_)) == 'e') {
    const char sign = at(position_ + 1);
    const std::size_t first = position_ + (sign == '+' || sign == '-' ? 2 : 1);
    if (is_digit(at(first))) {
      kind = TokenKind::kReal;
      position_ = first;
      digits();
    }
  }
  if (is_identifier_start(at(position_))) {
    while (is_identifier_char(at(position_))) ++position_;
    kind = TokenKind::kBadNumber;
  }
  return make(kind, begin);
}

Token Lexer::quoted(std::size_t begin, TokenKind kind) {
  const char quote = at(position_);
  ++position_;
  // A line end is written as $N in a text: a forgotten quote spoils its line, not the rest of the file.
  while (position_ < text_.size() && at(position_) != '\n' && at(position_) != '\r') {
    const char c = at(position_++);
    if (c == quote) return make(kind, begin);
    if (c == '$' && position_ < text_.size()) ++position_;
  }
  return make(TokenKind::kUnterminatedString, begin);
}

std::size_t Lexer::after_blanks(std::size_t i) const {
  while (is_blank(at(i))) ++i;
  return i;
}

// "T#1h 30m", "T#5 s": the blanks at position_ are between two parts, or between a number and its unit. Nothing else
// begins with a digit after a literal, and what follows a number without a unit is wrong if it is none.
bool Lexer::continues_after_blanks(char last) const {
  const std::size_t begin = after_blanks(position_);
  if (!is_digit(last)) return last != '\0' && is_digit(at(begin));
  std::size_t end = begin;
  while (is_identifier_start(at(end)) && at(end) != '_') ++end;
  const std::string_view unit = text_.substr(begin, end - begin);
  for (const std::string_view known : {"d", "h", "m", "s", "ms", "us", "ns"}) {
    if (core::iequals(unit, known)) return true;
  }
  return false;
}

// After `prefix#`: position_ is on the '#'.
Token Lexer::prefixed(std::size_t begin, std::string_view prefix) {
  ++position_;
  const std::optional<core::TypeId> type = literal_prefix(prefix);
  if (!type) {
    while (is_identifier_char(at(position_))) ++position_;
    return make(TokenKind::kEnumValue, begin);
  }
  if (at(position_) == '\'' || at(position_) == '"') return quoted(begin, TokenKind::kTyped);
  const bool date = core::in_category(*type, core::kAnyDate);
  const bool real = core::in_category(*type, core::kAnyReal);
  const bool duration = core::in_category(*type, core::kAnyDuration);
  const std::size_t value = after_blanks(position_);
  if (is_digit(at(value)) || ((at(value) == '-' || at(value) == '+') && is_digit(at(value + 1)))) position_ = value;
  if (at(position_) == '+' || at(position_) == '-') ++position_;
  for (char last = '\0';; last = at(position_), ++position_) {
    const char c = at(position_);
    if (is_identifier_char(c) || (c == '#' && last != '\0')) continue;
    if (duration && is_blank(c) && continues_after_blanks(last)) {
      position_ = after_blanks(position_) - 1;
      continue;
    }
    const bool digit_follows = is_digit(at(position_ + 1));
    if (c == '.' && digit_follows) continue;
    if (date && (c == '-' || c == ':') && digit_follows) continue;
    if (real && (c == '-' || c == '+') && core::fold(last) == 'e' && digit_follows) continue;
    return make(TokenKind::kTyped, begin);
  }
}

Token Lexer::direct(std::size_t begin) {
  ++position_;
  while (is_identifier_char(at(position_)) || at(position_) == '*' ||
         (at(position_) == '.' && is_digit(at(position_ + 1)))) {
    ++position_;
  }
  return make(TokenKind::kDirect, begin);
}

Token Lexer::next() {
  Token bad;
  if (!skip_blanks(bad)) return bad;
  const std::size_t begin = position_;
  if (begin >= text_.size()) return make(TokenKind::kEnd, begin);
  const char c = at(begin);
  if (is_identifier_start(c)) {
    skip_identifier();
    if (position_ == begin) {
      position_ += stray_character(text_.substr(begin));
      return make(TokenKind::kUnknown, begin);
    }
    if (at(position_) == '#') return prefixed(begin, text_.substr(begin, position_ - begin));
    return make(TokenKind::kIdentifier, begin);
  }
  if (is_digit(c)) return number(begin);
  if (c == '\'') return quoted(begin, TokenKind::kString);
  if (c == '"') return quoted(begin, TokenKind::kWstring);
  if (c == '%') return direct(begin);
  const char second = at(begin + 1);
  struct Pair {
    char first, second;
    TokenKind kind;
  };
  static constexpr Pair kPairs[] = {
      {':', '=', TokenKind::kAssign},        {'=', '>', TokenKind::kOutput},      {'*', '*', TokenKind::kPower},
      {'<', '>', TokenKind::kNotEqual},      {'<', '=', TokenKind::kLessEqual},   {'>', '=', TokenKind::kGreaterEqual},
      {'.', '.', TokenKind::kRange},         {'=', '\0', TokenKind::kEqual},      {'<', '\0', TokenKind::kLess},
      {'>', '\0', TokenKind::kGreater},      {'+', '\0', TokenKind::kPlus},       {'-', '\0', TokenKind::kMinus},
      {'*', '\0', TokenKind::kStar},         {'/', '\0', TokenKind::kSlash},      {'&', '\0', TokenKind::kAnd},
      {'(', '\0', TokenKind::kLeftParen},    {')', '\0', TokenKind::kRightParen}, {'[', '\0', TokenKind::kLeftBracket},
      {']', '\0', TokenKind::kRightBracket}, {'.', '\0', TokenKind::kDot},        {',', '\0', TokenKind::kComma},
      {';', '\0', TokenKind::kSemicolon},    {':', '\0', TokenKind::kColon},      {'^', '\0', TokenKind::kCaret},
  };
  for (const Pair& pair : kPairs) {
    if (c != pair.first || (pair.second != '\0' && second != pair.second)) continue;
    position_ += pair.second == '\0' ? 1 : 2;
    return make(pair.kind, begin);
  }
  ++position_;
  return make(TokenKind::kUnknown, begin);
}

}  // namespace plc::st
