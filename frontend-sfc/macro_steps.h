// Macro steps: a step that stands for a chart of its own. Its steps become steps of the chart it is drawn in, as IEC
// 60848 has it: what leads to the macro step enters the entry step, what leaves it waits for the exit step.
//
// In: a drawn body. Out: the same without macro steps; P3120. Does not belong here: what wires mean (read_drawing.cpp).
#pragma once

#include <string>

#include "core/diagnostics.h"
#include "plcopen/project.h"

namespace plc::sfc {

/// True when a macro step is drawn.
bool has_macro_steps(const plcopen::Body& body);

/// The body with the charts of its macro steps in their places, also of those inside of others. Elements of these
/// charts whose localIds are taken get others. A macro step without an entry or an exit is reported and left out, with
/// what is wired to it.
plcopen::Body expand_macro_steps(const plcopen::Body& body, const std::string& pou, core::Diagnostics& diagnostics);

}  // namespace plc::sfc
