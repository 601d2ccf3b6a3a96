#include "native/operation.h"

#include <iterator>

namespace plc::native {

using runtime::ResolvedOp;

unsigned bytes_of(Type type) {
  switch (type) {
    case Type::kI8:
    case Type::kU8:
      return 1;
    case Type::kI16:
    case Type::kU16:
      return 2;
    case Type::kI32:
    case Type::kU32:
    case Type::kF32:
      return 4;
    case Type::kI64:
    case Type::kU64:
    case Type::kF64:
      break;
  }
  return 8;
}
bool is_signed(Type type) {
  return type == Type::kI8 || type == Type::kI16 || type == Type::kI32 || type == Type::kI64;
}
bool is_real(Type type) { return type == Type::kF32 || type == Type::kF64; }

Operation operation_of(ResolvedOp op) {
#define PLC_ONE(Name, form, type) \
  case ResolvedOp::k##Name:       \
    return {Form::form, Type::type};
// Families, as in opcodes.def.
#define PLC_SIZES(Name, form) \
  PLC_ONE(Name##8, form, kU8) PLC_ONE(Name##16, form, kU16) PLC_ONE(Name##32, form, kU32) PLC_ONE(Name##64, form, kU64)
#define PLC_REALS(Name, form) PLC_ONE(Name##F32, form, kF32) PLC_ONE(Name##F64, form, kF64)
#define PLC_INTEGERS(Name, form) \
  PLC_ONE(Name##I8, form, kI8)   \
  PLC_ONE(Name##U8, form, kU8)   \
  PLC_ONE(Name##I16, form, kI16) \
  PLC_ONE(Name##U16, form, kU16) \
  PLC_ONE(Name##I32, form, kI32) \
  PLC_ONE(Name##U32, form, kU32) PLC_ONE(Name##I64, form, kI64) PLC_ONE(Name##U64, form, kU64)
#define PLC_COMPARISON(Name, suffix, type) \
  case ResolvedOp::k##Name##suffix:        \
    return {Form::kCompare, Type::type, Relation::k##Name};
#define PLC_EQUALITY(Name)       \
  PLC_COMPARISON(Name, 8, kU8)   \
  PLC_COMPARISON(Name, 16, kU16) \
  PLC_COMPARISON(Name, 32, kU32) \
  PLC_COMPARISON(Name, 64, kU64) PLC_COMPARISON(Name, F32, kF32) PLC_COMPARISON(Name, F64, kF64)
#define PLC_ORDER(Name)           \
  PLC_COMPARISON(Name, I8, kI8)   \
  PLC_COMPARISON(Name, U8, kU8)   \
  PLC_COMPARISON(Name, I16, kI16) \
  PLC_COMPARISON(Name, U16, kU16) \
  PLC_COMPARISON(Name, I32, kI32) \
  PLC_COMPARISON(Name, U32, kU32) \
  PLC_COMPARISON(Name, I64, kI64) \
  PLC_COMPARISON(Name, U64, kU64) PLC_COMPARISON(Name, F32, kF32) PLC_COMPARISON(Name, F64, kF64)
#define PLC_FUSED(Name)                                 \
  case ResolvedOp::k##Name##Unless: {                   \
    Operation jump = operation_of(ResolvedOp::k##Name); \
    jump.form = Form::kCompareJumpUnless;               \
    return jump;                                        \
  }                                                     \
  case ResolvedOp::k##Name##If: {                       \
    Operation jump = operation_of(ResolvedOp::k##Name); \
    jump.form = Form::kCompareJumpIf;                   \
    return jump;                                        \
  }
#define PLC_INDEXED(Name, form, type) \
  PLC_ONE(Name##I16, form, type) PLC_ONE(Name##I32, form, type) PLC_ONE(Name##Any, form, type)
  switch (op) {
    PLC_ONE(Return, kReturn, kU8)
    PLC_ONE(BlockStart, kBlockStart, kU8)
    PLC_ONE(ValueRun, kArranged, kU8)
    PLC_ONE(BlockRun, kArranged, kU8)
    PLC_ONE(BoolRun2, kArranged, kU8)
    PLC_ONE(Jump, kJump, kU8)
    PLC_ONE(CondJump, kJumpUnless, kU8)
    PLC_ONE(JumpIf, kJumpIf, kU8)
    PLC_ONE(LoopJump, kLoopJump, kU8)
    PLC_ONE(MoveBool, kMove, kU8)
    PLC_SIZES(Move, kMove)
    PLC_REALS(Move, kMove)
    PLC_ONE(MoveRef, kMove, kU64)
    PLC_ONE(Copy, kCopy, kU8)
    PLC_ONE(BoolRun4, kShortRecords4, kU8)
    PLC_ONE(BoolRun5, kShortRecords5, kU8)
    PLC_ONE(BoolRun, kGeneralRecords, kU8)
    PLC_ONE(RunTb, kRunBlock, kU8)
    PLC_ONE(RunTaskblock, kRunTaskblock, kU8)
    PLC_ONE(CallPouFixed, kCallFixed, kU8)
    PLC_ONE(EnterPou, kCallFixed, kU8)
    PLC_ONE(CallPou, kCallRelative, kU8)
    PLC_ONE(CallFn, kCallFunction, kU8)
    PLC_ONE(CallStd, kCallLibrary, kU8)
#define PLC_LIBRARY_OP(Name, meaning, Out, inputs, expression) PLC_ONE(Name, kCallLibrary, kU8)
#include "runtime/interpreter/library_ops.def"
    PLC_ONE(ClearEvent, kClearEvent, kU8)
    PLC_ONE(Eno, kEno, kU8)
    PLC_INDEXED(LoadAt8, kLoadElement, kU8)
    PLC_INDEXED(LoadAt16, kLoadElement, kU16)
    PLC_INDEXED(LoadAt32, kLoadElement, kU32)
    PLC_INDEXED(LoadAt64, kLoadElement, kU64)
    PLC_INDEXED(StoreAt8, kStoreElement, kU8)
    PLC_INDEXED(StoreAt16, kStoreElement, kU16)
    PLC_INDEXED(StoreAt32, kStoreElement, kU32)
    PLC_INDEXED(StoreAt64, kStoreElement, kU64)
    PLC_SIZES(LoadPath, kLoadPath)
    PLC_SIZES(StorePath, kStorePath)
    PLC_SIZES(Add, kAdd)
    PLC_REALS(Add, kAdd)
    PLC_SIZES(Sub, kSub)
    PLC_REALS(Sub, kSub)
    PLC_SIZES(Mul, kMul)
    PLC_REALS(Mul, kMul)
    PLC_INTEGERS(Div, kDiv)
    PLC_REALS(Div, kDiv)
    PLC_INTEGERS(Mod, kMod)
    PLC_SIZES(And, kAnd)
    PLC_SIZES(Or, kOr)
    PLC_SIZES(Xor, kXor)
    PLC_EQUALITY(Eq)
    PLC_EQUALITY(Ne)
    PLC_ORDER(Lt)
    PLC_ORDER(Le)
    PLC_ORDER(Gt)
    PLC_ORDER(Ge)
    case ResolvedOp::kSameRef:
      return {Form::kCompare, Type::kU64, Relation::kEq};
#define PLC_FUSED_JUMP(Name, T, expression) PLC_FUSED(Name)
#include "runtime/interpreter/fused_jumps.def"
      PLC_ONE(Extract, kExtract, kU8)
      PLC_ONE(Insert, kInsert, kU8)
      PLC_INTEGERS(Range, kRange)
    // Texts, structures, references: a call of the library outweighs what code of their own would save.
    case ResolvedOp::kMoveStr:
    case ResolvedOp::kMoveWstr:
    case ResolvedOp::kLoadAt:
    case ResolvedOp::kStoreAt:
    case ResolvedOp::kRefAt:
    case ResolvedOp::kRunAt:
    case ResolvedOp::kCallAt:
    case ResolvedOp::kLoadVia:
    case ResolvedOp::kStoreVia:
    case ResolvedOp::kRefVia:
    case ResolvedOp::kAdrAt:
    case ResolvedOp::kAdrVia:
    case ResolvedOp::kAdrPtr:
    case ResolvedOp::kLoadPtr:
    case ResolvedOp::kStorePtr:
    case ResolvedOp::kRefPtr:
    case ResolvedOp::kPtrTo32:
    case ResolvedOp::kPtrFrom32:
    case ResolvedOp::kRunVia:
    case ResolvedOp::kCallVia:
#define PLC_REFERENCED(Name)     \
  case ResolvedOp::k##Name:      \
  case ResolvedOp::k##Name##I16: \
  case ResolvedOp::k##Name##I32: \
  case ResolvedOp::k##Name##Any:
      PLC_REFERENCED(LoadVia8)
      PLC_REFERENCED(LoadVia16)
      PLC_REFERENCED(LoadVia32)
      PLC_REFERENCED(LoadVia64)
      PLC_REFERENCED(StoreVia8)
      PLC_REFERENCED(StoreVia16)
      PLC_REFERENCED(StoreVia32)
      PLC_REFERENCED(StoreVia64)
    // Of the interpreter alone.
    case ResolvedOp::kProbe:
    // Once in a scan, or between tasks.
    case ResolvedOp::kReadN:
    case ResolvedOp::kWriteN:
    case ResolvedOp::kWriteChangedN:
    case ResolvedOp::kRaisePriority:
    case ResolvedOp::kReschedule:
    case ResolvedOp::kLock:
    case ResolvedOp::kUnlock:
    case ResolvedOp::kQueuePut:
    case ResolvedOp::kQueueGet:
    case ResolvedOp::kQueueCount:
    case ResolvedOp::kQueueSpace:
    case ResolvedOp::kCount:
      break;
  }
  return {};
}

std::string_view name_of(ResolvedOp op) {
  static constexpr std::string_view kNames[] = {
#define PLC_OPCODE(Name, mnemonic, operands, events, cost, function, meaning) mnemonic,
#include "bytecode/opcodes.def"
#define PLC_INTERNAL_OP(Name, words, meaning) #Name,
#include "runtime/interpreter/internal_ops.def"
  };
  static_assert(std::size(kNames) == static_cast<std::size_t>(ResolvedOp::kCount));
  return kNames[static_cast<std::size_t>(op)];
}

}  // namespace plc::native
