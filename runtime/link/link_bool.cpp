#include "runtime/link/link_bool.h"

#include <algorithm>
#include <cstring>

#include "runtime/interpreter/interpreter.h"

namespace plc::runtime {
namespace {

/// A switch of loops costs a mispredicted branch or two, about ten records: shorter basic blocks do not pay for it.
constexpr std::uint32_t kLeastWindowed = 16;
constexpr std::uint32_t kLeastFourInput = 64;
constexpr std::uint32_t kWindowBytes = 0x10000;

/// Smallest and largest operand; `uniform` when all count from the same place (the table or the instance).
struct Extent {
  std::uint32_t low = 0;
  std::uint32_t high = 0;
  bool uniform = true;
};

Extent extent_of(const GeneralRecord& record) {
  Extent e{record.out, record.out, true};
  for (const std::uint32_t in : record.in) {
    e.low = std::min(e.low, in);
    e.high = std::max(e.high, in);
  }
  // The relative bit is the top one, so operands of one kind are neighbours in order.
  e.uniform = (e.low & kRelativeBit) == (e.high & kRelativeBit);
  return e;
}

/// How many records from `first` on fit one window, and the window's start.
struct Window {
  std::uint32_t count = 0;
  std::uint32_t start = 0;
};
Window widest_window(std::span<const GeneralRecord> records, std::uint32_t first) {
  Window window;
  std::uint32_t low = 0xffffffffu;
  std::uint32_t high = 0;
  for (std::size_t i = first; i < records.size(); ++i) {
    const Extent e = extent_of(records[i]);
    const std::uint32_t new_low = std::min(low, e.low);
    const std::uint32_t new_high = std::max(high, e.high);
    if (!e.uniform || (new_low & kRelativeBit) != (new_high & kRelativeBit) || new_high - new_low >= kWindowBytes)
      break;
    low = new_low;
    high = new_high;
    ++window.count;
  }
  window.start = window.count == 0 ? 0 : low;
  return window;
}

void append(std::vector<BoolSegment>& segments, BoolSegment segment) {
  if (segment.count == 0) return;
  if (!segments.empty() && segments.back().form == segment.form && segments.back().window == segment.window) {
    segments.back().count += segment.count;
  } else {
    segments.push_back(segment);
  }
}

/// Splits one window into long four-input basic blocks and the rest.
void append_window(std::vector<BoolSegment>& segments, std::span<const GeneralRecord> records, std::uint32_t first,
                   const Window& window) {
  const std::uint32_t end = first + window.count;
  std::uint32_t rest = first;
  for (std::uint32_t at = first; at < end;) {
    std::uint32_t after = at;
    while (after < end && ignores_last_input(records[after].truth)) ++after;
    const bool whole_window = at == first && after == end;
    if (whole_window || after - at >= kLeastFourInput) {
      append(segments, {BoolSegment::Form::kShort5, rest, at - rest, window.start});
      append(segments, {BoolSegment::Form::kShort4, at, after - at, window.start});
      rest = after;
    }
    at = after + 1;
  }
  append(segments, {BoolSegment::Form::kShort5, rest, end - rest, window.start});
}

}  // namespace

std::vector<BoolSegment> cut_into_segments(std::span<const GeneralRecord> records) {
  std::vector<BoolSegment> segments;
  const auto count = static_cast<std::uint32_t>(records.size());
  for (std::uint32_t first = 0; first < count;) {
    const Window window = widest_window(records, first);
    if (window.count >= kLeastWindowed || (first == 0 && window.count == count)) {
      append_window(segments, records, first, window);
      first += window.count;
    } else {
      const std::uint32_t general = std::max<std::uint32_t>(window.count, 1);
      append(segments, {BoolSegment::Form::kGeneral, first, general, 0});
      first += general;
    }
  }
  return segments;
}

ShortRecord shorten(const GeneralRecord& record, std::uint32_t window) {
  ShortRecord s;
  s.truth = record.truth;
  s.out = static_cast<std::uint16_t>(record.out - window);
  for (std::size_t i = 0; i < 5; ++i) s.in[i] = static_cast<std::uint16_t>(record.in[i] - window);
  return s;
}

void append_segment(std::vector<std::uint32_t>& words, std::uint32_t handler, const BoolSegment& segment,
                    std::span<const GeneralRecord> records) {
  words.push_back(handler);
  words.push_back(segment.count);
  if (segment.form == BoolSegment::Form::kGeneral) {
    const std::size_t at = words.size();
    words.resize(at + records.size() * kGeneralRecordWords);
    std::memcpy(words.data() + at, records.data(), records.size_bytes());
    return;
  }
  words.push_back(segment.window);
  // A record must not lie across two cache lines.
  const std::size_t first = (words.size() + 1 + kShortRecordWords - 1) / kShortRecordWords * kShortRecordWords;
  words.push_back(static_cast<std::uint32_t>(first));
  words.resize(first + records.size() * kShortRecordWords, 0);
  for (std::size_t i = 0; i < records.size(); ++i) {
    const ShortRecord record = shorten(records[i], segment.window);
    std::memcpy(words.data() + first + i * kShortRecordWords, &record, sizeof record);
  }
}

}  // namespace plc::runtime
