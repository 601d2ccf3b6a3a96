#include "engineering/login_delay.h"

#include <algorithm>
#include <array>

#include "core/text.h"

namespace plc::engineering {
namespace {

struct Keys {
  std::string pair, address, user;
  Keys(const std::string& user_name, const std::string& from)
      : pair("p" + core::folded(user_name) + "\n" + from), address("a" + from), user("u" + core::folded(user_name)) {}
};

}  // namespace

core::TimeNs LoginDelay::wait_ns(const Count& count, const Limit& limit, core::TimeNs now_ns) {
  if (count.failures < limit.free || now_ns - count.last_ns >= kForgottenNs) return 0;
  core::TimeNs delay = limit.first_ns;
  for (std::uint32_t i = limit.free; i < count.failures && delay < limit.longest_ns; ++i) delay *= 2;
  return std::max<core::TimeNs>(0, count.last_ns + std::min(delay, limit.longest_ns) - now_ns);
}

void LoginDelay::forget(core::TimeNs now_ns) {
  if (counts_.size() < kMost) return;
  std::erase_if(counts_, [now_ns](const auto& entry) { return now_ns - entry.second.last_ns >= kForgottenNs; });
  // A flood of names: what hinders the flood itself, its address, is the last to go.
  if (counts_.size() >= kMost) std::erase_if(counts_, [](const auto& entry) { return entry.first.front() != 'a'; });
  if (counts_.size() >= kMost) counts_.clear();
}

core::TimeNs LoginDelay::attempt(const std::string& user, const std::string& address, core::TimeNs now_ns) {
  static constexpr Limit kPair = {3, 1'000'000'000, kLongestNs};
  static constexpr Limit kOthers = {20, 125'000'000, kLongestOthersNs};
  const Keys keys(user, address);
  const std::lock_guard lock(mutex_);
  forget(now_ns);
  const bool known = known_.contains(keys.pair);
  const std::array<std::pair<const std::string*, const Limit*>, 3> looked_at = {
      {{&keys.pair, &kPair}, {&keys.address, &kOthers}, {&keys.user, &kOthers}}};
  core::TimeNs wait = 0;
  for (const auto& [key, limit] : looked_at) {
    if (known && key == &keys.user) continue;
    const auto count = counts_.find(*key);
    if (count != counts_.end()) wait = std::max(wait, wait_ns(count->second, *limit, now_ns));
  }
  if (wait != 0) return wait;
  for (const auto& [key, limit] : looked_at) {
    Count& count = counts_[*key];
    if (now_ns - count.last_ns >= kForgottenNs) count.failures = 0;
    count.failures = std::min(count.failures + 1, 64u);
    count.last_ns = now_ns;
  }
  return 0;
}

void LoginDelay::succeeded(const std::string& user, const std::string& address) {
  const Keys keys(user, address);
  const std::lock_guard lock(mutex_);
  for (const std::string* key : {&keys.pair, &keys.address, &keys.user}) counts_.erase(*key);
  if (known_.size() >= kMost) known_.clear();
  known_.insert(keys.pair);
}

void LoginDelay::withdrawn(const std::string& user, const std::string& address) {
  const Keys keys(user, address);
  const std::lock_guard lock(mutex_);
  for (const std::string* key : {&keys.pair, &keys.address, &keys.user}) {
    const auto count = counts_.find(*key);
    if (count != counts_.end() && count->second.failures != 0) --count->second.failures;
  }
}

}  // namespace plc::engineering
