// Value ops: what instructions compute that do nothing else, one type each, named as the instruction.
//
// In: values. Out: the value of the result, `of()`. For the interpreter's handlers and its runs (value_runs.h), which
// so compute the same. RT. Does not belong here: where operands lie.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#include "runtime/interpreter/operations.h"
#include "stdlib/arithmetic.h"

namespace plc::runtime {

namespace value {
#define PLC_VALUE_OP(Name, Result, inputs, expression)                           \
  struct Name {                                                                  \
    static Result of inputs noexcept { return static_cast<Result>(expression); } \
  };
#include "runtime/interpreter/value_ops.def"
#define PLC_LIBRARY_OP(Name, meaning, Out, inputs, expression) \
  struct Name {                                                \
    static Out of inputs noexcept { return expression; }       \
  };
#include "runtime/interpreter/library_ops.def"
}  // namespace value

/// Words: the operand of the result, then those of the inputs. `at`: the place of an operand.
template <class Op, class Out, class... In, class At, std::size_t... kInput>
[[gnu::always_inline]] inline void compute(Out (* /*of*/)(In...) noexcept, const std::uint32_t* words, At at,
                                           std::index_sequence<kInput...> /*inputs*/) noexcept {
  store<Out>(at(words[0]), Op::of(load<In>(at(words[1 + kInput]))...));
}
template <class Out, class... In>
constexpr std::size_t inputs_of(Out (* /*of*/)(In...) noexcept) {
  return sizeof...(In);
}
template <class Op>
inline constexpr std::size_t kInputs = inputs_of(&Op::of);
template <class Op, class At>
[[gnu::always_inline]] inline void compute(const std::uint32_t* words, At at) noexcept {
  compute<Op>(&Op::of, words, at, std::make_index_sequence<kInputs<Op>>{});
}

}  // namespace plc::runtime
