// Opcodes and the encoding of code, derived from opcodes.def.
//
// Code is a sequence of 32-bit words: the opcode word (opcode in the low 16 bits, number of list items in the high 16),
// then one word per operand of the row, then the list, if the row has one:
//   records()   count x 7 words: truth table, out, in0..in4 (out and in are BOOL leaves; unused inputs repeat in0 and
//   the
//               table ignores them)
//   path()      count x 2 words: PathStep, then a field number, an element number from 0, or the leaf of an index
//   std_args()  count words: the result leaf, then the arguments
//   fn_args()   count x 2 words: variable index in the callee, leaf or place of the caller (inputs: read; outputs and
//   the
//               return value: written; in-outs: a REF leaf)
// Larger lists are split into several instructions.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/types.h"

namespace plc::bytecode {

using core::Rep;

/// Sets of representations an operand may have.
using RepMask = std::uint16_t;
constexpr RepMask mask_of(Rep rep) { return static_cast<RepMask>(1u << static_cast<unsigned>(rep)); }
inline constexpr RepMask kMBool = mask_of(Rep::kBool), kMI8 = mask_of(Rep::kI8), kMU8 = mask_of(Rep::kU8),
                         kMI16 = mask_of(Rep::kI16), kMU16 = mask_of(Rep::kU16), kMI32 = mask_of(Rep::kI32),
                         kMU32 = mask_of(Rep::kU32), kMI64 = mask_of(Rep::kI64), kMU64 = mask_of(Rep::kU64),
                         kMF32 = mask_of(Rep::kF32), kMF64 = mask_of(Rep::kF64), kMStr = mask_of(Rep::kStr),
                         kMWstr = mask_of(Rep::kWstr), kMRef = mask_of(Rep::kRef), kM8 = kMI8 | kMU8,
                         kM16 = kMI16 | kMU16, kM32 = kMI32 | kMU32, kM64 = kMI64 | kMU64,
                         kMWord = kM8 | kM16 | kM32 | kM64, kMPart = kMBool | kMU8 | kMU16 | kMU32;

/// What one word after the opcode word means.
enum class OperandKind : std::uint8_t {
  kIn,          ///< leaf read; `reps`
  kOut,         ///< leaf written; `reps`; never in the constants
  kPlaceIn,     ///< value of the instruction's type() operand, read
  kPlaceOut,    ///< value of the instruction's type() operand, written
  kPlaceInOut,  ///< instance or port struct that belongs to the block() or pou() operand before it
  kBaseIn,      ///< value of the instruction's type() operand, where its path starts; read
  kBaseOut,     ///< the same, written
  kValueIn,     ///< leaf or place of the type where the path ends, read
  kValueOut,    ///< leaf or place of the type where the path ends, written
  kTarget,      ///< word index in the same body
  kType,        ///< index into Image::types
  kPou,         ///< index into Image::pous
  kBlock,       ///< index into Image::blocks
  kFunction,    ///< index into Image::functions
  kGlobal,      ///< field index in the global table
  kCount,       ///< plain number
  kImm,         ///< plain number
  kPath,        ///< no word of its own: the list of steps from the type() operand to a part of it
  kRecords,     ///< no word of its own: the list of a BOOL_RUN
  kStdArgs,     ///< no word of its own: the list of a CALL_STD
  kFnArgs,      ///< no word of its own: the list of a CALL_FN
  kQueue,       ///< index into Image::queues
};
struct OperandSpec {
  OperandKind kind = OperandKind::kIn;
  RepMask reps = 0;
};
struct Operands {
  std::uint8_t count = 0;
  std::array<OperandSpec, 4> specs{};
};
/// kEvent: may raise a stdlib::Event. kBudget: may raise the loop-budget fault.
enum class Events : std::uint8_t { kNever, kEvent, kBudget };

enum class Opcode : std::uint16_t {
#define PLC_OPCODE(Name, mnemonic, operands, events, cost, function, meaning) k##Name,
#include "bytecode/opcodes.def"
};

struct OpcodeInfo {
  std::string_view name;      ///< C++ name, "Add32"
  std::string_view mnemonic;  ///< in the assembler, "ADD_32"
  Operands operands;
  Events events;
  std::string_view function;  ///< standard function implemented, or empty
  std::string_view meaning;
};
std::span<const OpcodeInfo> opcodes();
const OpcodeInfo& info(Opcode opcode);

inline constexpr std::uint32_t kRecordWords = 7;
inline constexpr std::uint32_t kPathWords = 2;
inline constexpr std::uint32_t kMaxListItems = 0xffff;

/// Words of one item of the list `kind`; 0 for operands that have a word of their own.
constexpr std::uint32_t words_per_item(OperandKind kind) {
  return kind == OperandKind::kRecords   ? kRecordWords
         : kind == OperandKind::kStdArgs ? 1
         : kind == OperandKind::kFnArgs  ? 2
         : kind == OperandKind::kPath    ? kPathWords
                                         : 0;
}
/// Words of an instruction of this row with `items` list items, the opcode word included.
constexpr std::size_t words_of(const Operands& operands, std::uint32_t items) {
  std::size_t words = 1;
  for (std::uint8_t i = 0; i < operands.count; ++i) {
    const std::uint32_t item = words_per_item(operands.specs[i].kind);
    words += item == 0 ? 1 : std::size_t{item} * items;
  }
  return words;
}

/// The first word of an item of path().
enum class PathStep : std::uint32_t {
  kField,    ///< to the field of this number of a structure
  kElement,  ///< to the element of this number, from 0, of an array
  kIndex,    ///< to the element of an array whose index, as declared, is in this leaf: an integer or bit string
};

constexpr std::uint32_t opcode_word(Opcode opcode, std::uint32_t list_items = 0) {
  return static_cast<std::uint32_t>(opcode) | (list_items << 16);
}

/// Which memory an operand is relative to.
enum class Space : std::uint8_t {
  kGlobal,    ///< the task's local copy of the global table (same layout)
  kInstance,  ///< the current instance
  kFrame,     ///< the frame of the current POU
  kConst,     ///< the constants; read only
};
/// An operand word: space in the top two bits, byte offset below.
constexpr std::uint32_t operand_word(Space space, std::uint32_t offset) {
  return static_cast<std::uint32_t>(space) << 30 | offset;
}
constexpr Space space_of(std::uint32_t word) { return static_cast<Space>(word >> 30); }
constexpr std::uint32_t offset_of(std::uint32_t word) { return word & 0x3fffffffu; }
/// Tables larger than this are refused.
inline constexpr std::uint32_t kMaxTableBytes = 0x3fffffffu;

}  // namespace plc::bytecode
