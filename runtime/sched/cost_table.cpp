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
  static constexpr CostKind kKinds[] = {
#define PLC_OPCODE(Name, mnemonic, operands, events, cost, function, meaning) CostKind::cost,
#include "bytecode/opcodes.def"
  };
  return kKinds[static_cast<std::size_t>(opcode)];
}

Cost longer(const Cost& a, const Cost& b) { return {std::max(a.first, b.first), std::max(a.again, b.again)}; }

}  // namespace plc::runtime
