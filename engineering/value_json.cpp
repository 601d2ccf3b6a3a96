#include "engineering/value_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "core/integer_at.h"
#include "core/text.h"
#include "core/utf8.h"
#include "core/windows_1252.h"
#include "runtime/value_text.h"

namespace plc::engineering {
namespace {

using bytecode::Image;
using bytecode::ImageField;
using bytecode::ImageType;
using bytecode::TypeKind;
using core::Code;
using core::Problem;
using core::Rep;

template <class T>
T load(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

/// A STRING has the characters of Windows-1252, a WSTRING units of UTF-16.
std::string characters_text(const std::byte* from, std::size_t length, bool wide) {
  std::string text;
  for (std::size_t i = 0; i < length; ++i) {
    char32_t character = wide ? load<char16_t>(from + 2 * i) : core::from_windows_1252(load<std::uint8_t>(from + i));
    if (wide && character >= 0xd800 && character < 0xe000) {
      const char32_t next = i + 1 < length ? load<char16_t>(from + 2 * (i + 1)) : 0;
      const bool pair = character < 0xdc00 && next >= 0xdc00 && next < 0xe000;
      character = pair ? 0x10000 + ((character - 0xd800) << 10) + (next - 0xdc00) : 0xfffd;
      i += pair ? 1 : 0;
    }
    core::append_utf8(character, text);
  }
  return text;
}

/// `shortest`: the shortest text that reads back the same.
Json real_json(double value, const std::string& shortest) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "Infinity" : "-Infinity";
  return Json::parse(shortest, nullptr, false);
}

std::string text_of(const ImageType& type, const std::byte* bytes, runtime::ValueStyle style) {
  std::string text;
  runtime::append_value(type, bytes, text, style);
  return text;
}

Json leaf_json(const ImageType& type, const std::byte* bytes) {
  if (type.kind == TypeKind::kString) {
    const auto header = load<core::StringHeader>(bytes);
    const bool wide = type.elementary == core::TypeId::kWstring;
    return characters_text(bytes + sizeof header, std::min(header.length, type.capacity), wide);
  }
  if (type.elementary == core::TypeId::kChar) return characters_text(bytes, 1, false);
  if (type.elementary == core::TypeId::kWchar) return characters_text(bytes, 1, true);
  if (!type.members.empty()) {
    const std::string name = text_of(type, bytes, runtime::ValueStyle::kNames);
    return name;
  }
  if (type.elementary == core::TypeId::kBool) return bytes[0] != std::byte{0};
  if (!core::in_category(type.elementary, core::kAnyNum | core::kAnyBit)) {
    return text_of(type, bytes, runtime::ValueStyle::kNames);
  }
  switch (bytecode::rep_of(type)) {
    case Rep::kF32:
      return real_json(load<float>(bytes), text_of(type, bytes, runtime::ValueStyle::kNumbers));
    case Rep::kF64:
      return real_json(load<double>(bytes), text_of(type, bytes, runtime::ValueStyle::kNumbers));
    case Rep::kI64:
    case Rep::kU64:  // numbers of JavaScript have 53 bits
      return text_of(type, bytes, runtime::ValueStyle::kNumbers);
    default:
      return *core::integer_at(bytecode::rep_of(type), bytes);
  }
}

bool is_hidden(const std::string& name) { return name.find('#') != std::string::npos; }

/// The text of a value as parse_value() takes it; nothing for what is no value of a leaf.
std::optional<std::string> text_of_json(const ImageType& type, const Json& value) {
  if (value.is_boolean())
    return type.elementary == core::TypeId::kBool ? std::optional(value.get<bool>() ? "1" : "0") : std::nullopt;
  if (value.is_number()) return value.dump();
  if (!value.is_string()) return std::nullopt;
  const auto& text = value.get_ref<const std::string&>();
  const bool characters = type.kind == TypeKind::kString || core::in_category(type.elementary, core::kAnyChar);
  if (!characters) {
    if (text == "Infinity") return "inf";
    return text == "-Infinity" ? "-inf" : text;
  }
  // As a literal: what is written is what is stored, also when it has quotes and dollars.
  const bool wide = type.elementary == core::TypeId::kWstring || type.elementary == core::TypeId::kWchar;
  std::string literal(1, wide ? '"' : '\'');
  for (std::size_t i = 0; i < text.size();) {
    const char32_t c = core::decode_utf8(text, i);
    if (!wide) {
      const auto byte = core::to_windows_1252(c);
      if (!byte) return std::nullopt;
      literal += fmt::format("${:02X}", unsigned{*byte});
    } else if (c > 0xffff) {
      literal += fmt::format("${:04X}${:04X}", static_cast<unsigned>(0xd800 + ((c - 0x10000) >> 10)),
                             static_cast<unsigned>(0xdc00 + ((c - 0x10000) & 0x3ff)));
    } else {
      literal += fmt::format("${:04X}", static_cast<unsigned>(c));
    }
  }
  return literal + (wide ? '"' : '\'');
}

}  // namespace

std::string type_name(const Image& image, std::uint32_t index) {
  const ImageType& type = image.types[index];
  switch (type.kind) {
    case TypeKind::kArray:
      return fmt::format("ARRAY [{}..{}] OF {}", type.lower, type.lower + std::int64_t{type.count} - 1,
                         type_name(image, type.element));
    case TypeKind::kRef:
      return "REF_TO " + (image.types[type.element].kind == TypeKind::kRef ? std::string("REF_TO ..")
                                                                           : type_name(image, type.element));
    case TypeKind::kString:
      return fmt::format("{}[{}]", core::name_of(type.elementary), type.capacity);
    case TypeKind::kStruct:
      return type.name.empty() ? "STRUCT" : type.name;
    case TypeKind::kScalar:
      break;
  }
  const std::string elementary(core::name_of(type.elementary));
  // A range that is declared with its variable has a name that no source can spell.
  if (!type.name.empty() && type.name.find(' ') == std::string::npos) return type.name;
  return type.limited ? fmt::format("{} ({}..{})", elementary, type.lower, type.upper) : elementary;
}

std::uint64_t leaf_count(const Image& image, std::uint32_t index) {
  const ImageType& type = image.types[index];
  if (type.kind == TypeKind::kArray) return type.count * leaf_count(image, type.element);
  if (type.kind != TypeKind::kStruct) return 1;
  std::uint64_t leaves = 0;
  for (const ImageField& field : type.fields) leaves += is_hidden(field.name) ? 0 : leaf_count(image, field.type);
  return leaves;
}

Json value_json(const Image& image, std::uint32_t index, const std::byte* bytes) {
  const ImageType& type = image.types[index];
  switch (type.kind) {
    case TypeKind::kArray: {
      Json value = Json::array();
      const std::uint32_t size = image.types[type.element].size;
      for (std::uint32_t i = 0; i < type.count; ++i) {
        value.push_back(value_json(image, type.element, bytes + std::size_t{i} * size));
      }
      return value;
    }
    case TypeKind::kStruct: {
      Json value = Json::object();
      // WHY not by name, which is looked for among those before it: a structure may have 20,000 of them, all different.
      auto& fields = value.get_ref<Json::object_t&>();
      fields.reserve(type.fields.size());
      for (const ImageField& field : type.fields) {
        if (!is_hidden(field.name)) fields.push_back({field.name, value_json(image, field.type, bytes + field.offset)});
      }
      return value;
    }
    case TypeKind::kRef:
      return nullptr;
    case TypeKind::kScalar:
    case TypeKind::kString:
      break;
  }
  return leaf_json(type, bytes);
}

std::optional<Problem> leaves_of(const Image& image, std::uint32_t index, const Json& value, std::uint32_t offset,
                                 std::vector<LeafValue>& leaves, std::string& field) {
  const ImageType& type = image.types[index];
  const auto no_value = [&] {
    return Problem{
        Code::P7102,
        fmt::format("{} is not a value of type {}",
                    value.dump(-1, ' ', true, Json::error_handler_t::replace).substr(0, 60), type_name(image, index)),
        type.kind == TypeKind::kStruct  ? "a structure is an object: {\"Field\": value}"
        : type.kind == TypeKind::kArray ? "an array is a list of all its elements"
                                        : ""};
  };
  const std::size_t depth = field.size();
  if (type.kind == TypeKind::kStruct) {
    if (!value.is_object()) return no_value();
    for (const auto& [name, part] : value.items()) {
      const auto found = std::find_if(type.fields.begin(), type.fields.end(), [&n = name](const ImageField& f) {
        return core::iequals(f.name, n) && !is_hidden(f.name);
      });
      field += "." + name;
      if (found == type.fields.end())
        return Problem{Code::P7101, type_name(image, index) + " has no field \"" + name + "\"", {}};
      if (found->constant) return Problem{Code::P7106, "the variable is declared CONSTANT", {}};
      if (auto problem = leaves_of(image, found->type, part, offset + found->offset, leaves, field)) return problem;
      field.resize(depth);
    }
    return std::nullopt;
  }
  if (type.kind == TypeKind::kArray) {
    if (!value.is_array() || value.size() != type.count) return no_value();
    const std::uint32_t size = image.types[type.element].size;
    for (std::uint32_t i = 0; i < type.count; ++i) {
      field += fmt::format("[{}]", i);
      if (auto problem = leaves_of(image, type.element, value[i], offset + i * size, leaves, field)) return problem;
      field.resize(depth);
    }
    return std::nullopt;
  }
  if (type.kind == TypeKind::kRef) return Problem{Code::P7106, "references are not written from outside", {}};
  const auto text = text_of_json(type, value);
  if (!text) return Problem{Code::P7103, no_value().message, {}};
  LeafValue leaf{offset, index, std::vector<std::byte>(type.size)};
  if (auto problem = runtime::parse_value(type, *text, leaf.bytes)) return problem;
  leaves.push_back(std::move(leaf));
  return std::nullopt;
}

}  // namespace plc::engineering
