// LD and FBD bodies of TC6 files.
#include "plcopen/reader_body.h"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "core/text.h"
#include "plcopen/reader_pou.h"
#include "plcopen/reader_types.h"

namespace plc::plcopen {

namespace {

/// TwinCAT and CODESYS number FBD elements as network * 10^10 + n.
constexpr std::int64_t kIdsPerNetwork = 10'000'000'000;
constexpr std::int64_t kMaxNetwork = 1'000'000;
constexpr std::int64_t kMaxId = std::numeric_limits<std::int64_t>::max();

BodyFrame& frame(Reader& r) { return *r.bodies.back(); }
Element& element(Reader& r) { return r.bodies.back()->element; }

std::int64_t local_id(Reader& r, const Tag& tag) {
  if (core::trimmed(tag.attributes.get(Attr::kLocalId)).empty()) {
    r.report(core::Code::P1009, tag.at, fmt::format("element \"{}\" has no localId", tag.name));
    return -1;
  }
  return r.integer(tag, Attr::kLocalId, -1, kMaxId);
}

template <ElementKind kKind>
void start(Reader& r, const Tag& tag) {
  Element& e = open_element(r, tag, kKind, local_id(r, tag));
  e.negated = r.flag(tag, Attr::kNegated);
  e.edge = r.edge(tag, Attr::kEdge);
  e.storage = r.storage(tag, Attr::kStorage);
}

void start_in_out_variable(Reader& r, const Tag& tag) {
  Element& e = open_element(r, tag, ElementKind::kInOutVariable, local_id(r, tag));
  e.negated = r.flag(tag, Attr::kNegatedIn);
  e.edge = r.edge(tag, Attr::kEdgeIn);
  e.storage = r.storage(tag, Attr::kStorageIn);
  e.negated_out = r.flag(tag, Attr::kNegatedOut);
  e.edge_out = r.edge(tag, Attr::kEdgeOut);
  e.storage_out = r.storage(tag, Attr::kStorageOut);
}

/// Elements whose text is an attribute: a name (connector, continuation) or a label (label, jump).
template <ElementKind kKind, Attr kText>
void start_named(Reader& r, const Tag& tag) {
  Element& e = open_element(r, tag, kKind, local_id(r, tag));
  // The schema has none of these at jumps; a negated one that jumps with power would be another.
  if (kKind == ElementKind::kJump) {
    e.negated = r.flag(tag, Attr::kNegated);
    e.edge = r.edge(tag, Attr::kEdge);
    e.storage = r.storage(tag, Attr::kStorage);
  }
  e.text = core::trimmed(tag.attributes.get(kText));
  e.text_at = e.at;
  if (e.text.empty()) {
    r.report(core::Code::P1009, e.at, fmt::format("element \"{}\" has no {}", tag.name, attribute_name(kText)));
  }
}

/// CODESYS and its relatives write "???" where nothing is assigned yet.
bool is_unassigned(std::string_view text) { return text.find_first_not_of("? \t\r\n") == std::string_view::npos; }
std::string assigned(std::string_view text) { return std::string(is_unassigned(text) ? std::string_view() : text); }

void start_block(Reader& r, const Tag& tag) {
  Element& e = open_element(r, tag, ElementKind::kBlock, local_id(r, tag));
  // Of the symbols of functions, this one would be refused as a name.
  const bool quotient = core::trimmed(tag.attributes.get(Attr::kTypeName)) == "/";
  e.text = quotient ? "/" : r.required_name(tag, Attr::kTypeName);
  e.text_at = e.at;
  e.instance_name = assigned(core::trimmed(tag.attributes.get(Attr::kInstanceName)));
  e.inputs.reserve(4);
}

void start_vendor_element(Reader& r, const Tag& tag) {
  frame(r).network_title = false;
  frame(r).title.clear();
  open_element(r, tag, ElementKind::kNone, r.integer(tag, Attr::kLocalId, -1, kMaxId));
}

void end_vendor_element(Reader& r) {
  BodyFrame& f = frame(r);
  f.element_open = false;
  if (f.network_title) {
    ++f.network;
    if (!f.title.empty()) f.body.comments.push_back({f.title, {}, 0, 0, f.network, f.body.elements.size()});
    // TwinCAT writes the comment of a network in front of its title.
    for (DrawnComment& comment : f.body.comments) {
      if (comment.before == f.body.elements.size()) comment.network = f.network;
    }
  } else if (!f.element.inputs.empty() || !f.element.outputs.empty() || !f.element.in_outs.empty()) {
    ++f.body.drawn_elements;
    r.report(core::Code::P1017, f.element.at, "vendorElement with pins is not known; the diagram is incomplete",
             "replace the element by a block of the standard");
  }
}

void element_type(Reader& r) {
  const std::string type = r.take_text();
  if (!r.bodies.empty() && frame(r).element_open) {
    frame(r).network_title = core::iequals(type, "networktitle");
  }
}

void start_element_text(Reader& r, const Tag& tag) {
  element(r).text_at = r.element_place(tag.at);
  r.begin_text();
}

void element_text(Reader& r) {
  Element& e = element(r);
  e.text = assigned(r.take_text(&e.text_at));
  e.text_at = r.element_place(e.text_at);
}

void vendor_title(Reader& r) { frame(r).title = r.take_text(); }

// ---- what only pictures need --------------------------------------------------------------------------------------

Point point_of(Reader& r, const Tag& tag) {
  return {r.coordinate(tag, Attr::kX, Coordinate::kPicture), r.coordinate(tag, Attr::kY, Coordinate::kPicture)};
}

void pin_place(Reader& r, const Tag& tag) {
  Pin* const pin = frame(r).pin;
  if (pin == nullptr) return;
  pin->place = point_of(r, tag);
  pin->has_place = true;
}

void wire_corner(Reader& r, const Tag& tag) {
  Pin* const pin = frame(r).pin;
  if (pin != nullptr && !pin->connections.empty()) pin->connections.back().points.push_back(point_of(r, tag));
}

void start_comment(Reader& r, const Tag& tag) {
  BodyFrame& f = frame(r);
  DrawnComment comment;
  comment.width = r.coordinate(tag, Attr::kWidth, Coordinate::kPicture);
  comment.height = r.coordinate(tag, Attr::kHeight, Coordinate::kPicture);
  comment.network = f.network;
  comment.before = f.body.elements.size();
  f.body.comments.push_back(std::move(comment));
}

void comment_place(Reader& r, const Tag& tag) { frame(r).body.comments.back().place = point_of(r, tag); }

void comment_text(Reader& r) { frame(r).body.comments.back().text = r.take_text(); }

void end_comment(Reader& r) {
  std::vector<DrawnComment>& comments = frame(r).body.comments;
  if (comments.back().text.empty()) comments.pop_back();
}

// ---- what the tool that wrote the file could not write -------------------------------------------------------------

void start_lost(Reader& r, const Tag& tag) {
  frame(r).lost = tag.at;
  r.begin_text();
}

void end_lost(Reader& r) {
  const std::string text = r.take_text();
  r.report(core::Code::P1013, frame(r).lost,
           "element \"error\": what is missing here the tool that wrote the file could not write" +
               (text.empty() ? std::string() : ": \"" + text.substr(0, 200) + "\""),
           "compare with the drawing in the tool");
}

enum class PinList : std::uint8_t { kIn, kInOut, kOut };
template <PinList kList>
void start_pin(Reader& r, const Tag& tag) {
  Element& e = element(r);
  Pin& pin = r.add_pin(kList == PinList::kIn ? e.inputs : kList == PinList::kInOut ? e.in_outs : e.outputs, tag);
  pin.name = r.optional_name(tag, Attr::kFormalParameter);
  pin.negated = r.flag(tag, Attr::kNegated);
  pin.edge = r.edge(tag, Attr::kEdge);
  pin.storage = r.storage(tag, Attr::kStorage);
  pin.hidden = r.flag(tag, Attr::kHidden);
  frame(r).pin = &pin;
}

void start_connection(Reader& r, const Tag& tag) {
  Connection& connection = add_connection(r, tag);
  if (core::trimmed(tag.attributes.get(Attr::kRefLocalId)).empty()) {
    r.report(core::Code::P1009, connection.at, "connection has no refLocalId");
    connection.refused = true;
    return;
  }
  connection.ref_local_id = r.integer(tag, Attr::kRefLocalId, -1, kMaxId);
  connection.formal_parameter = core::trimmed(tag.attributes.get(Attr::kFormalParameter));
}

void start_action(Reader& r, const Tag& tag) {
  ActionLink& action = element(r).actions.emplace_back();
  action.qualifier = core::trimmed(tag.attributes.get(Attr::kQualifier));
  action.duration = core::trimmed(tag.attributes.get(Attr::kDuration));
  action.indicator = core::trimmed(tag.attributes.get(Attr::kIndicator));
  action.at = r.element_place(tag.at);
  action.local_id = r.integer(tag, Attr::kLocalId, -1, kMaxId);
  frame(r).action_open = true;
}
void end_action(Reader& r) { frame(r).action_open = false; }

void action_reference(Reader& r, const Tag& tag) {
  std::string name = r.optional_name(tag, Attr::kName);
  const std::string& known = element(r).actions.back().name;
  if (known.empty()) return name_action(r, std::move(name));
  r.report(core::Code::P1007, r.element_place(tag.at),
           fmt::format("action refers to \"{}\", and is \"{}\" already", name, known),
           "an action has one reference, before what is drawn in it");
}

constexpr Rule drawn(std::string_view name, StartHandler handler) {
  return used(State::kDrawing, name, State::kElement, handler, close_element);
}

constexpr Rule lost_in_export() {
  Rule rule = ignored(State::kDrawing, "error", "what its tool could not write: named (P1013)", State::kFormatted);
  rule.start = start_lost;
  rule.end = end_lost;
  return rule;
}

constexpr Rule refused_drawn() {
  Rule rule = refused(State::kDrawing, "*", "not an element of LD or FBD (P1017)", unknown_element);
  return rule;
}

constexpr Rule kRules[] = {
    drawn("leftPowerRail", start<ElementKind::kLeftRail>),
    drawn("rightPowerRail", start<ElementKind::kRightRail>),
    drawn("contact", start<ElementKind::kContact>),
    drawn("coil", start<ElementKind::kCoil>),
    drawn("block", start_block),
    drawn("inVariable", start<ElementKind::kInVariable>),
    drawn("outVariable", start<ElementKind::kOutVariable>),
    drawn("inOutVariable", start_in_out_variable),
    drawn("connector", start_named<ElementKind::kConnector, Attr::kName>),
    drawn("continuation", start_named<ElementKind::kContinuation, Attr::kName>),
    drawn("label", start_named<ElementKind::kLabel, Attr::kLabel>),
    drawn("jump", start_named<ElementKind::kJump, Attr::kLabel>),
    drawn("return", start<ElementKind::kReturn>),
    drawn("actionBlock", start<ElementKind::kActionBlock>),
    used(State::kDrawing, "vendorElement", State::kElement, start_vendor_element, end_vendor_element),
    preserved(State::kDrawing, "comment", State::kComment, kReasonDrawn, start_comment, end_comment),
    lost_in_export(),
    refused_drawn(),

    used(State::kElement, "position", State::kLeaf, element_position),
    used(State::kElement, "connectionPointIn", State::kPointIn, own_point_in, close_pin),
    used(State::kElement, "connectionPointOut", State::kPointOut, own_point_out, close_pin),
    used(State::kElement, "variable", State::kText, start_element_text, element_text),
    used(State::kElement, "expression", State::kText, start_element_text, element_text),
    used(State::kElement, "inputVariables", State::kInputPins),
    used(State::kElement, "inOutVariables", State::kInOutPins),
    used(State::kElement, "outputVariables", State::kOutputPins),
    used(State::kElement, "action", State::kAction, start_action, end_action),
    used(State::kElement, "addData", State::kAddData),
    ignored(State::kElement, "documentation", kReasonNote),
    preserved(State::kElement, "alternativeText", State::kFormatted, kReasonDrawn, start_text, vendor_title),

    used(State::kAction, "reference", State::kLeaf, action_reference),
    ignored(State::kAction, "relPosition", kReasonLayout),
    ignored(State::kAction, "connectionPointOut", kReasonLayout),
    ignored(State::kAction, "documentation", kReasonNote),
    used(State::kAction, "addData", State::kAddData),

    used(State::kInputPins, "variable", State::kPin, start_pin<PinList::kIn>, close_pin),
    used(State::kInOutPins, "variable", State::kPin, start_pin<PinList::kInOut>, close_pin),
    used(State::kOutputPins, "variable", State::kPin, start_pin<PinList::kOut>, close_pin),
    used(State::kPin, "connectionPointIn", State::kPointIn, pin_point_in),
    used(State::kPin, "connectionPointOut", State::kPointOut, pin_point_out),
    used(State::kPin, "addData", State::kAddData),
    ignored(State::kPin, "documentation", kReasonNote),

    used(State::kPointIn, "connection", State::kConnection, start_connection),
    used(State::kPointIn, "expression", State::kText, start_text, point_expression),
    preserved(State::kPointIn, "relPosition", State::kLeaf, kReasonDrawn, pin_place, nullptr),
    used(State::kPointIn, "addData", State::kAddData),
    used(State::kPointOut, "expression", State::kText, start_text, point_target),
    preserved(State::kPointOut, "relPosition", State::kLeaf, kReasonDrawn, pin_place, nullptr),
    used(State::kPointOut, "addData", State::kAddData),
    preserved(State::kConnection, "position", State::kLeaf, kReasonDrawn, wire_corner, nullptr),
    used(State::kConnection, "addData", State::kAddData),

    preserved(State::kComment, "position", State::kLeaf, kReasonDrawn, comment_place, nullptr),
    preserved(State::kComment, "content", State::kFormatted, kReasonDrawn, start_text, comment_text),
    ignored(State::kComment, "documentation", kReasonNote),
    ignored(State::kComment, "addData", kReasonEditor),

    used(State::kVendor, "ElementType", State::kText, start_text, element_type),
};

void check_duplicates(Reader& r, const Body& body) {
  std::vector<std::uint32_t> order;
  order.reserve(body.elements.size());
  bool ascending = true;
  std::int64_t last = -1;
  for (std::uint32_t i = 0; i < body.elements.size(); ++i) {
    const std::int64_t id = body.elements[i].at.local_id;
    if (id < 0) continue;
    ascending = ascending && id > last;
    last = id;
    order.push_back(i);
  }
  if (ascending) return;
  const auto id = [&](std::uint32_t i) { return body.elements[i].at.local_id; };
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return id(a) < id(b); });
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (id(order[i]) != id(order[i - 1])) continue;
    const SourceRef& first = body.elements[order[i - 1]].at;
    const SourceRef& second = body.elements[order[i]].at;
    r.report(core::Code::P1008, second,
             fmt::format("localId {} is used twice, also at line {} column {} by a {}", second.local_id, first.line,
                         first.column, core::element_word(first.kind)),
             "renumber one of the elements and its wires");
  }
}

}  // namespace

