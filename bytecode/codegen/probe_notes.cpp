#include "bytecode/codegen/probe_notes.h"

#include <algorithm>

namespace plc::bytecode {

using ir::Inst;
using ir::Op;

ProbeNotes::ProbeNotes(const ir::TypeTable& types, const ir::Body& body, const Analysis& analysis,
                       const std::vector<std::uint32_t>& place_words, const Layout& layout)
    : types_(types),
      body_(body),
      analysis_(analysis),
      place_words_(place_words),
      layout_(layout),
      wanted_(body.insts.size()),
      when_(body.insts.size(), kUnset),
      step_(body.insts.size(), kNoStep),
      probe_step_(body.probes.size(), kNoStep),
      label_order_(body.label_count) {
  for (std::uint32_t p = 0; p < body.probes.size(); ++p) {
    const ir::Probe& probe = body.probes[p];
    if (probe.value.valid()) {
      want(probe.value);
      if (probe.when.valid()) when_[probe.value.index] = probe.when.index;
    } else {
      by_position_.push_back(p);
    }
    if (probe.when.valid()) want(probe.when);
  }
  std::stable_sort(by_position_.begin(), by_position_.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return body.probes[a].before < body.probes[b].before; });
}

/// The value and all that it is made from.
void ProbeNotes::want(ir::ValueId value) {
  std::vector<std::uint32_t> open = {value.index};
  while (!open.empty()) {
    const std::uint32_t v = open.back();
    open.pop_back();
    if (wanted_[v] != 0) continue;
    wanted_[v] = 1;
    const Inst& inst = body_.insts[v];
    if (const auto same = same_as(v)) {
      if (!is_constant(*same)) open.push_back(value_of(*same));
    } else {
      if (is_logic(inst.op)) open.push_back(inst.b);
      if (is_logic(inst.op) || inst.op == Op::kNot) open.push_back(inst.a);
    }
  }
}

/// The constant, or the earlier value or its negation, that logic comes to without the rest of its operands, which the
/// code then does not compute.
std::optional<Literal> ProbeNotes::same_as(std::uint32_t value) const {
  const Literal literal = analysis_.values[value].literal;
  const bool itself = !is_constant(literal) && value_of(literal) == value;
  return !is_logic(body_.insts[value].op) || itself ? std::nullopt : std::optional(literal);
}

bool ProbeNotes::is_shown(ir::TypeRef type) const {
  const ir::TypeKind kind = types_[type].kind;
  return kind != ir::TypeKind::kReference && kind != ir::TypeKind::kPointer && types_.rep_of(type).has_value();
}

void ProbeNotes::move_to(std::uint32_t word) {
  if (word == word_) return;
  word_ = word;
  order_ = 0;
  since_label_ = false;
}

std::uint32_t ProbeNotes::add(ProbeOp op, std::uint32_t a, std::uint32_t b, std::uint32_t type, std::uint32_t when) {
  map_.steps.push_back({word_, order_, op, a, b, type, when});
  since_label_ = true;
  return static_cast<std::uint32_t>(map_.steps.size() - 1);
}

std::uint32_t ProbeNotes::capture(std::uint32_t operand, ir::TypeRef type, std::uint32_t when) {
  const std::uint32_t known = is_shown(type) ? layout_.known_type(type) : kNoIndex;
  if (operand == kUnset || known == kNoIndex) return add(ProbeOp::kNotComputed, 0, 0, kNoProbeType, when);
  return add(ProbeOp::kCapture, operand, 0, known, when);
}

std::uint32_t ProbeNotes::constant(const Inst& inst, std::uint32_t value, std::uint32_t when) {
  const ir::Constant& constant = body_.constants[inst.a];
  const auto rep = types_.rep_of(inst.type);
  const std::uint32_t known = is_shown(inst.type) ? layout_.known_type(inst.type) : kNoIndex;
  const auto low = static_cast<std::uint32_t>(constant.bits);
  const auto high = static_cast<std::uint32_t>(constant.bits >> 32);
  if (inst.type == ir::kBoolType) return add(ProbeOp::kConst, low & 1u, 0, kNoProbeType, when);
  if (rep == core::Rep::kStr || rep == core::Rep::kWstr) {
    // Where something reads it, it is one of the image's constants; that is known when all code is made.
    const std::uint32_t step = add(ProbeOp::kNotComputed, 0, 0, kNoProbeType, when);
    texts_.emplace_back(step, value);
    return step;
  }
  if (known == kNoIndex) return add(ProbeOp::kNotComputed, 0, 0, kNoProbeType, when);
  return add(ProbeOp::kConst, low, high, known, when);
}

std::uint32_t ProbeNotes::when_of(std::uint32_t value) const { return value == kUnset ? kNoStep : step_[value]; }

