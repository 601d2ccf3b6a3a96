// TimeZone: what local time is, as a table that is made once, so that a scan can ask it.
//
// In: the time zone database of the machine, by name. Out: local time of any UTC, from 1970 to 2100; before and after,
// that of the ends. Threads: load() before there are others, since it asks the C library under another TZ; the rest
// any. Does not belong here: what time it is (clock.h).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/clock.h"

namespace plc::core {

class TimeZone {
 public:
  /// UTC.
  TimeZone() = default;
  /// A zone of the database ("Europe/Berlin"), "UTC", or a rule as POSIX writes it ("CET-1CEST,M3.5.0,M10.5.0/3");
  /// empty: the zone of this machine. Nothing when there is no such zone.
  static std::optional<TimeZone> load(const std::string& name);

  /// Local time minus UTC at that time. RT: some ten steps of a search.
  [[nodiscard]] TimeNs offset_ns(TimeNs utc_ns) const noexcept;
  /// As given; of an empty name what TZ or /etc/localtime say, or "UTC".
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  struct Change {
    TimeNs from_ns = 0;  ///< UTC
    TimeNs offset_ns = 0;
  };
  std::string name_ = "UTC";
  TimeNs first_offset_ns_ = 0;
  std::vector<Change> changes_;  ///< ascending
};

}  // namespace plc::core
