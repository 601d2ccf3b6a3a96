#include "native/change_tracker.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

#include "runtime/operations.h"
#include "stdlib/blocks/timers.h"

namespace plc::native {
namespace {

constexpr std::size_t kLine = 64;
/// Steps that a record costs which runs and marks four others, and each other mark; its straight code is one.
constexpr std::uint32_t kRecordEffort = 24;
constexpr std::uint32_t kMarkEffort = 4;

/// Limit that one more step does not wrap.
constexpr std::uint64_t kMostEffort = 1u << 30;

[[gnu::always_inline]] inline std::byte value_of(const std::byte* table, const ChangeTables::Group& group) noexcept {
  const auto input = [&](std::size_t i) { return static_cast<std::uint32_t>(table[group.in[i]]); };
  const std::uint32_t row = input(0) + 2 * input(1) + 4 * (input(2) + 2 * input(3)) + 16 * input(4);
  return static_cast<std::byte>(group.truth >> (row & 31u) & 1u);
}

/// The first line from `line` on, of `count`, in which a and b differ; count when there is none.
// RT:
std::uint32_t first_difference(const std::byte* a, const std::byte* b, std::uint32_t line,
                               std::uint32_t count) noexcept {
  while (line < count && std::memcmp(a + line * kLine, b + line * kLine, kLine) == 0) ++line;
  return line;
}
#if defined(__x86_64__)
// The same, four times as fast.
// RT:
[[gnu::target("avx2")]] std::uint32_t first_difference_avx2(const std::byte* a, const std::byte* b, std::uint32_t line,
                                                            std::uint32_t count) noexcept {
  for (; line < count; ++line) {
    const auto* const x = reinterpret_cast<const __m256i*>(a + line * kLine);
    const auto* const y = reinterpret_cast<const __m256i*>(b + line * kLine);
    const __m256i low = _mm256_xor_si256(_mm256_loadu_si256(x), _mm256_loadu_si256(y));
    const __m256i high = _mm256_xor_si256(_mm256_loadu_si256(x + 1), _mm256_loadu_si256(y + 1));
    const __m256i any = _mm256_or_si256(low, high);
    if (_mm256_testz_si256(any, any) == 0) break;
  }
  return line;
}
#endif

}  // namespace

ChangeTracker::ChangeTracker(std::byte* table, std::size_t bytes, ChangeTables tables_in, std::uint32_t patience)
    : tables(std::move(tables_in)),
      table_(table),
      shadow_((bytes + kLine - 1) / kLine * kLine),
      dirty_(tables.used.size() + 1),
      dirty_chunks_(tables.used.size() / 64 + 1),
      executed_(tables.stretches.size()),
      limit_(static_cast<std::uint32_t>(std::min<std::uint64_t>(std::uint64_t{tables.effort} * patience / 100, kMostEffort))),
      first_difference_(first_difference) {
  counts_.groups = tables.count;
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") != 0) first_difference_ = first_difference_avx2;
#endif
}

/// What marking works on: copies, since bytes may be anything to the compiler, which would read members again behind
/// each of them.
struct ChangeTracker::Marker {
  std::byte* table;
  std::byte* shadow;
  const ChangeTables::Group* groups;
  std::uint64_t* dirty;
  std::uint64_t* dirty_chunks;

