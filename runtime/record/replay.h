// Replay: the same questions as those that a Recorder noted, answered from a record; and the exchange of a task that is
// executed from records.
//
// In: one record after the other. Out: the bytes that others wrote, the answers of queues, the outputs of taskblocks.
// A record that does not fit the questions (of another program, or damaged) gives zeros and says so: nothing is read or
// written outside of it and the table. Threads: one. Does not belong here: the execution (Program::link_replica()).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "runtime/memory/exchange.h"
#include "runtime/record/record.h"
#include "runtime/record/table_types.h"

namespace plc::runtime {

class Replay {
 public:
  /// `table`: that of the replica, without scratch. `types`: what may be there, for records that nobody vouches for.
  void set_table(std::span<std::byte> table, const TableTypes* types = nullptr) noexcept {
    table_ = table;
    types_ = types;
  }
  /// Another table, as it was before the scan that comes next; of the same size. False when it has what no table of
  /// this program has, which is mended.
  bool load(std::span<const std::byte> table) noexcept;

  /// The record of the scan that is executed next. Lives until finished() was asked.
  void begin(std::span<const std::byte> record) noexcept;
  [[nodiscard]] const RecordHead& head() const noexcept { return head_; }

  /// Puts into the table what was there before the first instruction.
  void start() noexcept;
  /// Puts into the table what the next import of the scan brought.
  void import() noexcept;
  /// Puts into the table what was forced before the next export of the scan.
  void export_range() noexcept;
  /// Puts into the table what was forced after the last instruction.
  void end() noexcept { apply(EntryKind::kForced, kForcedAtEnd); }
  /// Whether a queue took the element, or gave one, which is then copied to `element`, `bytes` long. Null: none is
  /// wanted.
  bool queue(void* element, std::size_t bytes) noexcept;
  [[nodiscard]] std::uint32_t number() noexcept;
  /// The status of the taskblock that ran; its outputs get their values.
  std::uint32_t taskblock(std::uint32_t object, std::span<const PortBytes> outputs) noexcept;
  /// How the scan ended.
  [[nodiscard]] RecordedFault fault() noexcept;

  /// Every question found its answer, and every answer its question.
  [[nodiscard]] bool finished() const noexcept { return fits_ && at_ == record_.size(); }

 private:
  /// The entry that comes next, when it is of this kind, and its payload.
  bool take(EntryKind kind, EntryHead& head, std::span<const std::byte>& payload) noexcept;
  [[nodiscard]] bool next_is(EntryKind kind, EntryHead& head) const noexcept;
  void apply() noexcept;
  void apply(EntryKind kind, std::uint32_t detail) noexcept;
  /// Puts bytes into the table, which `to` is in. RT.
  void put(std::byte* to, std::span<const std::byte> bytes) noexcept;

  std::span<std::byte> table_;
  const TableTypes* types_ = nullptr;
  std::span<const std::byte> record_;
  RecordHead head_;
  std::size_t at_ = 0;
  std::uint32_t moment_ = 0;
  std::uint32_t exports_ = 0;
  bool fits_ = true;
};

/// The exchange of a replica: what it imports is in the record, and nobody sees what it exports.
class ReplayExchange final : public Exchange {
 public:
  explicit ReplayExchange(Replay& replay) : replay_(replay) {}

  std::uint32_t add_range(std::uint32_t, std::uint32_t, Use) override { return ranges_++; }
  void prepare() override {}
  void reset() override {}
  void expect(std::size_t) noexcept override {}
  void begin() noexcept override { replay_.start(); }
  void import(std::uint32_t) noexcept override { replay_.import(); }
  void export_range(std::uint32_t) noexcept override { replay_.export_range(); }
  bool end() noexcept override {
    replay_.end();
    return (replay_.head().flags & kRevoked) == 0;
  }
  [[nodiscard]] bool read_bool(std::uint32_t) noexcept override { return false; }
  bool revoke() noexcept override { return false; }
  void publish_safe(std::span<const GlobalWrite>) noexcept override {}

 private:
  Replay& replay_;
  std::uint32_t ranges_ = 0;
};

}  // namespace plc::runtime
