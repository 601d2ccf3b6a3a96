// HttpClient: a client of the engineering server that tests can make do anything: half requests, wrong frames, silence.
//
// Blocking, with time-outs. Does not belong here: what servers should answer.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

namespace plc::test {

struct HttpAnswer {
  int status = 0;  ///< 0: the connection ended without an answer
  std::string head, body;
};

/// A frame of a WebSocket.
struct WebFrame {
  int opcode = -1;  ///< 1 text, 2 binary, 8 close; -1: the connection ended
  std::string bytes;
};

class HttpClient {
 public:
  explicit HttpClient(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = ::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0;
  }
  ~HttpClient() { close(); }
  HttpClient(HttpClient&& other) noexcept
      : socket_(std::exchange(other.socket_, -1)), connected_(other.connected_), got_(std::move(other.got_)) {}
  HttpClient(const HttpClient&) = delete;
  HttpClient& operator=(const HttpClient&) = delete;

  [[nodiscard]] bool connected() const { return connected_; }
  [[nodiscard]] int descriptor() const { return socket_; }
  void close() {
    if (socket_ >= 0) ::close(std::exchange(socket_, -1));
  }
  bool send(std::string_view bytes) const {
    while (!bytes.empty()) {
      const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    }
    return true;
  }
  /// The next answer of HTTP.
  HttpAnswer receive(int timeout_ms = 5000) {
    HttpAnswer answer;
    std::size_t end = 0;
    while ((end = got_.find("\r\n\r\n")) == std::string::npos) {
      if (!more(timeout_ms)) return answer;
    }
    answer.head = got_.substr(0, end + 2);
    std::size_t length = 0;
    const std::size_t at = answer.head.find("Content-Length: ");
    if (at != std::string::npos) length = std::stoul(answer.head.substr(at + 16));
    while (got_.size() < end + 4 + length) {
      if (!more(timeout_ms)) return answer;
    }
    answer.status = std::stoi(answer.head.substr(9, 3));
    answer.body = got_.substr(end + 4, length);
    got_.erase(0, end + 4 + length);
    return answer;
  }
  HttpAnswer ask(std::string_view request) {
    send(request);
    return receive();
  }
  /// Whether the server ends the connection within this time.
  bool ends(int timeout_ms) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(timeout_ms);
    for (;;) {
      const auto left =
          std::chrono::duration_cast<std::chrono::milliseconds>(until - std::chrono::steady_clock::now()).count();
      if (left <= 0) return false;
      if (!more(static_cast<int>(left))) return ended_;
    }
  }
  /// A masked frame, as clients send them.
  bool send_frame(int opcode, std::string_view bytes, bool masked = true) const {
    std::string frame(1, static_cast<char>(0x80 | opcode));
    const int mask = masked ? 0x80 : 0;
    if (bytes.size() < 126) {
      frame += static_cast<char>(mask | static_cast<int>(bytes.size()));
    } else if (bytes.size() < 65536) {
      frame += static_cast<char>(mask | 126);
      frame += static_cast<char>(bytes.size() >> 8);
      frame += static_cast<char>(bytes.size());
    } else {
      frame += static_cast<char>(mask | 127);
      for (int shift = 56; shift >= 0; shift -= 8) frame += static_cast<char>(bytes.size() >> shift);
    }
    if (masked) frame += std::string(4, '\0');  // a mask of zeros changes nothing
    return send(frame) && send(bytes);
  }
  WebFrame receive_frame(int timeout_ms = 5000) {
    const auto need = [&](std::size_t bytes) {
      while (got_.size() < bytes) {
        if (!more(timeout_ms)) return false;
      }
      return true;
    };
    if (!need(2)) return {};
    std::size_t length = static_cast<unsigned char>(got_[1]) & 0x7fu, head = 2;
    if (length == 126) {
      if (!need(4)) return {};
      length = static_cast<std::size_t>(static_cast<unsigned char>(got_[2])) << 8 | static_cast<unsigned char>(got_[3]);
      head = 4;
    } else if (length == 127) {
      if (!need(10)) return {};
      length = 0;
      for (int i = 2; i < 10; ++i) length = length << 8 | static_cast<unsigned char>(got_[static_cast<std::size_t>(i)]);
      head = 10;
    }
    if (!need(head + length)) return {};
    WebFrame frame{got_[0] & 0x0f, got_.substr(head, length)};
    got_.erase(0, head + length);
    return frame;
  }

 private:
  bool more(int timeout_ms) {
    pollfd waits{socket_, POLLIN, 0};
    if (::poll(&waits, 1, timeout_ms) <= 0) return false;
    char bytes[65536];
    const ssize_t got = ::recv(socket_, bytes, sizeof bytes, 0);
    ended_ = got <= 0;
    if (got > 0) got_.append(bytes, static_cast<std::size_t>(got));
    return got > 0;
  }

  int socket_;
  bool connected_ = false, ended_ = false;
  std::string got_;
};

}  // namespace plc::test
