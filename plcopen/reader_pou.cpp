// POUs: heads, interfaces, textual bodies, charts.
#include "plcopen/reader_pou.h"

#include <fmt/core.h>

#include <algorithm>
#include <numeric>

#include "core/text.h"
#include "plcopen/reader_types.h"

namespace plc::plcopen {

namespace {

Body& body(Reader& r) { return r.bodies.back()->body; }

void start_body(Reader& r, const Tag& tag) {
  open_body(r, tag);
  body(r).name = r.optional_name(tag, Attr::kWorksheetName);
}

template <Language kLanguage>
void start_drawing(Reader& r, const Tag& tag) {
  set_language(r, tag, kLanguage);
}

void start_chart(Reader& r, const Tag& tag) {
  set_language(r, tag, Language::kSfc);
  if (!r.pous.empty()) r.pous.back()->pou.has_chart = true;
}

template <Language kLanguage>
void start_code(Reader& r, const Tag& tag) {
  set_language(r, tag, kLanguage);
  begin_code(r, tag);
}

void start_pou_transition(Reader& r, const Tag& tag) {
  open_pou(r, tag, r.pous.empty() ? PouKind::kProgram : r.pous.back()->pou.kind);
  r.pous.back()->is_action = true;
}

void close_pou_transition(Reader& r) {
  const std::unique_ptr<PouFrame> frame = std::move(r.pous.back());
  r.pous.pop_back();
  if (!frame->pou.name.empty() && !r.pous.empty()) r.pous.back()->pou.transitions.push_back(std::move(frame->pou));
}

void pou_note(Reader& r) { r.pous.back()->pou.documentation = r.take_text(); }

constexpr Rule kRules[] = {
    anchored(State::kPous, "pou", State::kPou, start_pou, close_pou),
    used(State::kPou, "interface", State::kInterface),
    used(State::kPou, "actions", State::kActions),
    used(State::kPou, "transitions", State::kActions),
    anchored(State::kPou, "body", State::kBody, start_body, close_body),
    used(State::kPou, "addData", State::kAddData),
    preserved(State::kPou, "documentation", State::kFormatted, kReasonKept, start_text, pou_note),

    used(State::kInterface, "returnType", State::kType, push_return_type, pop_type),
    used(State::kInterface, "inputVars", State::kVarList, start_pou_list<Section::kInput>, end_var_list),
    used(State::kInterface, "outputVars", State::kVarList, start_pou_list<Section::kOutput>, end_var_list),
    used(State::kInterface, "inOutVars", State::kVarList, start_pou_list<Section::kInOut>, end_var_list),
    used(State::kInterface, "localVars", State::kVarList, start_pou_list<Section::kLocal>, end_var_list),
    used(State::kInterface, "tempVars", State::kVarList, start_pou_list<Section::kTemp>, end_var_list),
    used(State::kInterface, "externalVars", State::kVarList, start_pou_list<Section::kExternal>, end_var_list),
    used(State::kInterface, "globalVars", State::kVarList, start_pou_list<Section::kGlobal>, end_var_list),
    used(State::kInterface, "accessVars", State::kVarList, start_pou_list<Section::kAccess>, end_var_list),
    used(State::kInterface, "addData", State::kAddData),
    ignored(State::kInterface, "documentation", kReasonNote),

    anchored(State::kActions, "action", State::kPouAction, start_pou_action, close_pou_action),
    anchored(State::kActions, "transition", State::kPouAction, start_pou_transition, close_pou_transition),

    anchored(State::kPouAction, "body", State::kBody, start_body, close_body),
    used(State::kPouAction, "addData", State::kAddData),
    preserved(State::kPouAction, "documentation", State::kFormatted, kReasonKept, start_text, pou_note),

    used(State::kBody, "LD", State::kDrawing, start_drawing<Language::kLd>),
    used(State::kBody, "FBD", State::kDrawing, start_drawing<Language::kFbd>),
    used(State::kBody, "ST", State::kFormatted, start_code<Language::kSt>, end_code),
    used(State::kBody, "IL", State::kFormatted, start_code<Language::kIl>, end_code),
    used(State::kBody, "SFC", State::kSfc, start_chart),
    used(State::kBody, "addData", State::kAddData),
    ignored(State::kBody, "documentation", kReasonNote),
};

}  // namespace

void start_pou(Reader& r, const Tag& tag) {
  open_pou(r, tag, PouKind::kProgram);
  const std::string_view kind = core::trimmed(tag.attributes.get(Attr::kPouType));
  for (const PouKind known : {PouKind::kProgram, PouKind::kFunctionBlock, PouKind::kFunction}) {
    if (core::iequals(kind, pou_kind_name(known))) {
      r.pous.back()->pou.kind = known;
      return;
    }
  }
  if (kind.empty()) {
    r.report(core::Code::P1009, tag.at, "element \"pou\" has no pouType");
  } else {
    r.report(core::Code::P1010, tag.at,
             fmt::format("pouType is none of program, functionBlock, function: \"{}\"", kind.substr(0, 60)));
  }
}

void open_pou(Reader& r, const Tag& tag, PouKind kind) {
  std::string name = r.required_name(tag, Attr::kName);
  auto frame = std::make_unique<PouFrame>();
  frame->pou.name = std::move(name);
  frame->pou.kind = kind;
  frame->pou.at = tag.at;
  r.pous.push_back(std::move(frame));
}

void close_pou(Reader& r) {
  PouFrame& frame = *r.pous.back();
  if (!frame.body_seen) {
    r.report(core::Code::P1011, frame.pou.at,
             fmt::format("{} \"{}\" has no body", pou_kind_name(frame.pou.kind), frame.pou.name),
             "export the POU with its body, or remove it");
  }
  if (!std::is_sorted(frame.body_orders.begin(), frame.body_orders.end())) {
    std::vector<std::size_t> order(frame.pou.bodies.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return frame.body_orders[a] < frame.body_orders[b]; });
    std::vector<Body> sorted;
    sorted.reserve(order.size());
    for (const std::size_t i : order) sorted.push_back(std::move(frame.pou.bodies[i]));
    frame.pou.bodies = std::move(sorted);
  }
  r.note_extent(frame.pou.name, frame.pou.at);
  r.project.pous.push_back(std::move(frame.pou));
  r.pous.pop_back();
}

