#include "runtime/value_runs.h"

#include <type_traits>
#include <utility>

#include "runtime/operations.h"
#include "runtime/repeat.h"
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

/// The same with operands that step through memory.
template <class Function, class Out, class... In, std::size_t... kIn>
void stream_values(const Stream& out, const Stream* const (&in)[3], std::uint32_t count,
                   std::index_sequence<kIn...> /*inputs*/) noexcept {
  if constexpr (sizeof...(In) == 2 && (std::is_same_v<Out, In> && ...)) {
    // A sum, or its like: in a register.
    if (out.step == 0 && in[0]->at == out.at && in[0]->step == 0 && in[1]->at != out.at) {
      Out value = load<Out>(out.at);
      const std::byte* other = in[1]->at;
#pragma GCC unroll 4
      for (; count != 0; --count, other += in[1]->step) value = Function{}(value, load<Out>(other));
      store(out.at, value);
      return;
    }
  }
  std::byte* to = out.at;
  const std::byte* from[] = {in[kIn]->at...};
  const std::ptrdiff_t step[] = {in[kIn]->step...};
  const std::ptrdiff_t out_step = out.step;
#pragma GCC unroll 4
  for (; count != 0; --count) {
    store<Out>(to, Function{}(load<In>(from[kIn])...));
    to += out_step;
    ((from[kIn] += step[kIn]), ...);
  }
}
template <class Function, class Out, class... In>
void stream(const Stream& out, const Stream& in0, const Stream& in1, const Stream& in2, std::uint32_t count) noexcept {
  stream_values<Function, Out, In...>(out, {&in0, &in1, &in2}, count, std::index_sequence_for<In...>{});
}

template <class Function, class Out, class... In>
constexpr ValueOp row(std::uint8_t first) {
  ValueOp op;
  op.stream = &stream<Function, Out, In...>;
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
#include "runtime/binary_ops.def"

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
#include "runtime/binary_ops.def"
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
#include "runtime/convert_ops.def"
#define PLC_SELECT(Name, T) at(ResolvedOp::k##Name) = row<Select, T, std::uint8_t, T, T>(kLibraryOut);
  PLC_SELECT(Select8, std::uint8_t)
  PLC_SELECT(Select16, std::uint16_t)
  PLC_SELECT(Select32, std::uint32_t)
  PLC_SELECT(Select64, std::uint64_t)
  return rows;
}

template <class T, bool kDown>
void count_rounds(const Stream& out, const Stream& in0, const Stream& in1, const Stream& /*in2*/,
                  std::uint32_t count) noexcept {
  T value = load<T>(in0.at);
  const T step = load<T>(in1.at);
  std::byte* to = out.at;
  for (; count != 0; --count, to += out.step) {
    store(to, value);
    value = kDown ? stdlib::wrap_sub(value, step) : stdlib::wrap_add(value, step);
  }
}

template <class T>
void add_products(const Stream& out, const Stream& in0, const Stream& in1, const Stream& in2,
                  std::uint32_t count) noexcept {
  T sum = load<T>(out.at);
  T product{};
  const std::byte* a = in0.at;
  const std::byte* b = in1.at;
  const std::ptrdiff_t a_step = in0.step, b_step = in1.step;
  // A sum that is NaN stays NaN: one look at the end is enough.
  const auto add = [&sum, &product](const std::byte* x, const std::byte* y) {
    if constexpr (std::is_floating_point_v<T>) {
      product = load<T>(x) * load<T>(y);
      sum += product;
    } else {
      product = stdlib::mul(load<T>(x), load<T>(y));
      sum = stdlib::add(sum, product);
    }
  };
  // Four rounds at a time. What is left over comes first: nothing of a and b is needed behind the others.
  for (; (count & 3u) != 0; --count, a += a_step, b += b_step) add(a, b);
  for (; count != 0; count -= 4, a += 4 * a_step, b += 4 * b_step) {
    add(a, b);
    add(a + a_step, b + b_step);
    add(a + 2 * a_step, b + 2 * b_step);
    add(a + 3 * a_step, b + 3 * b_step);
  }
  if constexpr (std::is_floating_point_v<T>) {
    sum = stdlib::canonical(sum);
    product = stdlib::canonical(product);
  }
  store(out.at, sum);
  store(in2.at, product);
}

}  // namespace

StreamRun counting(bool wide, bool down) {
  if (wide) return down ? &count_rounds<std::uint32_t, true> : &count_rounds<std::uint32_t, false>;
  return down ? &count_rounds<std::uint16_t, true> : &count_rounds<std::uint16_t, false>;
}

StreamRun sum_of_products(StreamRun product, StreamRun sum) {
  struct Pair {
    ResolvedOp product, sum;
    StreamRun both;
  };
  static constexpr Pair kPairs[] = {{ResolvedOp::kMulF32, ResolvedOp::kAddF32, &add_products<float>},
                                    {ResolvedOp::kMulF64, ResolvedOp::kAddF64, &add_products<double>},
                                    {ResolvedOp::kMul32, ResolvedOp::kAdd32, &add_products<std::uint32_t>},
                                    {ResolvedOp::kMul16, ResolvedOp::kAdd16, &add_products<std::uint16_t>}};
  for (const Pair& pair : kPairs) {
    if (value_op(pair.product)->stream == product && value_op(pair.sum)->stream == sum) return pair.both;
  }
  return nullptr;
}

const ValueOp* value_op(ResolvedOp op) {
  static const Rows kRows = make_rows();
  const ValueOp& row = kRows[static_cast<std::size_t>(op)];
  return row.inputs == 0 ? nullptr : &row;
}

}  // namespace plc::runtime
