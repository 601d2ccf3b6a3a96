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
/// Steps that finding and evaluating one record costs, where its straight code costs one.
constexpr std::uint32_t kRecordEffort = 8;

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

ChangeTracker::ChangeTracker(std::byte* table, std::size_t bytes, ChangeTables tables_in)
    : tables(std::move(tables_in)),
      table_(table),
      shadow_((bytes + kLine - 1) / kLine * kLine),
      dirty_(tables.used.size()),
      executed_(tables.stretches.size()),
      limit_(tables.effort / 2),
      first_difference_(first_difference) {
  counts_.groups = tables.count;
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") != 0) first_difference_ = first_difference_avx2;
#endif
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
  for (std::uint32_t chunk = stretch.first; chunk < end; ++chunk) {
    if (exhausted()) [[unlikely]] {
      flags.whole = 1;
      return tables.entries[chunk];
    }
    if (dirty_[chunk] != 0) run_chunk(machine, chunk);
  }
  return stretch.exit;
}

// RT:
void ChangeTracker::run_chunk(runtime::Machine& machine, std::uint32_t chunk) noexcept {
  // In order: what a group marks in front of itself is for the next scan.
  std::uint64_t behind = ~std::uint64_t{0};
  for (;;) {
    // Marks are incomplete once the effort is spent: all that is left of the chunk runs then.
    const std::uint64_t bits = (exhausted() ? tables.used[chunk] : dirty_[chunk]) & behind;
    if (bits == 0) return;
    const auto bit = static_cast<unsigned>(std::countr_zero(bits));
    behind = (~std::uint64_t{0} << bit) << 1;
    dirty_[chunk] &= ~(std::uint64_t{1} << bit);
    ++runs_;
    const std::uint32_t number = chunk * kChunkGroups + bit;
    const ChangeTables::Group& group = tables.groups[number];
    if (group.out == ChangeTables::kCode) {
      run_code(machine, tables.codes[group.truth]);
      continue;
    }
    spend(kRecordEffort);
    const auto input = [&](std::size_t i) { return static_cast<std::uint32_t>(table_[group.in[i]]); };
    const std::uint32_t row = input(0) + 2 * input(1) + 4 * (input(2) + 2 * input(3)) + 16 * input(4);
    const auto value = static_cast<std::byte>(group.truth >> (row & 31u) & 1u);
    if (table_[group.out] == value) continue;
    table_[group.out] = value;
    shadow_.data()[group.out] = value;
    const ChangeTables::Cell& cell = tables.cells[group.cell];
    mark(cell.others, cell.end);
  }
}

// RT:
void ChangeTracker::run_code(runtime::Machine& machine, const ChangeTables::Code& code) noexcept {
  spend(code.effort);
  const std::uint64_t events = machine.event_count;
  reinterpret_cast<void (*)(runtime::Machine&) noexcept>(reinterpret_cast<std::uintptr_t>(code.entry))(machine);
  for (std::uint32_t i = 0; i < code.spans.count; ++i) settle(tables.spans[code.spans.first + i], false);
  // Events are counted in every scan, and running timers follow the time.
  if (machine.event_count != events || is_timing(code)) mark_group(code.group);
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
  spend(end - begin);
  if (exhausted()) [[unlikely]]
    return;
  for (std::uint32_t i = begin; i < end; ++i) mark_group(tables.marks[i]);
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
  for (std::size_t i = 0; i < kLine; ++i) {
    if (table_[offset + i] == before[i] || cells[i] == last) continue;
    last = cells[i];
    mark(tables.cells[last].begin, tables.cells[last].end);
  }
  std::memcpy(before, table_ + offset, kLine);
}

// RT:
void ChangeTracker::snapshot() noexcept {
  for (const ChangeTables::Lines& lines : tables.lines) {
    std::memcpy(shadow_.data() + lines.offset, table_ + lines.offset, lines.count * kLine);
  }
  std::fill(dirty_.begin(), dirty_.end(), 0);
  std::fill(executed_.begin(), executed_.end(), 0);
}

/// After a scan of plain code, beside groups whose bytes changed in it.
// RT:
void ChangeTracker::mark_unsettled(const runtime::Machine& machine) noexcept {
  // What several write may have changed and changed back.
  for (const std::uint32_t group : tables.contested) mark_group(group);
  for (std::size_t s = 0; s < executed_.size(); ++s) {
    const ChangeTables::Stretch& stretch = tables.stretches[s];
    for (std::uint32_t c = 0; c < stretch.chunks && executed_[s] == 0; ++c) {
      dirty_[stretch.first + c] = tables.used[stretch.first + c];
    }
  }
  for (const ChangeTables::Code& code : tables.codes) {
    if ((code.raises && machine.event_count != events_) || is_timing(code)) mark_group(code.group);
  }
}

}  // namespace plc::native
