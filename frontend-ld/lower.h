// ld::lower_body: a body drawn in LD or FBD -> IR. Both languages share all elements in real files, so one function
// lowers both: contacts, coils and rails here, everything else through frontend-fbd.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/diagnostics.h"
#include "core/options.h"
#include "frontend-fbd/order.h"
#include "ir/builder.h"
#include "ir/ir.h"
#include "plcopen/project.h"

namespace plc::ld {

/// Lowers all drawn bodies of `pou` into module.pous[pou_index].body, in the order of SEMANTICS /
/// docs/guides/execution-order.md. Reports every problem; true (and Pou::compiled set) when there was no error.
bool lower_body(const plcopen::Pou& pou, ir::Module& module, std::uint32_t pou_index, core::Diagnostics& diagnostics);

/// What the drawn bodies of one POU have, all together.
struct Worksheets {
  bool drawn = false;      ///< elements other than rails
  bool connected = true;   ///< each has wires
  bool effective = false;  ///< something is written that others see, is run, or is jumped over
};
/// Lowers one drawn body into the one that `builder` makes, after what it has already. Reports every problem.
void lower_drawing(const plcopen::Body& body, ir::Builder& builder, Worksheets& all);
/// Warns where bodies without an error draw nothing, or nothing that has an effect.
void warn_of_idle(const plcopen::Pou& pou, const Worksheets& all, ir::Builder& builder);

/// Takes the value that is wired to the condition of a transition; nothing when there is none, or it had an error.
using ConditionSink = std::function<void(const plcopen::Element& transition, std::optional<ir::ValueId> value)>;
/// Lowers elements that are drawn between the steps of a chart into the body that `builder` makes; transitions are
/// elements with one input.
void lower_conditions(const plcopen::Body& body, ir::Builder& builder, const ConditionSink& sink);

/// One line of `plc explain`: an element at its place in the execution order.
struct OrderLine {
  std::uint32_t network = 0;  ///< 1-based
  core::SourceRef at;         ///< kind and localId name the element
  std::string text;           ///< variable, expression, or block type and instance
  fbd::Reason reason = fbd::Reason::kPosition;
  core::SourceRef with;                     ///< of kForReader and kWithBlock: the reader, the block
  std::vector<std::int64_t> feedback_from;  ///< localIds whose previous value arrives here
};
/// The execution order of one drawn body by `rule`.
std::vector<OrderLine> explain_order(const plcopen::Body& body, core::Order rule);

}  // namespace plc::ld
