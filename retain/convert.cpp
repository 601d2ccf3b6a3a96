#include "retain/convert.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "core/integer_at.h"
#include "core/text.h"
#include "core/types.h"
#include "runtime/memory/global_table.h"
#include "runtime/value_text.h"

namespace plc::retain {
namespace {

using bytecode::ImageType;
using bytecode::TypeKind;
using core::Rep;

template <class T>
T load(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

bool is_whole(const ImageType& type) { return core::in_category(type.elementary, core::kAnyInt | core::kAnyBit); }
bool is_real(const ImageType& type) { return core::in_category(type.elementary, core::kAnyReal); }

/// Of a whole number. Those above the largest LINT are nothing.
std::optional<std::int64_t> whole(const ImageType& type, const std::byte* from) {
  const Rep rep = core::rep_of(type.elementary);
  const auto value = core::integer_at(rep, from);
  return rep == Rep::kU64 && *value < 0 ? std::nullopt : value;
}

double real(const ImageType& type, const std::byte* from) {
  return core::rep_of(type.elementary) == Rep::kF32 ? load<float>(from) : load<double>(from);
}

template <class T>
bool store_whole(std::int64_t value, std::byte* to) {
  const auto narrow = static_cast<T>(value);
  if (value < 0 && !std::is_signed_v<T>) return false;
  if (static_cast<std::int64_t>(narrow) != value) return false;
  std::memcpy(to, &narrow, sizeof narrow);
  return true;
}

bool put_whole(std::int64_t value, const ImageType& type, std::byte* to) {
  switch (core::rep_of(type.elementary)) {
    case Rep::kBool:
      return (value == 0 || value == 1) && store_whole<std::uint8_t>(value, to);
    case Rep::kI8:
      return store_whole<std::int8_t>(value, to);
    case Rep::kU8:
      return store_whole<std::uint8_t>(value, to);
    case Rep::kI16:
      return store_whole<std::int16_t>(value, to);
    case Rep::kU16:
      return store_whole<std::uint16_t>(value, to);
    case Rep::kI32:
      return store_whole<std::int32_t>(value, to);
    case Rep::kU32:
      return store_whole<std::uint32_t>(value, to);
    case Rep::kI64:
      return store_whole<std::int64_t>(value, to);
    case Rep::kU64:
      return store_whole<std::uint64_t>(value, to);
    default:
      return false;
  }
}

bool put_real(double value, const ImageType& type, std::byte* to) {
  if (core::rep_of(type.elementary) == Rep::kF64) {
    std::memcpy(to, &value, sizeof value);
    return true;
  }
  const auto narrow = static_cast<float>(value);
  if (std::isinf(narrow) && !std::isinf(value)) return false;
  std::memcpy(to, &narrow, sizeof narrow);
  return true;
}

/// The member of that name; nothing when there is none.
std::optional<std::int64_t> member_named(const ImageType& type, std::string_view name) {
  const core::NameEqual equal;
  for (std::size_t m = 0; m < type.members.size(); ++m) {
    if (equal(type.members[m], name)) return type.member_values[m];
  }
  return std::nullopt;
}
const std::string* member_of(const ImageType& type, std::int64_t value) {
  const auto found = std::find(type.member_values.begin(), type.member_values.end(), value);
  return found == type.member_values.end()
             ? nullptr
             : &type.members[static_cast<std::size_t>(found - type.member_values.begin())];
}

std::string type_word(const ImageType& type) {
  if (!type.name.empty()) return type.name;
  if (type.kind == TypeKind::kString) return fmt::format("{}[{}]", core::name_of(type.elementary), type.capacity);
  if (type.limited) return fmt::format("{} ({}..{})", core::name_of(type.elementary), type.lower, type.upper);
  return std::string(core::name_of(type.elementary));
}

std::string value_text(const ImageType& type, const std::byte* from) {
  std::string text;
  runtime::append_value(type, from, text, runtime::ValueStyle::kNames);
  return text;
}

std::string convert_text(const ImageType& was, const std::byte* from, const ImageType& is, std::byte* to) {
  const std::size_t unit = is.elementary == core::TypeId::kWstring ? 2 : 1;
  // A file may say what is not so.
  const std::uint16_t length = std::min(load<core::StringHeader>(from).length, was.capacity);
  if (length > is.capacity) return fmt::format("its {} characters do not fit into {}", length, type_word(is));
  std::memset(to, 0, is.size);
  const core::StringHeader header{is.capacity, length};
  std::memcpy(to, &header, sizeof header);
  std::memcpy(to + sizeof header, from + sizeof header, length * unit);
  return {};
}

/// TIME and LTIME; LWORD and ULINT.
bool is_same_kind(const ImageType& was, const ImageType& is) {
  const bool durations =
      core::in_category(was.elementary, core::kAnyDuration) && core::in_category(is.elementary, core::kAnyDuration);
  return durations || (is_whole(was) && is_whole(is) && core::rep_of(was.elementary) == core::rep_of(is.elementary));
}

/// False: the value is none of `is`.
bool convert_scalar(const ImageType& was, const std::byte* from, const ImageType& is, std::byte* to) {
  if (!was.members.empty() && !is.members.empty()) {
    const auto value = whole(was, from);
    const std::string* const name = value ? member_of(was, *value) : nullptr;
    if (name == nullptr) return false;
    const auto now = member_named(is, *name);
    return now && put_whole(*now, is, to);
  }
  if (was.elementary == is.elementary || is_same_kind(was, is)) {
    std::memcpy(to, from, is.size);
    return true;
  }
  if (is_whole(was) && is_whole(is)) {
    const auto value = whole(was, from);
    return value && put_whole(*value, is, to);
  }
  if (is_real(was) && is_real(is)) return put_real(real(was, from), is, to);
  if (is_whole(was) && is_real(is)) {
    const auto value = whole(was, from);
    // Exactly, as the program would count on.
    const bool exact = value && std::abs(*value) <= (core::rep_of(is.elementary) == Rep::kF32 ? 1 << 24 : 1LL << 53);
    return exact && put_real(static_cast<double>(*value), is, to);
  }
  return false;
}

bool related(const ImageType& was, const ImageType& is) {
  return was.elementary == is.elementary || is_same_kind(was, is) || (is_whole(was) && (is_whole(is) || is_real(is))) ||
         (is_real(was) && is_real(is));
}

}  // namespace

std::string convert_leaf(const ImageType& was, const std::byte* from, const ImageType& is, std::byte* to) {
  if (was.kind != is.kind || !related(was, is)) return fmt::format("was {} and is {}", type_word(was), type_word(is));
  if (was.kind == TypeKind::kString) return convert_text(was, from, is, to);
  std::byte value[8] = {};
  if (convert_scalar(was, from, is, value) && runtime::normalise(is, value)) {
    std::memcpy(to, value, is.size);
    return {};
  }
  return fmt::format("{} is not a value of {}", value_text(was, from), type_word(is));
}

}  // namespace plc::retain
