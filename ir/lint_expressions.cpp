// Lints of single computations: equality of reals, products and quotients that lose before they are widened,
// comparisons that a type decides, division by zero.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "core/text.h"
#include "ir/lint_findings.h"
#include "ir/text.h"

namespace plc::ir {
namespace {

__extension__ using Wide = __int128;  // products of any two 64-bit integers

struct Range {
  Wide least = 0, greatest = 0;
  [[nodiscard]] bool holds(const Range& other) const { return least <= other.least && other.greatest <= greatest; }
};

Range range_of(TypeId type) {
  const unsigned bits = core::rep_bytes(core::rep_of(type)) * 8;
  if (core::in_category(type, core::kAnySigned)) return {-(Wide{1} << (bits - 1)), (Wide{1} << (bits - 1)) - 1};
  return {0, (Wide{1} << bits) - 1};
}

Wide integer_of(const Constant& constant, TypeId type) {
  const unsigned unused = 64 - core::rep_bytes(core::rep_of(type)) * 8;
  if (core::in_category(type, core::kAnySigned)) return static_cast<std::int64_t>(constant.bits << unused) >> unused;
  return constant.bits;
}

/// One variable copied to another somewhere in the body.
struct Copied {
  std::uint32_t to, from;  ///< places
  friend auto operator<=>(const Copied&, const Copied&) = default;
};

class Expressions {
 public:
  Expressions(const LintBody& body, Findings& findings) : b_(body), types_(body.module.types), findings_(findings) {}

  void run() {
    for (std::uint32_t i = 0; i < b_.body().insts.size(); ++i) {
      const Inst& inst = b_.inst(i);
      if (inst.op != Op::kCall || inst.part != Part::kPlain || inst.count == 0 || !b_.flow.reached[i]) continue;
      const stdlib::Overload& function = *b_.body().functions[inst.a];
      const std::string_view name = function.spec->name;
      if (name == "EQ" || name == "NE") look_at_equality(i, function);
      if (inst.count == 2) look_at_comparison(i, function);
      if (name == "DIV" || name == "MOD") look_at_divisor(i);
      if (inst.count == 1 && function.spec->param_count == 1) look_at_conversion(i, function);
    }
  }

 private:
  [[nodiscard]] ValueId arg(const Inst& inst, std::uint32_t index) const { return b_.body().args[inst.b + index]; }
  [[nodiscard]] const Inst& value(ValueId id) const { return b_.inst(id.index); }
  [[nodiscard]] const Constant* constant(ValueId id) const {
    return value(id).op == Op::kConst ? &b_.body().constants[value(id).a] : nullptr;
  }
  [[nodiscard]] std::string type_name(TypeId type) const { return std::string(core::name_of(type)); }
  void add(Lint lint, std::uint32_t index, std::string message, std::string help) {
    findings_.add(lint, b_.at(index), b_.pou.name, std::move(message), std::move(help));
  }

  /// The value as it is written, or empty: variables and constants.
  [[nodiscard]] std::string text_of(ValueId id) const {
    if (value(id).op == Op::kLoad) return place_text(b_.module, b_.pou, PlaceId{value(id).a});
    if (const Constant* known = constant(id)) return constant_text(types_, *known);
    return {};
  }

  /// True for a conversion from one numeric type to another, as casts and widening make it.
  static bool converts(const stdlib::Overload& function) {
    if (function.spec->param_count != 1 || function.name.find("TO_") == std::string_view::npos) return false;
    return core::in_category(function.param_type(0), core::kAnyNum) &&
           core::in_category(function.result_type(), core::kAnyNum);
  }
  /// The value before it was widened, which changes no value.
  [[nodiscard]] ValueId unconverted(ValueId id) const {
    while (value(id).op == Op::kCall) {
      const stdlib::Overload& function = *b_.body().functions[value(id).a];
      if (!converts(function) || !stdlib::widens(function.param_type(0), function.result_type())) break;
      id = arg(value(id), 0);
    }
    return id;
  }

