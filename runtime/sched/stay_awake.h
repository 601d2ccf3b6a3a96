// StayAwake: no processor falls into a sleep it needs long to wake from, for as long as this lives.
//
// In: /dev/cpu_dma_latency, the kernel's interface for that wish; open and close, on the owner's thread. Out: idle
// processors wait in their lightest state, awake or nearly so: a task's timer finds them at once, and they take more
// power. The wish ends with the process at the latest. Does not belong here: clock frequencies, which are the
// administrator's.
#pragma once

namespace plc::runtime {

class StayAwake {
 public:
  StayAwake() = default;
  ~StayAwake() { release(); }
  StayAwake(const StayAwake&) = delete;
  StayAwake& operator=(const StayAwake&) = delete;

  /// Returns 0, or the errno of what the system refused: ENOENT where the kernel has no such interface.
  [[nodiscard]] int request() noexcept;
  void release() noexcept;

 private:
  int file_ = -1;
};

}  // namespace plc::runtime
