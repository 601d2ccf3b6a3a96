// Program: the executable form of one task of a verified image. Handles become addresses here, before the first run.
//
// In: VerifiedImage, GlobalTable. Out: execute(), one scan of the task: imports, programs, exports as its body says, in
// the interpreter or in what a compiler made of the same resolved code (compiled_task.h).
// Threads: a Program belongs to one thread at a time; only the global table is shared (memory/exchange.h).
// Events stop nothing and are counted with their drawn element; a fault ends the scan (docs/guides/events.md).
// Does not belong here: when a task runs (sched/), names of variables (access.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bytecode/image.h"
#include "core/clock.h"
#include "core/result.h"
#include "core/source_ref.h"
#include "core/time_zone.h"
#include "runtime/memory/exchange.h"
#include "runtime/memory/global_table.h"
#include "runtime/memory/handover.h"
#include "runtime/memory/table.h"
#include "runtime/message_ring.h"
#include "stdlib/library.h"
#include "taskblocks/registry.h"

namespace plc::runtime {

struct CompiledTask;
struct LinkedCode;
class Forces;
class Probes;
class Recorder;
class Replay;

/// What a scan is told from outside. Taken once per cycle.
struct CycleContext {
  core::TimeNs now_ns = 0;
  core::TimeNs start_ns = 0;  ///< when the PLC started, by the same clock
  core::TimeNs utc_ns = 0;    ///< date and time, as taken with now_ns
};

enum class FaultKind : std::uint8_t {
  kNone,
  kLoopBudget,  ///< R1001
  kWatchdog,    ///< R1002: longer than the task's watchdog time
  kOverrun,     ///< R1003: ended after the next release, where that is a fault
  kTaskblock,   ///< R1004: the fire() of a taskblock failed
  kBudget,      ///< R1005: the fire() of a taskblock took longer than it declares
};

/// A scan that could not end regularly. Nothing was exported by the instructions after it.
struct Fault {
  FaultKind kind = FaultKind::kNone;
  std::uint32_t pou = 0;                  ///< index into Image::pous
  std::uint32_t word = 0;                 ///< code word of the instruction in that POU
  std::uint32_t taskblock = 0xffffffffu;  ///< kTaskblock, kBudget, and kWatchdog inside of fire(): which object
  explicit operator bool() const { return kind != FaultKind::kNone; }
};
/// The diagnostics code of a fault kind ("R1001").
core::Code fault_code(FaultKind kind);

/// The place in the user's files that code word `word` of POU `pou` came from.
core::SourceRef source_of(const bytecode::Image& image, std::uint32_t pou, std::uint32_t word);

/// How often one instruction raised an event.
struct EventCount {
  std::uint32_t pou = 0;
  std::uint32_t word = 0;
  stdlib::Event last = stdlib::Event::kNone;
  std::uint64_t count = 0;
};

/// A POU that somebody looks at, and the instance it runs on: its offset in the table of the task; of a function 0.
struct ProbedPou {
  std::uint32_t pou = 0;
  std::uint32_t instance = 0;
  friend auto operator<=>(const ProbedPou&, const ProbedPou&) = default;
};

struct ProgramOptions {
  std::uint32_t loop_budget = bytecode::kDefaultLoopBudget;  ///< LOOP_JUMPs that one scan may take
  bool huge_pages = false;
  bool arrange = true;  ///< false: the interpreter keeps the order of straight code (arrange.h), for who measures it
  std::vector<std::int32_t> priorities{};            ///< of the tasks, 0 the most urgent; empty = as the image declares
  const taskblocks::Registry* taskblocks = nullptr;  ///< of this machine; null = those that come with PICARD
  const core::Clock* budget_clock = nullptr;  ///< measures taskblocks that declare a time budget; null = none does
  /// False: taskblock instances in globals have no objects, and running one is a fault. For an image whose globals are
  /// copies of those of another one, which has the objects.
  bool global_taskblocks = true;
  /// False: nothing of taskblocks runs before Resource::start_taskblocks(), which a process that forks calls after
  /// that: threads that they start must be of the process that runs them.
  bool start_taskblocks = true;
  const core::TimeZone* zone = nullptr;  ///< of local time in programs; null: UTC. Must outlive the program
};

class Program {
 public:
  /// Resolves task `task` of the image. Refuses (P9001) tables that cannot be addressed and images that
  /// were made for another standard library. The image must outlive the program; `globals` too.
  static core::Result<std::unique_ptr<Program>> link(const bytecode::VerifiedImage& image, std::uint32_t task,
                                                     GlobalTable& globals, const ProgramOptions& options = {});
  /// A replica of the task: executes scans that were recorded. Its taskblocks have no objects, its exchange and queues
  /// answer from `replay`, which outlives it: Replay::begin() before each execute(), with the times of its head, on the
  /// table that the scan began with. `options` as those of the recorded program, but for the registry, which is not
  /// asked.
  static core::Result<std::unique_ptr<Program>> link_replica(const bytecode::VerifiedImage& image, std::uint32_t task,
                                                             Replay& replay, const ProgramOptions& options = {});
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// Shortly before execute(): does ahead what can be done twice, so that the scan finds it in the caches. Copies at
  /// most about `bytes`. No result changes. Between scans. RT: like execute().
  void expect(std::size_t bytes) noexcept;
  /// One scan. RT: noexcept, no allocation, no lock, no system call.
  Fault execute(const CycleContext& context) noexcept;

