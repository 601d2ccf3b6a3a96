#include "engineering/server.h"

#include <fcntl.h>
#include <openssl/ssl.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <exception>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "engineering/connection.h"
#include "engineering/worker.h"
#include "runtime/sched/ordinary_thread.h"

namespace plc::engineering {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

/// Without descriptors or memory for another connection, accepting rests for so long.
constexpr std::chrono::milliseconds kAcceptPause{100};
/// Calls that wait for a thread of their own.
constexpr std::size_t kMostSecrets = 64;
constexpr std::size_t kMostFiles = 256;
constexpr std::size_t kMostPast = 64;
constexpr std::size_t kMostUploads = 1;  // one client at a time sends a file

core::Problem cannot_listen(const ServerOptions& options, const error_code& error) {
  const char* help = "see listen under [engineering] in plc.toml, or --engineering";
  if (error == asio::error::address_in_use) {
    help = "another program has the port, perhaps another plc-run: take another one, --engineering 127.0.0.1:8062";
  } else if (error == asio::error::access_denied) {
    help = "ports below 1024 need a privilege: take 8061";
  } else if (error == boost::system::errc::address_not_available) {
    help = "this machine has no such address: 0.0.0.0 means all it has";
  }
  return {core::Code::P7700,
          "cannot listen for engineering clients on " + options.address + " port " + std::to_string(options.port) +
              ": " + error.message(),
          help};
}

std::optional<core::Problem> set_up(asio::ssl::context& context, const Certificate& certificate) {
  error_code error;
  context.set_options(asio::ssl::context::default_workarounds | asio::ssl::context::no_sslv2 |
                          asio::ssl::context::no_sslv3 | asio::ssl::context::no_tlsv1 | asio::ssl::context::no_tlsv1_1 |
                          SSL_OP_NO_RENEGOTIATION | SSL_OP_CIPHER_SERVER_PREFERENCE,
                      error);
  if (!error) context.use_certificate_chain(asio::buffer(certificate.chain), error);
  if (!error) context.use_private_key(asio::buffer(certificate.key), asio::ssl::context::pem, error);
  if (error) return core::Problem{core::Code::P7703, "the certificate cannot be used: " + error.message(), {}};
  return std::nullopt;
}

}  // namespace

bool is_loopback(const std::string& address) {
  error_code error;
  const asio::ip::address parsed = asio::ip::make_address(address, error);
  return !error && parsed.is_loopback();
}

struct Server::State final : ClientOwner {
  State(Dispatcher& shared, ServerOptions given) : calls(shared), options(std::move(given)) {}

  Dispatcher& dispatcher() override { return calls; }
  bool run(std::shared_ptr<ReadyCall> ready, std::function<void(HttpResponse)> done) override;
  bool prepare(std::function<void()> work, std::function<void()> done) override {
    return post(files, std::move(work), std::move(done));
  }
  void used(Client& client) override {
    client.last_used = ++uses;
    counters.requests.fetch_add(1, std::memory_order_relaxed);
  }
  void goes_on(Client& client) override { client.last_used = ++uses; }
  void closed(Client& client, bool dropped) override;
  bool begin_file(Client& client) override {
    if (file_from == nullptr) file_from = &client;
    return file_from == &client;
  }
  void end_file(Client& client) override {
    if (file_from == &client) file_from = nullptr;
  }
  void counted_frame() override { counters.frames.fetch_add(1, std::memory_order_relaxed); }
  [[nodiscard]] std::chrono::milliseconds request_timeout() const override {
    return std::chrono::milliseconds(options.request_timeout_ms);
  }
  [[nodiscard]] std::chrono::milliseconds idle_timeout() const override {
    return std::chrono::milliseconds(options.idle_timeout_ms);
  }

  /// `done` is called, and what it holds is let go of, on the thread of the connections. False when too much waits.
  bool post(Worker& worker, std::function<void()> work, std::function<void()> done);
  error_code listen();
  void accept();
  void admit(tcp::socket socket);
  bool make_room();
  [[nodiscard]] std::shared_ptr<Client> who_gives_way() const;
  void run_io() noexcept;

