// Fingerprint: a hash of what an image does and of how its variables are called, for "is it the same program?".
//
// In: images. Out: a number, or where two images differ. Does not belong here: the checksum of files (format.h).
#pragma once

#include <cstdint>
#include <string>

#include "bytecode/image.h"

namespace plc::bytecode {

/// XXH3 of the image without what only tells where it comes from and what it looks like: names of the project, of the
/// product and of files, places in files, drawings, probes. Equal numbers: the same tables, types, names, initial
/// values, tasks and instructions.
std::uint64_t fingerprint(const Image& image);

/// Where two images differ, as part of a sentence: "code of POU Main"; empty when their fingerprints are equal.
std::string difference(const Image& a, const Image& b);

}  // namespace plc::bytecode
