#include "runtime/memory/forces.h"

#include <cstring>
#include <utility>

namespace plc::runtime {

void Forces::set(std::vector<ForcedPlace> places) {
  slots_[write_] = std::move(places);
  const std::uint8_t other = between_.exchange(write_ | kNew, std::memory_order_acq_rel);
  write_ = other & ~kNew;
}

// RT:
bool Forces::take() noexcept {
  if ((between_.load(std::memory_order_relaxed) & kNew) != 0) [[unlikely]]
    read_ = between_.exchange(read_, std::memory_order_acq_rel) & ~kNew;
  return !slots_[read_].empty();
}

// RT:
bool ForcingExchange::put(const ForcedPlace& place) noexcept {
  std::byte* const to = table_ + place.at;
  if (std::memcmp(to, place.value.data(), place.value.size()) == 0) return false;
  std::memcpy(to, place.value.data(), place.value.size());
  return true;
}

// RT:
void ForcingExchange::begin() noexcept {
  inner_.begin();
  exports_ = 0;
  for (const ForcedPlace& place : places_) {
    if (put(place) && recorder_ != nullptr)
      recorder_->written(place.at, static_cast<std::uint32_t>(place.value.size()));
  }
}

// RT:
void ForcingExchange::import(std::uint32_t range) noexcept {
  inner_.import(range);
  for (const ForcedPlace& place : places_) {
    if (place.imported && put(place) && recorder_ != nullptr)
      recorder_->written(place.at, static_cast<std::uint32_t>(place.value.size()));
  }
}

// RT:
void ForcingExchange::export_range(std::uint32_t range) noexcept {
  for (const ForcedPlace& place : places_) {
    if (place.exported && put(place) && recorder_ != nullptr)
      recorder_->forced(exports_, place.at, static_cast<std::uint32_t>(place.value.size()));
  }
  ++exports_;
  inner_.export_range(range);
}

// RT:
bool ForcingExchange::end() noexcept {
  for (const ForcedPlace& place : places_) {
    if (put(place) && recorder_ != nullptr)
      recorder_->forced(kForcedAtEnd, place.at, static_cast<std::uint32_t>(place.value.size()));
  }
  return inner_.end();
}

}  // namespace plc::runtime
