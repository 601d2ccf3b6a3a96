// Types given as text, as IEC 61131-10 exports and some tools do.
#include <cctype>

#include "core/text.h"
#include "plcopen/reader_types.h"

namespace plc::plcopen {

namespace {

/// What follows `word` at the start of `text` (any letter case, blanks or a bracket after it), trimmed; null if
/// absent.
std::optional<std::string_view> after_word(std::string_view text, std::string_view word) {
  if (text.size() <= word.size() || !core::iequals(text.substr(0, word.size()), word)) return std::nullopt;
  const char next = text[word.size()];
  if (std::isalnum(static_cast<unsigned char>(next)) != 0 || next == '_') return std::nullopt;
  return core::trimmed(text.substr(word.size()));
}

/// One "lower..upper"; a lone bound is the upper one.
Dimension dimension_of(std::string_view text) {
  const std::size_t dots = text.find("..");
  if (dots == std::string_view::npos) return {{}, std::string(core::trimmed(text))};
  return {std::string(core::trimmed(text.substr(0, dots))), std::string(core::trimmed(text.substr(dots + 2)))};
}

/// Takes "[a..b, c..d] OF" off the text; false if it is none.
bool take_dimensions(std::string_view& text, std::vector<Dimension>& dimensions) {
  if (!text.starts_with('[')) return false;
  const std::size_t close = text.find(']');
  if (close == std::string_view::npos) return false;
  const std::optional<std::string_view> base = after_word(core::trimmed(text.substr(close + 1)), "OF");
  if (!base) return false;
  std::string_view inside = text.substr(1, close - 1);
  while (true) {
    const std::size_t comma = inside.find(',');
    dimensions.push_back(dimension_of(inside.substr(0, comma)));
    if (comma == std::string_view::npos) break;
    inside.remove_prefix(comma + 1);
  }
  text = *base;
  return true;
}

/// Takes "ARRAY [a..b] OF" off the text; false if it is none.
bool take_array(std::string_view& text, std::vector<Dimension>& dimensions) {
  const std::optional<std::string_view> rest = after_word(text, "ARRAY");
  std::string_view remaining = rest.value_or(std::string_view{});
  if (!take_dimensions(remaining, dimensions)) return false;
  text = remaining;
  return true;
}

/// Takes "REF_TO", "POINTER TO" or "REFERENCE TO" off the text; false if there is none.
bool take_pointer(std::string_view& text, TypeSpec::Kind& kind) {
  using Kind = TypeSpec::Kind;
  constexpr std::pair<std::string_view, Kind> kWords[] = {
      {"REF_TO", Kind::kReference}, {"POINTER TO", Kind::kPointer}, {"REFERENCE TO", Kind::kReferenceTo}};
  for (const auto& [word, made] : kWords) {
    const std::optional<std::string_view> rest = after_word(text, word);
    if (!rest) continue;
    text = *rest;
    kind = made;
    return true;
  }
  return false;
}

/// "STRING[20]", "WSTRING(20)".
bool string_text(std::string_view text, TypeSpec& type) {
  for (const std::string_view name : {std::string_view("STRING"), std::string_view("WSTRING")}) {
    const std::optional<std::string_view> rest = after_word(text, name);
    if (!core::iequals(text, name) && (!rest || rest->size() < 2 || (rest->front() != '[' && rest->front() != '('))) {
      continue;
    }
    type.kind = TypeSpec::Kind::kString;
    type.name = name;
    if (rest) type.length = core::trimmed(rest->substr(1, rest->size() - 2));
    return true;
  }
  return false;
}

}  // namespace

void parse_type_text(std::string_view text, const SourceRef& at, TypeSpec& result) {
  constexpr int kMaxNesting = 32;
  TypeSpec* type = &result;
  text = core::trimmed(text);
  for (int nesting = 0; nesting < kMaxNesting; ++nesting) {
    type->at = at;
    if (take_array(text, type->dimensions)) {
      type->kind = TypeSpec::Kind::kArray;
    } else if (!take_pointer(text, type->kind)) {
      break;
    }
    type->base = std::make_shared<TypeSpec>();
    type = type->base.get();
  }
  type->at = at;
  if (text.empty() || string_text(text, *type)) return;
  type->kind = TypeSpec::Kind::kNamed;
  // Sysmac Studio writes library types as Library\Type; namespaces are flat here.
  type->name = text.substr(text.rfind('\\') + 1);
}

}  // namespace plc::plcopen
