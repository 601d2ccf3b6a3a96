// What `plc explain` says of a chart: its steps with their actions, and the order in which their transitions are
// tested.
//
// In: a body in SFC. Out: lines of text. Does not belong here: printing.
#pragma once

#include <string>
#include <vector>

#include "plcopen/project.h"

namespace plc::sfc {

/// Lines without their ends. `final_scan`: bodies of actions run once more when they end.
std::vector<std::string> explain_chart(const plcopen::Body& body, bool final_scan);

}  // namespace plc::sfc
