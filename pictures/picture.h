// Pictures of drawings: SVG for browsers, print and screen readers. No scripts, nothing from elsewhere.
//
// In: a body of bytecode::Drawings, and what is known of its places. Out: text. Does not belong here: where values come
// from, layout (drawings/), files.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>

#include "bytecode/drawings.h"

namespace plc::pictures {

/// How a place is drawn.
enum class Look : std::uint8_t {
  kPlain,   ///< nothing is known: thin and dark
  kOn,      ///< TRUE, active, executed: thick, green
  kOff,     ///< FALSE, inactive: thin, grey
  kNotRun,  ///< execution did not come by: dashed, grey
  kSeen,    ///< coverage: in every state
  kHalf,    ///< coverage: in one state only
  kUnseen,  ///< coverage: in none
};

struct Mark {
  Look look = Look::kPlain;
  std::string text;  ///< a value or a remark, beside the place; or empty
  /// By which a viewer finds the place in a Sheet, and fills in look and value itself; -1 = it does not.
  std::int64_t id = -1;
};

/// What is known, by place. A wire looks like the output it comes from, or else like the input it leads to.
using Marks = std::map<bytecode::DrawnKey, Mark>;

/// A body in a picture.
struct PicturedBody {
  const bytecode::DrawnBody* body = nullptr;
  std::string caption;    ///< a line above it, or empty
  std::uint32_t pou = 0;  ///< whose marks it shows: DrawnKey::pou
};

/// The bodies below each other as one SVG document: in light colours, which print, and dark ones where the reader
/// prefers them. `title` is for screen readers and tabs of browsers. Any text whatever gives well-formed XML.
std::string svg(std::string_view title, std::span<const PicturedBody> bodies, const Marks& marks = {});

/// Text as it stands in XML: with entities, without characters that XML does not have; what is not UTF-8 becomes
/// U+FFFD.
std::string escaped(std::string_view text);

}  // namespace plc::pictures
