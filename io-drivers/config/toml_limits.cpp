#include "io-drivers/config/toml_limits.h"

namespace plc::io {
namespace {

/// Walks over TOML far enough to tell brackets and dots from those in strings and comments.
class Walk {
 public:
  explicit Walk(std::string_view text) : text_(text) {}

  std::optional<TextPlace> run() {
    std::uint32_t brackets = 0;
    std::uint32_t dots = 0;
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '"' || c == '\'') {
        skip_string(c);
        continue;
      }
      if (c == '#') {
        while (at_ < text_.size() && text_[at_] != '\n') step();
        continue;
      }
      if (c == '.') {
        ++dots;
      } else if (c == '[' || c == '{') {
        ++brackets;
        dots = 0;
      } else if (c == ']' || c == '}') {
        brackets -= brackets == 0 ? 0 : 1;
        dots = 0;
      } else if (c == '=' || c == ',' || c == '\n') {
        dots = 0;
      }
      if (brackets > kMaxConfigurationDepth || dots > kMaxConfigurationDepth) return place_;
      step();
    }
    return std::nullopt;
  }

 private:
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

  void skip_string(char quote) {
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
        return;
      }
      if (c == '\n' && !is_long) return;
      step();
      if (c == '\\' && quote == '"' && at_ < text_.size()) step();
    }
  }

  std::string_view text_;
  std::size_t at_ = 0;
  TextPlace place_;
};

}  // namespace

std::optional<TextPlace> too_deep(std::string_view toml) { return Walk(toml).run(); }

}  // namespace plc::io
