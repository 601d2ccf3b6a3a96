// Loops over records with few jumps, so that processors learn how long each run is: runs repeat in every scan.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

namespace plc::runtime {

/// Calls `one` with each of `count` records, `kStep` elements apart from `at` on. Returns what follows them. RT.
template <std::size_t kStep, class T, class One>
[[gnu::always_inline]] inline const T* repeat(const T* at, std::uint32_t count, One one) noexcept {
  const auto some = [one]<std::size_t... kNumber>(const T* from, std::index_sequence<kNumber...> /*numbers*/)
      __attribute__((always_inline)) {
    (one(from + kNumber * kStep), ...);
  };
  for (; count >= 8; count -= 8, at += 8 * kStep) some(at, std::make_index_sequence<8>{});
  if ((count & 4u) != 0) {
    some(at, std::make_index_sequence<4>{});
    at += 4 * kStep;
  }
  if ((count & 2u) != 0) {
    some(at, std::make_index_sequence<2>{});
    at += 2 * kStep;
  }
  if ((count & 1u) != 0) {
    one(at);
    at += kStep;
  }
  return at;
}

}  // namespace plc::runtime
