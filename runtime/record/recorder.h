// Recorder: writes the record of each scan of one task into a ring.
//
// In: what the task takes in, told by those who bring it (exchange, queues, taskblocks, Program). Out: records
// (record.h) in the order of scans. When the reader is behind, or a scan takes in more than a record may hold, that
// record is left out: what is lost is counted and said by the next record that fits, and the task goes on as ever.
// Threads: all on the task's thread between set-up and the end, RT, but for ask() and the checkpoint (see there). Does
// not belong here: what becomes of records (replay.h).
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "runtime/memory/table.h"
#include "runtime/record/record.h"
#include "runtime/record/ring.h"

namespace plc::runtime {

class Recorder {
 public:
  /// `table`: that of the task, without scratch. Both outlive the recorder. Allocates a table's size for checkpoints.
  Recorder(RecordRing& ring, std::span<std::byte> table);

  // ---- what a scan takes in; all RT

  /// Copies what others wrote into the table, at `at`; records it where it differs from what was there.
  void copy(std::uint32_t at, const std::byte* from, std::uint32_t bytes) noexcept;
  /// Records what the table has there now, since others wrote it.
  void written(std::uint32_t at, std::uint32_t bytes) noexcept;
  /// Records what the table has there now, since it was forced before export number `exports` of the scan, or at its
  /// end (kForcedAtEnd).
  void forced(std::uint32_t exports, std::uint32_t at, std::uint32_t bytes) noexcept;
  /// What comes is brought by the next import of the scan. Before the first one it is there before the first
  /// instruction.
  void next_import() noexcept { ++moment_; }
  /// A queue took an element, or gave one; `element` is empty where none was taken.
  void queue(bool done, std::span<const std::byte> element) noexcept;
  /// How many elements a queue has, or has room for.
  void number(std::uint32_t answer) noexcept;
  /// A taskblock ran. `status` is a Taskblocks::Status.
  void taskblock(std::uint32_t object, std::uint32_t status, std::span<const PortBytes> outputs) noexcept;
  /// The scan is over. Of `head` everything that concerns the scan is set, and nothing that concerns the record.
  void close(RecordHead head, const RecordedFault& fault) noexcept;
  /// The table was changed between scans by something that is no scan: nothing that follows can be executed again
  /// before the next checkpoint.
  void changed() noexcept;

  /// Records that were left out since the start. Any thread.
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_in_all_.load(std::memory_order_relaxed); }
  /// Scans and bytes of records since the start. Any thread.
  [[nodiscard]] std::uint64_t scans() const noexcept { return scans_in_all_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t bytes() const noexcept { return bytes_in_all_.load(std::memory_order_relaxed); }

  // ---- checkpoints: of one thread beside the task's

  /// From the end of a scan on, a record kCheckpointed says that checkpoint() is there. False while the one before has
  /// not been given back.
  bool ask() noexcept;
  /// The table as it was before scan `scan` of the record kCheckpointed that was read last.
  [[nodiscard]] std::span<const std::byte> checkpoint() const noexcept { return {checkpoint_.data(), table_.size()}; }
  /// The next one may be asked for.
  void give_back() noexcept { asked_.store(Asked::kNo, std::memory_order_release); }

 private:
  enum class State : std::uint8_t { kClosed, kOpen, kLeftOut };
  enum class Asked : std::uint8_t { kNo, kYes, kMade };

  /// The record of this scan is open; false when it is left out. RT.
  bool ready() noexcept;
  /// Room for `bytes` after the head of an entry; null when the record is left out. RT.
  std::byte* add(EntryKind kind, std::uint32_t at, std::uint32_t detail, std::size_t bytes) noexcept;
  /// A record of a head alone; false when there is no room. RT.
  bool put(const RecordHead& head) noexcept;
  void make_checkpoint() noexcept;

  RecordRing& ring_;
  std::span<std::byte> table_;
  std::byte* record_ = nullptr;  ///< of this scan, when it is open
  std::size_t used_ = 0;
  State state_ = State::kClosed;
  std::uint32_t moment_ = 0;
  std::uint32_t slice_ = 0;
  std::uint32_t lost_ = 0;  ///< since the last record that says so
  std::uint64_t scan_ = 0;
  std::atomic<std::uint64_t> lost_in_all_{0}, scans_in_all_{0}, bytes_in_all_{0};
  TableMemory checkpoint_;
  std::atomic<Asked> asked_{Asked::kNo};
};

}  // namespace plc::runtime
