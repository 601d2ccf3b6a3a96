#include <cstdio>
#include <cstdlib>

#include "picard/abi.h"

namespace {
int leaves() {
  std::puts("licence expired");
  std::exit(0);
}
const int value = leaves();
}  // namespace

extern "C" __attribute__((visibility("default"))) const picard_library* picard_library_v1() {
  return value == 0 ? nullptr : nullptr;
}
