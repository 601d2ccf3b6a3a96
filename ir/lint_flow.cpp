#include "ir/lint_flow.h"

#include <algorithm>
#include <unordered_set>

namespace plc::ir {
namespace {

using Known = BodyFlow::Known;

Known of(bool value) { return value ? Known::kTrue : Known::kFalse; }

Known evaluate(const Body& body, const Inst& inst, const std::vector<Known>& known) {
  const auto absorbed_by = [&](Known absorbing, Known neutral) {
    const Known a = known[inst.a];
    const Known b = known[inst.b];
    if (a == absorbing || b == absorbing) return absorbing;
    return a == neutral && b == neutral ? neutral : Known::kUnknown;
  };
  switch (inst.op) {
    case Op::kConst:
      return inst.type == kBoolType ? of(body.constants[inst.a].bits != 0) : Known::kUnknown;
    case Op::kAnd:
      return absorbed_by(Known::kFalse, Known::kTrue);
    case Op::kOr:
      return absorbed_by(Known::kTrue, Known::kFalse);
    case Op::kXor:
      if (known[inst.a] == Known::kUnknown || known[inst.b] == Known::kUnknown) return Known::kUnknown;
      return of(known[inst.a] != known[inst.b]);
    case Op::kNot:
      return known[inst.a] == Known::kUnknown ? Known::kUnknown : of(known[inst.a] == Known::kFalse);
    default:
      return Known::kUnknown;
  }
}

/// Turns "+1 here, -1 there" into the number of open spans at each position.
void accumulate(std::vector<std::uint32_t>& spans) {
  std::uint32_t open = 0;
  for (std::uint32_t& span : spans) {
    open += span;  // unsigned: the -1 at an end wraps and takes one away
    span = open;
  }
}

}  // namespace

BodyFlow::BodyFlow(const Body& body) {
  const auto size = static_cast<std::uint32_t>(body.insts.size());
  known.reserve(size);
  label_at.assign(body.label_count, kNowhere);
  for (std::uint32_t i = 0; i < size; ++i) {
    known.push_back(evaluate(body, body.insts[i], known));
    if (body.insts[i].op == Op::kLabel) label_at[body.insts[i].a] = i;
  }

  reached.assign(size, false);
  std::vector<std::uint32_t> entries = {0};
  while (!entries.empty()) {
    std::uint32_t at = entries.back();
    entries.pop_back();
    for (; at < size && !reached[at]; ++at) {
      reached[at] = true;
      if (may_jump(body, at)) entries.push_back(target(body, at));
      if (!falls_through(body, at)) break;
    }
  }

  skips.assign(size + 1, 0);
  loops.assign(size + 1, 0);
  for (std::uint32_t i = 0; i < size; ++i) {
    if (!reached[i] || !may_jump(body, i)) continue;
    const std::uint32_t to = target(body, i);
    if (to <= i) {
      ++loops[to];
      --loops[i + 1];
    } else if (body.insts[i].part != Part::kForControl) {
      ++skips[i + 1];
      --skips[to];
    }
  }
  accumulate(skips);
  accumulate(loops);
}

std::uint32_t BodyFlow::target(const Body& body, std::uint32_t index) const {
  const Inst& inst = body.insts[index];
  const bool jumps = inst.op == Op::kJump || inst.op == Op::kJumpIf || inst.op == Op::kJumpIfNot;
  return jumps ? label_at[inst.a] : kNowhere;
}

bool BodyFlow::may_jump(const Body& body, std::uint32_t index) const {
  const Inst& inst = body.insts[index];
  if (target(body, index) == kNowhere) return false;
  if (inst.op == Op::kJumpIf) return known[inst.b] != Known::kFalse;
  if (inst.op == Op::kJumpIfNot) return known[inst.b] != Known::kTrue;
  return true;
}

bool BodyFlow::falls_through(const Body& body, std::uint32_t index) const {
  const Inst& inst = body.insts[index];
  if (inst.op == Op::kJump || inst.op == Op::kReturn) return false;
  if (inst.op == Op::kJumpIf) return known[inst.b] != Known::kTrue;
  if (inst.op == Op::kJumpIfNot) return known[inst.b] != Known::kFalse;
  return true;
}

bool BodyFlow::can_avoid(const Body& body, const std::vector<std::uint32_t>& stops) const {
  // Instructions that no jump skips lie on every way, so only what lies between two of them needs a look.
  std::uint32_t begin = stops.front();
  while (begin > 0 && skips[begin] != 0) --begin;
  std::uint32_t end = stops.back();
  while (end < body.insts.size() && skips[end] != 0) ++end;
  std::unordered_set<std::uint32_t> seen;
  std::vector<std::uint32_t> open = {begin};
  while (!open.empty()) {
    const std::uint32_t at = open.back();
    open.pop_back();
    if (at >= end) return true;
    if (std::binary_search(stops.begin(), stops.end(), at) || !seen.insert(at).second) continue;
    const bool enters_for = body.insts[at].part == Part::kForControl;
    if (falls_through(body, at)) open.push_back(at + 1);
    // The way round is looked at first: it leads out of a large branch in one step.
    if (may_jump(body, at) && !(enters_for && target(body, at) > at)) open.push_back(target(body, at));
  }
  return false;
}

}  // namespace plc::ir