  /// Something that a record reads or writes changed. It is dirty if its output is not what its inputs say: seen at once
  /// and without a branch, so that only those run that change something. What is found clean may stay marked. Returns 1
  /// when it is dirty.
  [[gnu::always_inline]] std::uint64_t look_at(std::uint32_t number) const noexcept {
    const ChangeTables::Group& group = groups[number];
    const std::uint64_t is = table[group.out] != value_of(table, group) ? 1 : 0;
    dirty[number / kChunkGroups] |= is << number % kChunkGroups;
    return is;
  }
  /// That its chunk is dirty, too.
  [[gnu::always_inline]] void note_chunk(std::uint32_t number, std::uint64_t is) const noexcept {
    const std::uint32_t chunk = number / kChunkGroups;
    dirty_chunks[chunk / 64] |= is << chunk % 64;
  }
  /// Something that any group reads or writes changed.
  [[gnu::always_inline]] void mark(std::uint32_t number) const noexcept {
    const std::uint64_t code = groups[number].code != ChangeTables::kNoCode ? 1 : 0;
    dirty[number / kChunkGroups] |= code << number % kChunkGroups;
    note_chunk(number, look_at(number) | code);
  }
};
// RT:
inline ChangeTracker::Marker ChangeTracker::marker() noexcept {
  return {table_, shadow_.data(), tables.groups.data(), dirty_.data(), dirty_chunks_.data()};
}

/// The group runs, whatever is known of it.
// RT:
void ChangeTracker::insist_on(std::uint32_t number) noexcept {
  const std::uint32_t chunk = number / kChunkGroups;
  dirty_[chunk] |= std::uint64_t{1} << number % kChunkGroups;
  dirty_chunks_[chunk / 64] |= std::uint64_t{1} << chunk % 64;
}

// RT:
void ChangeTracker::begin() noexcept {
  if (phase_ == Phase::kWhole && whole_left_-- == 0) phase_ = Phase::kSettling;
  flags.whole = phase_ == Phase::kWhole ? 1 : 0;
  flags.settling = 0;
  flags.look = 1;
  effort_ = 0;
  runs_ = 0;
}

// RT:
void ChangeTracker::end(const runtime::Machine& machine, bool fine) noexcept {
  const auto add = [](std::atomic<std::uint64_t>& count, std::uint64_t more) {
    count.store(count.load(std::memory_order_relaxed) + more, std::memory_order_relaxed);
  };
  add(counts_.scans, 1);
  if (phase_ != Phase::kTracking || flags.whole != 0) add(counts_.whole_scans, 1);
  add(counts_.runs, runs_);
  if (phase_ == Phase::kWhole) return;
  if (phase_ == Phase::kSettling) {
    if (!fine || flags.settling == 0) return;  // the next scan tries again
    look();
    if (!exhausted()) mark_unsettled(machine);
    phase_ = Phase::kTracking;
  }
  if (flags.whole == 0 && !exhausted()) return;
  phase_ = Phase::kWhole;
  whole_left_ = kWholeScans;
}

/// Dirty groups in order: what one of them marks behind itself still runs, in front of itself in the next scan.
/// Returns the chunk to go on with: the end, or the one behind that in which the effort was spent.
// RT:
std::uint32_t ChangeTracker::run_chunks(runtime::Machine& machine, std::uint32_t first, std::uint32_t end) noexcept {
  const Marker mark_one = marker();
  std::byte* const table = mark_one.table;
  std::uint64_t* const dirty = mark_one.dirty;
  std::uint64_t* const dirty_chunks = mark_one.dirty_chunks;
  // What is dirty is kept in registers: the next group is known without waiting for what the last one wrote.
  std::uint32_t runs = 0;
  std::uint32_t most = (limit_ - effort_) / kRecordEffort;
  for (std::uint32_t word = first / 64; word * 64 < end; ++word) {
    std::uint64_t range = ~std::uint64_t{0};
    if (word == first / 64) range <<= first % 64;
    if (word == end / 64) range &= ~(~std::uint64_t{0} << end % 64);
    std::uint64_t chunks = dirty_chunks[word] & range;
    dirty_chunks[word] &= ~range;
    int next = std::countr_zero(chunks);
    while (next < 64) {
      const int chunk_bit = next;
      // Ahead of what runs now: what comes next is fetched meanwhile.
      chunks &= chunks - 1;
      next = std::countr_zero(chunks);
      const std::uint32_t chunk = word * 64 + static_cast<std::uint32_t>(chunk_bit);
      std::uint64_t bits = dirty[chunk];
      dirty[chunk] = 0;
      while (bits != 0) {
        const auto bit = static_cast<unsigned>(std::countr_zero(bits));
        bits &= bits - 1;
        ++runs;
        const ChangeTables::Group& group = mark_one.groups[std::size_t{chunk} * kChunkGroups + bit];
        if (group.code == ChangeTables::kNoCode) [[likely]] {
          const std::byte value = value_of(table, group);
          if (table[group.out] == value) continue;
          table[group.out] = value;
          mark_one.shadow[group.out] = value;
          std::uint64_t is[ChangeTables::kNear];
          std::uint64_t any = 0;
          for (std::size_t i = 0; i < ChangeTables::kNear; ++i) any |= is[i] = mark_one.look_at(group.near[i]);
          if (group.rest != group.rest_end) {
            mark(group.rest, group.rest_end);
            most = exhausted() ? 0 : (limit_ - effort_) / kRecordEffort;
            any = 1;
          }
          if (any == 0) continue;
          for (std::size_t i = 0; i < ChangeTables::kNear; ++i) mark_one.note_chunk(group.near[i], is[i]);
        } else {
          run_code(machine, tables.codes[group.code]);
          most = exhausted() ? 0 : (limit_ - effort_) / kRecordEffort;
        }
        // What is marked now. Once marks are incomplete, all that is left of the chunk runs.
        const std::uint64_t behind = ~std::uint64_t{1} << bit;
        bits |= (most == 0 ? tables.used[chunk] : dirty[chunk]) & behind;
        dirty[chunk] &= ~behind;
        const std::uint64_t others = dirty_chunks[word] & range & ~std::uint64_t{1} << chunk_bit;
        if (others == 0) continue;
        dirty_chunks[word] &= ~others;
        chunks |= others;
        if (std::countr_zero(others) < next) [[unlikely]]
          next = std::countr_zero(others);
      }
      if (runs > most) [[unlikely]] {
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

// RT:
const std::byte* ChangeTracker::run(runtime::Machine& machine, std::uint32_t number) noexcept {
  const ChangeTables::Stretch& stretch = tables.stretches[number];
  if (phase_ == Phase::kSettling) {
    if (flags.settling == 0) {
      snapshot();
      events_ = machine.event_count;
      flags.settling = 1;
      flags.look = 0;
    } else if (flags.look != 0) {
      look();
    }
    executed_[number] = 1;
    return tables.entries[stretch.first];
  }
  if (flags.look != 0) look();
  const std::uint32_t end = stretch.first + stretch.chunks;
  const std::uint32_t next = exhausted() ? stretch.first : run_chunks(machine, stretch.first, end);
  // Not all that is dirty is marked any more.
  if (exhausted()) [[unlikely]]
    flags.whole = 1;
  return next < end ? tables.entries[next] : stretch.exit;
}

// RT:
void ChangeTracker::run_code(runtime::Machine& machine, const ChangeTables::Code& code) noexcept {
  spend(code.effort);
  const std::uint64_t events = machine.event_count;
  reinterpret_cast<void (*)(runtime::Machine&) noexcept>(reinterpret_cast<std::uintptr_t>(code.entry))(machine);
  for (std::uint32_t i = 0; i < code.spans.count; ++i) settle(tables.spans[code.spans.first + i], false);
  // Events are counted in every scan, and running timers follow the time.
  if (machine.event_count != events || is_timing(code)) insist_on(code.group);
}

// RT:
bool ChangeTracker::is_timing(const ChangeTables::Code& code) const noexcept {
  for (std::uint32_t i = 0; i < code.timers.count; ++i) {
    if (table_[tables.timers[code.timers.first + i]] == std::byte{stdlib::fb::TimerPorts::kRunning}) return true;
  }
  return false;
}

// RT:
void ChangeTracker::settle(const ChangeTables::Span& span, bool outside) noexcept {
  const std::byte* const now = table_ + span.offset;
  std::byte* const before = shadow_.data() + span.offset;
  if (std::memcmp(now, before, span.bytes) == 0) return;
  std::memcpy(before, now, span.bytes);
  const ChangeTables::Cell& cell = tables.cells[span.cell];
  mark(outside ? cell.begin : cell.others, cell.end);
}

// RT:
void ChangeTracker::settle_outside(std::uint32_t list) noexcept {
  const ChangeTables::List spans = tables.outside[list];
  for (std::uint32_t i = 0; i < spans.count; ++i) settle(tables.spans[spans.first + i], true);
}

// RT:
void ChangeTracker::mark(std::uint32_t begin, std::uint32_t end) noexcept {
  spend(kMarkEffort * (end - begin));
  if (exhausted()) [[unlikely]]
    return;
  const Marker mark_one = marker();
  for (const std::uint32_t *at = tables.marks.data() + begin, *last = tables.marks.data() + end; at != last; ++at) {
    mark_one.mark(*at);
  }
}

// RT:
void ChangeTracker::look() noexcept {
  flags.look = 0;
  for (const ChangeTables::Lines& lines : tables.lines) {
    const std::byte* const now = table_ + lines.offset;
    const std::byte* const before = shadow_.data() + lines.offset;
    std::uint32_t line = first_difference_(now, before, 0, lines.count);
    while (line < lines.count) {
      take_over(lines, line);
      line = first_difference_(now, before, line + 1, lines.count);
    }
  }
}

/// Marks who reads or writes what changed in a line.
// RT:
void ChangeTracker::take_over(const ChangeTables::Lines& lines, std::uint32_t line) noexcept {
  const std::size_t offset = lines.offset + line * kLine;
  const std::uint32_t* const cells = tables.cell_of_byte.data() + lines.cells + line * kLine;
  std::byte* const before = shadow_.data() + offset;
  std::uint32_t last = 0;
  for (std::size_t word = 0; word < kLine; word += sizeof(std::uint64_t)) {
    auto differ = runtime::load<std::uint64_t>(table_ + offset + word) ^ runtime::load<std::uint64_t>(before + word);
    while (differ != 0) {
      const auto byte = static_cast<unsigned>(std::countr_zero(differ)) / 8;
      differ &= ~(std::uint64_t{0xff} << byte * 8);
      const std::uint32_t cell = cells[word + byte];
      if (cell != last) mark(tables.cells[cell].begin, tables.cells[cell].end);
      last = cell;
    }
  }
  std::memcpy(before, table_ + offset, kLine);
}

// RT:
void ChangeTracker::snapshot() noexcept {
  for (const ChangeTables::Lines& lines : tables.lines) {
    std::memcpy(shadow_.data() + lines.offset, table_ + lines.offset, lines.count * kLine);
  }
  std::fill(dirty_.begin(), dirty_.end(), 0);
  std::fill(dirty_chunks_.begin(), dirty_chunks_.end(), 0);
  std::fill(executed_.begin(), executed_.end(), 0);
}

/// After a scan of plain code, beside groups whose bytes changed in it.
// RT:
void ChangeTracker::mark_unsettled(const runtime::Machine& machine) noexcept {
  // What several write may have changed and changed back.
  const Marker mark_one = marker();
  for (const std::uint32_t group : tables.contested) mark_one.mark(group);
  for (std::size_t s = 0; s < executed_.size(); ++s) {
    const ChangeTables::Stretch& stretch = tables.stretches[s];
    for (std::uint32_t c = 0; c < stretch.chunks && executed_[s] == 0; ++c) {
      const std::uint32_t chunk = stretch.first + c;
      dirty_[chunk] = tables.used[chunk];
      dirty_chunks_[chunk / 64] |= std::uint64_t{1} << chunk % 64;
    }
  }
  for (const ChangeTables::Code& code : tables.codes) {
    if ((code.raises && machine.event_count != events_) || is_timing(code)) insist_on(code.group);
  }
}

}  // namespace plc::native
