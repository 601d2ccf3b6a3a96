// SIZEOF and TIME(): what CODESYS and TwinCAT ask of the machine, answered the same on every one; its date and time.
#include <algorithm>
#include <iterator>

#include "core/text.h"
#include "frontend-st/lowering.h"
#include "frontend-st/static_type.h"

namespace plc::st {

using core::Code;
using ir::Operand;

std::optional<Operand> Lowering::call_sizeof(NodeId id) {
  const NodeId argument = node(id).b;
  if (argument == kNoNode || node(argument).next != kNoNode || node(argument).argument != ArgumentKind::kPositional) {
    report(Code::P4010, at(id), "SIZEOF takes one variable or type");
    return std::nullopt;
  }
  std::string problem;
  const auto size = size_of_named(ast_, source_, node(argument).a, builder_.module(), &builder_.pou(), problem);
  if (!size) {
    report(Code::P4056, at(argument), "SIZEOF: " + problem, "give it a variable or type without function blocks in it");
    return std::nullopt;
  }
  report(Code::P4352, at(id),
         "SIZEOF is not in the standard; " + std::string(text(id)) + " is " + std::to_string(*size) + " in CODESYS",
         "write the number, or LOWER_BOUND and UPPER_BOUND for lengths of arrays");
  Operand out;
  out.kind = Operand::Kind::kIntLiteral;
  out.int_value = static_cast<std::int64_t>(*size);
  out.at = at(id);
  out.text = std::string(text(id));
  return out;
}

// The hidden instance holds nothing from scan to scan: it is in frames of functions, too.
std::optional<Operand> Lowering::call_uptime(NodeId id) {
  report(Code::P4353, at(id), std::string(text(id)) + ", the time since the start, is not in the standard",
         "measure times with TON");
  const stdlib::BlockSpec* const spec = stdlib::block_named("UPTIME");
  const ir::PlaceId clock = builder_.variable(builder_.hidden("uptime", types().block(*spec)));
  builder_.run(clock);
  const Operand time = operand(builder_.load(builder_.field(clock, 0)), id);
  if (core::iequals(name_text(node(id).a), "TIME")) return time;
  const auto wide = builder_.convert(time, ir::ref_of(core::TypeId::kLtime), "LTIME()");
  return wide ? std::optional(operand(*wide, id)) : std::nullopt;
}

// A hidden instance, as for the time since the start.
std::optional<Operand> Lowering::call_sys_time(NodeId id, std::string_view name) {
  struct Row {
    std::string_view name;
    std::string_view output;  ///< of SYS_TIME
    bool wide;                ///< LDT
  };
  static constexpr Row kRows[] = {
      {"UTC_DT", "UTC", false}, {"UTC_LDT", "UTC", true}, {"LOCAL_DT", "LOCAL", false}, {"LOCAL_LDT", "LOCAL", true}};
  const auto row = std::find_if(std::begin(kRows), std::end(kRows),
                                [name](const Row& one) { return core::iequals(one.name, name); });
  if (row == std::end(kRows)) return std::nullopt;
  const ir::PlaceId clock =
      builder_.variable(builder_.hidden("sys_time", types().block(*stdlib::block_named("SYS_TIME"))));
  builder_.run(clock);
  const Operand time = operand(builder_.load(*builder_.member(clock, row->output)), id);
  if (!row->wide) return time;
  const auto wide = builder_.convert(time, ir::ref_of(core::TypeId::kLdt), std::string(name) + "()");
  return wide ? std::optional(operand(*wide, id)) : std::nullopt;
}

}  // namespace plc::st
