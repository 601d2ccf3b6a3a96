// Rows of the library that translators have code for, found by the pointers in resolved code.
//
// Out: which function or block of the library a kernel or step is. Does not belong here: code.
#pragma once

#include <optional>

#include "core/types.h"
#include "native/operation.h"
#include "stdlib/library.h"

namespace plc::native {

/// Nothing for texts.
std::optional<Type> machine_type(core::TypeId id);
enum class Function : std::uint8_t {
  kSelect,
  kLeast,
  kGreatest,
  kLimit,
  kAbsolute,  ///< of integers with a sign
  kSquareRoot,
  kNot,
  kShiftLeft,
  kShiftRight,
  kRotateLeft,
  kRotateRight,
  kConvert,  ///< between numbers and bits
};
struct FunctionRow {
  Function function;
  const stdlib::Overload* overload;
  Type type;  ///< T, or what the first parameter is
};
/// The function of a kernel, if it may cost less than a call (stdlib/functions/).
std::optional<FunctionRow> function_of(stdlib::Kernel kernel);

enum class Block : std::uint8_t {
  kRisingEdge,
  kFallingEdge,
  kSetDominant,
  kResetDominant,
  kOnDelay,
  kOffDelay,
  kPulse,
  kCountUp,
  kCountDown,
};
/// Ports of a block, at its beginning, that its code stores by itself if what is before it left them in registers.
constexpr std::uint32_t deferred_bytes(Block block) {
  switch (block) {
    case Block::kSetDominant:
    case Block::kResetDominant:
      return 0;
    case Block::kCountUp:
    case Block::kCountDown:
      return 2;
    default:
      return 1;
  }
}
inline constexpr std::uint32_t kMostDeferredBytes = 2;
struct BlockRow {
  Block block;
  const stdlib::BlockSpec* spec;
};
/// The block of a step, if it costs less than a call (stdlib/blocks/).
std::optional<BlockRow> block_of(stdlib::Step step);

}  // namespace plc::native