  /// What one start() needs and one stop() ends. Declared in the order of construction: connections go first.
  struct Session {
    asio::io_context io{1};
    asio::ssl::context tls{asio::ssl::context::tls_server};
    tcp::acceptor acceptor{io};
    asio::steady_timer accept_timer{io};
    std::vector<std::shared_ptr<Client>> clients;
  };
  struct Counters {
    std::atomic<std::uint64_t> accepted{0}, refused{0}, requests{0}, dropped{0}, frames{0};
    std::atomic<std::uint32_t> clients{0};
  };

  Dispatcher& calls;
  ServerOptions options;
  Counters counters;
  Client* file_from = nullptr;  ///< who sends a file
  std::uint64_t uses = 0;
  std::unique_ptr<Session> session;
  Worker secrets{kMostSecrets};
  Worker files{kMostFiles};
  Worker past{kMostPast};
  Worker uploads{kMostUploads};
  runtime::OrdinaryThread thread;
  std::atomic<std::uint16_t> port{0};
};

error_code Server::State::listen() {
  error_code error;
  tcp::acceptor& acceptor = session->acceptor;
  const asio::ip::address address = asio::ip::make_address(options.address, error);
  if (error) return error;
  const tcp::endpoint endpoint(address, options.port);
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) ::fcntl(acceptor.native_handle(), F_SETFD, FD_CLOEXEC);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  return error;
}

bool Server::State::run(std::shared_ptr<ReadyCall> ready, std::function<void(HttpResponse)> done) {
  if (ready->call->thread == Thread::kIo) {
    done(calls.run(*ready));
    return true;
  }
  Worker& worker = ready->call->thread == Thread::kSecrets  ? secrets
                   : ready->call->thread == Thread::kPast   ? past
                   : ready->call->thread == Thread::kUpload ? uploads
                                                            : files;
  auto response = std::make_shared<HttpResponse>();
  response->status = 503;  // when there is not even memory to say why
  return post(
      worker, [this, ready, response] { *response = calls.run(*ready); },
      [response, done = std::move(done)] { done(std::move(*response)); });
}

bool Server::State::post(Worker& worker, std::function<void()> work, std::function<void()> done) {
  auto shared = std::make_shared<std::function<void()>>(std::move(done));
  return worker.post([this, work = std::move(work), shared]() mutable {
    try {
      work();
    } catch (const std::exception&) {
      // No memory, most likely: who waits for it is told all the same.
    }
    asio::post(session->io, [shared = std::move(shared)] { (*shared)(); });
  });
}

void Server::State::closed(Client& client, bool dropped) {
  end_file(client);
  if (dropped) counters.dropped.fetch_add(1, std::memory_order_relaxed);
  auto& all = session->clients;
  const auto at = std::find_if(all.begin(), all.end(), [&](const auto& other) { return other.get() == &client; });
  if (at == all.end()) return;
  std::iter_swap(at, all.end() - 1);
  all.pop_back();
  counters.clients.store(static_cast<std::uint32_t>(all.size()), std::memory_order_relaxed);
}

void Server::State::accept() {
  session->acceptor.async_accept([this](const error_code& error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (!error) {
      accept();
      return admit(std::move(socket));
    }
    // No descriptor, or no memory in the kernel: the client waits in the queue, and trying at once would only spin.
    session->accept_timer.expires_after(kAcceptPause);
    session->accept_timer.async_wait([this](const error_code& stopped) {
      if (!stopped) accept();
    });
  });
}