Element& open_element(Reader& r, const Tag& tag, ElementKind kind, std::int64_t id) {
  BodyFrame& f = frame(r);
  f.element = Element{};
  f.element_open = true;
  f.pin = nullptr;
  f.connection = nullptr;
  Element& e = f.element;
  e.kind = kind;
  e.at = tag.at;
  e.at.kind = kind;
  e.at.local_id = id;
  e.width = r.coordinate(tag, Attr::kWidth);
  e.height = r.coordinate(tag, Attr::kHeight);
  e.execution_order =
      static_cast<std::uint32_t>(r.integer(tag, Attr::kExecutionOrderId, 0, std::numeric_limits<std::uint32_t>::max()));
  e.order_zero = e.execution_order == 0 && tag.attributes.has(Attr::kExecutionOrderId);
  e.network = f.network;
  if (id >= kIdsPerNetwork && id / kIdsPerNetwork <= kMaxNetwork && f.body.language == Language::kFbd) {
    e.network = static_cast<std::uint32_t>(id / kIdsPerNetwork);
  }
  return e;
}

void name_action(Reader& r, std::string name) {
  Element& e = element(r);
  if (!e.text.empty()) e.text += ", ";
  e.text += name;
  e.actions.back().name = std::move(name);
}

void close_element(Reader& r) {
  BodyFrame& f = frame(r);
  f.element_open = false;
  f.pin = nullptr;
  f.body.elements.push_back(std::move(f.element));
  ++f.body.drawn_elements;
}

