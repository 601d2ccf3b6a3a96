// Boolean functions of up to five inputs, as expressions: what a truth table of a BOOL_RUN record says in ANDs, ORs and
// XORs, each input read once where that is possible.
//
// In: a truth table. Out: BooleanExpression. Does not belong here: operands, code.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace plc::native {

struct BooleanExpression {
  enum class Kind : std::uint8_t {
    kConstant,  ///< `negated` = TRUE
    kInput,     ///< number `input`, or its negation
    kAnd,       ///< of two or more children, none of which is a kAnd
    kOr,        ///< of two or more children, none of which is a kOr
    kXor,       ///< of two or more children, none of which is a kXor or negated; the whole may be
    kTable,     ///< bit (c0 + 2 c1 + 4 c2 ..) of `table`, of three to five children
  } kind = Kind::kConstant;
  bool negated = false;  ///< never for kAnd, kOr and kTable
  std::uint8_t input = 0;
  std::uint32_t table = 0;
  std::vector<BooleanExpression> children;

  [[nodiscard]] bool value(std::uint32_t inputs) const;
};

/// The opposite.
BooleanExpression negate(BooleanExpression expression);

/// Expression of the function of `inputs` inputs (0 .. 5) whose value for inputs i0, i1, .. is bit (i0 + 2 i1 + 4 i2
/// ..) of `truth`; higher bits do not count.
BooleanExpression expression_of(std::uint32_t truth, unsigned inputs);

/// Expressions that were asked for before: ladders repeat themselves.
class BooleanExpressions {
 public:
  const BooleanExpression& of(std::uint32_t truth, unsigned inputs);

 private:
  std::unordered_map<std::uint64_t, BooleanExpression> known_;
};

}  // namespace plc::native