/// Of those that have not logged in, the one unused for longest; where all have, that of the user who has most places.
/// Nobody when each has one, and never who sends a file.
std::shared_ptr<Client> Server::State::who_gives_way() const {
  const auto& all = session->clients;
  std::unordered_map<std::string_view, std::size_t> places;
  std::size_t most = 0;
  bool all_known = true;
  for (const auto& client : all) {
    if (client.get() == file_from) continue;
    all_known = all_known && client->has_logged_in;
    most = std::max(most, ++places[client->user]);
  }
  if (all_known && most < 2) return nullptr;
  std::shared_ptr<Client> least;
  for (const auto& client : all) {
    const bool may = all_known ? places[client->user] == most : !client->has_logged_in;
    if (may && client.get() != file_from && (!least || client->last_used < least->last_used)) least = client;
  }
  return least;
}

bool Server::State::make_room() {
  if (session->clients.size() < options.max_clients) return true;
  const std::shared_ptr<Client> least = who_gives_way();
  if (!least) return false;
  least->close();
  closed(*least, true);
  return true;
}

void Server::State::admit(tcp::socket socket) {
  error_code error;
  const tcp::endpoint peer = socket.remote_endpoint(error);
  if (error) return;  // it has gone already
  if (!make_room()) {
    counters.refused.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  ::fcntl(socket.native_handle(), F_SETFD, FD_CLOEXEC);
  socket.set_option(tcp::no_delay(true), error);
  const std::shared_ptr<Client> client =
      make_connection(std::move(socket), options.certificate ? &session->tls : nullptr, *this);
  client->peer = peer.address().to_string();
  client->last_used = ++uses;
  session->clients.push_back(client);
  counters.accepted.fetch_add(1, std::memory_order_relaxed);
  counters.clients.store(static_cast<std::uint32_t>(session->clients.size()), std::memory_order_relaxed);
  client->start();
}

void Server::State::run_io() noexcept {
  for (;;) {
    try {
      session->io.run();
      return;
    } catch (const std::exception&) {
      // Out of memory: what was under way is lost, the other connections go on.
    }
  }
}

Server::Server(Dispatcher& dispatcher, ServerOptions options)
    : state_(std::make_unique<State>(dispatcher, std::move(options))) {}

Server::~Server() { stop(); }

std::optional<core::Problem> Server::start() {
  State& state = *state_;
  if (state.session) return std::nullopt;
  state.session = std::make_unique<State::Session>();
  if (state.options.certificate) {
    if (auto problem = set_up(state.session->tls, *state.options.certificate)) {
      state.session.reset();
      return problem;
    }
  }
  error_code error = state.listen();
  if (!error) state.port = state.session->acceptor.local_endpoint(error).port();
  if (error) {
    state.session.reset();
    return cannot_listen(state.options, error);
  }
  state.accept();
  state.secrets.start("plc-eng-secrets");
  state.files.start("plc-eng-files");
  state.past.start("plc-eng-past");
  state.uploads.start("plc-eng-upload");
  state.thread.start("plc-eng", [&state] { state.run_io(); });
  return std::nullopt;
}

void Server::stop() {
  State& state = *state_;
  if (!state.session) return;
  state.secrets.stop();
  state.files.stop();
  state.past.stop();
  state.uploads.stop();
  state.session->io.stop();
  state.thread.join();
  for (const auto& client : state.session->clients) client->close();
  state.session->clients.clear();
  // WHY not before: a stream is let go of while no other one is served.
  for (Worker* const worker : {&state.secrets, &state.files, &state.past, &state.uploads}) worker->drop();
  state.file_from = nullptr;
  state.session.reset();
  state.counters.clients.store(0, std::memory_order_relaxed);
}

std::uint16_t Server::port() const { return state_->port; }

bool Server::post_file_work(std::function<void()> work) { return state_->files.post(std::move(work)); }

bool Server::post_past_work(std::function<void()> work) { return state_->past.post(std::move(work)); }

ServerStatistics Server::statistics() const {
  const State::Counters& counters = state_->counters;
  const auto value = [](const auto& counter) { return counter.load(std::memory_order_relaxed); };
  return {value(counters.accepted), value(counters.refused), value(counters.requests),
          value(counters.dropped),  value(counters.frames),  value(counters.clients)};
}

}  // namespace plc::engineering
