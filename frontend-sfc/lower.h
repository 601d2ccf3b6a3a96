// sfc::lower_body: sequential function charts -> IR (IEC 61131-3:2013, 6.7; docs/guides/charts.md says what they do).
//
// In: charts of a POU, prepared before its bodies. Out: IR of the evaluation of each chart. Does not belong here:
// bodies in other languages, though actions and conditions may be such bodies.
#pragma once

#include <cstdint>

#include "core/diagnostics.h"
#include "frontend-sfc/prepare.h"
#include "ir/ir.h"
#include "plcopen/project.h"

namespace plc::sfc {

/// Lowers the charts that are the body of `pou_index`, the POU that `charts` belong to or an action of it. Reports
/// every problem; true (and Pou::compiled set) when there was no error.
bool lower_body(const PreparedCharts& charts, ir::Module& module, std::uint32_t pou_index,
                core::Diagnostics& diagnostics);

/// Lowers the body of a transition of a POU: it gives its condition to its result. In ST it is an expression, with ":="
/// or an assignment to its own name before it; in LD a coil, in FBD a variable, has the name of the transition.
bool lower_transition(const plcopen::Pou& transition, ir::Module& module, std::uint32_t pou_index,
                      core::Diagnostics& diagnostics);

}  // namespace plc::sfc
