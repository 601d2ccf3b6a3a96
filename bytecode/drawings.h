// Drawings: what POUs look like, for people who watch, explain or print a program. An image may carry them; nothing
// that executes reads them.
//
// In: made from a project (drawings/), or unpacked from an image. Out: read by viewers. Coordinates are pixels of an
// undistorted drawing, x to the right, y down, from 0; every element has a place, whether the file gave it one or it
// was laid out by rule. Texts are UTF-8 as the file has them: a viewer escapes them. Does not belong here: XML, layout,
// SVG.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bytecode/drawn_key.h"
#include "core/result.h"
#include "core/source_ref.h"

namespace plc::bytecode {

enum class DrawnLanguage : std::uint8_t { kLd, kFbd, kSt, kIl, kSfc };
inline constexpr DrawnLanguage kLastDrawnLanguage = DrawnLanguage::kSfc;

struct DrawnPoint {
  std::int32_t x = 0, y = 0;
  friend bool operator==(const DrawnPoint&, const DrawnPoint&) = default;
};

enum class DrawnEdge : std::uint8_t { kNone, kRising, kFalling };
enum class DrawnStorage : std::uint8_t { kNone, kSet, kReset };

/// Negation, edge and storage as they are drawn at an element or a pin.
struct DrawnModifiers {
  bool negated = false;
  DrawnEdge edge = DrawnEdge::kNone;
  DrawnStorage storage = DrawnStorage::kNone;
  friend bool operator==(const DrawnModifiers&, const DrawnModifiers&) = default;
};

struct DrawnPin {
  std::string name;  ///< as drawn, or empty
  std::string text;  ///< variable or expression that stands at the pin instead of a wire, or empty
  bool output = false;
  std::uint16_t pin = 0;  ///< DrawnKey::pin
  DrawnModifiers modifiers;
  DrawnPoint at;  ///< where its wires end, on the border of the element
  friend bool operator==(const DrawnPin&, const DrawnPin&) = default;
};

/// An action at a step: a row of an action block, or one of the step's own (CODESYS).
struct DrawnAction {
  std::string qualifier;  ///< "N", "S", .. ; "entry", "main", "exit" for the step's own
  std::string text;       ///< name of the action or variable, or the ST written here
  std::string time;       ///< as written, or empty
  std::string indicator;  ///< indicator variable, or empty
  std::uint32_t line = 0, column = 0;
  friend bool operator==(const DrawnAction&, const DrawnAction&) = default;
};

struct DrawnElement {
  core::ElementKind kind = core::ElementKind::kNone;
  std::int64_t local_id = -1;
  std::uint32_t line = 0, column = 0;
  std::uint16_t sheet = 0;    ///< into DrawnBody::sheets
  std::uint32_t network = 0;  ///< 1-based in LD and FBD, in the order of the drawing; 0 in charts
  /// Variable or expression; type of a block; name of connector, continuation, label, step; target of a jump;
  /// transition: its condition as text, empty when it is drawn.
  std::string text;
  std::string instance;       ///< block: name of the instance, or empty
  std::string code;           ///< block: ST of an EXECUTE box
  DrawnModifiers modifiers;   ///< contact, coil, variable
  std::int32_t x = 0, y = 0;  ///< left upper corner
  std::int32_t width = 0, height = 0;
  std::vector<DrawnPin> pins;        ///< several have one number where wires meet a rail or a bar in several places
  bool initial = false;              ///< step
  std::int64_t priority = -1;        ///< transition: small numbers first; -1 = none
  std::uint16_t macro_sheet = 0;     ///< macro step: the sheet with its chart; 0 = it has none
  std::vector<DrawnAction> actions;  ///< step, action block
  friend bool operator==(const DrawnElement&, const DrawnElement&) = default;
};

/// A wire from an output to an input. Its polyline begins at the one pin and ends at the other; a wire to a connector's
/// continuation is not drawn and none.
struct DrawnWire {
  std::uint32_t from = 0;      ///< into DrawnBody::elements
  std::uint32_t from_pin = 0;  ///< into DrawnElement::pins, an output
  std::uint32_t to = 0;
  std::uint32_t to_pin = 0;  ///< an input
  std::vector<DrawnPoint> points;
  friend bool operator==(const DrawnWire&, const DrawnWire&) = default;
};

struct DrawnComment {
  std::string text;
  std::uint16_t sheet = 0;
  std::int32_t x = 0, y = 0, width = 0, height = 0;
  friend bool operator==(const DrawnComment&, const DrawnComment&) = default;
};

/// A statement of ST or an instruction of IL: from its first character to the one behind its last.
struct DrawnStatement {
  std::uint32_t line = 0, column = 0;  ///< 1-based, in the file
  std::uint32_t end_line = 0, end_column = 0;
  friend bool operator==(const DrawnStatement&, const DrawnStatement&) = default;
};

enum class DrawnOwner : std::uint8_t { kProgram, kFunctionBlock, kFunction, kAction, kTransition };
inline constexpr DrawnOwner kLastDrawnOwner = DrawnOwner::kTransition;

/// One body: a drawing, or a text.
struct DrawnBody {
  /// "Main", "Main.Start" of an action or transition. All of Image::pous of this name execute it: one, or one for each
  /// set of array bounds.
  std::string name;
  DrawnOwner owner = DrawnOwner::kProgram;
  std::string worksheet;  ///< of a POU that has several bodies (IEC 61131-10), or empty
  DrawnLanguage language = DrawnLanguage::kLd;
  std::string file;  ///< where it is, as Image::files has it

