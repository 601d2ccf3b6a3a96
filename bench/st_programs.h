// Workloads whose PLCopen project has bodies in ST: loops, calls of taskblocks, exchange of globals.
//
// In: size and seed. Out: Source. Does not belong here: limits (workloads.cpp), drawn programs (program.h).
#pragma once

#include <cstdint>

#include "bench/workload.h"

namespace plc::bench {

/// Products of two REALs converted to DINT; `size` of them.
Source make_products(std::uint32_t size, std::uint64_t seed);
/// Bubble sort of `size` DINTs in groups of 100, each in reverse order, the worst case.
Source make_bubble(std::uint32_t size, std::uint64_t seed);
/// FIR filter of 32 coefficients over `size` samples.
Source make_fir(std::uint32_t size, std::uint64_t seed);
/// Product of a matrix of `size` rows of 16 and one of 16 by 16, ARRAY[..,..] OF REAL.
Source make_matrix(std::uint32_t size, std::uint64_t seed);
/// CRC-32 of `size` bytes, bit by bit.
Source make_checksum(std::uint32_t size, std::uint64_t seed);

/// A chain of `size` taskblocks, each of which adds 1 to what it is given.
Source make_calls(std::uint32_t size, std::uint64_t seed);
/// Two tasks that each export `size` DINTs to the other one.
Source make_exchange(std::uint32_t size, std::uint64_t seed);

}  // namespace plc::bench
