// GpioDriver: BOOL variables on GPIO lines, read before and written after each scan of one task.
//
// In: a BoundDriver (config/bind.h), lines through GpioAccess. Out: inputs published as one snapshot, outputs on lines.
// Bounded: per cycle one ioctl for each group of up to 64 lines with equal settings, two calls for each latched input,
// and all of that once more when it fails; outputs are written when one changed, and every kRefreshNs at the latest.
// A device whose exchange fails in more cycles in a row than `errors` is lost until service() gets it back.
// Does not belong here: libgpiod (gpio_lines.cpp), what variables mean, when the process dies (guardian/).
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io-drivers/config/driver_type.h"
#include "io-drivers/gpio/gpio_lines.h"
#include "runtime/memory/global_ports.h"

namespace plc::io {

/// An edge between two cycles is seen as one cycle of TRUE (rising) or FALSE (falling).
enum class Latch : std::uint8_t { kNone, kRising, kFalling };

class GpioDriver final : public Driver {
 public:
  /// WHY: unchanged outputs are not written each cycle (a line on an I2C expander costs a bus transfer), but now and
  /// then they are: that is how the loss of a chip with outputs only is noticed, and an expander that lost its state
  /// gets it back.
  static constexpr core::TimeNs kRefreshNs = 100'000'000;

  /// Claims its inputs in the resource's global table: before any task runs. The configuration must outlive the driver.
  GpioDriver(const BoundDriver& bound, runtime::Resource& resource, GpioAccess access);
  ~GpioDriver() override;
  GpioDriver(const GpioDriver&) = delete;
  GpioDriver& operator=(const GpioDriver&) = delete;

  [[nodiscard]] std::string_view name() const override { return config_->name; }
  [[nodiscard]] Timing timing() const override { return Timing::kBounded; }
  [[nodiscard]] std::uint32_t task() const override { return task_; }
  [[nodiscard]] bool has_outputs() const override { return !outputs_.empty(); }

  std::optional<core::Problem> check() override;
  std::optional<core::Problem> open() override;
  std::vector<Sentence> service(core::TimeNs now_ns) override;
  [[nodiscard]] DriverStatus status() const override;
  [[nodiscard]] std::vector<InputStatus> inputs(core::TimeNs now_ns) const override;
  bool drive_safe() noexcept override;
  void release_if_gone() noexcept override;
  void close() noexcept override;

  void before_scan(const runtime::ReleaseContext& context) noexcept override;
  void after_scan(const runtime::ReleaseContext& context) noexcept override;
  void safe_state() noexcept override;
  /// Outputs that `task` writes become safe and stay so; all of them when it is the task this driver serves.
  void task_stopped(std::uint32_t task) noexcept override;

 private:
  struct Input {
    std::string_view variable;
    std::uint32_t offset = 0, type = 0;
    bool invert = false;
    Latch latch = Latch::kNone;
  };
  struct Output {
    std::uint32_t offset = 0;
    bool invert = false;
    std::uint8_t safe = 0;             ///< on the line: inverted already
    std::atomic<std::uint8_t> wanted;  ///< on the line: what the last cycle wanted, at first the initial value
    std::vector<std::uint32_t> exporters;
    std::atomic<bool> held{false};  ///< safe for good: a task that writes it has stopped, or all have
  };

  [[nodiscard]] LinesRequest request(std::span<const std::uint8_t> values, bool with_inputs) const;
  [[nodiscard]] std::vector<std::uint8_t> wanted_values() const;
  void take_inputs() noexcept;
  void lose_inputs() noexcept;
  GpioLines* borrow() noexcept { return active_.exchange(nullptr, std::memory_order_acquire); }
  void give_back(GpioLines* lines) noexcept { active_.store(lines, std::memory_order_release); }
  template <class Exchange>
  int try_twice(Exchange exchange) noexcept;
  void failed(GpioLines* lines, int error, std::uint32_t& in_a_row) noexcept;
  void lose(GpioLines* lines, int error) noexcept;
  void count_exchange() noexcept;
  void hold_all() noexcept;
  bool works(GpioLines& lines);
  std::optional<std::string> try_to_come_back();
  void tell_errors(core::TimeNs now_ns, std::vector<Sentence>& said);

  const DriverConfig* config_;
  GpioAccess access_;
  std::uint32_t task_;
  std::vector<Input> inputs_;
  std::vector<std::unique_ptr<Output>> outputs_;
  LinesRequest request_;                                       ///< outputs with their initial values
  std::optional<std::pair<std::uint32_t, std::uint32_t>> ok_;  ///< offset, type
  std::optional<runtime::GlobalInputs> to_table_;
  std::optional<runtime::GlobalReader> from_table_;
  std::vector<std::uint8_t> safe_values_;
  std::uint32_t errors_allowed_ = 0;  ///< cycles in a row

  // The lines change hands, and the thread that has the pointer may use them: the cycle borrows from active_ and gives
  // back, or puts what failed into lost_; service() takes from lost_ and puts what works into active_. Neither ever
  // waits.
  std::atomic<GpioLines*> active_{nullptr};
  std::atomic<GpioLines*> lost_{nullptr};

  // The cycle's own.
  std::vector<LineInput> read_;
  std::vector<std::uint8_t> wanted_, written_;
  bool inputs_good_ = false;
  std::uint32_t reads_failed_ = 0, writes_failed_ = 0;  ///< cycles in a row
  bool written_valid_ = false;                          ///< written_ is what these lines have
  core::TimeNs refresh_ns_ = 0;

  // Told by the cycle, read by anyone.
  std::atomic<int> error_{0};
  std::atomic<bool> connected_{false};
  std::atomic<core::TimeNs> read_at_ns_{-1};  ///< -1 = never
  std::atomic<std::uint64_t> losses_{0}, recoveries_{0}, exchanges_{0}, errors_{0};

  // service(), status(), drive_safe() and close(); never the cycle.
  mutable std::mutex mutex_;
  std::unique_ptr<GpioLines> parked_;  ///< failed, but the device may only have been busy
  bool opened_ = false;
  bool away_ = false;
  bool late_ = false;  ///< it was not there at the start, and has not come yet
  core::TimeNs away_since_ns_ = 0, next_try_ns_ = 0;
  std::string problem_;
  std::string told_;  ///< of a late device: the problem that was said
  std::uint64_t errors_told_ = 0;
  core::TimeNs next_errors_ns_ = 0;
};

/// kind = "gpio" (gpio_type.cpp).
extern const DriverType kGpioType;

}  // namespace plc::io
