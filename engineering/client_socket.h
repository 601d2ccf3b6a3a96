// Inside engineering/connection.cpp: the socket of a client, plain or with TLS, as one type.
//
// In: bytes to write, memory to read into. Out: completions. Threads: that of all connections. Does not belong here:
// what the bytes mean.
//
// WHY one type: HTTP and WebSockets of Beast are templates over the stream. With two types of it they were 1.2 MB of
// code and a minute of compiling.
#pragma once

#include <algorithm>  // WHY first: Asio of Boost 1.74 needs std::exchange, and does not include it
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/beast/core/role.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>

namespace plc::engineering {

/// What is called once, when bytes have been read or written. Unlike std::function it need not be copied.
class Completion {
 public:
  template <class Handler, class = std::enable_if_t<!std::is_same_v<std::decay_t<Handler>, Completion>>>
  explicit Completion(Handler&& handler)
      : call_(std::make_unique<CallOf<std::decay_t<Handler>>>(std::forward<Handler>(handler))) {}

  void operator()(const boost::system::error_code& error, std::size_t bytes = 0) {
    const std::unique_ptr<Call> call = std::move(call_);
    call->run(error, bytes);
  }

 private:
  struct Call {
    virtual ~Call() = default;
    virtual void run(const boost::system::error_code& error, std::size_t bytes) = 0;
  };
  template <class Handler>
  struct CallOf final : Call {
    template <class Given>
    explicit CallOf(Given&& given) : handler(std::forward<Given>(given)) {}
    void run(const boost::system::error_code& error, std::size_t bytes) override {
      if constexpr (std::is_invocable_v<Handler&, boost::system::error_code, std::size_t>) {
        handler(error, bytes);
      } else {
        handler(error);
      }
    }
    Handler handler;
  };
  std::unique_ptr<Call> call_;
};

/// Some buffers, for one write.
class GatheredBuffers {
 public:
  using value_type = boost::asio::const_buffer;
  static constexpr std::size_t kMost = 64;  ///< each field of a header is one; asio writes no more at once either

  /// The first that are not empty: what is left is for the next write.
  template <class Buffers>
  explicit GatheredBuffers(const Buffers& buffers) {
    const auto end = boost::asio::buffer_sequence_end(buffers);
    for (auto at = boost::asio::buffer_sequence_begin(buffers); at != end && count_ < kMost; ++at) {
      const value_type buffer(*at);
      if (buffer.size() != 0) all_[count_++] = buffer;
    }
  }
  [[nodiscard]] const value_type* begin() const { return all_.data(); }
  [[nodiscard]] const value_type* end() const { return all_.data() + count_; }

 private:
  std::array<value_type, kMost> all_;
  std::size_t count_ = 0;
};

/// An AsyncStream of Beast. Every completion comes on the thread that runs the socket's io_context.
class ClientSocket {
 public:
  using executor_type = boost::beast::tcp_stream::executor_type;
  using next_layer_type = boost::beast::tcp_stream;

  /// `context`: of TLS, which lives longer; null for a plain socket.
  ClientSocket(boost::asio::ip::tcp::socket socket, boost::asio::ssl::context* context);

  executor_type get_executor() { return next_layer().get_executor(); }
  /// The TCP stream, with its deadline for all that is asked after.
  [[nodiscard]] next_layer_type& next_layer() { return layers_->tcp(); }
  [[nodiscard]] const next_layer_type& next_layer() const { return layers_->tcp(); }

  /// Of TLS; completes at once, within the call, for a plain socket.
  void handshake(Completion done) { layers_->handshake(std::move(done)); }
  /// Says that no more comes: with TLS when the client has confirmed it, else at once, within the call.
  void shut_down(Completion done) { layers_->shut_down(std::move(done)); }
  /// What Beast asks for when a WebSocket has ended: shut_down(), then the end of what the client sends.
  void tear_down(boost::beast::role_type role, Completion done) { layers_->tear_down(role, std::move(done)); }
  [[nodiscard]] bool has_tls() const { return layers_->has_tls(); }

  template <class Buffers, class Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    // Into the first that is not empty: a read may give less than there is room for.
    boost::asio::mutable_buffer first;
    const auto end = boost::asio::buffer_sequence_end(buffers);
    for (auto at = boost::asio::buffer_sequence_begin(buffers); at != end && first.size() == 0; ++at) first = *at;
    layers_->read(first, Completion(std::forward<Handler>(handler)));
  }
  template <class Buffers, class Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    layers_->write(GatheredBuffers(buffers), Completion(std::forward<Handler>(handler)));
  }

 private:
  struct Layers {
    virtual ~Layers() = default;
    virtual boost::beast::tcp_stream& tcp() = 0;
    virtual void handshake(Completion done) = 0;
    virtual void shut_down(Completion done) = 0;
    virtual void tear_down(boost::beast::role_type role, Completion done) = 0;
    [[nodiscard]] virtual bool has_tls() const = 0;
    virtual void read(boost::asio::mutable_buffer into, Completion done) = 0;
    virtual void write(const GatheredBuffers& bytes, Completion done) = 0;
  };
  struct Plain;
  struct Tls;

  std::unique_ptr<Layers> layers_;
};

/// Found by Beast when a WebSocket ends.
template <class Handler>
void async_teardown(boost::beast::role_type role, ClientSocket& socket, Handler&& handler) {
  socket.tear_down(role, Completion(std::forward<Handler>(handler)));
}

}  // namespace plc::engineering
