#include "io-drivers/machine/simulated_device.h"

#include <utility>

namespace plc::io {

std::optional<core::Problem> SimulatedDevice::check() {
  if (stimulus_.empty()) return std::nullopt;
  auto loaded = SimulatedDriver::load(stimulus_, resource_);
  if (!loaded) return loaded.error();
  for (const runtime::Place& place : loaded->places()) {
    if (place.task == runtime::Place::kGlobal || place.task == task_) continue;
    return core::Problem{core::Code::P7205,
                         stimulus_ + " names variables of task \"" + resource_.image().tasks[place.task].name +
                             "\", and is applied by task \"" + resource_.image().tasks[task_].name + "\"",
                         "in real time a stimulus writes globals, or variables of one task; plc sim takes any"};
  }
  script_.emplace(std::move(*loaded));
  return std::nullopt;
}

void SimulatedDevice::claim_ok(const BoundChannel& ok) {
  ok_ = ok;
  ok_owner_.emplace(resource_.globals(), std::span(&ok.field, 1));
}

std::optional<core::Problem> SimulatedDevice::open() {
  if (ok_owner_) {
    const std::byte yes{1};
    ok_owner_->set(ok_->offset, ok_->type, &yes);
    ok_owner_->publish();
  }
  return std::nullopt;
}

DriverStatus SimulatedDevice::status() const {
  DriverStatus status;
  status.connected = true;
  status.exchanges = exchanges_.load(std::memory_order_relaxed);
  return status;
}

void SimulatedDevice::before_scan(const runtime::ReleaseContext& context) noexcept {
  if (context.task != task_ || !script_) return;
  if (context.cycle == 0) first_release_ns_ = context.release_ns;
  script_->apply(context.release_ns - first_release_ns_);
  exchanges_.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace plc::io
