// The widths of elementary types for who looks at bytes: SIZEOF, pointers, unions. They are those of CODESYS, not those
// of the tables that programs run on.
//
// In: an elementary type. Out: bytes; what a step of a duration or date is. Does not belong here: layouts of structures
// (ir/foreign_size.h, runtime/pointers/packed_types.h).
#pragma once

#include <cstdint>

#include "core/types.h"

namespace plc::core {

/// Nanoseconds that one step of the 32-bit number stands for, as which pointers see a TIME, TIME_OF_DAY (ms), DATE or
/// DATE_AND_TIME (s); 0 for types that they see as they are.
constexpr std::int64_t packed_step_ns(TypeId type) {
  if (type == TypeId::kTime || type == TypeId::kTod) return 1'000'000;
  return type == TypeId::kDate || type == TypeId::kDt ? 1'000'000'000 : 0;
}
/// Bytes of a type other than STRING and WSTRING.
constexpr std::uint32_t packed_bytes(TypeId type) { return packed_step_ns(type) != 0 ? 4 : rep_bytes(rep_of(type)); }

}  // namespace plc::core
