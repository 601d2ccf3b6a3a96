#include "picard/abi.h"

extern "C" const picard_library* nobody_has_this();
extern "C" __attribute__((visibility("default"))) const picard_library* picard_library_v1() {
  return nobody_has_this();
}
