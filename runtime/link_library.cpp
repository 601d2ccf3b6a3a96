#include "runtime/link_library.h"

#include <string_view>

#include "core/types.h"

namespace plc::runtime {
namespace {

/// The instruction of a family (internal_ops.def: PLC_VALUE_OPS) for a representation, whose order rows have.
ResolvedOp of_rep(ResolvedOp first, core::Rep rep) {
  const auto number = rep == core::Rep::kBool ? core::Rep::kU8 : rep;
  return static_cast<ResolvedOp>(static_cast<std::uint32_t>(first) + static_cast<std::uint32_t>(number) -
                                 static_cast<std::uint32_t>(core::Rep::kI8));
}
static_assert(static_cast<std::uint32_t>(ResolvedOp::kMinF64) - static_cast<std::uint32_t>(ResolvedOp::kMinI8) ==
              static_cast<std::uint32_t>(core::Rep::kF64) - static_cast<std::uint32_t>(core::Rep::kI8));

ResolvedOp select_op(core::Rep rep) {
  switch (core::rep_bytes(rep)) {
    case 1:
      return ResolvedOp::kSelect8;
    case 2:
      return ResolvedOp::kSelect16;
    case 4:
      return ResolvedOp::kSelect32;
    default:
      return ResolvedOp::kSelect64;
  }
}

}  // namespace

ResolvedOp library_op(const stdlib::Overload& overload, std::uint32_t arguments) {
  const core::Rep rep = core::rep_of(overload.t);
  if (rep > core::Rep::kF64) return ResolvedOp::kCallStd;
  const std::string_view name = overload.spec->name;
  if (name == "SEL") return select_op(rep);
  if (name == "LIMIT") return of_rep(ResolvedOp::kLimitI8, rep);
  if (name == "MIN" && arguments == 2) return of_rep(ResolvedOp::kMinI8, rep);
  if (name == "MAX" && arguments == 2) return of_rep(ResolvedOp::kMaxI8, rep);
  return ResolvedOp::kCallStd;
}

}  // namespace plc::runtime
