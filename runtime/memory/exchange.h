// Exchange: one task's part in the exchange of globals at the ends of its cycle (paper, 3.2.2; docs/adr/0012).
//
// In: field ranges of the global table as READ_N, WRITE_N and WRITE_CHANGED_N name them. Out: the task's local copy of the
// table, consistent per owner, and one snapshot of all it exports. What a task alone exports lives in its local copy;
// READ_N brings only what others own. Interpreter and engines know this interface only. Threads: all calls on the task's
// thread; wait-free, bounded by the sizes of the ranges and the journal.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bytecode/image.h"
#include "runtime/memory/global_table.h"
#include "runtime/memory/table.h"

namespace plc::runtime {

/// Copies `bytes` out of or into memory that several threads access as relaxed atomics, in words as the shared address is
/// aligned: a naturally aligned value of up to 8 bytes never tears. RT.
void copy_from_shared(std::byte* to, const std::byte* shared, std::size_t bytes) noexcept;
void copy_to_shared(std::byte* shared, const std::byte* from, std::size_t bytes) noexcept;
/// Stores one value of 1, 2, 4 or 8 bytes there unless it is no longer `expected`; whether it did. RT.
bool replace_shared(std::byte* shared, const std::byte* expected, const std::byte* value, std::size_t bytes) noexcept;

class Exchange {
 public:
  /// `local` is the start of the task's table; its first bytes are the copy of the global table.
  Exchange(GlobalTable& globals, std::uint32_t task, std::byte* local);
  ~Exchange();
  Exchange(const Exchange&) = delete;
  Exchange& operator=(const Exchange&) = delete;

  /// Makes a range of `count` fields from `first` on known, to import or to export; returns its number. Set-up.
  std::uint32_t add_range(std::uint32_t first, std::uint32_t count, bool exports);
  /// Works out again who owns what; the table calls it. Set-up.
  void prepare();
  /// Forgets what was imported, as after a cold start.
  void reset();

  /// Start of a cycle: applies the journal, takes the newest snapshot of every owner it reads. RT.
  void begin() noexcept;
  /// RT.
  void import(std::uint32_t range) noexcept;
  /// Marks the range for publication; shared values only where they differ from what was imported. RT.
  void export_range(std::uint32_t range) noexcept;
  void raise(std::uint32_t /*group*/) noexcept {}
  void reschedule() noexcept {}
  void lock() noexcept {}
  void unlock() noexcept {}
  std::uint32_t add_group(std::uint32_t, std::uint32_t) { return 0; }
  /// End of a cycle: publishes what was exported, gives the snapshots back. RT.
  void end() noexcept;

  /// The BOOL at `offset` as published now; between cycles. RT.
  [[nodiscard]] bool read_bool(std::uint32_t offset) noexcept;

 private:
  /// Bytes of the table that one owner publishes side by side.
  struct Stretch {
    std::uint32_t owner = 0;
    std::uint32_t begin = 0;
    std::uint32_t end = 0;
    std::size_t at = 0;  ///< where they start in its snapshot
  };
  struct Range {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    bool exports = false;
    std::vector<Stretch> stretches;     ///< to import: owned by others; to export: owned by this task
    std::vector<std::uint32_t> leaves;  ///< shared and overlapping: into GlobalTable::leaves_
  };
  void import_leaves(std::uint32_t index) noexcept;
  void export_leaves(const GlobalTable::Leaves& leaves) noexcept;
  void open_snapshot() noexcept;
  void apply(const Journal::Entry& entry, const std::byte* value, const std::byte* mask) noexcept;

  GlobalTable& globals_;
  std::uint32_t task_;
  std::byte* local_;
  std::vector<Range> ranges_;
  std::vector<std::uint32_t> sources_;  ///< owners it reads
  GlobalTable::Held held_;
  static constexpr std::uint64_t kNotImported = ~std::uint64_t{0};
  std::vector<std::uint64_t> imported_; ///< per GlobalTable::leaves_: its version at the last import
  TableMemory shadow_;                  ///< shared and overlapping leaves as imported; size 0 without any
  bool in_parts_ = false;               ///< several ranges make up what it publishes
  std::byte* writing_ = nullptr;        ///< the snapshot of this cycle, once something was exported
  std::uint64_t stamp_ = 0;             ///< of this cycle; 0 = none drawn yet
};

}  // namespace plc::runtime
