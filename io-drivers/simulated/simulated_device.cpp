#include "io-drivers/simulated/simulated_device.h"

#include <algorithm>
#include <utility>

#include "runtime/value_text.h"

namespace plc::io {

std::optional<core::Problem> SimulatedDevice::check() {
  if (stimulus_.empty()) return std::nullopt;
  auto loaded = Stimulus::load(stimulus_, resource_);
  if (!loaded) return loaded.error();
  for (const runtime::Place& place : loaded->places()) {
    const bool global = place.task == runtime::Place::kGlobal;
    if (global && !owns(place) && !resource_.globals().writable(resource_.globals().field_of(place.offset))) {
      return core::Problem{core::Code::P7205, stimulus_ + " names an input of another driver",
                           "an input has one driver: take it out of [inputs] in plc.toml, or out of the stimulus"};
    }
  }
  if (auto problem = loaded->check_real_time(stimulus_, task_)) return problem;
  script_.emplace(std::move(*loaded));
  return std::nullopt;
}

void SimulatedDevice::claim(const BoundDriver& bound) {
  for (const BoundChannel& input : bound.inputs) variables_.push_back(input.config->variable.text);
  ok_ = bound.ok;
  claimed_ = claimed_fields(bound);
  if (!claimed_.empty()) inputs_.emplace(resource_.globals(), claimed_);
}

bool SimulatedDevice::owns(const runtime::Place& place) const {
  return place.task == runtime::Place::kGlobal &&
         std::binary_search(claimed_.begin(), claimed_.end(), resource_.globals().field_of(place.offset));
}

std::optional<core::Problem> SimulatedDevice::open() {
  if (ok_) {
    const std::byte yes{1};
    inputs_->set(ok_->offset, ok_->type, &yes);
    inputs_->publish();
  }
  return std::nullopt;
}

std::vector<InputStatus> SimulatedDevice::inputs(core::TimeNs) const {
  std::vector<InputStatus> inputs;
  const Quality quality = exchanges_.load(std::memory_order_relaxed) != 0 ? Quality::kGood : Quality::kNever;
  for (const std::string_view variable : variables_) inputs.push_back({variable, quality, 0});
  return inputs;
}

std::vector<Sentence> SimulatedDevice::service(core::TimeNs) {
  if (told_ || !losing_.load(std::memory_order_acquire)) return {};
  told_ = true;
  const core::Problem& first = *script_->lost().first;
  return {{name_ + ": error " + std::string(core::info(first.code).name) + ": values are lost, the first " +
           first.message}};
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
  if (repeats_ && script_->end_ns() != 0 && context.release_ns - first_release_ns_ > script_->end_ns()) {
    first_release_ns_ = context.release_ns;
    script_->restart();
  }
  bool changed = false;
  script_->apply(context.release_ns - first_release_ns_, [&](const runtime::Place& place, std::string_view text) {
    if (!owns(place)) return script_->write(place, text, context.release_ns - first_release_ns_);
    const bytecode::ImageType& type = resource_.image().types[place.type];
    std::vector<std::byte> value(type.size);
    if (runtime::parse_value(type, text, value)) return;
    inputs_->set(place.offset, place.type, value.data());
    changed = true;
  });
  if (changed) inputs_->publish();
  if (script_->lost().values != 0) losing_.store(true, std::memory_order_release);
  exchanges_.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace plc::io
