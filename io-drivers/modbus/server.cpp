#include "io-drivers/modbus/server.h"

#include <fcntl.h>
#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <exception>
#include <filesystem>
#include <iterator>
#include <system_error>
#include <vector>

#include "io-drivers/modbus/connection.h"
#include "runtime/sched/ordinary_thread.h"

namespace plc::modbus {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using Acceptor = asio::basic_socket_acceptor<tcp, Executor>;
using Timer =
    asio::basic_waitable_timer<std::chrono::steady_clock, asio::wait_traits<std::chrono::steady_clock>, Executor>;

constexpr std::chrono::milliseconds kSweep{100};
/// Without descriptors or memory for another connection, accepting rests for so long.
constexpr std::chrono::milliseconds kAcceptPause{100};
/// A connection that was of use once gives way to a new one after so long without a request.
constexpr core::TimeNs kGivesWayAfterNs = 60'000'000'000;
/// Share of the connections that only addresses without one may take.
constexpr std::uint32_t kReserveShare = 8;

/// As many of `wanted` connections as the limit of descriptors leaves room for, with the limit raised as far as it may
/// be.
std::uint32_t affordable(std::uint32_t wanted) {
  constexpr rlim_t kOthers = 16;  // files that are opened later: logs, devices that come back
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return wanted;
  std::error_code unknown;
  const auto open = static_cast<rlim_t>(std::distance(std::filesystem::directory_iterator("/proc/self/fd", unknown),
                                                      std::filesystem::directory_iterator()));
  const rlim_t needed = open + kOthers + wanted;
  if (limit.rlim_cur < needed) {
    limit.rlim_cur = std::min(needed, limit.rlim_max);
    ::setrlimit(RLIMIT_NOFILE, &limit);
    ::getrlimit(RLIMIT_NOFILE, &limit);
  }
  if (limit.rlim_cur >= needed) return wanted;
  return limit.rlim_cur > open + kOthers ? static_cast<std::uint32_t>(limit.rlim_cur - open - kOthers) : 1;
}

error_code listen(Acceptor& acceptor, const io::ModbusConfig& config) {
  error_code error;
  const asio::ip::address address = asio::ip::make_address(config.address, error);
  if (error) return error;
  const tcp::endpoint endpoint(address, config.port);
  if (config.socket >= 0) {
    const int copy = ::fcntl(config.socket, F_DUPFD_CLOEXEC, 0);
    if (copy < 0) return {errno, boost::system::system_category()};
    acceptor.assign(endpoint.protocol(), copy, error);
    if (error) ::close(copy);
    return error;
  }
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  return error;
}

core::Problem cannot_listen(const io::ModbusConfig& config, const error_code& error) {
  const char* help = "see [modbus] listen in plc.toml, or --modbus";
  if (error == asio::error::address_in_use) {
    help = "another server has the port, perhaps another plc-run: take another one, --modbus 127.0.0.1:1502";
  } else if (error == asio::error::access_denied) {
    help =
        "ports below 1024 need a privilege: a service has systemd open it (systemctl enable --now picard@NAME.socket); "
        "or take 1502";
  } else if (error == boost::system::errc::address_not_available) {
    help = "this machine has no such address: 0.0.0.0 means all it has";
  }
  return {core::Code::P7510,
          "cannot listen for Modbus clients on " + config.address + " port " + std::to_string(config.port) + ": " +
              error.message(),
          help};
}

}  // namespace

struct Server::State final : Connection::Owner {
  State(Responder& shared, const io::ModbusConfig& modbus) : config(modbus), responder(shared) {}

  std::size_t answer(std::span<const std::uint8_t> frame, std::span<std::uint8_t, kMaxFrame> answer) override;
  void closed(Connection& connection, bool dropped) override;

  void accept();
  void admit(Socket socket, const asio::ip::address& peer);
  [[nodiscard]] bool make_room(const asio::ip::address& peer);
  [[nodiscard]] Connection* least_useful(const asio::ip::address* peer) const;
  void sweep();
  void release_coils();
  void run() noexcept;

