// How often a thread asked for memory: fire() of a taskblock must not.
#pragma once

#include <cstddef>

namespace plc::blocks {

/// Calls of malloc(), and so of operator new and of Eigen, by the calling thread since it started. With a sanitizer,
/// which takes malloc's place itself, those of operator new.
std::size_t allocations();

}  // namespace plc::blocks
