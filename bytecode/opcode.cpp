#include "bytecode/opcode.h"

#include <cstddef>
#include <initializer_list>
#include <iterator>

namespace plc::bytecode {

namespace {

// The words of the `operands` column.
constexpr Operands ops(std::initializer_list<OperandSpec> specs = {}) {
  Operands operands;
  for (const OperandSpec& spec : specs) operands.specs[operands.count++] = spec;
  return operands;
}
template <class... Specs>
constexpr Operands ops(OperandSpec first, Specs... rest) {
  return ops({first, rest...});
}
constexpr OperandSpec in(RepMask reps) { return {OperandKind::kIn, reps}; }
constexpr OperandSpec out(RepMask reps) { return {OperandKind::kOut, reps}; }
constexpr OperandSpec place_in() { return {OperandKind::kPlaceIn, 0}; }
constexpr OperandSpec place_out() { return {OperandKind::kPlaceOut, 0}; }
constexpr OperandSpec place_inout() { return {OperandKind::kPlaceInOut, 0}; }
constexpr OperandSpec target() { return {OperandKind::kTarget, 0}; }
constexpr OperandSpec type() { return {OperandKind::kType, 0}; }
constexpr OperandSpec pou() { return {OperandKind::kPou, 0}; }
constexpr OperandSpec block() { return {OperandKind::kBlock, 0}; }
constexpr OperandSpec function() { return {OperandKind::kFunction, 0}; }
constexpr OperandSpec queue() { return {OperandKind::kQueue, 0}; }
constexpr OperandSpec global() { return {OperandKind::kGlobal, 0}; }
constexpr OperandSpec count() { return {OperandKind::kCount, 0}; }
constexpr OperandSpec imm() { return {OperandKind::kImm, 0}; }
constexpr OperandSpec base_in() { return {OperandKind::kBaseIn, 0}; }
constexpr OperandSpec base_out() { return {OperandKind::kBaseOut, 0}; }
constexpr OperandSpec value_in() { return {OperandKind::kValueIn, 0}; }
constexpr OperandSpec value_out() { return {OperandKind::kValueOut, 0}; }
constexpr OperandSpec path() { return {OperandKind::kPath, 0}; }
constexpr OperandSpec records() { return {OperandKind::kRecords, 0}; }
constexpr OperandSpec std_args() { return {OperandKind::kStdArgs, 0}; }
constexpr OperandSpec fn_args() { return {OperandKind::kFnArgs, 0}; }

constexpr auto kNever = Events::kNever;
constexpr auto kEvent = Events::kEvent;
constexpr auto kBudget = Events::kBudget;

constexpr OpcodeInfo kOpcodes[] = {
#define PLC_OPCODE(Name, mnemonic_, operands_, events_, cost_, function_, meaning_) \
  {#Name, mnemonic_, operands_, events_, function_, meaning_},
#include "bytecode/opcodes.def"
};

}  // namespace

std::span<const OpcodeInfo> opcodes() { return kOpcodes; }
const OpcodeInfo& info(Opcode opcode) { return kOpcodes[static_cast<std::size_t>(opcode)]; }

}  // namespace plc::bytecode
