// Peers that misbehave: a TCP server and an RTU slave at a pty pair, each with a script of what to answer.
//
// In: what to do with each request. Out: a port, or the path of a line. Threads: one of its own, which ends with it.
// Does not belong here: the client.
#pragma once

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <pty.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <atomic>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>

#include "io-drivers/modbus-client/frame.h"
#include "io-drivers/modbus-rtu/frame.h"
#include "tests/support/serial_line.h"

namespace plc::test {

using modbus_client::Bytes;

/// What a peer does with one request: bytes to send, one piece after the other, and whether it then closes.
struct Reaction {
  std::vector<Bytes> pieces;
  bool close = false, reset = false;
  int pause_ms = 0;  ///< before each piece but the first
};
using Script = std::function<Reaction(const Bytes& request)>;

class Peer {
 public:
  virtual ~Peer() = default;
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;
  [[nodiscard]] int requests() const { return requests_.load(); }
  [[nodiscard]] int connections() const { return connections_.load(); }

 protected:
  Peer() = default;
  void stop() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  bool readable(int fd) const {
    while (!stop_) {
      pollfd one = {fd, POLLIN, 0};
      if (::poll(&one, 1, 5) > 0) return true;
    }
    return false;
  }
  static void put(int fd, const Reaction& reaction, const std::atomic<bool>& stop) {
    for (std::size_t i = 0; i < reaction.pieces.size() && !stop; ++i) {
      if (i != 0) std::this_thread::sleep_for(std::chrono::milliseconds(reaction.pause_ms));
      const Bytes& piece = reaction.pieces[i];
      // MSG_NOSIGNAL has no meaning for a line: EPIPE does not come there.
      if (::send(fd, piece.data(), piece.size(), MSG_NOSIGNAL) < 0 && errno == ENOTSOCK) {
        static_cast<void>(!::write(fd, piece.data(), piece.size()));
      }
    }
  }
  std::atomic<bool> stop_{false};
  std::atomic<int> requests_{0}, connections_{0};
  std::thread thread_;
};

class TcpPeer final : public Peer {
 public:
  explicit TcpPeer(Script script) : script_(std::move(script)) {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in at = {};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof at;
    if (::bind(listener_, reinterpret_cast<sockaddr*>(&at), size) != 0 || ::listen(listener_, 8) != 0) {
      throw std::runtime_error("no port to listen on");
    }
    ::getsockname(listener_, reinterpret_cast<sockaddr*>(&at), &size);
    port_ = ntohs(at.sin_port);
    thread_ = std::thread([this] { run(); });
  }
  ~TcpPeer() override {
    stop();
    ::close(listener_);
  }
  [[nodiscard]] std::uint16_t port() const { return port_; }
  [[nodiscard]] std::string bus() const { return "127.0.0.1:" + std::to_string(port_); }

 private:
  void run() {
    while (readable(listener_)) {
      const int fd = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
      if (fd < 0) continue;
      ++connections_;
      serve(fd);
      ::close(fd);
    }
  }
  void serve(int fd) {
    Bytes got;
    while (readable(fd)) {
      std::uint8_t chunk[512];
      const ssize_t n = ::read(fd, chunk, sizeof chunk);
      if (n <= 0) return;
      got.insert(got.end(), chunk, chunk + n);
      while (got.size() >= 6 && got.size() >= 6u + (got[4] << 8 | got[5])) {
        const Bytes request(got.begin(), got.begin() + 6 + (got[4] << 8 | got[5]));
        got.erase(got.begin(), got.begin() + static_cast<std::ptrdiff_t>(request.size()));
        ++requests_;
        const Reaction reaction = script_(request);
        put(fd, reaction, stop_);
        if (reaction.reset) {
          const linger now = {1, 0};
          ::setsockopt(fd, SOL_SOCKET, SO_LINGER, &now, sizeof now);
        }
        if (reaction.close || reaction.reset) return;
      }
    }
  }

  Script script_;
  int listener_ = -1;
  std::uint16_t port_ = 0;
};

/// The slave's side of a serial line; the client opens path().
class LinePeer final : public Peer {
 public:
  explicit LinePeer(Script script) : script_(std::move(script)) {
    thread_ = std::thread([this] { run(); });
  }
  ~LinePeer() override { stop(); }
  [[nodiscard]] const std::string& path() const { return end_.path(); }
  /// Between the end of an answer and the next request, the shortest, in ns.
  [[nodiscard]] std::int64_t shortest_silence_ns() const { return shortest_.load(); }

 private:
  static std::int64_t now_ns() {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
  }
  void run() {
    Bytes got;
    std::int64_t answered = 0;
    while (readable(end_.fd())) {
      std::uint8_t chunk[512];
      const ssize_t n = ::read(end_.fd(), chunk, sizeof chunk);
      if (n <= 0) continue;
      if (got.empty() && answered != 0) shortest_ = std::min<std::int64_t>(shortest_, now_ns() - answered);
      got.insert(got.end(), chunk, chunk + n);
      const std::size_t size = modbus_rtu::request_size(got);
      if (size == modbus_rtu::kNotKnownYet || got.size() < size) continue;
      const Bytes request = std::exchange(got, {});
      ++requests_;
      answered = now_ns();  // before it is sent: the client cannot see it sooner
      put(end_.fd(), script_(request), stop_);
    }
  }

  Script script_;
  SerialEnd end_;
  std::atomic<std::int64_t> shortest_{INT64_MAX};
};

}  // namespace plc::test
