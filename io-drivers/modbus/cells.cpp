#include "io-drivers/modbus/cells.h"

#include <algorithm>

namespace plc::modbus {
namespace {

constexpr std::uint32_t kAddresses = 65536;

/// The second cell goes on where the first ends, in the register and in the value.
bool joins(const Cell& first, const Cell& second) {
  return first.point == second.point && first.cell_bit + first.bits == second.cell_bit &&
         first.value_bit + first.bits == second.value_bit;
}

}  // namespace

void CellMaker::add(Table table, std::uint32_t address, const Cell& cell) {
  const std::uint32_t place = static_cast<std::uint32_t>(table) * kAddresses + address;
  const auto mask = static_cast<std::uint16_t>(((1u << cell.bits) - 1) << cell.cell_bit);
  if ((covered_[place] & mask) != 0) return;
  covered_[place] = static_cast<std::uint16_t>(covered_[place] | mask);
  placed_.push_back({place, cell});
}

void CellMaker::add_to_unit(std::uint32_t index, std::uint32_t value_bit, const Unit& unit, std::uint32_t unit_bit,
                            std::uint32_t bits) {
  const bool many = unit.registers > 1;
  const bool low_word_first = many && (unit.order == io::WordOrder::kCdab || unit.order == io::WordOrder::kDcba);
  const bool low_byte_first = many && (unit.order == io::WordOrder::kBadc || unit.order == io::WordOrder::kDcba);
  const std::uint32_t word = unit_bit / 16;
  const std::uint32_t at = unit.address + (low_word_first ? word : unit.registers - 1 - word);
  const std::uint32_t cell_bit = low_byte_first ? (unit_bit % 16) ^ 8u : unit_bit % 16;
  add(unit.table, at,
      {index, static_cast<std::uint16_t>(value_bit), static_cast<std::uint8_t>(cell_bit),
       static_cast<std::uint8_t>(bits)});
}

void CellMaker::add_point(std::uint32_t index, const Point& point) {
  for (std::uint32_t i = 0; point.characters != 0 && i < point.registers; ++i) {
    add(point.table, point.address + i, {index, static_cast<std::uint16_t>(i), 0, 16});
  }
  if (point.characters != 0) return;
  if (point.registers <= 1) {
    const std::uint8_t bits = point.registers == 0 ? 1 : 16;
    add(point.table, point.address, {index, 0, 0, bits});
    return;
  }
  const Unit unit = {point.table, point.address, point.registers, point.word_order};
  for (std::uint32_t bit = 0; bit < point.registers * 16u; bit += 8) add_to_unit(index, bit, unit, bit, 8);
}

void CellMaker::add_view(std::uint32_t index, const runtime::Location& location, const View& view,
                         const OrderAt& order_at) {
  const std::uint32_t step = view.bits == 1 ? 1 : std::min(location.bits, 8u);
  for (std::uint32_t bit = 0; bit < location.bits; bit += step) {
    const std::uint64_t at = location.first_bit + bit;
    if (at / view.bits >= view.count) return;
    const std::uint32_t address = view.base + static_cast<std::uint32_t>(at / view.bits) * view.width();
    const auto unit_bit = static_cast<std::uint32_t>(at % view.bits);
    if (view.bits == 1) {
      add(view.table, address, {index, static_cast<std::uint16_t>(bit), 0, 1});
    } else {
      add_to_unit(index, bit, {view.table, address, view.width(), order_at(view.table, address)}, unit_bit, step);
    }
  }
}

std::vector<Cell> CellMaker::finish(std::vector<std::uint32_t> (&begin)[4]) {
  std::sort(placed_.begin(), placed_.end(), [](const Placed& a, const Placed& b) {
    return a.place != b.place ? a.place < b.place : a.cell.cell_bit < b.cell.cell_bit;
  });
  std::vector<Cell> cells;
  std::uint32_t end[4] = {};
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    const std::uint32_t table = placed_[i].place / kAddresses;
    if (i != 0 && placed_[i - 1].place == placed_[i].place && joins(cells.back(), placed_[i].cell)) {
      cells.back().bits = static_cast<std::uint8_t>(cells.back().bits + placed_[i].cell.bits);
      continue;
    }
    begin[table].resize(placed_[i].place % kAddresses + 1, static_cast<std::uint32_t>(cells.size()));
    cells.push_back(placed_[i].cell);
    end[table] = static_cast<std::uint32_t>(cells.size());
  }
  for (std::size_t table = 0; table < 4; ++table) begin[table].push_back(end[table]);
  return cells;
}

}  // namespace plc::modbus
