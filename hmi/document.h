// Document: the HMI pages of a project, as pages.toml in its folder has them (docs/adr/0064).
//
// In: text of TOML, or a document made otherwise. Out: a document, with places for messages; text whose form depends on
// the document alone, a table for each element, so that versions can be compared line by line. Comments stay with the
// table that they stand in or before. Does not belong here: which variables there are, files (engineering/hmi_pages.h).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/diagnostics.h"
#include "hmi/rows.h"

namespace plc::hmi {

/// Of a key; nothing when it is not there.
using Value = std::variant<std::monostate, bool, double, std::string, std::vector<std::string>>;

/// One thing on a page. Places count in cells from the upper left corner, from 0.
struct Element {
  Kind kind = Kind::kText;
  std::int64_t x = 0, y = 0;
  std::int64_t width = 1, height = 1;
  std::array<Value, kKeyCount> values;  ///< by the position of the key in kKeys
  std::vector<std::string> comment;     ///< lines without their #
  core::SourceRef at;                   ///< its table
  struct Place {
    std::uint32_t line = 0, column = 0;
  };
  std::array<Place, kKeyCount> places = {};  ///< of `values`; line 0: not known

  /// Where the value of a key is; its table where that is not known.
  [[nodiscard]] core::SourceRef place(std::size_t key) const {
    core::SourceRef place = at;
    if (places[key].line == 0) return place;
    place.line = places[key].line;
    place.column = places[key].column;
    return place;
  }
  [[nodiscard]] std::string_view text(std::size_t key) const {
    const auto* text = std::get_if<std::string>(&values[key]);
    return text == nullptr ? std::string_view{} : *text;
  }
  [[nodiscard]] std::optional<double> number(std::size_t key) const {
    const auto* number = std::get_if<double>(&values[key]);
    return number == nullptr ? std::nullopt : std::optional(*number);
  }
  [[nodiscard]] bool is_true(std::size_t key) const {
    const auto* flag = std::get_if<bool>(&values[key]);
    return flag != nullptr && *flag;
  }
};

struct Page {
  std::string name;   ///< letters, digits, - and _: for links and addresses
  std::string title;  ///< empty: the name
  std::int64_t columns = kColumns, rows = kRows;
  std::vector<Element> elements;
  std::vector<std::string> comment;
  core::SourceRef at;
};

struct Document {
  std::vector<Page> pages;
  std::vector<std::string> comment;  ///< at the beginning of the file
};

/// P7770 to P7775 into `diagnostics`, with line and column in `file`; nothing when one of them is an error.
std::optional<Document> read_document(std::string_view text, std::string_view file, core::Diagnostics& diagnostics);
/// The text of pages.toml: read_document() gives the same document. It checks nothing.
std::string write_document(const Document& document);
/// What a line (from 1) of the text of write_document() is of, as a field of pages.save: "pages[0].elements[2].low";
/// empty: of none.
std::string field_of_line(std::string_view written, std::uint32_t line);

/// What an element lets operators write.
struct Offer {
  enum class Way : std::uint8_t {
    kAny,    ///< every value of a BOOL
    kRange,  ///< from low to high, both included; where one is missing: as far as the type goes
    kValue,  ///< `value` alone
    kPress,  ///< TRUE as long as it is held
  } way = Way::kAny;
  std::string path;
  std::optional<double> low, high;
  Value value;
  core::SourceRef at;  ///< of the variable
};
std::vector<Offer> offers_of(const Document& document);

}  // namespace plc::hmi
