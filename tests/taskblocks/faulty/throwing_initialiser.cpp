#include <stdexcept>

#include "tests/taskblocks/faulty/component.h"

namespace {
int fails() { throw std::runtime_error("no configuration"); }
const int value = fails();
}  // namespace

extern "C" __attribute__((visibility("default"))) const picard_library* picard_library_v1() {
  return value == 0 ? nullptr : nullptr;
}
