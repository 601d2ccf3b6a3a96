#include "runtime/memory/ceiling_exchange.h"

#include <algorithm>

namespace plc::runtime {

void CeilingExchange::prepare() {
  CommonTableExchange::prepare();
  own_ = level_ = globals().priority(task());
  ceilings_.clear();
  for (const Range& range : ranges()) {
    std::int32_t ceiling = own_;
    for (std::uint32_t f = range.first; f < range.first + range.count; ++f) {
      // Only what a task alone exports lies in the common table.
      const GlobalTable::Field& in = field(f);
      if (in.kind == GlobalTable::Kind::kOwned && !in.exporters.empty()) ceiling = std::min(ceiling, *in.ceiling);
    }
    ceilings_.push_back(ceiling);
  }
}

// RT: the priorities keep copies apart; that one is after the other is for compiler and processor to know as well.
template <class Copy>
void CeilingExchange::in_turn(Copy copy) noexcept {
  static_cast<void>(copies().load(std::memory_order_acquire));
  copy();
  copies().fetch_add(1, std::memory_order_release);
}

// RT: never falls before reschedule().
void CeilingExchange::rise_to(std::int32_t priority) noexcept {
  if (priority >= level_) return;
  level_ = priority;
  if (set_ != nullptr) set_(priority);
}

// RT:
void CeilingExchange::raise(std::uint32_t range) noexcept { rise_to(ceilings_[range]); }

// RT:
void CeilingExchange::reschedule() noexcept {
  if (level_ == own_) return;
  level_ = own_;
  if (set_ != nullptr) set_(own_);
}

// RT: code that raises too little is wrong, or was made for other priorities.
void CeilingExchange::import(std::uint32_t range) noexcept {
  rise_to(ceilings_[range]);
  in_turn([this, range] { copy_in(range); });
}

// RT:
void CeilingExchange::export_range(std::uint32_t range) noexcept {
  if (!may_publish()) return;
  rise_to(ceilings_[range]);
  in_turn([this, range] { copy_out(range); });
}

// RT:
bool CeilingExchange::end() noexcept {
  reschedule();
  return CommonTableExchange::end();
}

// RT:
void CeilingExchange::publish_safe(std::span<const GlobalWrite> values) noexcept {
  std::int32_t ceiling = own_;
  for (const GlobalWrite& w : values)
    ceiling = std::min(ceiling, globals().ceiling(globals().field_of(w.offset)).value_or(own_));
  if (set_ != nullptr) set_(own_);
  if (set_ != nullptr && ceiling != own_) set_(ceiling);
  in_turn([this, values] { put_safe(values); });
  if (set_ != nullptr && ceiling != own_) set_(own_);
  CommonTableExchange::publish_safe(values);
}

}  // namespace plc::runtime
