// coverage_svg(): a drawn body as a picture that shows which of its contacts and coils tests have seen in which state.
//
// In: a body as it is drawn, what was seen. Out: SVG. Does not belong here: what coverage means (testing/coverage.h),
// how drawings look (pictures/).
#pragma once

#include <string>

#include "bytecode/drawings.h"
#include "testing/coverage.h"

namespace plc::tools {

std::string coverage_svg(const bytecode::DrawnBody& body, const tests::CoverageReport& coverage);

}  // namespace plc::tools
