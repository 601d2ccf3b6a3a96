// How often a thread asked for memory: for tests of code that must not.
//
// Link plc_count_allocations, which takes malloc's place. Not here: who must not call the system at all (tests/rt).
#pragma once

#include <cstddef>

namespace plc::test {

/// Calls of malloc(), and so of operator new and of Eigen, by the calling thread since it started. With a sanitizer,
/// which takes malloc's place itself, those of operator new.
std::size_t allocations();

/// Those while `what` runs.
template <class What>
std::size_t allocations_of(What what) {
  const std::size_t before = allocations();
  what();
  return allocations() - before;
}

}  // namespace plc::test
