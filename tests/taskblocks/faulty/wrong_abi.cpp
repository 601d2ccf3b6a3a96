#include "picard/abi.h"

extern "C" __attribute__((visibility("default"))) const picard_library* picard_library_v1() {
  static picard_library library{};
  library.abi_version = PICARD_ABI_VERSION + 1;
  return &library;
}
