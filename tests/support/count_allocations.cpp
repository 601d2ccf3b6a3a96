#include "tests/support/count_allocations.h"

#include <cstdlib>
#include <new>

namespace {
thread_local std::size_t count;
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
void* operator new(std::size_t size) {
  ++count;
  void* const memory = std::malloc(size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
void* operator new(std::size_t size, const std::nothrow_t& /*tag*/) noexcept {
  ++count;
  return std::malloc(size);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t /*size*/) noexcept { std::free(memory); }
#else
extern "C" {
void* __libc_malloc(std::size_t size);
void* malloc(std::size_t size) {
  ++count;
  return __libc_malloc(size);
}
}
#endif

namespace plc::test {

std::size_t allocations() { return count; }

}  // namespace plc::test