  // ---- real-equality ----

  [[nodiscard]] bool is_zero(ValueId id) const {
    const Constant* known = constant(id);
    if (known == nullptr) return false;
    const auto rep = types_.rep_of(known->type);
    const std::uint64_t sign = rep == Rep::kF32   ? std::uint64_t{1} << 31
                               : rep == Rep::kF64 ? std::uint64_t{1} << 63
                                                  : 0;
    return (known->bits & ~sign) == 0;
  }

  /// "IF New <> Old THEN .. Old := New": whether it changed is an exact question.
  bool is_change_test(ValueId a, ValueId b) {
    const Inst& first = value(unconverted(a));
    const Inst& second = value(unconverted(b));
    if (first.op != Op::kLoad || second.op != Op::kLoad) return false;
    if (first.a == second.a) return true;  // x <> x: the test for NaN
    if (!copies_known_) {
      copies_known_ = true;
      for (const Inst& inst : b_.body().insts) {
        if (inst.op != Op::kStore) continue;
        const Inst& from = value(unconverted(ValueId{inst.b}));
        if (from.op == Op::kLoad) copies_.insert({inst.a, from.a});
      }
    }
    return copies_.contains({first.a, second.a}) || copies_.contains({second.a, first.a});
  }

  void look_at_equality(std::uint32_t index, const stdlib::Overload& function) {
    if (!core::in_category(function.param_type(0), core::kAnyReal)) return;
    const Inst& inst = b_.inst(index);
    for (std::uint32_t i = 0; i < inst.count; ++i) {
      if (is_zero(arg(inst, i))) return;
    }
    if (inst.count == 2 && is_change_test(arg(inst, 0), arg(inst, 1))) return;
    const bool equal = function.spec->name == "EQ";
    add(Lint::kRealEquality, index,
        fmt::format("{} values are compared for {}", type_name(function.param_type(0)),
                    equal ? "equality" : "inequality"),
        equal ? "rounding makes computed values differ in the last bits: test ABS(a - b) < tolerance"
              : "rounding makes computed values differ in the last bits: test ABS(a - b) >= tolerance");
  }

  // ---- constant-comparison ----

  void look_at_comparison(std::uint32_t index, const stdlib::Overload& function) {
    // By what it is for: TRUE when the first is less, equal, greater than the second.
    struct Comparison {
      std::string_view name;
      bool less, equal, greater;
    };
    static constexpr Comparison kComparisons[] = {
        {"EQ", false, true, false}, {"NE", true, false, true},  {"LT", true, false, false},
        {"LE", true, true, false},  {"GT", false, false, true}, {"GE", false, true, true},
    };
    const auto* row = std::find_if(std::begin(kComparisons), std::end(kComparisons),
                                   [&](const Comparison& c) { return c.name == function.spec->name; });
    const TypeId type = function.param_type(0);
    if (row == std::end(kComparisons)) return;
    const Inst& inst = b_.inst(index);
    const ValueId a = arg(inst, 0), b = arg(inst, 1);
    const auto say = [&](bool result, const std::string& why) {
      add(Lint::kConstantComparison, index, fmt::format("comparison is always {}: {}", result ? "TRUE" : "FALSE", why),
          "compare with another value, or remove the comparison");
    };
    if (value(a).op == Op::kLoad && value(b).op == Op::kLoad && value(a).a == value(b).a && b.index == a.index + 1 &&
        !core::in_category(type, core::kAnyReal)) {
      return say(row->equal, fmt::format("{} is compared with itself", text_of(a)));
    }
    if (!core::in_category(type, core::kAnyInt)) return;
    const Constant* left = constant(a);
    const Constant* right = constant(b);
    if ((left == nullptr) == (right == nullptr)) return;
    // The variable's own type counts: it may have been widened to meet the constant.
    const ValueId other = unconverted(left != nullptr ? b : a);
    const auto own = types_.elementary_of(value(other).type);
    if (!own || !core::in_category(*own, core::kAnyInt)) return;
    const Range range = range_of(*own);
    const Wide bound = integer_of(left != nullptr ? *left : *right, type);
    // Which of less, equal, greater the first operand may be.
    bool less = range.least < bound, equal = range.least <= bound && bound <= range.greatest,
         greater = range.greatest > bound;
    if (left != nullptr) std::swap(less, greater);
    const bool may_hold = (row->less && less) || (row->equal && equal) || (row->greater && greater);
    const bool may_fail = (!row->less && less) || (!row->equal && equal) || (!row->greater && greater);
    if (may_hold == may_fail) return;
    const std::string name = text_of(other);
    say(may_hold, fmt::format("{}{} has values from {} to {}", name.empty() ? "" : name + " of type ", type_name(*own),
                              static_cast<std::int64_t>(range.least), static_cast<std::uint64_t>(range.greatest)));
  }

