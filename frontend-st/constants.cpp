#include "frontend-st/constants.h"

#include <bit>
#include <cmath>
#include <compare>
#include <vector>

#include "core/text.h"
#include "frontend-st/literals.h"
#include "frontend-st/names.h"
#include "frontend-st/operators.h"
#include "frontend-st/parser.h"

namespace plc::st {
namespace {

using core::Code;
using core::Rep;
using core::TypeId;
using Kind = ConstantValue::Kind;

ConstantValue integer(std::int64_t value, bool is_unsigned = false) {
  ConstantValue out;
  out.int_value = value;
  out.is_unsigned = is_unsigned && value < 0;
  return out;
}

ConstantValue real(double value) {
  ConstantValue out;
  out.kind = Kind::kReal;
  out.real_value = value;
  return out;
}

ConstantValue typed(ir::TypeRef type, std::uint64_t bits) {
  ConstantValue out;
  out.kind = Kind::kTyped;
  out.constant.type = type;
  out.constant.bits = bits;
  return out;
}

double as_double(const ConstantValue& v) {
  if (v.kind == Kind::kReal) return v.real_value;
  return v.is_unsigned ? static_cast<double>(static_cast<std::uint64_t>(v.int_value))
                       : static_cast<double>(v.int_value);
}

bool is_number(const ConstantValue& v) { return v.kind == Kind::kInt || v.kind == Kind::kReal; }
bool is_typed(const ConstantValue& v, TypeId id) { return v.kind == Kind::kTyped && v.constant.type == ir::ref_of(id); }

ConstantValue from_literal(const Literal& literal, ir::TypeTable& types) {
  switch (literal.kind) {
    case Literal::Kind::kInt:
      return integer(literal.int_value, literal.int_is_unsigned);
    case Literal::Kind::kReal:
      return real(literal.real_value);
    case Literal::Kind::kText: {
      const std::size_t length =
          literal.text.size() / (literal.type == TypeId::kWstring || literal.type == TypeId::kWchar ? 2u : 1u);
      const TypeId type = core::in_category(literal.type, core::kAnyString) ? literal.type
                          : literal.type == TypeId::kWchar                  ? TypeId::kWstring
                                                                            : TypeId::kString;
      ConstantValue out = typed(types.string(type, static_cast<std::uint16_t>(length == 0 ? 1 : length)), 0);
      out.constant.text = literal.text;
      return out;
    }
    case Literal::Kind::kScalar:
      break;
  }
  const Rep rep = core::rep_of(literal.type);
  if (core::in_category(literal.type, core::kAnyReal)) {
    return constant_of_type(
        real(rep == Rep::kF32 ? static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(literal.bits)))
                              : std::bit_cast<double>(literal.bits)),
        literal.type);
  }
  const bool number = core::in_category(literal.type, core::kAnyInt | core::kAnyBit) && literal.type != TypeId::kBool;
  if (!number) return typed(ir::ref_of(literal.type), literal.bits);
  return constant_of_type(integer(signed_value(literal.bits, rep), rep == Rep::kU64), literal.type);
}

/// The type in which the two are computed on, as in statements: the wider of their types; a literal takes the other's.
std::optional<TypeId> common_type(const ConstantValue& a, const ConstantValue& b) {
  if (!a.type || !b.type) {
    const ConstantValue& known = a.type ? a : b;
    const ConstantValue& literal = a.type ? b : a;
    if (!known.type) return std::nullopt;
    const bool is_real = core::in_category(*known.type, core::kAnyReal);
    const bool fits =
        is_real || (literal.kind == Kind::kInt && int_fits(literal.int_value, literal.is_unsigned, *known.type));
    return fits ? known.type : std::nullopt;
  }
  if (stdlib::widens(*b.type, *a.type)) return a.type;
  return stdlib::widens(*a.type, *b.type) ? b.type : std::nullopt;
}

