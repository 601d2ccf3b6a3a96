// Parts of words, and parts of what a function gives.
#include <string>

#include "core/text.h"
#include "frontend-st/literals.h"
#include "frontend-st/lowering.h"
#include "frontend-st/names.h"
#include "ir/reach.h"

namespace plc::st {

using core::Code;
using ir::PlaceId;
using ir::TypeKind;
using ir::TypeRef;

namespace {

std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

unsigned bits_of(core::TypeId type) {
  return type == core::TypeId::kBool ? 1u : core::rep_bytes(core::rep_of(type)) * 8u;
}

}  // namespace

bool Lowering::has_parts(TypeRef word) {
  const auto elementary = types().elementary_of(word);
  return elementary && core::in_category(*elementary, core::kAnyBit | core::kAnyInt) &&
         *elementary != core::TypeId::kBool && types()[word].kind == TypeKind::kElementary;
}

std::optional<Lowering::Part> Lowering::part_of(NodeId id, TypeRef word) {
  std::string_view digits = name_text(id);
  core::TypeId part = core::TypeId::kBool;
  if (digits.size() > 2 && digits[0] == '%') {
    switch (core::upper(digits[1])) {
      case 'X':
        break;
      case 'B':
        part = core::TypeId::kByte;
        break;
      case 'W':
        part = core::TypeId::kWord;
        break;
      case 'D':
        part = core::TypeId::kDword;
        break;
      default:
        part = core::TypeId::kLword;
        break;
    }
    digits.remove_prefix(2);
  }
  std::string problem;
  const auto number = parse_literal(digits, problem);
  if (!has_parts(word) || !number || number->kind != Literal::Kind::kInt) {
    report(Code::P4005, name_at(id), quoted(text(node(id).a)) + " has no part " + quoted(name_text(id)),
           "parts are taken from integers and BYTE, WORD, DWORD, LWORD, as in w.3, w.%X3 and w.%B1");
    return std::nullopt;
  }
  const std::int64_t count = part == core::TypeId::kLword ? 0 : bits_of(*types().elementary_of(word)) / bits_of(part);
  if (count < 2 || number->int_value < 0 || number->int_value >= count) {
    report(Code::P4008, name_at(id),
           quoted(text(node(id).a)) + " of type " + types().name_of(word) + " has no part " + quoted(name_text(id)),
           count < 2 ? "a part is smaller than the whole"
                     : "its parts of this size are 0 to " + std::to_string(count - 1));
    return std::nullopt;
  }
  return Part{ir::ref_of(part), static_cast<unsigned>(number->int_value) * bits_of(part)};
}

std::optional<PlaceId> Lowering::part_place(PlaceId word, NodeId id) {
  const auto part = part_of(id, builder_.type_of(word));
  if (!part) return std::nullopt;
  return builder_.part(word, part->type, part->bit);
}

// "w.Ready" with a constant Ready (CODESYS).
std::optional<std::int64_t> Lowering::bit_constant(NodeId id) {
  const Named named = find_name(builder_.module(), builder_.pou(), name_text(id));
  if (!named.is_place()) return std::nullopt;
  const bool local = named.kind == Named::Kind::kVariable;
  const auto known = known_constant(local ? builder_.variable(named.index) : builder_.global(named.index));
  const auto type = known ? types().elementary_of(known->type) : std::nullopt;
  if (!type || !core::in_category(*type, core::kAnyInt)) return std::nullopt;
  return signed_value(known->bits, core::rep_of(*type));
}

std::optional<PlaceId> Lowering::constant_bit_place(PlaceId word, NodeId id, std::int64_t bit) {
  const TypeRef type = builder_.type_of(word);
  const std::int64_t count = bits_of(*types().elementary_of(type));
  if (bit < 0 || bit >= count) {
    report(Code::P4008, name_at(id),
           quoted(text(node(id).a)) + " of type " + types().name_of(type) + " has no bit " + std::to_string(bit) +
               ", the value of " + quoted(name_text(id)),
           "its bits are 0 to " + std::to_string(count - 1));
    return std::nullopt;
  }
  report(Code::P4356, name_at(id), quoted(name_text(id)) + " is a constant that names bit " + std::to_string(bit),
         "write " + std::string(text(node(id).a)) + "." + std::to_string(bit));
  return builder_.part(word, ir::kBoolType, static_cast<unsigned>(bit));
}

bool Lowering::gives_reference(NodeId id) {
  if (node(id).kind != NodeKind::kCall || node(node(id).a).kind != NodeKind::kName) return false;
  const ir::Module& module = builder_.module();
  const auto found = module.pou_by_name.find(name_text(node(id).a));
  if (found == module.pou_by_name.end() || module.pous[found->second].kind != ir::PouKind::kFunction) return false;
  const TypeRef type = module.pous[found->second].return_type;
  return type.valid() && types()[type].implicit;
}

// "F(x).a[2]" (CODESYS): what the function gives is kept where it can be taken apart.
std::optional<PlaceId> Lowering::result_place(NodeId id, bool keep_reference) {
  if (gives_reference(id)) {
    const ir::Pou& function = builder_.module().pous[builder_.module().pou_by_name.find(name_text(node(id).a))->second];
    if (function.stub) {
      // Its result would lead nowhere.
      const TypeRef type = function.return_type;
      warn_stub(at(id), "function " + quoted(function.name));
      return builder_.variable(builder_.hidden("stub", keep_reference ? type : types()[type].element));
    }
  }
  const auto given = call(id, std::nullopt, false);
  const auto result = given ? builder_.settle(*given) : std::nullopt;
  if (!result) return std::nullopt;
  const PlaceId kept = builder_.variable(builder_.hidden("result", builder_.type_of(*result)));
  builder_.store(kept, *result);
  const TypeKind kind = types()[builder_.type_of(kept)].kind;
  if (kind == TypeKind::kReference || kind == TypeKind::kPointer) return kept;  // followed, and not taken apart
  report(Code::P4357, at(id), "a part of what " + quoted(name_text(node(id).a)) + " gives is taken in its call",
         "assign the result to a variable, and take the part of that");
  return kept;
}

std::optional<PlaceId> Lowering::lasting_place(NodeId id) {
  const auto where = place(id, false);
  NodeId root = id;
  while (node(root).kind == NodeKind::kMember || node(root).kind == NodeKind::kIndex ||
         node(root).kind == NodeKind::kBit || node(root).kind == NodeKind::kDeref) {
    root = node(root).a;
  }
  const bool follows = where && ir::root_of(builder_.body(), *where).kind == ir::Place::Kind::kDeref;
  if (!where || node(root).kind != NodeKind::kCall || follows || stub_used_) return where;
  report(Code::P4006, at(root), quoted(text(root)) + " is not a variable");
  return std::nullopt;
}

}  // namespace plc::st
