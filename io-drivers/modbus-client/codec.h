// Coding: how a variable is put into registers and bits of a device, and taken from there.
//
// In: cells, bytes of a variable as the global table has it. Out: the other. Pure, allocates nothing. Does not belong
// here: where the cells are (plan.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "bytecode/image.h"
#include "core/types.h"
#include "io-drivers/config/configuration.h"

namespace plc::modbus_client {

/// What the device has in its cells, in the order of the choices of `type`. kVariable: as wide as the variable.
enum class Raw : std::uint8_t { kVariable, kInt, kUint, kDint, kUdint, kLint, kUlint, kReal, kLreal };

struct Coding {
  core::TypeId variable = core::TypeId::kInt;
  Raw raw = Raw::kInt;  ///< never kVariable; without meaning for a BOOL
  io::WordOrder order = io::WordOrder::kAbcd;
  double scale = 1, offset = 0;  ///< variable = raw * scale + offset
  int bit = -1;                  ///< 0..15: a BOOL in a register
  bool invert = false;           ///< a BOOL
  std::uint16_t characters =
      0;  ///< of a text at most; two in a register, the first in its high byte, or one of a WSTRING
};

/// What a variable of this type is in a device that says nothing else.
Raw raw_of(core::TypeId variable);
/// Registers of the value: 1, 2 or 4.
std::uint16_t registers_of(Raw raw);
/// "a Modbus value is a BOOL, a number or a text" for types that cannot be coded, else empty.
std::string_view refuses(const bytecode::ImageType& type);

/// Values outside of the variable's type become its nearest; what is no number becomes 0. A text ends with the first 0,
/// or where the variable has no more room.
void decode(const Coding& coding, std::span<const std::uint16_t> cells, std::byte* value);
/// Sets the cells, of a bit in a register that bit alone; 0 behind the end of a text. Values outside of the raw type
/// become its nearest.
void encode(const Coding& coding, const std::byte* value, std::span<std::uint16_t> cells);

}  // namespace plc::modbus_client
