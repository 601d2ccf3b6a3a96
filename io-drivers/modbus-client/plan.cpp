#include "io-drivers/modbus-client/plan.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace plc::modbus_client {

std::vector<Block> plan(std::span<const Want> wants, const Limits& limits) {
  std::vector<std::uint32_t> order(wants.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto key = [&](std::uint32_t i) {
    const Want& w = wants[i];
    return std::tuple(w.table, w.period_ns, w.first, i);
  };
  std::ranges::sort(order, {}, key);
  std::vector<Block> blocks;
  for (const std::uint32_t i : order) {
    const Want& want = wants[i];
    const std::uint32_t most = is_bits(want.table) ? limits.bits : limits.registers;
    const std::uint32_t gap = is_bits(want.table) ? limits.gap * 16u : limits.gap;
    const std::uint32_t end = std::uint32_t{want.first} + want.count;
    // WHY greedy: with values in the order of their addresses, beginning a block as late as possible is the fewest.
    if (!blocks.empty()) {
      Block& last = blocks.back();
      const std::uint32_t last_end = std::uint32_t{last.first} + last.count;
      if (last.table == want.table && last.period_ns == want.period_ns && want.first <= last_end + gap &&
          end <= last.first + most) {
        last.gaps = last.gaps || want.first > last_end;
        last.count = static_cast<std::uint16_t>(std::max(end, last_end) - last.first);
        last.wants.push_back(i);
        continue;
      }
    }
    blocks.push_back({want.table, want.first, want.count, want.period_ns, {i}, false});
  }
  return blocks;
}

}  // namespace plc::modbus_client
