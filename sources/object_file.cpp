#include "sources/object_file.h"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <new>
#include <string_view>
#include <utility>

#include "core/text.h"
#include "plcopen/input_text.h"
#include "plcopen/xml_stream.h"

namespace plc::sources {
namespace {

using core::Code;
using plcopen::Attr;
using plcopen::Attributes;
using plcopen::Fate;
using plcopen::Place;

struct Known {
  std::string_view name;
  Fate fate;
  std::string_view reason;
};
constexpr Known kElements[] = {
#define PLC_SOURCE_ELEMENT(name, fate, reason) {name, Fate::fate, reason},
#include "sources/elements.def"
};
constexpr std::pair<std::string_view, Object::Kind> kObjects[] = {
    {"POU", Object::Kind::kPou},       {"GVL", Object::Kind::kGlobals}, {"DUT", Object::Kind::kType},
    {"Itf", Object::Kind::kInterface}, {"Task", Object::Kind::kTask},
};
constexpr std::pair<std::string_view, Member::Kind> kMembers[] = {
    {"Action", Member::Kind::kAction},
    {"Method", Member::Kind::kMethod},
    {"Property", Member::Kind::kProperty},
    {"Transition", Member::Kind::kTransition},
};
constexpr std::size_t kShown = 60;

/// What the open element is to its object.
enum class At : std::uint8_t {
  kFile,
  kObject,
  kMember,
  kDeclaration,
  kImplementation,
  kBody,
  kCycleTime,
  kPriority,
  kPouCall,
  kCallName,
  kOther,
};

class Handler final : public plcopen::XmlHandler {
 public:
  Handler(ObjectFile& out, core::Diagnostics& diagnostics, const plcopen::ReadLimits& limits,
          plcopen::XmlParser& parser)
      : out_(out), diagnostics_(diagnostics), limits_(limits), parser_(parser) {}

  void start_element(const char* raw, std::string_view, const Attributes& attributes, Place place) override {
    const std::string_view name(raw);
    const core::SourceRef at{.line = place.line, .column = place.column, .file = out_.file};
    if (open_.empty()) {
      root(name, at);
      return;
    }
    const At parent = open_.back();
    At here = At::kOther;
    if (parent == At::kFile) {
      here = object(name, attributes, at);
    } else if (parent == At::kObject || parent == At::kMember) {
      here = part(parent, name, attributes, at);
    } else if (parent == At::kImplementation) {
      here = At::kBody;
      body().format = name.substr(0, kShown);
      body().text.at = at;
      if (name == "ST") begin_text(body().text);
    } else if (parent == At::kPouCall && name == "Name") {
      here = At::kCallName;
      object().calls.emplace_back().at = at;
      begin_text(object().calls.back());
    }
    if (here != At::kOther || parent == At::kObject || parent == At::kFile) count(name, at.line);
    open_.push_back(here);
  }

  void end_element() override {
    if (open_.empty()) return;
    const At here = open_.back();
    open_.pop_back();
    if (here == At::kMember) member_ = false;
    if (target_ == nullptr || open_.size() >= text_depth_) return;
    parser_.end_text();
    target_->text.resize(core::trimmed(target_->text).size());
    target_ = nullptr;
  }

  [[nodiscard]] bool wants_text() const override { return target_ != nullptr; }

  void text(std::string_view piece) override {
    if (target_->text.empty()) {
      const std::size_t first = piece.find_first_not_of(" \t\r\n");
      if (first == std::string_view::npos) return;
      const Place place = parser_.text_place();
      target_->at = {.line = place.line, .column = place.column, .file = out_.file, .kind = core::ElementKind::kText};
      piece.remove_prefix(first);
    }
    if (target_->text.size() + piece.size() > limits_.max_text) {
      diagnostics_.report(Code::P1006, target_->at, {}, fmt::format("text is longer than {} bytes", limits_.max_text));
      parser_.stop();
      return;
    }
    target_->text += piece;
  }

 private:
  Object& object() { return out_.objects.back(); }
  Implementation& body() { return member_ ? object().members.back().implementation : object().implementation; }

  void root(std::string_view name, const core::SourceRef& at) {
    if (name != "TcPlcObject") {
      diagnostics_.report(Code::P1207, at, {},
                          fmt::format(R"(root element is "{}", not "TcPlcObject")", name.substr(0, kShown)),
                          "give the file a name that tells its format, or take it out of the project");
      parser_.stop();
      return;
    }
    open_.push_back(At::kFile);
  }

  At object(std::string_view name, const Attributes& attributes, const core::SourceRef& at) {
    const auto* const known =
        std::find_if(std::begin(kObjects), std::end(kObjects), [&](const auto& row) { return row.first == name; });
    if (known == std::end(kObjects)) return At::kOther;
    Object& out = out_.objects.emplace_back();
    out.kind = known->second;
    out.at = at;
    out.name = named(attributes, at, name);
    if (const std::string_view special = attributes.get(Attr::kSpecialFunc); special != "None") {
      out.special = special.substr(0, limits_.max_name);
    }
    out.declaration.at = at;
    return At::kObject;
  }

