#include "io-drivers/modbus-client/link.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>

#include "core/text.h"

namespace plc::modbus_client {
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

template <class T>
bool parse_whole(std::string_view text, T& to) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), to);
  return error == std::errc{} && end == text.data() + text.size();
}

/// A socket or a line with one request at a time.
class StreamLink : public Link {
 public:
  ~StreamLink() override { shut(); }
  StreamLink() = default;
  StreamLink(const StreamLink&) = delete;
  StreamLink& operator=(const StreamLink&) = delete;
  [[nodiscard]] std::string_view reason() const override { return reason_; }

 protected:
  static constexpr std::size_t kMaxFrame = 512;  ///< more than any frame, so that one too long is seen

  void shut() {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }
  Error fail(Error error, int code = 0) {
    reason_ = code == 0 ? "" : std::strerror(code);
    shut();
    return error;
  }
  /// Whether the events came in time. Not interrupted by signals for longer than the deadline.
  bool wait(short events, TimeNs deadline_ns) {
    for (;;) {
      const TimeNs left = std::max<TimeNs>(deadline_ns - clock_.now_ns(), 0);
      timespec time = {left / 1'000'000'000, left % 1'000'000'000};
      pollfd one = {fd_, events, 0};
      const int ready = ::ppoll(&one, 1, &time, nullptr);
      if (ready > 0) return true;
      if (ready == 0 || errno != EINTR) return false;
    }
  }
  Error send_all(std::span<const std::uint8_t> bytes, TimeNs deadline_ns) {
    while (!bytes.empty()) {
      const ssize_t sent = put(bytes);
      if (sent > 0) {
        bytes = bytes.subspan(static_cast<std::size_t>(sent));
      } else if (sent < 0 && errno != EAGAIN && errno != EINTR) {
        return fail(Error::kClosed, errno);
      } else if (!wait(POLLOUT, deadline_ns)) {
        return fail(Error::kNoAnswer);
      }
    }
    return Error::kNone;
  }
  /// More bytes into got_.
  Error receive(TimeNs deadline_ns) {
    for (;;) {
      if (!wait(POLLIN, deadline_ns)) return Error::kNoAnswer;
      std::array<std::uint8_t, kMaxFrame> chunk;
      const ssize_t got = ::read(fd_, chunk.data(), chunk.size() - got_.size());
      if (got > 0) {
        got_.insert(got_.end(), chunk.begin(), chunk.begin() + got);
        return Error::kNone;
      }
      if (got == 0) return fail(Error::kClosed);
      if (errno != EAGAIN && errno != EINTR) return fail(Error::kClosed, errno);
    }
  }
  virtual ssize_t put(std::span<const std::uint8_t> bytes) = 0;

  int fd_ = -1;
  core::MonotonicClock clock_;
  Bytes got_;
  std::string reason_;
};

class TcpLink final : public StreamLink {
 public:
  explicit TcpLink(BusAddress bus) : bus_(std::move(bus)) {}

  Error exchange(std::uint8_t unit, std::span<const std::uint8_t> pdu, TimeNs timeout_ns, Bytes& answer) override {
    reason_.clear();
    // The peer may have closed an idle connection, or sent what nobody asked for.
    if (fd_ >= 0 && wait(POLLIN, 0)) shut();
    const bool reused = fd_ >= 0;
    Error error = attempt(unit, pdu, timeout_ns, answer);
    // Or it closes just now: a connection that is made anew shows whether it means the request.
    if (error == Error::kClosed && reused && got_.empty()) error = attempt(unit, pdu, timeout_ns, answer);
    return error;
  }

