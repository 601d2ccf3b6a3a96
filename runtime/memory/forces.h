// Forces: values that variables of a task keep at both ends of its cycle, whatever writes them.
//
// In: places of the task's table and values, from a thread that may allocate. Out: the same, to the task, between two
// scans and all at once. A forced variable has its value when the scan begins and when it ends, and so has everything
// that others see of it; what the program writes in between is its own until then. Threads: set() on one thread, take()
// on the task's. Nobody waits. Does not belong here: who forces, how long, and why.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/memory/exchange.h"
#include "runtime/record/recorder.h"

namespace plc::runtime {

/// A part of a task's table that is forced: a scalar or a text, as the table has it.
struct ForcedPlace {
  std::uint32_t at = 0;
  /// A global that comes from elsewhere: also forced whenever it is imported.
  bool imported = false;
  /// A global that the task exports: also forced before it is exported.
  bool exported = false;
  std::vector<std::byte> value;
};

class Forces {
 public:
  /// From the next scan on these, and no others. Any one thread; allocates.
  void set(std::vector<ForcedPlace> places);
  /// The start of a scan: what holds in it. True when something is forced. RT.
  bool take() noexcept;

  /// What take() has found. RT.
  [[nodiscard]] std::span<const ForcedPlace> places() const noexcept { return slots_[read_]; }

 private:
  static constexpr std::uint8_t kNew = 4;
  std::vector<ForcedPlace> slots_[3];
  std::uint8_t write_ = 0, read_ = 1;     ///< slots of the two threads
  std::atomic<std::uint8_t> between_{2};  ///< the third one; kNew: it was written and not taken
};

/// The exchange of a scan in which something is forced: that of the task, and the forced values around it.
class ForcingExchange final : public Exchange {
 public:
  ForcingExchange(Exchange& inner, std::byte* table) : inner_(inner), table_(table) {}
  /// As Exchange::set_recorder(), of which the inner one is told by who made it.
  void set_recorder(Recorder* recorder) override { recorder_ = recorder; }
  /// What holds in the scan that begins; before begin(). RT.
  void hold(std::span<const ForcedPlace> places) noexcept { places_ = places; }

  std::uint32_t add_range(std::uint32_t first, std::uint32_t count, Use use) override {
    return inner_.add_range(first, count, use);
  }
  void prepare() override { inner_.prepare(); }
  void reset() override { inner_.reset(); }
  void expect(std::size_t bytes) noexcept override { inner_.expect(bytes); }
  void begin() noexcept override;
  void import(std::uint32_t range) noexcept override;
  void export_range(std::uint32_t range) noexcept override;
  bool end() noexcept override;
  void raise(std::uint32_t range) noexcept override { inner_.raise(range); }
  void reschedule() noexcept override { inner_.reschedule(); }
  void lock() noexcept override { inner_.lock(); }
  void unlock() noexcept override { inner_.unlock(); }
  [[nodiscard]] bool read_bool(std::uint32_t offset) noexcept override { return inner_.read_bool(offset); }
  bool revoke() noexcept override { return inner_.revoke(); }
  void publish_safe(std::span<const GlobalWrite> values) noexcept override { inner_.publish_safe(values); }

 private:
  /// Puts the value into the table; false when it was there. RT.
  bool put(const ForcedPlace& place) noexcept;

  Exchange& inner_;
  std::byte* table_;
  Recorder* recorder_ = nullptr;
  std::span<const ForcedPlace> places_;
  std::uint32_t exports_ = 0;  ///< of this scan, before the present one
};

}  // namespace plc::runtime
