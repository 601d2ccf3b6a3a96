// FlowPoint: what one place of a drawing had, as clients see it.
//
// Threads: any. Does not belong here: which places.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "engineering/call.h"
#include "shadow/probe_view.h"

namespace plc::engineering {

struct FlowPoint {
  static constexpr std::uint8_t kRan = 1;      ///< executed since the frame before
  static constexpr std::uint8_t kBool = 2;     ///< power, a BOOL
  static constexpr std::uint8_t kKnown = 4;    ///< there is a value
  static constexpr std::uint8_t kOn = 8;       ///< BOOL: TRUE
  static constexpr std::uint8_t kBoth = 16;    ///< BOOL: TRUE and FALSE since the frame before
  static constexpr std::uint8_t kForced = 32;  ///< its variable is forced
  std::uint8_t state = 0;
  std::string text;  ///< the value, cut to 100 bytes; of a BOOL empty
  friend bool operator==(const FlowPoint&, const FlowPoint&) = default;
};

/// A point as it was seen; `text`: ProbeView::text().
FlowPoint flow_point(const shadow::Shown& shown, std::string text);
/// {"point", "state", "text"}.
Json flow_json(std::uint32_t number, const FlowPoint& point);
/// The record of rows.
extern const Record kFlowPoint;

}  // namespace plc::engineering
