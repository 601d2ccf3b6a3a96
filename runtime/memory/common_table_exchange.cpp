#include "runtime/memory/common_table_exchange.h"

#include <cstring>

namespace plc::runtime {

void CommonTableExchange::prepare() {
  WaitFreeExchange::prepare();
  exported_.assign(ranges().size(), 0);
}

// RT:
void CommonTableExchange::expect(std::size_t /*bytes*/) noexcept { take(); }

// RT:
void CommonTableExchange::copy_in(std::uint32_t range) noexcept {
  next_import();
  for (const Stretch& s : stretches(range)) {
    take_in(s.begin, from_task(s) ? common() + s.begin : held(s), s.end - s.begin);
  }
  for (const std::uint32_t l : leaves(range)) import_leaves(l);
}

// RT:
void CommonTableExchange::copy_out(std::uint32_t range) noexcept {
  for (const Stretch& s : stretches(range)) std::memcpy(common() + s.begin, local() + s.begin, s.end - s.begin);
  exported_[range] = 1;
}

// RT:
void CommonTableExchange::put_safe(std::span<const GlobalWrite> values) noexcept {
  for (const GlobalWrite& w : values) {
    const GlobalTable::Field& at = globals().field_at(w.offset);
    if (at.kind != GlobalTable::Kind::kOwned || at.owner != task()) continue;
    globals().merge(common() + w.offset, w.type, w.value, w.mask);
  }
}

// RT:
bool CommonTableExchange::end() noexcept {
  for (std::uint32_t range = 0; range < exported_.size(); ++range) {
    if (exported_[range] == 0) continue;
    exported_[range] = 0;
    WaitFreeExchange::export_range(range);
  }
  return WaitFreeExchange::end();
}

}  // namespace plc::runtime
