// ChangeTracker: runs those groups of a task whose inputs changed, and leaves out the others (docs/adr/0022).
//
// In: the tables of a ChangedPlan; calls from the task's code: begin() and end() around a scan, run() where groups
// stand in it. Out: the table, events and faults of a full evaluation. A group is clean when the bytes it reads are
// those of its last evaluation and the bytes it writes are as it left them; clean groups would change nothing. When
// more than about half of the work of a full scan has gone into finding and running dirty groups, the rest of the scan
// and kWholeScans after it run the plain code. Everything is counted in steps, never in time. All of it is RT but
// set-up. Does not belong here: which groups there are (changed_plan.h), machine code (compile.cpp).
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "native/table_copy.h"
#include "runtime/bool_run.h"
#include "runtime/compiled_task.h"
#include "runtime/interpreter.h"

namespace plc::native {

/// Groups of one chunk: its bits in one word. A chunk has straight code, and its groups run one by one, too.
inline constexpr std::uint32_t kChunkGroups = 64;

/// What a tracker works with, all of it made when the task is compiled. Groups have numbers: 64 times their chunk, plus
/// their bit.
struct ChangeTables {
  /// Bytes that the same groups read and write.
  struct Cell {
    std::uint32_t begin = 0;   ///< into `marks`: of groups that write, then of groups that read
    std::uint32_t others = 0;  ///< into `marks`: the first one behind the writer, if there is one writer; else begin
    std::uint32_t end = 0;
  };
  /// What is known of a record: its inputs and its output as they are in the copy of the table, so that a change of one
  /// of them costs no look at the others. Apart from all else, since many of them are changed at random: they stay in
  /// near caches.
  struct State {
    std::uint32_t truth = 0;  ///< inverted while the output is TRUE: bit `row` says whether it is dirty
    std::uint32_t row = 0;    ///< inputs, i0 + 2 i1 + ..
  };
  /// One look-up record, or code: in half a cache line.
  struct alignas(32) Group {
    std::uint32_t out = 0;   ///< kCode: none
    std::uint32_t more = 0;  ///< code: into `codes`; records: a list of other marks, in `marks`: how many, then these
    /// Marks for the change of a record's output; of the group that is never dirty where there are fewer.
    std::uint32_t near[6] = {};
  };
  static constexpr std::uint32_t kCode = 0xffffffffu;
  /// A mark is the number of a group times 64 and what the byte is to it: to a record, its output, or (bit k) its input
  /// k; to code, nothing.
  static constexpr std::uint32_t kOutput = 32;
  static constexpr std::uint32_t kInputs = 31;
  /// Bytes in one cell.
  struct Span {
    std::uint32_t offset = 0;
    std::uint32_t bytes = 0;
    std::uint32_t cell = 0;
  };
  struct List {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };
  struct Code {
    const std::byte* entry = nullptr;  ///< void (Machine&)
    List spans;                        ///< what it writes
    List timers;                       ///< into `timers`
    std::uint32_t group = 0;
    std::uint32_t effort = 0;  ///< of running it alone, in steps
    bool raises = false;       ///< events, perhaps
    bool is_restless = false;  ///< runs in every scan: time counts, though no timer says that it runs
  };
  /// Chunks that lie behind one another in the code; it is entered at the first one only.
  struct Stretch {
    std::uint32_t first = 0;  ///< chunk
    std::uint32_t chunks = 0;
    List codes;                       ///< of its groups, into `codes`
    const std::byte* exit = nullptr;  ///< of the code, behind it
  };

