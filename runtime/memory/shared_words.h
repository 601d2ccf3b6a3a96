// Copies out of and into memory that several threads use at once, in words that never tear.
//
// In: a private and a shared address. Out: bytes moved as relaxed atomics, in words as the shared address is aligned: a
// naturally aligned value of up to 8 bytes never tears, two values may be of different times. RT. Does not belong here:
// what keeps several values together (snapshot.h).
#pragma once

#include <cstddef>

namespace plc::runtime {

void copy_from_shared(std::byte* to, const std::byte* shared, std::size_t bytes) noexcept;
void copy_to_shared(std::byte* shared, const std::byte* from, std::size_t bytes) noexcept;
/// Stores one value of 1, 2, 4 or 8 bytes there unless it is no longer `expected`; whether it did.
bool replace_shared(std::byte* shared, const std::byte* expected, const std::byte* value, std::size_t bytes) noexcept;

}  // namespace plc::runtime
