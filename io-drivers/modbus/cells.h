// CellMaker: which bits of which values show at every address of the four tables.
//
// In: points with their addresses and word orders; under --profile=overlay also the views of the areas they lie in.
// Out: cells by address. Does not belong here: where a point gets its address from.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "io-drivers/modbus/address_map.h"
#include "io-drivers/modbus/views.h"

namespace plc::modbus {

/// Word order of a value of several registers that begins at the address.
using OrderAt = std::function<io::WordOrder(Table, std::uint32_t)>;

class CellMaker {
 public:
  /// The point at its own address. What was added first keeps its bits: own addresses come before views.
  void add_point(std::uint32_t index, const Point& point);
  /// Those bits of a located point that show in `view` and are not covered yet.
  void add_view(std::uint32_t index, const runtime::Location& location, const View& view, const OrderAt& order_at);
  /// Cells by table and address. Those of an address are begin[table][address] .. begin[table][address + 1]; `begin`
  /// ends after the last address that has any.
  std::vector<Cell> finish(std::vector<std::uint32_t> (&begin)[4]);

 private:
  struct Unit {
    Table table;
    std::uint32_t address;
    std::uint32_t registers;
    io::WordOrder order;
  };
  struct Placed {
    std::uint32_t place;  ///< table * 65536 + address
    Cell cell;
  };
  void add(Table table, std::uint32_t address, const Cell& cell);
  /// `bits` of a value, all in one byte of it and of the unit.
  void add_to_unit(std::uint32_t index, std::uint32_t value_bit, const Unit& unit, std::uint32_t unit_bit,
                   std::uint32_t bits);

  std::vector<Placed> placed_;
  std::vector<std::uint16_t> covered_ = std::vector<std::uint16_t>(std::size_t{4} * 65536);  // by place
};

}  // namespace plc::modbus
