// Sessions: who is logged in, under secrets that only the server and one client know.
//
// In: logins. Out: the session of a secret. In memory: the end of plc-run ends
// all, a start of another program by a call (handover.h) none. A session ends after kIdleNs without a call,
// and after kLongestNs in any case. Threads: any. Does not belong here: passwords, cookies.
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/clock.h"
#include "engineering/call.h"

namespace plc::engineering {

struct Session {
  std::uint64_t number = 0;  ///< what others call it
  std::string user;
  Right role = Right::kViewer;
  std::string address;  ///< of who logged in
  core::TimeNs begin_ns = 0;
  core::TimeNs last_ns = 0;  ///< latest call
};

class Sessions {
 public:
  static constexpr core::TimeNs kIdleNs = 30 * 60'000'000'000;
  static constexpr core::TimeNs kLongestNs = 12 * 3'600'000'000'000;
  static constexpr std::size_t kMost = 1000;
  static constexpr std::size_t kMostOfUser = 32;

  /// The secret of a new session. Where there are too many the one unused for longest ends, first of this user.
  std::string begin(const std::string& user, Right role, const std::string& address, core::TimeNs now_ns);
  /// The session, which counts as used now.
  std::optional<Session> use(std::string_view secret, core::TimeNs now_ns);
  /// Whether the session of this number goes on; it counts as used now.
  bool keep(std::uint64_t number, core::TimeNs now_ns);
  void end(std::string_view secret);
  /// False when there is none.
  bool end_number(std::uint64_t number);
  void end_all_of(std::string_view user);
  /// Whom to tell, on the thread of the call and before it returns, that a session has begun or was ended by a call:
  /// one call after the other, so that what the last of them reads of the sessions is what has become of them. It must
  /// begin and end none. Before other threads use this.
  void on_change(std::function<void()> changed) { changed_ = std::move(changed); }
  /// Ends those of which `stays` says false.
  void keep_if(const std::function<bool(const Session&)>& stays);
  [[nodiscard]] std::vector<Session> all(core::TimeNs now_ns) const;
  /// Each with the hash of its secret, for the process that follows.
  [[nodiscard]] std::vector<std::pair<std::string, Session>> kept() const;
  void take_over(std::string hash, Session session);

 private:
  static bool is_over(const Session& session, core::TimeNs now_ns) {
    return now_ns - session.last_ns >= kIdleNs || now_ns - session.begin_ns >= kLongestNs;
  }
  void make_room(const std::string& user, core::TimeNs now_ns);
  /// Whether there was one.
  template <class Ends>
  bool end_if(Ends ends);
  void tell() {
    if (!changed_) return;
    const std::lock_guard lock(telling_);
    changed_();
  }

  std::mutex telling_;        ///< of calls of changed_; before mutex_
  mutable std::mutex mutex_;  ///< of what follows, but for changed_
  std::uint64_t last_number_ = 0;
  std::unordered_map<std::string, Session> by_hash_;
  std::function<void()> changed_;
};

}  // namespace plc::engineering
