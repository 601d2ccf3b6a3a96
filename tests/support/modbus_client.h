// ModbusClient: a blocking TCP client for tests that lets everything be sent: frames, halves of frames, garbage.
//
// In: bytes. Out: frames received, or why there is none. Does not belong here: a polite client's helpers.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <utility>
#include <vector>

namespace plc::test {

using Pdu = std::vector<std::uint8_t>;

inline void append_word(Pdu& pdu, std::uint32_t value) {
  pdu.push_back(static_cast<std::uint8_t>(value >> 8));
  pdu.push_back(static_cast<std::uint8_t>(value));
}
/// Function code, then 16-bit words.
inline Pdu pdu_of(unsigned function, std::initializer_list<std::uint32_t> words) {
  Pdu pdu{static_cast<std::uint8_t>(function)};
  for (const std::uint32_t word : words) append_word(pdu, word);
  return pdu;
}
/// FC16.
inline Pdu write_registers(std::uint32_t first, const std::vector<std::uint16_t>& values) {
  Pdu pdu = pdu_of(16, {first, static_cast<std::uint32_t>(values.size())});
  pdu.push_back(static_cast<std::uint8_t>(2 * values.size()));
  for (const std::uint16_t value : values) append_word(pdu, value);
  return pdu;
}
/// FC15.
inline Pdu write_coils(std::uint32_t first, std::uint32_t count, const Pdu& bytes) {
  Pdu pdu = pdu_of(15, {first, count});
  pdu.push_back(static_cast<std::uint8_t>(bytes.size()));
  pdu.insert(pdu.end(), bytes.begin(), bytes.end());
  return pdu;
}
/// FC23.
inline Pdu read_write(std::uint32_t read_first, std::uint32_t read_count, std::uint32_t first,
                      const std::vector<std::uint16_t>& values) {
  Pdu pdu = pdu_of(23, {read_first, read_count, first, static_cast<std::uint32_t>(values.size())});
  pdu.push_back(static_cast<std::uint8_t>(2 * values.size()));
  for (const std::uint16_t value : values) append_word(pdu, value);
  return pdu;
}
/// A frame with any header.
inline Pdu frame_of(const Pdu& pdu, std::uint32_t transaction = 1, std::uint8_t unit = 1, std::uint32_t protocol = 0,
                    std::optional<std::uint32_t> length = {}) {
  Pdu frame;
  append_word(frame, transaction);
  append_word(frame, protocol);
  append_word(frame, length.value_or(static_cast<std::uint32_t>(pdu.size() + 1)));
  frame.push_back(unit);
  frame.insert(frame.end(), pdu.begin(), pdu.end());
  return frame;
}

struct Answer {
  enum class Kind : std::uint8_t { kFrame, kClosed, kTimeout };
  Kind kind = Kind::kTimeout;
  std::uint32_t transaction = 0;
  std::uint8_t unit = 0;
  Pdu pdu;
  [[nodiscard]] bool is_closed() const { return kind == Kind::kClosed; }
  [[nodiscard]] bool is_timeout() const { return kind == Kind::kTimeout; }
  /// A normal answer.
  [[nodiscard]] bool is_normal() const { return kind == Kind::kFrame && pdu.size() >= 2 && pdu[0] < 0x80; }
  /// The exception code, or -1.
  [[nodiscard]] int exception() const {
    return kind == Kind::kFrame && pdu.size() == 2 && pdu[0] >= 0x80 ? pdu[1] : -1;
  }
};

class ModbusClient {
 public:
  /// Connects to 127.0.0.1; `from` is the last number of the 127.0.0.x it comes from.
  explicit ModbusClient(std::uint16_t port, std::uint8_t from = 1) {
    fd_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    if (from != 1) {
      address.sin_addr.s_addr = htonl(0x7f000000u | from);
      ::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address);
    }
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    const int on = 1;
    ::setsockopt(fd_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    connected_ = fd_ >= 0 && ::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  ~ModbusClient() { close(); }
  ModbusClient(ModbusClient&& other) noexcept
      : fd_(std::exchange(other.fd_, -1)), connected_(other.connected_), received_(std::move(other.received_)) {}
  ModbusClient(const ModbusClient&) = delete;
  ModbusClient& operator=(const ModbusClient&) = delete;

  [[nodiscard]] bool connected() const { return connected_; }
  [[nodiscard]] int fd() const { return fd_; }

  /// False when the connection is gone.
  bool send(const Pdu& bytes) const {
    std::size_t sent = 0;
    while (sent < bytes.size()) {
      const ssize_t n = ::send(fd_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
      if (n <= 0) return false;
      sent += static_cast<std::size_t>(n);
    }
    return true;
  }
  Answer receive(int timeout_ms = 15'000) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(timeout_ms);
    for (;;) {
      if (received_.size() >= 7) {
        const std::size_t size = 6u + received_[4] * 256u + received_[5];
        if (received_.size() >= size) return take(size);
      }
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
      pollfd readable{fd_, POLLIN, 0};
      if (::poll(&readable, 1, std::max(0, static_cast<int>(left.count()))) <= 0) return {};
      std::uint8_t chunk[4096];
      const ssize_t n = ::recv(fd_, chunk, sizeof chunk, 0);
      if (n <= 0) return {Answer::Kind::kClosed, 0, 0, {}};
      received_.insert(received_.end(), chunk, chunk + n);
    }
  }
  Answer ask(const Pdu& pdu, std::uint32_t transaction = 7, std::uint8_t unit = 1, int timeout_ms = 15'000) {
    if (!send(frame_of(pdu, transaction, unit))) return {Answer::Kind::kClosed, 0, 0, {}};
    return receive(timeout_ms);
  }
  /// No more requests.
  void finish_sending() const { ::shutdown(fd_, SHUT_WR); }
  void close() {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }
  void reset() {
    const linger now{1, 0};
    ::setsockopt(fd_, SOL_SOCKET, SO_LINGER, &now, sizeof now);
    close();
  }

 private:
  Answer take(std::size_t size) {
    Answer answer;
    answer.kind = Answer::Kind::kFrame;
    answer.transaction = received_[0] * 256u + received_[1];
    answer.unit = received_[6];
    answer.pdu.assign(received_.begin() + 7, received_.begin() + static_cast<std::ptrdiff_t>(size));
    received_.erase(received_.begin(), received_.begin() + static_cast<std::ptrdiff_t>(size));
    return answer;
  }
  int fd_ = -1;
  bool connected_ = false;
  Pdu received_;
};

}  // namespace plc::test
