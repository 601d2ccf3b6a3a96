// Tracer: values of variables in every scan of a task, from recorded scans: chosen afterwards.
//
// In: a player, paths, a stretch of time or a trigger. Out: a table as CSV. Threads: one. Does not belong here: where
// recordings come from, where tables go.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/clock.h"
#include "core/result.h"
#include "runtime/value_text.h"
#include "shadow/player.h"

namespace plc::shadow {

/// When something of interest happens.
struct Trigger {
  enum class Edge : std::uint8_t {
    kRising,   ///< the value was below `level`, and is not any more
    kFalling,  ///< it was not below `level`, and is now
    kChange,   ///< it is another one than after the scan before
  };
  std::string path;  ///< of a BOOL (level 0.5 = TRUE) or a number; of anything for kChange
  Edge edge = Edge::kRising;
  double level = 0.5;
};

struct TraceRequest {
  std::vector<std::string> paths;
  std::uint32_t task = 0;    ///< each scan of it is a row
  core::TimeNs from_ns = 0;  ///< `now` of the first and of the last scan
  core::TimeNs until_ns = 0;
  std::optional<Trigger> trigger;  ///< the rows around its first time in that stretch; without, all
  core::TimeNs before_ns = 0;      ///< of the time of the trigger
  core::TimeNs after_ns = 0;
  std::uint64_t most_rows = 1'000'000;
  std::size_t most_bytes = SIZE_MAX;  ///< of the table: no row begins beyond it
  runtime::ValueStyle style = runtime::ValueStyle::kNumbers;
  const std::atomic<bool>* ending = nullptr;  ///< given up, and cut, once it is true
};

struct Trace {
  std::string csv;  ///< "scan,time_ms,<path>,..", a row for each scan; time since from_ns, or since the trigger
  std::uint64_t rows = 0;
  bool cut = false;                          ///< there are more rows than most_rows, or than most_bytes hold
  std::optional<std::uint64_t> triggered{};  ///< the scan
};

/// P7101, P7102 for paths. A trigger that never comes gives no rows.
core::Result<Trace> trace(Player& player, const TraceRequest& request);

}  // namespace plc::shadow