  /// Writes a variable of the task, at byte `at` of its table. Between scans, on the task's thread or while it does not
  /// run. RT.
  void write_local(std::uint32_t at, std::span<const std::byte> value) noexcept;
  /// What scans take in from now on is told to `recorder`; null = to nobody. Between scans.
  void set_recorder(Recorder* recorder);

  /// What keeps its value at both ends of each scan. The first call before the task runs; after that Forces::set() at
  /// any time.
  [[nodiscard]] Forces& forces();

  /// Other times for the rest of the scan that runs, for who is called by it and lets time go on (testing/). On the
  /// thread of the scan.
  void set_now(core::TimeNs now_ns, core::TimeNs utc_ns) noexcept;

  /// The task's resolved code: what a compiler starts from. Lives as long as the program.
  [[nodiscard]] const LinkedCode& linked() const;
  /// From the next scan on this runs instead of the interpreter. Not while a scan runs.
  void install(std::unique_ptr<CompiledTask> compiled);
  [[nodiscard]] bool is_compiled() const noexcept;

  /// Of a replica: from the next scan on what these POUs have at their probes is taken (bytecode/probes.h), which the
  /// interpreter does, on the same table; without views it runs as before again. Between scans. P9001 when it cannot be
  /// linked, or is no replica.
  std::optional<core::Problem> look_at(std::span<const ProbedPou> views);
  /// Null when nobody looks.
  [[nodiscard]] Probes* probes() noexcept;

  /// Where a running scan is, roughly: at its last loop jump or program call. Any thread; RT.
  [[nodiscard]] Fault place(FaultKind kind) const noexcept;
  /// Ends a running scan at its next loop jump, if there is one. May have to be said again. Any thread; RT.
  void cut_loops() noexcept;
  /// Takes the right to publish from a running scan: execute() will return kWatchdog, without effect on the global
  /// table. False when it is exporting already, or does not run. Any thread; RT.
  bool revoke() noexcept;
  /// Publishes these values of globals that the task exports, all else as published last. Between scans, or by the
  /// thread that revoked it. RT.
  void publish_safe(std::span<const GlobalWrite> values) noexcept;
  /// How the task's thread changes its priority under --coherence=priority-ceiling; null = it does not. Between scans.
  void set_priority_change(SetPriority set);

  /// A BOOL of the global table as published now: what releases an event task. Between scans. RT.
  [[nodiscard]] bool read_global_bool(std::uint32_t offset) noexcept;

