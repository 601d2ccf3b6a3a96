#include "engineering/task_times.h"

#include <nlohmann/json.hpp>

namespace plc::engineering {
namespace {

using runtime::TaskStatistics;

constexpr Quantity kQuantities[] = {{"latency", &TaskStatistics::latency},
                                    {"scan", &TaskStatistics::scan_time},
                                    {"response", &TaskStatistics::response}};
constexpr Share kShares[] = {{"p50", "p50_ns", 0.5}, {"p99", "p99_ns", 0.99}, {"p99.9", "p99_9_ns", 0.999}};

}  // namespace

std::span<const Quantity> quantities() { return kQuantities; }
std::span<const Share> shares() { return kShares; }

nlohmann::ordered_json times_json(const runtime::Histogram& histogram) {
  nlohmann::ordered_json times;
  times["count"] = histogram.count();
  times["min_ns"] = histogram.min_ns();
  times["mean_ns"] = histogram.mean_ns();
  for (const Share& share : kShares) times[share.member] = histogram.percentile_ns(share.share);
  times["max_ns"] = histogram.max_ns();
  return times;
}

}  // namespace plc::engineering
