// Drawn programs as C, as a good engineer writes them by hand.
//
// In: Program. Out: C source. Does not belong here: compiling it (c_side.cpp).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/program.h"

namespace plc::bench {

/// Variables and instances of blocks as lvalues of the C.
std::string c_variable(Type type, std::uint32_t variable);
std::string c_instance(Box box, std::uint32_t instance);

/// Functions of 500 rungs, or of 100 where there are blocks, four to a file.
std::vector<std::string> write_c(const Program& program);

}  // namespace plc::bench
