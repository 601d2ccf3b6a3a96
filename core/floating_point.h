// The mode that REAL and LREAL are computed in: rounding to nearest, subnormal numbers as they are, no traps (IEC
// 61131-3, 6.4.2: IEC 60559). A thread inherits it from the one that made it, and a library that was linked with
// -ffast-math sets another one when it is loaded.
//
// Does not belong here: what operations give (stdlib/).
#pragma once

#include <cfenv>

namespace plc::core {

/// Sets the mode for the calling thread, whoever made it. RT: no system call.
inline void set_floating_point_mode() noexcept { static_cast<void>(std::fesetenv(FE_DFL_ENV)); }

/// The calling thread has the same mode after this as before, whatever is done in between.
class KeptFloatingPointMode {
 public:
  KeptFloatingPointMode() noexcept { static_cast<void>(std::fegetenv(&mode_)); }
  ~KeptFloatingPointMode() { static_cast<void>(std::fesetenv(&mode_)); }
  KeptFloatingPointMode(const KeptFloatingPointMode&) = delete;
  KeptFloatingPointMode& operator=(const KeptFloatingPointMode&) = delete;

 private:
  std::fenv_t mode_{};
};

}  // namespace plc::core