void start_pou_action(Reader& r, const Tag& tag) {
  const PouKind kind = r.pous.empty() ? PouKind::kProgram : r.pous.back()->pou.kind;
  open_pou(r, tag, kind);
  r.pous.back()->is_action = true;
}

void close_pou_action(Reader& r) {
  const std::unique_ptr<PouFrame> frame = std::move(r.pous.back());
  r.pous.pop_back();
  if (frame->pou.name.empty()) return;  // said so
  if (!r.pous.empty()) {
    r.pous.back()->pou.actions.push_back(std::move(frame->pou));
    return;
  }
  // The path ends with the POU and the action itself.
  const std::size_t depth = frame->path.size();
  r.loose_actions.push_back({depth < 2 ? std::string() : frame->path[depth - 2], std::move(frame->pou)});
}

void path_structure(Reader& r, const Tag& tag) {
  if (r.pous.empty() || !r.pous.back()->is_action) return;
  r.pous.back()->path.emplace_back(core::trimmed(tag.attributes.get(Attr::kName)));
}

void open_body(Reader& r, const Tag& tag) {
  auto frame = std::make_unique<BodyFrame>();
  frame->body.at = tag.at;
  r.bodies.push_back(std::move(frame));
  if (!r.pous.empty()) r.pous.back()->body_seen = true;
}

void close_body(Reader& r) {
  const BodyFrame& frame = *r.bodies.back();
  if (frame.body.language == Language::kNone && !frame.foreign.empty() && !r.pous.empty()) {
    r.pous.back()->pou.unread = fmt::format("has a body in \"{}\", which is not read", frame.foreign.substr(0, 60));
  }
  finish_body(r);
  r.bodies.pop_back();
}

void set_language(Reader& r, const Tag& tag, Language language) {
  BodyFrame& frame = *r.bodies.back();
  if (frame.body.language != Language::kNone) {
    // A second language in one body element: a worksheet of its own.
    std::string name = frame.body.name;
    finish_body(r);
    frame = BodyFrame{};
    frame.body.at = tag.at;
    frame.body.name = std::move(name);
  }
  frame.body.language = language;
}

void report_chart(Reader& r, const Tag& tag) {
  if (r.pous.empty()) return;
  // Once for a POU and its actions.
  const std::size_t owner = r.pous.back()->is_action && r.pous.size() > 1 ? 2 : 1;
  if (std::exchange(r.pous[r.pous.size() - owner]->chart_reported, true)) return;
  r.report(core::Code::P1016, tag.at, "sequential function chart in the form of IEC 61131-10, which is not read",
           "export the project as PLCopen XML 2.01 (TC6), or write the chart as text");
}

void begin_code(Reader& r, const Tag& tag) {
  body(r).text_at = tag.at;
  body(r).text_at.kind = ElementKind::kText;
  r.begin_text();
}

void end_code(Reader& r) {
  Body& b = body(r);
  b.text = r.take_text(&b.text_at);
}

std::span<const Rule> pou_rules() { return kRules; }

}  // namespace plc::plcopen
