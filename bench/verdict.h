// What a measurement comes to: whether its results are right and its figures within their limits.
//
// In: figures. Out: a Verdict and words for the output. Does not belong here: the limits themselves (limits.h).
#pragma once

#include <string>
#include <vector>

#include "bench/limits.h"

namespace plc::bench {

struct Verdict {
  bool correct = true;        ///< every result was right
  bool within_limits = true;  ///< every ratio is within its limit
  void merge(const Verdict& other) {
    correct = correct && other.correct;
    within_limits = within_limits && other.within_limits;
  }
};

double median(std::vector<double> values);
/// "within 2.5" or "MISSED 2.5".
std::string limit_text(double value, const Limit& limit, Verdict& verdict);

}  // namespace plc::bench
