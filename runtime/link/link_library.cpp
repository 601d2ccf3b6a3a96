#include "runtime/link/link_library.h"

#include <bit>
#include <string_view>
#include <type_traits>

#include "core/types.h"

namespace plc::runtime {
namespace {

/// Of four instructions for values of 1, 2, 4 and 8 bytes, the first of which is `first`, that for `bytes`.
ResolvedOp of_size(ResolvedOp first, std::uint32_t bytes) {
  return static_cast<ResolvedOp>(static_cast<std::uint32_t>(first) +
                                 static_cast<std::uint32_t>(std::countr_zero(bytes)));
}
static_assert(static_cast<std::uint32_t>(ResolvedOp::kSelect64) ==
              static_cast<std::uint32_t>(ResolvedOp::kSelect8) + 3);

/// The instruction of a family (internal_ops.def: PLC_VALUE_OPS) for a representation, whose order rows have.
ResolvedOp of_rep(ResolvedOp first, core::Rep rep) {
  const auto number = rep == core::Rep::kBool ? core::Rep::kU8 : rep;
  return static_cast<ResolvedOp>(static_cast<std::uint32_t>(first) + static_cast<std::uint32_t>(number) -
                                 static_cast<std::uint32_t>(core::Rep::kI8));
}
static_assert(static_cast<std::uint32_t>(ResolvedOp::kMinF64) - static_cast<std::uint32_t>(ResolvedOp::kMinI8) ==
              static_cast<std::uint32_t>(core::Rep::kF64) - static_cast<std::uint32_t>(core::Rep::kI8));

/// A conversion from `t` to `u`. A CALL_STD when it does more than compute, or is rare.
ResolvedOp conversion_op(core::TypeId t, core::TypeId u) {
  struct Row {
    ResolvedOp op;
    bool is_signed, real;
    std::uint32_t from, to;  ///< bytes
  };
  static constexpr Row kRows[] = {
#define PLC_CONVERT_OP(Name, From, To) \
  {ResolvedOp::k##Name, std::is_signed_v<From>, std::is_floating_point_v<To>, sizeof(From), sizeof(To)},
#include "runtime/interpreter/convert_ops.def"
  };
  constexpr std::uint16_t kWhole = core::kAnyInt | core::kAnyBit;
  const auto is_whole = [](core::TypeId id) { return core::in_category(id, kWhole) && id != core::TypeId::kBool; };
  const bool real = core::in_category(u, core::kAnyReal);
  if (!is_whole(t) || (!is_whole(u) && !real)) return ResolvedOp::kCallStd;
  const std::uint32_t from = core::rep_bytes(core::rep_of(t)), to = core::rep_bytes(core::rep_of(u));
  const bool widens = real || from < to;
  for (const Row& row : kRows) {
    if (row.from != from || row.to != to || row.real != real) continue;
    if (!widens || row.is_signed == core::in_category(t, core::kAnySigned)) return row.op;
  }
  return ResolvedOp::kCallStd;
}

}  // namespace

ResolvedOp library_op(const stdlib::Overload& overload, std::uint32_t arguments, bool known_places) {
  const core::Rep rep = core::rep_of(overload.t);
  if (rep > core::Rep::kF64) return ResolvedOp::kCallStd;
  const std::string_view name = overload.spec->name;
  if (known_places && overload.t != core::TypeId::kBool) {
    if (name == "SHL") return of_size(ResolvedOp::kShl8, core::rep_bytes(rep));
    if (name == "SHR") return of_size(ResolvedOp::kShr8, core::rep_bytes(rep));
    if (name == "ROL") return of_size(ResolvedOp::kRol8, core::rep_bytes(rep));
    if (name == "ROR") return of_size(ResolvedOp::kRor8, core::rep_bytes(rep));
  }
  if (name == "*_TO_*" || name == "TO_*") return conversion_op(overload.t, overload.u);
  if (name == "SEL") return of_size(ResolvedOp::kSelect8, core::rep_bytes(rep));
  if (name == "LIMIT") return of_rep(ResolvedOp::kLimitI8, rep);
  if (name == "MIN" && arguments == 2) return of_rep(ResolvedOp::kMinI8, rep);
  if (name == "MAX" && arguments == 2) return of_rep(ResolvedOp::kMaxI8, rep);
  return ResolvedOp::kCallStd;
}

}  // namespace plc::runtime
