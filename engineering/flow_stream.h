// FlowStream: the power flow of the part of a diagram that a client shows, frame by frame.
//
// In: {"pou", "instance", "task", "points"} of the client. Out: texts, JSON: an answer, then frames
//   {"subscription": n, "scan": n, "utc_ms": n, "points": [FlowPoint]}
// of which the first after a change has all points, others those that have changed. Threads: that of the connections;
// what prepare() gives any. Does not belong here: sockets.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engineering/flow_points.h"
#include "engineering/live_flow.h"
#include "engineering/streams.h"

namespace plc::engineering {

class FlowStream final : public Stream {
 public:
  static constexpr std::size_t kMostPoints = 20'000;

  FlowStream(Context& context, core::TimeNs period_ns);

  std::function<void()> prepare(std::string_view text) override;
  std::string take(std::string_view text) override;
  std::optional<Frame> next() override;
  [[nodiscard]] core::TimeNs period_ns() const override { return period_ns_; }

 private:
  /// What a message of the client asks for.
  struct Asked {
    std::string refusal;  ///< or empty
    std::vector<std::uint64_t> points;
    std::shared_ptr<const Diagrams::Opened> opened;
    DrawnInstance instance;
  };
  /// Any thread.
  static Asked find(Context& context, std::string_view text);
  struct Point {
    std::uint32_t number = 0;
    std::optional<runtime::Place> place;  ///< of its variable
    std::optional<FlowPoint> sent;
  };

  Context& context_;
  core::TimeNs period_ns_;
  core::TimeNs next_ns_ = 0;
  LiveFlow::Viewer viewer_;
  std::shared_ptr<Asked> asked_;  ///< of the message that is prepared
  std::shared_ptr<const Diagrams::Opened> opened_;
  std::vector<Point> points_;
  std::uint64_t number_ = 0;
};

}  // namespace plc::engineering
