#include "io-drivers/modbus/coil_latch.h"

#include <algorithm>

#include "runtime/link/link.h"

namespace plc::modbus {

CoilLatch::CoilLatch(const runtime::Resource& resource, const AddressMap& map) {
  const bytecode::Image& image = resource.image();
  for (std::uint32_t i = 0; i < map.points().size(); ++i) {
    const Point& point = map.points()[i];
    if (!point.latch) continue;
    Coil coil{.point = i};
    const std::uint32_t field = resource.globals().field_of(point.offset);
    for (std::uint32_t task = 0; task < image.tasks.size(); ++task) {
      if (!image.tasks[task].single.empty()) continue;  // it may not scan for days
      const auto ranges = runtime::exchanged_ranges(image, image.tasks[task].body);
      const bool uses = std::any_of(ranges.begin(), ranges.end(),
                                    [&](const auto& r) { return r.first <= field && field < r.first + r.count; });
      if (uses) coil.tasks.emplace_back(task, 0);
    }
    coils_.push_back(std::move(coil));
  }
  due_.reserve(coils_.size());
}

const CoilLatch::Coil* CoilLatch::find(std::uint32_t point) const {
  const auto at = std::lower_bound(coils_.begin(), coils_.end(), point,
                                   [](const Coil& coil, std::uint32_t wanted) { return coil.point < wanted; });
  return at != coils_.end() && at->point == point ? &*at : nullptr;
}

/// A scan that was under way took its inputs before: the one after it has seen the coil.
bool CoilLatch::was_seen(const Coil& coil) const {
  return std::all_of(coil.tasks.begin(), coil.tasks.end(), [&](const auto& task) {
    const std::uint64_t now = scans_(task.first);
    return now == kNoMoreScans || now - task.second >= 2;
  });
}

bool CoilLatch::must_wait(std::uint32_t point) const {
  const Coil* const coil = scans_ ? find(point) : nullptr;
  return coil != nullptr && coil->pressed && !was_seen(*coil);
}

void CoilLatch::was_set(std::uint32_t point) {
  Coil* const coil = scans_ ? find(point) : nullptr;
  if (coil == nullptr) return;
  if (coil->reset) --waiting_;
  coil->pressed = true;
  coil->reset = false;
  for (auto& [task, scans] : coil->tasks) scans = scans_(task);
}

void CoilLatch::reset_later(std::uint32_t point) {
  Coil* const coil = find(point);
  if (coil->reset) return;
  coil->reset = true;
  ++waiting_;
}

std::span<const std::uint32_t> CoilLatch::due() {
  due_.clear();
  for (Coil& coil : coils_) {
    if (!coil.reset || !was_seen(coil)) continue;
    coil.pressed = coil.reset = false;
    --waiting_;
    due_.push_back(coil.point);
  }
  return due_;
}

}  // namespace plc::modbus
