#include "engineering/past_views.h"

#include <algorithm>
#include <utility>

namespace plc::engineering {

core::Result<PastViews::View*> PastViews::open(const shadow::Shadow& shadow, core::TimeNs now_ns) {
  rest(now_ns);
  if (!views_.empty() && now_ns - views_.back().opened_ns < kShareNs) {
    views_.back().used_ns = now_ns;
    return &views_.back();
  }
  auto past = shadow::Past::open(shadow.recording(), shadow.prepare());
  if (!past) return past.error();
  if (views_.size() >= kMost) {
    views_.erase(std::min_element(views_.begin(), views_.end(),
                                  [](const View& a, const View& b) { return a.used_ns < b.used_ns; }));
  }
  views_.push_back({++last_, now_ns, now_ns, std::move(*past)});
  return &views_.back();
}

PastViews::View* PastViews::find(std::uint64_t number, core::TimeNs now_ns) {
  const auto found =
      std::find_if(views_.begin(), views_.end(), [number](const View& view) { return view.number == number; });
  if (found == views_.end()) return nullptr;
  found->used_ns = now_ns;
  return &*found;
}

void PastViews::rest(core::TimeNs now_ns) {
  std::erase_if(views_, [now_ns](const View& view) { return now_ns - view.used_ns > kForgetNs; });
}

}  // namespace plc::engineering