class Evaluator {
 public:
  Evaluator(const SourceText& source, const Ast& ast, ir::TypeTable& types, ConstantScope& scope,
            std::optional<ir::TypeRef> expected)
      : source_(source), ast_(ast), types_(types), scope_(scope), expected_(expected) {}

  // Nodes stand behind their children, so one pass over the table computes every value.
  std::optional<ConstantValue> run(NodeId root) {
    std::vector<bool> part_of_name(ast_.nodes.size(), false);
    for (const Node& n : ast_.nodes) {
      if (n.kind == NodeKind::kMember) part_of_name[n.a] = true;
    }
    for (NodeId id = 0; id <= root; ++id) {
      values_.emplace_back();
      if (part_of_name[id]) continue;
      values_.back() = compute(id);
      if (!values_.back()) {
        wrong_ = id;
        return std::nullopt;
      }
    }
    return values_[root];
  }
  [[nodiscard]] NodeId wrong() const { return wrong_; }
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  std::optional<ConstantValue> fail(std::string problem) {
    problem_ = std::move(problem);
    return std::nullopt;
  }

  std::optional<ConstantValue> compute(NodeId id) {
    const Node& n = ast_[id];
    const std::string_view name = source_.slice(n.name, n.name_end);
    switch (n.kind) {
      case NodeKind::kLiteral: {
        const auto literal = parse_literal(name, problem_);
        if (!literal) return std::nullopt;
        return from_literal(*literal, types_);
      }
      case NodeKind::kName:
        return named(name);
      case NodeKind::kMember:
        return named(source_.slice(n.begin, n.end));
      case NodeKind::kEnumValue:
        return enum_value(name.substr(0, name.find('#')), name.substr(name.find('#') + 1));
      case NodeKind::kUnary:
        return unary(n.op, *values_[n.a]);
      case NodeKind::kBinary:
        return binary(n.op, *values_[n.a], *values_[n.b]);
      default:
        return fail("\"" + std::string(source_.slice(n.begin, n.end)) + "\" is not constant");
    }
  }

  std::optional<ConstantValue> enum_value(std::string_view type_name, std::string_view member) {
    const auto type = types_.find(type_name);
    const EnumValueRef found = type ? find_enum_value(types_, *type, member) : EnumValueRef{};
    if (!found.type.valid())
      return fail("there is no enumeration value " + std::string(type_name) + "#" + std::string(member));
    return enum_constant(found);
  }

  ConstantValue enum_constant(const EnumValueRef& value) {
    return typed(value.type,
                 truncate_bits(static_cast<std::uint64_t>(value.value), core::rep_of(types_[value.type].elementary)));
  }

  std::optional<ConstantValue> named(std::string_view name) {
    if (expected_) {
      const EnumValueRef wanted = find_enum_value(types_, *expected_, name);
      if (wanted.type.valid()) return enum_constant(wanted);
    }
    if (const auto constant = scope_.constant_named(name)) return constant;
    if (core::iequals(name, "NULL")) {
      ConstantValue null;
      null.kind = Kind::kNull;
      return null;
    }
    const std::size_t dot = name.find('.');
    if (dot != std::string_view::npos) {
      const auto type = types_.find(name.substr(0, dot));
      if (type && types_[*type].kind == ir::TypeKind::kEnum)
        return enum_value(name.substr(0, dot), name.substr(dot + 1));
    }
    const std::vector<EnumValueRef> found = find_enum_values(types_, name);
    if (found.size() == 1) return enum_constant(found[0]);
    if (found.size() > 1) return fail("\"" + std::string(name) + "\" is a value of several enumerations");
    return fail("\"" + std::string(name) + "\" is not a constant");
  }

