#include "io-drivers/modbus/process_data.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace plc::modbus {
namespace {

static_assert(std::endian::native == std::endian::little, "values are taken out of the table byte by byte");

constexpr std::uint64_t low_bits(unsigned count) {
  return count >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
}

bool is_bit_table(Table table) { return table == Table::kCoils || table == Table::kDiscreteInputs; }

constexpr std::uint32_t kAddresses = 65536;
/// More values than an FC15 over plain coils can touch; an overlay may need more once and then keeps it.
constexpr std::size_t kUsualChanges = 2048;

}  // namespace

ProcessData::ProcessData(runtime::Resource& resource, const AddressMap& map)
    : globals_(resource.globals()), map_(map), reader_(resource.globals()), slots_(map.points().size()) {
  layouts_.reserve(map.points().size());
  for (const Point& point : map.points()) {
    const core::Rep rep = core::rep_of(point.elementary);
    const auto bytes = static_cast<std::uint8_t>(core::rep_bytes(rep));
    layouts_.push_back({point.offset, bytes, static_cast<std::uint8_t>(rep == core::Rep::kBool ? 1 : 8 * bytes),
                        rep == core::Rep::kI8});
  }
  for (std::size_t table = 0; table < 4; ++table) {
    std::vector<Run>& runs = inside_[table];
    for (std::uint32_t address = 0; address < kAddresses; ++address) {
      if (!map.contains(static_cast<Table>(table), static_cast<std::uint16_t>(address))) continue;
      if (runs.empty() || runs.back().end != address) runs.push_back({address, address});
      ++runs.back().end;
      if (is_bit_table(static_cast<Table>(table)) ||
          map.at(static_cast<Table>(table), static_cast<std::uint16_t>(address)).empty())
        continue;
      sources_[table].resize(address + 1, kGap);
      sources_[table][address] = make_source(static_cast<Table>(table), address);
    }
  }
  changed_.reserve(kUsualChanges);
  batch_.reserve(kUsualChanges);
}

bool ProcessData::contains(Table table, std::uint32_t first, std::uint32_t count) const {
  const std::vector<Run>& runs = inside_[static_cast<std::size_t>(table)];
  const auto after =
      std::upper_bound(runs.begin(), runs.end(), first, [](std::uint32_t a, const Run& run) { return a < run.first; });
  return after != runs.begin() && first + count <= (after - 1)->end;
}

std::uint32_t ProcessData::make_source(Table table, std::uint32_t address) const {
  const std::span<const Cell> cells = map_.at(table, static_cast<std::uint16_t>(address));
  const Cell& cell = cells[0];
  const Layout& layout = layouts_[cell.point];
  const bool plain = cells.size() == 1 && cell.bits == 16 && cell.value_bit + 16u <= 8u * layout.bytes;
  return plain ? layout.offset + cell.value_bit / 8 : kComposed;
}

/// Neighbours in the map are mostly neighbours in the table: one copy from the first value to the last one instead of
/// one for each. What is elsewhere is read on its own.
void ProcessData::fetch(Table table, std::uint32_t first, std::uint32_t count) {
  ++request_;
  std::uint32_t begin = UINT32_MAX, end = 0;
  const auto include = [&](std::uint32_t address) {
    const std::span<const Cell> cells = map_.at(table, static_cast<std::uint16_t>(address));
    for (const Cell& cell : cells) {
      begin = std::min(begin, layouts_[cell.point].offset);
      end = std::max(end, layouts_[cell.point].offset + layouts_[cell.point].bytes);
    }
    return !cells.empty();
  };
  std::uint32_t low = first, high = first + count;
  while (low < high && !include(low)) ++low;
  while (high > low && !include(high - 1)) --high;
  block_begin_ = begin;
  block_bytes_ = begin < end && end - begin <= block_.size() - sizeof(std::uint64_t) ? end - begin : 0;
  if (block_bytes_ != 0) reader_.read(block_begin_, block_bytes_, block_.data());
}

/// A value is read once per request: its registers cannot be of two publications.
std::uint64_t ProcessData::value_of(std::uint32_t point) {
  const Layout& layout = layouts_[point];
  std::uint64_t value = 0;
  if (layout.offset - block_begin_ < block_bytes_) {
    std::memcpy(&value, block_.data() + (layout.offset - block_begin_), sizeof value);
    value &= low_bits(8u * layout.bytes);
  } else {
    Slot& slot = slots_[point];
    if (slot.request != request_) {
      slot = {request_, 0, 0};
      reader_.read(layout.offset, layout.bytes, reinterpret_cast<std::byte*>(&slot.value));
    }
    value = slot.value;
  }
  return layout.sign_extended && (value & 0x80) != 0 ? value | 0xff00 : value;
}

