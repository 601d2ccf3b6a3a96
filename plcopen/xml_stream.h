// libxml2's SAX2 interface as start, text and end events with exact places. The one file that knows libxml2 is
// xml_stream.cpp.
//
// In: InputText. Out: events to an XmlHandler; P1002, P1004, P1005, P1006. Does not belong here: PLCopen.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>

#include "core/diagnostics.h"
#include "plcopen/input_text.h"
#include "plcopen/reader.h"
#include "plcopen/text_walk.h"

namespace plc::plcopen {

enum class Attr : std::uint8_t {
#define PLC_ATTRIBUTE(Name, spelling) k##Name,
#include "plcopen/attributes.def"
  kXsiType,
};
inline constexpr std::size_t kAttrCount = static_cast<std::size_t>(Attr::kXsiType) + 1;
/// "localId"; "xsi:type" for kXsiType.
std::string_view attribute_name(Attr attribute);

/// The attributes of the current start tag. Views are valid during the start event only.
class Attributes {
 public:
  [[nodiscard]] bool has(Attr attribute) const { return stamps_[index(attribute)] == stamp_; }
  /// Value, or empty when absent.
  [[nodiscard]] std::string_view get(Attr attribute) const {
    return has(attribute) ? values_[index(attribute)] : std::string_view();
  }
  /// Name of an attribute that is not known, and would be with other capitals: meant(); empty when there is none.
  [[nodiscard]] std::string_view in_other_case() const { return other_case_; }
  [[nodiscard]] Attr meant() const { return meant_; }

 private:
  friend class XmlParser;
  static std::size_t index(Attr attribute) { return static_cast<std::size_t>(attribute); }

  std::array<std::string_view, kAttrCount> values_;
  std::array<std::uint32_t, kAttrCount> stamps_{};
  std::uint32_t stamp_ = 0;
  std::string_view other_case_;
  Attr meant_{};
  std::deque<std::string> decoded_;  ///< values that needed decoding; a deque keeps the views valid
};

class XmlHandler {
 public:
  virtual ~XmlHandler() = default;
  /// `name` is the local name; the same name always has the same address during one parse.
  virtual void start_element(const char* name, std::string_view uri, const Attributes& attributes, Place place) = 0;
  virtual void end_element() = 0;
  /// True when text events are wanted now.
  [[nodiscard]] virtual bool wants_text() const = 0;
  /// True when a line ends before `piece` though the file has no line end there; it is given as a text of its own.
  virtual bool ends_line_before(std::string_view /*piece*/) { return false; }
  /// A piece of character data, entities and line ends resolved.
  virtual void text(std::string_view piece) = 0;
};

/// Runs over the whole text. False when it is not well-formed or exceeds a limit (reported). `stop()` may be called by
/// the handler to end early; the result is then false as well.
class XmlParser {
 public:
  XmlParser(const InputText& input, std::uint16_t file, core::Diagnostics& diagnostics, const ReadLimits& limits)
      : text_(input.text()),
        file_(file),
        diagnostics_(diagnostics),
        limits_(limits),
        places_(text_),
        walk_(text_, places_) {}
  bool run(XmlHandler& handler);
  void stop();

  /// The text events from now on belong to one text, until end_text().
  void begin_text() { walk_.begin(); }
  void end_text() { walk_.end(); }
  /// Place of the first character of the text that is no blank; there was one.
  [[nodiscard]] Place text_place() const { return walk_.first().value_or(Place{}); }
  /// During a start event: place of the first character of an attribute's value that is no blank. None where there is
  /// no such character.
  std::optional<Place> value_place(Attr attribute);
  /// Place after what was read last.
  Place end_place() { return places_.at(content_); }

 private:
  struct Callbacks;
  struct CachedName {
    const char* name = nullptr;
    int attribute = -1;
    int meant = -1;  ///< attribute of this name in other capitals
  };
  void fill(int count, const unsigned char** attributes);
  const CachedName& attribute_of(const char* name);
  void problem(core::Code code, std::size_t offset, std::string message, std::string help = {});
  [[nodiscard]] std::size_t offset() const;

  static constexpr int kMaxNamespaceProblems = 20;

  std::string_view text_;
  std::uint16_t file_;
  core::Diagnostics& diagnostics_;
  const ReadLimits& limits_;
  PlaceFinder places_;
  XmlHandler* handler_ = nullptr;
  void* context_ = nullptr;  ///< xmlParserCtxt
  Attributes attributes_;
  std::array<CachedName, 256> names_{};
  TextWalk walk_;
  std::size_t tag_ = 0;      ///< offset of the last start tag
  std::size_t content_ = 0;  ///< offset after the last tag
  std::size_t elements_ = 0;
  std::size_t depth_ = 0;
  std::size_t namespaces_ = 0;  ///< in scope
  std::deque<std::size_t> namespace_marks_;
  int namespace_problems_ = 0;
  bool failed_ = false;
};

}  // namespace plc::plcopen
