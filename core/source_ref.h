// Where in the user's files something came from. Every IR instruction and every code range carries one, so that a
// diagnostic, a runtime fault, the power flow and the coverage can name the drawn element.
#pragma once

#include <cstdint>
#include <string_view>

namespace plc::core {

/// What kind of thing a SourceRef points at. The word goes into messages: "[POU Fill, block 14]".
enum class ElementKind : std::uint8_t {
  kNone,
  kContact,
  kCoil,
  kBlock,
  kInVariable,
  kOutVariable,
  kInOutVariable,
  kConnector,
  kContinuation,
  kJump,
  kLabel,
  kReturn,
  kLeftRail,
  kRightRail,
  kActionBlock,
  kStep,
  kTransition,
  kVariable,  ///< a declaration
  kTask,
  kInstance,
  kType,
  kText,  ///< a statement or expression of a textual body
  kMacroStep,
  kJumpStep,
  kSelectionDivergence,
  kSelectionConvergence,
  kSimultaneousDivergence,
  kSimultaneousConvergence,
};
/// The last of them: images store kinds as numbers.
inline constexpr ElementKind kLastElementKind = ElementKind::kSimultaneousConvergence;
/// "contact", "coil", "block", ...; empty for kNone.
std::string_view element_word(ElementKind kind);

/// A place in a file and, if it is drawn, the element there.
struct SourceRef {
  std::uint32_t line = 0;      ///< 1-based; 0 = no place in a file
  std::uint32_t column = 0;    ///< 1-based, in characters of the XML file
  std::int64_t local_id = -1;  ///< localId of the drawn element (TwinCAT's exceed 32 bits), -1 = none
  std::uint16_t file = 0;      ///< index into the compilation's list of input files
  ElementKind kind = ElementKind::kNone;
  friend bool operator==(const SourceRef&, const SourceRef&) = default;
};

}  // namespace plc::core
