#include "engineering/validate.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "core/utf8.h"
#include "engineering/dispatch.h"

namespace plc::engineering {
namespace {

Refusal wrong(std::string field, std::string text) {
  return {400, core::Code::P7714, std::move(text), std::move(field), {}, 0};
}

bool is_choice(std::string_view choices, std::string_view text) {
  for (std::string_view rest = choices; !rest.empty();) {
    const std::size_t bar = rest.find('|');
    if (rest.substr(0, bar) == text) return true;
    rest = bar == std::string_view::npos ? std::string_view{} : rest.substr(bar + 1);
  }
  return false;
}

std::optional<Refusal> wrong_object(const Json& object, std::span<const Field> fields, const std::string& where);

std::optional<Refusal> wrong_value(const Json& value, const Field& field, const std::string& where) {
  switch (field.type) {
    case FieldType::kText: {
      if (!value.is_string()) return wrong(where, "must be a text");
      const auto& text = value.get_ref<const std::string&>();
      const auto size = static_cast<std::int64_t>(text.size());
      if (size < field.low)
        return wrong(where, fmt::format("must have at least {} character{}", field.low, field.low == 1 ? "" : "s"));
      if (field.high != 0 && size > field.high)
        return wrong(where, fmt::format("must have at most {} characters", field.high));
      if (!field.choices.empty() && !is_choice(field.choices, text)) {
        return wrong(where, fmt::format("must be one of {}", field.choices));
      }
      return std::nullopt;
    }
    case FieldType::kInteger: {
      const bool too_large = value.is_number_unsigned() && value.get<std::uint64_t>() > INT64_MAX;
      if (!value.is_number_integer() || too_large) return wrong(where, "must be a whole number");
      const auto number = value.get<std::int64_t>();
      if (number < field.low || number > field.high) {
        return wrong(where, fmt::format("must be from {} to {}", field.low, field.high));
      }
      return std::nullopt;
    }
    case FieldType::kNumber:
      return value.is_number() ? std::nullopt : std::optional(wrong(where, "must be a number"));
    case FieldType::kBoolean:
      return value.is_boolean() ? std::nullopt : std::optional(wrong(where, "must be true or false"));
    case FieldType::kValue:
      return std::nullopt;
    case FieldType::kFile:
      return value.is_string() ? std::nullopt : std::optional(wrong(where, "must be bytes"));
    case FieldType::kRecord:
      if (!value.is_object()) return wrong(where, "must be an object");
      return wrong_object(value, field.record->fields, where + ".");
    case FieldType::kTexts:
    case FieldType::kNumbers:
    case FieldType::kRecords:
      if (!value.is_array()) return wrong(where, "must be a list");
      if (field.high != 0 && value.size() > static_cast<std::size_t>(field.high)) {
        return wrong(where, fmt::format("must have at most {} entries", field.high));
      }
      for (std::size_t i = 0; i < value.size(); ++i) {
        const std::string at = fmt::format("{}[{}]", where, i);
        if (field.type == FieldType::kTexts) {
          if (!value[i].is_string()) return wrong(at, "must be a text");
        } else if (field.type == FieldType::kNumbers) {
          if (!value[i].is_number_unsigned() || value[i].get<std::uint64_t>() > INT64_MAX)
            return wrong(at, "must be a whole number from 0 on");
        } else {
          if (!value[i].is_object()) return wrong(at, "must be an object");
          if (auto found = wrong_object(value[i], field.record->fields, at + ".")) return found;
        }
      }
      return std::nullopt;
  }
  return std::nullopt;
}

std::optional<Refusal> wrong_object(const Json& object, std::span<const Field> fields, const std::string& where) {
  for (const auto& [name, value] : object.items()) {
    const auto field = std::find_if(fields.begin(), fields.end(), [&n = name](const Field& f) { return f.name == n; });
    if (field == fields.end()) return wrong(where + name, "is not a field here");
    if (auto found = wrong_value(value, *field, where + name)) return found;
  }
  for (const Field& field : fields) {
    if (field.required && !object.contains(std::string(field.name)))
      return wrong(where + std::string(field.name), "is missing");
  }
  return std::nullopt;
}

/// WHY: who parses compares each name of an object with those before it, and 100,000 of them, for which a body has
/// room, would hold up all clients for 15 s.
constexpr std::size_t kMostNames = 4000;
constexpr std::size_t kMostComparisons = kMostNames * (kMostNames + 1) / 2;

/// Refuses what nests too deeply, names a field twice or has too many names, while it is read.
class Strict {
 public:
  bool operator()(int depth, Json::parse_event_t event, Json& parsed) {
    switch (event) {
      case Json::parse_event_t::object_start:
        names_.emplace_back();
        too_deep_ = too_deep_ || depth > kMostDepth;
        break;
      case Json::parse_event_t::object_end:
        names_.pop_back();
        break;
      case Json::parse_event_t::array_start:
        too_deep_ = too_deep_ || depth > kMostDepth;
        break;
      case Json::parse_event_t::key:
        twice_ = twice_ || !names_.back().insert(parsed.get<std::string>()).second;
        comparisons_ += names_.back().size();
        break;
      default:
        break;
    }
    return good();
  }
  [[nodiscard]] bool good() const { return !too_deep_ && !twice_ && comparisons_ <= kMostComparisons; }