  std::vector<Group> groups;                    ///< by number; the last one is never dirty
  std::vector<State> states;                    ///< parallel to it
  std::vector<runtime::GeneralRecord> records;  ///< parallel to it
  std::vector<std::uint64_t> used;              ///< by chunk: bits of groups that exist
  std::vector<const std::byte*> entries;        ///< by chunk: its straight code
  std::vector<Stretch> stretches;
  std::vector<Code> codes;
  std::vector<Cell> cells;  ///< the first one has no groups
  std::vector<std::uint32_t> marks;
  std::vector<TableCopy::Area> areas;       ///< lines that hold cells
  std::vector<std::uint32_t> cell_of_byte;  ///< of each byte of an area, from Area::cells on; 0 = of nobody
  std::vector<Span> spans;
  std::vector<List> outside;                       ///< what instructions that are no groups write, each a list of spans
  std::vector<std::uint32_t> timers;               ///< offsets of STATE
  std::vector<std::uint32_t> contested;            ///< numbers of code that reads or writes what several write
  std::uint32_t constants = 0, constants_end = 0;  ///< offsets in the table: what nobody writes
  std::uint32_t count = 0;                         ///< groups
  std::uint32_t effort = 0;  ///< of a full evaluation, in steps: about what the code of one record takes
};

class ChangeTracker {
 public:
  /// `patience`, `baseline`: see CompileOptions. `tables` is filled by the compiler until the first scan.
  ChangeTracker(std::span<std::byte> table, ChangeTables tables, std::uint32_t patience, bool baseline);

  ChangeTables tables;

  /// Not 0 while the rest of the scan runs the plain code alone. What the code looks at.
  [[nodiscard]] const std::uint8_t& whole() const { return whole_; }

  /// Start and end of a scan; `fine`: no fault.
  void begin() noexcept;
  void end(const runtime::Machine& machine, bool fine) noexcept;
  /// The groups of a stretch. Returns where the code goes on: at the exit, or at a chunk that is to run in full.
  const std::byte* run(runtime::Machine& machine, std::uint32_t stretch) noexcept;
  /// Before an instruction that may write anywhere.
  void expect_changes() noexcept;
  /// An instruction that is no group wrote the bytes of ChangeTables::outside[list].
  void settle_outside(std::uint32_t list) noexcept;

  [[nodiscard]] const runtime::SkipCounts& counts() const { return counts_; }

  /// Scans that run the plain code before the next attempt to skip.
  static constexpr std::uint32_t kWholeScans = 32;

 private:
  /// What the scan is for.
  enum class Phase : std::uint8_t {
    kWhole,     ///< the plain code alone
    kSettling,  ///< the plain code, and what it changes: which groups are clean behind it
    kTracking,  ///< dirty groups
  };
  std::uint32_t run_chunks(runtime::Machine& machine, std::uint32_t first, std::uint32_t end) noexcept;
  void finish_chunk(runtime::Machine& machine, std::uint32_t chunk, std::uint64_t groups) noexcept;
  void run_code(runtime::Machine& machine, const ChangeTables::Code& code) noexcept;
  [[nodiscard]] bool is_timing(const ChangeTables::Code& code) const noexcept;
  void look() noexcept;
  void settle(const ChangeTables::Span& span, bool outside) noexcept;
  bool mark(std::uint32_t begin, std::uint32_t end, std::uint32_t toggled) noexcept;
  struct Marker;
  Marker marker() noexcept;
  void insist_on(std::uint32_t number) noexcept;
  void spend(std::uint32_t effort) noexcept { effort_ += effort; }
  [[nodiscard]] bool exhausted() const noexcept { return effort_ > limit_; }
  void mark_unsettled(const runtime::Machine& machine) noexcept;

  std::byte* table_;
  /// The table as groups know it, where there are cells: in front of the first scan, zeros. It follows the table byte
  /// by byte as these are marked, so that the two together are never wrong, only late.
  TableCopy copy_;
  std::vector<std::uint64_t> dirty_;         ///< by chunk
  std::vector<std::uint64_t> dirty_chunks_;  ///< bits of chunks that may be dirty
  std::vector<std::uint8_t> executed_;       ///< by stretch, while settling
  Phase phase_ = Phase::kSettling;
  std::uint8_t whole_ = 0;  ///< see whole()
  bool settling_ = false;   ///< the plain code runs, and what it changes is about to be seen
  bool look_ = false;       ///< anybody may have written anywhere since the table was looked at
  std::uint32_t whole_left_ = 0;
  std::uint32_t effort_ = 0;
  std::uint32_t limit_;       ///< of the effort
  std::uint32_t runs_ = 0;    ///< groups, in this scan
  std::uint64_t events_ = 0;  ///< when settling began
  runtime::SkipCounts counts_;
};

}  // namespace plc::native
