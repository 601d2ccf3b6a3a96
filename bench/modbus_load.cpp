#include "bench/modbus_load.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <memory>

namespace plc::bench {
namespace {

constexpr std::size_t kMaxFrame = 260;

struct Client {
  int fd = -1;
  std::size_t read = 0;  ///< which request is under way
  std::uint16_t transaction = 0;
  std::size_t received = 0;
  std::array<std::uint8_t, kMaxFrame> buffer;
};

class Load {
 public:
  Load(std::span<const RegisterRead> reads, const RegisterCheck& check) : reads_(reads), check_(check) {}
  ~Load() {
    for (const auto& client : clients_) ::close(client->fd);
    ::close(epoll_);
  }
  Load(const Load&) = delete;
  Load& operator=(const Load&) = delete;

  bool connect(std::uint16_t port, unsigned connections) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    for (unsigned i = 0; i < connections; ++i) {
      clients_.push_back(std::make_unique<Client>());
      Client& client = *clients_.back();
      client.fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
      client.read = i % reads_.size();
      if (client.fd < 0 || ::connect(client.fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
        return fail("cannot connect");
      }
      const int on = 1;
      ::setsockopt(client.fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      epoll_event event{};
      event.events = EPOLLIN;
      event.data.u32 = i;
      ::epoll_ctl(epoll_, EPOLL_CTL_ADD, client.fd, &event);
    }
    return true;
  }
  void run(double seconds) {
    const core::TimeNs begin = clock_.now_ns();
    const core::TimeNs end = begin + static_cast<core::TimeNs>(seconds * 1e9);
    for (const auto& client : clients_) ask(*client);
    core::TimeNs now = begin;
    while (now < end && result_.errors == 0) {
      std::array<epoll_event, 128> events;
      const int count = ::epoll_wait(epoll_, events.data(), static_cast<int>(events.size()), 1000);
      now = clock_.now_ns();
      if (count == 0) fail("no answer within a second");
      for (int i = 0; i < count; ++i) receive(*clients_[events[static_cast<std::size_t>(i)].data.u32]);
    }
    result_.seconds = static_cast<double>(now - begin) / 1e9;
  }
  [[nodiscard]] const LoadResult& result() const { return result_; }

 private:
  bool fail(const char* what) {
    if (result_.errors++ == 0) result_.problem = what;
    return false;
  }
  void ask(Client& client) {
    const RegisterRead& read = reads_[client.read];
    const auto high = [](unsigned value) { return static_cast<std::uint8_t>(value >> 8); };
    const auto low = [](unsigned value) { return static_cast<std::uint8_t>(value); };
    const std::uint8_t frame[] = {
        high(client.transaction), low(client.transaction), 0, 0, 0, 6, 1, 3, high(read.first), low(read.first),
        high(read.count),         low(read.count)};
    client.received = 0;
    if (::send(client.fd, frame, sizeof frame, MSG_NOSIGNAL) != sizeof frame) fail("cannot send");
  }
  void receive(Client& client) {
    const RegisterRead& read = reads_[client.read];
    const std::size_t size = 9 + 2 * std::size_t{read.count};
    const ssize_t bytes =
        ::recv(client.fd, client.buffer.data() + client.received, client.buffer.size() - client.received, MSG_DONTWAIT);
    if (bytes < 0 && errno == EAGAIN) return;
    if (bytes <= 0) return (void)fail("connection lost");
    client.received += static_cast<std::size_t>(bytes);
    if (client.received >= 9 && client.buffer[7] != 3) return (void)fail("exception");
    if (client.received < size) return;
    const unsigned transaction = client.buffer[0] * 256u + client.buffer[1];
    if (client.received > size || transaction != client.transaction || client.buffer[8] != 2 * read.count) {
      return (void)fail("wrong frame");
    }
    ++result_.answers;
    if (!check_(read, std::span(client.buffer).subspan(9, 2 * std::size_t{read.count}))) ++result_.mismatches;
    ++client.transaction;
    client.read = (client.read + 1) % reads_.size();
    ask(client);
  }

  std::span<const RegisterRead> reads_;
  const RegisterCheck& check_;
  core::MonotonicClock clock_;
  int epoll_ = ::epoll_create1(EPOLL_CLOEXEC);
  std::vector<std::unique_ptr<Client>> clients_;
  LoadResult result_;
};

}  // namespace

LoadResult modbus_load(std::uint16_t port, unsigned connections, double seconds, std::span<const RegisterRead> reads,
                       const RegisterCheck& check) {
  Load load(reads, check);
  if (load.connect(port, connections)) load.run(seconds);
  return load.result();
}

}  // namespace plc::bench
