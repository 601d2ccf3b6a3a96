#include "convert/body_plan.h"

#include <algorithm>
#include <string_view>

namespace plc::convert {

using ir::Inst;
using ir::Op;
using ir::Place;
using ir::PlaceId;

BodyPlan::BodyPlan(const ir::Module& module, const ir::Pou& pou, const ir::Pou& owner)
    : module_(module), body_(pou.body) {
  const std::size_t count = body_.insts.size();
  uses_.assign(count, 0);
  last_use_.assign(count, 0);
  run_of_.assign(count, 0);
  chain_.assign(count, 0);
  watched_.assign(count, kNone);
  inline_.assign(count, false);
  in_chain_.assign(count, false);
  // A load, a store, a run, a load and a store for each input with an edge.
  constexpr std::size_t kPerEdge = 5;
  if (pou.owner == ir::Pou::kDeclared)
    first_ = static_cast<std::uint32_t>(std::min(count, owner.edges.size() * kPerEdge));
  find_labels();
  find_runs();
  count_uses();
  find_chains();
  find_inline();
  find_watched();
}

template <class Visit>
void BodyPlan::each_value_of(PlaceId place, const Visit& visit) const {
  for (PlaceId at = place; at.valid(); at = body_.places[at.index].parent) {
    const Place& p = body_.places[at.index];
    if (p.kind == Place::Kind::kElementAt || p.kind == Place::Kind::kDeref) visit(p.index);
  }
}

template <class Visit>
void BodyPlan::each_value(const Inst& inst, const Visit& visit) const {
  switch (inst.op) {
    case Op::kLoad:
    case Op::kRun:
    case Op::kMakeRef:
    case Op::kAddress:
      each_value_of(PlaceId{inst.a}, visit);
      break;
    case Op::kStore:
      each_value_of(PlaceId{inst.a}, visit);
      visit(inst.b);
      break;
    case Op::kCopy:
      each_value_of(PlaceId{inst.a}, visit);
      each_value_of(PlaceId{inst.b}, visit);
      break;
    case Op::kAnd:
    case Op::kOr:
    case Op::kXor:
    case Op::kSameRef:
    case Op::kInsert:
      visit(inst.a);
      visit(inst.b);
      break;
    case Op::kNot:
    case Op::kExtract:
    case Op::kRange:
    case Op::kPointerRef:
    case Op::kPointerTo32:
    case Op::kPointerFrom32:
      visit(inst.a);
      break;
    case Op::kJumpIf:
    case Op::kJumpIfNot:
      visit(inst.b);
      break;
    case Op::kCall:
      for (std::uint32_t i = 0; i < inst.count; ++i) visit(body_.args[inst.b + i].index);
      break;
    case Op::kCallPou:
      for (std::uint32_t i = 0; i < inst.count; ++i) {
        const ir::CallArg& arg = body_.call_args[inst.b + i];
        if (arg.kind == ir::CallArg::Kind::kOutput) {
          each_value_of(arg.place, visit);
        } else {
          visit(arg.value.index);
        }
      }
      break;
    default:
      break;
  }
}

void BodyPlan::find_labels() {
  labels_.assign(body_.label_count, 0);
  forward_.assign(body_.label_count, true);
  for (std::uint32_t i = 0; i < body_.insts.size(); ++i) {
    if (body_.insts[i].op == Op::kLabel) labels_[body_.insts[i].a] = i;
  }
  for (std::uint32_t i = 0; i < body_.insts.size(); ++i) {
    const Op op = body_.insts[i].op;
    const bool jumps = op == Op::kJump || op == Op::kJumpIf || op == Op::kJumpIfNot;
    if (jumps && labels_[body_.insts[i].a] <= i) forward_[body_.insts[i].a] = false;
  }
}

bool BodyPlan::is_input(ir::TypeRef instance, std::uint32_t field) const {
  const ir::Type& type = module_.types[instance];
  if (type.kind == ir::TypeKind::kBlock) {
    const stdlib::Direction direction = type.block->fields[field].direction;
    return direction == stdlib::Direction::kInput || direction == stdlib::Direction::kInOut;
  }
  if (type.kind != ir::TypeKind::kPou) return false;
  const ir::Role role = module_.pous[type.pou].variables[field].role;
  return role == ir::Role::kInput || role == ir::Role::kInOut;
}

/// Stores to inputs of an instance right before it runs, values in between, become arguments of the call.
void BodyPlan::find_runs() {
  for (std::uint32_t i = 0; i < body_.insts.size(); ++i) {
    if (body_.insts[i].op != Op::kRun) continue;
    const PlaceId instance{body_.insts[i].a};
    for (std::uint32_t j = i; j-- > first_;) {
      const Inst& inst = body_.insts[j];
      const bool value = inst.op == Op::kConst || inst.op == Op::kLoad || inst.op == Op::kAnd || inst.op == Op::kOr ||
                         inst.op == Op::kXor || inst.op == Op::kNot || inst.op == Op::kCall ||
                         inst.op == Op::kMakeRef || inst.op == Op::kExtract || inst.op == Op::kSameRef;
      if (value) continue;
      const Place* const place = inst.op == Op::kStore ? &body_.places[inst.a] : nullptr;
      if (place == nullptr || place->kind != Place::Kind::kField || place->parent != instance) break;
      if (!is_input(body_.places[instance.index].type, place->index)) break;
      // One argument for each input.
      bool again = false;
      for (std::uint32_t k = j + 1; k < i; ++k) again = again || (run_of_[k] == i && body_.insts[k].a == inst.a);
      if (again) break;
      run_of_[j] = i;
    }
  }
}

/// An instruction that makes a value and does nothing else.
bool BodyPlan::is_pure(std::uint32_t inst) const {
  switch (body_.insts[inst].op) {
    case Op::kConst:
    case Op::kLoad:
    case Op::kAnd:
    case Op::kOr:
    case Op::kXor:
    case Op::kNot:
    case Op::kExtract:
    case Op::kInsert:
    case Op::kMakeRef:
    case Op::kSameRef:
      return true;
    case Op::kCall:
      return body_.functions[body_.insts[inst].a]->spec->events.empty();
    default:
      return false;
  }
}

/// From the end on: a value that nobody wants needs no operands.
void BodyPlan::count_uses() {
  for (auto i = static_cast<std::uint32_t>(body_.insts.size()); i-- > first_;) {
    if (is_pure(i) && uses_[i] == 0) continue;
    // Arguments are written where the instance runs.
    const std::uint32_t at = run_of_[i] != 0 ? run_of_[i] : i;
    each_value(body_.insts[i], [&](std::uint32_t value) {
      ++uses_[value];
      last_use_[value] = std::max(last_use_[value], at);
    });
  }
}

/// One value that goes to several variables at once: a := b := value.
void BodyPlan::find_chains() {
  for (std::uint32_t i = first_; i < body_.insts.size(); ++i) {
    if (body_.insts[i].op != Op::kStore || in_chain_[i] || run_of_[i] != 0) continue;
    const std::uint32_t value = body_.insts[i].b;
    std::uint32_t count = 0;
    for (std::uint32_t j = i; j < body_.insts.size(); ++j, ++count) {
      const Inst& inst = body_.insts[j];
      if (inst.op != Op::kStore || inst.b != value || run_of_[j] != 0) break;
      bool indexed = false;
      each_value_of(PlaceId{inst.a}, [&](std::uint32_t) { indexed = true; });
      if (indexed) break;
    }
    if (count < 2 || count != uses_[value] || body_.insts[value].op == Op::kConst) continue;
    chain_[i] = count;
    for (std::uint32_t j = i + 1; j < i + count; ++j) in_chain_[j] = true;
    last_use_[value] = i;
    uses_[value] = 1;
  }
}

PlaceId BodyPlan::root_of(PlaceId place) const {
  while (body_.places[place.index].parent.valid()) place = body_.places[place.index].parent;
  return place;
}

bool BodyPlan::place_reads(PlaceId place, PlaceId root, int depth) const {
  const PlaceId own = root_of(place);
  const Place::Kind kind = body_.places[own.index].kind;
  const Place::Kind other = body_.places[root.index].kind;
  // What a reference points at may be anything.
  if (own == root || kind == Place::Kind::kDeref || other == Place::Kind::kDeref || other == Place::Kind::kSelf)
    return true;
  bool found = false;
  each_value_of(place, [&](std::uint32_t value) { found = found || reads(value, root, depth + 1); });
  return found;
}

bool BodyPlan::reads(std::uint32_t value, PlaceId root, int depth) const {
  constexpr int kDeepest = 200;
  if (depth > kDeepest) return true;
  const Inst& inst = body_.insts[value];
  if (inst.op == Op::kLoad) return place_reads(PlaceId{inst.a}, root, depth);
  bool found = false;
  each_value(inst,
             [&](std::uint32_t operand) { found = found || (inline_[operand] && reads(operand, root, depth + 1)); });
  return found;
}

/// True when computing the value can be an event, which counts once for each time.
bool BodyPlan::is_counted(std::uint32_t value, int depth) const {
  constexpr int kDeepest = 200;
  const Inst& inst = body_.insts[value];
  if (depth > kDeepest || inst.op == Op::kCallPou || inst.op == Op::kRange || inst.op == Op::kEno) return true;
  if (inst.op == Op::kCall && !body_.functions[inst.a]->spec->events.empty()) return true;
  if (inst.op == Op::kLoad || inst.op == Op::kMakeRef) {
    for (PlaceId at{inst.a}; at.valid(); at = body_.places[at.index].parent) {
      const Place::Kind kind = body_.places[at.index].kind;
      if (kind == Place::Kind::kElementAt || kind == Place::Kind::kDeref) return true;
    }
  }
  bool found = false;
  each_value(inst,
             [&](std::uint32_t operand) { found = found || (inline_[operand] && is_counted(operand, depth + 1)); });
  return found;
}

/// Value `i` may be computed at `use` instead: nothing in between changes what it reads, and it counts as often.
bool BodyPlan::can_move(std::uint32_t i, std::uint32_t use) const {
  constexpr std::uint32_t kFarthest = 5000;
  if (use - i > kFarthest) return false;
  const bool counted = is_counted(i, 0);
  for (std::uint32_t j = i + 1; j < use; ++j) {
    const Inst& inst = body_.insts[j];
    switch (inst.op) {
      case Op::kStore:
      case Op::kCopy:
        // An argument that is this value is written with the call.
        if (run_of_[j] == use && inst.b == i) break;
        if (run_of_[j] != 0 && run_of_[j] != use && run_of_[j] > use) return false;
        if (reads(i, root_of(PlaceId{inst.a}), 0)) return false;
        break;
      case Op::kRun:
      case Op::kCallPou:
        return false;
      case Op::kLabel:
      case Op::kJump:
      case Op::kJumpIf:
      case Op::kJumpIfNot:
      case Op::kReturn:
        if (counted || has_loops_) return false;
        break;
      case Op::kClearEvent:
      case Op::kEno:
        if (counted) return false;
        break;
      default:
        break;
    }
  }
  return true;
}

void BodyPlan::find_inline() {
  has_loops_ = std::find(forward_.begin(), forward_.end(), false) != forward_.end();
  const auto count = static_cast<std::uint32_t>(body_.insts.size());
  for (std::uint32_t i = first_; i < count; ++i) {
    const Inst& inst = body_.insts[i];
    if (inst.op == Op::kConst) {
      inline_[i] = true;
      continue;
    }
    // One output of a function of several is given by a statement: SPLIT_DATE(IN := d, MONTH => m).
    if (inst.op == Op::kCall && body_.functions[inst.a]->name.find('.') != std::string_view::npos) continue;
    // A variable that nothing writes in between may be read again for each use.
    const bool again = inst.op == Op::kLoad && uses_[i] > 1 && !is_counted(i, 0);
    if (uses_[i] != 1 && !again) continue;
    const std::uint32_t use = last_use_[i];
    // What a function changes must be changed before anything that follows is read.
    inline_[i] = inst.op == Op::kCallPou ? use == i + 1 : can_move(i, use);
  }
}

void BodyPlan::find_watched() {
  std::uint32_t calls = kNone;
  for (std::uint32_t i = first_; i < body_.insts.size(); ++i) {
    const Inst& inst = body_.insts[i];
    if (inst.op == Op::kClearEvent) calls = kNone;
    if (inst.op == Op::kEno) watched_[i] = calls;
    const bool call = inst.op == Op::kCall && !body_.functions[inst.a]->spec->events.empty();
    bool indexed = false;
    if (inst.op == Op::kLoad || inst.op == Op::kStore) {
      for (PlaceId at{inst.a}; at.valid(); at = body_.places[at.index].parent) {
        indexed = indexed || body_.places[at.index].kind == Place::Kind::kElementAt;
      }
    }
    if (call) calls = calls == kNone ? i : kSeveral;
    if (indexed || inst.op == Op::kRun || inst.op == Op::kCallPou || inst.op == Op::kRange) calls = kSeveral;
  }
}

}  // namespace plc::convert
