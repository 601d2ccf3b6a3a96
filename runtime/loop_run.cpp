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

/// The type of a control variable.
template <bool kDint>
using Control = std::conditional_t<kDint, std::int32_t, std::int16_t>;

template <bool kDint>
std::int64_t load_control(const std::byte* from) noexcept {
  return load<Control<kDint>>(from);
}
template <bool kDint>
void store_control(std::byte* to, std::int64_t value) noexcept {
  store(to, static_cast<Control<kDint>>(value));
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
};

/// The stream that a record, an index or a last value names.
const Stream& stream_at(const Stream* streams, std::uint32_t place) noexcept {
  return *reinterpret_cast<const Stream*>(reinterpret_cast<const std::byte*>(streams) + place);
}
Stream& stream_at(Stream* streams, std::uint32_t place) noexcept {
  return *reinterpret_cast<Stream*>(reinterpret_cast<std::byte*>(streams) + place);
}

/// Sets what the last of `count` rounds leaves in variables; `last` is behind the records. RT.
template <Addressing kAddressing>
[[gnu::always_inline]] inline void finish(std::byte* table, std::uint32_t instance, const std::uint32_t* words,
                                          const std::uint32_t* last, const Stream* streams,
                                          std::uint32_t count) noexcept {
  const auto at = [streams, count](const std::uint32_t* value) {
    const Stream& from = stream_at(streams, value[1]);
    return from.at + from.step * (count - 1);
  };
  for (std::uint32_t i = words[LoopWords::kLastWords]; i != 0; --i, last += kLastValueWords) {
    store(place<kAddressing>(table, instance, last[0]), load<std::uint32_t>(at(last)));
  }
  for (std::uint32_t i = words[LoopWords::kLastValues]; i != 0; --i, last += kLastValueWords) {
    pass(place<kAddressing>(table, instance, last[0]), at(last), last[2], 0);
  }
  for (std::uint32_t i = words[LoopWords::kLastComputed]; i != 0; --i, last += kLastComputedWords + last[2]) {
    load_pointer<ValueRun>(last)(table, instance, last + kLastComputedWords, 1);
  }
}

/// A function of the library, round by round. RT.
template <std::uint32_t kArguments>
[[gnu::noinline]] void call_rounds(Machine& m, const std::uint32_t* record, const Stream* streams,
                                   std::uint32_t count) noexcept {
  const auto kernel = load_pointer<stdlib::Kernel>(record + RecordWords::kRun);
  const Stream& out = stream_at(streams, record[RecordWords::kOut]);
  const Stream* in[kArguments];
  for (std::uint32_t i = 0; i < kArguments; ++i) in[i] = &stream_at(streams, record[RecordWords::kIn + i]);
  std::byte* to = out.at;
  const void* places[kArguments];
  for (std::uint32_t i = 0; i < kArguments; ++i) places[i] = in[i]->at;
  for (; count != 0; --count) {
    const stdlib::Event event = kernel(to, places, kArguments);
    if (event != stdlib::Event::kNone) [[unlikely]]
      raise(m, m.code + record[RecordWords::kPosition], event);
    to += out.step;
    for (std::uint32_t i = 0; i < kArguments; ++i) places[i] = static_cast<const std::byte*>(places[i]) + in[i]->step;
  }
}

