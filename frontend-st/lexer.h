// Lexer of Structured Text: characters -> tokens, on demand. Comments and pragmas are blanks.
//
// In: a text. Out: tokens as byte ranges of it. Does not belong here: values of literals (literals.h), grammar
// (parser.h).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace plc::st {

enum class TokenKind : std::uint8_t {
  kEnd,
  kIdentifier,  ///< also keywords: the grammar tells them apart
  kInteger,     ///< 12, 16#FF, 1_000
  kReal,        ///< 1.5, 1.0E-3
  kTyped,       ///< elementary prefix and value: INT#5, T#1s, D#2024-01-31, STRING#'a'
  kEnumValue,   ///< Color#Red
  kString,      ///< 'text'
  kWstring,     ///< "text"
  kDirect,      ///< %IX0.0
  kAssign,      ///< :=
  kOutput,      ///< =>
  kPower,       ///< **
  kEqual,
  kNotEqual,
  kLess,
  kLessEqual,
  kGreater,
  kGreaterEqual,
  kPlus,
  kMinus,
  kStar,
  kSlash,
  kAnd,  ///< &
  kLeftParen,
  kRightParen,
  kLeftBracket,
  kRightBracket,
  kDot,
  kRange,  ///< ..
  kComma,
  kSemicolon,
  kColon,
  kCaret,
  kUnterminatedString,
  kUnterminatedComment,
  kBadNumber,  ///< digits run into letters: 12ab
  kUnknown,    ///< a character that begins no token
};

struct Token {
  TokenKind kind = TokenKind::kEnd;
  std::uint32_t begin = 0;  ///< byte offsets into the text
  std::uint32_t end = 0;
};

class Lexer {
 public:
  /// Pragmas and comments passed over are added to `pragmas` and `comments`, if given.
  explicit Lexer(std::string_view text, std::vector<Token>* pragmas = nullptr, std::vector<Token>* comments = nullptr)
      : text_(text), pragmas_(pragmas), comments_(comments) {}
  /// The next token; kEnd for ever after the last.
  Token next();

 private:
  [[nodiscard]] char at(std::size_t i) const { return i < text_.size() ? text_[i] : '\0'; }
  Token make(TokenKind kind, std::size_t begin);
  bool skip_blanks(Token& bad);
  [[nodiscard]] std::size_t pragma_end(std::size_t begin) const;
  void skip_identifier();
  Token number(std::size_t begin);
  Token quoted(std::size_t begin, TokenKind kind);
  Token prefixed(std::size_t begin, std::string_view prefix);
  [[nodiscard]] std::size_t after_blanks(std::size_t i) const;
  [[nodiscard]] bool continues_after_blanks(char last) const;
  Token direct(std::size_t begin);

  std::string_view text_;
  std::vector<Token>* pragmas_;
  std::vector<Token>* comments_;
  std::size_t position_ = 0;
};

/// Characters of identifiers. Bytes above 127 count as letters: some tools allow names in any script.
constexpr bool is_identifier_start(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || static_cast<unsigned char>(c) >= 0x80;
}
constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
constexpr bool is_identifier_char(char c) { return is_identifier_start(c) || is_digit(c); }
/// Bytes of the blank, quote or dash before `text` that word processors put where ASCII is meant; 0 for anything
/// else. Such a character is no part of a name.
std::size_t stray_character(std::string_view text);
inline constexpr const char* kStrayHelp = "write blanks, quotes and signs as they are on the keyboard";
/// A token for messages: in quotes, and with its code point when it is such a character.
std::string shown_token(std::string_view text);
/// True for a literal such as "T# 30ms", which some tools write and the standard does not know.
bool has_blank_inside(const Token& token, std::string_view text);
/// True when all of `text` is one identifier.
bool is_identifier(std::string_view text);

}  // namespace plc::st
