// Clients of the engineering server, one method a call: text from its rows.
//
// Does not belong here: connections (clients/python/picard/connection.py, clients/typescript/connection.ts).
#pragma once

#include <string>

namespace plc::tools {

/// clients/python/picard/calls.py
std::string python_calls();
/// clients/typescript/calls.ts
std::string typescript_calls();

}  // namespace plc::tools