void unknown_element(Reader& r, const Tag& tag) {
  ++frame(r).body.drawn_elements;
  SourceRef at = tag.at;
  at.local_id = r.integer(tag, Attr::kLocalId, -1, kMaxId);
  r.report(core::Code::P1017, at,
           fmt::format("element \"{}\" in a {} body is not known; the diagram is incomplete", tag.name.substr(0, 60),
                       language_name(frame(r).body.language)),
           "remove the element or write that part in another language");
}

void element_position(Reader& r, const Tag& tag) {
  Element& e = element(r);
  e.has_position = true;
  for (const Attr attribute : {Attr::kX, Attr::kY}) {
    if (!core::trimmed(tag.attributes.get(attribute)).empty()) continue;
    r.report(core::Code::P1009, tag.at, fmt::format("element \"{}\" has no {}", tag.name, attribute_name(attribute)));
  }
  e.x = r.coordinate(tag, Attr::kX);
  e.y = r.coordinate(tag, Attr::kY);
}

void own_point_in(Reader& r, const Tag& tag) {
  Pin& pin = r.add_pin(element(r).inputs, tag);
  pin.has_point_in = true;
  frame(r).pin = &pin;
}

void own_point_out(Reader& r, const Tag& tag) {
  Pin& pin = r.add_pin(element(r).outputs, tag);
  pin.has_point_out = true;
  pin.name = core::trimmed(tag.attributes.get(Attr::kFormalParameter));
  frame(r).pin = &pin;
}

