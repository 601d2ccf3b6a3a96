#include "plcopen/reader_state.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "core/text.h"

namespace plc::plcopen {

namespace {

struct KnownNamespace {
  std::string_view end;
  Version version;
};
constexpr KnownNamespace kNamespaces[] = {
    {"/tc6.xsd", Version::kTc6v101},  {"/tc6_0100", Version::kTc6v101}, {"/tc6_0101", Version::kTc6v101},
    {"/tc6_0200", Version::kTc6v200}, {"/tc6_0201", Version::kTc6v201}, {"TC65SC65BWG7TF10", Version::kIec61131_10},
};
constexpr std::size_t kMaxUnknownNames = 1000;
constexpr std::size_t kMaxPins = 4096;
constexpr std::size_t kShown = 60;

/// A text of the file for a message: not longer than a line.
std::string shown(std::string_view text) {
  if (text.size() <= kShown) return std::string(text);
  return std::string(text.substr(0, kShown)).append("...");
}

/// Elements of XHTML that are lines of their own.
bool is_block(std::string_view name) {
  constexpr std::string_view kBlocks[] = {"p", "br", "div", "li", "pre", "tr", "xhtml"};
  return std::find(std::begin(kBlocks), std::end(kBlocks), name) != std::end(kBlocks);
}

constexpr std::string_view kBlanks = " \t\r\n";
/// Whether a line ends in the blanks that `text` begins with, or ends with.
bool begins_with_line_end(std::string_view text) {
  return text.substr(0, text.find_first_not_of(kBlanks)).find('\n') != std::string_view::npos;
}
/// The same after `ended`, the answer for what is before `text`.
bool ends_with_line_end(std::string_view text, bool ended) {
  const std::size_t last = text.find_last_not_of(kBlanks);
  return (last == std::string_view::npos && ended) || text.substr(last + 1).find('\n') != std::string_view::npos;
}

}  // namespace

Reader::Reader(Project& target, core::Diagnostics& diagnostics, const ReadLimits& limits, XmlParser& parser)
    : project(target), diagnostics_(diagnostics), limits_(limits), parser_(parser) {}

void Reader::start_element(const char* name, std::string_view uri, const Attributes& attributes, Place place) {
  const Tag tag{name, attributes, {.line = place.line, .column = place.column, .file = project.file}};
  if (frames_.empty() && !open_document(tag.name, uri, tag.at)) {
    parser_.stop();
    return;
  }
  std::string_view variant;
  if (attributes.has(Attr::kXsiType)) {
    variant = attributes.get(Attr::kXsiType);
    variant.remove_prefix(variant.rfind(':') + 1);
  } else if (tag.name == "data" || tag.name == "Data") {
    variant = attributes.get(Attr::kName);
  }
  const Account::NodeId id =
      account_.enter(frames_.empty() ? Account::kRoot : frames_.back().node, name, variant, place.line);
  const Rule* rule = account_.node(id).rule;
  const bool block = capturing_ && is_block(tag.name);
  line_ends_ = line_ends_ || block;
  frames_.push_back({id, rule == nullptr ? nullptr : rule->end, block});
  if (rule == nullptr) {
    const Rule* const parent = frames_.size() < 2 ? nullptr : account_.node(frames_[frames_.size() - 2].node).rule;
    if (parent != nullptr && parent->state == State::kBody && !bodies.empty()) bodies.back()->foreign = tag.name;
    if (unknown_.size() < kMaxUnknownNames && unknown_.emplace(tag.name).second) {
      report(core::Code::P1013, tag.at,
             fmt::format("element \"{}\" is not known here and is ignored", shown(tag.name)));
    }
    return;
  }
  if (!attributes.in_other_case().empty()) warn_of_letter_case(tag, rule->parent);
  if (!rule->belongs.empty() && misplaced_.insert(rule).second) {
    report(core::Code::P1019, tag.at,
           fmt::format("element \"{}\" is outside of \"{}\" and is read as if it were inside", tag.name, rule->belongs),
           fmt::format("move it into \"{}\": other tools do not look for it here", rule->belongs));
  }
  if (rule->start != nullptr) rule->start(*this, tag);
}

/// Of drawn elements, their pins and wires: "Negated" would be a negation that nobody sees.
void Reader::warn_of_letter_case(const Tag& tag, State parent) {
  constexpr State kDrawn[] = {State::kDrawing,    State::kElement, State::kInputPins, State::kInOutPins,
                              State::kOutputPins, State::kPin,     State::kPointIn};
  if (std::find(std::begin(kDrawn), std::end(kDrawn), parent) == std::end(kDrawn)) return;
  const std::string_view name = tag.attributes.in_other_case();
  if (other_case_.size() >= kMaxUnknownNames || !other_case_.emplace(name).second) return;
  report(core::Code::P1013, tag.at,
         fmt::format("attribute \"{}\" of element \"{}\" is not known and is ignored", shown(name), tag.name),
         fmt::format("PLCopen XML has \"{}\": capitals count", attribute_name(tag.attributes.meant())));
}

void Reader::end_element() {
  if (frames_.empty()) return;
  const EndHandler end = frames_.back().end;
  line_ends_ = line_ends_ || frames_.back().block;
  frames_.pop_back();
  if (end != nullptr) end(*this);
}

bool Reader::ends_line_before(std::string_view piece) {
  return std::exchange(line_ends_, false) && !text_.empty() && !line_ended_ && !begins_with_line_end(piece);
}

Pin& Reader::add_pin(std::vector<Pin>& pins, const Tag& tag) {
  if (pins.size() == kMaxPins) {
    report(core::Code::P1006, tag.at, fmt::format("drawn element has more than {} inputs or outputs", kMaxPins));
    parser_.stop();
  }
  Pin& pin = pins.emplace_back();
  pin.at = element_place(tag.at);
  return pin;
}

void Reader::text(std::string_view piece) {
  if (text_.empty()) {
    const std::size_t first = piece.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos) return;
    const Place place = parser_.text_place();
    text_at_ = {.line = place.line, .column = place.column, .file = project.file, .kind = ElementKind::kText};
    piece.remove_prefix(first);
  }
  if (text_.size() + piece.size() > limits_.max_text) {
    report(core::Code::P1006, text_at_, fmt::format("text is longer than {} bytes", limits_.max_text));
    parser_.stop();
    return;
  }
  text_ += piece;
  line_ended_ = ends_with_line_end(piece, line_ended_);
}

