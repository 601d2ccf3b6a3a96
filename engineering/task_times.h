// What tasks needed, as JSON: for /api/tasks and plc-run --stats=json.
//
// Threads: any, while tasks run. Does not belong here: tables for people (tools/plc-run/report.h).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "runtime/sched/statistics.h"

namespace plc::engineering {

/// The times of a task, in the order in which they happen. One row is one line, column and member.
struct Quantity {
  const char* name;
  runtime::Histogram runtime::TaskStatistics::*histogram;
};
std::span<const Quantity> quantities();

struct Share {
  const char* name;
  const char* member;  ///< of the JSON
  double share;
};
std::span<const Share> shares();

/// Count, minimum, mean, shares and maximum.
nlohmann::ordered_json times_json(const runtime::Histogram& histogram);

}  // namespace plc::engineering
