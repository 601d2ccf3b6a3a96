// Limits of plc-bench: what each measured figure may be at most, and in words what is measured against what.
//
// Out: the only place where they are; `plc-bench limits` prints them as the table of README.md. Does not belong here:
// measuring.
#pragma once

namespace plc::bench {

struct Limit {
  double most = 0;
  const char* unit = "times";  ///< of `most`
  const char* measured = "";
  const char* against = "";  ///< empty: nothing
};

namespace limit {

inline constexpr const char* kBarrierC = "C, `gcc -O2` with a barrier after each rung";

// Scan.
inline constexpr Limit kLadderNative{1.15, "times", "native code of boolean ladders (`plain`, `rewritten`)", kBarrierC};
/// WHY not 1: medians of equal code differ by as much on a machine that does other things, too.
inline constexpr Limit kLadderNotSlower{1.02, "times", "`plain` of these", "C, `gcc -O2` without barriers: not slower"};
inline constexpr Limit kDrawnNative{
    1.25, "times", "native code of timers and counters, drawn arithmetic, and ladders that hold some of them",
    kBarrierC};
inline constexpr Limit kLoopNative{2, "times", "native code of loops in ST",
                                   "C, `gcc -O2` with a barrier after each sample, byte, row .."};
inline constexpr Limit kInterpreter{6, "times", "interpreter on all of these but loops, taskblocks and exchange too",
                                    "the same C"};
/// WHY not 1: where nothing is gained, both run at the same speed, and medians differ by as much.
inline constexpr Limit kNotSlowerThanInterpreter{1.02, "times", "native code of every workload",
                                                 "the interpreter: not slower"};

// Load.
inline constexpr Limit kFirstScan{1, "times", "`plc sim --cycles 1` at 10,000 plain rungs (24 MB of XML)",
                                  "`xmllint --noout` on the same file"};
inline constexpr Limit kResident{2, "kB a rung",
                                 "resident memory with 10,000 and 100,000 plain rungs loaded and compiled", ""};
inline constexpr Limit kPeak{200, "MB", "peak memory of loading 10,000 plain rungs", ""};
inline constexpr Limit kMarginalLoad{1.2, "times", "marginal cost of loading, 10,000 to 100,000 rungs",
                                     "1,000 to 10,000 rungs"};

// Taskblocks.
inline constexpr Limit kTaskblockCall{3, "ns more", "RUNTB of an empty taskblock without budget",
                                      "an indirect call of the same `fire()` on the same object"};
inline constexpr Limit kTaskblockWires{1.1, "times", "1,000 empty taskblocks in a chain, eight LREAL wires each",
                                       "the same, unconnected"};

// Charts.
inline constexpr Limit kLargeChart{2, "times", "native code of a chart of 1,000 steps with one token",
                                   "a chart of that step alone, with its transition"};

// Retained variables.
inline constexpr Limit kRetainIdle{1.02, "times", "scans of a program that keeps 1 MB, while nobody asks for it",
                                   "the same program, nothing kept"};
inline constexpr Limit kRetainShare{0.5, "% of the time", "handing over 1 MB of retained variables, once in 100 ms",
                                    ""};

// Recording.
inline constexpr Limit kRecordSmall{60, "ns more", "a recorded scan that takes in up to 1 KB",
                                    "the same, not recorded"};
inline constexpr Limit kRecordSmallCold{250, "ns more", "the same with caches cold", "the same, not recorded"};
inline constexpr Limit kRecordLarge{200, "ns more", "a recorded scan that takes in 8 KB", "the same, not recorded"};
inline constexpr Limit kRecordLargeCold{400, "ns more", "the same with caches cold", "the same, not recorded"};
inline constexpr Limit kCheckpoint{50, "us a MB", "a checkpoint, once in 10 s", ""};
inline constexpr Limit kReplayedScan{100, "ns", "a scan of examples/tank that is executed again, native", ""};
inline constexpr Limit kSeek{200, "ms",
                             "to any scan of the last hour of a task of 1 ms, opening the recording included", ""};
inline constexpr Limit kWakeUpRecorded{1.2, "times",
                                       "p99.9 of how late a task of 1 ms wakes, recorded and executed again beside it",
                                       "the same, not recorded"};

// Historian.
inline constexpr Limit kHistorySize{5, "GB", "24 hours of 1,000 tags at 10 Hz in the historian", ""};
inline constexpr Limit kHistoryZoom{100, "ms", "any zoom of any tag of that, 1,000 points", ""};
inline constexpr Limit kHistoryZoomCold{100, "ms", "the same with nothing of the file in memory", ""};

// Probes.
inline constexpr Limit kProbes{100, "us a scan", "a replica of 1,000 drawn rungs, `plain` or `mixed`, with all probes",
                               ""};

// Compile.
inline constexpr Limit kCompile{2, "s", "`plc compile` of 100,000 lines of ST", ""};
inline constexpr Limit kCompilePeak{500, "MB", "peak memory of that", ""};
inline constexpr Limit kRefuse{2, "s", "`plc check` of 10 MB of each of eight kinds of garbage", ""};

// Modbus.
inline constexpr Limit kRequests{1, "times", "libmodbus's own server (one thread, `select`)",
                                 "the Modbus server, in requests/s"};
inline constexpr Limit kScanBesideClients{
    1.3, "times", "scan time p99.9 while 100 clients poll, and while hostile ones do their worst",
    "the same without clients"};
inline constexpr Limit kGrowth{512, "kB more", "resident memory after 60 s of that", "before"};
inline constexpr Limit kBesideDevices{
    1.2, "times",
    "p99.9 from release to end of scan of a task of 1 ms that reads 64 Modbus devices of 125 registers at 100 Hz",
    "the same task without the devices"};

// Engineering server.
inline constexpr Limit kCall{2, "ms", "a call of the engineering server on loopback, p99", ""};
inline constexpr Limit kFrames{1.05, "times", "60 frames a second",
                               "what the slowest of 50 clients gets that see 5,000 variables"};
inline constexpr Limit kServer{10, "% of a processor",
                               "the server for these clients, where a tenth of the variables changes", ""};
inline constexpr Limit kLogin{2, "s", "a login while 1,000 wrong passwords a second come", ""};
inline constexpr Limit kWakeUpWatched{
    1.2, "times", "p99.9 of how late a task of 1 ms wakes, with 50 such clients, and under wrong passwords",
    "the same without clients"};

// Coherence.
inline constexpr Limit kExchange{
    1.2, "times",
    "wait-free exchange of 1 to 10,000 DINTs in and out, p99.9, while the other processor exchanges the same",
    "memcpy of the same bytes, just written there"};

/// All of them, in the order of the table.
inline constexpr const Limit* kAll[] = {&kLadderNative,
                                        &kLadderNotSlower,
                                        &kDrawnNative,
                                        &kLoopNative,
                                        &kInterpreter,
                                        &kNotSlowerThanInterpreter,
                                        &kFirstScan,
                                        &kResident,
                                        &kPeak,
                                        &kMarginalLoad,
                                        &kTaskblockCall,
                                        &kTaskblockWires,
                                        &kLargeChart,
                                        &kRetainIdle,
                                        &kRetainShare,
                                        &kRecordSmall,
                                        &kRecordSmallCold,
                                        &kRecordLarge,
                                        &kRecordLargeCold,
                                        &kCheckpoint,
                                        &kReplayedScan,
                                        &kSeek,
                                        &kWakeUpRecorded,
                                        &kHistorySize,
                                        &kHistoryZoom,
                                        &kHistoryZoomCold,
                                        &kProbes,
                                        &kCompile,
                                        &kCompilePeak,
                                        &kRefuse,
                                        &kRequests,
                                        &kScanBesideClients,
                                        &kGrowth,
                                        &kBesideDevices,
                                        &kCall,
                                        &kFrames,
                                        &kServer,
                                        &kLogin,
                                        &kWakeUpWatched,
                                        &kExchange};

}  // namespace limit
}  // namespace plc::bench
