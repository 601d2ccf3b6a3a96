// LoginDelay: how long somebody must wait before the next attempt to log in.
//
// In: attempts, by user and address. Out: a time to wait. Three counts, each with its delay, which doubles with every
// failure: of the user from the address, which grows to minutes; of the address, and of the user from anywhere, which
// grow to one second, so that others cannot lock a user out. An address from which a user came in once does not wait
// for what others do with the user's name. Attempts count as failures until they have succeeded: many at once are no
// way round. Threads: any. Does not belong here: passwords.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <unordered_map>
#include <unordered_set>

#include "core/clock.h"

namespace plc::engineering {

class LoginDelay {
 public:
  static constexpr core::TimeNs kLongestNs = 300'000'000'000;      ///< of a user from an address
  static constexpr core::TimeNs kLongestOthersNs = 1'000'000'000;  ///< of an address; of a user
  static constexpr core::TimeNs kForgottenNs = 3'600'000'000'000;  ///< after the last failure
  static constexpr std::size_t kMost = 20'000;                     ///< counts that are kept

  /// 0: the attempt may be made, and counts as a failure until succeeded(). Else the time to wait.
  core::TimeNs attempt(const std::string& user, const std::string& address, core::TimeNs now_ns);
  void succeeded(const std::string& user, const std::string& address);
  /// The attempt was none: nobody looked at the password.
  void withdrawn(const std::string& user, const std::string& address);

 private:
  struct Count {
    std::uint32_t failures = 0;
    core::TimeNs last_ns = 0;
  };
  struct Limit {
    std::uint32_t free;  ///< failures without a delay
    core::TimeNs first_ns;
    core::TimeNs longest_ns;
  };
  static core::TimeNs wait_ns(const Count& count, const Limit& limit, core::TimeNs now_ns);
  void forget(core::TimeNs now_ns);

  std::mutex mutex_;
  std::unordered_map<std::string, Count> counts_;
  std::unordered_set<std::string> known_;  ///< user and address that have come in
};

}  // namespace plc::engineering
