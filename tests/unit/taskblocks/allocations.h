// How often this program asked for memory: fire() of a taskblock must not.
#pragma once

#include <cstddef>

namespace plc::blocks {

/// Calls of malloc(), and so of operator new and of Eigen, since the program started. With a sanitizer, which takes
/// malloc's place itself, those of operator new.
std::size_t allocations();

}  // namespace plc::blocks
