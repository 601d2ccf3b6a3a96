// malloc and the like of this program: glibc's, and a count for the taskblock that is running. Components, the C++
// library and all other shared objects get these. Not in builds with a sanitizer, which brings its own.
#include <cerrno>
#include <cstddef>

#include "tools/plc-run/component_faults.h"

namespace {

// RT:
void count() noexcept {
  if (plc::runtime::Program* const program = plc::tools::program_of_thread()) program->count_allocation();
}

}  // namespace

extern "C" {

// glibc's own entry points.
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  count();
  return __libc_malloc(size);
}
void* calloc(std::size_t elements, std::size_t size) {
  count();
  return __libc_calloc(elements, size);
}
void* realloc(void* block, std::size_t size) {
  count();
  return __libc_realloc(block, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  count();
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
  if (alignment < sizeof(void*) || (alignment & (alignment - 1)) != 0) return EINVAL;
  count();
  void* const made = __libc_memalign(alignment, size);
  if (made == nullptr) return ENOMEM;
  *block = made;
  return 0;
}

}  // extern "C"