 private:
  Error attempt(std::uint8_t unit, std::span<const std::uint8_t> pdu, TimeNs timeout_ns, Bytes& answer) {
    got_.clear();
    if (fd_ < 0) {
      if (const Error error = connect(clock_.now_ns() + timeout_ns); error != Error::kNone) return error;
    }
    const TimeNs deadline = clock_.now_ns() + timeout_ns;
    ++transaction_;
    const Bytes frame = tcp_frame(transaction_, unit, pdu);
    if (const Error error = send_all(frame, deadline); error != Error::kNone) return error;
    for (;;) {
      if (const Error error = receive(deadline); error != Error::kNone) return fail_as(error);
      std::span<const std::uint8_t> found;
      const Progress progress = parse_tcp(got_, transaction_, unit, found);
      if (progress == Progress::kWrong) return fail(Error::kWrongAnswer);
      if (progress == Progress::kMore) continue;
      answer.assign(found.begin(), found.end());
      return Error::kNone;
    }
  }
  Error fail_as(Error error) {
    if (error == Error::kNoAnswer) fail(error);
    return error;
  }
  ssize_t put(std::span<const std::uint8_t> bytes) override {
    return ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }
  Error connect(TimeNs deadline_ns) {
    sockaddr_storage to = {};
    socklen_t size = 0;
    auto* four = reinterpret_cast<sockaddr_in*>(&to);
    auto* six = reinterpret_cast<sockaddr_in6*>(&to);
    if (::inet_pton(AF_INET, bus_.host.c_str(), &four->sin_addr) == 1) {
      four->sin_family = AF_INET;
      four->sin_port = htons(bus_.port);
      size = sizeof *four;
    } else if (::inet_pton(AF_INET6, bus_.host.c_str(), &six->sin6_addr) == 1) {
      six->sin6_family = AF_INET6;
      six->sin6_port = htons(bus_.port);
      size = sizeof *six;
    } else {
      return fail(Error::kNotConnected, EINVAL);
    }
    fd_ = ::socket(to.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd_ < 0) return fail(Error::kNotConnected, errno);
    const int one = 1;
    ::setsockopt(fd_, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    if (::connect(fd_, reinterpret_cast<const sockaddr*>(&to), size) == 0) return Error::kNone;
    if (errno != EINPROGRESS) return fail(Error::kNotConnected, errno);
    if (!wait(POLLOUT, deadline_ns)) return fail(Error::kNotConnected, ETIMEDOUT);
    int error = 0;
    socklen_t length = sizeof error;
    ::getsockopt(fd_, SOL_SOCKET, SO_ERROR, &error, &length);
    return error == 0 ? Error::kNone : fail(Error::kNotConnected, error);
  }

  BusAddress bus_;
  std::uint16_t transaction_ = 0;
};

class SerialLink final : public StreamLink {
 public:
  explicit SerialLink(BusAddress bus) : bus_(std::move(bus)), silence_(silence_ns(bus_.line)) {}

  Error exchange(std::uint8_t unit, std::span<const std::uint8_t> pdu, TimeNs timeout_ns, Bytes& answer) override {
    reason_.clear();
    if (fd_ < 0) {
      if (const int error = open(); error != 0) return fail(Error::kNotConnected, error);
    }
    clock_.sleep_until_ns(last_byte_ns_ + silence_);
    // Noise, and answers that came too late.
    ::tcflush(fd_, TCIFLUSH);
    const Bytes frame = rtu_frame(unit, pdu);
    const TimeNs deadline = clock_.now_ns() + timeout_ns + characters_ns(frame.size());
    if (const Error error = send_all(frame, deadline); error != Error::kNone) return error;
    last_byte_ns_ = clock_.now_ns() + characters_ns(frame.size());
    got_.clear();
    for (;;) {
      if (const Error error = receive(deadline); error != Error::kNone) return error;
      last_byte_ns_ = clock_.now_ns();
      std::span<const std::uint8_t> found;
      const Progress progress = parse_rtu(got_, unit, pdu, found);
      if (progress == Progress::kComplete) {
        answer.assign(found.begin(), found.end());
        return Error::kNone;
      }
      if (progress == Progress::kWrong) {
        discard(deadline);
        return Error::kWrongAnswer;
      }
    }
  }

 private:
  /// A USB adapter hands on what came every 16 ms.
  static constexpr TimeNs kQuietNs = 20'000'000;