  std::optional<ConstantValue> unary(Operator op, const ConstantValue& v) {
    if (op == Operator::kPlus && is_number(v)) return v;
    if (op == Operator::kNot && is_typed(v, TypeId::kBool)) return typed(ir::kBoolType, v.constant.bits ^ 1u);
    if (is_number(v) && v.type) {
      if (const stdlib::Overload* const of_type = overload(op, *v.type)) return computed(*of_type, *v.type, {&v});
    }
    if (op == Operator::kNegate) {
      if (v.kind == Kind::kReal) return real(-v.real_value);
      if (v.kind == Kind::kInt && v.is_unsigned && v.int_value == INT64_MIN) return integer(INT64_MIN);
      if (v.kind == Kind::kInt && !v.is_unsigned && v.int_value != INT64_MIN) return integer(-v.int_value);
      const auto ns = static_cast<std::int64_t>(v.constant.bits);
      if (is_duration(v) && ns != INT64_MIN) return typed(v.constant.type, static_cast<std::uint64_t>(-ns));
    }
    return fail("operator does not take this value");
  }

  bool is_duration(const ConstantValue& v) const { return is_typed(v, TypeId::kTime) || is_typed(v, TypeId::kLtime); }

  std::optional<ConstantValue> binary(Operator op, const ConstantValue& a, const ConstantValue& b) {
    if (is_comparison(op)) return compare(op, a, b);
    if (is_typed(a, TypeId::kBool) && is_typed(b, TypeId::kBool)) {
      if (op == Operator::kAnd) return typed(ir::kBoolType, a.constant.bits & b.constant.bits);
      if (op == Operator::kOr) return typed(ir::kBoolType, a.constant.bits | b.constant.bits);
      if (op == Operator::kXor) return typed(ir::kBoolType, a.constant.bits ^ b.constant.bits);
    }
    if (is_duration(a) && (is_duration(b) || b.kind == Kind::kInt)) {
      const auto x = static_cast<std::int64_t>(a.constant.bits);
      const bool scale = op == Operator::kMultiply || op == Operator::kDivide;
      if (is_duration(b) == scale) return fail("operator does not take these values");
      const auto result = integers(op, x, is_duration(b) ? static_cast<std::int64_t>(b.constant.bits) : b.int_value);
      if (!result) return std::nullopt;
      return typed(a.constant.type, static_cast<std::uint64_t>(result->int_value));
    }
    if (!is_number(a) || !is_number(b)) return fail("operator does not take these values");
    const std::optional<TypeId> type = common_type(a, b);
    const bool is_power = op == Operator::kPower;  // its kernel is not exact, and not folded
    const stdlib::Overload* const of_type = type && !is_power ? overload(op, *type) : nullptr;
    if (of_type != nullptr) return computed(*of_type, *type, {&a, &b});
    if (a.kind == Kind::kInt && b.kind == Kind::kInt && !a.is_unsigned && !b.is_unsigned && !is_power) {
      return integers(op, a.int_value, b.int_value);
    }
    const auto result = reals(op, a, b);
    return result && type && core::in_category(*type, core::kAnyReal) ? constant_of_type(*result, *type) : result;
  }

  std::optional<ConstantValue> reals(Operator op, const ConstantValue& a, const ConstantValue& b) {
    const double x = as_double(a);
    const double y = as_double(b);
    switch (op) {
      case Operator::kAdd:
        return real(x + y);
      case Operator::kSubtract:
        return real(x - y);
      case Operator::kMultiply:
        return real(x * y);
      case Operator::kDivide:
        if (y == 0) return fail("division by zero");
        return real(x / y);
      case Operator::kPower: {
        const double power = std::pow(x, y);
        const bool whole = a.kind == Kind::kInt && b.kind == Kind::kInt && y >= 0 && std::fabs(power) < 9e15;
        return whole ? integer(static_cast<std::int64_t>(power)) : real(power);
      }
      default:
        return fail("operator does not take these values");
    }
  }

