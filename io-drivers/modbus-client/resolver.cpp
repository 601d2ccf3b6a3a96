#include "io-drivers/modbus-client/resolver.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstring>
#include <mutex>

namespace plc::modbus_client {
namespace {

/// As for buses: plc-run locks its memory. Modules of the C library's resolver need some of it.
constexpr std::size_t kStackBytes = std::size_t{512} * 1024;

}  // namespace

struct Resolver::State {
  std::string host, port;
  std::mutex mutex;
  std::condition_variable answered;
  bool asks = false;  ///< the thread runs
  bool fresh = false;
  std::vector<SocketAddress> addresses;
  std::string reason;
};

std::vector<SocketAddress> Resolver::ask(const State& state, int flags, std::string& reason) {
  addrinfo wanted = {};
  wanted.ai_flags = flags;
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(state.host.c_str(), state.port.c_str(), &wanted, &found);
  reason = error == 0 ? "" : error == EAI_SYSTEM ? std::strerror(errno) : ::gai_strerror(error);
  std::vector<SocketAddress> all;
  for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
    if (one->ai_addrlen > sizeof(sockaddr_storage)) continue;
    SocketAddress& address = all.emplace_back();
    std::memcpy(&address.bytes, one->ai_addr, one->ai_addrlen);
    address.size = one->ai_addrlen;
  }
  if (found != nullptr) ::freeaddrinfo(found);
  return all;
}

std::string text_of(const SocketAddress& address) {
  std::array<char, INET6_ADDRSTRLEN> text = {};
  const void* from = address.bytes.ss_family == AF_INET
                         ? static_cast<const void*>(&reinterpret_cast<const sockaddr_in*>(&address.bytes)->sin_addr)
                         : &reinterpret_cast<const sockaddr_in6*>(&address.bytes)->sin6_addr;
  ::inet_ntop(address.bytes.ss_family, from, text.data(), text.size());
  return text.data();
}

std::string why_no_way(const SocketAddress& address) {
  // A datagram socket that is connected has been given a route, and has sent nothing.
  const int fd = ::socket(address.bytes.ss_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return std::strerror(errno);
  const int result = ::connect(fd, reinterpret_cast<const sockaddr*>(&address.bytes), address.size);
  std::string why = result == 0 ? "" : std::strerror(errno);
  ::close(fd);
  return why;
}

Resolver::Resolver(std::string host, std::uint16_t port) : state_(std::make_shared<State>()) {
  state_->host = std::move(host);
  state_->port = std::to_string(port);
  known_ = ask(*state_, AI_NUMERICHOST, reason_);
  is_address_ = !known_.empty();
}

const std::vector<SocketAddress>& Resolver::resolve(core::TimeNs deadline_ns) {
  if (is_address_) return known_;
  waits_ = false;
  std::unique_lock lock(state_->mutex);
  if (!state_->asks && !state_->fresh) {
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    pthread_attr_t attributes;
    pthread_attr_init(&attributes);
    pthread_attr_setstacksize(&attributes, kStackBytes);
    pthread_attr_setdetachstate(&attributes, PTHREAD_CREATE_DETACHED);
    auto shared = std::make_unique<std::shared_ptr<State>>(state_);
    pthread_t thread;
    const auto body = [](void* argument) -> void* {
      const std::unique_ptr<std::shared_ptr<State>> state(static_cast<std::shared_ptr<State>*>(argument));
      std::string reason;
      std::vector<SocketAddress> addresses = ask(**state, 0, reason);
      const std::scoped_lock answer((*state)->mutex);
      (*state)->addresses = std::move(addresses);
      (*state)->reason = std::move(reason);
      (*state)->asks = false;
      (*state)->fresh = true;
      (*state)->answered.notify_all();
      return nullptr;
    };
    const int error = pthread_create(&thread, &attributes, body, shared.get());
    if (error == 0) static_cast<void>(shared.release());
    pthread_attr_destroy(&attributes);
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    if (error != 0) {
      reason_ = std::strerror(error);
      return known_;
    }
    state_->asks = true;
  }
  const core::TimeNs left =
      std::clamp<core::TimeNs>(deadline_ns - core::MonotonicClock().now_ns(), 0, 3'600'000'000'000);
  if (!state_->answered.wait_for(lock, std::chrono::nanoseconds(left), [&] { return state_->fresh; })) {
    waits_ = true;
    reason_ = "no name server answers in time";
    return known_;
  }
  state_->fresh = false;
  reason_ = state_->reason;
  if (!state_->addresses.empty()) known_ = state_->addresses;
  return known_;
}

}  // namespace plc::modbus_client