 private:
  std::vector<std::set<std::string>> names_;
  bool too_deep_ = false, twice_ = false;
  std::size_t comparisons_ = 0;
};

std::optional<std::string> decoded(std::string_view text) {
  std::string out;
  const auto digit = [](char c) {
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '+') {
      out += ' ';
    } else if (text[i] != '%') {
      out += text[i];
    } else {
      if (i + 2 >= text.size() || digit(text[i + 1]) < 0 || digit(text[i + 2]) < 0) return std::nullopt;
      out += static_cast<char>(digit(text[i + 1]) * 16 + digit(text[i + 2]));
      i += 2;
    }
  }
  if (!core::is_utf8(out)) return std::nullopt;
  return out;
}

}  // namespace

std::optional<Refusal> wrong_fields(const Json& object, std::span<const Field> fields) {
  if (!object.is_object()) return wrong("", "the request must be a JSON object");
  return wrong_object(object, fields, "");
}

std::optional<Json> parse_json(std::string_view text) {
  // The parser goes through the nesting without a stack of calls, but what it builds is destroyed with one.
  int depth = 0;
  bool in_text = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_text) {
      if (c == '\\') ++i;
      in_text = c != '"';
    } else if (c == '"') {
      in_text = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kMostDepth) return std::nullopt;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  Strict strict;
  Json parsed = Json::parse(
      text, [&strict](int at, Json::parse_event_t event, Json& value) { return strict(at, event, value); }, false);
  if (parsed.is_discarded() || !strict.good()) return std::nullopt;
  return parsed;
}

std::optional<Json> query_json(std::string_view query, std::span<const Field> fields) {
  Json object = Json::object();
  while (!query.empty()) {
    const std::size_t end = query.find('&');
    const std::string_view part = query.substr(0, end);
    query = end == std::string_view::npos ? std::string_view{} : query.substr(end + 1);
    if (part.empty()) continue;
    const std::size_t equals = part.find('=');
    const auto name = decoded(part.substr(0, equals));
    const auto text = decoded(equals == std::string_view::npos ? std::string_view{} : part.substr(equals + 1));
    if (!name || !text) return std::nullopt;
    const auto field = std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.name == *name; });
    if (field != fields.end() && field->type == FieldType::kTexts) {
      object[*name].push_back(*text);
      continue;
    }
    if (object.contains(*name)) return std::nullopt;
    object[*name] = *text;
    if (field == fields.end()) return object;  // wrong_fields() says so, whatever follows
    if (field->type == FieldType::kInteger) {
      std::int64_t number = 0;
      const auto read = std::from_chars(text->data(), text->data() + text->size(), number);
      if (read.ec == std::errc{} && read.ptr == text->data() + text->size()) object[*name] = number;
    } else if (field->type == FieldType::kNumber) {
      double number = 0;
      const auto read = std::from_chars(text->data(), text->data() + text->size(), number);
      const bool whole = read.ec == std::errc{} && read.ptr == text->data() + text->size();
      if (whole && std::isfinite(number)) object[*name] = number;
    } else if (field->type == FieldType::kBoolean && (*text == "true" || *text == "false")) {
      object[*name] = *text == "true";
    }
  }
  return object;
}

}  // namespace plc::engineering
