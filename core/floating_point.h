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

/// Whether the calling thread has that mode. RT: what a processor says in a few nanoseconds.
inline bool has_floating_point_mode() noexcept {
#if defined(__x86_64__)
  constexpr unsigned kFlags = 0x3f, kAsAtStart = 0x1f80;
  return (__builtin_ia32_stmxcsr() & ~kFlags) == kAsAtStart;
#elif defined(__aarch64__)
  return __builtin_aarch64_get_fpcr() == 0;
#else
  return std::fegetround() == FE_TONEAREST;
#endif
}

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