void pin_point_in(Reader& r, const Tag&) { frame(r).pin->has_point_in = true; }
void pin_point_out(Reader& r, const Tag&) { frame(r).pin->has_point_out = true; }
void close_pin(Reader& r) { frame(r).pin = nullptr; }

void point_expression(Reader& r) { frame(r).pin->expression = assigned(r.take_text()); }

void point_target(Reader& r) {
  Pin& pin = *frame(r).pin;
  pin.target_at = pin.at;
  pin.target = assigned(r.take_text(&pin.target_at));
  pin.target_at = r.element_place(pin.target_at);
}

void start_closed_branch(Reader& r, const Tag& tag) {
  ClosedBranch branch;
  if (!r.bodies.empty()) branch.local_id = frame(r).element.at.local_id;
  const std::string_view mode = core::trimmed(tag.attributes.get(Attr::kMode));
  branch.short_circuit = core::iequals(mode, "sce");
  if (!branch.short_circuit && !mode.empty() && !core::iequals(mode, "or")) {
    r.report(core::Code::P3030, r.element_place(tag.at),
             fmt::format("closed branch has the mode \"{}\", which is neither sce nor or", mode.substr(0, 60)),
             "read as or: every box in it is executed in every scan");
  }
  // Its connections are no pins of the element that the mark is in.
  auto own = std::make_unique<BodyFrame>();
  own->element.at = r.element_place(tag.at);
  own->body.closed_branches.push_back(std::move(branch));
  r.bodies.push_back(std::move(own));
}