  /// What one start() needs and one stop() ends. Declared in the order of construction: connections go first.
  struct Session {
    asio::io_context io{BOOST_ASIO_CONCURRENCY_HINT_UNSAFE_IO};  // one thread; stop() may come from another
    Acceptor acceptor{io.get_executor()};
    Timer sweep_timer{io.get_executor()};
    Timer accept_timer{io.get_executor()};
    Timer coil_timer{io.get_executor()};
    bool coils_wait = false;  ///< the timer runs
    tcp::endpoint peer;       ///< of the connection that is accepted next
    std::vector<std::shared_ptr<Connection>> connections;
  };
  struct Counters {
    std::atomic<std::uint64_t> accepted{0}, refused{0}, requests{0}, exceptions{0}, dropped{0};
    std::atomic<std::uint32_t> clients{0};
  };

  const io::ModbusConfig& config;
  std::uint32_t places = config.max_clients;
  Responder& responder;
  Counters counters;
  std::unique_ptr<Session> session;
  runtime::OrdinaryThread thread;
  std::atomic<std::uint16_t> port{0};  ///< any thread may ask
};

std::size_t Server::State::answer(std::span<const std::uint8_t> frame, std::span<std::uint8_t, kMaxFrame> answer) {
  const std::uint8_t unit = frame[kFrameHead - 1];
  std::size_t size = 0;
  const auto pdu = answer.subspan<kFrameHead, kMaxPdu>();
  if (config.unit_id && unit != *config.unit_id) {
    if (!config.unit_exception) return 0;
    pdu[0] = static_cast<std::uint8_t>(frame[kFrameHead] | 0x80);
    pdu[1] = static_cast<std::uint8_t>(Exception::kWrongUnit);
    size = 2;
  } else {
    size = responder.answer(frame.subspan(kFrameHead), pdu);
  }
  std::copy_n(frame.begin(), 4, answer.begin());  // transaction and protocol
  answer[4] = static_cast<std::uint8_t>((size + 1) >> 8);
  answer[5] = static_cast<std::uint8_t>(size + 1);
  answer[6] = unit;
  counters.requests.fetch_add(1, std::memory_order_relaxed);
  if ((pdu[0] & 0x80) != 0) counters.exceptions.fetch_add(1, std::memory_order_relaxed);
  if (!session->coils_wait) release_coils();
  return kFrameHead + size;
}

void Server::State::closed(Connection& connection, bool dropped) {
  if (dropped) counters.dropped.fetch_add(1, std::memory_order_relaxed);
  auto& all = session->connections;
  const auto at = std::find_if(all.begin(), all.end(), [&](const auto& other) { return other.get() == &connection; });
  if (at == all.end()) return;
  std::iter_swap(at, all.end() - 1);
  all.pop_back();
  counters.clients.store(static_cast<std::uint32_t>(all.size()), std::memory_order_relaxed);
}

void Server::State::accept() {
  session->acceptor.async_accept(session->peer, [this](const error_code& error, Socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (!error) {
      const asio::ip::address peer = session->peer.address();
      accept();
      return admit(std::move(socket), peer);
    }
    // No descriptor, or no memory in the kernel: the client waits in the queue, and trying at once would only spin.
    session->accept_timer.expires_after(kAcceptPause);
    session->accept_timer.async_wait([this](const error_code& stopped) {
      if (!stopped) accept();
    });
  });
}

void Server::State::admit(Socket socket, const asio::ip::address& peer) {
  if (!make_room(peer)) {
    counters.refused.fetch_add(1, std::memory_order_relaxed);
    return;  // the socket closes
  }
  auto& all = session->connections;
  all.push_back(std::make_shared<Connection>(std::move(socket), peer, *this));
  counters.accepted.fetch_add(1, std::memory_order_relaxed);
  counters.clients.store(static_cast<std::uint32_t>(all.size()), std::memory_order_relaxed);
  const std::shared_ptr<Connection> connection = all.back();
  connection->start();
}

