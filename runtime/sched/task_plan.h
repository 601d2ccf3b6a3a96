// TaskPlan: what this machine decides about a task beyond what the image declares.
//
// In: plc.toml, by way of its owner. Out: read by the linker (priorities), the schedulers and the analysis. Plain data.
// Does not belong here: where it comes from, what it costs.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bytecode/image.h"
#include "core/clock.h"

namespace plc::runtime {

/// What to do about a task that faulted; the other tasks go on unless it says kStop.
enum class FaultPolicy : std::uint8_t {
  kContinue,   ///< release it again at its next instant
  kSafeState,  ///< it stays stopped and the outputs go to their safe state
  kStop,       ///< everything stops, outputs in their safe state
};

/// What to do about a scan that ended after the task's next release instant.
enum class OverrunPolicy : std::uint8_t {
  kSkip,   ///< leave out the instants that passed, and count them
  kFault,  ///< it is a fault (R1003)
};

struct TaskPlan {
  std::int32_t priority = 0;   ///< 0 is the most urgent; equal ones run in the order of their release
  int cpu = -1;                ///< processor it is bound to; -1 = any
  core::TimeNs offset_ns = 0;  ///< from the common start to the first release
  std::optional<core::TimeNs> lead_ns = std::nullopt;  ///< nothing = the default: see lead_of()
  core::TimeNs deadline_ns = 0;  ///< from a release to the end of the scan, for the analysis; 0 = the interval
  std::optional<core::TimeNs> execution_ns = std::nullopt;  ///< longest scan as measured; nothing = not measured
  core::TimeNs watchdog_ns = 0;  ///< a scan longer than this is a fault (R1002); 0 = no watchdog
  OverrunPolicy overrun = OverrunPolicy::kSkip;
  FaultPolicy on_fault = FaultPolicy::kSafeState;
};

/// One plan a task, with the priorities that the image declares and nothing else.
std::vector<TaskPlan> default_plan(const bytecode::Image& image);

/// How long before its release a task with real-time priority wakes, to do ahead what can be done twice and to wait
/// awake for the instant: what it is released to do is in the caches by then. As planned, by default 5 % of the
/// interval, at most kDefaultLeadNs. Event tasks and freewheeling ones have no instant to wait for, and so none.
core::TimeNs lead_of(const bytecode::ImageTask& task, const TaskPlan& plan);
inline constexpr core::TimeNs kDefaultLeadNs = 50'000;
/// The longest lead is this part of the interval: no less urgent task runs meanwhile.
inline constexpr core::TimeNs kLongestLeadPart = 4;

/// Priorities 0, 1, .. by interval, the shortest first; equal intervals get equal ones. Event tasks and freewheeling
/// ones come last, in the order of the plan. Liu, Layland 1973.
void make_rate_monotonic(const bytecode::Image& image, std::vector<TaskPlan>& plan);

}  // namespace plc::runtime