void Reader::begin_text() {
  text_.clear();
  text_at_ = {};
  capturing_ = true;
  line_ends_ = false;
  line_ended_ = false;
  parser_.begin_text();
}

std::string Reader::take_text(SourceRef* at) {
  if (capturing_) parser_.end_text();
  capturing_ = false;
  text_.resize(core::trimmed(text_).size());
  if (at != nullptr && text_at_.line != 0) *at = text_at_;
  return text_;
}

SourceRef Reader::value_place(const Tag& tag, Attr attribute) {
  SourceRef at = tag.at;
  if (const std::optional<Place> place = parser_.value_place(attribute)) {
    at.line = place->line;
    at.column = place->column;
  }
  return at;
}

bool Reader::open_document(std::string_view name, std::string_view uri, const SourceRef& at) {
  if (name != "project" && name != "Project") {
    report(core::Code::P1003, at, fmt::format(R"(root element is "{}", not "project")", shown(name)),
           name == "TcSmProject" ? "give the .plcproj of TwinCAT's PLC project, or the folder that it is in"
                                 : "export the project as PLCopen XML");
    return false;
  }
  for (const KnownNamespace& known : kNamespaces) {
    if (uri.ends_with(known.end)) project.version = known.version;
  }
  if (project.version == Version::kUnknown) {
    report(core::Code::P1004, at,
           uri.empty()
               ? std::string("project has no namespace; elements are read by their local names")
               : fmt::format("namespace \"{}\" is not known; elements are read by their local names", shown(uri)));
  }
  return true;
}

void Reader::report(core::Code code, const SourceRef& at, std::string message, std::string help) {
  // What is drawn inside of an element has no name yet.
  std::string name;
  for (const auto& frame : pous) {
    if (!name.empty() && !frame->pou.name.empty()) name += '.';
    name += frame->pou.name;
  }
  diagnostics_.report(code, at, name, std::move(message), std::move(help));
}

void Reader::note_extent(const std::string& name, const SourceRef& begin) {
  const Place end = parser_.end_place();
  project.extents.push_back({{name}, begin, {.line = end.line, .column = end.column, .file = project.file}});
}

bool Reader::check_name(std::string_view name, const Tag& tag, Attr attribute) {
  const auto refuse = [&](const std::string& why) {
    report(core::Code::P1007, tag.at,
           fmt::format(R"({} of element "{}" {}: "{}")", attribute_name(attribute), tag.name, why, shown(name)),
           "use letters, digits and underscores");
    return false;
  };
  if (name.size() > limits_.max_name) return refuse(fmt::format("is longer than {} bytes", limits_.max_name));
  for (const char c : name) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) return refuse("contains a control character");
    if (c == '/' || c == '\\') return refuse("contains a path separator");
  }
  return true;
}

std::string Reader::required_name(const Tag& tag, Attr attribute) {
  const std::string_view name = core::trimmed(tag.attributes.get(attribute));
  if (name.empty()) {
    report(core::Code::P1009, tag.at, fmt::format("element \"{}\" has no {}", tag.name, attribute_name(attribute)));
    return {};
  }
  return check_name(name, tag, attribute) ? std::string(name) : std::string();
}

std::string Reader::optional_name(const Tag& tag, Attr attribute) {
  const std::string_view name = core::trimmed(tag.attributes.get(attribute));
  return check_name(name, tag, attribute) ? std::string(name) : std::string();
}

