// ProcessData: Modbus bits and registers over the global table: which bits of which values, packed and unpacked.
//
// In: AddressMap, the global table. Out: cells as one request sees and writes them: reads of one snapshot per owner,
// writes as one batch of whole values or bit masks, so that changing half a value happens at its owner and never tears
// the other half. Threads: constructed while no task runs, then one thread. Nothing is allocated after the largest
// request. Does not belong here: function codes, frames.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io-drivers/modbus/address_map.h"
#include "runtime/memory/global_ports.h"
#include "runtime/resource.h"

namespace plc::modbus {

/// Exception codes of the protocol.
enum class Exception : std::uint8_t {
  kNone = 0,
  kIllegalFunction = 1,
  kIllegalAddress = 2,
  kIllegalValue = 3,
  kDeviceFailure = 4,
  kBusy = 6,
  kWrongUnit = 11,
};

class ProcessData {
 public:
  /// Set-up only: it becomes a reader of the table. Both must outlive it.
  ProcessData(runtime::Resource& resource, const AddressMap& map);

  /// Whether all of `count` cells from `first` on are inside the map; there is no wrap past 65535.
  [[nodiscard]] bool contains(Table table, std::uint32_t first, std::uint32_t count) const;

  /// Bits into bytes, the first one lowest; bits of the last byte that were not asked for are 0.
  void read_bits(Table table, std::uint32_t first, std::span<std::uint8_t> bytes, std::uint32_t count);
  /// Registers, high byte first: two bytes each.
  void read_registers(Table table, std::uint32_t first, std::span<std::uint8_t> bytes);

  /// Collects the changes of one request, for commit().
  void begin_write();
  /// One bit, or the bits of a register that are set in `mask`. False when a variable there must not be written.
  [[nodiscard]] bool change(Table table, std::uint32_t address, std::uint16_t value, std::uint16_t mask);
  /// Writes all that was collected, or nothing.
  Exception commit();

 private:
  /// What the present request knows of a point. Values are little-endian as in the table, in a register at least.
  struct Slot {
    std::uint64_t request = 0;  ///< the one it is of
    std::uint64_t value = 0;
    std::uint64_t mask = 0;
  };
  struct Layout {
    std::uint8_t bytes = 0;       ///< in the table
    std::uint8_t value_bits = 0;  ///< that mean something: 1 for BOOL
    bool sign_extended = false;   ///< SINT in a register of its own
  };

  std::uint64_t value_of(std::uint32_t point);
  std::uint16_t cell_value(Table table, std::uint32_t address);

  runtime::GlobalTable& globals_;
  const AddressMap& map_;
  runtime::GlobalReader reader_;
  std::vector<Layout> layouts_;  ///< parallel to map_.points()
  std::vector<Slot> slots_;      ///< parallel to map_.points()
  std::uint64_t request_ = 0;
  std::vector<std::uint32_t> changed_;  ///< points
  std::vector<runtime::GlobalWrite> batch_;
};

}  // namespace plc::modbus
