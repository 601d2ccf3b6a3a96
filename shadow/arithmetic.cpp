#include "shadow/arithmetic.h"

#include <xxhash.h>

#include <cmath>
#include <vector>

namespace plc::shadow {

std::uint64_t arithmetic_fingerprint() {
  // Volatile: what the compiler works out is not what the library gives.
  volatile double step = 0.137;
  std::vector<double> results;
  std::vector<float> narrow;
  for (int i = 1; i <= 16; ++i) {
    const double x = step * i;
    const auto y = static_cast<float>(x);
    for (const double r : {std::log(x), std::log10(x), std::exp(x), std::sin(x * 10), std::cos(x * 10), std::tan(x),
                           std::pow(x, 1.7), std::atan(x)}) {
      results.push_back(r);
    }
    for (const float r : {std::log(y), std::log10(y), std::exp(y), std::sin(y * 10), std::cos(y * 10), std::tan(y),
                          std::pow(y, 1.7F), std::atan(y)}) {
      narrow.push_back(r);
    }
  }
  return XXH3_64bits_withSeed(narrow.data(), narrow.size() * sizeof(float),
                              XXH3_64bits(results.data(), results.size() * sizeof(double)));
}

const char* processor_kind() {
#if defined(__x86_64__)
  return "x86-64";
#elif defined(__aarch64__)
  return "aarch64";
#else
  return "another";
#endif
}

}  // namespace plc::shadow
