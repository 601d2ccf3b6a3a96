// ScanObserver: is told of every scan that replicas execute soon after the plant has.
//
// Threads: that of the shadow, while no other scan is executed; it must not call the shadow. Does not belong here: what
// is looked for.
#pragma once

#include <cstdint>

#include "core/clock.h"

namespace plc::shadow {

class ReplicaSet;

/// A scan that a replica has executed.
struct ObservedScan {
  std::uint32_t task = 0;
  std::uint64_t scan = 0;
  core::TimeNs now_ns = 0;  ///< what the scan was told
  core::TimeNs utc_ns = 0;
};

class ScanObserver {
 public:
  virtual ~ScanObserver() = default;
  /// The tables of `replicas` are those after the scan.
  virtual void after_scan(const ReplicaSet& replicas, const ObservedScan& scan) = 0;
};

}  // namespace plc::shadow
