// Serial lines for tests, made of ptys: a line whose other end is the test, and a cable between two programs.
//
// In: bytes. Out: bytes, paths to open. What a pty has not: speed, parity, and so errors of them. Threads: a cable has
// one of its own. Does not belong here: frames.
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace plc::test {

/// A pty whose slave programs open by path().
class SerialEnd {
 public:
  SerialEnd() {
    char name[128] = {};
    if (::openpty(&master_, &slave_, name, nullptr, nullptr) != 0) throw std::runtime_error("no pty");
    path_ = name;
    termios raw = {};
    ::tcgetattr(slave_, &raw);
    ::cfmakeraw(&raw);
    ::tcsetattr(slave_, TCSANOW, &raw);
  }
  ~SerialEnd() { pull_out(); }
  SerialEnd(const SerialEnd&) = delete;
  SerialEnd& operator=(const SerialEnd&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] int fd() const { return master_; }
  /// As an adapter that is pulled out: who has it open notices.
  void pull_out() {
    if (master_ < 0) return;
    ::close(std::exchange(slave_, -1));
    ::close(std::exchange(master_, -1));
  }
  void put(const std::vector<std::uint8_t>& bytes) const {
    if (::write(master_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size())) {
      throw std::runtime_error("the line takes nothing");
    }
  }
  /// What comes until nothing came for `quiet`; waits for the first byte at most `wait`.
  [[nodiscard]] std::vector<std::uint8_t> get(std::chrono::milliseconds wait,
                                              std::chrono::milliseconds quiet = std::chrono::milliseconds(15)) const {
    std::vector<std::uint8_t> got;
    for (;;) {
      pollfd one = {master_, POLLIN, 0};
      if (::poll(&one, 1, static_cast<int>((got.empty() ? wait : quiet).count())) <= 0) return got;
      std::array<std::uint8_t, 512> bytes;
      const ssize_t n = ::read(master_, bytes.data(), bytes.size());
      if (n <= 0) return got;
      got.insert(got.end(), bytes.begin(), bytes.begin() + n);
    }
  }

 private:
  int master_ = -1, slave_ = -1;
  std::string path_;
};

/// Two ends; what one sends, the other gets.
class SerialCable {
 public:
  SerialCable() : thread_([this] { run(); }) {}
  ~SerialCable() {
    stop_ = true;
    thread_.join();
  }
  SerialCable(const SerialCable&) = delete;
  SerialCable& operator=(const SerialCable&) = delete;
  [[nodiscard]] const std::string& path(std::size_t end) const { return ends_[end].path(); }

 private:
  void run() {
    while (!stop_) {
      pollfd both[] = {{ends_[0].fd(), POLLIN, 0}, {ends_[1].fd(), POLLIN, 0}};
      if (::poll(both, 2, 5) <= 0) continue;
      for (std::size_t i = 0; i < 2; ++i) {
        std::array<std::uint8_t, 512> bytes;
        const ssize_t n = both[i].revents == 0 ? 0 : ::read(ends_[i].fd(), bytes.data(), bytes.size());
        if (n > 0) ends_[1 - i].put({bytes.begin(), bytes.begin() + n});
      }
    }
  }

  std::array<SerialEnd, 2> ends_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace plc::test
