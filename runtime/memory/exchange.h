// Exchange: one task's part in the exchange of globals at the ends of its cycle, whatever the protocol (paper, 3.2.2
// and 3.2.3; docs/guides/coherence.md).
//
// In: field ranges of the global table as READ_N, WRITE_N, WRITE_CHANGED_N and RAISE_PRIORITY name them. Out: the
// task's local copy of the table, in which all that one owner publishes is of one time, and what the task exports made
// visible as a whole. Interpreter and engines know this interface only:
//
//   wait_free_exchange.h  a snapshot per owner; nobody waits                       --coherence=wait-free
//   lock_exchange.h       one table, one lock around every copy (Chimera)          --coherence=global-lock
//   ceiling_exchange.h    one table, copies at raised priority, group by group     --coherence=priority-ceiling
//
// Threads: all calls on the task's thread, but for revoke() and publish_safe() (see there).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "core/options.h"
#include "runtime/memory/global_table.h"

namespace plc::runtime {

class Recorder;

/// Gives the calling thread the priority of IEC priority `priority` (0 is the most urgent). RT: one system call.
using SetPriority = void (*)(std::int32_t priority) noexcept;

class Exchange {
 public:
  virtual ~Exchange() = default;

  /// Makes a range of `count` fields from `first` on known, to import, to export, or to raise the priority for; returns
  /// its number. Set-up.
  enum class Use : std::uint8_t { kImport, kExport, kRaise };
  virtual std::uint32_t add_range(std::uint32_t first, std::uint32_t count, Use use) = 0;
  /// Works out again who owns what; the table calls it. Set-up.
  virtual void prepare() = 0;
  /// Forgets what was imported, as after a cold start; the task may publish again. Set-up.
  virtual void reset() = 0;
  /// How raise() and reschedule() change the priority of the task's thread; null (as at first) = they do not. Set-up.
  virtual void set_priority_change(SetPriority /*set*/) {}
  /// Who is told what comes into the local copy (record/recorder.h); null (as at first) = nobody. Between cycles.
  virtual void set_recorder(Recorder* /*recorder*/) {}

  /// Shortly before begin(): does ahead what can be done twice, so that begin() and import() find it in the caches:
  /// code, tables, and what others publish. No result changes. Between cycles; copies ranges to import only as
  /// long as they read at most `bytes` in all. RT.
  virtual void expect(std::size_t bytes) noexcept = 0;
  /// Start of a cycle: applies the journal, takes what others publish without a protocol. RT.
  virtual void begin() noexcept = 0;
  /// RT.
  virtual void import(std::uint32_t range) noexcept = 0;
  /// Shared values only where they differ from what was imported. Nothing happens once the task is revoked. RT.
  virtual void export_range(std::uint32_t range) noexcept = 0;
  /// End of a cycle: all that was exported is visible, nothing is held any more. False: the task was revoked, nothing
  /// of this cycle became visible. RT.
  virtual bool end() noexcept = 0;
  /// RAISE_PRIORITY, RESCHEDULE, LOCK, UNLOCK: bounds of a critical section, for the protocols that have any. RT.
  virtual void raise(std::uint32_t /*range*/) noexcept {}
  virtual void reschedule() noexcept {}
  virtual void lock() noexcept {}
  virtual void unlock() noexcept {}

  /// The BOOL at `offset` as published now; between cycles. RT.
  [[nodiscard]] virtual bool read_bool(std::uint32_t offset) noexcept = 0;

  /// Takes the right to publish from a task that computes, for good: its present cycle will have no effect. False while
  /// it does not compute: between cycles, or exporting already. Any thread; wait-free.
  virtual bool revoke() noexcept = 0;
  /// Publishes these values of fields that the task exports, all else as published last. By the task's thread between
  /// cycles, or by the thread that revoked it. RT.
  virtual void publish_safe(std::span<const GlobalWrite> values) noexcept = 0;
};

/// `local` is the start of the task's table; its first bytes are the copy of the global table.
std::unique_ptr<Exchange> make_exchange(core::Coherence coherence, GlobalTable& globals, std::uint32_t task,
                                        std::byte* local);

}  // namespace plc::runtime
