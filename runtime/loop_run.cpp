#include "runtime/loop_run.h"

#include <algorithm>
#include <limits>

#include "runtime/memory/table.h"
#include "runtime/operations.h"
#include "runtime/value_runs.h"

namespace plc::runtime {
namespace {

static_assert(kLoopChunk * sizeof(std::uint64_t) * kMostStreams <= kScratchBytes);

/// Fewer are not worth it.
constexpr std::uint32_t kLeastRounds = 4;

std::int64_t load_integer(const std::byte* from, bool wide) noexcept {
  return wide ? std::int64_t{load<std::int32_t>(from)} : std::int64_t{load<std::int16_t>(from)};
}
void store_integer(std::byte* to, bool wide, std::int64_t value) noexcept {
  if (wide) {
    store(to, static_cast<std::int32_t>(value));
  } else {
    store(to, static_cast<std::int16_t>(value));
  }
}
bool fits(std::int64_t value, bool wide) noexcept {
  return wide ? value == static_cast<std::int32_t>(value) : value == static_cast<std::int16_t>(value);
}

/// The control variable over the rounds to come.
struct Rounds {
  std::int64_t value = 0;
  std::int64_t step = 0;
  std::int64_t count = 0;
  bool all = true;  ///< the last one is the loop's last one, which takes no jump
};

/// Sets what the last of `count` rounds leaves in variables; `last` is behind the records. RT.
template <Addressing kAddressing>
void finish(const Machine& m, std::uint32_t instance, const std::uint32_t* words, const std::uint32_t* last,
            const Stream* streams, std::uint32_t count) noexcept {
  for (std::uint32_t i = words[LoopWords::kLastValues]; i != 0; --i, last += kLastValueWords) {
    const Stream& from = streams[last[1]];
    pass(place<kAddressing>(m.table, instance, last[0]), from.at + from.step * (count - 1), last[2], 0);
  }
  for (std::uint32_t i = words[LoopWords::kLastComputed]; i != 0; --i, last += kLastComputedWords + last[2]) {
    load_pointer<ValueRun>(last)(m.table, instance, last + kLastComputedWords, 1);
  }
}

/// A function of the library, round by round. RT.
template <std::uint32_t kArguments>
void call_rounds(Machine& m, const std::uint32_t* record, const Stream& out, const Stream* const (&in)[3],
                 std::uint32_t count) noexcept {
  const auto kernel = load_pointer<stdlib::Kernel>(record);
  std::byte* to = out.at;
  const void* places[kArguments];
  for (std::uint32_t i = 0; i < kArguments; ++i) places[i] = in[i]->at;
  for (; count != 0; --count) {
    const stdlib::Event event = kernel(to, places, kArguments);
    if (event != stdlib::Event::kNone) [[unlikely]]
      raise(m, m.code + record[4], event);
    to += out.step;
    for (std::uint32_t i = 0; i < kArguments; ++i) places[i] = static_cast<const std::byte*>(places[i]) + in[i]->step;
  }
}

/// `count` rounds of every record. Returns what is behind them. RT.
inline const std::uint32_t* run_records(Machine& m, const std::uint32_t* words, const std::uint32_t* record,
                                        const Stream* streams, std::uint32_t count) noexcept {
  for (std::uint32_t i = words[LoopWords::kRecords]; i != 0; --i, record += kLoopRecordWords) {
    const std::uint32_t numbers = record[2];
    const Stream& out = streams[numbers & 0xff];
    const Stream& in0 = streams[numbers >> 8 & 0xff];
    const Stream& in1 = streams[numbers >> 16 & 0xff];
    const Stream& in2 = streams[numbers >> 24];
    switch (record[3]) {
      case 0:
        load_pointer<StreamRun>(record)(out, in0, in1, in2, count);
        break;
      case 1:
        call_rounds<1>(m, record, out, {&in0, &in1, &in2}, count);
        break;
      case 2:
        call_rounds<2>(m, record, out, {&in0, &in1, &in2}, count);
        break;
      default:
        call_rounds<3>(m, record, out, {&in0, &in1, &in2}, count);
    }
  }
  return record;
}

}  // namespace

// RT:
template <Addressing kAddressing>
const std::uint32_t* run_loop(Machine& m, std::uint32_t instance, const std::uint32_t* words) noexcept {
  std::byte* const table = m.table;
  const auto at = [table, instance](std::uint32_t operand) { return place<kAddressing>(table, instance, operand); };
  const std::uint32_t* const head = m.code + words[LoopWords::kHead];
  const bool wide = (words[LoopWords::kForm] & kWide) != 0;
  const bool down = (words[LoopWords::kForm] & kDown) != 0;

  // How many rounds a jump follows.
  std::byte* const control = at(words[LoopWords::kControl]);
  Rounds rounds;
  rounds.value = load_integer(control, wide);
  const std::int64_t limit = load_integer(at(words[LoopWords::kLimit]), wide);
  const std::int64_t step = load_integer(at(words[LoopWords::kStep]), wide);
  const std::int64_t distance = down ? rounds.value - limit : limit - rounds.value;
  if (distance < kLeastRounds || step <= 0) return head;
  const std::int64_t jumps =
      step == 1 ? distance : (static_cast<std::uint32_t>(distance) - 1) / static_cast<std::uint32_t>(step) + 1;
  const std::uint32_t budget = m.loops_left.load(std::memory_order_relaxed);
  rounds.step = down ? -step : step;
  rounds.all = jumps <= budget;
  rounds.count = rounds.all ? jumps + 1 : budget;
  if (rounds.count < kLeastRounds || !fits(rounds.value + rounds.step * (rounds.count - rounds.all), wide)) return head;

  // Streams.
  Stream streams[kMostStreams];
  Stream* stream = streams;
  const std::uint32_t* next = words + LoopWords::kCount;
  for (std::uint32_t i = 0; i < words[LoopWords::kVariables]; ++i) *stream++ = {at(*next++), 0};
  std::byte* scratch = table + words[LoopWords::kScratch];
  for (std::uint32_t i = 0; i < words[LoopWords::kValues]; ++i) {
    const std::uint32_t bytes = *next++;
    *stream++ = {scratch, static_cast<std::ptrdiff_t>(bytes)};
    scratch += std::size_t{bytes} * kLoopChunk;
  }
  Stream* const elements = stream;
  for (std::uint32_t i = 0; i < words[LoopWords::kElements]; ++i) {
    *stream = {at(next[0]), 0};
    std::uint32_t indices = next[1];
    next += kElementWords;
    for (; indices != 0; --indices) {
      const auto kind = static_cast<LoopIndex>(next[0]);
      const std::uint32_t count = next[1], stride = next[2];
      std::int64_t factor = 0, number;
      if (kind == LoopIndex::kSum) [[unlikely]] {
        factor = static_cast<std::int32_t>(next[3]);
        number = load<std::int64_t>(next + 5) + factor * rounds.value;
        std::uint32_t terms = next[4];
        next += kSumIndexWords;
        for (; terms != 0; --terms, next += kTermWords) {
          number += static_cast<std::int32_t>(next[1]) * load_integer(at(next[0]), next[2] == 4);
        }
      } else {
        factor = kind == LoopIndex::kControl;
        number = static_cast<std::int32_t>(next[3]);
        number += kind == LoopIndex::kControl ? rounds.value : load_integer(at(next[4]), kind == LoopIndex::kDint);
        next += kPlainIndexWords;
      }
      if (factor != 0) {
        const std::int64_t per_round = factor * rounds.step;
        if (static_cast<std::uint64_t>(number + per_round * (rounds.count - 1)) >= count) return head;
        stream->step += per_round * stride;
      }
      if (static_cast<std::uint64_t>(number) >= count) return head;
      stream->at += number * stride;
    }
    ++stream;
  }

  const std::uint32_t* const records = next;
  const auto jump_on = [&m, words](std::uint32_t count, std::uint32_t left) {
    m.place.store(words[LoopWords::kLoopJump], std::memory_order_relaxed);
    m.loops_left.store(left - count, std::memory_order_relaxed);
  };
  for (; rounds.count > kLoopChunk || !rounds.all; rounds.count -= kLoopChunk) {
    // What a budget ends in is left to the loop's own jump.
    const std::uint32_t left = m.loops_left.load(std::memory_order_relaxed);
    const auto count = static_cast<std::uint32_t>(std::min<std::int64_t>({rounds.count, left, kLoopChunk}));
    if (count == 0) return head;
    run_records(m, words, records, streams, count);
    for (Stream* element = elements; element != stream; ++element) element->at += element->step * count;
    rounds.value += rounds.step * count;
    store_integer(control, wide, rounds.value);
    jump_on(count, left);
    if (count < kLoopChunk) return head;
  }
  const auto count = static_cast<std::uint32_t>(rounds.count);
  const std::uint32_t left = m.loops_left.load(std::memory_order_relaxed);
  if (left < count - 1) return head;
  const std::uint32_t* const last = run_records(m, words, records, streams, count);
  store_integer(control, wide, rounds.value + rounds.step * (count - 1));
  jump_on(count - 1, left);
  finish<kAddressing>(m, instance, words, last, streams, count);
  return m.code + words[LoopWords::kEnd];
}

template const std::uint32_t* run_loop<Addressing::kFixed>(Machine&, std::uint32_t, const std::uint32_t*) noexcept;
template const std::uint32_t* run_loop<Addressing::kRelative>(Machine&, std::uint32_t, const std::uint32_t*) noexcept;

}  // namespace plc::runtime
