// AlarmState: an alarm in the sense of ISA-18.2: raised, acknowledged, returned, shelved, suppressed, out of service.
//
// In: that the condition began or ended, what people do. Out: the state, and what happened. Threads: one at a time.
// Does not belong here: conditions (condition.h), history.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/clock.h"

namespace plc::alarms {

enum class State : std::uint8_t {
  kNormal,
  kUnackedActive,
  kAckedActive,
  kUnackedReturned,
  kShelved,       ///< by a person, with an end
  kSuppressed,    ///< by the plant: it has no meaning now
  kOutOfService,  ///< by a person, until it is put into service again
};
inline constexpr std::array<std::string_view, 7> kStateTexts = {
    "normal", "unacked active", "acked active", "unacked returned", "shelved", "suppressed", "out of service"};

enum class Happened : std::uint8_t {
  kNothing,
  kRaised,
  kReturned,
  kAcknowledged,
  kShelved,
  kUnshelved,
  kSuppressed,
  kUnsuppressed,
  kOutOfService,
  kInService,
};
inline constexpr std::array<std::string_view, 10> kHappenedTexts = {
    "nothing",   "raised",     "returned",     "acknowledged",   "shelved",
    "unshelved", "suppressed", "unsuppressed", "out of service", "in service"};

class AlarmState {
 public:
  [[nodiscard]] State state() const;
  /// Not in its normal state, and not hidden by anybody.
  [[nodiscard]] bool is_shown() const { return !is_hidden() && (raised_ || unacked_); }
  /// Shelved, suppressed or out of service.
  [[nodiscard]] bool is_hidden() const { return shelved_until_ || suppressed_ || out_of_service_; }
  [[nodiscard]] bool is_unacked() const { return unacked_ && !is_hidden(); }

  /// The condition began or ended. `latch`: as its definition has it.
  Happened condition(bool is, bool latch);
  /// Somebody has seen it. kNothing when there was nothing to be seen; kReturned when a latched alarm ends with it.
  Happened acknowledge();
  /// `until_ns`: UTC.
  void shelve(core::TimeNs until_ns) {
    hide([&] { shelved_until_ = until_ns; });
  }
  void unshelve() {
    show([&] { shelved_until_.reset(); });
  }
  void suppress(bool is) {
    is ? hide([&] { suppressed_ = true; }) : show([&] { suppressed_ = false; });
  }
  void take_out_of_service(bool is) {
    is ? hide([&] { out_of_service_ = true; }) : show([&] { out_of_service_ = false; });
  }
  /// The condition is there, and nobody knew it, since the alarm was hidden: kRaised once.
  Happened take_shown();

  [[nodiscard]] std::optional<core::TimeNs> shelved_until_ns() const { return shelved_until_; }
  [[nodiscard]] bool is_suppressed() const { return suppressed_; }
  [[nodiscard]] bool is_out_of_service() const { return out_of_service_; }
  /// The condition is there.
  [[nodiscard]] bool is_active() const { return active_; }

  /// What has to be kept over a restart, as a number; and back. Suppression is the plant's, which says it again.
  [[nodiscard]] std::int64_t packed() const;
  static constexpr std::int64_t kPackedActive = 1;  ///< the bit of is_active()
  void unpack(std::int64_t packed, std::optional<core::TimeNs> shelved_until_ns);

 private:
  template <class Set>
  void hide(Set set) {
    set();
    raised_ = unacked_ = false;
  }
  template <class Set>
  void show(Set set) {
    const bool was_hidden = is_hidden();
    set();
    fresh_ = was_hidden && !is_hidden() && active_;
  }

  bool active_ = false;   ///< the condition
  bool raised_ = false;   ///< shown as active: the condition, or a latch
  bool unacked_ = false;  ///< since it was raised
  bool suppressed_ = false, out_of_service_ = false;
  bool fresh_ = false;
  std::optional<core::TimeNs> shelved_until_;
};

}  // namespace plc::alarms
