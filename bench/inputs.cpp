#include "bench/inputs.h"

#include <algorithm>
#include <cstring>

namespace plc::bench {
namespace {

/// All rows together: so many values that no branch predictor learns them, and they stay in the second cache.
constexpr std::size_t kRowBytes = 128 * 1024;

/// Spreads consecutive numbers over all 64 bits.
std::uint64_t scatter(std::uint64_t number) {
  number = (number ^ (number >> 30)) * 0xbf58476d1ce4e5b9u;
  number = (number ^ (number >> 27)) * 0x94d049bb133111ebu;
  return number ^ (number >> 31);
}

void put(Stimulus stimulus, std::uint64_t random, unsigned char* at) {
  const auto value = static_cast<std::int32_t>(random);
  switch (stimulus) {
    case Stimulus::kNone:
      break;
    case Stimulus::kBool:
      *at = random & 1;
      break;
    case Stimulus::kDint:
      std::memcpy(at, &value, sizeof value);
      break;
    case Stimulus::kReal: {
      const float real = static_cast<float>(value % 100'000) / 100;
      std::memcpy(at, &real, sizeof real);
      break;
    }
  }
}

}  // namespace

InputWriter::InputWriter(const Source& source, const Side& side, Inputs inputs) {
  for (std::size_t i = 0; i < source.variables.size(); ++i)
    by_stimulus_[static_cast<std::size_t>(source.variables[i].stimulus)].push_back(side.variables()[i]);
  if (inputs == Inputs::kAll) make_rows(source, side);
}

void InputWriter::make_rows(const Source& source, const Side& side) {
  for (std::size_t i = 0; i < source.variables.size(); ++i) {
    const Variable& variable = source.variables[i];
    if (variable.stimulus == Stimulus::kNone) continue;
    unsigned char* const to = side.variables()[i];
    if (parts_.empty() || parts_.back().to + parts_.back().bytes != to) parts_.push_back({to, row_bytes_, 0});
    parts_.back().bytes += variable.bytes;
    row_bytes_ += variable.bytes;
  }
  if (row_bytes_ == 0) return;
  row_count_ = std::max<std::size_t>(1, kRowBytes / row_bytes_);
  rows_.resize(row_count_ * row_bytes_);
  std::uint64_t number = 0;
  for (std::size_t at = 0; at < rows_.size();) {
    for (const Variable& variable : source.variables) {
      if (variable.stimulus == Stimulus::kNone) continue;
      put(variable.stimulus, scatter(++number) >> 8, &rows_[at]);
      at += variable.bytes;
    }
  }
}

void InputWriter::write_one_of_each(std::uint64_t scan) const {
  for (const Stimulus stimulus : {Stimulus::kBool, Stimulus::kDint, Stimulus::kReal}) {
    const auto& inputs = by_stimulus_[static_cast<std::size_t>(stimulus)];
    if (inputs.empty()) continue;
    unsigned char* const at = inputs[scan * 2654435761u % inputs.size()];
    if (stimulus == Stimulus::kBool) {
      *at ^= 1;
    } else {
      put(stimulus, scatter(scan), at);
    }
  }
}

void InputWriter::write_all(std::uint64_t scan) const {
  const unsigned char* const row = &rows_[scan % row_count_ * row_bytes_];
  for (const Part& part : parts_) std::memcpy(part.to, row + part.from, part.bytes);
}

}  // namespace plc::bench
