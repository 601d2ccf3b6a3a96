#include "sources/plcproj.h"

#include <fmt/core.h>

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

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  const char folded = core::fold(c);
  return folded >= 'a' && folded <= 'f' ? folded - 'a' + 10 : -1;
}

/// MSBuild writes characters that it takes for its own as %28.
std::string unescaped(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const int high = text[i] == '%' && i + 2 < text.size() ? hex_digit(text[i + 1]) : -1;
    const int low = high < 0 ? -1 : hex_digit(text[i + 2]);
    if (low < 0) {
      out += text[i];
      continue;
    }
    out += static_cast<char>(high * 16 + low);
    i += 2;
  }
  return out;
}

/// The name of a library in "Tc2_Standard, * (Beckhoff Automation GmbH)" and "Name,newest,Company".
std::string library_name(std::string_view text) { return std::string(core::trimmed(text.substr(0, text.find(',')))); }

class Handler final : public plcopen::XmlHandler {
 public:
  Handler(PlcProject& out, core::Diagnostics& diagnostics, plcopen::XmlParser& parser)
      : out_(out), diagnostics_(diagnostics), parser_(parser) {}

  void start_element(const char* raw, std::string_view, const plcopen::Attributes& attributes,
                     plcopen::Place place) override {
    const std::string_view name(raw);
    core::SourceRef at{.line = place.line, .column = place.column, .file = out_.file};
    ++depth_;
    if (depth_ == 1 && name != "Project") {
      diagnostics_.report(Code::P1207, at, {},
                          fmt::format(R"(root element is "{}", not "Project")", name.substr(0, 60)),
                          "give a .plcproj of TwinCAT, or the folder of its source files");
      parser_.stop();
      return;
    }
    if (name == "Compile") {
      if (const auto value = parser_.value_place(Attr::kInclude)) {
        at.line = value->line;
        at.column = value->column;
      }
      out_.entries.push_back({unescaped(core::trimmed(attributes.get(Attr::kInclude))), at, false});
      compile_ = true;
    } else if (name == "PlaceholderReference" || name == "LibraryReference") {
      out_.namespaces.push_back(library_name(attributes.get(Attr::kInclude)));
      library_ = true;
    } else if (compile_ && name == "ExcludeFromBuild") {
      begin(Target::kExcluded);
    } else if (library_ && name == "Namespace") {
      begin(Target::kNamespace);
    } else if (depth_ == 3 && name == "Name" && out_.name.empty()) {
      begin(Target::kName);
    }
  }

  void end_element() override {
    if (target_ != Target::kNone && depth_ == target_depth_) {
      parser_.end_text();
      const std::string_view text = core::trimmed(text_);
      if (target_ == Target::kExcluded) out_.entries.back().excluded = core::iequals(text, "true");
      if (target_ == Target::kNamespace && !text.empty()) out_.namespaces.back() = text;
      if (target_ == Target::kName) out_.name = text;
      target_ = Target::kNone;
    }
    if (depth_ == 3) compile_ = library_ = false;
    --depth_;
  }

  [[nodiscard]] bool wants_text() const override { return target_ != Target::kNone; }
  void text(std::string_view piece) override {
    constexpr std::size_t kMost = 1024;
    text_ += piece.substr(0, kMost - std::min(kMost, text_.size()));
  }

 private:
  enum class Target : std::uint8_t { kNone, kExcluded, kNamespace, kName };
  void begin(Target target) {
    if (target_ != Target::kNone) return;
    target_ = target;
    target_depth_ = depth_;
    text_.clear();
    parser_.begin_text();
  }

  PlcProject& out_;
  core::Diagnostics& diagnostics_;
  plcopen::XmlParser& parser_;
  std::size_t depth_ = 0;
  bool compile_ = false;  ///< inside of Compile
  bool library_ = false;  ///< inside of a reference to a library
  Target target_ = Target::kNone;
  std::size_t target_depth_ = 0;
  std::string text_;
};

template <class Load>
std::optional<PlcProject> read_with(const std::string& name, core::Diagnostics& diagnostics,
                                    const plcopen::ReadLimits& limits, Load load) {
  PlcProject out;
  out.file = diagnostics.add_file(name);
  try {
    const std::unique_ptr<plcopen::InputText> input = load(out.file);
    if (input == nullptr) return std::nullopt;
    plcopen::XmlParser parser(*input, out.file, diagnostics, limits);
    Handler handler(out, diagnostics, parser);
    if (!parser.run(handler)) return std::nullopt;
  } catch (const std::bad_alloc&) {
    diagnostics.report(Code::P1001, {.file = out.file}, {}, "not enough memory to read the file");
    return std::nullopt;
  }
  std::erase(out.namespaces, std::string());
  return out;
}

}  // namespace

std::optional<PlcProject> read_plcproj(const std::string& path, core::Diagnostics& diagnostics,
                                       const plcopen::ReadLimits& limits) {
  return read_with(path, diagnostics, limits,
                   [&](std::uint16_t file) { return plcopen::InputText::from_file(path, file, diagnostics, limits); });
}

std::optional<PlcProject> read_plcproj_memory(std::string_view bytes, const std::string& name,
                                              core::Diagnostics& diagnostics, const plcopen::ReadLimits& limits) {
  return read_with(name, diagnostics, limits, [&](std::uint16_t file) {
    return plcopen::InputText::from_memory(bytes, file, diagnostics, limits);
  });
}

}  // namespace plc::sources