/// `count` rounds of every record. Returns what is behind them. RT.
[[gnu::always_inline]] inline const std::uint32_t* run_records(Machine& m, const std::uint32_t* words,
                                                               const std::uint32_t* record, const Stream* streams,
                                                               std::uint32_t count) noexcept {
  for (std::uint32_t i = words[LoopWords::kRecords]; i != 0; --i, record += RecordWords::kCount) {
    switch (record[RecordWords::kArguments]) {
      [[likely]] case 0 : {
        const auto stream = [streams, record](std::uint32_t word) -> const Stream& {
          return stream_at(streams, record[word]);
        };
        load_pointer<StreamRun>(record + RecordWords::kRun)(stream(RecordWords::kOut), stream(RecordWords::kIn),
                                                            stream(RecordWords::kIn + 1), stream(RecordWords::kIn + 2),
                                                            count);
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

/// Moves the stream of an element to one of its indices: `number`, from 0, in the first round, `factor` times the
/// control variable further in others. False when one leaves the array. RT.
[[gnu::always_inline]] inline bool add_index(Stream* streams, const std::uint32_t* index, std::int64_t number,
                                             std::int64_t factor, const Rounds& rounds) noexcept {
  const std::uint32_t count = index[IndexWords::kElements], stride = index[IndexWords::kStride];
  const std::int64_t ahead = factor * rounds.step * (rounds.count - 1);  // in the last round
  if (static_cast<std::uint64_t>(number) >= count || static_cast<std::uint64_t>(number + ahead) >= count) return false;
  Stream& stream = stream_at(streams, index[IndexWords::kStream]);
  stream.at += number * stride;
  stream.step += factor * rounds.step * stride;
  return true;
}

/// `indices` of one kind. Returns what is behind them, or null when one leaves its array. RT.
template <Addressing kAddressing, bool kControl, bool kVariable>
[[gnu::always_inline]] inline const std::uint32_t* add_indices(std::byte* table, std::uint32_t instance,
                                                               const std::uint32_t* next, std::uint32_t indices,
                                                               const Rounds& rounds, Stream* streams) noexcept {
  for (; indices != 0; --indices, next += IndexWords::kCount) {
    std::int64_t number = static_cast<std::int32_t>(next[IndexWords::kStart]);
    if (kVariable) {
      number +=
          load_part(place<kAddressing>(table, instance, next[IndexWords::kOperand]), next[IndexWords::kBytes] == 4);
    }
    if (kControl) number += rounds.value;
    if (!add_index(streams, next, number, kControl ? 1 : 0, rounds)) return nullptr;
  }
  return next;
}

/// The same, of sums.
template <Addressing kAddressing>
[[gnu::noinline]] const std::uint32_t* add_sums(std::byte* table, std::uint32_t instance, const std::uint32_t* next,
                                                std::uint32_t sums, Rounds rounds, Stream* streams) noexcept {
  for (; sums != 0; --sums) {
    const auto factor = static_cast<std::int32_t>(next[SumWords::kFactor]);
    std::int64_t number = load<std::int64_t>(next + SumWords::kStart) + factor * rounds.value;
    const std::uint32_t* term = next + SumWords::kCount;
    for (std::uint32_t i = next[SumWords::kTerms]; i != 0; --i, term += kTermWords) {
      number +=
          static_cast<std::int32_t>(term[1]) * load_part(place<kAddressing>(table, instance, term[0]), term[2] == 4);
    }
    if (!add_index(streams, next, number, factor, rounds)) return nullptr;
    next = term;
  }
  return next;
}

/// Finds the elements whose indices are at `next` in the first round. Returns what is behind the indices, or null when
/// one leaves its array. RT.
template <Addressing kAddressing>
[[gnu::always_inline]] inline const std::uint32_t* find_elements(std::byte* table, std::uint32_t instance,
                                                                 const std::uint32_t* words, const std::uint32_t* next,
                                                                 const Rounds& rounds, Stream* streams) noexcept {
  next = add_indices<kAddressing, true, false>(table, instance, next, words[LoopWords::kByControl], rounds, streams);
  if (next == nullptr) return nullptr;
  next = add_indices<kAddressing, false, true>(table, instance, next, words[LoopWords::kByVariable], rounds, streams);
  if (next == nullptr) return nullptr;
  next = add_indices<kAddressing, true, true>(table, instance, next, words[LoopWords::kByBoth], rounds, streams);
  if (next == nullptr || words[LoopWords::kBySum] == 0) return next;
  return add_sums<kAddressing>(table, instance, next, words[LoopWords::kBySum], rounds, streams);
}

/// The loop took `count` jumps of those that were left. RT.
void jump_on(Machine& m, const std::uint32_t* words, std::uint32_t count, std::uint32_t left) noexcept {
  m.place.store(words[LoopWords::kLoopJump], std::memory_order_relaxed);
  m.loops_left.store(left - count, std::memory_order_relaxed);
}

/// Runs all but the last kLoopChunk of many rounds, or as many as the budget has jumps for: `all`, if it has enough.
/// Returns the rounds to come; false when those are left to the code of the loop. RT.
template <bool kDint>
[[gnu::noinline]] std::pair<Rounds, bool> run_chunks(Machine& m, const std::uint32_t* words,
                                                     const std::uint32_t* records, Stream* streams, std::byte* control,
                                                     Rounds rounds, bool all) noexcept {
  Stream* const elements =
      streams + words[LoopWords::kValues] + words[LoopWords::kVariables] - words[LoopWords::kElements];
  while (rounds.count > kLoopChunk || !all) {
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

  // How many rounds a jump follows.
  std::byte* const control = at(words[LoopWords::kControl]);
  Rounds rounds;
  std::int64_t jumps = words[LoopWords::kJumps];
  if ((words[LoopWords::kForm] & kKnown) != 0) {
    rounds.value = static_cast<std::int32_t>(words[LoopWords::kStart]);
    rounds.step = static_cast<std::int32_t>(words[LoopWords::kAdded]);
  } else {
    rounds.value = load_control<kDint>(control);
    const bool down = (words[LoopWords::kForm] & kDown) != 0;
    rounds.step = load_control<kDint>(at(words[LoopWords::kStep]));
    const std::int64_t limit = load_control<kDint>(at(words[LoopWords::kLimit]));
    jumps = jumps_of_loop<Control<kDint>>(rounds.value, rounds.step, limit, down);
    if (down) rounds.step = -rounds.step;
  }
  if (jumps < kLeastRounds) return head;

  // The last round takes no jump.
  const std::uint32_t budget = m.loops_left.load(std::memory_order_relaxed);
  const bool all = jumps <= budget;
  rounds.count = all ? jumps + 1 : budget;
  if (rounds.count < kLeastRounds) return head;

  // Streams.
  Stream streams[kMostStreams];
  Stream* stream = streams;
  const std::uint32_t* next = words + LoopWords::kCount;
  std::byte* scratch = table + words[LoopWords::kScratch];
  for (std::uint32_t i = words[LoopWords::kValues]; i != 0; --i) {
    const std::uint32_t bytes = *next++;
    *stream++ = {scratch, static_cast<std::ptrdiff_t>(bytes)};
    scratch += std::size_t{bytes} * kLoopChunk;
  }
  for (std::uint32_t i = words[LoopWords::kVariables]; i != 0; --i, next += 2) {
    *stream++ = {at(next[0]), static_cast<std::int32_t>(next[1])};
  }
  const std::uint32_t* const records = find_elements<kAddressing>(table, instance, words, next, rounds, streams);
  if (records == nullptr) return head;

  if (rounds.count > kLoopChunk || !all) [[unlikely]] {
    bool goes_on = false;
    std::tie(rounds, goes_on) = run_chunks<kDint>(m, words, records, streams, control, rounds, all);
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
