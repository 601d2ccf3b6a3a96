#include "core/toml_limits.h"

namespace plc::core {
namespace {

constexpr bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

/// Walks over TOML far enough to tell what is inside of texts and comments from what is outside. A place where
/// it and the parser could disagree has a mistake before it.
class Walk {
 public:
  explicit Walk(std::string_view text) : text_(text) {}

  std::optional<TextProblem> run() {
    if (starts("\xef\xbb\xbf")) at_ = 3;
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '#') {
        while (at_ < text_.size() && text_[at_] != '\n') step();
        continue;
      }
      if (c == '"' || c == '\'') {
        // The parser reads on over a quote inside a word.
        if (in_word_ || !skip_text(c)) return problem(TextProblem::Kind::kNotPlain);
        continue;
      }
      if (static_cast<unsigned char>(c) >= 0x7f || (c < ' ' && !is_blank(c))) {
        return problem(TextProblem::Kind::kNotPlain);
      }
      note(c);
      if (depth_ > kMaxTomlDepth || dots_ > kMaxTomlDepth) return problem(TextProblem::Kind::kTooDeep);
      step();
    }
    return std::nullopt;
  }

 private:
  std::optional<TextProblem> problem(TextProblem::Kind kind) {
    place_.kind = kind;
    return place_;
  }

  /// What a character outside of texts and comments means for those after it.
  void note(char c) {
    const bool in_table = depth_ > 0 && (tables_ >> depth_ & 1u) != 0;
    if (c == '.') {
      ++dots_;
      in_word_ = in_value_;  // parts of a key may have quotes of their own
      return;
    }
    const bool bracket = c == '[' || c == '{';
    const bool second_equals = c == '=' && in_value_;
    if (bracket || c == ']' || c == '}' || c == '=' || c == ',' || c == '\n') dots_ = 0;
    if (bracket) {
      ++depth_;
      tables_ = c == '{' ? tables_ | 1u << depth_ : tables_ & ~(1u << depth_);
      if (c == '{') in_value_ = false;
      return;
    }
    if (c == ']' || c == '}') {
      depth_ -= depth_ == 0 ? 0 : 1;
      if (c == '}') in_value_ = true;
    } else if (c == '=') {
      in_value_ = true;
    } else if ((c == ',' && in_table) || (c == '\n' && depth_ == 0)) {
      in_value_ = false;
    }
    in_word_ = !is_blank(c) && c != ']' && c != '}' && c != ',' && (c != '=' || second_equals);
  }

  void step() {
    const auto c = static_cast<unsigned char>(text_[at_++]);
    if (c == '\n') {
      ++place_.line;
      place_.column = 1;
    } else if (at_ == text_.size() || (static_cast<unsigned char>(text_[at_]) & 0xC0u) != 0x80u) {
      ++place_.column;
    }
  }
  [[nodiscard]] bool starts(std::string_view with) const { return text_.substr(at_).starts_with(with); }

  /// False at a character beyond ASCII where the parser looks for blanks: after a backslash that joins lines.
  bool skip_text(char quote) {
    const char triple[] = {quote, quote, quote};
    const std::string_view long_quote(triple, 3);
    const bool is_long = starts(long_quote);
    for (int i = is_long ? 3 : 1; i > 0; --i) step();
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (is_long ? starts(long_quote) : c == quote) {
        for (int i = is_long ? 3 : 1; i > 0; --i) step();
        // The text of a long string may end with quotes itself.
        for (int more = 0; is_long && more < 2 && starts({&quote, 1}); ++more) step();
        return true;
      }
      if (c == '\n' && !is_long) return true;
      step();
      if (c != '\\' || quote != '"' || at_ == text_.size()) continue;
      const char escaped = text_[at_];
      if (is_long && is_blank(escaped)) {
        while (at_ < text_.size() && is_blank(text_[at_])) step();
        if (at_ < text_.size() && static_cast<unsigned char>(text_[at_]) >= 0x80) return false;
      } else {
        if (is_long && static_cast<unsigned char>(escaped) >= 0x80) return false;
        step();
      }
    }
    return true;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  TextProblem place_;
  std::uint32_t depth_ = 0;   ///< open brackets
  std::uint32_t tables_ = 0;  ///< bit n: bracket n is a {
  std::uint32_t dots_ = 0;    ///< in this key
  bool in_value_ = false;     ///< after a =
  bool in_word_ = false;      ///< something other than a text has begun
};

}  // namespace

std::optional<TextProblem> find_unsafe(std::string_view toml) { return Walk(toml).run(); }

}  // namespace plc::core
