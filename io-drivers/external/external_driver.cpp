#include "io-drivers/external/external_driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "io-drivers/numbers.h"

namespace plc::io {
namespace {

/// Exchanges in a row that may fail before the device is lost.
constexpr std::uint32_t kTolerated = 2;
constexpr std::size_t kMostSaid = 100;

double value_of(const std::vector<std::byte>& bytes, core::TypeId type, bool invert) {
  const double number = load_number(type, bytes.data());
  return invert ? (number == 0 ? 1 : 0) : number;
}

}  // namespace

std::string_view refuses_number(const bytecode::ImageType& type) {
  const bool number =
      type.kind == bytecode::TypeKind::kScalar &&
      (type.elementary == core::TypeId::kBool || core::in_category(type.elementary, core::kAnyInt) ||
       core::in_category(type.elementary, core::kAnyReal) || core::in_category(type.elementary, core::kAnyBit));
  return number ? "" : "a driver of a library has numbers and BOOLs";
}

ExternalDriver::ExternalDriver(const picard_driver_kind& kind, const BoundDriver& bound,
                               const Configuration& configuration, runtime::Resource& resource)
    : kind_(kind), config_(bound.config), task_(bound.task), may_wait_(bound.config->values.flag("wait")) {
  told_.folder = configuration.beside(".");
  const auto tell_channel = [&](const BoundChannel& channel) {
    return picard_channel{channel.config->variable.text.c_str(),
                          tell_settings(kind_.channel_keys, kind_.channel_key_count, channel.config->values)};
  };
  for (const BoundChannel& channel : bound.inputs) {
    inputs_.push_back(point_of(channel, resource));
    told_.inputs.push_back(tell_channel(channel));
  }
  for (const BoundChannel& channel : bound.outputs) {
    Output& output = outputs_.emplace_back();
    static_cast<Point&>(output) = point_of(channel, resource);
    output.safe = value_of(channel.safe, output.elementary, output.invert);
    output.exporters = resource.globals().exporters(channel.field);
    safe_.push_back(output.safe);
    initial_.push_back(value_of(channel.initial, output.elementary, output.invert));
    told_.outputs.push_back(tell_channel(channel));
  }
  told_.config = {config_->name.c_str(),
                  told_.folder.c_str(),
                  tell_settings(kind_.driver_keys, kind_.driver_key_count, config_->values),
                  told_.inputs.data(),
                  static_cast<std::uint32_t>(told_.inputs.size()),
                  told_.outputs.data(),
                  static_cast<std::uint32_t>(told_.outputs.size())};
  if (bound.ok) ok_.emplace(bound.ok->offset, bound.ok->type);
  const std::vector<std::uint32_t> claimed = claimed_fields(bound);
  if (!claimed.empty()) to_table_.emplace(resource.globals(), claimed);
  if (!outputs_.empty()) from_table_.emplace(resource.globals());
  read_.resize(inputs_.size());
  wanted_ = initial_;
}

ExternalDriver::~ExternalDriver() {
  close();
  if (object_ != nullptr) kind_.destroy(object_);
}

const picard_setting* ExternalDriver::tell_settings(const picard_key* keys, std::uint32_t count,
                                                    const KeyValues& values) {
  std::vector<picard_setting>& told = told_.settings.emplace_back();
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::int64_t number = keys[i].kind == PICARD_KEY_TEXT ? 0 : values.number(keys[i].name);
    told.push_back({values.text(keys[i].name).c_str(), number});
  }
  return told.data();
}

ExternalDriver::Point ExternalDriver::point_of(const BoundChannel& channel, const runtime::Resource& resource) const {
  return {channel.config->variable.text, channel.offset, channel.type, resource.image().types[channel.type].elementary,
          channel.config->invert};
}

std::string ExternalDriver::why() const {
  const std::size_t length = ::strnlen(failure_.text, sizeof failure_.text);
  return length == 0 ? "it does not say why" : std::string(failure_.text, length);
}

