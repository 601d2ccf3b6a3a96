// CASE (IEC 61131-3:2013, table 72): the selector is computed once and compared with the labels from top to bottom; the
// first branch that has its value runs.
#include <algorithm>
#include <iterator>

#include "frontend-st/literals.h"
#include "frontend-st/lowering.h"

namespace plc::st {

using core::Code;
using ir::Operand;
using ir::TypeKind;
using ir::TypeRef;
using ir::ValueId;

namespace {

std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

}  // namespace

// Ranges are kept apart and merged, so that many labels stay cheap.
bool LabelRanges::take(std::int64_t low, std::int64_t high) {
  auto after = ranges_.upper_bound(low);
  if (after != ranges_.begin()) {
    const auto before = std::prev(after);
    if (before->second >= high) return false;
    if (before->second >= low) low = before->first;
  }
  after = ranges_.lower_bound(low);
  while (after != ranges_.end() && after->first <= high) {
    high = std::max(high, after->second);
    after = ranges_.erase(after);
  }
  ranges_.emplace(low, high);
  return true;
}

std::optional<ValueId> Lowering::compare(std::string_view function, ValueId a, ValueId b, NodeId where) {
  const Operand both[] = {operand(a, where), operand(b, where)};
  return builder_.call(function, both, at(where));
}

// A constant of another integer type, which does not widen to the selector's: its number counts.
std::optional<Operand> Lowering::number_of_constant(const Operand& given, TypeRef selector) {
  if (given.kind != Operand::Kind::kValue) return std::nullopt;
  const ir::Inst& inst = builder_.body().insts[given.value.index];
  const auto is_whole = [this](TypeRef type) {
    const auto id = types().elementary_of(type);
    return id && types()[type].kind == TypeKind::kElementary && *id != core::TypeId::kBool &&
           core::in_category(*id, core::kAnyInt | core::kAnyBit);
  };
  if (inst.op != ir::Op::kConst || !is_whole(inst.type) || !is_whole(selector)) return std::nullopt;
  const core::TypeId from = types()[inst.type].elementary;
  if (stdlib::widens(from, types()[selector].elementary)) return std::nullopt;
  Operand out = given;
  out.kind = Operand::Kind::kIntLiteral;
  out.int_value = signed_value(builder_.body().constants[inst.a].bits, core::rep_of(from));
  out.int_is_unsigned = core::rep_of(from) == core::Rep::kU64 && out.int_value < 0;
  return out;
}

std::optional<ValueId> Lowering::label_value(NodeId id, TypeRef selector) {
  const auto given = value(id, selector);
  if (!given) return std::nullopt;
  if (given->kind == Operand::Kind::kValue && builder_.type_of(given->value) == ir::kBoolType &&
      selector != ir::kBoolType) {
    report(Code::P4101, at(id),
           "label of CASE needs " + types().name_of(selector) + ", " + quoted(text(id)) + " is BOOL");
    return std::nullopt;
  }
  if (const auto number = number_of_constant(*given, selector)) {
    report(Code::P4339, at(id),
           "label " + quoted(text(id)) + " of CASE has type " + types().name_of(builder_.type_of(given->value)) +
               ", the selector " + types().name_of(selector));
    return builder_.convert(*number, selector, "label of CASE");
  }
  std::optional<ValueId> label = given->value;
  // Strings of any length compare; everything else takes the selector's type.
  const auto elementary = types().elementary_of(selector);
  const bool is_text = elementary && core::in_category(*elementary, core::kAnyString);
  if (!is_text || given->kind != Operand::Kind::kValue) {
    // A number for a value of an enumeration is taken as it is in "color = 0".
    const bool number = types()[selector].kind == TypeKind::kEnum && given->kind == Operand::Kind::kIntLiteral;
    const bool as_number = number || types()[selector].kind == TypeKind::kSubrange;
    label = builder_.convert(*given, as_number ? ir::ref_of(*elementary) : selector, "label of CASE");
    if (number && label) {
      ir::Constant constant = builder_.body().constants[builder_.body().insts[label->index].a];
      constant.type = selector;
      label = builder_.constant(constant);
    }
  }
  if (!label) return std::nullopt;
  if (builder_.body().insts[label->index].op == ir::Op::kConst) return label;
  report(Code::P4070, at(id), "label " + quoted(text(id)) + " of CASE is not constant",
         "labels are literals, enumeration values and constants; compare variables with IF");
  return std::nullopt;
}

/// The number of a constant label, in the order of its type; nothing for texts and reals.
std::optional<std::int64_t> Lowering::label_number(ValueId label) {
  const auto elementary = types().elementary_of(builder_.type_of(label));
  if (!elementary || core::in_category(*elementary, core::kAnyString | core::kAnyReal)) return std::nullopt;
  const core::Rep rep = core::rep_of(*elementary);
  const std::int64_t number = signed_value(builder_.body().constants[builder_.body().insts[label.index].a].bits, rep);
  return rep == core::Rep::kU64 ? static_cast<std::int64_t>(static_cast<std::uint64_t>(number) ^ (1ull << 63)) : number;
}

/// BOOL: the selector has the value, or lies in the range, of `label`.
std::optional<ValueId> Lowering::case_label(NodeId label, ValueId selector, LabelRanges& taken) {
  const ir::PartScope part(builder_, ir::Part::kCaseLabel);
  const TypeRef type = builder_.type_of(selector);
  const bool range = node(label).kind == NodeKind::kRange;
  const auto low = label_value(range ? node(label).a : label, type);
  const auto high = range ? label_value(node(label).b, type) : low;
  if (!low || !high) return std::nullopt;
  const auto first = label_number(*low);
  const auto last = label_number(*high);
  if (first && last && *first > *last) {
    report(Code::P4070, at(label), "range " + quoted(text(label)) + " of CASE holds no value",
           "the lower limit comes first");
    return std::nullopt;
  }
  if (first && last && !taken.take(*first, *last)) {
    report(Code::P4072, at(label), "label " + quoted(text(label)) + " of CASE was given before and is never reached");
  }
  if (!range) return compare("EQ", selector, *low, label);
  const auto above = compare("GE", selector, *low, label);
  const auto below = compare("LE", selector, *high, label);
  if (!above || !below) return std::nullopt;
  return builder_.logic(ir::Op::kAnd, *above, *below);
}

bool Lowering::case_of(NodeId id) {
  const auto given = value(node(id).a, std::nullopt);
  const auto settled = given ? builder_.settle(*given) : std::nullopt;
  std::optional<ValueId> selector = settled;
  if (settled && !types().elementary_of(builder_.type_of(*settled))) {
    report(Code::P4070, at(node(id).a),
           "selector " + quoted(text(node(id).a)) + " of CASE has type " + types().name_of(builder_.type_of(*settled)),
           "select by a value of an elementary type or of an enumeration");
    selector.reset();
  }
  const ir::LabelId end = builder_.new_label();
  bool fine = selector.has_value();
  LabelRanges labels;
  for (NodeId branch = node(id).c; branch != kNoNode; branch = node(branch).c) {
    builder_.set_source(at(branch));
    if (node(branch).kind == NodeKind::kElse) {
      cover_branch(branch, "ELSE");
      fine = statements(node(branch).b) && fine;
      break;
    }
    std::optional<ValueId> taken;
    for (NodeId label = node(branch).a; label != kNoNode && selector; label = node(label).next) {
      const auto one = case_label(label, *selector, labels);
      fine = fine && one.has_value();
      if (one) taken = taken ? builder_.logic(ir::Op::kOr, *taken, *one) : *one;
    }
    const ir::LabelId next = builder_.new_label();
    if (taken) {
      const ir::PartScope part(builder_, ir::Part::kCaseLabel);
      builder_.jump_if_not(*taken, next);
    }
    cover_branch(branch, "CASE");
    fine = statements(node(branch).b) && fine;
    const bool last = node(branch).c == kNoNode;
    if (!last || covered()) {
      const ir::PartScope part(builder_, ir::Part::kCaseLabel);
      builder_.jump(end);
    }
    builder_.bind(next);
    if (last) cover_branch(id, "none of CASE");
  }
  builder_.bind(end);
  return fine;
}

}  // namespace plc::st
