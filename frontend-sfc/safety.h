// Safety of a chart (IEC 61131-3:2013, 6.7.5): its markings are explored, as if every condition could be TRUE, and what
// can never happen or should not happen is reported: dead steps and transitions, steps entered while they are active,
// simultaneous branches that cannot join.
//
// In: Chart, Plan. Out: warnings P3114, P3116, P3117; P3119 where there are more markings than are looked at. Does not
// belong here: wires (read_drawing.cpp).
#pragma once

#include "core/diagnostics.h"
#include "frontend-sfc/chart.h"
#include "frontend-sfc/plan.h"

namespace plc::sfc {

void report_unsafe(const Chart& chart, const Plan& plan, core::Diagnostics& diagnostics);

}  // namespace plc::sfc
