// PastViews: recordings that viewers look into, made from what is in memory when they stop the time. A few at once, on
// a thread of their own; who comes within two seconds shares one.
//
// In: a shadow. Out: pasts by number. Threads: calls of Thread::kPast. Does not belong here: rows, drawings.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/clock.h"
#include "core/result.h"
#include "shadow/past.h"
#include "shadow/shadow.h"

namespace plc::engineering {

class PastViews {
 public:
  static constexpr std::size_t kMost = 3;
  static constexpr core::TimeNs kShareNs = 2'000'000'000;
  static constexpr core::TimeNs kForgetNs = 300'000'000'000;

  struct View {
    std::uint64_t number = 0;
    core::TimeNs opened_ns = 0, used_ns = 0;
    std::unique_ptr<shadow::Past> past;
  };
  /// As Past::open(). The one that was unused for longest gives way.
  core::Result<View*> open(const shadow::Shadow& shadow, core::TimeNs now_ns);
  /// Null when it is no more.
  View* find(std::uint64_t number, core::TimeNs now_ns);
  /// Lets go of those that nobody has used for five minutes.
  void rest(core::TimeNs now_ns);

 private:
  std::vector<View> views_;
  std::uint64_t last_ = 0;
};

}  // namespace plc::engineering
