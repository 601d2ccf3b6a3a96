// DiagramServices: what the calls of diagrams share: drawings, live viewers, the past.
//
// Threads: as its members say. Does not belong here: rows.
#pragma once

#include "engineering/diagrams.h"
#include "engineering/live_flow.h"
#include "engineering/past_views.h"

namespace plc::engineering {

struct DiagramServices {
  explicit DiagramServices(runtime::Resource& resource) : diagrams(resource) {}
  Diagrams diagrams;
  LiveFlow live;
  PastViews past;
};

inline constexpr const char* kRecordingIsOff = "[record] mode in plc.toml, or --record, is off";

}  // namespace plc::engineering
