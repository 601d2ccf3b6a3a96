// An I2C bus with an ADS1115, in place of the kernel's: preloaded into plc-run, it answers ioctl() of one device file.
#include "tests/drivers/i2c_bus.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <linux/i2c-dev.h>
#include <linux/i2c.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstddef>
#include <cstdlib>
#include <cstring>

namespace {

using plc::test::I2cBus;

constexpr int kAddress = 0x49;
std::atomic<int> bus_fd{-1};

bool answer(I2cBus& bus, const i2c_msg* messages, std::uint32_t count) {
  if (bus.there == 0 || count == 0 || messages[0].addr != kAddress || (messages[0].flags & I2C_M_RD) != 0) return false;
  ++bus.transfers;
  std::uint16_t* const registers[] = {&bus.conversion, &bus.config};
  const unsigned pointer = messages[0].buf[0];
  if (pointer > 1) return false;
  if (messages[0].len == 3) {
    const auto value = static_cast<std::uint16_t>(messages[0].buf[1] << 8 | messages[0].buf[2]);
    *registers[pointer] = value;
    // OS starts a conversion, which is over at once; MUX 4 to 7 is an input against ground; PGA 1 is 4.096 V.
    if (pointer == 1 && (value & 0x8000) != 0 && (value >> 14 & 1) == 1 && (value >> 9 & 7) == 1)
      bus.conversion = static_cast<std::uint16_t>(bus.volts[value >> 12 & 3]);
  }
  if (count == 2) {
    if ((messages[1].flags & I2C_M_RD) == 0 || messages[1].len != 2) return false;
    messages[1].buf[0] = static_cast<std::uint8_t>(*registers[pointer] >> 8);
    messages[1].buf[1] = static_cast<std::uint8_t>(*registers[pointer]);
  }
  return true;
}

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" int open(const char* path, int flags, ...) {
  std::va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(more, mode_t) : 0;
  va_end(more);
  static const auto real = next<int (*)(const char*, int, ...)>("open");
  if (std::strcmp(path, plc::test::kBusDevice) != 0) return real(path, flags, mode);
  const char* const file = std::getenv(plc::test::kBusVariable);
  if (file == nullptr) return errno = ENOENT, -1;
  const int fd = real(file, O_RDWR | O_CLOEXEC);
  bus_fd = fd;
  return fd;
}

extern "C" int ioctl(int fd, unsigned long request, ...) {
  std::va_list more;
  va_start(more, request);
  void* const argument = va_arg(more, void*);
  va_end(more);
  static const auto real = next<int (*)(int, unsigned long, ...)>("ioctl");
  if (fd != bus_fd || request != I2C_RDWR) return real(fd, request, argument);
  I2cBus bus;
  if (::pread(fd, &bus, sizeof bus, 0) != sizeof bus) return errno = EIO, -1;
  const auto* const data = static_cast<const i2c_rdwr_ioctl_data*>(argument);
  const bool good = answer(bus, data->msgs, data->nmsgs);
  // What the chip has changed; the rest is the test's.
  if (good) {
    static_assert(offsetof(I2cBus, config) + 8 == sizeof(I2cBus));
    constexpr std::size_t kChanged = offsetof(I2cBus, config);
    if (::pwrite(fd, &bus.config, sizeof bus - kChanged, kChanged) != sizeof bus - kChanged) return errno = EIO, -1;
  }
  return good ? static_cast<int>(data->nmsgs) : (errno = ENXIO, -1);
}
