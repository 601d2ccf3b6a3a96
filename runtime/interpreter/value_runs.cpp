#include "runtime/interpreter/value_runs.h"

#include "runtime/interpreter/repeat.h"
#include "runtime/interpreter/value_ops.h"

namespace plc::runtime {
namespace {

template <Addressing kAddressing, class Op>
const std::uint32_t* run(std::byte* table, std::uint32_t instance, const std::uint32_t* records,
                         std::uint32_t count) noexcept {
  return repeat<1 + kInputs<Op>>(
      records, count, [ table, instance ](const std::uint32_t* record) __attribute__((always_inline)) {
        compute<Op>(
            record, [ table, instance ](std::uint32_t operand)
                        __attribute__((always_inline)) { return place<kAddressing>(table, instance, operand); });
      });
}

template <class Op, class Out, class... In>
constexpr ValueOp row(std::uint8_t first, Out (* /*of*/)(In...) noexcept) {
  ValueOp op;
  op.run[0] = &run<Addressing::kFixed, Op>;
  op.run[1] = &run<Addressing::kRelative, Op>;
  op.first = first;
  op.inputs = sizeof...(In);
  op.out_bytes = sizeof(Out);
  std::size_t i = 0;
  ((op.in_bytes[i++] = sizeof(In)), ...);
  return op;
}
template <class Op>
constexpr ValueOp row(std::uint8_t first) {
  return row<Op>(first, &Op::of);
}
static_assert(static_cast<int>(Addressing::kFixed) == 0 && static_cast<int>(Addressing::kRelative) == 1);

/// The word that is the result of a function of the library, see CALL_STD.
constexpr std::uint8_t kLibraryOut = 4;

using Rows = std::array<ValueOp, static_cast<std::size_t>(ResolvedOp::kCount)>;

Rows make_rows() {
  Rows rows{};
  const auto at = [&rows](ResolvedOp op) -> ValueOp& { return rows[static_cast<std::size_t>(op)]; };
#define PLC_VALUE_OP(Name, Result, inputs, expression) at(ResolvedOp::k##Name) = row<value::Name>(1);
#include "runtime/interpreter/value_ops.def"
#define PLC_LIBRARY_OP(Name, meaning, Out, inputs, expression) at(ResolvedOp::k##Name) = row<value::Name>(kLibraryOut);
#include "runtime/interpreter/library_ops.def"
  return rows;
}

}  // namespace

const ValueOp* value_op(ResolvedOp op) {
  static const Rows kRows = make_rows();
  const ValueOp& row = kRows[static_cast<std::size_t>(op)];
  return row.inputs == 0 ? nullptr : &row;
}

}  // namespace plc::runtime