  [[nodiscard]] TimeNs characters_ns(std::size_t count) const {
    return static_cast<TimeNs>(count) * 11 * 1'000'000'000 / bus_.line.baud;
  }
  /// Until the line is quiet: the rest of a frame must not meet the next request.
  void discard(TimeNs deadline_ns) {
    for (;;) {
      got_.clear();
      const TimeNs quiet = clock_.now_ns() + std::max(silence_, kQuietNs);
      if (clock_.now_ns() >= deadline_ns || receive(std::min(quiet, deadline_ns)) != Error::kNone) return;
      last_byte_ns_ = clock_.now_ns();
    }
  }
  ssize_t put(std::span<const std::uint8_t> bytes) override { return ::write(fd_, bytes.data(), bytes.size()); }
  /// errno, or 0.
  int open() {
    fd_ = ::open(bus_.host.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (fd_ < 0) return errno;
    termios line = {};
    if (::tcgetattr(fd_, &line) != 0) return errno;
    ::cfmakeraw(&line);
    line.c_cflag |= CLOCAL | CREAD;
    line.c_cflag &= ~static_cast<tcflag_t>(PARENB | PARODD | CSTOPB | CSIZE | CRTSCTS);
    line.c_cflag |= CS8;
    if (bus_.line.parity != Parity::kNone) line.c_cflag |= PARENB;
    if (bus_.line.parity == Parity::kOdd) line.c_cflag |= PARODD;
    if (bus_.line.stop_bits == 2) line.c_cflag |= CSTOPB;
    if (bus_.line.parity != Parity::kNone) line.c_iflag |= INPCK;
    const speed_t speed = speed_of(bus_.line.baud)->code;
    ::cfsetispeed(&line, speed);
    ::cfsetospeed(&line, speed);
    if (::tcsetattr(fd_, TCSANOW, &line) != 0) return errno;
    ::ioctl(fd_, TIOCEXCL);  // nobody else talks in between
    return 0;
  }

  BusAddress bus_;
  TimeNs silence_;
  TimeNs last_byte_ns_ = 0;
};

}  // namespace

std::optional<LineSettings> parse_line(std::string_view text) {
  const std::size_t blank = text.find(' ');
  if (blank == std::string_view::npos) return std::nullopt;
  LineSettings line;
  const std::string_view form = core::trimmed(text.substr(blank));
  if (!parse_whole(text.substr(0, blank), line.baud) || speed_of(line.baud) == nullptr) return std::nullopt;
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

std::optional<BusAddress> parse_bus(std::string_view text) {
  BusAddress bus;
  text = core::trimmed(text);
  if (text.starts_with('/')) {
    bus.serial = true;
    bus.host = text;
    return bus;
  }
  std::string_view port;
  if (text.starts_with('[')) {
    const std::size_t end = text.find(']');
    if (end == std::string_view::npos) return std::nullopt;
    port = text.substr(end + 1);
    text = text.substr(1, end - 1);
  } else if (std::ranges::count(text, ':') == 1) {
    port = text.substr(text.find(':'));
    text = text.substr(0, text.find(':'));
  }
  if (!port.empty() && (port[0] != ':' || !parse_whole(port.substr(1), bus.port) || bus.port == 0)) return std::nullopt;
  bus.host = text;
  unsigned char bytes[sizeof(in6_addr)];
  if (bus.host.find('\0') != std::string::npos) return std::nullopt;
  const bool four = ::inet_pton(AF_INET, bus.host.c_str(), bytes) == 1;
  if (!four && ::inet_pton(AF_INET6, bus.host.c_str(), bytes) != 1) return std::nullopt;
  return bus;
}

std::string bus_name(const BusAddress& bus) {
  if (bus.serial) return bus.host;
  const bool six = bus.host.find(':') != std::string::npos;
  return (six ? "[" + bus.host + "]" : bus.host) + ":" + std::to_string(bus.port);
}

std::unique_ptr<Link> make_link(const BusAddress& bus) {
  if (bus.serial) return std::make_unique<SerialLink>(bus);
  return std::make_unique<TcpLink>(bus);
}

Error ask(Link& link, std::uint8_t unit, std::span<const std::uint8_t> pdu, TimeNs timeout_ns, Cells& cells) {
  Bytes answer;
  if (const Error error = link.exchange(unit, pdu, timeout_ns, answer); error != Error::kNone) return error;
  return parse_answer(pdu, answer, cells);
}

}  // namespace plc::modbus_client
