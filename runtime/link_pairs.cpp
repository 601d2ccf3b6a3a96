#include "runtime/link_pairs.h"

namespace plc::runtime {

std::optional<CountForm> count_form(ResolvedOp compares, ResolvedOp counts) {
#define PLC_COUNT_OP(Name, T, compare, goes_on, count, next)                     \
  if (compares == ResolvedOp::k##compare && counts == ResolvedOp::k##count) {    \
    return CountForm{ResolvedOp::k##Name, ResolvedOp::kRounds##Name, sizeof(T)}; \
  }
#include "runtime/count_ops.def"
  return std::nullopt;
}

std::optional<ResolvedOp> test_op(ResolvedOp masks, ResolvedOp compares) {
#define PLC_TEST_OP(Name, T, mask, compare, sign) \
  if (masks == ResolvedOp::k##mask && compares == ResolvedOp::k##compare) return ResolvedOp::k##Name;
#include "runtime/test_ops.def"
  return std::nullopt;
}

std::optional<ResolvedOp> when_op(ResolvedOp op) {
  switch (op) {
#define PLC_WHEN_OP(Name, T, expression) \
  case ResolvedOp::k##Name:              \
    return ResolvedOp::k##Name##When;
#include "runtime/when_ops.def"
    default:
      return std::nullopt;
  }
}

std::optional<ResolvedOp> feedback_op(ResolvedOp tests, ResolvedOp shifts, ResolvedOp mixes) {
#define PLC_FEEDBACK_OP(Name, T, test, shift, function, mix, sign)                                     \
  if (tests == ResolvedOp::k##test && shifts == ResolvedOp::k##shift && mixes == ResolvedOp::k##mix) { \
    return ResolvedOp::k##Name;                                                                        \
  }
#include "runtime/feedback_ops.def"
  return std::nullopt;
}

}  // namespace plc::runtime
