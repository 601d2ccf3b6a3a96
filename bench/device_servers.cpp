#include "bench/device_servers.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstring>
#include <stdexcept>

namespace plc::bench {
namespace {

constexpr std::size_t kHead = 7, kRequest = 12;
constexpr unsigned kMostRegisters = 125;

int listen_anywhere(std::uint16_t& port) {
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in at = {};
  at.sin_family = AF_INET;
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof at;
  if (fd < 0 || ::bind(fd, reinterpret_cast<sockaddr*>(&at), size) != 0 || ::listen(fd, 4) != 0 ||
      ::getsockname(fd, reinterpret_cast<sockaddr*>(&at), &size) != 0) {
    throw std::runtime_error("no port for a device");
  }
  port = ntohs(at.sin_port);
  return fd;
}

/// One request is under way on a connection: it comes whole.
void answer(int fd) {
  static std::uint16_t value = 0;
  std::array<std::uint8_t, 260> bytes;
  const ssize_t got = ::read(fd, bytes.data(), bytes.size());
  if (got <= 0) {
    ::close(fd);
    return;
  }
  const auto count = static_cast<unsigned>(bytes[10] << 8 | bytes[11]);
  if (got != static_cast<ssize_t>(kRequest) || bytes[kHead] != 3 || count > kMostRegisters) return;
  bytes[5] = static_cast<std::uint8_t>(3 + 2 * count);
  bytes[kHead + 1] = static_cast<std::uint8_t>(2 * count);
  ++value;
  for (unsigned i = 0; i < count; ++i) {
    bytes[9 + 2 * i] = static_cast<std::uint8_t>(value >> 8);
    bytes[10 + 2 * i] = static_cast<std::uint8_t>(value);
  }
  static_cast<void>(::send(fd, bytes.data(), 9 + 2 * count, MSG_NOSIGNAL));
}

[[noreturn]] void serve(const std::vector<int>& listeners) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  const int all = ::epoll_create1(EPOLL_CLOEXEC);
  const auto watch = [&](int fd) {
    epoll_event event = {EPOLLIN, {.fd = fd}};
    ::epoll_ctl(all, EPOLL_CTL_ADD, fd, &event);
  };
  for (const int listener : listeners) watch(listener);
  for (;;) {
    std::array<epoll_event, 64> ready;
    const int count = ::epoll_wait(all, ready.data(), static_cast<int>(ready.size()), -1);
    for (int i = 0; i < count; ++i) {
      const int fd = ready[static_cast<std::size_t>(i)].data.fd;
      if (fd > listeners.back()) {
        answer(fd);
        continue;
      }
      const int client = ::accept4(fd, nullptr, nullptr, SOCK_CLOEXEC);
      const int one = 1;
      ::setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
      if (client >= 0) watch(client);
    }
  }
}

}  // namespace

DeviceServers::DeviceServers(unsigned count) {
  std::vector<int> listeners;
  for (unsigned i = 0; i < count; ++i) listeners.push_back(listen_anywhere(ports_.emplace_back()));
  process_ = ::fork();
  if (process_ == 0) serve(listeners);
  for (const int listener : listeners) ::close(listener);
  if (process_ < 0) throw std::runtime_error("no process for the devices");
}

DeviceServers::~DeviceServers() {
  ::kill(process_, SIGKILL);
  ::waitpid(process_, nullptr, 0);
}

}  // namespace plc::bench
