// Fingerprint of the C library's functions: LN, SIN, EXPT and their kin may differ in the last bit between libraries
// and kinds of processors. Two machines with one fingerprint give the same results, as far as 256 samples show.
#pragma once

#include <cstdint>

namespace plc::shadow {

/// XXH3 of results in both precisions.
std::uint64_t arithmetic_fingerprint();
/// "x86-64", "aarch64", or "another".
const char* processor_kind();

}  // namespace plc::shadow
