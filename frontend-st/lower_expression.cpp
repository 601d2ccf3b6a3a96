// Expressions: literals, names, operators. A plain variable name, the text of most contacts and pins, takes the short
// way through lower_expression: one look-up, no tokens, no tree.
#include <bit>
#include <utility>

#include "core/text.h"
#include "frontend-st/lexer.h"
#include "frontend-st/literals.h"
#include "frontend-st/lowering.h"
#include "frontend-st/operators.h"
#include "frontend-st/parser.h"
#include "frontend-st/text.h"
#include "ir/pointers.h"

namespace plc::st {

using core::Code;
using core::TypeId;
using ir::Operand;
using ir::TypeKind;
using ir::TypeRef;

namespace {

std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

bool is_short_circuit(Operator op) { return op == Operator::kAndThen || op == Operator::kOrElse; }

/// Untyped integers stay untyped through + - * / MOD, so that "2*3" still takes the type of its place.
std::optional<std::int64_t> fold_integers(Operator op, std::int64_t a, std::int64_t b) {
  std::int64_t out = 0;
  switch (op) {
    case Operator::kAdd:
      return __builtin_add_overflow(a, b, &out) ? std::nullopt : std::optional(out);
    case Operator::kSubtract:
      return __builtin_sub_overflow(a, b, &out) ? std::nullopt : std::optional(out);
    case Operator::kMultiply:
      return __builtin_mul_overflow(a, b, &out) ? std::nullopt : std::optional(out);
    case Operator::kDivide:
    case Operator::kModulo:
      if (b == 0 || (a == INT64_MIN && b == -1)) return std::nullopt;
      return op == Operator::kDivide ? a / b : a % b;
    default:
      return std::nullopt;
  }
}

}  // namespace

Operand Lowering::operand(ir::ValueId value, NodeId id) {
  // Texts are for messages: a long chain must not be copied once for each of its operators.
  constexpr std::size_t kShown = 60;
  Operand out = Operand::of(value, at(id));
  const std::string_view written = text(id);
  out.text = std::string(written.substr(0, kShown));
  if (written.size() > kShown) out.text += "..";
  return out;
}

void Lowering::warn_stub(const core::SourceRef& where, const std::string& what) {
  stub_used_ = true;
  builder_.pou().partial = true;
  const std::string message = what + " is a stub and does nothing";
  for (const core::Diagnostic& d : builder_.diagnostics().all()) {
    if (d.code == Code::P4015 && d.message == message && d.pou == builder_.name()) return;
  }
  report(Code::P4015, where, message, "bring its library into the project, or write a POU or type of this name");
}

Operand Lowering::stub_value(NodeId id, Expected expected) {
  const std::uint32_t variable = builder_.hidden("stub", expected.value_or(ir::kBoolType));
  return operand(builder_.load(builder_.variable(variable)), id);
}

void Lowering::give(std::uint32_t number, const Operand& operand) {
  if (given_.size() <= number) given_.resize(number + 1);
  given_[number] = operand;
}

std::optional<Operand> Lowering::value(NodeId id, Expected expected) {
  if (id == kNoNode) return std::nullopt;  // not readable, and said so
  switch (node(id).kind) {
    case NodeKind::kLiteral:
      return literal(id, expected);
    case NodeKind::kEnumValue:
      return enum_value(id);
    case NodeKind::kBit:
      return part_value(id);
    case NodeKind::kUnary:
      return unary(id, expected);
    case NodeKind::kBinary:
      return binary(id, expected);
    case NodeKind::kCall:
      return gives_reference(id) ? name_value(id, expected) : call(id, expected, false);
    case NodeKind::kGiven:
      return given_[node(id).given];
    default:
      return name_value(id, expected);
  }
}

std::optional<Operand> Lowering::literal(NodeId id, Expected expected) {
  std::string problem;
  const std::string_view written = name_text(id);
  const auto parsed = parse_literal(written, problem);
  if (!parsed) {
    report(Code::P4003, at(id), problem);
    return std::nullopt;
  }
  Operand out;
  out.at = at(id);
  out.text = std::string(written);
  ir::Constant constant;
  switch (parsed->kind) {
    case Literal::Kind::kInt:
      out.kind = Operand::Kind::kIntLiteral;
      out.int_value = parsed->int_value;
      out.int_is_unsigned = parsed->int_is_unsigned;
      // CODESYS and Beremiz users write 0 and 1 for BOOL.
      return out;
    case Literal::Kind::kReal:
      out.kind = Operand::Kind::kRealLiteral;
      out.real_value = parsed->real_value;
      return out;
    case Literal::Kind::kScalar:
      constant.type = ir::ref_of(parsed->type);
      constant.bits = parsed->bits;
      break;
    case Literal::Kind::kText: {
      if (!parsed->beyond_latin_1.empty()) {
        report(Code::P4346, at(id), beyond_latin_1_text(*parsed), kBeyondLatin1Help);
      }
      const bool wide = parsed->type == TypeId::kWstring || parsed->type == TypeId::kWchar;
      const std::size_t length = parsed->text.size() / (wide ? 2u : 1u);
      const TypeId character = wide ? TypeId::kWchar : TypeId::kChar;
      const bool as_character = core::in_category(parsed->type, core::kAnyChar) ||
                                (expected && length == 1 && *expected == ir::ref_of(character));
      if (as_character) {
        constant.type = ir::ref_of(character);
        for (std::size_t i = parsed->text.size(); i-- > 0;) {
          constant.bits = (constant.bits << 8) | static_cast<unsigned char>(parsed->text[i]);
        }
      } else {
        constant.type = types().string(parsed->type, static_cast<std::uint16_t>(length == 0 ? 1 : length));
        constant.text = parsed->text;
      }
      break;
    }
  }
  out.kind = Operand::Kind::kValue;
  out.value = builder_.constant(constant);
  return out;
}

Operand Lowering::enum_constant(const EnumValueRef& value, NodeId id) {
  ir::Constant constant;
  constant.type = value.type;
  constant.bits = truncate_bits(static_cast<std::uint64_t>(value.value), core::rep_of(types()[value.type].elementary));
  return operand(builder_.constant(constant), id);
}

// Type#Name
std::optional<Operand> Lowering::enum_value(NodeId id) {
  const std::string_view written = name_text(id);
  const std::size_t hash = written.find('#');
  const std::string_view type_name = written.substr(0, hash);
  const std::string_view member = written.substr(hash + 1);
  const auto type = types().find(type_name);
  if (!type && builder_.is_broken(type_name, at(id))) return std::nullopt;
  if (!type || types()[*type].kind != TypeKind::kEnum) {
    report(Code::P4004, at(id), "there is no enumeration " + quoted(type_name),
           "a prefix before # is an elementary type or an enumeration of the project");
    return std::nullopt;
  }
  const EnumValueRef found = find_enum_value(types(), *type, member);
  if (!found.type.valid()) {
    report_unknown_value(id, *type, member);
    return std::nullopt;
  }
  return enum_constant(found, id);
}

void Lowering::report_unknown_value(NodeId id, ir::TypeRef enumeration, std::string_view value) {
  Guess guess(value);
  for (const ir::EnumMember& m : types()[enumeration].members) guess.offer(m.name);
  report(Code::P4005, at(id), "enumeration " + types().name_of(enumeration) + " has no value " + quoted(value),
         guess.help());
}

bool Lowering::is_unresolved_name(NodeId id) {
  return node(id).kind == NodeKind::kName &&
         find_name(builder_.module(), builder_.pou(), name_text(id)).kind == Named::Kind::kNothing;
}

// The name of an enumeration: also where a variable is called like its type, as in "Color : Color;".
bool Lowering::names_enumeration(NodeId id) {
  if (node(id).kind != NodeKind::kName) return false;
  const auto type = types().find(name_text(id));
  if (!type || types()[*type].kind != TypeKind::kEnum) return false;
  const Named named = find_name(builder_.module(), builder_.pou(), name_text(id));
  if (!named.is_place()) return named.kind == Named::Kind::kNothing;
  const bool local = named.kind == Named::Kind::kVariable;
  const ir::Variable& variable =
      local ? builder_.pou().variables[named.index] : builder_.module().globals[named.index].variable;
  return variable.type == *type;
}

// A variable, or the name of an enumeration value: "Red" or "Color.Red".
std::optional<Operand> Lowering::name_value(NodeId id, Expected expected) {
  if (is_unresolved_name(id)) {
    const std::string_view name = name_text(id);
    if (expected) {
      const EnumValueRef wanted = find_enum_value(types(), *expected, name);
      if (wanted.type.valid()) return enum_constant(wanted, id);
      const TypeKind wanted_kind = types()[*expected].kind;
      if (core::iequals(name, "NULL") && (wanted_kind == TypeKind::kReference || wanted_kind == TypeKind::kPointer)) {
        ir::Constant null;
        null.type = *expected;
        return operand(builder_.constant(null), id);
      }
    }
    const bool in_library = builder_.diagnostics().is_library(builder_.pou().at.file);
    const std::vector<EnumValueRef> found = find_enum_values(types(), name, in_library);
    if (found.empty() && expected && types()[*expected].kind == TypeKind::kEnum) {
      Guess guess(name);
      for (const ir::EnumMember& m : types()[*expected].members) guess.offer(m.name);
      if (!guess.best().empty()) {
        report(Code::P4004, at(id),
               "there is no variable " + quoted(name) + " and no such value of " + types().name_of(*expected),
               guess.help());
        return std::nullopt;
      }
    }
    if (found.size() == 1) return enum_constant(found[0], id);
    if (found.size() > 1) {
      report(Code::P4011, at(id),
             quoted(name) + " is a value of " + types().name_of(found[0].type) + " and of " +
                 types().name_of(found[1].type),
             "write " + types().name_of(found[0].type) + "#" + std::string(name));
      return std::nullopt;
    }
  }
  if (node(id).kind == NodeKind::kMember && names_enumeration(node(id).a)) {
    const ir::TypeRef type = *types().find(name_text(node(id).a));
    const EnumValueRef found = find_enum_value(types(), type, name_text(id));
    if (found.type.valid()) return enum_constant(found, id);
    report_unknown_value(id, type, name_text(id));
    return std::nullopt;
  }
  const auto where = place(id, false);
  if (!where) {
    if (!stub_used_) return std::nullopt;
    return stub_value(id, expected);
  }
  if (types()[builder_.type_of(*where)].stub && !(expected && *expected == builder_.type_of(*where))) {
    warn_stub(at(id), quoted(text(id)) + " of type " + types().name_of(builder_.type_of(*where)));
    return stub_value(id, expected);
  }
  if (const auto known = known_constant(*where)) return operand(builder_.constant(*known), id);
  const ir::ValueId loaded = builder_.load(*where);
  if (in_statement_) builder_.probe(value_key(id), loaded);
  return operand(loaded, id);
}

/// The value of a scalar declared CONSTANT: array indices, CASE labels and folding know it.
std::optional<ir::Constant> Lowering::known_constant(ir::PlaceId where) {
  const ir::Place& place = builder_.body().places[where.index];
  const ir::Variable* variable = nullptr;
  if (place.kind == ir::Place::Kind::kGlobal) variable = &builder_.module().globals[place.index].variable;
  if (place.kind == ir::Place::Kind::kInstance || place.kind == ir::Place::Kind::kFrame) {
    variable = &builder_.pou().variables[place.index];
  }
  if (variable == nullptr || !variable->constant || variable->role == ir::Role::kInput || !variable->address.empty()) {
    return std::nullopt;
  }
  const auto elementary = types().elementary_of(place.type);
  if (!elementary || core::in_category(*elementary, core::kAnyString)) return std::nullopt;
  if (variable->initial.size() != 1 || !variable->initial[0].path.empty()) return std::nullopt;
  ir::Constant constant = variable->initial[0].value;
  constant.type = place.type;
  return constant;
}

// Part of a value: w.3, w.%X3, w.%B1 (IEC 61131-3:2013, table 17).
std::optional<Operand> Lowering::part_value(NodeId id) {
  const auto base = value(node(id).a, std::nullopt);
  if (!base) return std::nullopt;
  const auto word = builder_.settle(*base);
  const auto part = word ? part_of(id, builder_.type_of(*word)) : std::nullopt;
  if (!part) return std::nullopt;
  return operand(builder_.extract(*word, part->type, part->bit), id);
}

// ---- operators ------------------------------------------------------------------------------------------------

// A sign before a literal belongs to the literal: -5 takes INT, -T#5s is a TIME.
std::optional<Operand> Lowering::negated(NodeId id, Operand inner, Expected expected) {
  const std::string written(text(id));
  if (inner.kind == Operand::Kind::kIntLiteral) {
    if (inner.int_is_unsigned && inner.int_value != INT64_MIN) {
      report(Code::P4003, at(id), "integer " + written + " needs more than 64 bits");
      return std::nullopt;
    }
    const bool becomes_unsigned = !inner.int_is_unsigned && inner.int_value == INT64_MIN;
    if (inner.int_value != INT64_MIN) inner.int_value = -inner.int_value;
    inner.int_is_unsigned = becomes_unsigned;
    inner.text = written;
    return inner;
  }
  if (inner.kind == Operand::Kind::kRealLiteral) {
    inner.real_value = -inner.real_value;
    inner.text = written;
    return inner;
  }
  const ir::Inst inst = builder_.body().insts[inner.value.index];
  const ir::Type& type = types()[inst.type];
  if (inst.op == ir::Op::kConst && type.kind == TypeKind::kElementary) {
    ir::Constant constant = builder_.body().constants[inst.a];
    const core::Rep rep = core::rep_of(type.elementary);
    const std::int64_t old = signed_value(constant.bits, rep);
    if (core::in_category(type.elementary, core::kAnySigned | core::kAnyDuration) && old != INT64_MIN &&
        (type.elementary == TypeId::kTime || type.elementary == TypeId::kLtime ||
         int_fits(-old, false, type.elementary))) {
      constant.bits = truncate_bits(static_cast<std::uint64_t>(-old), rep);
      return operand(builder_.constant(constant), id);
    }
  }
  const auto result = builder_.call("NEG", std::span(&inner, 1), at(id), expected);
  if (!result) return std::nullopt;
  return operand(*result, id);
}

std::optional<Operand> Lowering::unary(NodeId id, Expected expected) {
  const Node n = node(id);
  auto inner = value(n.a, expected);
  if (!inner) return std::nullopt;
  if (n.op == Operator::kNegate) return negated(id, *inner, expected);
  if (n.op == Operator::kPlus) {
    const auto type =
        inner->kind == Operand::Kind::kValue ? types().elementary_of(builder_.type_of(inner->value)) : TypeId::kInt;
    const bool bits = type && core::in_category(*type, core::kAnyBit) && *type != TypeId::kBool;
    if (type && (bits || core::in_category(*type, core::kAnyMagnitude))) return inner;
    report(Code::P4001, at(id), "sign before " + quoted(text(n.a)) + ", which is no number");
    return std::nullopt;
  }
  if (inner->kind == Operand::Kind::kValue && builder_.type_of(inner->value) == ir::kBoolType) {
    return operand(builder_.not_(inner->value), id);
  }
  const auto result = builder_.call("NOT", std::span(&*inner, 1), at(id), expected);
  if (!result) return std::nullopt;
  return operand(*result, id);
}

std::optional<Operand> Lowering::compare_references(NodeId id, const Operand& left, const Operand& right) {
  if (builder_.type_of(left.value) != builder_.type_of(right.value)) {
    report(Code::P4101, at(id),
           quoted(left.text) + " has type " + types().name_of(builder_.type_of(left.value)) + ", " +
               quoted(right.text) + " has type " + types().name_of(builder_.type_of(right.value)),
           "only references to one type can be equal");
    return std::nullopt;
  }
  const ir::ValueId same = builder_.same_ref(left.value, right.value);
  return operand(node(id).op == Operator::kEqual ? same : builder_.not_(same), id);
}

bool Lowering::is_duration(const Operand& operand) {
  if (operand.kind != Operand::Kind::kValue) return false;
  const auto elementary = types().elementary_of(builder_.type_of(operand.value));
  return elementary && core::in_category(*elementary, core::kAnyDuration);
}

bool Lowering::is_factor(const Operand& operand) {
  if (operand.kind != Operand::Kind::kValue) return true;
  const auto elementary = types().elementary_of(builder_.type_of(operand.value));
  return elementary && core::in_category(*elementary, core::kAnyNum);
}

std::optional<Operand> Lowering::combine(NodeId id, const Operand& left, const Operand& right, Expected expected) {
  const Operator op = node(id).op;
  const auto is_plain = [](const Operand& o) { return o.kind == Operand::Kind::kIntLiteral && !o.int_is_unsigned; };
  if (is_plain(left) && is_plain(right)) {
    if (const auto folded = fold_integers(op, left.int_value, right.int_value)) {
      Operand out = left;
      out.int_value = *folded;
      out.text = std::to_string(*folded);
      return out;
    }
  }
  const auto is_bool = [this](const Operand& o) {
    return o.kind == Operand::Kind::kValue && builder_.type_of(o.value) == ir::kBoolType;
  };
  if (is_bool(left) && is_bool(right)) {
    if (op == Operator::kAnd) return operand(builder_.logic(ir::Op::kAnd, left.value, right.value), id);
    if (op == Operator::kOr) return operand(builder_.logic(ir::Op::kOr, left.value, right.value), id);
    if (op == Operator::kXor) return operand(builder_.logic(ir::Op::kXor, left.value, right.value), id);
  }
  if (ir::is_pointer(builder_, left) || ir::is_pointer(builder_, right)) return pointer_operation(id, left, right);
  const auto is_reference = [this](const Operand& o) {
    return o.kind == Operand::Kind::kValue && types()[builder_.type_of(o.value)].kind == TypeKind::kReference;
  };
  if ((op == Operator::kEqual || op == Operator::kNotEqual) && is_reference(left) && is_reference(right)) {
    return compare_references(id, left, right);
  }
  Operand both[] = {left, right};
  if (op == Operator::kMultiply && is_duration(right) && is_factor(left)) {
    report(Code::P4359, at(id), std::string(kFactorFirst),
           "write " + std::string(text(node(id).b)) + " * " + std::string(text(node(id).a)));
    std::swap(both[0], both[1]);
  }
  const auto result = builder_.call(function_of(op), both, at(id),
                                    is_comparison(op) ? std::nullopt : expected_of(function_of(op), expected));
  if (!result) return std::nullopt;
  return operand(*result, id);
}

// A comparison of integers with a power is one of reals.
Lowering::Expected Lowering::expected_of(std::string_view function, Expected expected) {
  if (!compared_ || !expected || !core::iequals(function, "EXPT")) return expected;
  const auto elementary = types().elementary_of(*expected);
  return elementary && core::in_category(*elementary, core::kAnyReal) ? expected : std::nullopt;
}

// a AND_THEN b: the right side is computed only when the left one does not decide.
std::optional<Operand> Lowering::short_circuit(NodeId id, const std::optional<Operand>& left) {
  const bool is_and = node(id).op == Operator::kAndThen;
  const std::string what = std::string("input of ") + (is_and ? "AND_THEN" : "OR_ELSE");
  const auto first = left ? builder_.convert(*left, ir::kBoolType, what) : std::nullopt;
  const ir::PlaceId kept = builder_.variable(builder_.hidden("short", ir::kBoolType));
  const ir::LabelId decided = builder_.new_label();
  if (first) {
    builder_.store(kept, *first);
    is_and ? builder_.jump_if_not(*first, decided) : builder_.jump_if(*first, decided);
  }
  const auto second = condition(node(id).b, what);
  if (second) builder_.store(kept, *second);
  builder_.bind(decided);
  if (!first || !second) return std::nullopt;
  return operand(builder_.load(kept), id);
}

// Chains lean to the left without limit, so the left spine is walked in a loop.
std::optional<Operand> Lowering::binary(NodeId id, Expected expected) {
  struct Level {
    NodeId id;
    Expected expected;
  };
  std::vector<Level> spine;
  NodeId leaf = id;
  while (node(leaf).kind == NodeKind::kBinary) {
    spine.push_back({leaf, expected});
    if (is_comparison(node(leaf).op)) expected.reset();
    leaf = node(leaf).a;
  }
  std::optional<Operand> left;
  std::optional<Operand> first_right;
  if (is_comparison(node(spine.back().id).op) && is_unresolved_name(leaf)) {
    // "Idle = State": the name takes its type from the other side.
    first_right = value(node(spine.back().id).b, std::nullopt);
    if (first_right && first_right->kind == Operand::Kind::kValue) expected = builder_.type_of(first_right->value);
  }
  left = value(leaf, expected);
  bool fine = left.has_value();
  for (std::size_t i = spine.size(); i-- > 0;) {
    Expected hint = spine[i].expected;
    if (is_comparison(node(spine[i].id).op)) {
      hint.reset();
      if (left && left->kind == Operand::Kind::kValue) hint = builder_.type_of(left->value);
    }
    if (is_short_circuit(node(spine[i].id).op)) {
      left = short_circuit(spine[i].id, left);
      fine = left.has_value();
      continue;
    }
    const bool taken = i + 1 == spine.size() && first_right;
    const bool compared = std::exchange(compared_, compared_ || is_comparison(node(spine[i].id).op));
    const auto right = taken ? first_right : value(node(spine[i].id).b, hint);
    compared_ = compared;
    fine = fine && right.has_value();
    // After an error the rest is still read, for the errors it has of its own.
    if (!fine) continue;
    left = combine(spine[i].id, *left, *right, spine[i].expected);
    fine = left.has_value();
  }
  return fine ? left : std::nullopt;
}

// ---- entries --------------------------------------------------------------------------------------------------

std::optional<Operand> lower_expression(std::string_view text, const core::SourceRef& at, ir::Builder& builder,
                                        std::optional<TypeRef> expected) {
  const std::string_view plain = core::trimmed(text);
  if (is_identifier(plain)) {
    const Named named = find_name(builder.module(), builder.pou(), plain);
    if (named.is_place()) {
      const ir::PlaceId place =
          named.kind == Named::Kind::kVariable ? builder.variable(named.index) : builder.global(named.index);
      const ir::Type& type = builder.module().types[builder.type_of(place)];
      if (!type.stub && !type.implicit) {
        Operand out = Operand::of(builder.load(place), at);
        out.text = std::string(plain);
        return out;
      }
    }
  }
  if (text.size() > kMaxTextBytes) {
    builder.report(Code::P4002, at, "the text is longer than " + std::to_string(kMaxTextBytes) + " bytes");
    return std::nullopt;
  }
  const SourceText source(text, at, builder.diagnostics());
  Parser parser(source, builder.diagnostics(), builder.name());
  const NodeId root = parser.parse_expression();
  if (root == kNoNode) return std::nullopt;
  return Lowering(builder, source, parser.ast()).value(root, expected);
}

}  // namespace plc::st
