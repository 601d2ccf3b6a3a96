#include "io-drivers/modbus/responder.h"

namespace plc::modbus {
namespace {

Identification identification_of(const bytecode::Image& image) {
  return {"PICARD", "PICARD-PLC", PLC_VERSION, "", "PICARD soft-PLC", "IEC 61131-3", image.project};
}

}  // namespace

Responder::Responder(runtime::Resource& resource, const AddressMap& map, const io::ModbusConfig& config,
                     const std::optional<SeenFlag>& seen)
    : data_(resource, map),
      handler_(data_, identification_of(resource.image()), config.read_only),
      seen_flag_(seen),
      seen_timeout_ns_(config.client_timeout_ns) {}

std::size_t Responder::answer(std::span<const std::uint8_t> request, std::span<std::uint8_t, kMaxPdu> response,
                              bool unanswered) {
  const std::scoped_lock lock(mutex_);
  const std::size_t size = handler_.handle(request, response);
  coils_wait_.store(data_.has_waiting_coils(), std::memory_order_relaxed);
  if (seen_flag_ && !unanswered && (response[0] & 0x80) == 0) {
    seen_at_ns_ = core::MonotonicClock().now_ns();
    if (!seen_) publish_seen(true);
  }
  return size;
}

void Responder::release_coils() {
  const std::scoped_lock lock(mutex_);
  data_.release_coils();
  coils_wait_.store(data_.has_waiting_coils(), std::memory_order_relaxed);
}

void Responder::sweep(core::TimeNs now_ns) {
  const std::scoped_lock lock(mutex_);
  if (seen_ && now_ns - seen_at_ns_ > seen_timeout_ns_) publish_seen(false);
}

void Responder::stopped() {
  const std::scoped_lock lock(mutex_);
  if (seen_) publish_seen(false);
}

void Responder::publish_seen(bool seen) {
  const std::byte value{seen};
  seen_flag_->owner->set(seen_flag_->offset, seen_flag_->type, &value);
  seen_flag_->owner->publish();
  seen_ = seen;
}

}  // namespace plc::modbus
