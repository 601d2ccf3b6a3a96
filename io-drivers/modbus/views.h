// Views: where Modbus shows the areas %I, %Q and %M (OpenPLC's map).
//
// In: locations. Out: the table and the addresses that each kind of them has. Does not belong here: variables, rights,
// automatic addresses.
#pragma once

#include <cstdint>

#include "io-drivers/config/configuration.h"
#include "runtime/memory/location.h"

namespace plc::modbus {

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
const View* view_of(const runtime::Location& location);

}  // namespace plc::modbus
