// Counts what operator new gives out on this thread: for tests of code that must not allocate.
//
// In: nothing. Not here: malloc() itself (tests/rt interposes it).
#pragma once

#include <cstddef>
#include <cstdlib>
#include <new>

namespace plc::test {

inline thread_local std::size_t allocations = 0;

/// Allocations while `what` runs. A test that uses it asks first whether the counter is the one that counts.
template <class What>
std::size_t allocations_of(What what) {
  const std::size_t before = allocations;
  what();
  return allocations - before;
}

}  // namespace plc::test

// WHY weak: each test file of an executable may include this, and one definition is enough.
__attribute__((weak)) void* operator new(std::size_t size) {
  ++plc::test::allocations;
  void* const at = std::malloc(size == 0 ? 1 : size);
  if (at == nullptr) throw std::bad_alloc();
  return at;
}
__attribute__((weak)) void operator delete(void* at) noexcept { std::free(at); }
__attribute__((weak)) void operator delete(void* at, std::size_t) noexcept { std::free(at); }
