#include "engineering/sessions.h"

#include <algorithm>
#include <utility>

#include "core/text.h"
#include "engineering/secrets.h"

namespace plc::engineering {

void Sessions::make_room(const std::string& user, core::TimeNs now_ns) {
  std::erase_if(by_hash_, [now_ns](const auto& entry) { return is_over(entry.second, now_ns); });
  const auto end_oldest = [this](const std::string* of) {
    auto oldest = by_hash_.end();
    for (auto it = by_hash_.begin(); it != by_hash_.end(); ++it) {
      if (of != nullptr && it->second.user != *of) continue;
      if (oldest == by_hash_.end() || it->second.last_ns < oldest->second.last_ns) oldest = it;
    }
    if (oldest != by_hash_.end()) by_hash_.erase(oldest);
  };
  const auto of_user =
      std::count_if(by_hash_.begin(), by_hash_.end(), [&user](const auto& entry) { return entry.second.user == user; });
  if (static_cast<std::size_t>(of_user) >= kMostOfUser) end_oldest(&user);
  if (by_hash_.size() >= kMost) end_oldest(nullptr);
}

std::string Sessions::begin(const std::string& user, Right role, const std::string& address, core::TimeNs now_ns) {
  std::string secret = random_secret();
  {
    const std::lock_guard lock(mutex_);
    make_room(user, now_ns);
    by_hash_.emplace(hash_of_secret(secret), Session{++last_number_, user, role, address, now_ns, now_ns});
  }
  tell();
  return secret;
}

std::optional<Session> Sessions::use(std::string_view secret, core::TimeNs now_ns) {
  const std::string hash = hash_of_secret(secret);
  const std::lock_guard lock(mutex_);
  const auto found = by_hash_.find(hash);
  if (found == by_hash_.end()) return std::nullopt;
  if (is_over(found->second, now_ns)) {
    by_hash_.erase(found);
    return std::nullopt;
  }
  found->second.last_ns = now_ns;
  return found->second;
}

bool Sessions::keep(std::uint64_t number, core::TimeNs now_ns) {
  const std::lock_guard lock(mutex_);
  for (auto& [hash, session] : by_hash_) {
    if (session.number != number || is_over(session, now_ns)) continue;
    session.last_ns = now_ns;
    return true;
  }
  return false;
}

template <class Ends>
bool Sessions::end_if(Ends ends) {
  {
    const std::lock_guard lock(mutex_);
    if (std::erase_if(by_hash_, ends) == 0) return false;
  }
  tell();
  return true;
}

void Sessions::end(std::string_view secret) {
  end_if([hash = hash_of_secret(secret)](const auto& entry) { return entry.first == hash; });
}

bool Sessions::end_number(std::uint64_t number) {
  return end_if([number](const auto& entry) { return entry.second.number == number; });
}

void Sessions::end_all_of(std::string_view user) {
  end_if([user](const auto& entry) { return core::iequals(entry.second.user, user); });
}

void Sessions::keep_if(const std::function<bool(const Session&)>& stays) {
  end_if([&stays](const auto& entry) { return !stays(entry.second); });
}

std::vector<std::pair<std::string, Session>> Sessions::kept() const {
  const std::lock_guard lock(mutex_);
  return {by_hash_.begin(), by_hash_.end()};
}

void Sessions::take_over(std::string hash, Session session) {
  const std::lock_guard lock(mutex_);
  last_number_ = std::max(last_number_, session.number);
  by_hash_.emplace(std::move(hash), std::move(session));
}

std::vector<Session> Sessions::all(core::TimeNs now_ns) const {
  std::vector<Session> sessions;
  const std::lock_guard lock(mutex_);
  for (const auto& [hash, session] : by_hash_) {
    if (!is_over(session, now_ns)) sessions.push_back(session);
  }
  std::sort(sessions.begin(), sessions.end(), [](const auto& a, const auto& b) { return a.number < b.number; });
  return sessions;
}

}  // namespace plc::engineering
