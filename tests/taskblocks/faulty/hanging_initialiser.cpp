#include <unistd.h>

#include "picard/abi.h"

namespace {
int hangs() {
  for (;;) ::pause();
}
const int value = hangs();
}  // namespace

extern "C" __attribute__((visibility("default"))) const picard_library* picard_library_v1() {
  return value == 0 ? nullptr : nullptr;
}
