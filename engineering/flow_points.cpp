#include "engineering/flow_points.h"

#include <nlohmann/json.hpp>
#include <utility>

namespace plc::engineering {
namespace {

using namespace field;

constexpr std::size_t kMostText = 100;

constexpr Field kFields[] = {
    integer("point", "Its number: data-k in the drawing", 0, UINT32_MAX),
    integer("state",
            "Sum: 1 executed since the frame before, 2 a BOOL, 4 has a value, 8 TRUE, 16 was TRUE and FALSE since the "
            "frame before, 32 its variable is forced",
            0, 63),
    optional(text("text", "The value, of what is no BOOL")),
};

}  // namespace

const Record kFlowPoint = {"FlowPoint", "What one place of a drawing had.", kFields};

FlowPoint flow_point(const shadow::Shown& shown, std::string text) {
  FlowPoint point;
  if (shown.ran) point.state |= FlowPoint::kRan;
  if (shown.is_bool) point.state |= FlowPoint::kBool;
  if (shown.known) point.state |= FlowPoint::kKnown;
  if (shown.is_bool) {
    if (shown.known && shown.on) point.state |= FlowPoint::kOn;
    if (shown.was_on && shown.was_off) point.state |= FlowPoint::kBoth;
    return point;
  }
  if (text.size() > kMostText) {
    std::size_t end = kMostText;
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0u) == 0x80u) --end;
    text.resize(end);
    text += "…";
  }
  point.text = std::move(text);
  return point;
}

Json flow_json(std::uint32_t number, const FlowPoint& point) {
  Json row = {{"point", number}, {"state", point.state}};
  if (!point.text.empty()) row["text"] = point.text;
  return row;
}

}  // namespace plc::engineering
