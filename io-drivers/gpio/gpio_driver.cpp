#include "io-drivers/gpio/gpio_driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

namespace plc::io {
namespace {

/// While a killed process still lets go of its lines.
constexpr int kBusyTries = 30;
constexpr std::chrono::milliseconds kBusyPause{10};
/// Errors that are got over are said once in this time.
constexpr core::TimeNs kTellErrorsNs = 60'000'000'000;

Latch latch_of(const ChannelConfig& channel) { return channel.values.choice<Latch>("latch"); }

LineEdge edge_of(const ChannelConfig& channel) {
  const Latch latch = latch_of(channel);
  if (latch == Latch::kNone) return LineEdge::kNone;
  // The program's rising edge is the line's falling one when the driver inverts; active-low is turned by the kernel.
  return (latch == Latch::kRising) != channel.invert ? LineEdge::kRising : LineEdge::kFalling;
}

bool truth(const std::vector<std::byte>& value) { return !value.empty() && value.front() != std::byte{0}; }

LineSpec spec_of(const BoundChannel& channel) {
  const ChannelConfig& config = *channel.config;
  return {config.values.text("channel"),          config.variable.text, config.values.flag("active_low"),
          config.values.choice<Bias>("bias"),     edge_of(config),      config.values.choice<Drive>("drive"),
          truth(channel.initial) != config.invert};
}

/// Whether control may start without the device.
bool may_wait(const DriverConfig& config, const core::Problem& problem) {
  return problem.code == core::Code::P7401 && config.values.flag("wait");
}

}  // namespace

GpioDriver::GpioDriver(const BoundDriver& bound, runtime::Resource& resource, GpioAccess access)
    : config_(bound.config), access_(std::move(access)), task_(bound.task) {
  request_.chip = config_->values.text("chip");
  for (const BoundChannel& channel : bound.inputs) {
    request_.inputs.push_back(spec_of(channel));
    inputs_.push_back({channel.config->variable.text, channel.offset, channel.type, channel.config->invert,
                       latch_of(*channel.config)});
  }
  for (const BoundChannel& channel : bound.outputs) {
    request_.outputs.push_back(spec_of(channel));
    auto output = std::make_unique<Output>();
    output->offset = channel.offset;
    output->invert = channel.config->invert;
    output->safe = truth(channel.safe) != channel.config->invert ? 1 : 0;
    output->wanted = request_.outputs.back().initial ? 1 : 0;
    output->exporters = resource.globals().exporters(channel.field);
    safe_values_.push_back(output->safe);
    outputs_.push_back(std::move(output));
  }
  if (bound.ok) ok_.emplace(bound.ok->offset, bound.ok->type);
  const std::vector<std::uint32_t> claimed = claimed_fields(bound);
  if (!claimed.empty()) to_table_.emplace(resource.globals(), claimed);
  if (!outputs_.empty()) from_table_.emplace(resource.globals());
  errors_allowed_ = static_cast<std::uint32_t>(config_->values.number("errors"));
  read_.resize(inputs_.size());
  wanted_.resize(outputs_.size());
  written_.resize(outputs_.size());
}

GpioDriver::~GpioDriver() { close(); }

LinesRequest GpioDriver::request(std::span<const std::uint8_t> values, bool with_inputs) const {
  LinesRequest again = request_;
  for (std::size_t i = 0; i < again.outputs.size(); ++i) again.outputs[i].initial = values[i] != 0;
  if (!with_inputs) again.inputs.clear();
  return again;
}

std::vector<std::uint8_t> GpioDriver::wanted_values() const {
  std::vector<std::uint8_t> values;
  for (const auto& output : outputs_) {
    values.push_back(output->held.load(std::memory_order_relaxed) ? output->safe
                                                                  : output->wanted.load(std::memory_order_relaxed));
  }
  return values;
}

std::optional<core::Problem> GpioDriver::check() {
  auto problem = access_.check(request_);
  if (problem && may_wait(*config_, *problem)) return std::nullopt;
  if (problem) problem->message = config_->name + ": " + problem->message;
  return problem;
}

std::optional<core::Problem> GpioDriver::open() {
  const std::scoped_lock lock(mutex_);
  // Safe values first: when a later step fails, what was taken already is given back safe.
  auto lines = access_.open(request(safe_values_, true));
  if (!lines) {
    core::Problem problem = lines.error();
    if (may_wait(*config_, problem)) {
      opened_ = away_ = late_ = true;
      away_since_ns_ = core::MonotonicClock().now_ns();
      problem_ = problem.message + (problem.help.empty() ? "" : " (" + problem.help + ")");
      lose_inputs();
      return std::nullopt;
    }
    problem.message = config_->name + ": " + problem.message;
    return problem;
  }
  if (const int error = (*lines)->read(read_); error != 0) {
    (*lines)->write(safe_values_);
    return core::Problem{
        core::Code::P7406,
        fmt::format("{}: the lines of {} cannot be read: {}", config_->name, request_.chip, std::strerror(error)),
        "see what the kernel says about the chip: dmesg"};
  }
  std::vector<std::uint8_t> initial;
  for (const auto& output : request_.outputs) initial.push_back(output.initial ? 1 : 0);
  if (!initial.empty() && initial != safe_values_) (*lines)->write(initial);
  // An edge from before the first read is none.
  for (LineInput& input : read_) input.edge = false;
  take_inputs();
  read_at_ns_.store(core::MonotonicClock().now_ns(), std::memory_order_relaxed);
  connected_.store(true, std::memory_order_relaxed);
  opened_ = true;
  give_back(lines->release());
  return std::nullopt;
}

// RT:
void GpioDriver::before_scan(const runtime::ReleaseContext& context) noexcept {
  if (context.task != task_) return;
  GpioLines* const lines = borrow();
  const int error = lines == nullptr ? 0 : try_twice([&] { return lines->read(read_); });
  if (lines == nullptr || error != 0) {
    if (lines != nullptr) failed(lines, error, reads_failed_);
    // Without an error another thread has the lines for a moment, or they are lost already.
    if (inputs_good_ && !connected_.load(std::memory_order_relaxed)) lose_inputs();
    return;
  }
  reads_failed_ = 0;
  give_back(lines);
  take_inputs();
  if (inputs_.empty()) return;
  read_at_ns_.store(context.now_ns, std::memory_order_relaxed);
  count_exchange();
}

// RT:
void GpioDriver::take_inputs() noexcept {
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    const Input& input = inputs_[i];
    bool value = (read_[i].value != 0) != input.invert;
    if (read_[i].edge) value = input.latch == Latch::kRising;
    const std::byte byte{value ? std::uint8_t{1} : std::uint8_t{0}};
    to_table_->set(input.offset, input.type, &byte);
  }
  inputs_good_ = true;
  if (ok_) {
    constexpr std::byte kYes{1};
    to_table_->set(ok_->first, ok_->second, &kYes);
  }
  if (to_table_) to_table_->publish();
}