std::uint16_t ProcessData::cell_value(Table table, std::uint32_t address) {
  std::uint64_t value = 0;
  for (const Cell& cell : map_.at(table, static_cast<std::uint16_t>(address))) {
    const std::uint64_t mask = low_bits(is_bit_table(table) ? 1 : cell.bits);
    value &= ~(mask << cell.cell_bit);
    value |= (value_of(cell.point) >> cell.value_bit & mask) << cell.cell_bit;
  }
  return static_cast<std::uint16_t>(value);
}

void ProcessData::read_bits(Table table, std::uint32_t first, std::span<std::uint8_t> bytes, std::uint32_t count) {
  std::memset(bytes.data(), 0, bytes.size());
  reader_.take();
  fetch(table, first, count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto bit = static_cast<std::uint8_t>(cell_value(table, first + i) << i % 8);
    bytes[i / 8] = static_cast<std::uint8_t>(bytes[i / 8] | bit);
  }
}

void ProcessData::read_registers(Table table, std::uint32_t first, std::span<std::uint8_t> bytes) {
  const auto count = static_cast<std::uint32_t>(bytes.size() / 2);
  reader_.take();
  fetch(table, first, count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t from = source(table, first + i);
    std::uint16_t value = 0;
    if (from - block_begin_ < block_bytes_) {
      std::memcpy(&value, block_.data() + (from - block_begin_), sizeof value);
    } else if (from != kGap) {
      value = cell_value(table, first + i);
    }
    bytes[2 * i] = static_cast<std::uint8_t>(value >> 8);
    bytes[2 * i + 1] = static_cast<std::uint8_t>(value);
  }
}

void ProcessData::begin_write() {
  ++request_;
  changed_.clear();
}

bool ProcessData::change(Table table, std::uint32_t address, std::uint16_t value, std::uint16_t mask) {
  for (const Cell& cell : map_.at(table, static_cast<std::uint16_t>(address))) {
    if (!map_.points()[cell.point].writable) return false;
    Slot& slot = slots_[cell.point];
    if (slot.request != request_) {
      slot = {request_, 0, 0};
      changed_.push_back(cell.point);
    }
    const std::uint64_t wanted = low_bits(is_bit_table(table) ? 1 : cell.bits);
    const std::uint64_t bits = (mask >> cell.cell_bit & wanted) << cell.value_bit;
    const std::uint64_t part = (value >> cell.cell_bit & wanted) << cell.value_bit;
    slot.value = (slot.value & ~bits) | (part & bits);
    slot.mask |= bits;
  }
  return true;
}

Exception ProcessData::commit() {
  batch_.clear();
  const bytecode::Image& image = globals_.image();
  for (const std::uint32_t index : changed_) {
    const Point& point = map_.points()[index];
    const Layout& layout = layouts_[index];
    Slot& slot = slots_[index];
    const std::uint64_t all = low_bits(layout.value_bits);
    const bool whole = (slot.mask & all) == all;
    // A register is wider than a value of one byte: what does not fit in it is no value of its type.
    const std::uint64_t beyond = slot.mask & ~all;
    if (whole && beyond != 0) {
      const bool negative = layout.sign_extended && (slot.value & 0x80) != 0;
      if ((slot.value & beyond) != (negative ? beyond : 0)) return Exception::kIllegalValue;
    }
    slot.value &= all;
    slot.mask &= all;
    if (slot.mask == 0) continue;
    const auto* const value = reinterpret_cast<const std::byte*>(&slot.value);
    if (whole && image.types[point.type].limited) {
      std::byte checked[sizeof slot.value];
      std::memcpy(checked, value, sizeof checked);
      if (!runtime::normalise(image.types[point.type], checked)) return Exception::kIllegalValue;
    }
    batch_.push_back(
        {point.offset, point.type, value, whole ? nullptr : reinterpret_cast<const std::byte*>(&slot.mask)});
  }
  if (batch_.empty()) return Exception::kNone;
  switch (globals_.write(batch_)) {
    case runtime::WriteResult::kDone:
      return Exception::kNone;
    case runtime::WriteResult::kBusy:
      return Exception::kBusy;
    case runtime::WriteResult::kRefused:
      break;
  }
  // The map called it writable, the table does not: a defect, not the client's fault.
  return Exception::kDeviceFailure;
}

}  // namespace plc::modbus
