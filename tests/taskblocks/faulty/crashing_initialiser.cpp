#include <cstdint>

#include "picard/abi.h"

namespace {
int crashes() {
  *reinterpret_cast<volatile int*>(std::uintptr_t{0x10}) = 1;
  return 0;
}
const int value = crashes();
}  // namespace

extern "C" __attribute__((visibility("default"))) const picard_library* picard_library_v1() {
  return value == 0 ? nullptr : nullptr;
}
