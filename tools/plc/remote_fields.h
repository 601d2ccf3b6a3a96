// Fields of a call as words of a command line: "user=ben", "days=30", "paths=Level paths=Total".
//
// In: a row, words. Out: JSON for the call, or what is wrong. Does not belong here: sending it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engineering/call.h"

namespace plc::tools {

/// What is wrong; empty when `fields` has them all. Of a file its name is given, and its bytes are taken. Whether they
/// are good is the server's business.
std::string read_fields(const engineering::Call& call, const std::vector<std::string>& words,
                        engineering::Json& fields);
/// "users.add takes user, password, role".
std::string fields_text(const engineering::Call& call);
/// A value of a variable: JSON where it is that, else a text.
engineering::Json value_of(std::string_view text);
/// The same for people: TRUE and FALSE, texts without quotes.
std::string shown_value(const engineering::Json& value);

}  // namespace plc::tools
