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
    : globals_(resource.globals()),
      map_(map),
      reader_(resource.globals()),
      latch_(resource, map),
      slots_(map.points().size()) {
  layouts_.reserve(map.points().size());
  for (const Point& point : map.points()) {
    const core::Rep rep = core::rep_of(point.elementary);
    if (point.characters != 0) {
      layouts_.push_back({point.offset, 0, 0, false, point.characters, rep == core::Rep::kWstr});
      continue;
    }
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
  later_.reserve(kUsualChanges);
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
      if (layouts_[cell.point].characters != 0) continue;
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
    if (layouts_[cell.point].characters != 0) return text_register(cell.point, cell.value_bit);
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
    bytes[std::size_t{2} * i] = static_cast<std::uint8_t>(value >> 8);
    bytes[std::size_t{2} * i + 1] = static_cast<std::uint8_t>(value);
  }
  if (table == Table::kInputRegisters) put_system(first, bytes);
}

/// The system's registers among those of the request, all of one moment.
void ProcessData::put_system(std::uint32_t first, std::span<std::uint8_t> bytes) const {
  const std::uint32_t end = first + static_cast<std::uint32_t>(bytes.size() / 2);
  if (!system_ || first >= system_end() || end <= kSystemFirst) return;
  const SystemState state = system_();
  const auto order = static_cast<unsigned>(map_.system_order());
  const unsigned swapped_words = order & 1, swapped_bytes = order >> 1;
  for (const SystemPoint& point : system_points()) {
    const std::uint32_t value = point.value(state);
    for (std::uint32_t i = 0; i < point.registers; ++i) {
      const std::uint32_t address = point.address + i;
      if (address < first || address >= end) continue;
      const bool high = point.registers == 2 && (i == 0) != (swapped_words != 0);
      const auto word = static_cast<std::uint16_t>(high ? value >> 16 : value);
      const bool turned = point.registers == 2 && swapped_bytes != 0;
      const std::size_t at = std::size_t{2} * (address - first);
      bytes[at] = static_cast<std::uint8_t>(turned ? word : word >> 8);
      bytes[at + 1] = static_cast<std::uint8_t>(turned ? word >> 8 : word);
    }
  }
}

/// Two characters of a STRING, the first in the high byte, or one of a WSTRING; 0 behind the end.
std::uint16_t ProcessData::text_register(std::uint32_t point, std::uint32_t index) {
  const Layout& layout = layouts_[point];
  if (text_request_ != request_ || text_point_ != point) {
    text_.resize(globals_.image().types[map_.points()[point].type].size);
    reader_.read(layout.offset, static_cast<std::uint32_t>(text_.size()), text_.data());
    text_request_ = request_;
    text_point_ = point;
  }
  core::StringHeader header;
  std::memcpy(&header, text_.data(), sizeof header);
  const std::uint32_t length = std::min(header.length, layout.characters);
  const std::byte* const characters = text_.data() + sizeof header;
  if (layout.wide) {
    std::uint16_t unit = 0;
    if (index < length) std::memcpy(&unit, characters + std::size_t{2} * index, sizeof unit);
    return unit;
  }
  const auto character = [&](std::uint32_t at) { return at < length ? std::to_integer<unsigned>(characters[at]) : 0u; };
  return static_cast<std::uint16_t>(character(2 * index) << 8 | character(2 * index + 1));
}

/// Slot::value is where the value begins in new_texts_, Slot::mask how many registers it has so far.
bool ProcessData::change_text(std::uint32_t point, std::uint32_t index, std::uint16_t value, std::uint16_t mask) {
  const Layout& layout = layouts_[point];
  Slot& slot = slots_[point];
  if (slot.request != request_) {
    slot = {request_, new_texts_.size(), 0};
    changed_.push_back(point);
    // The last register of an odd number of characters has one more.
    new_texts_.resize(new_texts_.size() + sizeof(core::StringHeader) + std::size_t{2} * map_.points()[point].registers);
  }
  if (mask != 0xffff || index != slot.mask) return false;
  std::byte* const to = new_texts_.data() + slot.value + sizeof(core::StringHeader) + std::size_t{2} * index;
  const auto in_table = layout.wide ? value : static_cast<std::uint16_t>(value << 8 | value >> 8);
  std::memcpy(to, &in_table, sizeof in_table);
  ++slot.mask;
  return true;
}