std::int64_t Reader::integer(const Tag& tag, Attr attribute, std::int64_t absent, std::int64_t most) {
  const std::string_view text = core::trimmed(tag.attributes.get(attribute));
  if (text.empty()) return absent;
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size() && value >= 0 && value <= most) return value;
  report(core::Code::P1010, tag.at,
         fmt::format("{} is not a number between 0 and {}: \"{}\"", attribute_name(attribute), most, shown(text)));
  return absent;
}

std::int32_t Reader::coordinate(const Tag& tag, Attr attribute, Coordinate use) {
  constexpr double kMost = 1e9;
  const std::string_view text = core::trimmed(tag.attributes.get(attribute));
  if (text.empty()) return 0;
  const char* const last = text.data() + text.size();
  std::int32_t whole = 0;
  const auto [end, error] = std::from_chars(text.data(), last, whole);
  if (error == std::errc() && end == last) return whole;
  double value = 0;
  const auto [real_end, real_error] = std::from_chars(text.data(), last, value);
  if (real_error == std::errc() && real_end == last && std::abs(value) <= kMost) {
    return static_cast<std::int32_t>(std::lround(value));
  }
  if (use == Coordinate::kPicture) return 0;
  report(core::Code::P1010, tag.at,
         fmt::format("{} is not a coordinate: \"{}\"", attribute_name(attribute), shown(text)));
  return 0;
}

bool Reader::flag(const Tag& tag, Attr attribute) {
  const std::string_view text = core::trimmed(tag.attributes.get(attribute));
  if (text.empty() || text == "0" || core::iequals(text, "false")) return false;
  if (text == "1" || core::iequals(text, "true")) return true;
  report(core::Code::P1010, tag.at,
         fmt::format("{} is neither true nor false: \"{}\"", attribute_name(attribute), shown(text)));
  return false;
}

Edge Reader::edge(const Tag& tag, Attr attribute) {
  const std::string_view text = core::trimmed(tag.attributes.get(attribute));
  if (text.empty() || core::iequals(text, "none")) return Edge::kNone;
  if (core::iequals(text, "rising")) return Edge::kRising;
  if (core::iequals(text, "falling")) return Edge::kFalling;
  report(core::Code::P1010, tag.at,
         fmt::format("{} is none of none, rising, falling: \"{}\"", attribute_name(attribute), shown(text)));
  return Edge::kNone;
}

Storage Reader::storage(const Tag& tag, Attr attribute) {
  const std::string_view text = core::trimmed(tag.attributes.get(attribute));
  if (text.empty() || core::iequals(text, "none")) return Storage::kNone;
  if (core::iequals(text, "set")) return Storage::kSet;
  if (core::iequals(text, "reset")) return Storage::kReset;
  report(core::Code::P1010, tag.at,
         fmt::format("{} is none of none, set, reset: \"{}\"", attribute_name(attribute), shown(text)));
  return Storage::kNone;
}

SourceRef Reader::element_place(SourceRef at) const {
  if (bodies.empty()) return at;
  at.local_id = bodies.back()->element.at.local_id;
  at.kind = bodies.back()->element.at.kind;
  return at;
}

Configuration& Reader::outside() {
  if (outside_ == nullptr) outside_ = std::make_unique<Configuration>();
  return *outside_;
}

void Reader::finish() {
  if (outside_ != nullptr) project.configurations.push_back(std::move(*outside_));
  std::unordered_map<std::string_view, const Pou*, core::NameHash, core::NameEqual> seen;
  for (const Pou& pou : project.pous) {
    if (pou.name.empty()) continue;
    const auto [it, added] = seen.try_emplace(pou.name, &pou);
    if (added) continue;
    diagnostics_.report(core::Code::P1012, pou.at, pou.name,
                        fmt::format("POU \"{}\" is declared twice, first at line {}", pou.name, it->second->at.line),
                        "rename or remove one of them");
  }
  for (LooseAction& loose : loose_actions) {
    const auto owner = std::find_if(project.pous.begin(), project.pous.end(),
                                    [&](const Pou& pou) { return core::iequals(pou.name, loose.owner); });
    if (owner != project.pous.end()) {
      // What is drawn inside of its elements belongs to the POU as well.
      for (auto part : {&Pou::actions, &Pou::transitions}) {
        std::vector<Pou>& parts = loose.action.*part;
        std::move(parts.begin(), parts.end(), std::back_inserter((*owner).*part));
        parts.clear();
      }
      owner->actions.push_back(std::move(loose.action));
      continue;
    }
    diagnostics_.report(core::Code::P1018, loose.action.at, loose.action.name,
                        loose.owner.empty()
                            ? fmt::format("action \"{}\" does not say which POU it belongs to", loose.action.name)
                            : fmt::format("action \"{}\" belongs to \"{}\", which is no POU of this file",
                                          loose.action.name, loose.owner),
                        "nothing can call it: export it together with its POU");
  }
  project.report = account_.take_rows();
}

}  // namespace plc::plcopen
