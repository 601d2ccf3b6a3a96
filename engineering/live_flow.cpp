#include "engineering/live_flow.h"

#include <algorithm>
#include <utility>

namespace plc::engineering {

using shadow::ProbeView;
using shadow::Shown;

void LiveFlow::Viewer::look(const DrawnInstance& instance, std::vector<bytecode::DrawnKey> keys) {
  const bool same = looks_ && instance.task == instance_.task && instance.at.view == instance_.at.view;
  std::map<bytecode::DrawnKey, Bits> before;
  for (std::size_t i = 0; same && i < keys_.size(); ++i) before.emplace(keys_[i], bits_[i]);
  instance_ = instance;
  keys_ = std::move(keys);
  bits_.assign(keys_.size(), {});
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    if (const auto known = before.find(keys_[i]); known != before.end()) bits_[i] = known->second;
  }
  fresh_ = fresh_ && same;
  if (same) return;
  looks_ = true;
  flow_.look(*this);
}

void LiveFlow::look(Viewer& viewer) {
  if (shadow_ == nullptr) return;
  if (std::find(viewers_.begin(), viewers_.end(), &viewer) == viewers_.end()) viewers_.push_back(&viewer);
  if (!viewer_) viewer_ = std::make_unique<shadow::Shadow::Viewer>(*shadow_);
  regroup();
}

void LiveFlow::forget(Viewer& viewer) {
  const auto found = std::find(viewers_.begin(), viewers_.end(), &viewer);
  if (found == viewers_.end()) return;
  viewers_.erase(found);
  regroup();
  if (!viewers_.empty()) return;
  // Replicas run as they were made, for others who look at variables alone.
  viewer_->read([this](shadow::Follower& follower) { apply(follower); });
  viewer_.reset();
}

void LiveFlow::regroup() {
  std::map<Place, Group> groups;
  for (const Viewer* const viewer : viewers_) {
    const Place place{viewer->instance_.task, viewer->instance_.at.view};
    const auto known = groups_.find(place);
    groups.emplace(place, known == groups_.end() ? Group{} : known->second);
  }
  changed_ = changed_ || groups.size() != groups_.size() ||
             !std::equal(groups.begin(), groups.end(), groups_.begin(),
                         [](const auto& a, const auto& b) { return a.first == b.first; });
  groups_ = std::move(groups);
}

void LiveFlow::apply(shadow::Follower& follower) {
  if (!std::exchange(changed_, false)) return;
  runtime::Resource& resource = follower.replicas().resource();
  for (std::uint32_t task = 0; task < resource.task_count(); ++task) {
    std::vector<runtime::ProbedPou> views;
    bool all_there = true;
    for (const auto& [place, group] : groups_) {
      if (place.first != task) continue;
      views.push_back(place.second);
      all_there = all_there && group.applied;
    }
    const bool looked_at = resource.program(task).probes() != nullptr;
    if (views.empty() ? !looked_at : all_there && looked_at) continue;
    // What a view shows begins anew: those of a task are taken together.
    if (resource.program(task).look_at(views)) continue;
    for (auto& [place, group] : groups_) {
      if (place.first == task) group = {follower.next_scan(task), true};
    }
  }
}

void LiveFlow::collect(shadow::Follower& follower) {
  for (auto& [place, group] : groups_) {
    const std::uint64_t next = follower.next_scan(place.first);
    if (!group.applied || next == std::exchange(group.next, next)) continue;
    ProbeView view(follower.replicas().resource().program(place.first), place.second);
    if (!view.any()) continue;
    for (Viewer* const viewer : viewers_) {
      if (viewer->instance_.task != place.first || viewer->instance_.at.view != place.second) continue;
      for (std::size_t i = 0; i < viewer->keys_.size(); ++i) {
        const auto shown = view.at(viewer->keys_[i]);
        if (!shown) continue;
        Viewer::Bits& bits = viewer->bits_[i];
        bits.ran = bits.ran || shown->ran;
        bits.was_on = bits.was_on || shown->was_on;
        bits.was_off = bits.was_off || shown->was_off;
        bits.was_unknown = bits.was_unknown || shown->was_unknown;
      }
      viewer->fresh_ = true;
    }
    view.clear();
  }
}

std::optional<LiveFlow::Frame> LiveFlow::take(Viewer& viewer) {
  if (!viewer_ || !viewer.looks_) return {};
  std::optional<Frame> frame;
  viewer_->read([&](shadow::Follower& follower) {
    apply(follower);
    collect(follower);
    if (!std::exchange(viewer.fresh_, false)) return;
    const std::uint32_t task = viewer.instance_.task;
    const ProbeView view(follower.replicas().resource().program(task), viewer.instance_.at.view);
    frame.emplace();
    frame->scan = follower.next_scan(task) - 1;
    frame->utc_ns = follower.replicas().replica(task).head().utc_ns;
    for (std::size_t i = 0; i < viewer.keys_.size(); ++i) {
      const Viewer::Bits bits = std::exchange(viewer.bits_[i], {});
      Shown shown = view.at(viewer.keys_[i]).value_or(Shown{});
      shown.ran = bits.ran;
      shown.was_on = bits.was_on;
      shown.was_off = bits.was_off;
      shown.was_unknown = bits.was_unknown;
      frame->shown.push_back(shown);
      frame->texts.push_back(shown.known && !shown.is_bool ? view.text(viewer.keys_[i], runtime::ValueStyle::kNames)
                                                           : std::string());
    }
  });
  return frame;
}

}  // namespace plc::engineering
