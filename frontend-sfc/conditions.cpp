// Transitions: which are enabled, what their conditions say, what clears.
#include <algorithm>
#include <charconv>

#include "frontend-il/text.h"
#include "frontend-ld/lower.h"
#include "frontend-sfc/evaluation.h"
#include "frontend-st/names.h"
#include "frontend-st/text.h"

namespace plc::sfc {

using core::Code;
using ir::LabelId;
using ir::ValueId;

/// Blocks that are drawn inside the chart run once per evaluation; the conditions that they make are kept.
void Evaluation::lower_drawing() {
  if (c_.drawing.elements.empty()) return;
  for (std::uint32_t t = 0; t < c_.transitions.size(); ++t) {
    if (c_.transitions[t].condition.kind == Condition::Kind::kWire) wires_[t] = b_.hidden("wire", ir::kBoolType);
  }
  foreign([&] {
    ld::lower_conditions(c_.drawing, b_, [&](const plcopen::Element& e, std::optional<ValueId> value) {
      std::uint32_t t = 0;
      std::from_chars(e.text.data(), e.text.data() + e.text.size(), t);
      if (value) {
        store(wires_[t], *value);
      } else {
        b_.report(Code::P3105, c_.transitions[t].at,
                  "nothing that has a value is wired to the condition of the transition",
                  "wire a contact, a block or a variable to it, or write the condition as ST");
      }
    });
  });
}

void Evaluation::test() {
  // Groups of one step are tested where that step is; the others after them, which no condition can notice: it sees
  // the marking of this evaluation.
  steps_tree_.walk([&](std::uint32_t s) {
    const std::uint32_t group = chart_.plan.group_of_step[s];
    if (group == Plan::kNone || !chart_.plan.groups[group].is_simple()) return;
    when(active(s), [&] { test_group(chart_.plan.groups[group]); });
  });
  const auto any_source = [&](std::uint32_t i) {
    ValueId any{};
    for (const std::uint32_t s : chart_.plan.groups[joins_[i]].sources)
      any = any.valid() ? or_(any, active(s)) : active(s);
    return any;
  };
  joins_tree_.walk([&](std::uint32_t i) { when(any_source(i), [&] { test_group(chart_.plan.groups[joins_[i]]); }); },
                   any_source);
}

void Evaluation::test_group(const Group& group) {
  const LabelId end = b_.new_label();
  for (const std::uint32_t t : group.transitions) test_transition(group, t, end);
  b_.bind(end);
}

/// All steps of the set are active, none of them is left by a transition of this evaluation, and their minimal times
/// have passed. Invalid: always so, since the group's only step is active.
ValueId Evaluation::enabled(const Group& group, const std::vector<std::uint32_t>& sources) {
  ValueId all{};
  const auto add = [&](ValueId value) { all = all.valid() ? and_(all, value) : value; };
  for (const std::uint32_t s : sources) {
    if (!group.is_simple()) {
      add(active(s));
      add(b_.not_(load(chart_.steps[s].off)));
    }
    if (c_.steps[s].min_time.empty()) continue;
    if (const auto least = duration(c_.steps[s].min_time, c_.steps[s].at, "minimal time of a step")) {
      add(compare("GE", b_.load(time(s)), *least));
    }
  }
  return all;
}

void Evaluation::test_transition(const Group& group, std::uint32_t t, LabelId end) {
  const Transition& transition = c_.transitions[t];
  b_.set_source(transition.at);
  const LabelId next = b_.new_label();
  ValueId any{};
  for (const auto& sources : transition.sources) {
    const ValueId one = enabled(group, sources);
    if (one.valid()) any = any.valid() ? or_(any, one) : one;
  }
  if (any.valid()) b_.jump_if_not(any, next);
  const auto holds = condition(t);
  b_.set_source(transition.at);
  if (holds) {
    b_.probe(ir::ProbeKey::of(transition.at, ir::ProbeSide::kInput), *holds);
    b_.jump_if_not(*holds, next);
    b_.probe_reached(ir::ProbeKey::of(transition.at, ir::ProbeSide::kWhole));
    for (const auto& sources : transition.sources) {
      const ValueId one = transition.sources.size() > 1 ? enabled(group, sources) : ValueId{};
      if (one.valid()) {
        when(one, [&] { clear(transition, sources); });
      } else {
        clear(transition, sources);
      }
    }
    if (group.is_simple()) b_.jump(end);
  }
  b_.bind(next);
}

void Evaluation::clear(const Transition& transition, const std::vector<std::uint32_t>& sources) {
  for (const std::uint32_t s : sources) store(chart_.steps[s].off, true);
  for (const std::uint32_t s : transition.targets) enter(s);
  store(moved_, true);
}

std::optional<ValueId> Evaluation::condition(std::uint32_t t) {
  const Condition& condition = c_.transitions[t].condition;
  std::optional<ValueId> value;
  switch (condition.kind) {
    case Condition::Kind::kMissing:
      return std::nullopt;
    case Condition::Kind::kText:
      foreign([&] {
        // Tools take 1 and 0 for TRUE and FALSE.
        if (condition.text == "1" || condition.text == "0") {
          value = b_.constant_bool(condition.text == "1");
          return;
        }
        const auto operand = st::lower_expression(condition.text, condition.at, b_, ir::kBoolType);
        if (operand) value = b_.convert(*operand, ir::kBoolType, "condition of a transition");
      });
      break;
    case Condition::Kind::kInstructions:
      foreign([&] {
        const auto operand = il::lower_value(condition.text, condition.at, b_);
        if (operand) value = b_.convert(*operand, ir::kBoolType, "condition of a transition");
      });
      break;
    case Condition::Kind::kReference: {
      const std::uint32_t owner = b_.module().pous[b_.pou_index()].owner;
      const auto known =
          b_.module().find_transition(owner == ir::Pou::kDeclared ? b_.pou_index() : owner, condition.text);
      // A name that no transition has may be that of a BOOL variable.
      if (!known && st::is_variable_text(condition.text) &&
          st::find_name(b_.module(), b_.pou(), condition.text).is_place()) {
        foreign([&] {
          const auto operand = st::lower_expression(condition.text, condition.at, b_, ir::kBoolType);
          if (operand) value = b_.convert(*operand, ir::kBoolType, "condition of a transition");
        });
        break;
      }
      if (!known) {
        b_.report(Code::P3105, condition.at,
                  "condition refers to the transition \"" + condition.text + "\", which " + b_.pou().name + " has not",
                  "correct the name, or add the transition to the POU");
        return std::nullopt;
      }
      foreign([&] { b_.run_action(b_.self(), *known); });
      value = load(b_.module().transitions.at(*known).result);
      break;
    }
    case Condition::Kind::kWire: {
      const auto wire = wires_.find(t);
      if (wire == wires_.end()) return std::nullopt;
      value = load(wire->second);
      break;
    }
  }
  if (value && condition.negated) value = b_.not_(*value);
  if (!value || tip_ == kNoVariable) return value;
  // SFCTip goes on by hand; with SFCTipMode nothing else does.
  const ValueId asked = has(Flag::kTipMode) ? and_(*value, b_.not_(flag(Flag::kTipMode))) : *value;
  return or_(load(tip_), asked);
}

}  // namespace plc::sfc
