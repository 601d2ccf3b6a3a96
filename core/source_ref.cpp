#include "core/source_ref.h"

namespace plc::core {

std::string_view element_word(ElementKind kind) {
  switch (kind) {
    case ElementKind::kNone:
      return "";
    case ElementKind::kContact:
      return "contact";
    case ElementKind::kCoil:
      return "coil";
    case ElementKind::kBlock:
      return "block";
    case ElementKind::kInVariable:
      return "inVariable";
    case ElementKind::kOutVariable:
      return "outVariable";
    case ElementKind::kInOutVariable:
      return "inOutVariable";
    case ElementKind::kConnector:
      return "connector";
    case ElementKind::kContinuation:
      return "continuation";
    case ElementKind::kJump:
      return "jump";
    case ElementKind::kLabel:
      return "label";
    case ElementKind::kReturn:
      return "return";
    case ElementKind::kLeftRail:
      return "leftPowerRail";
    case ElementKind::kRightRail:
      return "rightPowerRail";
    case ElementKind::kActionBlock:
      return "actionBlock";
    case ElementKind::kStep:
      return "step";
    case ElementKind::kTransition:
      return "transition";
    case ElementKind::kVariable:
      return "variable";
    case ElementKind::kTask:
      return "task";
    case ElementKind::kInstance:
      return "instance";
    case ElementKind::kType:
      return "type";
    case ElementKind::kText:
      return "text";
    case ElementKind::kMacroStep:
      return "macroStep";
    case ElementKind::kJumpStep:
      return "jumpStep";
    case ElementKind::kSelectionDivergence:
      return "selectionDivergence";
    case ElementKind::kSelectionConvergence:
      return "selectionConvergence";
    case ElementKind::kSimultaneousDivergence:
      return "simultaneousDivergence";
    case ElementKind::kSimultaneousConvergence:
      return "simultaneousConvergence";
  }
  return "";
}

}  // namespace plc::core
