// Inside engineering/server.cpp: one client: requests one after another, or a WebSocket.
//
// In: a socket, plain or with TLS. Out: answers. Threads: that of all connections. Does not belong here: who may
// connect.
#pragma once

#include <algorithm>  // WHY first: Asio of Boost 1.74 needs std::exchange, and does not include it
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "engineering/dispatch.h"

namespace plc::engineering {

/// What the server knows of a client.
class Client {
 public:
  virtual ~Client() = default;
  virtual void start() = 0;
  virtual void close() = 0;

  std::string peer;
  bool has_logged_in = false;
  std::string user;             ///< whose call came last; empty: nobody's yet
  std::uint64_t last_used = 0;  ///< rises with every use of any connection
};

/// What a client needs of the server.
class ClientOwner {
 public:
  virtual ~ClientOwner() = default;
  virtual Dispatcher& dispatcher() = 0;
  /// Runs a ready call on its thread; `done` is called on that of the connections. False when too much waits.
  virtual bool run(std::shared_ptr<ReadyCall> ready, std::function<void(HttpResponse)> done) = 0;
  /// The same for what a stream prepares, on the thread for files.
  virtual bool prepare(std::function<void()> work, std::function<void()> done) = 0;
  virtual void used(Client& client) = 0;
  /// A stream goes on: it is in use, also when its client only reads.
  virtual void goes_on(Client& client) = 0;
  virtual void closed(Client& client, bool dropped) = 0;
  virtual void counted_frame() = 0;
  /// One client at a time may send a file: false when another one does. It ends with end_file() or closed().
  virtual bool begin_file(Client& client) = 0;
  virtual void end_file(Client& client) = 0;
  [[nodiscard]] virtual std::chrono::milliseconds request_timeout() const = 0;
  [[nodiscard]] virtual std::chrono::milliseconds idle_timeout() const = 0;
};

/// `context`: of TLS; null for plain sockets.
std::shared_ptr<Client> make_connection(boost::asio::ip::tcp::socket socket, boost::asio::ssl::context* context,
                                        ClientOwner& owner);

}  // namespace plc::engineering
