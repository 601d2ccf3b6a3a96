// Blocks: their order, jumps between them, and the accumulator where several ways meet.
//
// Blocks are lowered in the order of the text, but none before one that leads to it: so the type that is in the
// accumulator is known where it begins. A value goes on to a block that only one way leads to; where ways meet it is
// kept in a variable, one for each type.
#include <algorithm>
#include <set>

#include "frontend-il/lowering.h"
#include "frontend-st/operators.h"
#include "frontend-st/static_type.h"

namespace plc::il {

using core::Code;
using ir::Operand;
using ir::TypeKind;
using ir::TypeRef;

bool Lowering::meets(BlockId id) const {
  // The beginning of the list is a way to its first block.
  return flow_.blocks[id].before.size() + (id == 0 ? 1 : 0) > 1;
}

ir::LabelId Lowering::label(BlockId id) {
  if (!labels_[id].valid()) labels_[id] = builder_.new_label();
  return labels_[id];
}

ir::PlaceId Lowering::kept(TypeRef type) {
  const auto known = kept_.find(type.index);
  if (known != kept_.end()) return known->second;
  return kept_.emplace(type.index, builder_.variable(builder_.hidden("accumulator", type))).first->second;
}

bool Lowering::lower_all() {
  const auto count = static_cast<BlockId>(flow_.blocks.size());
  const BlockId end = flow_.end();
  after_.resize(count);
  meetings_.resize(count);
  labels_.resize(count);
  std::vector<bool> done(count, false);
  std::set<BlockId> ready;
  std::vector<BlockId> order;
  if (end != 0) ready.insert(0);
  BlockId first_left = 0;
  std::optional<BlockId> before;
  // The block that runs next when none is jumped to.
  const auto go_on = [&](BlockId id) {
    if (before && flow_.blocks[*before].next && *flow_.blocks[*before].next != id) {
      builder_.jump(label(*flow_.blocks[*before].next));
    }
    before = id;
  };
  for (;;) {
    bool reached = true;
    BlockId id = 0;
    if (!ready.empty()) {
      id = *ready.begin();
      ready.erase(ready.begin());
    } else {
      while (first_left < end && done[first_left]) ++first_left;
      if (first_left == end) break;
      id = first_left;
      reached = false;
    }
    done[id] = true;
    go_on(id);
    lower_block(id, reached);
    if (!reached) continue;
    for (const auto& to : {flow_.blocks[id].jump, flow_.blocks[id].next}) {
      if (to && *to != end && !done[*to]) ready.insert(*to);
    }
  }
  go_on(end);
  enter(end, true);
  if (!gives_value_) return fine_;
  const std::uint32_t last = listing_.instructions.empty() ? 0 : listing_.instructions.back().begin;
  result_ = needed(last);
  if (!result_ && fine_) fail(Code::P4507, last, "no way leads to the end of the list with a value in the accumulator");
  return fine_;
}

void Lowering::lower_block(BlockId id, bool reached) {
  const Block& block = flow_.blocks[id];
  jump_condition_.reset();
  block_ = id;
  builder_.set_source(at(listing_.instructions[block.first]));
  enter(id, reached);
  for (std::uint32_t i = block.first; i < block.last; ++i) lower(i);
  brackets_.clear();
  leave(id, reached);
}

void Lowering::enter(BlockId id, bool reached) {
  const Block& block = flow_.blocks[id];
  if (block.jump_target || labels_[id].valid() || meets(id)) builder_.bind(label(id));
  accumulator_ = {};
  if (!reached) accumulator_.state = Accumulator::State::kFailed;
  if (!reached || !block.needs_value || block.before.empty()) return;
  if (!meets(id)) {
    accumulator_ = after_[block.before.front()];
    return;
  }
  if (id == 0) return;
  const Meeting& meeting = meetings_[id];
  if (!meeting.type.valid() || meeting.failed) {
    accumulator_.state = Accumulator::State::kFailed;
    return;
  }
  accumulator_.state = Accumulator::State::kValue;
  accumulator_.called = meeting.called;
  accumulator_.value = Operand::of(builder_.load(kept(meeting.type)), source_.locate(meeting.decided));
  accumulator_.value.text = "the accumulator";
}

// The jump at the end of a block comes after what later blocks need is kept.
void Lowering::leave(BlockId id, bool reached) {
  const Block& block = flow_.blocks[id];
  after_[id] = accumulator_;
  const Instruction& last = listing_.instructions[block.last - 1];
  if (reached) {
    for (const auto& to : {block.jump, block.next}) {
      // The first block begins without a value: what reads one there is an error.
      if (to && *to != 0 && meets(*to) && flow_.blocks[*to].needs_value) deliver(*to, last.begin);
    }
  }
  if (!block.jump) return;
  if (last.condition == Condition::kAlways) return builder_.jump(label(*block.jump));
  if (!jump_condition_) return;
  last.condition == Condition::kIfTrue ? builder_.jump_if(*jump_condition_, label(*block.jump))
                                       : builder_.jump_if_not(*jump_condition_, label(*block.jump));
}

TypeRef Lowering::plain_type(const Operand& operand) {
  if (const ir::Builder::Narrow* narrow = builder_.narrow_of(operand.value)) return ir::ref_of(narrow->type);
  const TypeRef type = builder_.type_of(operand.value);
  const ir::Type& known = types()[type];
  if (known.kind == TypeKind::kSubrange) return ir::ref_of(known.elementary);
  if (known.kind == TypeKind::kString) return types().string(known.elementary, core::kDefaultStringCapacity);
  return type;
}

/// The accumulator goes on to block `to`, where ways meet; `from` is where this way ends.
void Lowering::deliver(BlockId to, std::uint32_t from) {
  Meeting& meeting = meetings_[to];
  if (accumulator_.state == Accumulator::State::kFailed) {
    meeting.failed = true;
    return;
  }
  if (accumulator_.state == Accumulator::State::kEmpty) {
    if (!meeting.failed) {
      fail(Code::P4507, from, "the accumulator has no value on this way to an instruction that reads it",
           "load a value before, on every way");
    }
    meeting.failed = true;
    return;
  }
  if (accumulator_.called && !meeting.called) meeting.called = accumulator_.called;
  const bool typed = accumulator_.value.kind == Operand::Kind::kValue;
  if (!meeting.type.valid()) {
    meeting.decided = from;
    if (typed) {
      meeting.type = plain_type(accumulator_.value);
      const auto wanted = wanted_type(to, flow_.blocks[to].first);
      const bool strings = wanted && types()[*wanted].kind == TypeKind::kString;
      if (strings && types()[meeting.type].kind == TypeKind::kString) meeting.type = *wanted;
    } else if (const auto wanted = wanted_type(to, flow_.blocks[to].first)) {
      meeting.type = *wanted;
    } else if (const auto settled = builder_.settle(accumulator_.value)) {
      meeting.type = builder_.type_of(*settled);
    } else {
      meeting.failed = true;
      fine_ = false;
      return;
    }
  }
  const bool strings = typed && types()[meeting.type].kind == TypeKind::kString &&
                       types()[builder_.type_of(accumulator_.value.value)].kind == TypeKind::kString;
  if (typed && !strings && plain_type(accumulator_.value) != meeting.type) {
    const auto line = [&](std::uint32_t where) { return std::to_string(source_.locate(where).line); };
    fail(Code::P4506, from,
         "the accumulator is " + types().name_of(plain_type(accumulator_.value)) + " on this way and " +
             types().name_of(meeting.type) + " on that of line " + line(meeting.decided) +
             ", which meets it before line " +
             line(flow_.blocks[to].first < listing_.instructions.size()
                      ? listing_.instructions[flow_.blocks[to].first].begin
                      : from),
         "convert the value on one of them, or store it in a variable");
    meeting.failed = true;
    return;
  }
  fine_ = builder_.assign(kept(meeting.type), accumulator_.value, "the accumulator") && fine_;
}

/// The type of a literal that comes to `instruction` of `block`: of the first operand that it meets. Nothing when none
/// tells.
Lowering::Expected Lowering::wanted_type(BlockId block, std::uint32_t instruction) {
  std::set<BlockId> seen;
  std::vector<std::pair<BlockId, std::uint32_t>> open = {{block, instruction}};
  while (!open.empty()) {
    const auto [id, first] = open.back();
    open.pop_back();
    bool passed = true;
    for (std::uint32_t i = first; i < flow_.blocks[id].last && passed; ++i) {
      const Instruction& one = listing_.instructions[i];
      if (!reads_accumulator(one) && !writes_accumulator(one)) continue;
      if (const auto type = type_wanted_by(one)) return type;
      // What a bracket gives meets what was there before it.
      if (one.kind == Kind::kClose && id == block_ && !brackets_.empty()) {
        const Accumulator& before = brackets_.back().before;
        return before.state == Accumulator::State::kValue ? type_of(before.value) : std::nullopt;
      }
      const bool keeps_type = one.kind == Kind::kNot ||
                              (one.kind == Kind::kBinary && !one.opens && !st::is_comparison(one.op)) ||
                              !writes_accumulator(one);
      passed = keeps_type;
    }
    if (!passed) continue;
    for (const auto& to : {flow_.blocks[id].jump, flow_.blocks[id].next}) {
      if (!to || !seen.insert(*to).second) continue;
      open.emplace_back(*to, flow_.blocks[*to].first);
    }
  }
  return std::nullopt;
}

Lowering::Expected Lowering::type_wanted_by(const Instruction& one) {
  switch (one.kind) {
    case Kind::kStore:
    case Kind::kBinary:
      return st::static_type(listing_.ast, source_, one.operand, builder_.module(), &builder_.pou());
    case Kind::kSet:
    case Kind::kReset:
    case Kind::kJump:
    case Kind::kCall:
    case Kind::kReturn:
      return ir::kBoolType;
    default:
      return std::nullopt;
  }
}

}  // namespace plc::il
