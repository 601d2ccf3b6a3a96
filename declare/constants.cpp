#include "declare/constants.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <compare>
#include <vector>

#include "core/text.h"
#include "frontend-st/literals.h"
#include "frontend-st/names.h"
#include "frontend-st/operators.h"
#include "frontend-st/parser.h"
#include "stdlib/idioms.h"

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

bool is_typed(const ConstantValue& v, TypeId id) { return v.kind == Kind::kTyped && v.constant.type == ir::ref_of(id); }

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

  // Nodes come after their children, so one pass over the table computes every value.
  std::optional<ConstantValue> run(NodeId root) {
    std::vector<bool> part_of_name(ast_.nodes.size(), false);
    for (NodeId id = 0; id <= root; ++id) {
      const Node& n = ast_[id];
      if (n.kind == NodeKind::kMember || n.kind == NodeKind::kIndex || n.kind == NodeKind::kCall)
        part_of_name[n.a] = true;
      if (is_sizeof(n)) std::fill(part_of_name.begin() + n.a, part_of_name.begin() + id, true);
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
  /// Idioms that were met: code, node, message, help.
  struct Note {
    Code code;
    NodeId at;
    std::string message;
    std::string help;
  };
  [[nodiscard]] const std::vector<Note>& notes() const { return notes_; }

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
        if (!literal->beyond_latin_1.empty()) {
          notes_.push_back({Code::P4346, id, beyond_latin_1_text(*literal), kBeyondLatin1Help});
        }
        ConstantValue value = constant_of_literal(*literal, types_);
        value.based = name.find('#') != std::string_view::npos;
        return value;
      }
      case NodeKind::kName:
        return named(id, name);
      case NodeKind::kMember:
        return named(id, source_.slice(n.begin, n.end));
      case NodeKind::kIndex: {
        const auto value = part_of_variable(id);
        return value ? value : fail("\"" + std::string(source_.slice(n.begin, n.end)) + "\" is not constant");
      }
      case NodeKind::kArgument:
        if (n.a == kNoNode || (n.argument != ArgumentKind::kPositional && n.argument != ArgumentKind::kInput))
          return fail("a call of constants has values at all inputs, and no outputs");
        return values_[n.a];
      case NodeKind::kCall:
        return call(id);
      case NodeKind::kEnumValue:
        return enum_value(name.substr(0, name.find('#')), name.substr(name.find('#') + 1));
      case NodeKind::kUnary:
        return unary(n.op, *values_[n.a]);
      case NodeKind::kBinary: {
        const ConstantValue& a = *values_[n.a];
        const ConstantValue& b = *values_[n.b];
        if (n.op != Operator::kMultiply || !is_number(a) || !is_duration(b)) return binary(n.op, a, b);
        notes_.push_back({Code::P4359, id, std::string(kFactorFirst),
                          "write " + std::string(source_.slice(ast_[n.b].begin, ast_[n.b].end)) + " * " +
                              std::string(source_.slice(ast_[n.a].begin, ast_[n.a].end))});
        return binary(n.op, b, a);
      }
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

  bool is_sizeof(const Node& n) const {
    return n.kind == NodeKind::kCall && ast_[n.a].kind == NodeKind::kName &&
           core::iequals(source_.slice(ast_[n.a].name, ast_[n.a].name_end), "SIZEOF");
  }

  std::optional<ConstantValue> call(NodeId id) {
    const Node& n = ast_[id];
    const std::string_view callee = source_.slice(ast_[n.a].begin, ast_[n.a].end);
    if (is_sizeof(n)) {
      if (n.b == kNoNode || ast_[n.b].next != kNoNode || ast_[n.b].argument != ArgumentKind::kPositional)
        return fail("SIZEOF takes one variable or type");
      const auto size = scope_.size_of(ast_, source_, ast_[n.b].a, problem_);
      if (!size) return std::nullopt;
      notes_.push_back({Code::P4352, id,
                        "SIZEOF is not in the standard; " + std::string(source_.slice(n.begin, n.end)) + " is " +
                            std::to_string(*size) + " in CODESYS",
                        "write the number"});
      return integer(static_cast<std::int64_t>(*size));
    }
    if (ast_[n.a].kind != NodeKind::kName || scope_.is_own_function(callee))
      return fail("\"" + std::string(source_.slice(n.begin, n.end)) + "\" is not constant");
    std::vector<ConstantValue> arguments;
    std::vector<std::string_view> pins;
    for (NodeId argument = n.b; argument != kNoNode; argument = ast_[argument].next) {
      if (ast_[argument].a == kNoNode) return fail("an argument is left out");
      arguments.push_back(*values_[argument]);
      pins.push_back(source_.slice(ast_[argument].name, ast_[argument].name_end));
    }
    return call_constant(callee, arguments, pins, types_, id + 1 == ast_.nodes.size() ? expected_ : std::nullopt,
                         problem_);
  }

  /// What "a.b[2].c" begins with.
  std::optional<ConstantValue> part_of_variable(NodeId id) {
    std::vector<PathStep> path;
    for (; ast_[id].kind == NodeKind::kMember || ast_[id].kind == NodeKind::kIndex; id = ast_[id].a) {
      const Node& n = ast_[id];
      if (n.kind == NodeKind::kMember) {
        path.push_back({source_.slice(n.name, n.name_end)});
        continue;
      }
      const std::size_t first = path.size();
      for (NodeId index = n.b; index != kNoNode; index = ast_[index].next) {
        if (values_[index]->kind != Kind::kInt) return std::nullopt;
        path.insert(path.begin() + static_cast<std::ptrdiff_t>(first), PathStep{{}, values_[index]->int_value});
      }
    }
    if (ast_[id].kind != NodeKind::kName) return std::nullopt;
    std::reverse(path.begin(), path.end());
    return scope_.variable_value(source_.slice(ast_[id].name, ast_[id].name_end), path);
  }

  std::optional<ConstantValue> named(NodeId id, std::string_view name) {
    if (expected_) {
      const EnumValueRef wanted = find_enum_value(types_, *expected_, name);
      if (wanted.type.valid()) return enum_constant(wanted);
    }
    if (auto constant = scope_.constant_named(name)) return constant;
    if (auto value = part_of_variable(id)) return value;
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
    const std::vector<EnumValueRef> found = find_enum_values(types_, name, scope_.in_library());
    if (found.size() == 1) return enum_constant(found[0]);
    if (found.size() > 1) return fail("\"" + std::string(name) + "\" is a value of several enumerations");
    return fail("\"" + std::string(name) + "\" is not a constant");
  }

  std::optional<ConstantValue> unary(Operator op, const ConstantValue& v) {
    if (op == Operator::kPlus && is_number(v)) return v;
    if (op == Operator::kNot && is_typed(v, TypeId::kBool)) return typed(ir::kBoolType, v.constant.bits ^ 1u);
    if (op == Operator::kNot && v.kind == Kind::kInt && v.type && core::in_category(*v.type, core::kAnyInt)) {
      const Rep rep = core::rep_of(*v.type);
      const std::uint64_t bits = truncate_bits(~static_cast<std::uint64_t>(v.int_value), rep);
      return constant_of_type(integer(signed_value(bits, rep), rep == Rep::kU64), *v.type);
    }
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
    if (!is_number(a) || !is_number(b)) {
      // Dates, durations with reals, enumerations as numbers: what the function of the operator gives.
      const std::string_view function = function_of(op);
      if (function.empty()) return fail("operator does not take these values");
      const ConstantValue both[] = {a, b};
      const std::string_view unnamed[2];
      return call_constant(function, both, unnamed, types_, std::nullopt, problem_);
    }
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
    for (const ConstantValue* operand : operands) bits.push_back(number_bits(*operand, core::rep_of(type)));
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
    return constant_of_literal(result, types_);
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
  std::vector<Note> notes_;
  std::string problem_;
  NodeId wrong_ = kNoNode;
};

}  // namespace

ConstantValue constant_of_literal(const Literal& literal, ir::TypeTable& types) {
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

std::uint64_t number_bits(const ConstantValue& v, Rep rep) {
  if (rep == Rep::kF32) return std::bit_cast<std::uint32_t>(static_cast<float>(as_double(v)));
  if (rep == Rep::kF64) return std::bit_cast<std::uint64_t>(as_double(v));
  return truncate_bits(static_cast<std::uint64_t>(v.int_value), rep);
}

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
  auto value = evaluator.run(root);
  for (const Evaluator::Note& note : evaluator.notes()) {
    diagnostics.report(note.code, source.locate(parser.ast()[note.at].begin), pou, note.message, note.help);
  }
  if (!value) {
    diagnostics.report(Code::P4034, source.locate(parser.ast()[evaluator.wrong()].begin), pou,
                       "\"" + std::string(core::trimmed(text)) + "\" has no constant value: " + evaluator.problem());
  }
  return value;
}

}  // namespace plc::st
