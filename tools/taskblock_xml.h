// Taskblocks as a PLCopen XML project that editors import, so that they can be drawn.
//
// In: a registry's entries. Out: XML (TC6 2.01): the structures of their ports, and one function block without
// statements for each, with its ports and what they mean. A project that comes back with them is as it was without:
// add_taskblocks() drops them. Does not belong here: files.
#pragma once

#include <span>
#include <string>

#include "taskblocks/registry.h"

namespace plc::tools {

std::string taskblocks_xml(std::span<const taskblocks::Registry::Entry* const> entries);

}  // namespace plc::tools
