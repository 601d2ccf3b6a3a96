#include "tools/plc/remote_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

namespace plc::tools {

using engineering::Call;
using engineering::Field;
using engineering::FieldType;
using engineering::Json;

Json value_of(std::string_view text) {
  if (text == "TRUE" || text == "FALSE") return text == "TRUE";
  Json value = Json::parse(text, nullptr, false);
  return value.is_discarded() ? Json(text) : value;
}

std::string shown_value(const Json& value) {
  if (value.is_boolean()) return value.get<bool>() ? "TRUE" : "FALSE";
  return value.is_string() ? value.get<std::string>() : value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string read_fields(const Call& call, const std::vector<std::string>& words, Json& fields) {
  fields = Json::object();
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    const std::string name = word.substr(0, equals);
    const auto field =
        std::find_if(call.request.begin(), call.request.end(), [&](const Field& f) { return f.name == name; });
    if (equals == std::string::npos) return fmt::format("\"{}\" is not FIELD=VALUE", word);
    if (field == call.request.end()) return fmt::format("{} has no field \"{}\"", call.name, name);
    const std::string text = word.substr(equals + 1);
    if (field->type == FieldType::kFile) {
      std::ifstream in(text, std::ios::binary);
      if (!in) return fmt::format("{} cannot be read: {}", text, std::strerror(errno));
      fields[name] = std::string{std::istreambuf_iterator<char>(in), {}};
    } else if (field->type == FieldType::kText) {
      fields[name] = text;
    } else if (field->type == FieldType::kTexts) {
      fields[name].push_back(text);
    } else {
      fields[name] = value_of(text);
    }
  }
  return {};
}

std::string fields_text(const Call& call) {
  if (call.request.empty()) return fmt::format("{} takes no fields", call.name);
  std::string text;
  for (const Field& field : call.request) {
    text += (text.empty() ? "" : ", ") + std::string(field.name) + (field.required ? "" : " (optional)");
  }
  return fmt::format("{} takes {}", call.name, text);
}

}  // namespace plc::tools
