// ThreadedDriver: lets a driver whose calls may take long (lines of an I2C or SPI chip) work on a thread of its own
// instead of in a task's cycle.
//
// In: the driver, how often it is to exchange. Out: the same driver to everybody else. The task only shares the global
// table with it: inputs appear as one snapshot when the device has been read, outputs are those of the newest complete
// cycle. Threads: start() makes one; safe_state() tells it to make the device safe and end, without waiting for it,
// close() waits; the guardian's copy never has one. Does not belong here: what a device is.
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>

#include "io-drivers/driver.h"
#include "runtime/sched/ordinary_thread.h"

namespace plc::io {

class ThreadedDriver final : public Driver {
 public:
  /// Every `poll_ns` the driver's before_scan() and after_scan() are called, on the thread.
  ThreadedDriver(std::unique_ptr<Driver> driver, core::TimeNs poll_ns);
  ~ThreadedDriver() override;

  [[nodiscard]] std::string_view name() const override { return driver_->name(); }
  [[nodiscard]] Timing timing() const override { return Timing::kThreaded; }
  [[nodiscard]] std::uint32_t task() const override { return driver_->task(); }
  [[nodiscard]] bool has_outputs() const override { return driver_->has_outputs(); }
  std::optional<core::Problem> check() override { return driver_->check(); }
  std::optional<core::Problem> open() override { return driver_->open(); }
  void start() override;
  std::vector<Sentence> service(core::TimeNs now_ns) override { return driver_->service(now_ns); }
  [[nodiscard]] DriverStatus status() const override { return driver_->status(); }
  [[nodiscard]] std::vector<InputStatus> inputs(core::TimeNs now_ns) const override { return driver_->inputs(now_ns); }
  bool drive_safe() noexcept override;
  void release_if_gone() noexcept override { driver_->release_if_gone(); }
  void close() noexcept override;

  void before_scan(const runtime::ReleaseContext&) noexcept override {}
  void after_scan(const runtime::ReleaseContext&) noexcept override {}
  void safe_state() noexcept override;
  /// Left to the thread, which has the device.
  void task_stopped(std::uint32_t task) noexcept override;

 private:
  void run() noexcept;
  /// Whether there is another exchange then.
  bool rest_until(core::TimeNs at_ns);
  void tell_to_end() noexcept;

  std::unique_ptr<Driver> driver_;
  core::TimeNs poll_ns_;
  std::mutex mutex_;  ///< of `stop_`, with `changed_`
  std::condition_variable changed_;
  bool stop_ = false;
  std::atomic<std::uint64_t> stopped_tasks_{0};  ///< a bit each; the last one stands for all from 63 on
  runtime::OrdinaryThread thread_;
};

}  // namespace plc::io
