#include "io-drivers/modbus-client/link.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <utility>

#include "core/text.h"
#include "io-drivers/modbus-client/resolver.h"

namespace plc::modbus_client {
namespace {

using core::TimeNs;

/// How late a wait learns of end_by().
constexpr TimeNs kPieceNs = 50'000'000;

template <class T>
bool parse_whole(std::string_view text, T& to) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), to);
  return error == std::errc{} && end == text.data() + text.size();
}

bool is_address(const std::string& text) {
  unsigned char bytes[sizeof(in6_addr)];
  if (text.find('\0') != std::string::npos) return false;
  return ::inet_pton(AF_INET, text.c_str(), bytes) == 1 || ::inet_pton(AF_INET6, text.c_str(), bytes) == 1;
}

/// Letters, digits and hyphens between dots (RFC 1123). Not what was meant as an address, or as a serial line: its last
/// part has a letter, and it begins neither with "tty" nor with "COM" and a digit.
bool is_host_name(std::string_view text) {
  const std::size_t last = text.rfind('.') + 1;
  bool letters = false;
  for (std::size_t i = 0, length = 0; i < text.size(); ++i) {
    const char c = core::fold(text[i]);
    const bool letter = c >= 'a' && c <= 'z';
    if (c == '.' ? length == 0 : !letter && !(c >= '0' && c <= '9') && (c != '-' || length == 0)) return false;
    length = c == '.' ? 0 : length + 1;
    if (length > 63) return false;
    letters = letters || (i >= last && letter);
  }
  const bool line = core::iequals(text.substr(0, 3), "tty") ||
                    (text.size() > 3 && core::iequals(text.substr(0, 3), "com") && text[3] >= '0' && text[3] <= '9');
  return letters && !line && text.size() <= 253 && text.back() != '-';
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
      // In pieces: the end may be asked for meanwhile.
      const TimeNs left = std::clamp<TimeNs>(until(deadline_ns) - clock_.now_ns(), 0, kPieceNs);
      timespec time = {left / 1'000'000'000, left % 1'000'000'000};
      pollfd one = {fd_, events, 0};
      const int ready = ::ppoll(&one, 1, &time, nullptr);
      if (ready > 0) return true;
      if (ready < 0 && errno != EINTR) return false;
      if (ready == 0 && clock_.now_ns() >= until(deadline_ns)) return false;
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
  explicit TcpLink(BusAddress bus) : bus_(std::move(bus)), resolver_(bus_.host, bus_.port) {}

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
    // In pieces, as wait().
    do {
      resolver_.resolve(std::min(until(deadline_ns), clock_.now_ns() + kPieceNs));
    } while (resolver_.waits() && clock_.now_ns() < until(deadline_ns));
    const auto& addresses = resolver_.known();
    if (addresses.empty()) {
      const Error error = fail(Error::kNotConnected);
      reason_ = resolver_.reason();
      return error;
    }
    // Of several addresses each has its turn, until one is good. One that refuses leaves time for the next: a name may
    // be that of ::1, where nobody listens, and of 127.0.0.1.
    Error error = Error::kNotConnected;
    for (std::size_t i = 0; i < addresses.size() && (i == 0 || clock_.now_ns() < until(deadline_ns)); ++i) {
      const SocketAddress& to = addresses[turn_ % addresses.size()];
      error = connect(to, deadline_ns);
      if (error == Error::kNone) return error;
      ++turn_;
      const std::string address = text_of(to);
      if (address != bus_.host) reason_ = address + ": " + reason_;
    }
    return error;
  }
  Error connect(const SocketAddress& to, TimeNs deadline_ns) {
    fd_ = ::socket(to.bytes.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd_ < 0) return fail(Error::kNotConnected, errno);
    const int one = 1;
    ::setsockopt(fd_, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    if (::connect(fd_, reinterpret_cast<const sockaddr*>(&to.bytes), to.size) == 0) return Error::kNone;
    if (errno != EINPROGRESS) return fail(Error::kNotConnected, errno);
    if (!wait(POLLOUT, deadline_ns)) return fail(Error::kNotConnected, ETIMEDOUT);
    int error = 0;
    socklen_t length = sizeof error;
    ::getsockopt(fd_, SOL_SOCKET, SO_ERROR, &error, &length);
    return error == 0 ? Error::kNone : fail(Error::kNotConnected, error);
  }

  BusAddress bus_;
  Resolver resolver_;
  std::size_t turn_ = 0;  ///< which of its addresses is tried
  std::uint16_t transaction_ = 0;
};

class SerialLink final : public StreamLink {
 public:
  explicit SerialLink(BusAddress bus) : bus_(std::move(bus)), silence_(silence_ns(bus_.line)) {}

  Error exchange(std::uint8_t unit, std::span<const std::uint8_t> pdu, TimeNs timeout_ns, Bytes& answer) override {
    reason_.clear();
    if (fd_ < 0) {
      fd_ = modbus_rtu::open_line(bus_.host, bus_.line);
      if (fd_ < 0) return fail(Error::kNotConnected, -fd_);
    }
    // The rest of an answer that did not come in time would meet the next one.
    if (std::exchange(unsettled_, false)) discard(clock_.now_ns() + timeout_ns);
    if (fd_ < 0) return Error::kClosed;
    clock_.sleep_until_ns(last_byte_ns_ + silence_);
    // Noise, and answers that came too late.
    ::tcflush(fd_, TCIFLUSH);
    const Bytes frame = rtu_frame(unit, pdu);
    const TimeNs deadline = clock_.now_ns() + timeout_ns + characters_ns(frame.size());
    if (const Error error = send_all(frame, deadline); error != Error::kNone) return error;
    last_byte_ns_ = clock_.now_ns() + characters_ns(frame.size());
    got_.clear();
    for (;;) {
      if (const Error error = receive(deadline); error != Error::kNone) {
        unsettled_ = !got_.empty();
        return error;
      }
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
  [[nodiscard]] TimeNs characters_ns(std::size_t count) const { return modbus_rtu::characters_ns(bus_.line, count); }
  /// Until the line is quiet: the rest of a frame must not meet the next request.
  void discard(TimeNs deadline_ns) {
    for (;;) {
      got_.clear();
      const TimeNs quiet = clock_.now_ns() + std::max(silence_, modbus_rtu::kLongestPauseNs);
      if (clock_.now_ns() >= until(deadline_ns) || receive(std::min(quiet, deadline_ns)) != Error::kNone) return;
      last_byte_ns_ = clock_.now_ns();
    }
  }
  ssize_t put(std::span<const std::uint8_t> bytes) override { return ::write(fd_, bytes.data(), bytes.size()); }

  BusAddress bus_;
  TimeNs silence_;
  TimeNs last_byte_ns_ = 0;
  bool unsettled_ = false;  ///< the rest of an answer may come
};

}  // namespace

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
  if (!is_address(bus.host) && !is_host_name(bus.host)) return std::nullopt;
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
  const core::MonotonicClock clock;
  const TimeNs begin = clock.now_ns();
  Bytes answer;
  if (const Error error = link.exchange(unit, pdu, timeout_ns, answer); error != Error::kNone) return error;
  link.answered_in(clock.now_ns() - begin);
  return parse_answer(pdu, answer, cells);
}

}  // namespace plc::modbus_client
