// reduce: makes a failing image smaller, so that a reader sees what it is about.
//
// In: an image, and whether an image fails. Out: an image that fails, with instructions left out. Does not belong here:
// what failing is.
#pragma once

#include <functional>

#include "bytecode/image.h"

namespace plc::test {

/// `fails` is also asked about images that the verifier refuses; those do not count as failing.
bytecode::Image reduce(bytecode::Image image, const std::function<bool(const bytecode::Image&)>& fails);

}  // namespace plc::test