void ProbeNotes::begin(std::uint32_t i, std::uint32_t word) {
  move_to(word);
  for (; next_ < by_position_.size() && body_.probes[by_position_[next_]].before == i; ++next_) {
    const std::uint32_t p = by_position_[next_];
    const ir::Probe& probe = body_.probes[p];
    const std::uint32_t when = when_of(probe.when.index);
    probe_step_[p] = probe.place.valid()
                         ? capture(place_words_[probe.place.index], body_.places[probe.place.index].type, when)
                         : add(ProbeOp::kReached, 0, 0, kNoProbeType, when);
  }
  if (i >= wanted_.size() || wanted_[i] == 0) return;
  const Inst& inst = body_.insts[i];
  const std::uint32_t when = when_of(when_[i]);
  switch (inst.op) {
    case Op::kLoad:
      if (analysis_.places[inst.a].is_static()) step_[i] = capture(place_words_[inst.a], inst.type, when);
      return;
    case Op::kConst:
      step_[i] = constant(inst, i, when);
      return;
    case Op::kAnd:
    case Op::kOr:
    case Op::kXor: {
      if (const auto same = same_as(i)) {
        const std::uint32_t from = is_constant(*same) ? 0 : step_[value_of(*same)];
        step_[i] = is_constant(*same)   ? add(ProbeOp::kConst, *same == kTrueLiteral ? 1 : 0, 0, kNoProbeType, when)
                   : is_inverted(*same) ? add(ProbeOp::kNot, from, 0, kNoProbeType, when)
                                        : add(ProbeOp::kAnd, from, from, kNoProbeType, when);
        return;
      }
      const ProbeOp op = inst.op == Op::kAnd ? ProbeOp::kAnd : inst.op == Op::kOr ? ProbeOp::kOr : ProbeOp::kXor;
      step_[i] = add(op, step_[inst.a], step_[inst.b], kNoProbeType, when);
      return;
    }
    case Op::kNot:
      step_[i] = add(ProbeOp::kNot, step_[inst.a], 0, kNoProbeType, when);
      return;
    default:
      return;
  }
}

void ProbeNotes::end(std::uint32_t i, std::uint32_t word) {
  if (wanted_[i] == 0 || step_[i] != kNoStep) return;
  move_to(word);
  const ValueInfo& info = analysis_.values[i];
  // What was taken over by a store is in its variable, which may be of another type with the same representation.
  const bool taken_over = info.word != kUnset && info.link != kUnset;
  const ir::TypeRef own = body_.insts[i].type;
  const ir::TypeRef type = taken_over ? body_.places[body_.insts[info.link].a].type : own;
  // A text that the variable cuts off is nowhere whole.
  const bool whole = types_[own].kind != ir::TypeKind::kString || types_[type].capacity >= types_[own].capacity;
  step_[i] = capture(whole ? info.word : kUnset, type, when_of(when_[i]));
}

void ProbeNotes::label(std::uint32_t label, std::uint32_t word) {
  move_to(word);
  if (since_label_) ++order_;
  since_label_ = false;
  label_order_[label] = order_;
}

PouProbes ProbeNotes::take() {
  for (const auto& [step, value] : texts_) {
    const std::uint32_t operand = analysis_.values[value].word;
    if (operand == kUnset) continue;
    map_.steps[step].op = ProbeOp::kCapture;
    map_.steps[step].a = operand;
  }
  for (const auto& [word, label] : jumps_) {
    if (label_order_[label] != 0) map_.jumps.push_back({word, label_order_[label]});
  }
  std::sort(map_.jumps.begin(), map_.jumps.end(),
            [](const ProbeJump& x, const ProbeJump& y) { return x.word < y.word; });
  for (std::uint32_t p = 0; p < body_.probes.size(); ++p) {
    const ir::Probe& probe = body_.probes[p];
    const ir::ProbeKey& key = probe.key;
    const std::uint32_t step = probe.value.valid() ? step_[probe.value.index] : probe_step_[p];
    if (step == kNoStep) continue;
    map_.points.push_back({{0, key.local_id, key.line, key.column, key.pin, static_cast<DrawnSide>(key.side)}, step});
  }
  // Of what is read or computed several times, the first counts: --compat=beremiz, arguments of generic functions.
  const auto before = [](const ProbePoint& x, const ProbePoint& y) { return x.key < y.key; };
  std::stable_sort(map_.points.begin(), map_.points.end(), before);
  const auto last = std::unique(map_.points.begin(), map_.points.end(),
                                [](const ProbePoint& x, const ProbePoint& y) { return x.key == y.key; });
  map_.points.erase(last, map_.points.end());
  return std::move(map_);
}

}  // namespace plc::bytecode
