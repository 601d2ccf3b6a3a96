// Operation: what a resolved instruction is to the code generator, and which ones it leaves to the interpreter.
//
// In: ResolvedOp. Out: a form that one function translates, with its parameters. Does not belong here: code.
#pragma once

#include <cstdint>
#include <string_view>

#include "runtime/interpreter/interpreter.h"

namespace plc::native {

/// Machine types of operands. Signs matter only where an operation asks for them.
enum class Type : std::uint8_t { kI8, kU8, kI16, kU16, kI32, kU32, kI64, kU64, kF32, kF64 };
unsigned bytes_of(Type type);
bool is_signed(Type type);
bool is_real(Type type);

enum class Form : std::uint8_t {
  kInterpreted,  ///< runs in the interpreter
  kReturn,
  kBlockStart,  ///< for the interpreter alone: does nothing
  kArranged,    ///< only in copies that the interpreter alone runs (runtime/link/arrange.h)
  kJump,
  kJumpUnless,
  kJumpIf,
  kLoopJump,
  kMove,
  kCopy,
  kShortRecords4,
  kShortRecords5,
  kGeneralRecords,
  kRunBlock,
  kRunTaskblock,
  kCallFixed,
  kCallRelative,
  kCallFunction,
  kCallLibrary,
  kClearEvent,
  kEno,
  kLoadElement,
  kStoreElement,
  kLoadPath,
  kStorePath,
  kAdd,
  kSub,
  kMul,
  kDiv,
  kMod,
  kAnd,
  kOr,
  kXor,
  kCompare,
  kCompareJumpUnless,
  kCompareJumpIf,
  kExtract,
  kInsert,
  kRange,
};

enum class Relation : std::uint8_t { kEq, kNe, kLt, kLe, kGt, kGe };

struct Operation {
  Form form = Form::kInterpreted;
  Type type = Type::kU8;              ///< of the operands, or of the element
  Relation relation = Relation::kEq;  ///< forms of comparison
};

Operation operation_of(runtime::ResolvedOp op);
/// "ADD_32", or the linker's own name "CallPouFixed".
std::string_view name_of(runtime::ResolvedOp op);

}  // namespace plc::native
