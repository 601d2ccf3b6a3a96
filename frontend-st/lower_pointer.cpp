// Pointers and references by name: ADR and REF, p[i], + and - and comparisons of pointers, REF= and __ISVALIDREF.
#include "core/text.h"
#include "frontend-st/any_types.h"
#include "frontend-st/lowering.h"
#include "frontend-st/operators.h"
#include "frontend-st/parser.h"
#include "frontend-st/text.h"
#include "ir/foreign_size.h"
#include "ir/pointers.h"

namespace plc::st {

using core::Code;
using ir::Operand;
using ir::PlaceId;
using ir::TypeKind;
using ir::TypeRef;

namespace {

std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

ir::ValueId null_of(ir::Builder& builder, TypeRef type) { return builder.constant({type, 0, {}}); }

}  // namespace

// A name of type REFERENCE TO stands for what the reference refers to.
PlaceId Lowering::follow_implicit(PlaceId where) {
  while (types()[builder_.type_of(where)].implicit) where = builder_.deref(builder_.load(where));
  return where;
}

std::optional<PlaceId> Lowering::reference_place(NodeId id) {
  keep_reference_ = true;
  return place(id, false);
}

std::optional<Operand> Lowering::take_reference(NodeId id, Expected expected) {
  const NodeId argument = node(id).b;
  const bool adr = core::iequals(name_text(node(id).a), "ADR");
  if (argument == kNoNode || node(argument).next != kNoNode || node(argument).argument != ArgumentKind::kPositional) {
    report(Code::P4010, at(id), std::string(name_text(node(id).a)) + " takes one variable");
    return std::nullopt;
  }
  const TypeKind wanted = expected ? types()[*expected].kind : TypeKind::kElementary;
  const bool pointer = adr ? wanted != TypeKind::kReference : wanted == TypeKind::kPointer;
  const auto where = lasting_place(node(argument).a);
  if (!where) return std::nullopt;
  if (builder_.is_part(*where)) {
    report(Code::P4010, at(argument),
           quoted(text(argument)) + " is a part of a variable and has no " + (pointer ? "address" : "reference"));
    return std::nullopt;
  }
  if (pointer) return operand(builder_.address(*where, builder_.type_of(*where)), id);
  if (is_constant(*where)) {
    report(Code::P4007, at(argument), quoted(text(argument)) + " is a constant, which a reference could write",
           "copy it to a variable, and refer to that");
    return std::nullopt;
  }
  return operand(builder_.make_ref(*where), id);
}

// p[i]: what lies i times its size after where p leads to (CODESYS).
std::optional<PlaceId> Lowering::pointer_element(PlaceId pointer, NodeId index) {
  const TypeRef target = types()[builder_.type_of(pointer)].element;
  if (node(index).next != kNoNode) {
    report(Code::P4008, at(node(index).next), quoted(text(node(index).next)) + " is one index too many",
           "a pointer takes one index; write p^[i, j] for elements of the array that it leads to");
    return std::nullopt;
  }
  const auto size = ir::foreign_size(types(), target);
  if (!size) {
    report(Code::P4206, at(index),
           types().name_of(target) + " has no size that is the same everywhere, so the pointer takes no index",
           "use an array of pointers, or a pointer to an array");
    return std::nullopt;
  }
  const ir::ValueId base = builder_.load(pointer);
  const auto given = value(index, std::nullopt);
  const auto moved = given ? ir::index_pointer(builder_, base, *given, *size) : std::nullopt;
  return moved ? std::optional(builder_.deref(*moved)) : std::nullopt;
}

std::optional<Operand> Lowering::pointer_operation(NodeId id, const Operand& left, const Operand& right) {
  const Operator op = node(id).op;
  const bool first = ir::is_pointer(builder_, left);
  const bool second = ir::is_pointer(builder_, right);
  std::optional<ir::ValueId> result;
  if (is_comparison(op)) {
    result = ir::compare_pointers(builder_, function_of(op), left, right);
  } else if (op == Operator::kSubtract && first && second) {
    result = ir::pointer_distance(builder_, left.value, right.value);
  } else if ((op == Operator::kAdd && first != second) || (op == Operator::kSubtract && !second)) {
    const bool back = op == Operator::kSubtract;
    result = ir::move_pointer(builder_, first ? left.value : right.value, first ? right : left, back);
  } else {
    report(Code::P4206, at(id), quoted(text(id)) + " computes with a pointer",
           "pointers are moved by + and -, subtracted from each other and compared; copy one to an LWORD to do more");
  }
  return result ? std::optional(operand(*result, id)) : std::nullopt;
}

// The reference to what `written` names, of type `reference`.
std::optional<ir::ValueId> Lowering::bound_reference(NodeId written, TypeRef reference, const std::string& what) {
  const TypeRef target = types()[reference].element;
  const bool null =
      (node(written).kind == NodeKind::kName && core::iequals(text(written), "NULL")) || text(written) == "0";
  if (null) return null_of(builder_, reference);
  const auto where = place(written, true);
  if (!where) return std::nullopt;
  if (builder_.is_part(*where) || builder_.type_of(*where) != target) {
    report(Code::P4208, at(written),
           what + " refers to a variable of type " + types().name_of(target) + ", " + quoted(text(written)) + " is " +
               (builder_.is_part(*where) ? "a part of one" : types().name_of(builder_.type_of(*where))),
           "references take variables of exactly their type");
    return std::nullopt;
  }
  return builder_.make_ref(*where);
}

// r REF= x
bool Lowering::bind_reference(NodeId id) {
  const auto where = reference_place(node(id).a);
  if (!where) return stub_used_;
  const TypeRef type = builder_.type_of(*where);
  const std::string_view name = text(node(id).a);
  if (types()[type].kind != TypeKind::kReference) {
    report(Code::P4208, at(id), quoted(name) + " has type " + types().name_of(type) + " and takes no REF=",
           "declare it as REFERENCE TO the type of what it shall stand for");
    return false;
  }
  const auto bound = bound_reference(node(id).b, type, quoted(name));
  if (bound) builder_.store(*where, *bound);
  return bound.has_value();
}

std::optional<Operand> Lowering::call_is_valid_ref(NodeId id) {
  const NodeId argument = node(id).b;
  const bool one =
      argument != kNoNode && node(argument).next == kNoNode && node(argument).argument == ArgumentKind::kPositional;
  const auto where = one ? reference_place(node(argument).a) : std::nullopt;
  if (one && !where) return std::nullopt;
  if (!one || types()[builder_.type_of(*where)].kind != TypeKind::kReference) {
    report(Code::P4208, at(id), "__ISVALIDREF takes one variable that is a REFERENCE TO or REF_TO",
           "a pointer is compared with 0");
    return std::nullopt;
  }
  const ir::ValueId reference = builder_.load(*where);
  const TypeRef type = builder_.type_of(*where);
  return operand(builder_.not_(builder_.same_ref(reference, null_of(builder_, type))), id);
}

// What an input of type ANY gets of the variable that is given: its class, address and size. The place holds it until
// the call; the input of an instance keeps it.
std::optional<PlaceId> Lowering::described(NodeId written, TypeRef any, const std::string& what) {
  const auto where = lasting_place(written);
  if (!where) return std::nullopt;
  const TypeRef type = builder_.type_of(*where);
  if (type == any) return where;
  const AnyInput input = any_input(types(), any).value_or(AnyInput{});
  const auto elementary = types().elementary_of(type);
  const bool fits = input.categories == 0 || (elementary && core::in_category(*elementary, input.categories));
  const auto size = ir::foreign_size(types(), type);
  if (!fits || !size || builder_.is_part(*where)) {
    report(
        Code::P4210, at(written),
        what + " takes a variable of " + std::string(input.name) + ", " + quoted(text(written)) + " is " +
            (builder_.is_part(*where) ? "a part of one" : types().name_of(type)),
        size ? "give it a whole variable of such a type" : "function blocks have no size that is the same everywhere");
    return std::nullopt;
  }
  const PlaceId made = builder_.variable(builder_.hidden("any", any));
  const auto number = [&](const char* member, std::int64_t value) {
    const PlaceId to = *builder_.member(made, member);
    const auto bits = static_cast<std::uint64_t>(value);
    builder_.store(to, builder_.constant({builder_.type_of(to), bits, {}}));
  };
  number("TypeClass", type_class_of(types(), type));
  number("diSize", static_cast<std::int64_t>(*size));
  builder_.store(*builder_.member(made, "pValue"), builder_.address(*where, ir::ref_of(core::TypeId::kByte)));
  return made;
}

bool Lowering::bind(PlaceId where, NodeId written) {
  const auto bound = bound_reference(written, builder_.type_of(where), quoted(builder_.describe(where)));
  if (bound) builder_.store(where, *bound);
  return bound.has_value();
}

bool lower_binding(PlaceId where, std::string_view text, const core::SourceRef& at, ir::Builder& builder) {
  const SourceText source(text, at, builder.diagnostics());
  Parser parser(source, builder.diagnostics(), builder.name());
  const NodeId root = parser.parse_expression();
  return root != kNoNode && Lowering(builder, source, parser.ast()).bind(where, root);
}

}  // namespace plc::st
