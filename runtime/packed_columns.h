// Bits of a packed run's second word (packed_run.h), so that no two inputs of a chunk lie in the same column, i.e. in
// the same bit of either word. Compile time.
//
// In: the columns where each byte of the second window may not be. Out: the bit of each. Does not belong here: which
// inputs a chunk has (link_packed.h).
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "runtime/packed_run.h"

namespace plc::runtime {

/// Bytes that are shuffled at once: those of a lane stay in it.
inline constexpr std::uint32_t kLaneBytes = 16;

/// For each byte of a window its bit.
using WindowBits = std::array<std::uint8_t, kPackedWindowBytes>;

/// `blocked[i]`: the bits where byte i may not be. The bit of each byte, all of them different; nothing if there is no
/// such order.
std::optional<WindowBits> order_window(const std::array<std::uint64_t, kPackedWindowBytes>& blocked);

}  // namespace plc::runtime