  At part(At parent, std::string_view name, const Attributes& attributes, const core::SourceRef& at) {
    if (parent == At::kObject) {
      const auto* const known =
          std::find_if(std::begin(kMembers), std::end(kMembers), [&](const auto& row) { return row.first == name; });
      if (known != std::end(kMembers)) {
        Member& out = object().members.emplace_back();
        out.kind = known->second;
        out.at = at;
        out.name = named(attributes, at, name);
        member_ = true;
        return At::kMember;
      }
    }
    const bool task = parent == At::kObject && object().kind == Object::Kind::kTask;
    if (name == "Implementation") return At::kImplementation;
    if (name == "Declaration") {
      // Actions have none; those of methods and properties are not read.
      if (parent == At::kObject) begin_text(object().declaration);
      return At::kDeclaration;
    }
    if (task && name == "CycleTime") {
      object().cycle_time.at = at;
      begin_text(object().cycle_time);
      return At::kCycleTime;
    }
    if (task && name == "Priority") {
      object().priority.at = at;
      begin_text(object().priority);
      return At::kPriority;
    }
    return task && name == "PouCall" ? At::kPouCall : At::kOther;
  }

  std::string named(const Attributes& attributes, const core::SourceRef& at, std::string_view element) {
    const std::string_view name = core::trimmed(attributes.get(Attr::kAttributeName));
    if (name.empty()) {
      diagnostics_.report(Code::P1009, at, {}, fmt::format("element \"{}\" has no Name", element));
    } else if (name.size() > limits_.max_name) {
      diagnostics_.report(Code::P1007, at, {},
                          fmt::format("Name of element \"{}\" is longer than {} bytes", element, limits_.max_name));
      return {};
    }
    return std::string(name);
  }

  void begin_text(Text& target) {
    target.text.clear();
    target_ = &target;
    text_depth_ = open_.size() + 1;
    parser_.begin_text();
  }

  void count(std::string_view name, std::uint32_t line) {
    const auto* const known =
        std::find_if(std::begin(kElements), std::end(kElements), [&](const Known& row) { return row.name == name; });
    const Known row = known != std::end(kElements) ? *known : Known{name, Fate::kIgnored, "not known here"};
    for (plcopen::ReportRow& one : out_.report) {
      if (one.element != row.name.substr(0, kShown)) continue;
      ++one.count;
      return;
    }
    constexpr std::size_t kMostRows = 200;
    if (out_.report.size() == kMostRows) return;
    out_.report.push_back({std::string(row.name.substr(0, kShown)), row.fate, 1, line, std::string(row.reason)});
  }

  ObjectFile& out_;
  core::Diagnostics& diagnostics_;
  const plcopen::ReadLimits& limits_;
  plcopen::XmlParser& parser_;
  std::vector<At> open_;
  Text* target_ = nullptr;  ///< of the open text. Nothing is added to its vector while it is open
  std::size_t text_depth_ = 0;
  bool member_ = false;  ///< inside a member of the object
};

template <class Load>
std::optional<ObjectFile> read_with(const std::string& name, core::Diagnostics& diagnostics,
                                    const plcopen::ReadLimits& limits, Load load) {
  ObjectFile out;
  out.path = name;
  out.file = diagnostics.add_file(name);
  try {
    const std::unique_ptr<plcopen::InputText> input = load(out.file);
    if (input == nullptr) return std::nullopt;
    plcopen::XmlParser parser(*input, out.file, diagnostics, limits);
    Handler handler(out, diagnostics, limits, parser);
    if (!parser.run(handler)) return std::nullopt;
  } catch (const std::bad_alloc&) {
    diagnostics.report(Code::P1001, {.file = out.file}, {}, "not enough memory to read the file");
    return std::nullopt;
  }
  return out;
}

}  // namespace

std::optional<ObjectFile> read_object_file(const std::string& path, core::Diagnostics& diagnostics,
                                           const plcopen::ReadLimits& limits) {
  return read_with(path, diagnostics, limits,
                   [&](std::uint16_t file) { return plcopen::InputText::from_file(path, file, diagnostics, limits); });
}

std::optional<ObjectFile> read_object_memory(std::string_view bytes, const std::string& name,
                                             core::Diagnostics& diagnostics, const plcopen::ReadLimits& limits) {
  return read_with(name, diagnostics, limits, [&](std::uint16_t file) {
    return plcopen::InputText::from_memory(bytes, file, diagnostics, limits);
  });
}

bool is_object_path(std::string_view path) {
  static constexpr std::string_view kExtensions[] = {".TcPOU", ".TcGVL", ".TcDUT", ".TcIO", ".TcTTO"};
  return std::any_of(std::begin(kExtensions), std::end(kExtensions), [&](std::string_view extension) {
    return path.size() > extension.size() && core::iequals(path.substr(path.size() - extension.size()), extension);
  });
}

}  // namespace plc::sources
