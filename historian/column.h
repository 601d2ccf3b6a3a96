// A column: the samples of one tag, or their times, one after the other, as few bytes.
//
// Each value is XORed with the one before it, the first bytes of all values come first, then the second ones, and the
// whole is compressed: what changes little takes little. In: bytes of values of one width. Out: the same. Threads: one
// for each object. Does not belong here: what values mean.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace plc::historian {

class Columns {
 public:
  Columns();
  ~Columns();
  Columns(const Columns&) = delete;
  Columns& operator=(const Columns&) = delete;

  /// `values`: a multiple of `width` bytes. The answer is good until the next call.
  std::span<const std::byte> pack(std::span<const std::byte> values, std::uint32_t width);
  /// Empty when it was not made by pack() of this width.
  std::span<const std::byte> unpack(std::span<const std::byte> packed, std::uint32_t width);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace plc::historian
