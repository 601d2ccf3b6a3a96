#include "native/change_tracker.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "stdlib/blocks/timers.h"

namespace plc::native {
namespace {

/// Steps that a record costs which runs and marks six others, and each other mark; its straight code is one.
constexpr std::uint32_t kRecordEffort = 16;
constexpr std::uint32_t kMarkEffort = 3;

constexpr std::uint32_t kMarkOf = ChangeTables::kOutput * 2;

// RT:
void run(const ChangeTables::Code& code, runtime::Machine& machine) noexcept {
  reinterpret_cast<void (*)(runtime::Machine&) noexcept>(reinterpret_cast<std::uintptr_t>(code.entry))(machine);
}

/// Limit that one more step does not wrap.
constexpr std::uint64_t kMostEffort = 1u << 30;

}  // namespace

ChangeTracker::ChangeTracker(std::span<std::byte> table, ChangeTables tables_in, std::uint32_t patience, bool baseline)
    : tables(std::move(tables_in)),
      table_(table.data()),
      copy_(table, std::move(tables.areas), baseline),
      dirty_(tables.used.size() + 1),
      dirty_chunks_(tables.used.size() / 64 + 1),
      executed_(tables.stretches.size()),
      limit_(static_cast<std::uint32_t>(
          std::min<std::uint64_t>(std::uint64_t{tables.effort} * patience / 100, kMostEffort))) {
  counts_.groups = tables.count;
  for (std::uint32_t number = 0; number + 1 < tables.groups.size(); ++number) {
    ChangeTables::State& state = tables.states[number];
    const runtime::GeneralRecord& record = tables.records[number];
    for (std::uint32_t k = 0; k < std::size(record.in); ++k) {
      const bool constant = record.in[k] >= tables.constants && record.in[k] < tables.constants_end;
      if (constant) state.row |= (static_cast<std::uint32_t>(table[record.in[k]]) & 1u) << k;
    }
    if ((state.truth >> state.row & 1u) != 0) insist_on(number);
  }
}

/// What marking works on: copies, since bytes may be anything to the compiler, which would read members again behind
/// each of them.
struct ChangeTracker::Marker {
  ChangeTables::State* states;
  std::uint64_t* dirty;
  std::uint64_t* dirty_chunks;
  const ChangeTables::Group* groups;