/// A flood from one address takes neither the places of others nor, once it is silent, all of its own: who never asked
/// anything gives way first.
bool Server::State::make_room(const asio::ip::address& peer) {
  const auto& all = session->connections;
  const auto from_peer = static_cast<std::uint32_t>(
      std::count_if(all.begin(), all.end(), [&](const auto& connection) { return connection->peer() == peer; }));
  const std::uint32_t per_address = config.max_clients_per_address == 0 ? places : config.max_clients_per_address;
  const std::uint32_t reserve = from_peer == 0 ? 0 : places / kReserveShare;
  Connection* gives_way = nullptr;
  if (from_peer >= per_address || (from_peer != 0 && all.size() + reserve >= places)) {
    gives_way = least_useful(&peer);
  } else if (all.size() >= places) {
    gives_way = least_useful(nullptr);
  } else {
    return true;
  }
  if (gives_way == nullptr) return false;
  gives_way->close(true);
  return true;
}

/// Of all, or of those from `peer`: the one silent longest among those that never asked, else among those that have not
/// for kGivesWayAfterNs; nothing when all are in use.
Connection* Server::State::least_useful(const asio::ip::address* peer) const {
  const core::TimeNs now_ns = connection_clock_ns();
  Connection* least = nullptr;
  for (const auto& connection : session->connections) {
    if (peer != nullptr && connection->peer() != *peer) continue;
    if (connection->has_requested() && now_ns - connection->last_request_ns() < kGivesWayAfterNs) continue;
    const bool less = least == nullptr || (connection->has_requested() != least->has_requested()
                                               ? !connection->has_requested()
                                               : connection->last_request_ns() < least->last_request_ns());
    if (less) least = connection.get();
  }
  return least;
}

void Server::State::sweep() {
  const core::TimeNs now_ns = connection_clock_ns();
  auto& all = session->connections;
  for (std::size_t i = all.size(); i-- > 0;) {
    const std::shared_ptr<Connection> connection = all[i];
    const core::TimeNs owing_ns = connection->owing_since_ns();
    const bool owes = owing_ns != 0 && now_ns - owing_ns > config.frame_timeout_ns;
    const bool idle = config.idle_timeout_ns != 0 && now_ns - connection->last_request_ns() > config.idle_timeout_ns;
    if (owes || idle) connection->close(true);
  }
  responder.sweep(now_ns);
  session->sweep_timer.expires_after(kSweep);
  session->sweep_timer.async_wait([this](const error_code& stopped) {
    if (!stopped) sweep();
  });
}

/// Now and then, as long as coils wait to be reset.
void Server::State::release_coils() {
  session->coils_wait = responder.coils_wait();
  if (!session->coils_wait) return;
  session->coil_timer.expires_after(std::chrono::nanoseconds(Responder::kCoilPause));
  session->coil_timer.async_wait([this](const error_code& stopped) {
    if (stopped) return;
    responder.release_coils();
    release_coils();
  });
}

void Server::State::run() noexcept {
  for (;;) {
    try {
      session->io.run();
      return;
    } catch (const std::exception&) {
      // Out of memory: what was under way is lost, the other connections go on.
    }
  }
}

Server::Server(Responder& responder, const io::ModbusConfig& config)
    : state_(std::make_unique<State>(responder, config)) {}

Server::~Server() { stop(); }

std::optional<core::Problem> Server::start() {
  State& state = *state_;
  if (state.session) return std::nullopt;
  state.session = std::make_unique<State::Session>();
  error_code error = listen(state.session->acceptor, state.config);
  if (!error) state.port = state.session->acceptor.local_endpoint(error).port();
  if (error) {
    state.session.reset();
    return cannot_listen(state.config, error);
  }
  state.places = affordable(state.config.max_clients);
  state.accept();
  state.sweep();
  state.thread.start("plc-modbus", [&state] { state.run(); });
  return std::nullopt;
}

void Server::stop() {
  State& state = *state_;
  if (!state.session) return;
  state.session->io.stop();
  state.thread.join();
  state.session->connections.clear();
  state.session.reset();
  state.counters.clients.store(0, std::memory_order_relaxed);
  state.responder.stopped();
}

std::uint32_t Server::places() const { return state_->places; }

std::uint16_t Server::port() const { return state_->port; }

ServerStatistics Server::statistics() const {
  const State::Counters& counters = state_->counters;
  const auto value = [](const auto& counter) { return counter.load(std::memory_order_relaxed); };
  return {value(counters.accepted),   value(counters.refused), value(counters.requests),
          value(counters.exceptions), value(counters.dropped), value(counters.clients)};
}

}  // namespace plc::modbus
