// Drawn programs as PLCopen XML.
//
// In: Program. Out: a project as OpenPLC Editor writes it. Does not belong here: what is drawn (program.h).
#pragma once

#include <iosfwd>

#include "bench/program.h"

namespace plc::bench {

/// One element a line, positions and rails as OpenPLC Editor writes them, about 2 kB a plain rung.
void write_plcopen(const Program& program, std::ostream& out);

}  // namespace plc::bench
