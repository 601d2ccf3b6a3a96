// Values of devices whose protocol has numbers and knows no types of the standard.
//
// In and out: a value as the global table has it, and a number. Does not belong here: scales and offsets, which are a
// kind's own.
#pragma once

#include <cstddef>

#include "core/types.h"

namespace plc::io {

/// `number` as a value of a BOOL, an integer, a bit string, a REAL or an LREAL. BOOL: TRUE unless 0. Integers: the
/// nearest one; what does not fit becomes the nearest that does, and what is no number (NaN) becomes 0. Bounded; any
/// thread.
void store_number(core::TypeId type, double number, std::byte* value) noexcept;
/// Such a value as a number: exact to 53 bits. Bounded; any thread.
double load_number(core::TypeId type, const std::byte* value) noexcept;

}  // namespace plc::io
