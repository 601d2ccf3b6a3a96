#include "runtime/loop_run.h"

#include <algorithm>
#include <tuple>
#include <type_traits>
#include <utility>

#include "runtime/memory/table.h"
#include "runtime/operations.h"
#include "runtime/value_runs.h"

namespace plc::runtime {
namespace {

static_assert(kLoopChunk * sizeof(std::uint64_t) * kMostStreams <= kScratchBytes);

/// Fewer are not worth it.
constexpr std::uint32_t kLeastRounds = 4;

template <bool kDint>
std::int64_t load_control(const std::byte* from) noexcept {
  return load<std::conditional_t<kDint, std::int32_t, std::int16_t>>(from);
}
template <bool kDint>
void store_control(std::byte* to, std::int64_t value) noexcept {
  store(to, static_cast<std::conditional_t<kDint, std::int32_t, std::int16_t>>(value));
}
template <bool kDint>
bool fits(std::int64_t value) noexcept {
  return value == static_cast<std::conditional_t<kDint, std::int32_t, std::int16_t>>(value);
}
/// A variable that is part of an index.
std::int64_t load_part(const std::byte* from, bool wide) noexcept {
  return wide ? load_control<true>(from) : load_control<false>(from);
}

/// The control variable over the rounds to come.
struct Rounds {
  std::int64_t value = 0;
  std::int64_t step = 0;
  std::int64_t count = 0;
  bool all = true;  ///< the last one is the loop's last one, which takes no jump
};

/// The stream that a record, or a last value, names.
const Stream& stream_at(const Stream* streams, std::uint32_t place) noexcept {
  return *reinterpret_cast<const Stream*>(reinterpret_cast<const std::byte*>(streams) + place);
}

/// Sets what the last of `count` rounds leaves in variables; `last` is behind the records. RT.
template <Addressing kAddressing>
[[gnu::always_inline]] inline void finish(std::byte* table, std::uint32_t instance, const std::uint32_t* words,
                                          const std::uint32_t* last, const Stream* streams,
                                          std::uint32_t count) noexcept {
  for (std::uint32_t i = words[LoopWords::kLastValues]; i != 0; --i, last += kLastValueWords) {
    const Stream& from = stream_at(streams, last[1]);
    std::byte* const to = place<kAddressing>(table, instance, last[0]);
    const std::byte* const at = from.at + from.step * (count - 1);
    if (last[2] == 4) {
      store(to, load<std::uint32_t>(at));
    } else {
      pass(to, at, last[2], 0);
    }
  }
  for (std::uint32_t i = words[LoopWords::kLastComputed]; i != 0; --i, last += kLastComputedWords + last[2]) {
    load_pointer<ValueRun>(last)(table, instance, last + kLastComputedWords, 1);
  }
}

/// A function of the library, round by round. RT.
template <std::uint32_t kArguments>
[[gnu::noinline]] void call_rounds(Machine& m, const std::uint32_t* record, const Stream* streams,
                                   std::uint32_t count) noexcept {
  const auto kernel = load_pointer<stdlib::Kernel>(record);
  const Stream& out = stream_at(streams, record[2] & 0xffff);
  const Stream* const in[] = {&stream_at(streams, record[2] >> 16), &stream_at(streams, record[3] & 0xffff),
                              &stream_at(streams, record[3] >> 16)};
  std::byte* to = out.at;
  const void* places[kArguments];
  for (std::uint32_t i = 0; i < kArguments; ++i) places[i] = in[i]->at;
  for (; count != 0; --count) {
    const stdlib::Event event = kernel(to, places, kArguments);
    if (event != stdlib::Event::kNone) [[unlikely]]
      raise(m, m.code + record[5], event);
    to += out.step;
    for (std::uint32_t i = 0; i < kArguments; ++i) places[i] = static_cast<const std::byte*>(places[i]) + in[i]->step;
  }
}

/// `count` rounds of every record. Returns what is behind them. RT.
[[gnu::always_inline]] inline const std::uint32_t* run_records(Machine& m, const std::uint32_t* words,
                                                               const std::uint32_t* record, const Stream* streams,
                                                               std::uint32_t count) noexcept {
  for (std::uint32_t i = words[LoopWords::kRecords]; i != 0; --i, record += kLoopRecordWords) {
    switch (record[4]) {
      [[likely]] case 0 : {
        const std::uint32_t first = record[2], second = record[3];
        load_pointer<StreamRun>(record)(stream_at(streams, first & 0xffff), stream_at(streams, first >> 16),
                                        stream_at(streams, second & 0xffff), stream_at(streams, second >> 16), count);
        break;
      }
      case 1:
        call_rounds<1>(m, record, streams, count);
        break;
      case 2:
        call_rounds<2>(m, record, streams, count);
        break;
      default:
        call_rounds<3>(m, record, streams, count);
    }
  }
  return record;
}

/// Number of an element, from 0, in the first round: a sum at `index`. RT.
template <Addressing kAddressing>
[[gnu::noinline]] std::int64_t sum_at(std::byte* table, std::uint32_t instance, const std::uint32_t* index,
                                      std::int64_t control) noexcept {
  std::int64_t number = load<std::int64_t>(index + 6) + static_cast<std::int32_t>(index[4]) * control;
  const std::uint32_t* term = index + kSumIndexWords;
  for (std::uint32_t i = index[5]; i != 0; --i, term += kTermWords) {
    number +=
        static_cast<std::int32_t>(term[1]) * load_part(place<kAddressing>(table, instance, term[0]), term[2] == 4);
  }
  return number;
}

/// Finds the elements whose indices are at `next` in the first round: streams from `stream` on. Returns what is behind
/// the indices, or null when one leaves its array. RT.
template <Addressing kAddressing>
[[gnu::always_inline]] inline const std::uint32_t* find_elements(std::byte* table, std::uint32_t instance,
                                                                 const std::uint32_t* next, std::uint32_t indices,
                                                                 const Rounds& rounds, Stream* stream) noexcept {
  const std::int64_t ahead = rounds.step * (rounds.count - 1);  // of the control variable, in the last round
  for (; indices != 0; --indices) {
    const std::uint32_t kind = next[0], count = next[1], stride = next[2], array = next[3];
    std::int64_t number = 0, factor = 0;
    if ((kind & kBySum) != 0) [[unlikely]] {
      factor = static_cast<std::int32_t>(next[4]);
      number = sum_at<kAddressing>(table, instance, next, rounds.value);
      next += kSumIndexWords + std::size_t{next[5]} * kTermWords;
    } else {
      number = static_cast<std::int32_t>(next[4]);
      if ((kind & (kByInt | kByDint)) != 0) {
        number += load_part(place<kAddressing>(table, instance, next[5]), (kind & kByDint) != 0);
      }
      if ((kind & kByControl) != 0) {
        factor = 1;
        number += rounds.value;
      }
      next += kPlainIndexWords;
    }
    if (static_cast<std::uint64_t>(number) >= count || static_cast<std::uint64_t>(number + factor * ahead) >= count)
      return nullptr;
    const std::int64_t per_round = factor * rounds.step * stride;
    if ((kind & kFurther) == 0) {
      *stream++ = {place<kAddressing>(table, instance, array) + number * stride, per_round};
    } else {
      stream[-1].at += number * stride;
      stream[-1].step += per_round;
    }
  }
  return next;
}

/// The loop took `count` jumps of those that were left. RT.
void jump_on(Machine& m, const std::uint32_t* words, std::uint32_t count, std::uint32_t left) noexcept {
  m.place.store(words[LoopWords::kLoopJump], std::memory_order_relaxed);
  m.loops_left.store(left - count, std::memory_order_relaxed);
}

/// Runs all but the last kLoopChunk of many rounds, or as many as the budget has jumps for. Returns the rounds to come;
/// false when those are left to the code of the loop. RT.
template <bool kDint>
[[gnu::noinline]] std::pair<Rounds, bool> run_chunks(Machine& m, const std::uint32_t* words,
                                                     const std::uint32_t* records, Stream* streams, std::byte* control,
                                                     Rounds rounds) noexcept {
  Stream* const elements = streams + words[LoopWords::kVariables] + words[LoopWords::kValues];
  while (rounds.count > kLoopChunk || !rounds.all) {
    // What a budget ends in is left to the loop's own jump.
    const std::uint32_t left = m.loops_left.load(std::memory_order_relaxed);
    const auto count = static_cast<std::uint32_t>(std::min<std::int64_t>({rounds.count, left, kLoopChunk}));
    if (count == 0) return {rounds, false};
    run_records(m, words, records, streams, count);
    for (std::uint32_t i = 0; i < words[LoopWords::kElements]; ++i) elements[i].at += elements[i].step * count;
    rounds.value += rounds.step * count;
    rounds.count -= count;
    store_control<kDint>(control, rounds.value);
    jump_on(m, words, count, left);
    if (count < kLoopChunk) return {rounds, false};
  }
  return {rounds, true};
}

template <Addressing kAddressing, bool kDint>
const std::uint32_t* run(Machine& m, std::uint32_t instance, const std::uint32_t* words) noexcept {
  std::byte* const table = m.table;
  const auto at = [table, instance](std::uint32_t operand) { return place<kAddressing>(table, instance, operand); };
  const std::uint32_t* const head = m.code + words[LoopWords::kHead];
  const bool down = (words[LoopWords::kForm] & kDown) != 0;

  // How many rounds a jump follows.
  std::byte* const control = at(words[LoopWords::kControl]);
  Rounds rounds;
  rounds.value = load_control<kDint>(control);
  rounds.step = load_control<kDint>(at(words[LoopWords::kStep]));
  const std::int64_t limit = load_control<kDint>(at(words[LoopWords::kLimit]));
  std::int64_t jumps = down ? rounds.value - limit : limit - rounds.value;
  if (jumps < kLeastRounds) return head;
  if (rounds.step != 1) [[unlikely]] {
    if (rounds.step <= 0) return head;
    jumps = (static_cast<std::uint32_t>(jumps) - 1) / static_cast<std::uint32_t>(rounds.step) + 1;
    if (!fits<kDint>(rounds.value + (down ? -jumps : jumps) * rounds.step)) return head;
  }
  if (down) rounds.step = -rounds.step;
  const std::uint32_t budget = m.loops_left.load(std::memory_order_relaxed);
  rounds.all = jumps <= budget;
  rounds.count = rounds.all ? jumps + 1 : budget;
  if (rounds.count < kLeastRounds) return head;

  // Streams.
  Stream streams[kMostStreams];
  Stream* stream = streams;
  const std::uint32_t* next = words + LoopWords::kCount;
  for (std::uint32_t i = words[LoopWords::kVariables]; i != 0; --i) *stream++ = {at(*next++), 0};
  std::byte* scratch = table + words[LoopWords::kScratch];
  for (std::uint32_t i = words[LoopWords::kValues]; i != 0; --i) {
    const std::uint32_t bytes = *next++;
    *stream++ = {scratch, static_cast<std::ptrdiff_t>(bytes)};
    scratch += std::size_t{bytes} * kLoopChunk;
  }
  const std::uint32_t* const records =
      find_elements<kAddressing>(table, instance, next, words[LoopWords::kIndices], rounds, stream);
  if (records == nullptr) return head;

  if (rounds.count > kLoopChunk || !rounds.all) [[unlikely]] {
    bool goes_on = false;
    std::tie(rounds, goes_on) = run_chunks<kDint>(m, words, records, streams, control, rounds);
    if (!goes_on) return head;
  }
  const auto count = static_cast<std::uint32_t>(rounds.count);
  const std::uint32_t left = m.loops_left.load(std::memory_order_relaxed);
  if (left < count - 1) return head;
  const std::uint32_t* const last = run_records(m, words, records, streams, count);
  store_control<kDint>(control, rounds.value + rounds.step * (count - 1));
  jump_on(m, words, count - 1, left);
  finish<kAddressing>(table, instance, words, last, streams, count);
  // The comparison that ends it.
  store(at(words[LoopWords::kResult]), std::uint8_t{0});
  return m.code + words[LoopWords::kExit];
}

}  // namespace

// RT:
template <Addressing kAddressing>
const std::uint32_t* run_loop(Machine& m, std::uint32_t instance, const std::uint32_t* words) noexcept {
  return (words[LoopWords::kForm] & kWide) != 0 ? run<kAddressing, true>(m, instance, words)
                                                : run<kAddressing, false>(m, instance, words);
}

template const std::uint32_t* run_loop<Addressing::kFixed>(Machine&, std::uint32_t, const std::uint32_t*) noexcept;
template const std::uint32_t* run_loop<Addressing::kRelative>(Machine&, std::uint32_t, const std::uint32_t*) noexcept;

}  // namespace plc::runtime