  /// Computes in `type` as statements do; nothing when the library has no such function.
  const stdlib::Overload* overload(Operator op, TypeId type) const {
    return stdlib::overload_with_key(std::string(function_of(op)) + ':' + std::string(core::name_of(type)));
  }
  std::optional<ConstantValue> computed(const stdlib::Overload& overload, TypeId type,
                                        std::initializer_list<const ConstantValue*> operands) {
    std::vector<std::uint64_t> bits;
    for (const ConstantValue* operand : operands) bits.push_back(bits_of(*operand, core::rep_of(type)));
    std::vector<const void*> arguments;
    for (const std::uint64_t& one : bits) arguments.push_back(&one);
    Literal result;
    result.kind = Literal::Kind::kScalar;
    result.type = type;
    const stdlib::Event event =
        overload.kernel(&result.bits, arguments.data(), static_cast<std::uint32_t>(arguments.size()));
    if (event == stdlib::Event::kDivideByZero) return fail("division by zero");
    if (event != stdlib::Event::kNone) return fail("the operator does not take these values");
    result.bits = truncate_bits(result.bits, core::rep_of(type));
    return from_literal(result, types_);
  }
  static std::uint64_t bits_of(const ConstantValue& v, Rep rep) {
    if (rep == Rep::kF32) return std::bit_cast<std::uint32_t>(static_cast<float>(as_double(v)));
    if (rep == Rep::kF64) return std::bit_cast<std::uint64_t>(as_double(v));
    return truncate_bits(static_cast<std::uint64_t>(v.int_value), rep);
  }

  std::optional<ConstantValue> integers(Operator op, std::int64_t a, std::int64_t b) {
    std::int64_t out = 0;
    bool overflow = false;
    switch (op) {
      case Operator::kAdd:
        overflow = __builtin_add_overflow(a, b, &out);
        break;
      case Operator::kSubtract:
        overflow = __builtin_sub_overflow(a, b, &out);
        break;
      case Operator::kMultiply:
        overflow = __builtin_mul_overflow(a, b, &out);
        break;
      case Operator::kDivide:
      case Operator::kModulo:
        if (b == 0) return fail("division by zero");
        overflow = a == INT64_MIN && b == -1;
        if (!overflow) out = op == Operator::kDivide ? a / b : a % b;
        break;
      case Operator::kAnd:
        out = a & b;
        break;
      case Operator::kOr:
        out = a | b;
        break;
      case Operator::kXor:
        out = a ^ b;
        break;
      default:
        return fail("operator does not take these values");
    }
    if (overflow) return fail("the result needs more than 64 bits");
    return integer(out);
  }

  /// Orders 64-bit numbers with and without sign.
  static std::pair<bool, std::uint64_t> sign_and_size(const ConstantValue& v) {
    return {v.is_unsigned || v.int_value >= 0, static_cast<std::uint64_t>(v.int_value)};
  }

  /// Bytes of a STRING, UTF-16 units of a WSTRING: strings compare by them.
  std::u16string units_of(const ir::Constant& text) const {
    const std::size_t width = types_[text.type].elementary == TypeId::kWstring ? 2 : 1;
    std::u16string out;
    for (std::size_t i = 0; i + width <= text.text.size(); i += width) {
      const auto byte = [&](std::size_t k) {
        return static_cast<unsigned>(static_cast<unsigned char>(text.text[i + k]));
      };
      out += static_cast<char16_t>(width == 2 ? byte(0) | byte(1) << 8 : byte(0));
    }
    return out;
  }

