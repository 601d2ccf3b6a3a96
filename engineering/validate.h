// Checks the fields of a request, or of an answer, against their rows.
//
// In: JSON, fields (call.h). Out: what is wrong first, and where. Does not belong here: what values mean.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "engineering/answer.h"

namespace plc::engineering {

/// P7714 with the field, "values[2].path"; nothing when `object` has the required fields and no others, all as their
/// rows say.
std::optional<Refusal> wrong_fields(const Json& object, std::span<const Field> fields);
/// JSON without comments, of UTF-8, nested at most kMostDepth deep, no name twice in an object, at most 4,000 names in
/// one; nothing else.
std::optional<Json> parse_json(std::string_view text);
/// The query of a path as an object with the types of the fields: "a=1&b=x%20y". Nothing when it is none.
std::optional<Json> query_json(std::string_view query, std::span<const Field> fields);

}  // namespace plc::engineering
