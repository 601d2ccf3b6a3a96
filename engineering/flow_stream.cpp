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

FlowStream::Asked FlowStream::find(Context& context, std::string_view text) {
  const auto refused = [](core::Code code, const std::string& why, const std::string& help = {}) {
    return Asked{refusal_text(code, why, help), {}, {}, {}};
  };
  auto request = parse_json(text);
  if (!request) return refused(core::Code::P7714, "the message is not JSON");
  if (const auto wrong = wrong_fields(*request, kLook))
    return refused(wrong->code, wrong->field + ": " + wrong->text, wrong->help);
  if (!context.drawn->live.on()) return refused(core::Code::P7720, "nothing is recorded", kRecordingIsOff);
  Diagrams& diagrams = context.drawn->diagrams;
  auto opened = diagrams.open((*request)["pou"].get<std::string>());
  if (!opened) return refused(core::Code::P7101, "there is no drawing of this POU");
  auto instance =
      diagrams.instance(*opened->pou, request->value("instance", std::string()), request->value("task", std::string()));
  if (!instance) return refused(core::Code::P7101, "no task executes this instance");
  return {{}, (*request)["points"].get<std::vector<std::uint64_t>>(), std::move(opened), std::move(*instance)};
}

// WHY: to lay out a drawing of 100,000 elements takes 0.4 s, and other clients would wait for it.
std::function<void()> FlowStream::prepare(std::string_view text) {
  asked_ = std::make_shared<Asked>();
  asked_->refusal = refusal_text(core::Code::P7717, "there is no memory to look at it");  // until it was
  return [&context = context_, asked = asked_, text = std::string(text)] { *asked = find(context, text); };
}

std::string FlowStream::take(std::string_view text) {
  const auto prepared = std::exchange(asked_, nullptr);
  Asked asked = prepared ? std::move(*prepared) : find(context_, text);
  if (!asked.refusal.empty()) return asked.refusal;
  Diagrams& diagrams = context_.drawn->diagrams;
  opened_ = std::move(asked.opened);
  const auto all = diagrams.points(*opened_->pou);
  points_.clear();
  std::vector<bytecode::DrawnKey> keys;
  for (const std::uint64_t row : asked.points) {
    if (row >= all.size()) continue;
    keys.push_back(all[row].key);
    points_.push_back({static_cast<std::uint32_t>(row),
                       shadow::place_in(diagrams.resource(), asked.instance.at.path, opened_->names[row]),
                       {}});
  }
  viewer_.look(asked.instance, std::move(keys));
  ++number_;
  return dump({{"subscription", number_},
               {"pou", opened_->pou->name},
               {"instance", asked.instance.at.path},
               {"task", diagrams.resource().image().tasks[asked.instance.task].name}});
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