// RT:
void GpioDriver::lose_inputs() noexcept {
  constexpr std::byte kNo{0};
  inputs_good_ = false;
  if (config_->on_loss == OnLoss::kZero) {
    for (const Input& input : inputs_) to_table_->set(input.offset, input.type, &kNo);
  }
  if (ok_) to_table_->set(ok_->first, ok_->second, &kNo);
  if (to_table_) to_table_->publish();
}

// RT:
void GpioDriver::after_scan(const runtime::ReleaseContext& context) noexcept {
  if (context.task != task_ || outputs_.empty()) return;
  from_table_->take();
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    Output& output = *outputs_[i];
    std::byte value{};
    from_table_->read(output.offset, 1, &value);
    wanted_[i] = output.held.load(std::memory_order_relaxed) ? output.safe
                 : (value != std::byte{0}) != output.invert  ? std::uint8_t{1}
                                                             : std::uint8_t{0};
    output.wanted.store(wanted_[i], std::memory_order_relaxed);
  }
  if (written_valid_ && wanted_ == written_ && context.now_ns < refresh_ns_) return;
  GpioLines* const lines = borrow();
  if (lines == nullptr) {
    written_valid_ = false;
    return;
  }
  if (const int error = try_twice([&] { return lines->write(wanted_); }); error != 0) {
    return failed(lines, error, writes_failed_);
  }
  writes_failed_ = 0;
  give_back(lines);
  std::copy(wanted_.begin(), wanted_.end(), written_.begin());
  written_valid_ = true;
  refresh_ns_ = context.now_ns + kRefreshNs;
  count_exchange();
}

