#include "bytecode/codegen/select.h"

#include <map>
#include <string_view>
#include <utility>

namespace plc::bytecode {
namespace {

/// (function, representation of the operands) -> opcode, of the rows out, in, in.
std::map<std::pair<std::string_view, Rep>, Opcode> make_table() {
  std::map<std::pair<std::string_view, Rep>, Opcode> table;
  const std::span<const OpcodeInfo> rows = opcodes();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const OpcodeInfo& row = rows[i];
    if (row.function.empty() || row.operands.count != 3) continue;
    for (std::size_t r = 0; r < core::kRepCount; ++r) {
      const Rep rep = static_cast<Rep>(r);
      if ((row.operands.specs[1].reps & mask_of(rep)) == 0) continue;
      // Rows such as ADD_16 take both signs: the bits of the result are the same.
      table.emplace(std::pair{row.function, rep}, static_cast<Opcode>(i));
    }
  }
  return table;
}

bool compares(std::string_view name) {
  for (const std::string_view n : {"EQ", "NE", "LT", "LE", "GT", "GE"}) {
    if (name == n) return true;
  }
  return false;
}

}  // namespace

std::optional<Opcode> opcode_for(const stdlib::Overload& overload) {
  static const auto kTable = make_table();
  const stdlib::FunctionSpec& spec = *overload.spec;
  const core::TypeId type = overload.param_type(0);
  // Rows work on two operands of one type. Times and dates take part only where their numbers are what counts.
  if (overload.param_type(1) != type) return std::nullopt;
  if (!compares(spec.name)) {
    if (overload.result_type() != type) return std::nullopt;
    const bool sum = spec.name == "ADD" || spec.name == "SUB";
    const bool plain = core::in_category(type, core::kAnyNum | core::kAnyBit);
    if (!plain && !(sum && core::in_category(type, core::kAnyDuration))) return std::nullopt;
  }
  const auto it = kTable.find({spec.name, core::rep_of(type)});
  return it == kTable.end() ? std::nullopt : std::optional(it->second);
}

Opcode move_for(core::Rep rep) {
  switch (rep) {
    case Rep::kBool:
      return Opcode::kMoveBool;
    case Rep::kI8:
    case Rep::kU8:
      return Opcode::kMove8;
    case Rep::kI16:
    case Rep::kU16:
      return Opcode::kMove16;
    case Rep::kI32:
    case Rep::kU32:
      return Opcode::kMove32;
    case Rep::kI64:
    case Rep::kU64:
      return Opcode::kMove64;
    case Rep::kF32:
      return Opcode::kMoveF32;
    case Rep::kF64:
      return Opcode::kMoveF64;
    case Rep::kStr:
      return Opcode::kMoveStr;
    case Rep::kWstr:
      return Opcode::kMoveWstr;
    case Rep::kRef:
      break;
  }
  return Opcode::kMoveRef;
}

Opcode range_for(core::Rep rep) {
  switch (rep) {
    case Rep::kI8:
      return Opcode::kRangeI8;
    case Rep::kU8:
      return Opcode::kRangeU8;
    case Rep::kI16:
      return Opcode::kRangeI16;
    case Rep::kU16:
      return Opcode::kRangeU16;
    case Rep::kI32:
      return Opcode::kRangeI32;
    case Rep::kU32:
      return Opcode::kRangeU32;
    case Rep::kI64:
      return Opcode::kRangeI64;
    default:
      return Opcode::kRangeU64;
  }
}

}  // namespace plc::bytecode
