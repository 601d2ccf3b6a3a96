#include "frontend-ld/action_block.h"

#include <algorithm>

#include "core/text.h"
#include "frontend-st/names.h"
#include "frontend-st/text.h"

namespace plc::ld {

using core::Code;
using core::ElementKind;
using ir::Op;
using ir::PlaceId;
using ir::ValueId;
using plcopen::ActionLink;
using plcopen::Edge;
using plcopen::Storage;

namespace {

bool has_text(const ActionLink& action) { return !core::trimmed(action.text).empty(); }

/// The name as two actions of a body share it: letter case and blanks do not count.
std::string key_of(const ActionLink& action) {
  std::string key = core::folded(action.name);
  std::erase_if(key, [](char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; });
  return key;
}

std::string title(const ActionLink& action) {
  return action.name.empty() ? "action" : "action \"" + action.name + "\"";
}

}  // namespace

std::string action_summary(const plcopen::Element& element) {
  std::string summary;
  for (const ActionLink& action : element.actions) {
    if (!summary.empty()) summary += ", ";
    summary += (action.qualifier.empty() ? "N" : action.qualifier) + " " + (action.name.empty() ? "ST" : action.name);
  }
  return summary;
}

void ActionBlocks::report(const ActionLink& action, std::string message, std::string help) {
  b_.report(Code::P2004, action.at, std::move(message), std::move(help));
}

// ---- qualifiers ---------------------------------------------------------------------------------------------------

std::optional<ActionBlocks::Qualifier> ActionBlocks::qualifier_of(std::string_view text) {
  static constexpr std::pair<std::string_view, Qualifier> kQualifiers[] = {
      {"", Qualifier::kN},    {"N", Qualifier::kN},   {"R", Qualifier::kR},   {"S", Qualifier::kS},
      {"L", Qualifier::kL},   {"D", Qualifier::kD},   {"P", Qualifier::kP},   {"P1", Qualifier::kP},
      {"P0", Qualifier::kP0}, {"SD", Qualifier::kSd}, {"DS", Qualifier::kDs}, {"SL", Qualifier::kSl}};
  for (const auto& [name, qualifier] : kQualifiers) {
    if (core::iequals(name, text)) return qualifier;
  }
  return std::nullopt;
}

bool ActionBlocks::is_timed(Qualifier qualifier) {
  switch (qualifier) {
    case Qualifier::kL:
    case Qualifier::kD:
    case Qualifier::kSd:
    case Qualifier::kDs:
    case Qualifier::kSl:
      return true;
    default:
      return false;
  }
}

bool ActionBlocks::runs(const ActionLink& action) const {
  return has_text(action) || st::find_action(b_.module(), b_.pou(), action.name).has_value();
}

/// An R may come before what it resets, so the whole body is searched once.
void ActionBlocks::find_stored() {
  if (searched_) return;
  searched_ = true;
  for (fbd::NodeId node = 0; node < d_.graph().nodes.size(); ++node) {
    const plcopen::Element& e = d_.element(node);
    if (e.kind != ElementKind::kActionBlock) continue;
    for (std::uint32_t i = 0; i < e.actions.size(); ++i) {
      const ActionLink& one = e.actions[i];
      const auto qualifier = qualifier_of(one.qualifier);
      if (one.name.empty() || !qualifier) continue;
      if (runs(one)) texts_.insert(key_of(one));
      // S and DS store into the variable itself; SD and SL, and all actions written as ST, into memory of their own.
      const bool own = *qualifier == Qualifier::kSd || *qualifier == Qualifier::kSl;
      const bool into_variable = *qualifier == Qualifier::kS || *qualifier == Qualifier::kDs;
      if (own || (into_variable && runs(one))) stored_[key_of(one)].emplace_back(node, i);
    }
  }
}

// ---- memory -------------------------------------------------------------------------------------------------------

PlaceId ActionBlocks::stored(const ActionId& id) {
  auto& index = memories_[id].stored;
  if (!index) index = b_.hidden("stored." + std::to_string(action(id).local_id), ir::kBoolType);
  return b_.variable(*index);
}

PlaceId ActionBlocks::timer(const ActionId& id) {
  auto& index = memories_[id].timer;
  if (!index) {
    const ir::TypeRef type = b_.module().types.block(*stdlib::block_named("TON"));
    index = b_.hidden("timer." + std::to_string(action(id).local_id), type);
  }
  return b_.variable(*index);
}

ValueId ActionBlocks::store(const ActionId& id, ValueId set) {
  const PlaceId place = stored(id);
  d_.write_bool(place, set, Storage::kSet);
  return b_.load(place);
}

ValueId ActionBlocks::on_delay(const ActionId& id, ValueId in, ValueId duration) {
  const PlaceId instance = timer(id);
  b_.store(*b_.member(instance, "IN"), in);
  b_.store(*b_.member(instance, "PT"), duration);
  b_.run(instance);
  return b_.load(*b_.member(instance, "Q"));
}

// ---- one action ---------------------------------------------------------------------------------------------------

std::optional<PlaceId> ActionBlocks::variable(const ActionLink& action) {
  if (action.name.empty()) {
    report(action, "action of the action block names no variable and has no ST",
           "refer to a BOOL variable, or write the action as inline ST");
    return std::nullopt;
  }
  const std::string not_bool = title(action) + " of the action block is not a BOOL variable";
  const bool plain = action.name.find_first_of(".[%^") == std::string::npos;
  const bool known = !plain || st::find_name(b_.module(), b_.pou(), action.name).kind != st::Named::Kind::kNothing;
  if (!known || !st::is_variable_text(action.name)) {
    report(action, not_bool, "declare the variable, or name an action of the POU");
    return std::nullopt;
  }
  const auto place = st::lower_place(action.name, action.at, b_, true);
  if (place && b_.type_of(*place) != ir::kBoolType) {
    report(action, not_bool + ", but has type " + b_.module().types.name_of(b_.type_of(*place)),
           "refer to a BOOL variable, or write the action as inline ST");
    return std::nullopt;
  }
  return place;
}

std::optional<ValueId> ActionBlocks::duration(const ActionLink& action) {
  if (action.duration.empty()) {
    report(action, title(action) + " with qualifier " + action.qualifier + " has no duration",
           "write one, as in duration=\"T#2s\"");
    return std::nullopt;
  }
  constexpr ir::TypeRef kTime = ir::ref_of(core::TypeId::kTime);
  const auto operand = st::lower_expression(action.duration, action.at, b_, kTime);
  if (!operand) return std::nullopt;
  return b_.convert(*operand, kTime, "duration of " + title(action));
}

ActionBlocks::Activity ActionBlocks::activity(const ActionId& id, Qualifier qualifier, ValueId flow, ValueId duration) {
  const std::string hint = "action." + std::to_string(action(id).local_id);
  const auto until_over = [&](ValueId active) {
    return b_.logic(Op::kAnd, active, b_.not_(on_delay(id, active, duration)));
  };
  switch (qualifier) {
    case Qualifier::kN:
    case Qualifier::kR:
      return {flow, Storage::kNone};
    case Qualifier::kS:
      return {flow, Storage::kSet};
    case Qualifier::kP:
      return {d_.edge_of(flow, Edge::kRising, hint), Storage::kNone};
    case Qualifier::kP0:
      return {d_.edge_of(flow, Edge::kFalling, hint), Storage::kNone};
    case Qualifier::kL:
      return {until_over(flow), Storage::kNone};
    case Qualifier::kD:
      return {on_delay(id, flow, duration), Storage::kNone};
    case Qualifier::kDs:
      return {on_delay(id, flow, duration), Storage::kSet};
    case Qualifier::kSd:
      return {on_delay(id, store(id, flow), duration), Storage::kSet};
    case Qualifier::kSl:
      return {until_over(store(id, flow)), Storage::kNone};
  }
  return {flow, Storage::kNone};
}

/// Several actions of one block on one variable are OR (6.7.4: ACTION_CONTROL), as far as they write like normal coils.
void ActionBlocks::write(const ActionId& id, PlaceId variable, Activity activity) {
  bool first = true;
  if (activity.storage == Storage::kNone) {
    const auto [before, fresh] = written_.emplace(key_of(action(id)), activity.value);
    first = fresh;
    if (!fresh) activity.value = before->second = b_.logic(Op::kOr, before->second, activity.value);
  }
  d_.write_bool(variable, activity.value, activity.storage);
  if (first) d_.note_write(variable, id.first, activity.storage == Storage::kNone);
}

void ActionBlocks::run_text(const ActionId& id, ValueId active) {
  const ActionLink& one = action(id);
  const ir::LabelId skip = b_.new_label();
  b_.jump_if_not(active, skip);
  if (has_text(one)) {
    st::lower_statements(one.text, one.text_at, b_);
  } else {
    st::lower_statements(one.name + "();", one.at, b_);
  }
  b_.set_source(d_.element(id.first).at);
  b_.bind(skip);
}

/// Beside the variable itself R resets what is stored for it elsewhere in the body, so that its time starts anew.
void ActionBlocks::reset(const ActionId& id, ValueId flow) {
  const ActionLink& one = action(id);
  b_.probe(ir::ProbeKey::of(one.at, ir::ProbeSide::kWhole), flow);
  if (!texts_.contains(key_of(one))) {
    const auto place = variable(one);
    if (!place) return;
    d_.write_bool(*place, flow, Storage::kReset);
    d_.note_write(*place, id.first, false);
  }
  const auto others = stored_.find(key_of(one));
  if (others == stored_.end()) return;
  const ir::LabelId skip = b_.new_label();
  b_.jump_if_not(flow, skip);
  const ValueId off = b_.constant_bool(false);
  for (const ActionId& other : others->second) {
    b_.store(stored(other), off);
    // The timer of DS measures power, which R does not take away (6.7.4: DS_TMR).
    if (!is_timed(*qualifier_of(action(other).qualifier)) || core::iequals(action(other).qualifier, "DS")) continue;
    const PlaceId instance = timer(other);
    b_.store(*b_.member(instance, "IN"), off);
    b_.run(instance);
  }
  b_.bind(skip);
}

void ActionBlocks::lower_action(const ActionId& id, ValueId flow) {
  const ActionLink& one = action(id);
  const auto qualifier = qualifier_of(one.qualifier);
  if (!qualifier) {
    return report(one, "qualifier \"" + one.qualifier + "\" of " + title(one) + " is not known",
                  "qualifiers are N, R, S, L, D, P, P0, P1, SD, DS and SL");
  }
  const bool remembers =
      *qualifier != Qualifier::kN && *qualifier != Qualifier::kR && (*qualifier != Qualifier::kS || runs(one));
  if (remembers && b_.pou().kind == ir::PouKind::kFunction) {
    return report(one, title(one) + " with qualifier " + one.qualifier + " is in a function, which remembers nothing",
                  "draw it in a function block or a program");
  }
  if (*qualifier == Qualifier::kR) return reset(id, flow);
  std::optional<PlaceId> target;
  if (!runs(one)) {
    target = variable(one);
    if (!target) return;
  }
  ValueId time{};
  if (is_timed(*qualifier)) {
    const auto value = duration(one);
    if (!value) return;
    time = *value;
  }
  const Activity what = activity(id, *qualifier, flow, time);
  if (target) {
    b_.probe(ir::ProbeKey::of(one.at, ir::ProbeSide::kWhole), what.value);
    return write(id, *target, what);
  }
  const bool latched = *qualifier == Qualifier::kS || *qualifier == Qualifier::kDs;
  const ValueId active = latched ? store(id, what.value) : what.value;
  b_.probe(ir::ProbeKey::of(one.at, ir::ProbeSide::kWhole), active);
  run_text(id, active);
}

void ActionBlocks::lower(fbd::NodeId node, ValueId flow) {
  find_stored();
  written_.clear();
  const plcopen::Element& e = d_.element(node);
  if (e.negated) flow = b_.not_(flow);
  for (std::uint32_t i = 0; i < e.actions.size(); ++i) lower_action({node, i}, flow);
}

}  // namespace plc::ld