// RT: 0, or the errno of the second attempt. One error of a bus is not a device that is gone.
template <class Exchange>
int GpioDriver::try_twice(Exchange exchange) noexcept {
  const int error = exchange();
  if (error == 0 || error == ENODEV) return error;
  error_.store(error, std::memory_order_relaxed);
  errors_.fetch_add(1, std::memory_order_relaxed);
  return exchange();
}

// RT: the exchange of this cycle failed. The lines keep their values, and the next cycle tries again.
void GpioDriver::failed(GpioLines* lines, int error, std::uint32_t& in_a_row) noexcept {
  if (error == ENODEV || ++in_a_row > errors_allowed_) {
    reads_failed_ = writes_failed_ = 0;
    return lose(lines, error);
  }
  written_valid_ = false;
  give_back(lines);
}

// RT:
void GpioDriver::lose(GpioLines* lines, int error) noexcept {
  written_valid_ = false;
  error_.store(error, std::memory_order_relaxed);
  connected_.store(false, std::memory_order_relaxed);
  losses_.fetch_add(1, std::memory_order_relaxed);
  lost_.store(lines, std::memory_order_release);
}

// RT:
void GpioDriver::count_exchange() noexcept { exchanges_.fetch_add(1, std::memory_order_relaxed); }

void GpioDriver::hold_all() noexcept {
  for (const auto& output : outputs_) output->held.store(true, std::memory_order_relaxed);
}

// RT:
void GpioDriver::safe_state() noexcept {
  hold_all();
  if (outputs_.empty()) return;
  GpioLines* const lines = borrow();
  if (lines == nullptr) return;  // lost: they come back safe
  if (const int error = lines->write(safe_values_); error != 0) return lose(lines, error);
  give_back(lines);
}

// RT:
void GpioDriver::task_stopped(std::uint32_t task) noexcept {
  if (task == task_) return safe_state();
  for (const auto& output : outputs_) {
    const auto& exporters = output->exporters;
    if (std::find(exporters.begin(), exporters.end(), task) != exporters.end()) {
      output->held.store(true, std::memory_order_relaxed);
    }
  }
}

bool GpioDriver::works(GpioLines& lines) {
  std::vector<LineInput> values(inputs_.size());
  return lines.read(values) == 0 && lines.write(wanted_values()) == 0;
}

/// Lines in active_ again, or why not.
std::optional<std::string> GpioDriver::try_to_come_back() {
  if (parked_ != nullptr && !parked_->gone()) {
    if (!works(*parked_)) return problem_;
    connected_.store(true, std::memory_order_relaxed);  // before the cycle can say otherwise
    give_back(parked_.release());
    return std::nullopt;
  }
  parked_.reset();
  auto lines = access_.open(request(wanted_values(), true));
  if (!lines) return lines.error().message;
  connected_.store(true, std::memory_order_relaxed);
  give_back(lines->release());
  return std::nullopt;
}

