// The table of known elements as text, for SUPPORT.md.
//
// In: all_rules(). Out: Markdown. Does not belong here: reading files.
#pragma once

#include <string>

namespace plc::plcopen {

/// One Markdown table per place in a project: element, fate, reason. SUPPORT.md holds exactly this (a unit test
/// compares).
std::string support_tables();

}  // namespace plc::plcopen