bool ProcessData::finish_text(std::uint32_t point) {
  const Layout& layout = layouts_[point];
  const Slot& slot = slots_[point];
  const std::size_t width = layout.wide ? 2 : 1;
  const std::byte* const characters = new_texts_.data() + slot.value + sizeof(core::StringHeader);
  const auto given = static_cast<std::uint32_t>(slot.mask * 2 / width);
  const auto is_end = [&](std::uint32_t at) {
    return characters[at * width] == std::byte{0} && characters[at * width + width - 1] == std::byte{0};
  };
  std::uint32_t length = 0;
  while (length < given && !is_end(length)) ++length;
  if (length > layout.characters) return false;
  const core::StringHeader header{layout.characters, static_cast<std::uint16_t>(length)};
  std::memcpy(new_texts_.data() + slot.value, &header, sizeof header);
  return true;
}

void ProcessData::begin_write() {
  ++request_;
  changed_.clear();
  new_texts_.clear();
}

bool ProcessData::change(Table table, std::uint32_t address, std::uint16_t value, std::uint16_t mask) {
  for (const Cell& cell : map_.at(table, static_cast<std::uint16_t>(address))) {
    if (!map_.points()[cell.point].writable) return false;
    if (layouts_[cell.point].characters != 0) {
      if (!change_text(cell.point, cell.value_bit, value, mask)) return false;
      continue;
    }
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
  later_.clear();
  const bytecode::Image& image = globals_.image();
  for (const std::uint32_t index : changed_) {
    const Point& point = map_.points()[index];
    const Layout& layout = layouts_[index];
    Slot& slot = slots_[index];
    if (layout.characters != 0) {
      if (!finish_text(index)) return Exception::kIllegalValue;
      batch_.push_back({point.offset, point.type, new_texts_.data() + slot.value, nullptr});
      continue;
    }
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
    if (point.latch && slot.value == 0 && latch_.must_wait(index)) {
      later_.push_back(index);
      continue;
    }
    const auto* const value = reinterpret_cast<const std::byte*>(&slot.value);
    if (whole && image.types[point.type].limited) {
      std::byte checked[sizeof slot.value];
      std::memcpy(checked, value, sizeof checked);
      if (!runtime::normalise(image.types[point.type], checked)) return Exception::kIllegalValue;
    }
    batch_.push_back(
        {point.offset, point.type, value, whole ? nullptr : reinterpret_cast<const std::byte*>(&slot.mask)});
  }
  const auto done = [&] {
    for (const std::uint32_t index : changed_) {
      if (map_.points()[index].latch && slots_[index].value != 0) latch_.was_set(index);
    }
    for (const std::uint32_t index : later_) latch_.reset_later(index);
    return Exception::kNone;
  };
  if (batch_.empty()) return done();
  switch (globals_.write(batch_)) {
    case runtime::WriteResult::kDone:
      return done();
    case runtime::WriteResult::kBusy:
      return Exception::kBusy;
    case runtime::WriteResult::kRefused:
      break;
  }
  // The map called it writable, the table does not: a defect, not the client's fault.
  return Exception::kDeviceFailure;
}

void ProcessData::release_coils() {
  constexpr std::byte kReset{0};
  batch_.clear();
  for (const std::uint32_t index : latch_.due()) {
    batch_.push_back({map_.points()[index].offset, map_.points()[index].type, &kReset, nullptr});
  }
  // A task that has stopped answers kBusy: nobody sees the coil any more.
  if (!batch_.empty()) static_cast<void>(globals_.write(batch_));
}

}  // namespace plc::modbus
