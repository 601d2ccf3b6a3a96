// The measurements of plc-bench but that of scans (scan.h). Every figure is a ratio of two things measured interleaved
// in the same run, and every speed comes with a check that the results are right.
//
// In: what to measure. Out: rows on stdout and a Verdict. Does not belong here: how (a file of its name for each).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/verdict.h"

namespace plc::bench {

struct PlotPlan {
  std::uint64_t seed = 1;
  std::uint32_t batches = 100;
  std::vector<std::string> only;  ///< names of workloads; none = all that have a plot
  std::string folder;             ///< where the SVG files go
};
/// measure_scan() over many sizes of the drawn workloads, as curves, with the ends of this machine's caches.
Verdict plot_scans(const PlotPlan& plan);

struct LoadPlan {
  std::uint64_t seed = 1;
  std::uint32_t repetitions = 7;
};
/// From file to the end of the first scan (`plc sim --cycles 1`) against `xmllint --noout` on the same file, and
/// resident memory then. Up to 100,000 rungs.
Verdict measure_load(const LoadPlan& plan);

struct TaskblockPlan {
  std::uint32_t batches = 200;  ///< timed batches of each side, interleaved; 0 = check only
};
/// What RUNTB adds to the fire() of a taskblock, and what a wire between two of them costs.
Verdict measure_taskblocks(const TaskblockPlan& plan);

/// An evaluation of a chart of 1,000 steps against one of its active step alone, `batches` timed batches of each;
/// 0 = check only.
Verdict measure_charts(std::uint32_t batches);

struct RetainPlan {
  std::uint32_t batches = 200;  ///< timed batches of each side, interleaved; 0 = check only
};
/// What 1 MB of retained variables costs the task that has them.
Verdict measure_retain(const RetainPlan& plan);

struct RecordPlan {
  std::uint32_t batches = 100;            ///< of scans of each side, interleaved; 0 = check only
  std::uint32_t seconds = 10;             ///< of each run of plc-run
  std::uint32_t rounds = 3;               ///< of both kinds of it in turn; 0 = none
  std::uint64_t day_scans = 100'000'000;  ///< of the long recording; 0 = none
};
/// What recording, checkpoints and replay cost.
Verdict measure_record(const RecordPlan& plan);

/// Scans of a replica with a probe at every place of 1,000 and 10,000 drawn rungs, `batches` timed batches beside the
/// same without; 0 = check only.
Verdict measure_probes(std::uint32_t batches);

struct HistorianPlan {
  std::uint32_t hours = 24;  ///< that are simulated; 0 = check only
  std::uint32_t tags = 1000;
};
/// A day of 1,000 tags at 10 Hz: bytes, and any zoom of any tag.
Verdict measure_historian(const HistorianPlan& plan);

struct CompilePlan {
  std::uint64_t seed = 1;
  std::uint32_t lines = 100'000;
  std::uint32_t garbage_mb = 10;
  std::uint32_t repetitions = 7;
  bool limits = true;  ///< false: only that programs compile and garbage is refused
};
/// From .st file to verified image, and how fast garbage is refused.
Verdict measure_compile(const CompilePlan& plan);

struct CoherencePlan {
  std::uint32_t cycles = 20'000;  ///< of the fast task, for each protocol, size and place
  std::uint32_t parts = 10;       ///< of these cycles, protocols interleaved
  std::vector<std::uint32_t> sizes = {1, 10, 100, 1'000, 10'000};  ///< variables in each direction
  bool limits = true;
  std::string plot;  ///< SVG file to write, or empty
};
/// The three coherence protocols, and memcpy of the same bytes. Needs two processors and SCHED_FIFO.
Verdict measure_coherence(const CoherencePlan& plan);

struct ModbusPlan {
  double seconds = 60;  ///< of load; a sixth of it for each of the other phases
  unsigned connections = 100;
  std::string torture;  ///< tool that plays hostile clients; a file that is not there is said to be so
};
/// The Modbus server: torn values, speed against libmodbus's own server in the same run, memory, and what the scan
/// notices.
Verdict measure_modbus(const ModbusPlan& plan);

struct DevicesPlan {
  double seconds = 20;  ///< of each side, in each round
  unsigned rounds = 3;
  unsigned devices = 64;
  bool share = false;  ///< the task has no processor for itself
};
/// Modbus devices that this process reads, beside a task of 1 ms: its times with and without them, in turns.
Verdict measure_devices(const DevicesPlan& plan);

struct EngineeringPlan {
  double seconds = 10;  ///< of each side, in each round
  unsigned rounds = 3;
  unsigned clients = 50;
  unsigned variables = 5000;
};
/// The engineering server of plc-run: calls, streams, wrong passwords, and how late a task of 1 ms wakes beside them.
Verdict measure_engineering(const EngineeringPlan& plan);

}  // namespace plc::bench