void end_closed_branch(Reader& r) {
  const std::unique_ptr<BodyFrame> own = std::move(r.bodies.back());
  r.bodies.pop_back();
  if (r.bodies.empty()) return;
  frame(r).body.closed_branches.push_back(std::move(own->body.closed_branches.back()));
}

void start_branch_input(Reader& r, const Tag&) { frame(r).pin = &frame(r).body.closed_branches.back().input; }

void start_branch_line(Reader& r, const Tag& tag) {
  frame(r).pin = &frame(r).body.closed_branches.back().lines.emplace_back();
  frame(r).pin->at = r.element_place(tag.at);
}

Connection& add_connection(Reader& r, const Tag& tag) {
  Connection& connection = frame(r).pin->connections.emplace_back();
  connection.at = r.element_place(tag.at);
  return connection;
}

void element_code(Reader& r) {
  SourceRef at;
  std::string code = r.take_text(&at);
  if (r.bodies.empty() || !frame(r).element_open) return;
  Element& e = element(r);
  e.code_at = r.element_place(at.line == 0 ? e.at : at);
  e.has_code = true;
  e.code = std::move(code);
}

void finish_body(Reader& r) {
  BodyFrame& f = frame(r);
  if (!std::is_sorted(f.orders.begin(), f.orders.end())) {
    // Networks in evaluation order; their numbers follow.
    std::vector<std::uint32_t> order(f.orders.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return f.orders[a] < f.orders[b]; });
    std::vector<std::uint32_t> number(order.size() + 1, 0);
    for (std::uint32_t i = 0; i < order.size(); ++i) number[order[i] + 1] = i + 1;
    for (Element& e : f.body.elements) e.network = number[e.network];
    std::stable_sort(f.body.elements.begin(), f.body.elements.end(),
                     [](const Element& a, const Element& b) { return a.network < b.network; });
  }
  check_duplicates(r, f.body);
  if (r.pous.empty()) return;
  r.pous.back()->pou.bodies.push_back(std::move(f.body));
  r.pous.back()->body_orders.push_back(f.order);
}

std::span<const Rule> body_rules() { return kRules; }

}  // namespace plc::plcopen
