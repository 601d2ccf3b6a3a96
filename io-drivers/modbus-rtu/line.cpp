#include "io-drivers/modbus-rtu/line.h"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>

#include "core/text.h"

namespace plc::modbus_rtu {
namespace {

using core::TimeNs;

struct Speed {
  std::uint32_t baud;
  speed_t code;
};
constexpr Speed kSpeeds[] = {{1200, B1200},     {2400, B2400},     {4800, B4800},     {9600, B9600},
                             {19200, B19200},   {38400, B38400},   {57600, B57600},   {115200, B115200},
                             {230400, B230400}, {460800, B460800}, {921600, B921600}, {1000000, B1000000}};

const Speed* speed_of(std::uint32_t baud) {
  const auto* found = std::ranges::find(kSpeeds, baud, &Speed::baud);
  return found == std::end(kSpeeds) ? nullptr : found;
}

/// 0, or errno.
int set_up(int fd, const LineSettings& settings) {
  termios line = {};
  if (::tcgetattr(fd, &line) != 0) return errno;
  ::cfmakeraw(&line);
  line.c_cflag |= CLOCAL | CREAD;
  line.c_cflag &= ~static_cast<tcflag_t>(PARENB | PARODD | CSTOPB | CSIZE | CRTSCTS);
  line.c_cflag |= CS8;
  if (settings.parity != Parity::kNone) line.c_cflag |= PARENB;
  if (settings.parity == Parity::kOdd) line.c_cflag |= PARODD;
  if (settings.stop_bits == 2) line.c_cflag |= CSTOPB;
  if (settings.parity != Parity::kNone) line.c_iflag |= INPCK;
  const speed_t speed = speed_of(settings.baud)->code;
  ::cfsetispeed(&line, speed);
  ::cfsetospeed(&line, speed);
  if (::tcsetattr(fd, TCSANOW, &line) != 0) {
    // WHY not always an error: a line that has all but the parity already, and has no parity (a pty), is refused as one
    // where nothing could be changed; the first time it was taken.
    const int error = errno;
    termios now = {};
    const bool as_wanted = error == EINVAL && ::tcgetattr(fd, &now) == 0 && ::cfgetospeed(&now) == speed &&
                           (now.c_cflag & CSIZE) == CS8 && now.c_lflag == line.c_lflag && now.c_oflag == line.c_oflag;
    if (!as_wanted) return error;
  }
  ::ioctl(fd, TIOCEXCL);  // nobody else talks in between
  ::tcflush(fd, TCIOFLUSH);
  return 0;
}

}  // namespace

std::optional<LineSettings> parse_line(std::string_view text) {
  const std::size_t blank = text.find(' ');
  if (blank == std::string_view::npos) return std::nullopt;
  LineSettings line;
  const auto [end, error] = std::from_chars(text.data(), text.data() + blank, line.baud);
  if (error != std::errc{} || end != text.data() + blank || speed_of(line.baud) == nullptr) return std::nullopt;
  const std::string_view form = core::trimmed(text.substr(blank));
  if (form.size() != 3 || form[0] != '8' || (form[2] != '1' && form[2] != '2')) return std::nullopt;
  constexpr std::string_view kParities = "neo";
  const std::size_t parity = kParities.find(core::fold(form[1]));
  if (parity == std::string_view::npos) return std::nullopt;
  line.parity = static_cast<Parity>(parity);
  line.stop_bits = static_cast<std::uint8_t>(form[2] - '0');
  return line;
}

TimeNs silence_ns(const LineSettings& line) {
  if (line.baud > 19200) return 1'750'000;
  return TimeNs{77} * 1'000'000'000 / 2 / line.baud;  // 3.5 characters of 11 bits
}

TimeNs characters_ns(const LineSettings& line, std::size_t count) {
  return static_cast<TimeNs>(count) * 11 * 1'000'000'000 / line.baud;
}

int open_line(const std::string& path, const LineSettings& line) {
  const int fd = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return -errno;
  const int error = set_up(fd, line);
  if (error == 0) return fd;
  ::close(fd);
  return -error;
}

}  // namespace plc::modbus_rtu
