// SimulatedDevice: a driver whose inputs come from a CSV file instead of wires: kind = "simulated" in plc.toml, and
// plc-run --stimulus.
//
// In: a stimulus (stimulus.h); time 0 is the first release of its task. Out: variables written before the scans of
// that task. It owns the inputs that plc.toml gives it, as any driver does; its stimulus may name other variables of
// its task and globals too. Offline: it allocates in the cycle. Does not belong here: virtual time (Stimulus::attach).
#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "io-drivers/config/driver_type.h"
#include "io-drivers/stimulus.h"
#include "runtime/memory/global_ports.h"

namespace plc::io {

class SimulatedDevice final : public Driver {
 public:
  /// `stimulus` empty: inputs keep their initial values. Variables of tasks other than `task` are refused by check().
  /// `repeats`: after the last row the stimulus begins again.
  SimulatedDevice(std::string name, std::string stimulus, std::uint32_t task, runtime::Resource& resource,
                  bool repeats = false)
      : name_(std::move(name)), stimulus_(std::move(stimulus)), task_(task), resource_(resource), repeats_(repeats) {}
  /// Claims its inputs and the variable that says whether it answers, which it always does. Before any task runs.
  void claim(const BoundDriver& bound);

  [[nodiscard]] std::string_view name() const override { return name_; }
  [[nodiscard]] Timing timing() const override { return Timing::kOffline; }
  [[nodiscard]] std::uint32_t task() const override { return task_; }
  [[nodiscard]] bool has_outputs() const override { return false; }
  std::optional<core::Problem> check() override;
  std::optional<core::Problem> open() override;
  /// Says once that values of the stimulus are lost.
  std::vector<Sentence> service(core::TimeNs now_ns) override;
  [[nodiscard]] DriverStatus status() const override;
  [[nodiscard]] std::vector<InputStatus> inputs(core::TimeNs now_ns) const override;
  bool drive_safe() noexcept override { return true; }
  void close() noexcept override {}

  void before_scan(const runtime::ReleaseContext& context) noexcept override;
  void after_scan(const runtime::ReleaseContext&) noexcept override {}
  void safe_state() noexcept override {}

 private:
  [[nodiscard]] bool owns(const runtime::Place& place) const;
  std::string name_;
  std::string stimulus_;
  std::uint32_t task_;
  runtime::Resource& resource_;
  std::optional<Stimulus> script_;
  bool repeats_;
  runtime::Access access_{resource_};
  std::vector<std::uint32_t> claimed_;  ///< fields, ascending
  std::optional<BoundChannel> ok_;
  std::optional<runtime::GlobalInputs> inputs_;
  core::TimeNs first_release_ns_ = 0;
  std::atomic<std::uint64_t> exchanges_{0};
  std::atomic<bool> losing_{false};  ///< from here on script_->lost().first stays as it is
  bool told_ = false;
  std::vector<std::string_view> variables_;  ///< of its inputs, as plc.toml has them
};

/// kind = "simulated" (simulated_type.cpp).
extern const DriverType kSimulatedType;

}  // namespace plc::io
