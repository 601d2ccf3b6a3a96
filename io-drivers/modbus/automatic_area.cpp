#include "io-drivers/modbus/automatic_area.h"

#include <algorithm>
#include <bit>

namespace plc::modbus {

bool AutomaticArea::is_free(const std::vector<bool>& taken, std::uint32_t first, std::uint32_t width) const {
  const auto begin = taken.begin() + static_cast<std::ptrdiff_t>(first - kAutomaticFirst);
  return std::find(begin, begin + static_cast<std::ptrdiff_t>(width), true) ==
         begin + static_cast<std::ptrdiff_t>(width);
}

bool AutomaticArea::reserve(Table table, std::uint32_t first, std::uint32_t width) {
  std::vector<bool>& taken = tables_[static_cast<std::size_t>(table)].taken;
  if (first < kAutomaticFirst || first + width > kEnd || !is_free(taken, first, width)) return false;
  std::fill_n(taken.begin() + static_cast<std::ptrdiff_t>(first - kAutomaticFirst), width, true);
  return true;
}

std::optional<std::uint16_t> AutomaticArea::allocate(Table table, std::uint32_t width, std::uint32_t count) {
  Addresses& addresses = tables_[static_cast<std::size_t>(table)];
  std::uint32_t& from = addresses.search_from[std::countr_zero(width)];
  while (from + width <= kEnd && !is_free(addresses.taken, from, width)) from += width;
  if (count > (kEnd - from) / width) return std::nullopt;
  std::uint32_t run = 0;  // values that fit, one after another, before `at`
  for (std::uint32_t at = from; at + width <= kEnd; at += width) {
    run = is_free(addresses.taken, at, width) ? run + 1 : 0;
    if (run != count) continue;
    const std::uint32_t first = at + width - count * width;
    reserve(table, first, count * width);
    return static_cast<std::uint16_t>(first);
  }
  return std::nullopt;
}

}  // namespace plc::modbus
