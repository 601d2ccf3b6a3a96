#include "bench/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

namespace plc::bench {

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::string limit_text(double value, const Limit& limit, Verdict& verdict) {
  const bool within = value <= limit.most;
  verdict.within_limits = verdict.within_limits && within;
  return fmt::format("{} {}", within ? "within" : "MISSED", limit.most);
}

}  // namespace plc::bench
