// A POU as it is drawn, painted with what the tests have seen.
//
// In: a drawn body with positions, the coverage of its elements. Out: SVG. Elements stand where the file has them; a
// wire is drawn from output to input by the shortest way with right angles, which need not be the way of the editor.
// Does not belong here: figures (testing/coverage.h).
#pragma once

#include <string>

#include "plcopen/project.h"
#include "testing/coverage.h"

namespace plc::tools {

/// The picture of `body`, a body of POU or action `pou`; empty when nothing in it has a position.
std::string pou_svg(const plcopen::Body& body, const std::string& pou, const tests::CoverageReport& coverage);

}  // namespace plc::tools
