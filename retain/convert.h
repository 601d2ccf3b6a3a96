// One value from a type to another one, where it fits.
//
// In: a scalar or text as it was stored. Out: the same value in the present type, or why there is none. Does not belong
// here: which value goes where (carry.h).
#pragma once

#include <cstddef>
#include <string>

#include "bytecode/image.h"

namespace plc::retain {

/// Stores what `from` of type `was` is in type `is` to `to`, normalised. Empty; or what does not fit, and `to` is as it
/// was. Both are scalars or strings.
std::string convert_leaf(const bytecode::ImageType& was, const std::byte* from, const bytecode::ImageType& is,
                         std::byte* to);

}  // namespace plc::retain
