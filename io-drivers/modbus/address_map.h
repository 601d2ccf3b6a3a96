// AddressMap: which Modbus address is which global variable (docs/guides/modbus.md).
//
// In: a resource, [modbus] of plc.toml, frozen automatic addresses. Out: points, sorted; lookup by table and address.
// Located variables follow OpenPLC: %QXb.i coil 8b+i (0..8191), %MXb.i coil 8192+8b+i, %IXb.i discrete input 8b+i,
// %IWn input register n (0..1023), %IDn 2048+2n and %ILn 4096+4n there, %QWn holding n (0..1023), %MWn 1024+n,
// %MDn 2048+2n, %MLn 4096+4n (n 0..1023); bytes %IBn/%QBn/%MBn, %QDn and %QLn have no place in that map and get
// automatic addresses like unlocated variables. Automatic area: from 16384 on in every table, aligned to the size:
// BOOLs that may not be written from outside as discrete inputs, other BOOLs as coils, constants and driver inputs as
// input registers, the rest as holding registers. Scalars, texts and arrays of them, also inside structures.
// Texts come after all others, and are written from their first register on. Under --profile=overlay the located areas
// are one bit field per %I, %Q, %M: a register shows whatever located variables share its bits. Immutable once built,
// any thread. Does not belong here: values, protocol.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bytecode/image.h"
#include "core/types.h"
#include "io-drivers/config/configuration.h"
#include "io-drivers/modbus/system_points.h"
#include "runtime/resource.h"

namespace plc::modbus {

using Table = io::ModbusTable;

inline constexpr std::uint32_t kAutomaticFirst = 16384;

/// One scalar variable (or array element) at one address.
struct Point {
  std::string path;          ///< as runtime::Access knows it: "Main.Level", "Recipe[3].Time"
  std::string iec_address;   ///< "%QX0.1", or empty
  std::uint32_t offset = 0;  ///< in the global table
  std::uint32_t type = 0;    ///< index into Image::types
  core::TypeId elementary = core::TypeId::kBool;
  Table table = Table::kHoldingRegisters;
  std::uint16_t address = 0;     ///< PDU address, from 0
  std::uint16_t registers = 0;   ///< 1, 2 or 4, of a text as many as its characters need; 0 = a bit (BOOL)
  std::uint16_t characters = 0;  ///< that a STRING (two a register) or WSTRING (one) holds; 0 = of another type
  bool writable = false;
  bool automatic = false;
  bool latch = false;  ///< a coil that stays set until the program has seen it
  io::WordOrder word_order = io::WordOrder::kAbcd;
};

/// What is at one bit or register of a table: part of a point, or of several (overlay). Word order is already in
/// it: under BADC and DCBA a register is two cells of eight bits. An 8-bit value alone in a register is a cell of 16
/// bits: readers extend values by their type (SINT keeps its sign), and refuse a written register that no value of it
/// gives.
struct Cell {
  std::uint32_t point = 0;      ///< index into points()
  std::uint16_t value_bit = 0;  ///< first bit of the value that shows here (0 = least significant); of a text: which
                                ///< of its registers
  std::uint8_t cell_bit = 0;    ///< first bit of the register it shows at; 0 in bit tables
  std::uint8_t bits = 16;       ///< how many; cells of one register share no bit
};

/// Automatic addresses given before: path -> (table, address). Kept in a file so that a recompile moves nothing.
struct FrozenAddresses {
  struct Entry {
    Table table;
    std::uint16_t address;
    core::TypeId elementary;
    std::uint16_t characters = 0;  ///< of texts
  };
  std::map<std::string, Entry> entries;  ///< by path; variables that are gone keep theirs
  bool changed = false;                  ///< build() added entries
};

/// Registers of a value, 0 = a bit.
constexpr std::uint32_t registers_of(core::TypeId type, std::uint32_t characters) {
  const core::Rep rep = core::rep_of(type);
  if (rep == core::Rep::kStr) return (characters + 1) / 2;
  if (rep == core::Rep::kWstr) return characters;
  return type == core::TypeId::kBool ? 0 : (core::rep_bytes(rep) + 1) / 2;
}

class AddressMap {
 public:
  /// Reports (P75xx) areas that are full, a lock file that contradicts itself, patterns that match nothing, ranges that
  /// split a value. Nothing on an error. `frozen` gets an entry for every variable with an automatic address.
  static std::optional<AddressMap> build(runtime::Resource& resource, const io::ModbusConfig& config,
                                         FrozenAddresses& frozen, core::Diagnostics& diagnostics);

  /// By table, then address, then path.
  [[nodiscard]] std::span<const Point> points() const { return points_; }
  /// What shows at a bit or register; empty for a gap. At most 16 cells.
  [[nodiscard]] std::span<const Cell> at(Table table, std::uint16_t address) const {
    const std::vector<std::uint32_t>& begin = cell_begin_[static_cast<std::size_t>(table)];
    if (std::size_t{address} + 1 >= begin.size()) return {};
    return std::span(cells_).subspan(begin[address], begin[address + 1u] - begin[address]);
  }
  /// True when the address is inside the map, with a variable or as a gap that reads 0: coils 0..16383, discrete inputs
  /// 0..8191, holding registers 0..8191, input registers 0..1023 (more with %ID, %IL), the automatic area up to its
  /// last variable; always the system's input registers (system_points.h). Under strict_gaps only where a value is.
  [[nodiscard]] bool contains(Table table, std::uint16_t address) const;
  /// Word order of the system's registers of two words (system_points.h).
  [[nodiscard]] io::WordOrder system_order() const { return system_order_; }

 private:
  std::vector<Point> points_;
  struct Area {
    std::uint32_t first = 0;
    std::uint32_t end = 0;
  };
  std::vector<Area> areas_[4];
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> cell_begin_[4];  ///< per address of the table, up to its last point
  bool strict_gaps_ = false;
  io::WordOrder system_order_ = io::WordOrder::kAbcd;
};

/// Where the lock file of a project is: [modbus] lock_file from the folder of plc.toml on, else NAME.modbus.csv beside
/// the project file or image.
std::string lock_file_of(const io::Configuration& configuration, const std::string& project);
/// The lock file: CSV "path,table,address,type". P75xx on a file that is none.
core::Result<FrozenAddresses> read_frozen(const std::string& path);  ///< a missing file is an empty one
/// Those of an image that was compiled with frozen addresses, and those of the lock file, which may have more. P7507
/// when the two give one variable different addresses: clients would write to another one than they mean.
core::Result<FrozenAddresses> read_frozen(const std::string& path, const bytecode::Image& image);
std::string frozen_text(const FrozenAddresses& frozen);

}  // namespace plc::modbus