  // ---- division-by-zero ----

  void look_at_divisor(std::uint32_t index) {
    const Inst& inst = b_.inst(index);
    if (inst.count != 2 || !is_zero(arg(inst, 1))) return;
    add(Lint::kDivisionByZero, index, "division by the constant zero",
        "each execution is an event; correct the divisor");
  }

  // ---- narrow-product, integer-division ----

  /// What values an operand of a product can have: of a constant, of the type before it was widened, or of a subrange.
  [[nodiscard]] Range operand_range(ValueId id, TypeId type) const {
    if (const Constant* known = constant(id)) {
      const Wide number = integer_of(*known, type);
      return {number, number};
    }
    const Range whole = range_of(type);
    const TypeRef own = value(unconverted(id)).type;
    const auto elementary = types_.elementary_of(own);
    if (!elementary || !core::in_category(*elementary, core::kAnyInt)) return whole;
    Range narrow = range_of(*elementary);
    if (types_[own].kind == TypeKind::kSubrange) narrow = {types_[own].lower, types_[own].upper};
    return whole.holds(narrow) ? narrow : whole;
  }

  void look_at_conversion(std::uint32_t index, const stdlib::Overload& function) {
    if (!converts(function)) return;
    const TypeId from = function.param_type(0), to = function.result_type();
    const Inst& operation = value(arg(b_.inst(index), 0));
    if (!core::in_category(from, core::kAnyInt) || operation.op != Op::kCall || operation.count != 2) return;
    const std::string_view name = b_.body().functions[operation.a]->spec->name;
    const bool real = core::in_category(to, core::kAnyReal);
    if (name == "DIV" && real) {
      return add(Lint::kIntegerDivision, index,
                 fmt::format("quotient of {} values is converted to {}: its fraction is lost before", type_name(from),
                             type_name(to)),
                 fmt::format("convert the operands: {0}_TO_{1}(a) / {0}_TO_{1}(b)", type_name(from), type_name(to)));
    }
    if (name != "MUL" || (!real && range_of(from).holds(range_of(to)))) return;
    const Range a = operand_range(arg(operation, 0), from), b = operand_range(arg(operation, 1), from);
    const auto [least, greatest] =
        std::minmax({a.least * b.least, a.least * b.greatest, a.greatest * b.least, a.greatest * b.greatest});
    if (range_of(from).holds({least, greatest})) return;
    add(Lint::kNarrowProduct, index,
        fmt::format("product of {0} values is computed in {0} and converted to {1} afterwards", type_name(from),
                    type_name(to)),
        fmt::format("it has wrapped around by then: convert an operand, {}_TO_{}(a) * b", type_name(from),
                    type_name(to)));
  }

  const LintBody& b_;
  const TypeTable& types_;
  Findings& findings_;
  std::set<Copied> copies_;
  bool copies_known_ = false;
};

}  // namespace

void lint_expressions(const LintBody& body, Findings& findings) { Expressions(body, findings).run(); }

}  // namespace plc::ir
