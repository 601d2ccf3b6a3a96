#include "runtime/sched/cost_table.h"

#include <algorithm>

namespace plc::runtime {
namespace {

using bytecode::Opcode;

constexpr CostInfo kInfos[] = {
#define PLC_COST(Name, key, unit, meaning) {key, unit, meaning},
#include "runtime/sched/costs.def"
};

}  // namespace

const CostInfo& info(CostKind kind) { return kInfos[static_cast<std::size_t>(kind)]; }

CostKind cost_kind(Opcode opcode) {
  const std::string_view function = bytecode::info(opcode).function;
  if (function == "DIV" || function == "MOD") return CostKind::kDivide;
  if (!function.empty()) return CostKind::kCompute;
  // What implements no standard function is named here, every one.
  switch (opcode) {
    case Opcode::kReturn:
    case Opcode::kJump:
    case Opcode::kLoopJump:
      return CostKind::kJump;
    case Opcode::kCondJump:
    case Opcode::kJumpIf:
      return CostKind::kBranch;
    case Opcode::kMoveBool:
    case Opcode::kMove8:
    case Opcode::kMove16:
    case Opcode::kMove32:
    case Opcode::kMove64:
    case Opcode::kMoveF32:
    case Opcode::kMoveF64:
    case Opcode::kMoveRef:
    case Opcode::kClearEvent:
    case Opcode::kEno:
    case Opcode::kExtract:
    case Opcode::kInsert:
    case Opcode::kQueueCount:
    case Opcode::kQueueSpace:
      return CostKind::kMove;
    case Opcode::kRangeI8:
    case Opcode::kRangeU8:
    case Opcode::kRangeI16:
    case Opcode::kRangeU16:
    case Opcode::kRangeI32:
    case Opcode::kRangeU32:
    case Opcode::kRangeI64:
    case Opcode::kRangeU64:
    case Opcode::kSameRef:
      return CostKind::kCompute;
    case Opcode::kMoveStr:
    case Opcode::kMoveWstr:
    case Opcode::kCopy:
    case Opcode::kQueuePut:
    case Opcode::kQueueGet:
      return CostKind::kCopy;
    case Opcode::kRunTb:
      return CostKind::kBlock;
    case Opcode::kCallPou:
      return CostKind::kCall;
    case Opcode::kCallFn:
      return CostKind::kFunction;
    case Opcode::kCallStd:
      return CostKind::kStandard;
    case Opcode::kLoadAt:
    case Opcode::kStoreAt:
    case Opcode::kRefAt:
    case Opcode::kRunAt:
    case Opcode::kCallAt:
    case Opcode::kLoadVia:
    case Opcode::kStoreVia:
    case Opcode::kRefVia:
    case Opcode::kRunVia:
    case Opcode::kCallVia:
      return CostKind::kAccess;
    case Opcode::kReadN:
      return CostKind::kImport;
    case Opcode::kWriteN:
    case Opcode::kWriteChangedN:
      return CostKind::kExport;
    case Opcode::kRaisePriority:
    case Opcode::kReschedule:
      return CostKind::kPriority;
    case Opcode::kLock:
    case Opcode::kUnlock:
      return CostKind::kLock;
    default:
      return CostKind::kCount;
  }
}

Cost longer(const Cost& a, const Cost& b) { return {std::max(a.first, b.first), std::max(a.again, b.again)}; }

}  // namespace plc::runtime
