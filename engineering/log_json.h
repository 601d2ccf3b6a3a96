// Inside engineering/: a message of the log as JSON.
#pragma once

#include <string>

#include "engineering/call.h"
#include "engineering/log_book.h"

namespace plc::engineering {

Json log_json(const LogBook::Entry& entry);
/// "note", "warning", "error".
core::Severity severity_named(const std::string& name);

}  // namespace plc::engineering
