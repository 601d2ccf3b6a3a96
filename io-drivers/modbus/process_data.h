// ProcessData: Modbus bits and registers over the global table: which bits of which values, packed and unpacked.
//
// In: AddressMap, the global table. Out: cells as one request sees and writes them: reads of one snapshot per owner,
// writes as one batch of whole values or bit masks, so that changing half a value happens at its owner and never tears
// the other half. Threads: constructed while no task runs, then one thread. Nothing is allocated after the largest
// request. Does not belong here: function codes, frames.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "io-drivers/modbus/address_map.h"
#include "io-drivers/modbus/coil_latch.h"
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

  /// Where the system's registers come from; they read 0 without. Before the first request.
  void set_system(SystemSource source) { system_ = std::move(source); }

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
  /// Writes all that was collected, or nothing. Resets of latched coils may wait for release_coils().
  Exception commit();

  /// How many scans tasks have made, for coils that are latched (coil_latch.h). Before the first request.
  void set_scans(ScanSource source) { latch_.set_scans(std::move(source)); }
  [[nodiscard]] bool has_waiting_coils() const { return latch_.any_waits(); }
  /// Resets the coils whose time has come.
  void release_coils();

 private:
  /// What the present request knows of a point: its value when that is not in the block, or what is to become of it.
  struct Slot {
    std::uint64_t request = 0;  ///< the one it is of
    std::uint64_t value = 0;
    std::uint64_t mask = 0;
  };
  struct Layout {
    std::uint32_t offset = 0;      ///< in the table
    std::uint8_t bytes = 0;        ///< in the table
    std::uint8_t value_bits = 0;   ///< that mean something: 1 for BOOL
    bool sign_extended = false;    ///< SINT in a register of its own
    std::uint16_t characters = 0;  ///< of a text, which `bytes` and `value_bits` do not count
    bool wide = false;
  };

  /// Addresses first .. end - 1 of a table, all inside the map.
  struct Run {
    std::uint32_t first = 0;
    std::uint32_t end = 0;
  };

  /// A register that is just two bytes of the table, low one first, has their offset as its source; others one of
  /// these.
  static constexpr std::uint32_t kGap = 0xffffffffu;
  static constexpr std::uint32_t kComposed = 0xfffffffeu;  ///< of its cells

  [[nodiscard]] std::uint32_t make_source(Table table, std::uint32_t address) const;
  [[nodiscard]] std::uint32_t source(Table table, std::uint32_t address) const {
    const std::vector<std::uint32_t>& of_table = sources_[static_cast<std::size_t>(table)];
    return address < of_table.size() ? of_table[address] : kGap;
  }
  /// Takes the part of the table that the request reads as one block.
  void fetch(Table table, std::uint32_t first, std::uint32_t count);
  std::uint64_t value_of(std::uint32_t point);
  std::uint16_t cell_value(Table table, std::uint32_t address);
  /// Register `index` of a text as it is in the table.
  std::uint16_t text_register(std::uint32_t point, std::uint32_t index);
  /// The next register of a text as it shall be.
  bool change_text(std::uint32_t point, std::uint32_t index, std::uint16_t value, std::uint16_t mask);
  /// The value that change_text() has put together; false when it has characters beyond those of its type.
  bool finish_text(std::uint32_t point);
  void put_system(std::uint32_t first, std::span<std::uint8_t> bytes) const;

  runtime::GlobalTable& globals_;
  const AddressMap& map_;
  runtime::GlobalReader reader_;
  SystemSource system_;
  CoilLatch latch_;
  std::vector<Run> inside_[4];             ///< by table, ascending
  std::vector<std::uint32_t> sources_[4];  ///< by table and address, up to the last that is no gap; bit tables: none
  std::vector<Layout> layouts_;            ///< parallel to map_.points()
  std::vector<Slot> slots_;                ///< parallel to map_.points()
  /// The part of the table that the present request reads, when it is small; 8 bytes more, so that any value can be
  /// loaded.
  std::array<std::byte, 2048 + 8> block_;
  std::uint32_t block_begin_ = 0;
  std::uint32_t block_bytes_ = 0;
  std::uint64_t request_ = 0;
  std::vector<std::byte> text_;  ///< the text that was read last
  std::uint32_t text_point_ = 0;
  std::uint64_t text_request_ = 0;      ///< the one it was read in
  std::vector<std::byte> new_texts_;    ///< of the present request: values one after another
  std::vector<std::uint32_t> changed_;  ///< points
  std::vector<std::uint32_t> later_;    ///< those of them whose reset waits
  std::vector<runtime::GlobalWrite> batch_;
};

}  // namespace plc::modbus
