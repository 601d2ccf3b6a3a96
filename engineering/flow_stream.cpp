#include "engineering/flow_stream.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "engineering/diagram_services.h"
#include "engineering/validate.h"
#include "shadow/writers.h"

namespace plc::engineering {
namespace {

using namespace field;

constexpr Field kLook[] = {
    text("pou", "Whose drawing", 1, 500),
    optional(text("instance", "Path of the instance; default: the first one", 0, 1000)),
    optional(text("task", "Name of the task that executes it; default: the first one that does", 0, 200)),
    numbers("points", "Numbers of what is in view", FlowStream::kMostPoints),
};

std::string dump(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

std::string refusal_text(core::Code code, const std::string& text, const std::string& help = {}) {
  Json body = {{"code", core::info(code).name}, {"text", text}};
  if (!help.empty()) body["help"] = help;
  return dump(body);
}

}  // namespace

FlowStream::FlowStream(Context& context, core::TimeNs period_ns)
    : context_(context), period_ns_(period_ns), viewer_(context.drawn->live) {}

std::string FlowStream::take(std::string_view text) {
  const auto request = parse_json(text);
  if (!request) return refusal_text(core::Code::P7714, "the message is not JSON");
  if (const auto wrong = wrong_fields(*request, kLook))
    return refusal_text(wrong->code, wrong->field + ": " + wrong->text, wrong->help);
  if (!context_.drawn->live.on()) return refusal_text(core::Code::P7720, "nothing is recorded", kRecordingIsOff);
  Diagrams& diagrams = context_.drawn->diagrams;
  const auto opened = diagrams.open((*request)["pou"].get<std::string>());
  if (!opened) return refusal_text(core::Code::P7101, "there is no drawing of this POU");
  const auto instance =
      diagrams.instance(*opened->pou, request->value("instance", std::string()), request->value("task", std::string()));
  if (!instance) return refusal_text(core::Code::P7101, "no task executes this instance");
  const auto all = diagrams.points(*opened->pou);
  opened_ = opened;
  points_.clear();
  std::vector<bytecode::DrawnKey> keys;
  for (const Json& number : (*request)["points"]) {
    const auto row = number.get<std::uint64_t>();
    if (row >= all.size()) continue;
    keys.push_back(all[row].key);
    points_.push_back({static_cast<std::uint32_t>(row),
                       shadow::place_in(diagrams.resource(), instance->at.path, opened->names[row]),
                       {}});
  }
  viewer_.look(*instance, std::move(keys));
  ++number_;
  return dump({{"subscription", number_},
               {"pou", opened->pou->name},
               {"instance", instance->at.path},
               {"task", diagrams.resource().image().tasks[instance->task].name}});
}

std::optional<Frame> FlowStream::next() {
  const core::TimeNs now_ns = context_.clock.now_ns();
  if (now_ns < next_ns_) return {};
  const auto seen = viewer_.take();
  if (!seen) return {};
  next_ns_ = now_ns + period_ns_;
  Json changed = Json::array();
  const bool forces = context_.forces.size() != 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    Point& point = points_[i];
    FlowPoint is = flow_point(seen->shown[i], seen->texts[i]);
    if (forces && point.place && context_.forces.holds(*point.place)) is.state |= FlowPoint::kForced;
    if (point.sent == is) continue;
    changed.push_back(flow_json(point.number, is));
    point.sent = std::move(is);
  }
  return Frame{false, dump({{"subscription", number_},
                            {"scan", seen->scan},
                            {"utc_ms", seen->utc_ns / 1'000'000},
                            {"points", std::move(changed)}})};
}

}  // namespace plc::engineering