std::optional<core::Problem> ExternalDriver::check() {
  failure_ = {};
  if (object_ == nullptr) object_ = kind_.create(&told_.config, &failure_);
  if (object_ != nullptr) return std::nullopt;
  return core::Problem{core::Code::P7421, fmt::format("{}: {}", config_->name, why()),
                       fmt::format("what its keys mean is in the documents of the driver \"{}\"", kind_.name)};
}

bool ExternalDriver::take_device(const std::vector<double>& outputs) {
  failure_ = {};
  open_ = kind_.open(object_, &failure_) != 0;
  const bool good = open_ && (inputs_.empty() || kind_.read(object_, read_.data(), &failure_) != 0) &&
                    (outputs_.empty() || kind_.write(object_, outputs.data(), &failure_) != 0);
  if (!good) {
    kind_.close(object_);
    open_ = false;
  }
  return good;
}

std::optional<core::Problem> ExternalDriver::open() {
  taken_ = true;
  if (take_device(initial_)) {
    publish(true);
    return std::nullopt;
  }
  const std::string reason = why();
  if (!may_wait_) {
    taken_ = false;
    return core::Problem{core::Code::P7421, fmt::format("{}: the device cannot be opened: {}", config_->name, reason),
                         "wait = true lets control start without it"};
  }
  say(core::Severity::kWarning,
      fmt::format("{}: the device cannot be opened: {}; control runs without it, it is tried again", config_->name,
                  reason));
  away_since_ns_ = core::MonotonicClock().now_ns();
  const std::scoped_lock lock(mutex_);
  problem_ = reason;
  return std::nullopt;
}

/// Inputs as they were read, or as on_loss says; and `ok`.
void ExternalDriver::publish(bool connected) {
  connected_.store(connected, std::memory_order_relaxed);
  if (!to_table_) return;
  std::byte value[8]{};
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    if (!connected && (config_->on_loss == OnLoss::kHold)) break;
    const Point& input = inputs_[i];
    double number = connected ? read_[i] : 0;
    if (connected && input.invert) number = number == 0 ? 1 : 0;
    store_number(input.elementary, number, value);
    to_table_->set(input.offset, input.type, value);
  }
  const auto good = static_cast<std::byte>(connected ? 1 : 0);
  if (ok_) to_table_->set(ok_->first, ok_->second, &good);
  to_table_->publish();
  if (connected) read_at_ns_.store(core::MonotonicClock().now_ns(), std::memory_order_relaxed);
}

bool ExternalDriver::read_inputs() { return kind_.read(object_, read_.data(), &failure_) != 0; }
bool ExternalDriver::write_outputs() { return kind_.write(object_, wanted_.data(), &failure_) != 0; }

/// One error of a bus is not a device that is gone: it is tried twice, and in the next exchanges. A write that works
/// does not make up for reads that fail: the program would not learn that its inputs stand still.
bool ExternalDriver::exchange(bool (ExternalDriver::*what)(), std::uint32_t& failed) {
  failure_ = {};
  if ((this->*what)() || (this->*what)()) {
    exchanges_.fetch_add(1, std::memory_order_relaxed);
    failed = 0;
    return true;
  }
  ++failed;
  if (failed_reads_ + failed_writes_ > kTolerated) lose();
  return false;
}

void ExternalDriver::lose() {
  failed_reads_ = failed_writes_ = 0;
  kind_.close(object_);
  open_ = false;
  losses_.fetch_add(1, std::memory_order_relaxed);
  away_since_ns_ = core::MonotonicClock().now_ns();
  next_try_ns_ = away_since_ns_ + config_->retry_ns;
  publish(false);
  const std::string reason = why();
  say(core::Severity::kWarning, fmt::format("{}: the device is lost: {}; {}", config_->name, reason,
                                            inputs_.empty()                     ? "it is tried again"
                                            : config_->on_loss == OnLoss::kZero ? "its inputs are FALSE or 0"
                                                                                : "its inputs keep their last values"));
  const std::scoped_lock lock(mutex_);
  problem_ = reason;
}

