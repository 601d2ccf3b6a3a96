// CoilLatch: a coil that was set stays set until the program has seen it, however soon the client takes it back.
//
// In: writes of coils whose range in plc.toml says `latch`, how many scans the tasks have made. Out: which resets have
// to wait, and which need not any more. Threads: one. Nothing is allocated after construction. Does not belong here:
// the table, timers.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "io-drivers/modbus/address_map.h"
#include "runtime/resource.h"

namespace plc::modbus {

/// Scans that a task has made; kNoMoreScans when it will make none. Any thread.
using ScanSource = std::function<std::uint64_t(std::uint32_t task)>;
inline constexpr std::uint64_t kNoMoreScans = ~std::uint64_t{0};

class CoilLatch {
 public:
  CoilLatch(const runtime::Resource& resource, const AddressMap& map);
  /// Without it nothing is latched. Before the first write.
  void set_scans(ScanSource source) { scans_ = std::move(source); }

  /// Whether a reset of the point has to wait: it was set, and a task that uses it has not seen that.
  [[nodiscard]] bool must_wait(std::uint32_t point) const;
  /// The point was set, or reset when must_wait() says so.
  void was_set(std::uint32_t point);
  void reset_later(std::uint32_t point);
  /// Points whose reset has waited long enough; they are forgotten.
  std::span<const std::uint32_t> due();
  [[nodiscard]] bool any_waits() const { return waiting_ != 0; }

 private:
  struct Coil {
    std::uint32_t point = 0;
    bool pressed = false;                                          ///< and not known to have been seen
    bool reset = false;                                            ///< as soon as it was seen
    std::vector<std::pair<std::uint32_t, std::uint64_t>> tasks{};  ///< that use it, and their scans when it was set
  };
  [[nodiscard]] const Coil* find(std::uint32_t point) const;
  [[nodiscard]] Coil* find(std::uint32_t point) { return const_cast<Coil*>(std::as_const(*this).find(point)); }
  [[nodiscard]] bool was_seen(const Coil& coil) const;

  ScanSource scans_;
  std::vector<Coil> coils_;  ///< by point
  std::vector<std::uint32_t> due_;
  std::size_t waiting_ = 0;
};

}  // namespace plc::modbus
