// DrawnKey: the name of a place in a drawing or text, for what knows values and what knows the drawing.
//
// In: made by front ends (ir/probes.h) and with drawings (drawings.h). Out: viewers join both. Does not belong here:
// what it looks like.
#pragma once

#include <compare>
#include <cstdint>

namespace plc::bytecode {

/// Which point of an element a value belongs to.
enum class DrawnSide : std::uint8_t {
  /// The element itself. Contact, coil, variable: its variable. Step: active when the evaluation of the chart began.
  /// Transition: it fired. Action: it is executed. Statement: it was reached. Jump, return: it was taken.
  kWhole,
  /// An input pin, after negation, edge and storage drawn there; of contact, coil, jump, return and right rail the
  /// power
  /// in front of them. Transition: its condition.
  kInput,
  /// An output pin, before what readers draw at theirs; of rails, contacts and coils the power behind them. Step: how
  /// long it has been active.
  kOutput,
};

/// The name of a place in a drawing or text whose value can be shown. It holds without any drawing: probes carry it,
/// and a viewer joins both.
///
/// - LD, FBD: `local_id`, `line`, `column` of the element (plcopen::Element::at), `pin` and `side`. Inputs count as
///   fbd::Node does, Element::inputs and then Element::in_outs; outputs Element::outputs and then Element::in_outs.
///   An ENO that is not drawn has no key. Pins that the compiler adds to a block follow those that are drawn.
/// - ST, IL: `local_id` is -1, `line` and `column` are those of the first character of the statement or instruction
///   (kWhole), or of the name or expression whose value it is (kOutput). `pin` is 0.
/// - SFC: a step, macro step or transition as it is drawn (Element::at) or written (sfc::Step::at, sfc::Transition::at,
///   `local_id` -1). An action: the place of its association (plcopen::ActionLink::at, sfc::Association::at), kWhole.
///   Actions of the step itself in CODESYS: the step, kWhole, `pin` 1 entry, 2 main, 3 exit. In a macro step elements
///   have the localIds that the whole chart gives them (sfc::expand_macro_steps).
struct DrawnKey {
  std::uint32_t pou = 0;  ///< whose code it is, into Image::pous: a POU, an action, the body of a transition
  std::int64_t local_id = -1;
  std::uint32_t line = 0, column = 0;  ///< 1-based, in the file of the POU
  std::uint16_t pin = 0;
  DrawnSide side = DrawnSide::kWhole;
  friend auto operator<=>(const DrawnKey&, const DrawnKey&) = default;
};

}  // namespace plc::bytecode
