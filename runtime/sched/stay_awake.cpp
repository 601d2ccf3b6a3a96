#include "runtime/sched/stay_awake.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>

namespace plc::runtime {

int StayAwake::request() noexcept {
  if (file_ >= 0) return 0;
  const int file = ::open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC);
  if (file < 0) return errno;
  // The wish holds while the file is open; in binary, so that no kernel reads it as text.
  const std::int32_t longest_us = 0;
  if (::write(file, &longest_us, sizeof longest_us) != sizeof longest_us) {
    const int error = errno;
    ::close(file);
    return error;
  }
  file_ = file;
  return 0;
}

void StayAwake::release() noexcept {
  if (file_ >= 0) ::close(file_);
  file_ = -1;
}

}  // namespace plc::runtime
