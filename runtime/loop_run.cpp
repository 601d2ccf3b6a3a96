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
  std::uint32_t count = 0;
};

/// A function of the library, round by round.
void call_rounds(Machine& m, const std::uint32_t* record, const Stream& out, const Stream* const (&in)[3],
                 std::uint32_t count) noexcept {
  const auto kernel = load_pointer<stdlib::Kernel>(record);
  const std::uint32_t arguments = record[3];
  for (std::uint32_t round = 0; round < count; ++round) {
    const void* places[3];
    for (std::uint32_t i = 0; i < 3; ++i) places[i] = in[i]->at + in[i]->step * round;
    const stdlib::Event event = kernel(out.at + out.step * round, places, arguments);
    if (event != stdlib::Event::kNone) [[unlikely]]
      raise(m, m.code + record[4], event);
  }
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
  const std::int64_t to_go =
      step == 1 ? distance : (static_cast<std::uint32_t>(distance) - 1) / static_cast<std::uint32_t>(step) + 1;
  rounds.step = down ? -step : step;
  rounds.count =
      static_cast<std::uint32_t>(std::min<std::int64_t>(to_go, m.loops_left.load(std::memory_order_relaxed)));
  if (rounds.count < kLeastRounds || !fits(rounds.value + rounds.step * rounds.count, wide)) return head;

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
      const std::uint32_t count = next[0], stride = next[1];
      const std::int64_t factor = static_cast<std::int32_t>(next[2]);
      std::int64_t element = load<std::int64_t>(next + 4);
      std::uint32_t terms = next[3];
      next += kElementIndexWords;
      for (; terms != 0; --terms, next += kElementTermWords) {
        element += static_cast<std::int32_t>(next[1]) * load_integer(at(next[0]), next[2] == 4);
      }
      if (factor != 0) {
        element += factor * rounds.value;
        const std::int64_t per_round = factor * rounds.step;
        if (static_cast<std::uint64_t>(element + per_round * (rounds.count - 1)) >= count) return head;
        stream->step += per_round * stride;
      }
      if (static_cast<std::uint64_t>(element) >= count) return head;
      stream->at += element * stride;
    }
    ++stream;
  }

  const std::uint32_t* const records = next;
  while (rounds.count != 0) {
    const std::uint32_t left = m.loops_left.load(std::memory_order_relaxed);
    if (left == 0) break;  // the loop's own jump says so
    const std::uint32_t count = std::min({rounds.count, left, kLoopChunk});
    const std::uint32_t* record = records;
    for (std::uint32_t i = words[LoopWords::kRecords]; i != 0; --i, record += kLoopRecordWords) {
      const std::uint32_t numbers = record[2];
      const Stream& out = streams[numbers & 0xff];
      const Stream& in0 = streams[numbers >> 8 & 0xff];
      const Stream& in1 = streams[numbers >> 16 & 0xff];
      const Stream& in2 = streams[numbers >> 24];
      if (record[3] == 0) {
        load_pointer<StreamRun>(record)(out, in0, in1, in2, count);
      } else {
        call_rounds(m, record, out, {&in0, &in1, &in2}, count);
      }
    }
    for (Stream* element = elements; element != stream; ++element) element->at += element->step * count;
    rounds.count -= count;
    rounds.value += rounds.step * count;
    store_integer(control, wide, rounds.value);
    m.place.store(words[LoopWords::kLoopJump], std::memory_order_relaxed);
    m.loops_left.store(left - count, std::memory_order_relaxed);
  }
  return head;
}

template const std::uint32_t* run_loop<Addressing::kFixed>(Machine&, std::uint32_t, const std::uint32_t*) noexcept;
template const std::uint32_t* run_loop<Addressing::kRelative>(Machine&, std::uint32_t, const std::uint32_t*) noexcept;

}  // namespace plc::runtime
