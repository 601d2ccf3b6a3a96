// The integer in the bytes of a value.
//
// In: a representation, bytes. Out: the number; nothing for what is none. Does not belong here: reals, texts
// (runtime/value_text.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>

#include "core/types.h"

namespace plc::core {

/// BOOL as 0 or 1; of 64 bits without sign those above the largest LINT as negative ones. Nothing for reals, texts and
/// references. `from` may be unaligned.
inline std::optional<std::int64_t> integer_at(Rep rep, const std::byte* from) {
  const auto load = [from](auto value) {
    std::memcpy(&value, from, sizeof value);
    return static_cast<std::int64_t>(value);
  };
  switch (rep) {
    case Rep::kBool:
      return load(std::uint8_t{}) != 0 ? 1 : 0;
    case Rep::kI8:
      return load(std::int8_t{});
    case Rep::kU8:
      return load(std::uint8_t{});
    case Rep::kI16:
      return load(std::int16_t{});
    case Rep::kU16:
      return load(std::uint16_t{});
    case Rep::kI32:
      return load(std::int32_t{});
    case Rep::kU32:
      return load(std::uint32_t{});
    case Rep::kI64:
    case Rep::kU64:
      return load(std::int64_t{});
    case Rep::kF32:
    case Rep::kF64:
    case Rep::kStr:
    case Rep::kWstr:
    case Rep::kRef:
      break;
  }
  return std::nullopt;
}

}  // namespace plc::core
