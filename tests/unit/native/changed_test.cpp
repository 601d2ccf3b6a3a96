// Scans that leave out what did not change: what runs again, and that tables, events and faults are those of the
// interpreter, while tables are written from outside.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "runtime/compiled_task.h"
#include "tests/fuzz/image_mutator.h"
#include "tests/support/engines.h"
#include "tests/support/random_image.h"
#include "tests/support/sample_image.h"

namespace plc::test {
namespace {
}  // namespace
}  // namespace plc::test
