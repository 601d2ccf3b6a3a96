// LD and FBD bodies in the spelling of IEC 61131-10: rungs and networks, objects typed by xsi:type, wires that name the
// output point instead of the element.
#include <fmt/core.h>

#include <algorithm>
#include <limits>

#include "core/text.h"
#include "plcopen/reader_body.h"
#include "plcopen/reader_pou.h"
#include "plcopen/reader_types.h"

namespace plc::plcopen {

namespace {

constexpr std::int64_t kMaxId = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kMaxOrder = 1'000'000'000;
/// Added to the index of an in-out pin in OutPoint::pin.
constexpr std::uint32_t kInOutPin = std::uint32_t{1} << 31;

BodyFrame& frame(Reader& r) { return *r.bodies.back(); }
Element& element(Reader& r) { return r.bodies.back()->element; }

template <Language kLanguage>
void start_drawing(Reader& r, const Tag& tag) {
  open_body(r, tag);
  frame(r).body.name = r.optional_name(tag, Attr::kName);
  frame(r).order = static_cast<std::int32_t>(r.integer(tag, Attr::kEvaluationOrder, 0, kMaxOrder));
  set_language(r, tag, kLanguage);
}

void start_network(Reader& r, const Tag& tag) {
  BodyFrame& f = frame(r);
  ++f.network;
  f.network_begin = static_cast<std::uint32_t>(f.body.elements.size());
  // Without an order of its own a network stays where it is drawn.
  f.orders.push_back(r.integer(tag, Attr::kEvaluationOrder, f.orders.empty() ? 0 : f.orders.back(), kMaxOrder));
  f.out_points.clear();
}

/// Elements have no localId here: they are numbered as drawn.
Element& open_object(Reader& r, const Tag& tag, ElementKind kind) {
  Element& e = open_element(r, tag, kind, static_cast<std::int64_t>(frame(r).body.elements.size()) + 1);
  e.negated = r.flag(tag, Attr::kNegated);
  e.edge = r.edge(tag, Attr::kEdge);
  e.storage = r.storage(tag, tag.attributes.has(Attr::kLatch) ? Attr::kLatch : Attr::kStorage);
  return e;
}

template <ElementKind kKind, Attr kText>
void start_object(Reader& r, const Tag& tag) {
  Element& e = open_object(r, tag, kKind);
  e.text = core::trimmed(tag.attributes.get(kText));
  e.text_at = r.element_place(r.value_place(tag, kText));
}

template <ElementKind kKind>
void start_plain(Reader& r, const Tag& tag) {
  open_object(r, tag, kKind);
}

void start_jump(Reader& r, const Tag& tag) {
  Element& e = open_object(r, tag, ElementKind::kJump);
  e.text =
      core::trimmed(tag.attributes.get(tag.attributes.has(Attr::kTargetLabel) ? Attr::kTargetLabel : Attr::kLabel));
  e.text_at = e.at;
}

/// A contact that compares: the same as a contact on the expression.
void start_compare(Reader& r, const Tag& tag) {
  Element& e = open_object(r, tag, ElementKind::kContact);
  e.text = fmt::format("({}) {} ({})", core::trimmed(tag.attributes.get(Attr::kOperand1)),
                       core::trimmed(tag.attributes.get(Attr::kCompareOperator)),
                       core::trimmed(tag.attributes.get(Attr::kOperand2)));
  e.text_at = e.at;
  e.text_at.column = 0;  // the text is nowhere in the file as it is
}

void start_block(Reader& r, const Tag& tag) {
  Element& e = open_object(r, tag, ElementKind::kBlock);
  const std::string_view type = core::trimmed(tag.attributes.get(Attr::kTypeName));
  e.text = type.substr(type.rfind('\\') + 1);
  e.text_at = e.at;
  e.instance_name = core::trimmed(tag.attributes.get(Attr::kInstanceName));
  if (e.text.empty()) r.report(core::Code::P1009, e.at, "block has no typeName");
}

void start_inline_code(Reader& r, const Tag& tag) {
  Element& e = open_object(r, tag, ElementKind::kBlock);
  e.text = "EXECUTE";
  e.text_at = e.at;
  e.has_code = true;
}

/// Inline ST has bare points: they are EN and ENO of the box.
void name_code_points(Reader& r) {
  Element& e = element(r);
  for (Pin& pin : e.inputs) pin.name = "EN";
  for (Pin& pin : e.outputs) pin.name = "ENO";
  close_element(r);
}

template <bool kInput>
void start_pin(Reader& r, const Tag& tag) {
  Element& e = element(r);
  Pin& pin = r.add_pin(kInput ? e.inputs : e.outputs, tag);
  pin.name = r.optional_name(tag, Attr::kParameterName);
  pin.negated = r.flag(tag, Attr::kNegated);
  pin.edge = r.edge(tag, Attr::kEdge);
  pin.storage = r.storage(tag, tag.attributes.has(Attr::kLatch) ? Attr::kLatch : Attr::kStorage);
  pin.hidden = r.flag(tag, Attr::kHidden);
  frame(r).pin = &pin;
}

void start_in_out_pin(Reader& r, const Tag& tag) {
  Pin& pin = r.add_pin(element(r).in_outs, tag);
  pin.name = r.optional_name(tag, Attr::kParameterName);
  frame(r).pin = &pin;
}

void note_out_point(Reader& r, const Tag& tag, std::size_t pin) {
  BodyFrame& f = frame(r);
  const std::int64_t id = r.integer(tag, Attr::kConnectionPointOutId, -1, kMaxId);
  if (id < 0) return;
  f.out_points.push_back({id, f.element.at.local_id, static_cast<std::uint32_t>(pin),
                          static_cast<std::uint32_t>(f.body.elements.size()), r.element_place(tag.at)});
}

void own_out(Reader& r, const Tag& tag) {
  own_point_out(r, tag);
  note_out_point(r, tag, element(r).outputs.size() - 1);
}

void pin_out(Reader& r, const Tag& tag) {
  pin_point_out(r, tag);
  const Element& e = element(r);
  const Pin* pin = frame(r).pin;
  if (!e.outputs.empty() && pin == &e.outputs.back()) note_out_point(r, tag, e.outputs.size() - 1);
  if (!e.in_outs.empty() && pin == &e.in_outs.back()) note_out_point(r, tag, kInOutPin + e.in_outs.size() - 1);
}

void start_connection(Reader& r, const Tag& tag) {
  Connection& connection = add_connection(r, tag);
  if (!tag.attributes.has(Attr::kRefConnectionPointOutId)) {
    r.report(core::Code::P1009, connection.at, "connection has no refConnectionPointOutId");
  }
  connection.ref_local_id = r.integer(tag, Attr::kRefConnectionPointOutId, -1, kMaxId);
}

void evaluation_priority(Reader& r, const Tag& tag) {
  if (r.bodies.empty() || !frame(r).element_open || !tag.attributes.has(Attr::kPriorityInNetwork)) return;
  element(r).execution_order = static_cast<std::uint32_t>(r.integer(tag, Attr::kPriorityInNetwork, 0, kMaxOrder)) + 1;
}

void connect(const BodyFrame& f, std::vector<Pin>& pins) {
  for (Pin& pin : pins) {
    for (Connection& connection : pin.connections) {
      const auto found = std::lower_bound(f.out_points.begin(), f.out_points.end(), connection.ref_local_id,
                                          [](const OutPoint& point, std::int64_t id) { return point.id < id; });
      if (found == f.out_points.end() || found->id != connection.ref_local_id) {
        connection.ref_local_id = -1;
        continue;
      }
      connection.ref_local_id = found->local_id;
      const Element& source = f.body.elements[found->element];
      if (source.kind != ElementKind::kBlock) continue;
      const bool in_out = (found->pin & kInOutPin) != 0;
      connection.formal_parameter =
          in_out ? source.in_outs[found->pin & ~kInOutPin].name : source.outputs[found->pin].name;
    }
  }
}

/// Replaces the output points that wires name by the elements and pins they belong to. Points count per network.
void end_network(Reader& r) {
  BodyFrame& f = frame(r);
  std::stable_sort(f.out_points.begin(), f.out_points.end(),
                   [](const OutPoint& a, const OutPoint& b) { return a.id < b.id; });
  for (std::size_t i = 1; i < f.out_points.size(); ++i) {
    if (f.out_points[i].id != f.out_points[i - 1].id) continue;
    const SourceRef& first = f.out_points[i - 1].at;
    r.report(core::Code::P1008, f.out_points[i].at,
             fmt::format("connectionPointOutId {} is used twice in a network, also at line {} column {} by a {}",
                         f.out_points[i].id, first.line, first.column, core::element_word(first.kind)),
             "renumber one of the points and its wires");
  }
  for (std::size_t i = f.network_begin; i < f.body.elements.size(); ++i) {
    connect(f, f.body.elements[i].inputs);
    connect(f, f.body.elements[i].in_outs);
  }
  f.out_points.clear();
}

constexpr Rule drawing_body(std::string_view variant, StartHandler start) {
  return used_variant(State::kXMainBody, "BodyContent", variant, State::kXDrawing, start, close_body);
}

constexpr Rule object(std::string_view name, std::string_view variant, StartHandler start) {
  return used_variant(State::kXNetwork, name, variant, State::kXObject, start, close_element);
}

constexpr Rule comment(std::string_view name, std::string_view variant) {
  Rule rule = ignored(State::kXNetwork, name, kReasonComment);
  rule.variant = variant;
  return rule;
}

constexpr Rule code_object(std::string_view name) {
  return used_variant(State::kXNetwork, name, "InlineST", State::kXCode, start_inline_code, name_code_points);
}

constexpr Rule unknown_object(std::string_view name) {
  return refused(State::kXNetwork, name, "not an element of LD or FBD (P1017)", unknown_element);
}

constexpr Rule kFixed[] = {
    drawing_body("LD", start_drawing<Language::kLd>),
    drawing_body("LdSection", start_drawing<Language::kLd>),
    drawing_body("FBD", start_drawing<Language::kFbd>),
    used(State::kXDrawing, "Rung", State::kXNetwork, start_network, end_network),
    used(State::kXDrawing, "Network", State::kXNetwork, start_network, end_network),
    ignored(State::kXDrawing, "Documentation", kReasonNote),
    used(State::kXDrawing, "AddData", State::kXAddData),
    ignored(State::kXNetwork, "Documentation", kReasonNote),
    used(State::kXNetwork, "AddData", State::kXAddData),

    used(State::kXObject, "RelPosition", State::kLeaf, element_position),
    ignored(State::kXObject, "Size", kReasonLayout),
    used(State::kXObject, "ConnectionPointIn", State::kXPointIn, own_point_in, close_pin),
    used(State::kXObject, "ConnectionPointOut", State::kXPointOut, own_out, close_pin),
    used(State::kXObject, "InputVariables", State::kXPins),
    used(State::kXObject, "InOutVariables", State::kXPins),
    used(State::kXObject, "OutputVariables", State::kXPins),
    used(State::kXObject, "AddData", State::kXAddData),
    ignored(State::kXObject, "Documentation", kReasonNote),
    used(State::kXPins, "InputVariable", State::kXPin, start_pin<true>, close_pin),
    used(State::kXPins, "OutputVariable", State::kXPin, start_pin<false>, close_pin),
    used(State::kXPins, "InOutVariable", State::kXPin, start_in_out_pin, close_pin),
    used(State::kXPin, "ConnectionPointIn", State::kXPointIn, pin_point_in),
    used(State::kXPin, "ConnectionPointOut", State::kXPointOut, pin_out),
    used(State::kXPin, "AddData", State::kXAddData),
    ignored(State::kXPin, "Documentation", kReasonNote),
    used(State::kXPointIn, "Connection", State::kLeaf, start_connection),
    used(State::kXPointIn, "Expression", State::kText, start_text, point_expression),
    ignored(State::kXPointIn, "RelPosition", kReasonLayout),
    used(State::kXPointIn, "AddData", State::kXAddData),
    used(State::kXPointOut, "Expression", State::kText, start_text, point_target),
    ignored(State::kXPointOut, "RelPosition", kReasonLayout),
    used(State::kXPointOut, "AddData", State::kXAddData),

    used(State::kXCode, "ConnectionPointIn", State::kXPointIn, own_point_in, close_pin),
    used(State::kXCode, "ConnectionPointOut", State::kXPointOut, own_out, close_pin),
    used(State::kXCode, "RelPosition", State::kLeaf, element_position),
    ignored(State::kXCode, "Size", kReasonLayout),
    used(State::kXCode, "AddData", State::kXAddData),
    used(State::kXCode, "ST", State::kFormatted, start_text, element_code),

    used(State::kXVendor, "EvaluationPriority", State::kLeaf, evaluation_priority),
};

struct Variant {
  std::string_view name;
  StartHandler start;
};
/// By xsi:type; CfcJump, CfcLabel and CfcReturn are Bachmann's, CompareContact and InlineST Omron's.
constexpr Variant kVariants[] = {
    {"LeftPowerRail", start_plain<ElementKind::kLeftRail>},
    {"RightPowerRail", start_plain<ElementKind::kRightRail>},
    {"Contact", start_object<ElementKind::kContact, Attr::kOperand>},
    {"CompareContact", start_compare},
    {"Coil", start_object<ElementKind::kCoil, Attr::kOperand>},
    {"Block", start_block},
    {"DataSource", start_object<ElementKind::kInVariable, Attr::kIdentifier>},
    {"DataSink", start_object<ElementKind::kOutVariable, Attr::kIdentifier>},
    {"DataSourceSink", start_object<ElementKind::kInOutVariable, Attr::kIdentifier>},
    {"Connector", start_object<ElementKind::kConnector, Attr::kLabel>},
    {"Continuation", start_object<ElementKind::kContinuation, Attr::kLabel>},
    {"Label", start_object<ElementKind::kLabel, Attr::kLabel>},
    {"CfcLabel", start_object<ElementKind::kLabel, Attr::kLabel>},
    {"Jump", start_jump},
    {"CfcJump", start_jump},
    {"Return", start_plain<ElementKind::kReturn>},
    {"CfcReturn", start_plain<ElementKind::kReturn>},
};

}  // namespace

std::span<const Rule> iec10_body_rules() {
  static const std::vector<Rule> kAll = [] {
    std::vector<Rule> all(std::begin(kFixed), std::end(kFixed));
    for (const std::string_view name : {"LdObject", "FbdObject", "CommonObject"}) {
      for (const Variant& variant : kVariants) all.push_back(object(name, variant.name, variant.start));
      all.push_back(code_object(name));
      all.push_back(comment(name, "Comment"));
      all.push_back(unknown_object(name));
    }
    return all;
  }();
  return kAll;
}

}  // namespace plc::plcopen