void ExternalDriver::come_back(core::TimeNs now_ns) {
  next_try_ns_ = now_ns + config_->retry_ns;
  if (!take_device(wanted_)) {
    const std::scoped_lock lock(mutex_);
    problem_ = why();
    return;
  }
  recoveries_.fetch_add(1, std::memory_order_relaxed);
  publish(true);
  say(core::Severity::kNote, fmt::format("{}: the device is there after {:.1f} s", config_->name,
                                         static_cast<double>(now_ns - away_since_ns_) / 1e9));
  const std::scoped_lock lock(mutex_);
  problem_.clear();
}

void ExternalDriver::before_scan(const runtime::ReleaseContext& context) noexcept {
  if (!open_ && context.now_ns >= next_try_ns_) come_back(context.now_ns);
  if (open_ && !inputs_.empty() && exchange(&ExternalDriver::read_inputs, failed_reads_)) publish(true);
}

void ExternalDriver::after_scan(const runtime::ReleaseContext&) noexcept {
  if (outputs_.empty()) return;
  from_table_->take();
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    const Output& output = outputs_[i];
    std::byte value[8]{};
    from_table_->read(output.offset, core::rep_bytes(core::rep_of(output.elementary)), value);
    const double number = load_number(output.elementary, value);
    wanted_[i] = output.held.load(std::memory_order_relaxed) ? output.safe
                 : output.invert                             ? (number == 0 ? 1 : 0)
                                                             : number;
  }
  if (open_) exchange(&ExternalDriver::write_outputs, failed_writes_);
}

void ExternalDriver::safe_state() noexcept {
  for (Output& output : outputs_) output.held.store(true, std::memory_order_relaxed);
  wanted_ = safe_;
  if (open_ && !outputs_.empty()) write_outputs() || write_outputs();
}

void ExternalDriver::task_stopped(std::uint32_t task) noexcept {
  for (Output& output : outputs_) {
    const bool writes = std::find(output.exporters.begin(), output.exporters.end(), task) != output.exporters.end();
    if (task == task_ || writes) output.held.store(true, std::memory_order_relaxed);
  }
}

// In the guardian the object is as it was after open(). Inputs that cannot be read do not matter here.
bool ExternalDriver::drive_safe() noexcept {
  if (outputs_.empty()) return true;
  wanted_ = safe_;
  if (open_ && (write_outputs() || write_outputs())) return true;
  if (object_ == nullptr) return false;
  if (open_) kind_.close(object_);
  open_ = kind_.open(object_, &failure_) != 0 && (write_outputs() || write_outputs());
  if (!open_) kind_.close(object_);
  return open_;
}

void ExternalDriver::close() noexcept {
  if (!std::exchange(taken_, false)) return;
  // Also a device that is lost: it may be so in one direction alone.
  drive_safe();
  if (open_) kind_.close(object_);
  open_ = false;
  connected_.store(false, std::memory_order_relaxed);
}

void ExternalDriver::say(core::Severity severity, std::string text) {
  const std::scoped_lock lock(mutex_);
  if (said_.size() < kMostSaid) said_.push_back({std::move(text), severity, config_->name});
}

std::vector<Sentence> ExternalDriver::service(core::TimeNs /*now_ns*/) {
  const std::scoped_lock lock(mutex_);
  return std::exchange(said_, {});
}

DriverStatus ExternalDriver::status() const {
  const std::scoped_lock lock(mutex_);
  return {connected_.load(std::memory_order_relaxed), losses_.load(std::memory_order_relaxed),
          recoveries_.load(std::memory_order_relaxed), exchanges_.load(std::memory_order_relaxed), problem_};
}

std::vector<InputStatus> ExternalDriver::inputs(core::TimeNs now_ns) const {
  const core::TimeNs read_at_ns = read_at_ns_.load(std::memory_order_relaxed);
  const bool connected = connected_.load(std::memory_order_relaxed);
  std::vector<InputStatus> all;
  for (const Point& input : inputs_) all.push_back(input_status(input.variable, read_at_ns, connected, now_ns));
  return all;
}

}  // namespace plc::io