  /// Other values than the initial ones: of the whole global table, and of the task's instance (as many bytes as
  /// ImagePou::instance_initial has). Typed as the verifier demands of initial values. Before the first scan.
  void restore(std::span<const std::byte> globals, std::span<const std::byte> instance);
  /// From now on these places can be asked for: Handover::Run::from is in table(). Before the first scan.
  void keep(std::vector<Handover::Run> runs, std::size_t bytes);
  /// Null when nothing of the task is kept.
  [[nodiscard]] Handover* handover() noexcept;
  /// Answers who asked, if the last scan ended without a fault; true when that took a copy. After execute(), when its
  /// outputs are where they belong. RT: bounded by what is kept.
  bool offer_kept() noexcept;

  /// Makes the objects of the taskblocks, if link() did not. Before the first scan. P7803 when one is not ready.
  std::optional<core::Problem> start_taskblocks();
  /// The taskblock whose fire() runs now, "LOWPASS main.filter", or null. Also for signal handlers on the task's
  /// thread.
  [[nodiscard]] const char* running_taskblock() const noexcept;
  /// Says that memory is being allocated on the task's thread: counts if a taskblock runs. RT.
  void count_allocation() noexcept;
  /// Taskblocks that allocated memory in their cycle: "LOWPASS main.filter", how often. Any thread.
  struct Allocations {
    std::string taskblock;
    std::uint64_t count = 0;
  };
  [[nodiscard]] std::vector<Allocations> allocations() const;
  /// What the task's taskblocks have told the operator since the last call. One thread at a time, while the task runs.
  [[nodiscard]] std::vector<TaskblockMessage> messages();
  /// How many messages were lost since the last call, because more waited than there is room for. As messages().
  [[nodiscard]] std::uint64_t lost_messages();
  /// The taskblock of a fault: "LOWPASS main.filter: why it failed first"; empty when the fault has none. Any thread.
  [[nodiscard]] std::string taskblock_text(const Fault& fault) const;

  [[nodiscard]] const bytecode::Image& image() const;
  [[nodiscard]] const bytecode::ImageTask& task() const;
  [[nodiscard]] std::uint32_t task_index() const;
  [[nodiscard]] TaskTable& table();
  [[nodiscard]] const TaskTable& table() const;

  /// Instructions that raised events since the start, in no particular order. May be read while the task runs: counts
  /// are relaxed atomics. At most kEventSlots instructions are told apart; the rest is in other_events().
  [[nodiscard]] std::vector<EventCount> events() const;
  [[nodiscard]] std::uint64_t other_events() const;
  [[nodiscard]] std::uint64_t event_total() const;
  static constexpr std::size_t kEventSlots = 256;

  /// Cold start: initial values again, events forgotten, taskblocks made anew. Not while the task runs. P7803 when one
  /// of those is not ready any more.
  std::optional<core::Problem> reset();

  /// How the linker resolved the boolean runs and bodies; for `explain`, tests and benchmarks.
  struct LinkReport {
    std::uint32_t fixed_bodies = 0;     ///< POUs with one instance: absolute operands
    std::uint32_t relative_bodies = 0;  ///< POUs with several instances: operands relative to the current one
    std::uint64_t short4_records = 0;   ///< BOOL_RUN records of 16 bytes, at most four inputs
    std::uint64_t short5_records = 0;   ///< BOOL_RUN records of 16 bytes, five inputs
    std::uint64_t wide_records = 0;     ///< BOOL_RUN records with 32-bit offsets
    std::uint64_t mixed_records = 0;    ///< BOOL_RUN records of relative bodies that mix instance and other memory
    std::uint64_t arranged = 0;         ///< instructions and records arranged side by side with others of their kind
    std::uint64_t runs = 0;             ///< ..in so many runs
    std::uint64_t code_bytes = 0;       ///< resolved code of the task
  };
  [[nodiscard]] const LinkReport& link_report() const;

 private:
  struct State;
  explicit Program(std::unique_ptr<State> state);
  static core::Result<std::unique_ptr<State>> lay_out(const bytecode::VerifiedImage& image, std::uint32_t task,
                                                      const ProgramOptions& options);
  static std::optional<core::Problem> resolve(State& state);
  static std::unique_ptr<Program> ready(std::unique_ptr<State> state);
  /// RT.
  void record(const CycleContext& context, const Fault& fault, std::uint64_t events, bool published) noexcept;
  std::unique_ptr<State> state_;
};

}  // namespace plc::runtime