  /// A byte changed that is input `mark` says of a record. The record is dirty if its output is not what its inputs
  /// say: seen at once, so that only those run that change something. What becomes clean may stay marked.
  [[gnu::always_inline]] void input(std::uint32_t mark) const noexcept {
    const std::uint32_t number = mark / kMarkOf;
    ChangeTables::State& state = states[number];
    state.row ^= mark % kMarkOf;
    if ((state.truth >> state.row & 1u) != 0) set(number);
  }
  /// The same for any mark. `toggled`: 1 when a BOOL changed, 0 when it cannot have been one. Without a jump that
  /// depends on whether it is dirty: these come many at a time, and nobody could guess it.
  [[gnu::always_inline]] void any(std::uint32_t mark, std::uint32_t toggled) const noexcept {
    const std::uint32_t number = mark / kMarkOf;
    const std::uint32_t what = mark % kMarkOf * toggled;
    ChangeTables::State& state = states[number];
    state.truth ^= (what & ChangeTables::kOutput) != 0 ? ~0u : 0u;
    state.row ^= what & ChangeTables::kInputs;
    set_if((state.truth >> state.row & 1u) | std::uint32_t{mark % kMarkOf == 0}, number);
  }
  /// The group is dirty.
  [[gnu::always_inline]] void set(std::uint32_t number) const noexcept {
    __builtin_prefetch(groups + number);  // it runs soon, and there are more than near caches hold
    set_if(1, number);
  }
  /// The group is dirty if is_dirty is 1, and as it was if 0.
  [[gnu::always_inline]] void set_if(std::uint64_t is_dirty, std::uint32_t number) const noexcept {
    const std::uint32_t chunk = number / kChunkGroups;
    dirty[chunk] |= is_dirty << number % kChunkGroups;
    dirty_chunks[chunk / 64] |= is_dirty << chunk % 64;
  }
};
// RT:
inline ChangeTracker::Marker ChangeTracker::marker() noexcept {
  return {tables.states.data(), dirty_.data(), dirty_chunks_.data(), tables.groups.data()};
}

/// The group runs, whatever is known of it.
// RT:
void ChangeTracker::insist_on(std::uint32_t number) noexcept { marker().set(number); }

// RT:
void ChangeTracker::begin() noexcept {
  if (phase_ == Phase::kWhole && whole_left_-- == 0) phase_ = Phase::kSettling;
  whole_ = phase_ == Phase::kWhole ? 1 : 0;
  settling_ = false;
  look_ = true;
  effort_ = 0;
  runs_ = 0;
}

// RT:
void ChangeTracker::end(const runtime::Machine& machine, bool fine) noexcept {
  const auto add = [](std::atomic<std::uint64_t>& count, std::uint64_t more) {
    count.store(count.load(std::memory_order_relaxed) + more, std::memory_order_relaxed);
  };
  add(counts_.scans, 1);
  if (phase_ != Phase::kTracking || whole_ != 0) add(counts_.whole_scans, 1);
  add(counts_.runs, runs_);
  if (phase_ == Phase::kWhole) return;
  if (phase_ == Phase::kSettling) {
    if (!fine || !settling_) return;  // the next scan tries again
    look();
    if (!exhausted()) mark_unsettled(machine);
    phase_ = Phase::kTracking;
  }
  if (whole_ == 0 && !exhausted()) return;
  phase_ = Phase::kWhole;
  whole_left_ = kWholeScans;
}

/// Dirty groups in order: what one of them marks behind itself still runs, in front of itself in the next scan.
/// Returns the chunk to go on with: the end, or the one behind that in which the effort was spent.
// RT:
std::uint32_t ChangeTracker::run_chunks(runtime::Machine& machine, std::uint32_t first, std::uint32_t end) noexcept {
  const Marker marks = marker();
  const ChangeTables::Group* const all = tables.groups.data();
  std::byte* const table = table_;
  const TableCopy::Writer copy = copy_.writer();
  std::uint32_t runs = 0;
  std::uint32_t most = (limit_ - effort_) / kRecordEffort;
  for (std::uint32_t word = first / 64; word * 64 < end; ++word) {
    std::uint64_t range = ~std::uint64_t{0};
    if (word == first / 64) range <<= first % 64;
    if (word == end / 64) range &= ~(~std::uint64_t{0} << end % 64);
    // What is dirty is kept in registers: the next group is known without waiting for what this one marks.
    std::uint64_t chunks = marks.dirty_chunks[word] & range;
    marks.dirty_chunks[word] &= ~range;
    int next = std::countr_zero(chunks);
    while (next < 64) {
      const int chunk_bit = next;
      chunks &= chunks - 1;
      next = std::countr_zero(chunks);
      const std::uint32_t chunk = word * 64 + static_cast<std::uint32_t>(chunk_bit);
      const ChangeTables::Group* const groups = all + std::size_t{chunk} * kChunkGroups;
      ChangeTables::State* const states = marks.states + std::size_t{chunk} * kChunkGroups;
      std::uint64_t& dirty = marks.dirty[chunk];
      std::uint64_t bits = dirty;
      dirty = 0;
      while (bits != 0) {
        const auto bit = static_cast<unsigned>(std::countr_zero(bits));
        bits &= bits - 1;
        const ChangeTables::Group& group = groups[bit];
        ChangeTables::State& state = states[bit];
        if (group.out != ChangeTables::kCode) [[likely]] {
          if ((state.truth >> state.row & 1u) == 0) continue;
          ++runs;
          const std::uint32_t more = group.more;
          state.truth = ~state.truth;
          if (more == 0 || mark(more + 1, more + 1 + tables.marks[more], 1)) [[likely]] {
            const std::byte value = table[group.out] ^ std::byte{1};
            table[group.out] = value;
            copy.set(group.out, value);
#pragma GCC unroll 6
            for (const std::uint32_t near : group.near) marks.input(near);
          } else {
            state.truth = ~state.truth;
            bits |= std::uint64_t{1} << bit;
          }
        } else {
          ++runs;
          run_code(machine, tables.codes[group.more]);
        }
        const std::uint64_t behind = ~std::uint64_t{1} << bit;
        if (exhausted()) [[unlikely]] {
          // For later: what is known to be dirty. For now: all that is left.
          dirty |= bits;
          marks.dirty_chunks[word] |= chunks | std::uint64_t{1} << chunk_bit;
          const std::uint64_t again = bits & std::uint64_t{1} << bit;
          finish_chunk(machine, chunk, tables.used[chunk] & (behind | again));
          runs_ += runs;
          return chunk + 1;
        }
        // What was marked meanwhile.
        bits |= dirty & behind;
        dirty &= ~behind;
        const std::uint64_t others = marks.dirty_chunks[word] & range & ~std::uint64_t{1} << chunk_bit;
        if (others == 0) continue;
        marks.dirty_chunks[word] &= ~others;
        chunks |= others;
        if (std::countr_zero(others) < next) [[unlikely]]
          next = std::countr_zero(others);
      }
      if (runs > most) [[unlikely]] {
        marks.dirty_chunks[word] |= chunks;
        runs_ += runs;
        effort_ = limit_ + 1;
        return chunk + 1;
      }
    }
  }
  runs_ += runs;
  spend(runs * kRecordEffort);
  return end;
}

/// Groups of a chunk, whether dirty or not, and without a look at what they change.
// RT:
void ChangeTracker::finish_chunk(runtime::Machine& machine, std::uint32_t chunk, std::uint64_t groups) noexcept {
  for (; groups != 0; groups &= groups - 1) {
    const std::uint32_t number = chunk * kChunkGroups + static_cast<unsigned>(std::countr_zero(groups));
    const ChangeTables::Group& group = tables.groups[number];
    if (group.out == ChangeTables::kCode) {
      native::run(tables.codes[group.more], machine);
      continue;
    }
    const runtime::GeneralRecord& record = tables.records[number];
    const auto input = [&](std::size_t i) { return static_cast<std::uint32_t>(table_[record.in[i]]); };
    const std::uint32_t row = input(0) + 2 * input(1) + 4 * (input(2) + 2 * input(3)) + 16 * input(4);
    table_[record.out] = static_cast<std::byte>(record.truth >> (row & 31u) & 1u);
  }
}

// RT:
const std::byte* ChangeTracker::run(runtime::Machine& machine, std::uint32_t number) noexcept {
  const ChangeTables::Stretch& stretch = tables.stretches[number];
  if (phase_ == Phase::kSettling) {
    if (!settling_) {
      std::fill(executed_.begin(), executed_.end(), 0);
      events_ = machine.event_count;
      settling_ = true;
    }
    if (look_) look();
    if (exhausted()) whole_ = 1;
    executed_[number] = 1;
    return tables.entries[stretch.first];
  }
  if (look_) look();
  const std::uint32_t end = stretch.first + stretch.chunks;
  const std::uint32_t next = exhausted() ? stretch.first : run_chunks(machine, stretch.first, end);
  // Not all that is dirty is marked any more.
  if (exhausted()) [[unlikely]]
    whole_ = 1;
  return next < end ? tables.entries[next] : stretch.exit;
}

// RT:
void ChangeTracker::run_code(runtime::Machine& machine, const ChangeTables::Code& code) noexcept {
  spend(code.effort);
  const std::uint64_t events = machine.event_count;
  native::run(code, machine);
  for (std::uint32_t i = 0; i < code.spans.count; ++i) settle(tables.spans[code.spans.first + i], false);
  // Events are counted in every scan, and running timers follow the time.
  if (machine.event_count != events || is_timing(code)) insist_on(code.group);
}

// RT:
bool ChangeTracker::is_timing(const ChangeTables::Code& code) const noexcept {
  if (code.is_restless) return true;
  for (std::uint32_t i = 0; i < code.timers.count; ++i) {
    if (table_[tables.timers[code.timers.first + i]] == std::byte{stdlib::fb::TimerPorts::kRunning}) return true;
  }
  return false;
}

// RT:
void ChangeTracker::settle(const ChangeTables::Span& span, bool outside) noexcept {
  if (!copy_.differs(span.offset, span.bytes)) return;
  const ChangeTables::Cell& cell = tables.cells[span.cell];
  const std::uint32_t toggled = copy_.toggled(span.offset);
  if (mark(outside ? cell.begin : cell.others, cell.end, toggled)) copy_.take(span.offset, span.bytes);
}

// RT:
void ChangeTracker::settle_outside(std::uint32_t list) noexcept {
  const ChangeTables::List spans = tables.outside[list];
  for (std::uint32_t i = 0; i < spans.count; ++i) settle(tables.spans[spans.first + i], true);
}

/// False, and nobody was marked, when that would be too much effort.
// RT:
bool ChangeTracker::mark(std::uint32_t begin, std::uint32_t end, std::uint32_t toggled) noexcept {
  spend(kMarkEffort * (end - begin));
  if (exhausted()) [[unlikely]]
    return false;
  const Marker marks = marker();
  for (const std::uint32_t *at = tables.marks.data() + begin, *last = tables.marks.data() + end; at != last; ++at) {
    marks.any(*at, toggled);
  }
  return true;
}

// RT:
void ChangeTracker::expect_changes() noexcept {
  // What groups changed is seen by itself: else they might be thought to have left what comes now.
  if (settling_ && !look_) look();
  look_ = true;
}

/// Marks who reads or writes what changed.
// RT:
void ChangeTracker::look() noexcept {
  look_ = false;
  std::uint32_t last = 0;
  copy_.for_each_change([&](const TableCopy::Area& area, std::uint32_t distance, std::uint32_t toggled) noexcept {
    const std::uint32_t number = tables.cell_of_byte[area.cells + distance];
    // All of a cell is marked at its first byte.
    const ChangeTables::Cell& cell = tables.cells[number];
    if (number != last && !mark(cell.begin, cell.end, toggled)) return false;
    last = number;
    return true;
  });
}

/// After a scan of plain code, beside groups whose bytes changed in it.
// RT:
void ChangeTracker::mark_unsettled(const runtime::Machine& machine) noexcept {
  // What several write may have changed and changed back. Records are as their inputs and outputs are, whatever
  // happened.
  for (const std::uint32_t group : tables.contested) insist_on(group);
  for (std::size_t s = 0; s < executed_.size(); ++s) {
    const ChangeTables::Stretch& stretch = tables.stretches[s];
    for (std::uint32_t i = 0; i < stretch.codes.count && executed_[s] == 0; ++i) {
      insist_on(tables.codes[stretch.codes.first + i].group);
    }
  }
  for (const ChangeTables::Code& code : tables.codes) {
    if ((code.raises && machine.event_count != events_) || is_timing(code)) insist_on(code.group);
  }
}

}  // namespace plc::native
