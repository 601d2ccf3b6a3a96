// Values, and boolean logic as look-up records.
#include <algorithm>
#include <cassert>

#include "bytecode/codegen/body_generator.h"

namespace plc::bytecode {

std::uint32_t BodyGenerator::operand(std::uint32_t value) {
  const Inst& inst = body_.insts[value];
  if (inst.type == ir::kBoolType) return bool_operand(values()[value].literal);
  if (values()[value].word != kUnset) return values()[value].word;
  if (inst.op == Op::kConst) return values()[value].word = shared_.constants.word(body_.constants[inst.a]);
  assert(inst.op == Op::kLoad);
  return place_words_[inst.a];
}

std::uint32_t BodyGenerator::operand_as(std::uint32_t value, ir::TypeRef type) {
  const std::uint32_t word = operand(value);
  const ValueInfo& info = values()[value];
  const bool taken_over = info.word != kUnset && !is_logic(body_.insts[value].op) && info.link != kUnset;
  const ir::TypeRef own = taken_over ? type_of_place(body_.insts[info.link].a) : body_.insts[value].type;
  if (own == type) return word;
  const std::uint32_t copy = intermediate_of(image_type(type), now_);
  move(type, copy, word);
  return copy;
}

std::uint32_t BodyGenerator::destination(bool exact_type) {
  ValueInfo& v = values()[now_];
  const ir::TypeRef type = body_.insts[now_].type;
  const std::uint32_t store = v.uses == 0 ? kUnset : takeover(exact_type);
  if (store == kUnset) {
    v.word = intermediate_of(image_type(type), lifetime(now_));
  } else {
    v.word = place_words_[body_.insts[store].a];
    v.link = store;
    v.hazard = values()[store].hazard;
  }
  return v.word;
}

std::uint32_t BodyGenerator::takeover(bool exact_type) {
  const ValueInfo& v = values()[now_];
  const std::uint32_t s = v.first_use;
  if (s - now_ > kFuseWindow || body_.insts[s].op != Op::kStore) return kUnset;
  const Inst& store = body_.insts[s];
  if (store.b != now_ || !is_static(store.a)) return kUnset;
  const ir::TypeRef from = body_.insts[now_].type;
  const ir::TypeRef to = type_of_place(store.a);
  if (from != to && (exact_type || types_.rep_of(from) != types_.rep_of(to))) return kUnset;
  if (v.uses > 1 && (from != to || v.pinned || v.last_use > values()[s].hazard)) return kUnset;
  const std::uint32_t root = analysis_.places[store.a].root;
  for (std::uint32_t i = now_ + 1; i < s; ++i) {
    const Inst& between = body_.insts[i];
    const bool harmless = between.op == Op::kConst ||
                          (between.op == Op::kLoad && is_static(between.a) && analysis_.places[between.a].root != root);
    if (!harmless) return kUnset;
  }
  return s;
}

std::uint32_t BodyGenerator::intermediate(const Piece& piece) {
  const std::uint32_t word = intermediate_of(image_type(ir::kBoolType), cone_lifetime_);
  writer_.record(word, piece);
  return word;
}

ConeArena::Operand BodyGenerator::take(Literal literal) {
  ConeArena::Operand operand;
  const std::uint32_t v = value_of(literal);
  ValueInfo& info = values()[v];
  if (info.word == kUnset && info.link != kUnset && is_logic(body_.insts[v].op)) {
    operand.inverted = is_inverted(literal);
    if (info.uses > 1) {
      --info.uses;
      operand.cone = arena_.copy(info.link);
    } else {
      operand.cone = std::exchange(info.link, kUnset);
    }
    return operand;
  }
  const std::uint32_t word = info.word != kUnset ? info.word : place_words_[body_.insts[v].a];
  operand.piece = leaf_piece(word, is_inverted(literal));
  return operand;
}

Piece BodyGenerator::piece_of(Literal literal, std::uint32_t last) {
  if (is_constant(literal)) return constant_piece(literal == kTrueLiteral);
  cone_lifetime_ = last;
  const ConeArena::Operand operand = take(literal);
  if (operand.cone == ConeArena::kNone) return operand.piece;
  const Piece piece = arena_.close(operand.cone, *this);
  return operand.inverted ? inverted_piece(piece) : piece;
}

std::uint32_t BodyGenerator::bool_operand(Literal literal) {
  if (is_constant(literal)) {
    ir::Constant constant;
    constant.type = ir::kBoolType;
    constant.bits = literal == kTrueLiteral ? 1 : 0;
    return shared_.constants.word(constant);
  }
  const std::uint32_t v = value_of(literal);
  const ValueInfo& info = values()[v];
  if (!is_inverted(literal)) {
    if (info.word != kUnset) return info.word;
    if (!is_logic(body_.insts[v].op)) return place_words_[body_.insts[v].a];
  }
  const Piece piece = piece_of(literal, now_);
  cone_lifetime_ = now_;
  return intermediate(piece);
}

void BodyGenerator::logic(const Inst& inst) {
  ValueInfo& v = values()[now_];
  if (v.literal != now_ * 2) return;  // another name of an operand
  const Literal a = values()[inst.a].literal;
  const Literal b = values()[inst.b].literal;
  v.hazard = std::min(hazard_of(a), hazard_of(b));
  cone_lifetime_ = lifetime(now_);
  const ConeArena::Operand left = take(a);
  const ConeArena::Operand right = take(b);
  v.link = arena_.combine(logic_of(inst.op), left, right, *this);
  const bool shared = v.uses > 1 && v.root_leaves > kRecordInputs;
  if (!shared && v.last_use <= v.hazard) return;
  if (stored_first(v)) {
    v.store_first = true;
    return;
  }
  locate(now_);
}

bool BodyGenerator::stored_first(const ValueInfo& v) {
  const Inst& store = body_.insts[v.first_use];
  if (v.uses < 2 || store.op != Op::kStore || !is_static(store.a) || v.first_use > v.hazard) return false;
  return values()[store.b].literal == now_ * 2 && !v.crosses_label && v.last_use <= values()[v.first_use].hazard;
}

void BodyGenerator::locate(std::uint32_t v) {
  ValueInfo& info = values()[v];
  cone_lifetime_ = now_;
  const Piece piece = arena_.close(std::exchange(info.link, kUnset), *this);
  info.word = intermediate_of(image_type(ir::kBoolType), lifetime(v));
  info.hazard = kUnset;
  writer_.record(info.word, piece);
}

void BodyGenerator::store_bool(const Inst& inst) {
  const std::uint32_t to = place_words_[inst.a];
  const Literal literal = values()[inst.b].literal;
  if (!is_constant(literal)) {
    ValueInfo& v = values()[value_of(literal)];
    if (v.store_first && v.first_use == now_) {
      v.uses = 1;  // the later uses read the variable
      writer_.record(to, piece_of(literal, now_));
      v.word = to;
      v.hazard = values()[now_].hazard;
      return;
    }
  }
  const Piece piece = piece_of(literal, now_);
  if (piece.count == 1 && piece.leaf[0] == to && piece.table == leaf_piece(to, false).table) return;
  writer_.record(to, piece);
}

}  // namespace plc::bytecode
