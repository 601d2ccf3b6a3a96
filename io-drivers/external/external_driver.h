// ExternalDriver: a driver of a library (picard/driver_abi.h) as io::Driver, on a thread of its own.
//
// In: a kind of a library, a BoundDriver. Out: numbers of the library as values of variables and back; a device that
// fails is lost, held as on_loss says, and opened again every `retry`. Threads: before_scan() and after_scan() are
// those of ThreadedDriver, which nobody else calls the library beside, but for open(), close() and drive_safe() while
// there is no thread. Does not belong here: loading libraries (external_types.h), what a device is.
#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "io-drivers/config/driver_type.h"
#include "picard/driver_abi.h"
#include "runtime/memory/global_ports.h"

namespace plc::io {

/// "a driver of a library has numbers and BOOLs" for types without a number, else empty.
std::string_view refuses_number(const bytecode::ImageType& type);

class ExternalDriver final : public Driver {
 public:
  /// Claims its inputs in the resource's global table: before any task runs. The configuration must outlive it.
  ExternalDriver(const picard_driver_kind& kind, const BoundDriver& bound, const Configuration& configuration,
                 runtime::Resource& resource);
  ~ExternalDriver() override;
  ExternalDriver(const ExternalDriver&) = delete;
  ExternalDriver& operator=(const ExternalDriver&) = delete;

  [[nodiscard]] std::string_view name() const override { return config_->name; }
  [[nodiscard]] Timing timing() const override { return Timing::kThreaded; }
  [[nodiscard]] std::uint32_t task() const override { return task_; }
  [[nodiscard]] bool has_outputs() const override { return !outputs_.empty(); }
  /// Makes the object: P7421 when the library refuses the settings.
  std::optional<core::Problem> check() override;
  std::optional<core::Problem> open() override;
  std::vector<Sentence> service(core::TimeNs now_ns) override;
  [[nodiscard]] DriverStatus status() const override;
  [[nodiscard]] std::vector<InputStatus> inputs(core::TimeNs now_ns) const override;
  bool drive_safe() noexcept override;
  void close() noexcept override;

  void before_scan(const runtime::ReleaseContext& context) noexcept override;
  void after_scan(const runtime::ReleaseContext& context) noexcept override;
  void safe_state() noexcept override;
  void task_stopped(std::uint32_t task) noexcept override;

 private:
  struct Point {
    std::string_view variable;
    std::uint32_t offset = 0, type = 0;
    core::TypeId elementary = core::TypeId::kLreal;
    bool invert = false;
  };
  struct Output : Point {
    double safe = 0;
    std::vector<std::uint32_t> exporters;
    std::atomic<bool> held{false};
  };
  /// What the library is told of the configuration; its addresses stay.
  struct Told {
    picard_driver_config config{};
    std::string folder;
    std::deque<std::vector<picard_setting>> settings;
    std::vector<picard_channel> inputs, outputs;
  };

  const picard_setting* tell_settings(const picard_key* keys, std::uint32_t count, const KeyValues& values);
  [[nodiscard]] Point point_of(const BoundChannel& channel, const runtime::Resource& resource) const;
  /// Takes the device and writes these outputs. False: why is in `failure_`.
  bool take_device(const std::vector<double>& outputs);
  bool exchange(bool (ExternalDriver::*what)(), std::uint32_t& failed);
  bool read_inputs();
  bool write_outputs();
  void lose();
  void come_back(core::TimeNs now_ns);
  void publish(bool connected);
  void say(core::Severity severity, std::string text);
  [[nodiscard]] std::string why() const;

  const picard_driver_kind& kind_;
  const DriverConfig* config_;
  std::uint32_t task_;
  bool may_wait_ = false;  ///< the key "wait"
  Told told_;
  std::vector<Point> inputs_;
  std::deque<Output> outputs_;
  std::optional<std::pair<std::uint32_t, std::uint32_t>> ok_;  ///< offset, type
  std::optional<runtime::GlobalInputs> to_table_;
  std::optional<runtime::GlobalReader> from_table_;
  std::vector<double> read_, wanted_, safe_, initial_;

  // Of the thread that has the device.
  void* object_ = nullptr;
  bool taken_ = false;  ///< from a good open() to close(), also while the device is lost
  bool open_ = false;
  picard_failure failure_{};
  std::uint32_t failed_reads_ = 0, failed_writes_ = 0;  ///< in a row
  core::TimeNs away_since_ns_ = 0, next_try_ns_ = 0;

  std::atomic<bool> connected_{false};
  std::atomic<core::TimeNs> read_at_ns_{-1};
  std::atomic<std::uint64_t> losses_{0}, recoveries_{0}, exchanges_{0};
  mutable std::mutex mutex_;  ///< of what follows; not for cycles of tasks, which never come here
  std::vector<Sentence> said_;
  std::string problem_;
};

}  // namespace plc::io
