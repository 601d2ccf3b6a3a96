// Sheet: one plane of a drawing while it is made: elements and wires as a body has them, and the places that the file
// gives. A body is one sheet, and one more for the chart of each macro step.
//
// In: read_sheet() from a drawn body, read_chart_sheet() from a chart that is written. Out: with places, joined into a
// DrawnBody by make.cpp. While a sheet is read, pins lie relative to the left upper corner of their element; placing it
// makes them absolute. Does not belong here: files of images, pictures.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bytecode/drawings.h"
#include "core/diagnostics.h"
#include "plcopen/project.h"

namespace plc::drawings {

using bytecode::DrawnAction;
using bytecode::DrawnComment;
using bytecode::DrawnElement;
using bytecode::DrawnPin;
using bytecode::DrawnPoint;
using bytecode::DrawnWire;
using core::ElementKind;

/// DrawnKey::pin of a point that has no value of its own: the wires of charts, an ENO that is not drawn.
inline constexpr std::uint16_t kNoPin = 0xffff;

struct Sheet {
  std::string caption;
  std::vector<DrawnElement> elements;
  std::vector<DrawnWire> wires;
  std::vector<DrawnComment> comments;
  std::vector<std::uint32_t> comment_networks;       ///< by comment: the network it is about, 0 = all
  std::vector<std::vector<DrawnPoint>> drawn_lines;  ///< by wire: as the file has it, from output to input; or empty
  std::vector<std::vector<bool>> pin_places;         ///< by element and pin: the file gives its place
  bool placed = false;                               ///< the file gives every element a place, in one plane
};

/// The elements of a body in LD, FBD or SFC. `has_plane`: positions of the file count in one plane for the whole body.
Sheet read_sheet(const plcopen::Body& body, bool has_plane);

/// Steps, transitions and what joins them of a chart that is written, as elements.
Sheet read_chart_sheet(const plcopen::Body& body, core::Diagnostics& quiet);

/// Gives the elements sizes where the file has none, and their pins places inside of them. `keep`: sizes and places of
/// the file stay.
void give_sizes(Sheet& sheet, bool keep);

/// Takes the places of the file, if it gives some that can be used: no two elements overlap. False when it
/// does not: the layouts below leave nothing of it.
bool keep_places(Sheet& sheet);

/// Lays out LD and FBD: networks below each other, in each from left to right.
void lay_out_networks(Sheet& sheet);

/// Lays out a chart: downwards, branches beside each other. What is drawn in LD and FBD for conditions comes below.
void lay_out_chart(Sheet& sheet);

/// True for what a chart is made of; false for contacts, blocks and the like.
bool is_chart_element(ElementKind kind);
/// True for divergences and convergences.
bool is_bar(ElementKind kind);
bool is_rail(ElementKind kind);

// Sizes in pixels.
inline constexpr std::int32_t kCharWidth = bytecode::kDrawnCharWidth;
inline constexpr std::int32_t kLineHeight = bytecode::kDrawnLineHeight;
inline constexpr std::int32_t kPinPitch = 18;
inline constexpr std::int32_t kMargin = 24;  ///< around a sheet
/// Width of a text: its characters, not its bytes.
std::int32_t width_of(std::string_view text);

/// The wire, from the middle of the right side of a step to the action block beside it.
void lead_from_side(Sheet& sheet, std::size_t wire);
/// A pin of the same number as `pin` at `at`, which lies on the border of the element; pins move with it when they are
/// absolute.
std::uint32_t pin_at(Sheet& sheet, std::uint32_t element, std::uint32_t pin, DrawnPoint at);
/// Makes pins absolute: they were relative to the left upper corner of their element.
void place_pins(DrawnElement& element);
/// A line from an output to an input in three pieces, for wires whose lines the file does not give.
std::vector<DrawnPoint> plain_line(const Sheet& sheet, const DrawnWire& wire);
/// Without points that change nothing.
std::vector<DrawnPoint> straightened(const std::vector<DrawnPoint>& line);

/// Free space that an element needs around its box for texts that stand outside of it.
struct Pads {
  std::int32_t left = 0, right = 0, top = 0, bottom = 0;
};
Pads pads_of(const DrawnElement& element);

}  // namespace plc::drawings
