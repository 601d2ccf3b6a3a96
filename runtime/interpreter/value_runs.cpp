#include "runtime/interpreter/value_runs.h"

#include <type_traits>
#include <utility>

#include "runtime/interpreter/operations.h"
#include "runtime/interpreter/repeat.h"
#include "stdlib/arithmetic.h"

namespace plc::runtime {
namespace {

/// `Function`: the result of inputs of the types `In`, whose operands are words 1, 2, .. of a record.
template <Addressing kAddressing, class Function, class Out, class... In, std::size_t... kWord>
const std::uint32_t* run_records(std::byte* table, std::uint32_t instance, const std::uint32_t* records,
                                 std::uint32_t count, std::index_sequence<kWord...> /*words*/) noexcept {
  return repeat<1 + sizeof...(In)>(
      records, count, [ table, instance ](const std::uint32_t* record) __attribute__((always_inline)) {
        store<Out>(place<kAddressing>(table, instance, record[0]),
                   Function{}(load<In>(place<kAddressing>(table, instance, record[1 + kWord]))...));
      });
}
template <Addressing kAddressing, class Function, class Out, class... In>
const std::uint32_t* run(std::byte* table, std::uint32_t instance, const std::uint32_t* records,
                         std::uint32_t count) noexcept {
  return run_records<kAddressing, Function, Out, In...>(table, instance, records, count,
                                                        std::index_sequence_for<In...>{});
}

template <class Function, class Out, class... In>
constexpr ValueOp row(std::uint8_t first) {
  ValueOp op;
  op.run[0] = &run<Addressing::kFixed, Function, Out, In...>;
  op.run[1] = &run<Addressing::kRelative, Function, Out, In...>;
  op.first = first;
  op.inputs = sizeof...(In);
  op.out_bytes = sizeof(Out);
  std::size_t i = 0;
  ((op.in_bytes[i++] = sizeof(In)), ...);
  return op;
}
static_assert(static_cast<int>(Addressing::kFixed) == 0 && static_cast<int>(Addressing::kRelative) == 1);

struct Same {
  template <class T>
  T operator()(T value) const noexcept {
    return value;
  }
};
template <class To>
struct Converted {
  template <class From>
  To operator()(From value) const noexcept {
    return static_cast<To>(value);
  }
};
struct Least {
  template <class T>
  T operator()(T a, T b) const noexcept {
    return stdlib::least(a, b);
  }
};
struct Greatest {
  template <class T>
  T operator()(T a, T b) const noexcept {
    return stdlib::greatest(a, b);
  }
};
struct Limit {
  template <class T>
  T operator()(T least, T value, T greatest) const noexcept {
    return stdlib::limit(least, value, greatest);
  }
};
struct Select {
  template <class T>
  T operator()(std::uint8_t g, T in0, T in1) const noexcept {
    return g != 0 ? in1 : in0;
  }
};
#define PLC_PLACES(Name, function)                         \
  struct Name {                                            \
    template <class T>                                     \
    T operator()(T value, std::uint8_t n) const noexcept { \
      return function(value, n);                           \
    }                                                      \
  };
PLC_PLACES(Shl, shift_left)
PLC_PLACES(Shr, shift_right)
PLC_PLACES(Rol, stdlib::rotate_left)
PLC_PLACES(Ror, stdlib::rotate_right)
#define PLC_BINARY_OP(Name, T, Result, expression)                                         \
  struct Name {                                                                            \
    Result operator()(T a, T b) const noexcept { return static_cast<Result>(expression); } \
  };
#include "runtime/interpreter/binary_ops.def"

/// The word that is the result of a function of the library, see CALL_STD.
constexpr std::uint8_t kLibraryOut = 4;

using Rows = std::array<ValueOp, static_cast<std::size_t>(ResolvedOp::kCount)>;

Rows make_rows() {
  Rows rows{};
  const auto at = [&rows](ResolvedOp op) -> ValueOp& { return rows[static_cast<std::size_t>(op)]; };
#define PLC_MOVE(Name, T) at(ResolvedOp::k##Name) = row<Same, T, T>(1);
  PLC_MOVE(MoveBool, std::uint8_t)
  PLC_MOVE(Move8, std::uint8_t)
  PLC_MOVE(Move16, std::uint16_t)
  PLC_MOVE(Move32, std::uint32_t)
  PLC_MOVE(Move64, std::uint64_t)
  PLC_MOVE(MoveF32, std::uint32_t)
  PLC_MOVE(MoveF64, std::uint64_t)
  PLC_MOVE(MoveRef, std::uint64_t)
#define PLC_BINARY_OP(Name, T, Result, expression) at(ResolvedOp::k##Name) = row<Name, Result, T, T>(1);
#include "runtime/interpreter/binary_ops.def"
#define PLC_CHOICES(R, T)                                        \
  at(ResolvedOp::kMin##R) = row<Least, T, T, T>(kLibraryOut);    \
  at(ResolvedOp::kMax##R) = row<Greatest, T, T, T>(kLibraryOut); \
  at(ResolvedOp::kLimit##R) = row<Limit, T, T, T, T>(kLibraryOut);
  PLC_CHOICES(I8, std::int8_t)
  PLC_CHOICES(U8, std::uint8_t)
  PLC_CHOICES(I16, std::int16_t)
  PLC_CHOICES(U16, std::uint16_t)
  PLC_CHOICES(I32, std::int32_t)
  PLC_CHOICES(U32, std::uint32_t)
  PLC_CHOICES(I64, std::int64_t)
  PLC_CHOICES(U64, std::uint64_t)
  PLC_CHOICES(F32, float)
  PLC_CHOICES(F64, double)
#define PLC_PLACES_OPS(Name)                                                                        \
  at(ResolvedOp::k##Name##8) = row<Name, std::uint8_t, std::uint8_t, std::uint8_t>(kLibraryOut);    \
  at(ResolvedOp::k##Name##16) = row<Name, std::uint16_t, std::uint16_t, std::uint8_t>(kLibraryOut); \
  at(ResolvedOp::k##Name##32) = row<Name, std::uint32_t, std::uint32_t, std::uint8_t>(kLibraryOut); \
  at(ResolvedOp::k##Name##64) = row<Name, std::uint64_t, std::uint64_t, std::uint8_t>(kLibraryOut);
  PLC_PLACES_OPS(Shl)
  PLC_PLACES_OPS(Shr)
  PLC_PLACES_OPS(Rol)
  PLC_PLACES_OPS(Ror)
#define PLC_CONVERT_OP(Name, From, To) at(ResolvedOp::k##Name) = row<Converted<To>, To, From>(kLibraryOut);
#include "runtime/interpreter/convert_ops.def"
#define PLC_SELECT(Name, T) at(ResolvedOp::k##Name) = row<Select, T, std::uint8_t, T, T>(kLibraryOut);
  PLC_SELECT(Select8, std::uint8_t)
  PLC_SELECT(Select16, std::uint16_t)
  PLC_SELECT(Select32, std::uint32_t)
  PLC_SELECT(Select64, std::uint64_t)
  return rows;
}

}  // namespace

const ValueOp* value_op(ResolvedOp op) {
  static const Rows kRows = make_rows();
  const ValueOp& row = kRows[static_cast<std::size_t>(op)];
  return row.inputs == 0 ? nullptr : &row;
}

}  // namespace plc::runtime