std::vector<Sentence> GpioDriver::service(core::TimeNs now_ns) {
  const std::scoped_lock lock(mutex_);
  std::vector<Sentence> said;
  if (!opened_) return said;
  tell_errors(now_ns, said);
  if (GpioLines* const lost = lost_.exchange(nullptr, std::memory_order_acquire); lost != nullptr) {
    parked_.reset(lost);
    away_ = true;
    away_since_ns_ = next_try_ns_ = now_ns;
    problem_ =
        fmt::format("{} does not answer: {}", request_.chip, std::strerror(error_.load(std::memory_order_relaxed)));
    said.push_back({fmt::format("{}: {}; {}", config_->name, problem_,
                                inputs_.empty()                     ? "it is tried again"
                                : config_->on_loss == OnLoss::kZero ? "its inputs read FALSE"
                                                                    : "its inputs keep their last values")});
  }
  if (!away_ || now_ns < next_try_ns_) return said;
  next_try_ns_ = now_ns + config_->retry_ns;
  if (const auto problem = try_to_come_back()) {
    problem_ = *problem;
    if (late_ && problem_ != told_) {
      said.push_back({fmt::format("{}: {}; control runs without it, it is tried again", config_->name, problem_)});
      told_ = problem_;
    }
    return said;
  }
  const bool was_late = late_;
  away_ = late_ = false;
  problem_.clear();
  if (!was_late) recoveries_.fetch_add(1, std::memory_order_relaxed);
  said.push_back({fmt::format("{}: {} is {} after {:.1f} s", config_->name, request_.chip, was_late ? "there" : "back",
                              static_cast<double>(now_ns - away_since_ns_) / 1e9),
                  core::Severity::kNote});
  return said;
}

void GpioDriver::tell_errors(core::TimeNs now_ns, std::vector<Sentence>& said) {
  const std::uint64_t errors = errors_.load(std::memory_order_relaxed);
  if (errors == errors_told_ || now_ns < next_errors_ns_) return;
  next_errors_ns_ = now_ns + kTellErrorsNs;
  said.push_back({fmt::format("{}: {}: {}, tried again; {} since the start", config_->name, request_.chip,
                              std::strerror(error_.load(std::memory_order_relaxed)),
                              errors == 1 ? "1 error" : std::to_string(errors) + " errors")});
  errors_told_ = errors;
}

DriverStatus GpioDriver::status() const {
  const std::scoped_lock lock(mutex_);
  return {connected_.load(std::memory_order_relaxed), losses_.load(std::memory_order_relaxed),
          recoveries_.load(std::memory_order_relaxed), exchanges_.load(std::memory_order_relaxed), problem_};
}

std::vector<InputStatus> GpioDriver::inputs(core::TimeNs now_ns) const {
  const core::TimeNs read_at_ns = read_at_ns_.load(std::memory_order_relaxed);
  const bool connected = connected_.load(std::memory_order_relaxed);
  std::vector<InputStatus> all;
  for (const Input& input : inputs_) all.push_back(input_status(input.variable, read_at_ns, connected, now_ns));
  return all;
}

bool GpioDriver::drive_safe() noexcept try {
  const std::scoped_lock lock(mutex_);
  hold_all();
  if (!opened_ || outputs_.empty()) return true;
  if (GpioLines* const lines = borrow(); lines != nullptr) {
    const bool safe = lines->write(safe_values_) == 0;
    if (safe) return give_back(lines), true;
    parked_.reset(lines);
  } else if (GpioLines* const lost = lost_.exchange(nullptr, std::memory_order_acquire); lost != nullptr) {
    parked_.reset(lost);
  }
  away_ = true;
  if (parked_ != nullptr && !parked_->gone()) {
    const bool safe = parked_->write(safe_values_) == 0;
    if (safe) give_back(parked_.release());
    return safe;
  }
  parked_.reset();
  for (int left = kBusyTries;; --left) {
    auto lines = access_.open(request(safe_values_, false));
    if (lines) return give_back(lines->release()), true;
    if (lines.error().code != core::Code::P7404 || left == 0) return false;
    std::this_thread::sleep_for(kBusyPause);
  }
} catch (...) {
  return false;
}

void GpioDriver::release_if_gone() noexcept {
  GpioLines* const lines = borrow();
  if (lines == nullptr) return;
  if (lines->gone()) {
    delete lines;
  } else {
    give_back(lines);
  }
}

void GpioDriver::close() noexcept {
  drive_safe();
  const std::scoped_lock lock(mutex_);
  opened_ = false;
  connected_.store(false, std::memory_order_relaxed);
  delete borrow();
  delete lost_.exchange(nullptr, std::memory_order_acquire);
  parked_.reset();
}

}  // namespace plc::io
