// Location: a direct address as bits of its area, and the views in which Modbus shows the areas (OpenPLC's map).
//
// In: addresses as images have them: "%QX0.3", "%MW7". Out: Location, kViews. Does not belong here: variables, rights,
// automatic addresses.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "io-drivers/config/configuration.h"

namespace plc::modbus {

/// One location, or the first of an array.
struct Location {
  char area = 'I';              ///< 'I', 'Q' or 'M'
  std::uint32_t bits = 1;       ///< of one element: 1, 8, 16, 32 or 64
  std::uint64_t first_bit = 0;  ///< from the start of the area, a multiple of `bits`
  bool dotted = false;          ///< bits: written with a byte, "%QX1.3", not "%QX11"
};

/// Nothing for unlocated ("%I*") and hierarchical addresses ("%IW0.0.1"): they have no number in the area.
std::optional<Location> parse_location(std::string_view address);
/// Address of the element `index` places behind: "%QX1.7" + 1 is "%QX2.0".
std::string location_text(const Location& location, std::uint32_t index);

/// One area cut into units of one size, from `base` on in a table: unit n begins at base + n * registers().
struct View {
  io::ModbusTable table = io::ModbusTable::kHoldingRegisters;
  char area = 'M';
  std::uint32_t bits = 16;  ///< of a unit; 1 in bit tables
  std::uint32_t base = 0;
  std::uint32_t count = 0;  ///< units
  /// Cells of the table that a unit takes.
  [[nodiscard]] constexpr std::uint32_t width() const { return bits == 1 ? 1 : bits / 16; }
  [[nodiscard]] constexpr std::uint32_t end() const { return base + count * width(); }
};

inline constexpr View kViews[] = {
    {io::ModbusTable::kCoils, 'Q', 1, 0, 8192},
    {io::ModbusTable::kCoils, 'M', 1, 8192, 8192},
    {io::ModbusTable::kDiscreteInputs, 'I', 1, 0, 8192},
    {io::ModbusTable::kInputRegisters, 'I', 16, 0, 1024},
    {io::ModbusTable::kInputRegisters, 'I', 32, 2048, 1024},
    {io::ModbusTable::kInputRegisters, 'I', 64, 4096, 1024},
    {io::ModbusTable::kHoldingRegisters, 'Q', 16, 0, 1024},
    {io::ModbusTable::kHoldingRegisters, 'M', 16, 1024, 1024},
    {io::ModbusTable::kHoldingRegisters, 'M', 32, 2048, 1024},
    {io::ModbusTable::kHoldingRegisters, 'M', 64, 4096, 1024},
};

/// The view in which locations of this size have their place; null for bytes, %QD and %QL.
const View* view_of(const Location& location);

}  // namespace plc::modbus
