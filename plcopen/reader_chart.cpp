// Sequential function charts of TC6 files: steps, transitions and what joins them are drawn elements as all others;
// actions and times of steps that CODESYS and TwinCAT keep in addData, conditions in four forms, actions that are
// written or drawn in their block.
#include <fmt/core.h>

#include <limits>

#include "core/text.h"
#include "plcopen/reader_body.h"
#include "plcopen/reader_pou.h"

namespace plc::plcopen {

namespace {

constexpr std::int64_t kMaxId = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kMaxPriority = std::numeric_limits<std::int32_t>::max();

BodyFrame& frame(Reader& r) { return *r.bodies.back(); }
Element& element(Reader& r) { return r.bodies.back()->element; }

void start_chart_step(Reader& r, const Tag& tag) {
  Element& e = open_element(r, tag, ElementKind::kStep, r.integer(tag, Attr::kLocalId, -1, kMaxId));
  e.chart = std::make_shared<ChartPart>();
  e.chart->initial = r.flag(tag, Attr::kInitialStep);
  e.negated = r.flag(tag, Attr::kNegated);
  e.text = r.required_name(tag, Attr::kName);
  e.text_at = e.at;
}

void start_macro_step(Reader& r, const Tag& tag) {
  Element& e = open_element(r, tag, ElementKind::kMacroStep, r.integer(tag, Attr::kLocalId, -1, kMaxId));
  e.chart = std::make_shared<ChartPart>();
  e.text = r.optional_name(tag, Attr::kName);
  e.text_at = e.at;
}

void start_jump_step(Reader& r, const Tag& tag) {
  Element& e = open_element(r, tag, ElementKind::kJumpStep, r.integer(tag, Attr::kLocalId, -1, kMaxId));
  e.text = r.required_name(tag, Attr::kTargetName);
  e.text_at = e.at;
}

void start_chart_transition(Reader& r, const Tag& tag) {
  Element& e = open_element(r, tag, ElementKind::kTransition, r.integer(tag, Attr::kLocalId, -1, kMaxId));
  e.chart = std::make_shared<ChartPart>();
  e.chart->priority = r.integer(tag, Attr::kPriority, -1, kMaxPriority);
}

template <ElementKind kKind>
void start_branch(Reader& r, const Tag& tag) {
  open_element(r, tag, kKind, r.integer(tag, Attr::kLocalId, -1, kMaxId));
}

// ---- conditions -----------------------------------------------------------------------------------------------

void start_condition(Reader& r, const Tag& tag) {
  if (element(r).chart != nullptr) element(r).chart->negated = r.flag(tag, Attr::kNegated);
}

void condition_reference(Reader& r, const Tag& tag) {
  element(r).chart->reference = r.required_name(tag, Attr::kName);
  element(r).chart->text_at = r.element_place(tag.at);
}

void condition_point(Reader& r, const Tag& tag) {
  Pin& pin = element(r).chart->condition;
  pin.has_point_in = true;
  pin.negated = element(r).chart->negated;
  pin.at = r.element_place(tag.at);
  frame(r).pin = &pin;
}

/// Version 1 has the wires of a condition without their connection point.
void condition_wire(Reader& r, const Tag& tag) {
  condition_point(r, tag);
  Connection& connection = add_connection(r, tag);
  connection.ref_local_id = r.integer(tag, Attr::kRefLocalId, -1, kMaxId);
  connection.formal_parameter = core::trimmed(tag.attributes.get(Attr::kFormalParameter));
}

/// A body inside of an element, in a frame of its own while it is read.
PouFrame& start_inner(Reader& r, const Tag& tag) {
  auto pou = std::make_unique<PouFrame>();
  pou->pou.kind = r.pous.empty() ? PouKind::kProgram : r.pous.back()->pou.kind;
  pou->pou.at = r.element_place(tag.at);
  pou->is_action = true;
  r.pous.push_back(std::move(pou));
  open_body(r, tag);
  return *r.pous.back();
}

std::unique_ptr<PouFrame> end_inner(Reader& r) {
  if (frame(r).body.language != Language::kNone) finish_body(r);
  r.bodies.pop_back();
  std::unique_ptr<PouFrame> own = std::move(r.pous.back());
  r.pous.pop_back();
  return own;
}

/// The POU that is open, beyond its actions and what is inside of elements.
PouFrame& open_owner(Reader& r) {
  std::size_t i = r.pous.size() - 1;
  while (i != 0 && r.pous[i]->is_action) --i;
  return *r.pous[i];
}

/// The chart in a macro step, an action in its block.
void start_inner_body(Reader& r, const Tag& tag) { start_inner(r, tag); }

void end_macro_body(Reader& r) {
  const std::unique_ptr<PouFrame> own = end_inner(r);
  if (r.bodies.empty() || own->pou.bodies.empty() || element(r).kind != ElementKind::kMacroStep) return;
  element(r).chart->macro = std::make_shared<Body>(std::move(own->pou.bodies.front()));
}

/// A condition in a language of its own: the body of a transition of the POU that only this one refers to.
void start_inline(Reader& r, const Tag& tag) { start_inner(r, tag).pou.result = r.optional_name(tag, Attr::kName); }

void end_inline(Reader& r) {
  const std::unique_ptr<PouFrame> own = end_inner(r);
  if (r.bodies.empty() || own->pou.bodies.empty() || element(r).chart == nullptr) return;
  ChartPart& part = *element(r).chart;
  Body& body = own->pou.bodies.front();
  if (body.language == Language::kSt) {
    part.text_at = r.element_place(body.text_at.line != 0 ? body.text_at : body.at);
    part.text = std::move(body.text);
    return;
  }
  if (r.pous.empty()) return;
  // No name of a file has a #.
  PouFrame& owner = open_owner(r);
  std::vector<Pou>& transitions = owner.pou.transitions;
  const std::string_view outside = owner.is_action ? std::string_view(owner.pou.name) : std::string_view();
  own->pou.name = fmt::format("#condition.{}{}.{}", outside, transitions.size(), element(r).at.local_id);
  // A list leaves its result in the accumulator; a drawing needs a name for it, which hides no variable.
  const bool taken = owner.variable_names.contains(owner.pou.variables, "condition");
  if (own->pou.result.empty() && body.language != Language::kIl && !taken) own->pou.result = "condition";
  part.reference = own->pou.name;
  part.text_at = own->pou.at;
  transitions.push_back(std::move(own->pou));
}

/// ST stays at the action; what is in another language is an action of the POU, with a name that is free if it has
/// none.
void end_inline_action(Reader& r) {
  const std::unique_ptr<PouFrame> own = end_inner(r);
  if (r.bodies.empty() || own->pou.bodies.empty() || element(r).actions.empty()) return;
  Body& body = own->pou.bodies.front();
  if (own->pou.bodies.size() == 1 && body.language == Language::kSt) {
    ActionLink& action = element(r).actions.back();
    action.text = std::move(body.text);
    action.text_at = r.element_place(body.text_at);
    return;
  }
  if (r.pous.empty()) return;
  PouFrame& owner = open_owner(r);
  std::vector<Pou>& actions = owner.pou.actions;
  const auto is_taken = [&](const std::string& name) {
    return owner.action_names.contains(actions, name) || owner.variable_names.contains(owner.pou.variables, name);
  };
  own->pou.name = element(r).actions.back().name;  // of a reference beside it
  if (own->pou.name.empty()) {
    // An action outside of its POU is one of several there.
    const std::string prefix = owner.is_action ? owner.pou.name + "_drawn_" : "drawn_action_";
    std::size_t number = actions.size();
    do own->pou.name = prefix + std::to_string(++number);
    while (is_taken(own->pou.name));
    name_action(r, own->pou.name);
  }
  actions.push_back(std::move(own->pou));
}

template <Language kLanguage>
void start_inline_drawing(Reader& r, const Tag& tag) {
  set_language(r, tag, kLanguage);
}

template <Language kLanguage>
void start_inline_code(Reader& r, const Tag& tag) {
  set_language(r, tag, kLanguage);
  begin_code(r, tag);
}

// ---- CODESYS and TwinCAT --------------------------------------------------------------------------------------

/// Attributes of elements by the beginning of their guid.
struct GuidRow {
  std::string_view begin;
  void (*take)(ChartPart&, std::string);
};
constexpr GuidRow kGuids[] = {
    {"700a583f", [](ChartPart& part, std::string value) { part.main = std::move(value); }},
    {"a6b08bd8", [](ChartPart& part, std::string value) { part.entry = std::move(value); }},
    {"a2621e18", [](ChartPart& part, std::string value) { part.exit = std::move(value); }},
    {"cacf1a68", [](ChartPart& part, std::string value) { part.min_time = std::move(value); }},
    {"b693554c", [](ChartPart& part, std::string value) { part.max_time = std::move(value); }},
    // NOLINTNEXTLINE(performance-unnecessary-value-param): one signature for all
    {"01580b27", [](ChartPart& part, std::string value) { part.excluded = core::iequals(value, "true"); }},
};

void start_attribute(Reader& r, const Tag& tag) {
  if (!r.bodies.empty()) frame(r).guid = core::trimmed(tag.attributes.get(Attr::kGuid));
  r.begin_text();
}

void end_attribute(Reader& r) {
  std::string value = r.take_text();
  if (r.bodies.empty() || !frame(r).element_open || frame(r).action_open || element(r).chart == nullptr) return;
  r.project.has_3s_charts = true;
  for (const GuidRow& row : kGuids) {
    if (frame(r).guid.starts_with(row.begin)) return row.take(*element(r).chart, std::move(value));
  }
}

/// <Init Declare="true" Use="true"/>: the flag SFCInit acts though the POU does not declare it.
void flag_setting(Reader& r, const Tag& tag) {
  if (r.bodies.empty() || frame(r).body.language != Language::kSfc) return;
  r.project.has_3s_charts = true;
  if (r.flag(tag, Attr::kDeclare) && r.flag(tag, Attr::kUse)) {
    frame(r).body.flags.push_back("SFC" + std::string(tag.name));
  }
}

constexpr Rule part(std::string_view name, StartHandler handler) {
  return used(State::kSfc, name, State::kElement, handler, close_element);
}

constexpr Rule kRules[] = {
    part("step", start_chart_step),
    part("macroStep", start_macro_step),
    part("jumpStep", start_jump_step),
    part("transition", start_chart_transition),
    part("selectionDivergence", start_branch<ElementKind::kSelectionDivergence>),
    part("selectionConvergence", start_branch<ElementKind::kSelectionConvergence>),
    part("simultaneousDivergence", start_branch<ElementKind::kSimultaneousDivergence>),
    part("simultaneousConvergence", start_branch<ElementKind::kSimultaneousConvergence>),
    used(State::kSfc, "addData", State::kAddData),

    used(State::kElement, "body", State::kBody, start_inner_body, end_macro_body),
    ignored(State::kElement, "connectionPointOutAction", kReasonLayout),
    used(State::kElement, "condition", State::kCondition, start_condition),
    used(State::kCondition, "reference", State::kLeaf, condition_reference),
    used(State::kCondition, "connectionPointIn", State::kPointIn, condition_point, close_pin),
    used(State::kCondition, "connection", State::kConnection, condition_wire, close_pin),
    used(State::kCondition, "inline", State::kInline, start_inline, end_inline),
    used(State::kInline, "ST", State::kFormatted, start_inline_code<Language::kSt>, end_code),
    used(State::kInline, "IL", State::kFormatted, start_inline_code<Language::kIl>, end_code),
    used(State::kInline, "LD", State::kDrawing, start_inline_drawing<Language::kLd>),
    used(State::kInline, "FBD", State::kDrawing, start_inline_drawing<Language::kFbd>),
    ignored(State::kCondition, "documentation", kReasonNote),

    used(State::kAction, "inline", State::kBody, start_inner_body, end_inline_action),

    used(State::kVendor, "attributes", State::kSfcAttributes),
    used(State::kSfcAttributes, "attribute", State::kText, start_attribute, end_attribute),
    used(State::kVendor, "SFCSettings", State::kSfcSettings),
    used(State::kSfcSettings, "Flags", State::kSfcFlags),
    ignored(State::kSfcSettings, "*", kReasonEditor),
    used(State::kSfcFlags, "*", State::kLeaf, flag_setting),
};

}  // namespace

std::span<const Rule> chart_rules() {
  // Conditions are drawn inside a chart with the elements of LD and FBD.
  static const std::vector<Rule> kAll = [] {
    std::vector<Rule> all(std::begin(kRules), std::end(kRules));
    for (Rule rule : body_rules()) {
      if (rule.parent != State::kDrawing || rule.name == "*") continue;
      rule.parent = State::kSfc;
      all.push_back(rule);
    }
    return all;
  }();
  return kAll;
}

}  // namespace plc::plcopen
