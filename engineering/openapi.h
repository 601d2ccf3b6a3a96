// The calls as an OpenAPI 3.1 document.
//
// Does not belong here: serving it (calls_target.cpp).
#pragma once

#include <string>

#include "engineering/call.h"

namespace plc::engineering {

/// Of the calls: it changes when a client of before would no longer understand.
inline constexpr int kApiVersion = 1;

const Json& openapi_document();
/// The same as it is served: made once, the first time that somebody asks.
const std::string& openapi_text();

}  // namespace plc::engineering