  /// LD, FBD, SFC. Charts that are written as text are drawn, too.
  std::vector<DrawnElement> elements;
  std::vector<DrawnWire> wires;
  std::vector<DrawnComment> comments;
  std::vector<std::string> sheets;  ///< captions: the body itself, then the chart of each macro step

  /// ST, IL, charts that are written.
  std::string text;
  std::uint32_t text_line = 0, text_column = 0;  ///< place of its first character in the file
  std::vector<DrawnStatement> statements;        ///< in the order of the text; an IF stands before what is in it
  friend bool operator==(const DrawnBody&, const DrawnBody&) = default;
};

struct Drawings {
  std::vector<DrawnBody> bodies;  ///< in the order of the project; actions and transitions follow their POU
  friend bool operator==(const Drawings&, const Drawings&) = default;
};

/// As bytes, compressed, for Image::drawings.
std::vector<std::byte> pack(const Drawings& drawings);
/// The drawings in `bytes`. Nothing in a result points outside of it: elements, pins and sheets exist, numbers of kinds
/// are known ones, sizes and places are at most kMaxDrawn. Refuses all else (P6004), and what unpacks to more than
/// kMaxUnpackedBytes.
core::Result<Drawings> unpack(std::span<const std::byte> bytes);

/// Drawings are made for texts in a monospaced font of 11 pixels: pixels from character to character, from line to
/// line.
inline constexpr std::int32_t kDrawnCharWidth = 7;
inline constexpr std::int32_t kDrawnLineHeight = 14;

/// No coordinate or size is larger, in either direction.
inline constexpr std::int32_t kMaxDrawn = 1 << 24;
inline constexpr std::size_t kMaxUnpackedBytes = std::size_t{1} << 30;

/// The key of a pin, an element, an action or a statement of a body that code of `pou` belongs to.
DrawnKey key_of(std::uint32_t pou, const DrawnElement& element);
DrawnKey key_of(std::uint32_t pou, const DrawnElement& element, const DrawnPin& pin);
DrawnKey key_of(std::uint32_t pou, const DrawnElement& element, std::size_t action);
DrawnKey key_of(std::uint32_t pou, const DrawnStatement& statement);

}  // namespace plc::bytecode
