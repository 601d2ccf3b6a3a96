// Initial values given as text where the schema has elements: `[1, 3(0)]`, `(x := 1, y := [2])`. Editors that keep what
// was typed write them into one simpleValue.
#include <algorithm>
#include <cctype>
#include <cstddef>
#include <optional>
#include <utility>

#include "core/text.h"
#include "plcopen/reader_types.h"

namespace plc::plcopen {

namespace {

constexpr std::size_t kNone = std::string_view::npos;
constexpr int kMaxNesting = 32;
constexpr std::ptrdiff_t kMaxValues = 1'000'000;

/// Offset of the first `wanted` that is in no brackets and no quotes; none also when brackets or quotes do not close
/// before it.
std::size_t find_outside(std::string_view text, std::string_view wanted) {
  std::string open;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (open.empty() && text.substr(i).starts_with(wanted)) return i;
    if (c == '\'' || c == '"') {
      for (++i; i < text.size() && text[i] != c; ++i) i += text[i] == '$' ? 1 : 0;
      if (i >= text.size()) return kNone;
    } else if (c == '[' || c == '(') {
      open += c == '[' ? ']' : ')';
    } else if (c == ']' || c == ')') {
      if (open.empty() || open.back() != c) return kNone;
      open.pop_back();
    }
  }
  return kNone;
}

/// What is between `open` and `close` when they are the first and the last of `text` and belong together.
std::optional<std::string_view> inside(std::string_view text, std::string_view open, std::string_view close) {
  if (text.size() < 2 || !text.starts_with(open)) return std::nullopt;
  const std::string_view rest = text.substr(1);
  if (find_outside(rest, close) != rest.size() - 1) return std::nullopt;
  return core::trimmed(rest.substr(0, rest.size() - 1));
}

bool is_name(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '#';
  });
}

class ValueText {
 public:
  explicit ValueText(const SourceRef& at) : at_(at) {}

  bool value(std::string_view text, InitialValue& out, int depth) {
    text = core::trimmed(text);
    out.at = at_;
    if (text.empty() || depth > kMaxNesting) return false;
    if (const auto list = inside(text, "[", "]")) return parts(*list, out, InitialValue::Kind::kArray, depth);
    const auto members = inside(text, "(", ")");
    if (members && find_outside(*members, ":=") != kNone) {
      return parts(*members, out, InitialValue::Kind::kStruct, depth);
    }
    out.kind = InitialValue::Kind::kSimple;
    out.text = text;
    return true;
  }

 private:
  bool parts(std::string_view text, InitialValue& out, InitialValue::Kind kind, int depth) {
    out.kind = kind;
    while (!text.empty()) {
      const std::size_t comma = find_outside(text, ",");
      const std::string_view one = core::trimmed(text.substr(0, comma));
      InitialValue& part = out.values.emplace_back();
      if (!(kind == InitialValue::Kind::kArray ? element(one, part, depth) : member(one, part, depth))) return false;
      if (comma == kNone) return true;
      text = core::trimmed(text.substr(comma + 1));
      if (text.empty()) return false;
    }
    return true;
  }

  /// `value`, `n(value)`, or `n()`, which leaves the defaults.
  bool element(std::string_view text, InitialValue& out, int depth) {
    const std::size_t open = text.find('(');
    const std::string_view count = core::trimmed(text.substr(0, open));
    const auto repeated = open == kNone || !is_name(count) ? std::nullopt : inside(text.substr(open), "(", ")");
    if (!repeated) return value(text, out, depth + 1);
    out.at = at_;
    if (!repeated->empty() && !value(*repeated, out, depth + 1)) return false;
    out.repetition = count;
    out.repetition_at = at_;
    return true;
  }

  bool member(std::string_view text, InitialValue& out, int depth) {
    const std::size_t sign = find_outside(text, ":=");
    if (sign == kNone || !is_name(core::trimmed(text.substr(0, sign)))) return false;
    if (!value(text.substr(sign + 2), out, depth + 1)) return false;
    out.member = core::trimmed(text.substr(0, sign));
    return true;
  }

  SourceRef at_;
};

}  // namespace

void parse_value_text(const TypeSpec& type, InitialValue& value) {
  // Texts are kept as they were typed, without quotes.
  if (value.kind != InitialValue::Kind::kSimple || type.kind == TypeSpec::Kind::kString) return;
  // Each value is the first of its list, or comes after a comma.
  const auto begins = [](char c) { return c == ',' || c == '[' || c == '('; };
  if (std::count_if(value.text.begin(), value.text.end(), begins) > kMaxValues) return;
  InitialValue parsed;
  if (!ValueText(value.at).value(value.text, parsed, 0) || parsed.kind == InitialValue::Kind::kSimple) return;
  parsed.text = std::move(value.text);
  value = std::move(parsed);
}

}  // namespace plc::plcopen