  std::optional<ConstantValue> compare(Operator op, const ConstantValue& a, const ConstantValue& b) {
    std::partial_ordering order = std::partial_ordering::equivalent;
    if (a.kind == Kind::kInt && b.kind == Kind::kInt) {
      order = sign_and_size(a) <=> sign_and_size(b);
    } else if (is_number(a) && is_number(b)) {
      order = as_double(a) <=> as_double(b);
    } else if (a.kind == Kind::kTyped && b.kind == Kind::kTyped &&
               types_[a.constant.type].kind == types_[b.constant.type].kind &&
               types_[a.constant.type].elementary == types_[b.constant.type].elementary) {
      const ir::Type& type = types_[a.constant.type];
      const auto id = types_.elementary_of(a.constant.type);
      if (type.kind == ir::TypeKind::kString) {
        order = units_of(a.constant) <=> units_of(b.constant);
      } else if (a.constant.type != b.constant.type) {
        return fail("these values cannot be compared");
      } else if (id && core::in_category(*id, core::kAnyUnsigned | core::kAnyBit)) {
        order = a.constant.bits <=> b.constant.bits;
      } else {
        order = static_cast<std::int64_t>(a.constant.bits) <=> static_cast<std::int64_t>(b.constant.bits);
      }
    } else {
      return fail("these values cannot be compared");
    }
    bool result = false;
    switch (op) {
      case Operator::kEqual:
        result = order == 0;
        break;
      case Operator::kNotEqual:
        result = order != 0;
        break;
      case Operator::kLess:
        result = order < 0;
        break;
      case Operator::kLessEqual:
        result = order <= 0;
        break;
      case Operator::kGreater:
        result = order > 0;
        break;
      default:
        result = order >= 0;
        break;
    }
    return typed(ir::kBoolType, result ? 1 : 0);
  }

  const SourceText& source_;
  const Ast& ast_;
  ir::TypeTable& types_;
  ConstantScope& scope_;
  std::optional<ir::TypeRef> expected_;
  std::vector<std::optional<ConstantValue>> values_;
  std::string problem_;
  NodeId wrong_ = kNoNode;
};

std::string shown(const ConstantValue& v, const ir::TypeTable& types) {
  switch (v.kind) {
    case Kind::kInt:
      return v.is_unsigned ? std::to_string(static_cast<std::uint64_t>(v.int_value)) : std::to_string(v.int_value);
    case Kind::kReal:
      return "a real number";
    case Kind::kNull:
      return "NULL";
    case Kind::kTyped:
      break;
  }
  return "a value of type " + types.name_of(v.constant.type);
}

}  // namespace

ConstantValue constant_of_type(ConstantValue value, TypeId id) {
  if (!is_number(value)) return value;
  const bool is_real = core::in_category(id, core::kAnyReal);
  if (is_real) {
    const double number = as_double(value);
    value = real(core::rep_of(id) == Rep::kF32 ? static_cast<double>(static_cast<float>(number)) : number);
  } else if (value.kind != Kind::kInt || !int_fits(value.int_value, value.is_unsigned, id)) {
    return value;  // reported where it is declared
  }
  value.type = id;
  return value;
}

std::optional<ConstantValue> evaluate_constant(std::string_view text, const core::SourceRef& at, ir::TypeTable& types,
                                               ConstantScope& scope, core::Diagnostics& diagnostics,
                                               std::string_view pou, std::optional<ir::TypeRef> expected) {
  if (text.size() > kMaxTextBytes) {
    diagnostics.report(Code::P4002, at, pou, "the text is longer than " + std::to_string(kMaxTextBytes) + " bytes");
    return std::nullopt;
  }
  const SourceText source(text, at, diagnostics);
  Parser parser(source, diagnostics, pou);
  const NodeId root = parser.parse_expression();
  if (root == kNoNode) return std::nullopt;
  Evaluator evaluator(source, parser.ast(), types, scope, expected);
  const auto value = evaluator.run(root);
  if (!value) {
    diagnostics.report(Code::P4034, source.locate(parser.ast()[evaluator.wrong()].begin), pou,
                       "\"" + std::string(core::trimmed(text)) + "\" has no constant value: " + evaluator.problem());
  }
  return value;
}

