#include "native/boolean_function.h"

#include <optional>
#include <utility>

namespace plc::native {
namespace {

using Kind = BooleanExpression::Kind;

/// A function while it is taken apart: its inputs are expressions themselves.
struct Function {
  std::uint32_t truth = 0;
  std::vector<BooleanExpression> inputs;

  [[nodiscard]] unsigned count() const { return static_cast<unsigned>(inputs.size()); }
  [[nodiscard]] std::uint32_t all() const {
    return inputs.size() == 5 ? 0xffffffffu : (1u << (1u << inputs.size())) - 1;
  }
};

/// Truth table of the other inputs when input `at` has this value.
std::uint32_t cofactor(std::uint32_t truth, unsigned count, unsigned at, unsigned value) {
  std::uint32_t result = 0;
  for (std::uint32_t row = 0; row < 1u << (count - 1); ++row) {
    const std::uint32_t below = row & ((1u << at) - 1);
    const std::uint32_t whole = below | value << at | (row >> at) << (at + 1);
    result |= (truth >> whole & 1u) << row;
  }
  return result;
}

Function without(const Function& f, unsigned at, std::uint32_t truth) {
  Function rest{truth, f.inputs};
  rest.inputs.erase(rest.inputs.begin() + at);
  return rest;
}

/// The two joined; chains of one operation become one.
BooleanExpression join(Kind kind, BooleanExpression a, BooleanExpression b) {
  BooleanExpression whole;
  whole.kind = kind;
  for (BooleanExpression* part : {&a, &b}) {
    if (kind == Kind::kXor) {
      whole.negated = whole.negated != part->negated;
      part->negated = false;
    }
    if (part->kind == kind) {
      for (BooleanExpression& child : part->children) whole.children.push_back(std::move(child));
    } else {
      whole.children.push_back(std::move(*part));
    }
  }
  return whole;
}

/// A function of two inputs that depends on both; bit (a + 2 b) of `truth`.
BooleanExpression of_two(std::uint32_t truth, const BooleanExpression& a, const BooleanExpression& b) {
  switch (truth) {
    case 0b1000:
      return join(Kind::kAnd, a, b);
    case 0b0100:
      return join(Kind::kAnd, negate(a), b);
    case 0b0010:
      return join(Kind::kAnd, a, negate(b));
    case 0b0001:
      return join(Kind::kAnd, negate(a), negate(b));
    case 0b1110:
      return join(Kind::kOr, a, b);
    case 0b1101:
      return join(Kind::kOr, negate(a), b);
    case 0b1011:
      return join(Kind::kOr, a, negate(b));
    case 0b0111:
      return join(Kind::kOr, negate(a), negate(b));
    case 0b0110:
      return join(Kind::kXor, a, b);
    default:
      return negate(join(Kind::kXor, a, b));
  }
}

/// Two inputs through which the function depends on one bit only become one input.
bool join_a_pair(Function& f) {
  for (unsigned b = 1; b < f.count(); ++b) {
    for (unsigned a = 0; a < b; ++a) {
      std::uint32_t quarter[4];
      for (unsigned row = 0; row < 4; ++row) {
        quarter[row] = cofactor(cofactor(f.truth, f.count(), b, row >> 1), f.count() - 1, a, row & 1);
      }
      std::optional<std::uint32_t> other;
      std::uint32_t pair = 0;  // truth table of the bit; 0 where the quarter is the first one
      bool two = true;
      for (unsigned row = 1; row < 4; ++row) {
        if (quarter[row] == quarter[0]) continue;
        if (!other) other = quarter[row];
        two = two && *other == quarter[row];
        pair |= 1u << row;
      }
      if (!two || !other) continue;
      Function joined = without(without(f, b, 0), a, 0);
      joined.truth = quarter[0] | *other << (1u << joined.count());
      joined.inputs.push_back(of_two(pair, f.inputs[a], f.inputs[b]));
      f = std::move(joined);
      return true;
    }
  }
  return false;
}

BooleanExpression take_apart(Function f) {
  f.truth &= f.all();
  // Inputs that do not matter.
  for (unsigned at = f.count(); at-- > 0;) {
    const std::uint32_t when_false = cofactor(f.truth, f.count(), at, 0);
    if (when_false == cofactor(f.truth, f.count(), at, 1)) f = without(f, at, when_false);
  }
  if (f.count() == 0) {
    BooleanExpression constant;
    constant.negated = f.truth != 0;
    return constant;
  }
  if (f.count() == 1) return f.truth == 0b10 ? f.inputs[0] : negate(f.inputs[0]);
  if (f.count() == 2) return of_two(f.truth, f.inputs[0], f.inputs[1]);
  // One input on its own: x AND rest, x OR rest, x XOR rest.
  for (unsigned at = 0; at < f.count(); ++at) {
    const std::uint32_t when_false = cofactor(f.truth, f.count(), at, 0);
    const std::uint32_t when_true = cofactor(f.truth, f.count(), at, 1);
    const std::uint32_t all = without(f, at, 0).all();
    const auto rest = [&](std::uint32_t truth) { return take_apart(without(f, at, truth)); };
    if (when_false == 0) return join(Kind::kAnd, f.inputs[at], rest(when_true));
    if (when_true == 0) return join(Kind::kAnd, negate(f.inputs[at]), rest(when_false));
    if (when_false == all) return join(Kind::kOr, negate(f.inputs[at]), rest(when_true));
    if (when_true == all) return join(Kind::kOr, f.inputs[at], rest(when_false));
    if ((when_true ^ when_false) == all) return join(Kind::kXor, f.inputs[at], rest(when_false));
  }
  if (join_a_pair(f)) return take_apart(std::move(f));
  BooleanExpression table;
  table.kind = Kind::kTable;
  table.table = f.truth;
  table.children = std::move(f.inputs);
  return table;
}

}  // namespace

bool BooleanExpression::value(std::uint32_t inputs) const {
  switch (kind) {
    case Kind::kConstant:
      return negated;
    case Kind::kInput:
      return ((inputs >> input & 1u) != 0) != negated;
    case Kind::kTable: {
      std::uint32_t row = 0;
      for (std::size_t i = 0; i < children.size(); ++i) row |= std::uint32_t{children[i].value(inputs)} << i;
      return (table >> row & 1u) != 0;
    }
    case Kind::kAnd:
    case Kind::kOr:
    case Kind::kXor:
      break;
  }
  bool result = children[0].value(inputs);
  for (std::size_t i = 1; i < children.size(); ++i) {
    const bool child = children[i].value(inputs);
    result = kind == Kind::kAnd ? result && child : kind == Kind::kOr ? result || child : result != child;
  }
  return result != negated;
}

BooleanExpression negate(BooleanExpression expression) {
  switch (expression.kind) {
    case Kind::kConstant:
    case Kind::kInput:
    case Kind::kXor:
      expression.negated = !expression.negated;
      break;
    case Kind::kAnd:
    case Kind::kOr:
      expression.kind = expression.kind == Kind::kAnd ? Kind::kOr : Kind::kAnd;
      for (BooleanExpression& child : expression.children) child = negate(std::move(child));
      break;
    case Kind::kTable:
      expression.table = ~expression.table;
      break;
  }
  return expression;
}

BooleanExpression expression_of(std::uint32_t truth, unsigned inputs) {
  Function f;
  f.truth = truth;
  for (unsigned i = 0; i < inputs; ++i) {
    BooleanExpression& input = f.inputs.emplace_back();
    input.kind = Kind::kInput;
    input.input = static_cast<std::uint8_t>(i);
  }
  return take_apart(std::move(f));
}

const BooleanExpression& BooleanExpressions::of(std::uint32_t truth, unsigned inputs) {
  const std::uint64_t key = std::uint64_t{inputs} << 32 | truth;
  const auto known = known_.find(key);
  return known != known_.end() ? known->second : known_.emplace(key, expression_of(truth, inputs)).first->second;
}

}  // namespace plc::native
