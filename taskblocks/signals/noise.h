// Numbers that look random and are the same for the same seed on every machine. In: a seed; not for secrets.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace plc::blocks {

/// SplitMix64: G. L. Steele, D. Lea, C. H. Flood, Fast splittable pseudorandom number generators, OOPSLA 2014.
/// RT: all of it.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) noexcept : state_(seed) {}

  /// All 64-bit numbers are equally likely.
  std::uint64_t next() noexcept {
    std::uint64_t z = state_ += 0x9E3779B97F4A7C15;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EB;
    return z ^ (z >> 31);
  }
  /// Equally likely in [0, 1).
  double uniform() noexcept { return static_cast<double>(next() >> 11) * 0x1p-53; }
  /// Normally distributed with mean 0 and standard deviation 1 (Box and Muller, 1958); never beyond 8.6.
  double gaussian() noexcept {
    const double radius = std::sqrt(-2 * std::log(1 - uniform()));
    return radius * std::cos(2 * std::numbers::pi * uniform());
  }

 private:
  std::uint64_t state_;
};

}  // namespace plc::blocks