std::optional<ir::Constant> constant_as(const ConstantValue& value, ir::TypeRef to, const ir::TypeTable& types,
                                        std::string& problem) {
  const ir::Type& target = types[to];
  const auto id = types.elementary_of(to);
  ir::Constant out;
  out.type = to;
  problem = types.name_of(to) + " does not take " + shown(value, types);
  if (target.kind == ir::TypeKind::kReference) return value.kind == Kind::kNull ? std::optional(out) : std::nullopt;
  if (!id || value.kind == Kind::kNull) return std::nullopt;
  const Rep rep = core::rep_of(*id);
  if (target.kind == ir::TypeKind::kEnum) {
    if (value.kind == Kind::kTyped && value.constant.type == to) return value.constant;
    if (value.kind != Kind::kInt) return std::nullopt;
    // Some tools export enumeration values as their numbers.
    for (const ir::EnumMember& member : target.members) {
      if (member.value != value.int_value) continue;
      out.bits = truncate_bits(static_cast<std::uint64_t>(member.value), rep);
      return out;
    }
    return std::nullopt;
  }
  if (target.kind == ir::TypeKind::kString || core::in_category(*id, core::kAnyChar)) {
    const bool wide = rep == Rep::kWstr || *id == TypeId::kWchar;
    if (value.kind != Kind::kTyped) return std::nullopt;
    const auto from = types.elementary_of(value.constant.type);
    if (from != (wide ? TypeId::kWstring : TypeId::kString)) {
      if (from && core::in_category(*from, core::kAnyString)) {
        problem += "; a STRING stands in single quotes, a WSTRING in double ones";
      }
      return std::nullopt;
    }
    const std::size_t length = value.constant.text.size() / (wide ? 2u : 1u);
    if (target.kind == ir::TypeKind::kString) {
      if (length > target.capacity) {
        problem = "a text of " + std::to_string(length) + " characters does not fit into " + types.name_of(to);
        return std::nullopt;
      }
      out.text = value.constant.text;
      return out;
    }
    if (length != 1) return std::nullopt;
    for (std::size_t i = value.constant.text.size(); i-- > 0;) {
      out.bits = (out.bits << 8) | static_cast<unsigned char>(value.constant.text[i]);
    }
    return out;
  }
  if (core::in_category(*id, core::kAnyReal)) {
    if (!is_number(value)) return std::nullopt;
    const double number = as_double(value);
    if (rep == Rep::kF64) {
      out.bits = std::bit_cast<std::uint64_t>(number);
      return out;
    }
    const auto narrow = static_cast<float>(number);
    if (std::isinf(narrow) && !std::isinf(number)) {
      problem = "the value is out of the range of REAL";
      return std::nullopt;
    }
    out.bits = std::bit_cast<std::uint32_t>(narrow);
    return out;
  }
  if (value.kind == Kind::kTyped) {
    const auto from = types.elementary_of(value.constant.type);
    if (!from || types[value.constant.type].kind == ir::TypeKind::kEnum) return std::nullopt;
    if (*from != *id && !stdlib::widens(*from, *id)) return std::nullopt;
    if (core::in_category(*from, core::kAnyChars)) return std::nullopt;
    if (*from == TypeId::kBool && *id != TypeId::kBool) return std::nullopt;
    out.bits = value.constant.bits;
    return out;
  }
  if (value.kind != Kind::kInt) return std::nullopt;
  if (core::in_category(*id, core::kAnyDuration | core::kAnyDate)) {
    // Tools that fill in defaults write a plain 0; any other number has no unit.
    if (value.int_value == 0) return out;
    problem += "; durations and dates have a prefix, as in T#5s";
    return std::nullopt;
  }
  if (!int_fits(value.int_value, value.is_unsigned, *id)) {
    problem = shown(value, types) + " does not fit into " + types.name_of(to);
    return std::nullopt;
  }
  if (target.kind == ir::TypeKind::kSubrange && (value.int_value < target.lower || value.int_value > target.upper)) {
    problem = shown(value, types) + " is outside of " + types.name_of(to) + " (" + std::to_string(target.lower) + ".." +
              std::to_string(target.upper) + ")";
    return std::nullopt;
  }
  out.bits = truncate_bits(static_cast<std::uint64_t>(value.int_value), rep);
  return out;
}

}  // namespace plc::st
