#include "convert/literals.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>

#include "frontend-st/keywords.h"
#include "frontend-st/lexer.h"

namespace plc::convert {
namespace {

using core::TypeId;
using ir::TypeKind;

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kDay = 86'400 * kSecond;

std::string duration_text(std::string_view prefix, std::int64_t ns) {
  static constexpr std::pair<const char*, std::int64_t> kUnits[] = {
      {"d", kDay}, {"h", 3'600 * kSecond}, {"m", 60 * kSecond}, {"s", kSecond}, {"ms", 1'000'000}, {"us", 1'000}};
  for (const auto& [unit, size] : kUnits) {
    if (ns != 0 && ns % size == 0) return fmt::format("{}#{}{}", prefix, ns / size, unit);
  }
  return ns == 0 ? fmt::format("{}#0s", prefix) : fmt::format("{}#{}ns", prefix, ns);
}

std::string time_of_day_text(std::int64_t ns) {
  const std::int64_t seconds = ns / kSecond;
  std::string text = fmt::format("{:02}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60);
  if (ns % kSecond == 0) return text;
  std::string fraction = fmt::format("{:09}", ns % kSecond);
  fraction.resize(fraction.find_last_not_of('0') + 1);
  return text + "." + fraction;
}

std::string date_text(std::int64_t days) {
  const std::chrono::year_month_day date{std::chrono::sys_days{std::chrono::days{days}}};
  return fmt::format("{:04}-{:02}-{:02}", static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                     static_cast<unsigned>(date.day()));
}

std::int64_t floor_div(std::int64_t a, std::int64_t b) { return a / b - (a % b < 0 ? 1 : 0); }

std::string quoted(std::string_view bytes) {
  std::string text = "'";
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '\'' || c == '$') {
      text += '$';
      text += c;
    } else if (byte >= 0x20 && byte < 0x7f) {
      text += c;
    } else {
      text += fmt::format("${:02X}", byte);
    }
  }
  return text + "'";
}

/// UTF-16LE as bytes.
std::string wide_quoted(std::string_view bytes) {
  std::string text = "\"";
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
    const unsigned unit =
        static_cast<unsigned char>(bytes[i]) | static_cast<unsigned>(static_cast<unsigned char>(bytes[i + 1])) << 8;
    if (unit == '"' || unit == '$') {
      text += '$';
      text += static_cast<char>(unit);
    } else if (unit >= 0x20 && unit < 0x7f) {
      text += static_cast<char>(unit);
    } else {
      text += fmt::format("${:04X}", unit);
    }
  }
  return text + "\"";
}

/// Digits that read back as the same number, with a point or an exponent.
template <class Real>
std::optional<std::string> real_text(std::string_view type, Real value) {
  if (!std::isfinite(value)) return std::nullopt;
  std::string text = fmt::format("{}", value);
  const std::size_t exponent = text.find('e');
  if (text.find('.') == std::string::npos) text.insert(exponent == std::string::npos ? text.size() : exponent, ".0");
  return fmt::format("{}#{}", type, text);
}

std::int64_t signed_value(std::uint64_t bits, core::Rep rep) {
  switch (rep) {
    case core::Rep::kI8:
      return static_cast<std::int8_t>(bits);
    case core::Rep::kI16:
      return static_cast<std::int16_t>(bits);
    case core::Rep::kI32:
      return static_cast<std::int32_t>(bits);
    default:
      return static_cast<std::int64_t>(bits);
  }
}

std::optional<std::string> elementary_text(TypeId id, std::uint64_t bits) {
  const auto value = static_cast<std::int64_t>(bits);
  switch (id) {
    case TypeId::kBool:
      return bits != 0 ? "TRUE" : "FALSE";
    case TypeId::kReal:
      return real_text("REAL", std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    case TypeId::kLreal:
      return real_text("LREAL", std::bit_cast<double>(bits));
    case TypeId::kTime:
      return duration_text("T", value);
    case TypeId::kLtime:
      return duration_text("LT", value);
    case TypeId::kDate:
      return "D#" + date_text(floor_div(value, kDay));
    case TypeId::kLdate:
      return "LD#" + date_text(floor_div(value, kDay));
    case TypeId::kTod:
      return "TOD#" + time_of_day_text(value);
    case TypeId::kLtod:
      return "LTOD#" + time_of_day_text(value);
    case TypeId::kDt:
    case TypeId::kLdt: {
      const std::int64_t day = floor_div(value, kDay);
      return fmt::format("{}#{}-{}", id == TypeId::kDt ? "DT" : "LDT", date_text(day),
                         time_of_day_text(value - day * kDay));
    }
    case TypeId::kChar:
      return "CHAR#" + quoted(std::string(1, static_cast<char>(bits)));
    case TypeId::kWchar: {
      const char bytes[] = {static_cast<char>(bits & 0xff), static_cast<char>(bits >> 8 & 0xff)};
      return "WCHAR#" + wide_quoted(std::string_view(bytes, 2));
    }
    default:
      break;
  }
  const core::Rep rep = core::rep_of(id);
  const bool is_signed =
      rep == core::Rep::kI8 || rep == core::Rep::kI16 || rep == core::Rep::kI32 || rep == core::Rep::kI64;
  if (is_signed) return fmt::format("{}#{}", core::name_of(id), signed_value(bits, rep));
  return core::in_category(id, core::kAnyBit) ? fmt::format("{}#16#{:X}", core::name_of(id), bits)
                                              : fmt::format("{}#{}", core::name_of(id), bits);
}

}  // namespace

std::optional<std::string> literal_text(const ir::TypeTable& types, const ir::Constant& constant) {
  const ir::Type& type = types[constant.type];
  if (type.kind == TypeKind::kString) {
    return type.elementary == TypeId::kWstring ? wide_quoted(constant.text) : quoted(constant.text);
  }
  if (type.kind == TypeKind::kEnum) {
    const std::int64_t value = signed_value(constant.bits, core::rep_of(type.elementary));
    const auto member = std::find_if(type.members.begin(), type.members.end(),
                                     [&](const ir::EnumMember& one) { return one.value == value; });
    if (member == type.members.end() || !st::is_identifier(type.name)) return std::nullopt;
    return type.name + "#" + member->name;
  }
  const auto id = types.elementary_of(constant.type);
  return id ? elementary_text(*id, constant.bits) : std::nullopt;
}

std::string name_text(std::string_view name) {
  return std::string(name) + (st::keyword_of(name) == st::Keyword::kNone ? "" : "_");
}

std::optional<std::string> type_text(const ir::TypeTable& types, ir::TypeRef type) {
  const ir::Type& t = types[type];
  if (!t.name.empty()) return st::is_identifier(t.name) ? std::optional(t.name) : std::nullopt;
  switch (t.kind) {
    case TypeKind::kArray: {
      if (t.open) return std::nullopt;
      const auto element = type_text(types, t.element);
      if (!element) return std::nullopt;
      return fmt::format("ARRAY [{}..{}] OF {}", t.lower, t.upper, *element);
    }
    case TypeKind::kReference: {
      const auto target = type_text(types, t.element);
      return target ? std::optional("REF_TO " + *target) : std::nullopt;
    }
    case TypeKind::kPointer: {
      const auto target = type_text(types, t.element);
      return target ? std::optional("POINTER TO " + *target) : std::nullopt;
    }
    case TypeKind::kStruct:
    case TypeKind::kUnion:
    case TypeKind::kEnum:
      return std::nullopt;
    default:
      return types.name_of(type);
  }
}

}  // namespace plc::convert
