#include "hmi/comments.h"

namespace plc::hmi {
namespace {

/// How far a text that begins at `at` with its quote goes: the position after its end.
std::size_t end_of_text(std::string_view toml, std::size_t at) {
  const char quote = toml[at];
  const std::string triple(3, quote);
  const bool is_long = toml.substr(at).starts_with(triple);
  at += is_long ? 3 : 1;
  while (at < toml.size()) {
    if (is_long ? toml.substr(at).starts_with(triple) : toml[at] == quote) {
      at += is_long ? 3 : 1;
      // The text of a long string may end with quotes itself.
      for (int more = 0; is_long && more < 2 && at < toml.size() && toml[at] == quote; ++more) ++at;
      return at;
    }
    at += toml[at] == '\\' && quote == '"' ? 2 : 1;
  }
  return toml.size();
}

}  // namespace

Lines lines_of(std::string_view toml) {
  Lines lines;
  lines.used.assign(2, false);
  std::uint32_t line = 1;
  const auto next_line = [&] {
    ++line;
    lines.used.push_back(false);
  };
  for (std::size_t at = toml.starts_with("\xef\xbb\xbf") ? 3 : 0; at < toml.size();) {
    const char c = toml[at];
    if (c == '\n') {
      next_line();
      ++at;
    } else if (c == ' ' || c == '\t' || c == '\r') {
      ++at;
    } else if (c == '#') {
      const std::size_t end = std::min(toml.find('\n', at), toml.size());
      std::string text(toml.substr(at + 1, end - at - 1));
      if (text.ends_with('\r')) text.pop_back();
      lines.comments.push_back({line, std::move(text), !lines.used[line]});
      at = end;
    } else if (c == '"' || c == '\'') {
      const std::size_t end = end_of_text(toml, at);
      for (; at < end; ++at) {
        lines.used[line] = true;
        if (toml[at] == '\n') next_line();
      }
      lines.used[line] = true;
    } else {
      lines.used[line] = true;
      ++at;
    }
  }
  return lines;
}

}  // namespace plc::hmi
