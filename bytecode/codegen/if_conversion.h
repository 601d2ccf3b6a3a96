// If-conversion: short IFs that only store BOOLs become boolean logic, as SET and RESET coils are.
//
// `IF c THEN q := TRUE; END_IF` stores q OR c, `IF c THEN q := e; ELSE q := f; END_IF` stores e where c is TRUE, else
// f. A jump is mispredicted whenever the inputs change their pattern, and ends a run of look-up records. In: a body.
// Out: the same body without those jumps. Values, events and the drawn element of each store are the same: what is
// computed in addition reads BOOLs whose place is known, and cannot raise an event. Does not belong here: look-up
// records (boolean_map.h), IFs around anything else, which stay jumps.
#pragma once

#include <optional>

#include "ir/ir.h"

namespace plc::bytecode {

/// Nothing when the body has no such IF.
std::optional<ir::Body> convert_ifs(const ir::Body& body);

}  // namespace plc::bytecode
