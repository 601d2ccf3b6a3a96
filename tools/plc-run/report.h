// What plc-run says of a run: at its start, and of the times it measured, for people and for scripts.
//
// In: the image, the machine, statistics of tasks. Out: text. Everything may be printed while the tasks run: the
// statistics are read without holding them up. Does not belong here: when to print, measuring, what other commands
// print too (tools/statistics.h).
#pragma once

#include <iosfwd>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.h"
#include "io-drivers/machine/machine.h"
#include "runtime/force_list.h"
#include "runtime/sched/realtime.h"
#include "shadow/shadow.h"

namespace plc::tools {

/// Version, options, and each task with its release and what the machine has planned for it. `load_ns`: from the start
/// to here.
void print_start(std::string_view program, const bytecode::Image& image, std::span<const runtime::TaskPlan> plan,
                 core::TimeNs load_ns, std::ostream& out);
/// A line for each variable that is forced.
void print_forces(const runtime::ForceList& forces, std::ostream& out);
/// Drivers and guardian.
void print_devices(const io::Machine& machine, std::ostream& out);
/// Why a run ended.
struct End {
  int signal = 0;                             ///< that asked for it, or 0
  std::int64_t duration_ns = 0;               ///< --duration, or 0
  std::uint64_t cycles = 0;                   ///< --cycles, or 0
  const runtime::TaskFault* fault = nullptr;  ///< the last one, or null
};
/// "ends after 12.5 s: signal SIGTERM", ".. the guardian (process 812) has died".
void print_end(const End& end, const runtime::Resource& resource, const runtime::RealtimeScheduler& scheduler,
               core::TimeNs ran_ns, std::ostream& out);
/// What the system granted.
void print_realtime(const runtime::RealtimeReport& report, std::ostream& out);

/// A block per task: counters, and minimum, mean, percentiles and maximum of its times.
void print_times(const bytecode::Image& image, const runtime::RealtimeScheduler& scheduler, std::ostream& out);
/// A block per task: how many scans fell into each octave of time.
void print_histograms(const bytecode::Image& image, const runtime::RealtimeScheduler& scheduler, std::ostream& out);
/// The longest scans as they may be written in plc.toml, for the analysis of the schedule; tasks without a scan left
/// out.
void print_executions(const bytecode::Image& image, const runtime::RealtimeScheduler& scheduler, std::ostream& out);
/// A line per task: its engine.
void print_engines(const runtime::Resource& resource, std::ostream& out);
/// The same as the four above as one line of JSON, all times in ns:
/// {"realtime_priority": .., "memory_locked": .., "refused": [..], "tasks": [{"name": .., "engine": .., "latency":
/// {"count": .., .., "buckets": [[upper, count], ..]}, ..}]}.
void print_json(const runtime::Resource& resource, const runtime::RealtimeScheduler& scheduler,
                const shadow::Shadow* shadow, std::ostream& out);

void print_modbus(const modbus::ServerStatistics& statistics, std::ostream& out);
void print_modbus(const modbus::SerialStatistics& statistics, std::ostream& out);

}  // namespace plc::tools
