// ValueStream: values of a subscription as frames (streams.h): those that have changed since the frame before. When
// none has for kStillNs, a frame without values tells scans and the clock.
//
// Threads: that of the connections. Does not belong here: sockets.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engineering/streams.h"

namespace plc::engineering {

class ValueStream final : public Stream {
 public:
  static constexpr std::size_t kMostValues = 20'000;
  /// Longest time without a frame. WHY: clients reckon with the clock of the machine (until_ms of values.write), which
  /// may be set.
  static constexpr core::TimeNs kStillNs = 1'000'000'000;

  ValueStream(Context& context, core::TimeNs period_ns);

  /// {"subscribe": [paths]}: the layout, or a refusal as a JSON object. Single values alone are in a layout: structures
  /// and arrays are taken apart.
  std::string take(std::string_view text) override;
  std::optional<Frame> next() override;
  [[nodiscard]] core::TimeNs period_ns() const override { return period_ns_; }

 private:
  struct Value {
    std::uint32_t task = 0;
    std::uint32_t offset = 0;
    std::uint32_t type = 0;
    std::uint32_t size = 0;
    std::uint32_t at = 0;  ///< in sent_ and newest_
    bool text = false;
  };
  /// Values of one path that lie one after the other: read and compared at once.
  struct Run {
    std::uint32_t task = 0;
    std::uint32_t offset = 0;
    std::uint32_t at = 0;
    std::uint32_t size = 0;
    std::size_t first = 0, count = 0;  ///< in values_
  };
  void add(const std::string& path, const runtime::Place& place, Json& layout);
  /// Of the values from `first` on, which are of one path.
  void add_runs(std::size_t first);
  void append(const Value& value, std::string& out) const;

  Context& context_;
  core::TimeNs period_ns_;
  std::uint32_t fastest_ = 0;
  std::uint16_t number_ = 0;
  bool whole_ = false;        ///< the next frame has all values
  core::TimeNs sent_ns_ = 0;  ///< when the latest frame was made
  std::vector<Value> values_;
  std::vector<Run> runs_;
  std::vector<std::byte> sent_, newest_;
};

}  // namespace plc::engineering
