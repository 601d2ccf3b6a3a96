// Inside engineering/server.cpp: one client: requests one after another, or a WebSocket.
//
// In: a socket, plain or with TLS. Out: answers. Threads: that of all connections. Does not belong here: who may
// connect.
#pragma once

#include <algorithm>  // WHY first: Asio of Boost 1.74 needs std::exchange, and does not include it
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/ssl.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <chrono>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "engineering/dispatch.h"
#include "engineering/http.h"
#include "engineering/streams.h"

namespace plc::engineering {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;

/// What the server knows of a client.
class Client {
 public:
  virtual ~Client() = default;
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

using PlainSocket = beast::tcp_stream;
using TlsSocket = beast::ssl_stream<beast::tcp_stream>;

template <class Socket>
class Connection final : public Client, public std::enable_shared_from_this<Connection<Socket>> {
 public:
  static constexpr bool kTls = std::is_same_v<Socket, TlsSocket>;

  /// `context`: of TLS; null for plain sockets.
  Connection(tcp::socket socket, asio::ssl::context* context, ClientOwner& owner)
      : socket_(make(std::move(socket), context)), timer_(lowest().get_executor()), owner_(owner) {}

  void start() {
    if constexpr (kTls) {
      lowest().expires_after(owner_.request_timeout());
      socket_->async_handshake(asio::ssl::stream_base::server, [self = this->shared_from_this()](error_code error) {
        if (error) return self->end(true);
        self->wait_for_request();
      });
    } else {
      wait_for_request();
    }
  }

  void close() override {
    if (closed_) return;
    closed_ = true;
    timer_.cancel();
    error_code ignored;
    if (web_) {
      beast::get_lowest_layer(*web_).socket().close(ignored);
    } else {
      lowest().socket().close(ignored);
    }
  }

 private:
  static constexpr std::size_t kMostAnswers = 16;
  static constexpr std::size_t kReadBytes = 16'384;
  static constexpr int kMessagesPerSecond = 20;
  /// For the last frames of a WebSocket.
  static constexpr std::chrono::milliseconds kClosing{3000};

  static std::unique_ptr<Socket> make(tcp::socket socket, asio::ssl::context* context) {
    if constexpr (kTls) {
      return std::make_unique<Socket>(std::move(socket), *context);
    } else {
      static_cast<void>(context);
      return std::make_unique<Socket>(std::move(socket));
    }
  }
  beast::tcp_stream& lowest() { return beast::get_lowest_layer(*socket_); }

  void end(bool dropped) {
    close();
    owner_.closed(*this, dropped);
  }
  /// Out of memory: this client has had bad luck, the others go on.
  template <class Work>
  void guarded(Work work) {
    try {
      work();
    } catch (const std::exception&) {
      end(true);
    }
  }

  /// Between requests a client may be silent for long; not within one.
  void wait_for_request() {
    if (closed_) return;
    if (buffer_.size() != 0) return read_request();
    lowest().expires_after(owner_.idle_timeout());
    socket_->async_read_some(buffer_.prepare(kReadBytes),
                             [self = this->shared_from_this()](error_code error, std::size_t bytes) {
                               if (error) return self->end(error == beast::error::timeout);
                               self->buffer_.commit(bytes);
                               self->read_request();
                             });
  }

  void read_request() {
    parser_.emplace();
    head_alone_ = false;
    parser_->header_limit(kMostHeaderBytes);
    parser_->body_limit(kMostFileBytes);
    lowest().expires_after(owner_.request_timeout());
    http::async_read_header(*socket_, buffer_, *parser_,
                            [self = this->shared_from_this()](error_code error, std::size_t) {
                              if (error) return self->give_up(error);
                              self->guarded([&] { self->take_header(); });
                            });
  }

  void give_up(error_code error) {
    end_file();
    auto refusal = refusal_of(error);
    if (!refusal) return end(error == beast::error::timeout);
    keep_alive_ = false;
    send(std::move(*refusal));
  }

  /// How much may follow is decided by what is asked, and who asks.
  void take_header() {
    head_alone_ = parser_->get().method() == http::verb::head;
    const std::size_t most = owner_.dispatcher().most_body_bytes(request_of(parser_->get(), peer));
    if (most > kMostBodyBytes && !owner_.begin_file(*this)) {
      keep_alive_ = false;
      return send(Dispatcher::refusal(503, core::Code::P7713, "another client sends a file: one at a time"));
    }
    takes_file_ = most > kMostBodyBytes;
    // WHY before its body: a file takes long, and who may send one does not give way meanwhile.
    if (takes_file_) this->has_logged_in = true;
    if (parser_->content_length().value_or(0) > most) return refuse_large();
    parser_->body_limit(most);
    parser_->eager(true);
    if (takes_file_ && parser_->get()[http::field::expect] == "100-continue") return ask_for_body();
    read_body();
  }

  /// Who may not make the call is told that, not how large it may be.
  void refuse_large() {
    ReadyCall ready = owner_.dispatcher().check(request_of(parser_->get(), peer));
    const bool may_not = ready.call == nullptr && (ready.response.status == 401 || ready.response.status == 403);
    if (!may_not) return give_up(http::error::body_limit);
    keep_alive_ = false;
    send(std::move(ready.response));
  }

  void ask_for_body() {
    static constexpr std::string_view kGoOn = "HTTP/1.1 100 Continue\r\n\r\n";
    asio::async_write(*socket_, asio::buffer(kGoOn.data(), kGoOn.size()),
                      [self = this->shared_from_this()](error_code error, std::size_t) {
                        if (error) return self->end(error == beast::error::timeout);
                        self->read_body();
                      });
  }

  /// A file takes as long as the line needs, if something of it comes again and again.
  void read_body() {
    if (parser_->is_done()) return guarded([&] { take_request(); });
    if (takes_file_) lowest().expires_after(owner_.request_timeout());
    const auto done = [self = this->shared_from_this()](error_code error, std::size_t) {
      if (error) return self->give_up(error);
      self->guarded([&] { self->read_body(); });
    };
    if (takes_file_) {
      http::async_read_some(*socket_, buffer_, *parser_, done);
    } else {
      http::async_read(*socket_, buffer_, *parser_, done);
    }
  }

  void take_request() {
    keep_alive_ = parser_->get().keep_alive();
    lowest().expires_never();
    owner_.used(*this);
    std::string body = std::move(parser_->get().body());  // not copied: it may be large
    HttpRequest request = request_of(parser_->get(), peer);
    request.body = std::move(body);
    auto ready = std::make_shared<ReadyCall>(owner_.dispatcher().check(std::move(request)));
    if (ready->call == nullptr) return end_file(), send(std::move(ready->response));
    if (!ready->caller.user.empty()) {
      this->has_logged_in = true;
      this->user = ready->caller.user;
    }
    if (ready->call->form == Form::kStream) return upgrade(ready);
    const bool taken = owner_.run(ready, [self = this->shared_from_this(), ready](HttpResponse response) {
      self->end_file();
      self->send(std::move(response));
    });
    if (taken) return;
    end_file();
    send(Dispatcher::refusal(503, core::Code::P7713, "the server is busy: too many calls of this kind wait"));
  }

  void send(HttpResponse given) {
    if (closed_) return;
    response_ = message_of(std::move(given), keep_alive_);
    // WHY: who asks with HEAD takes a body for the begin of the next answer.
    if (head_alone_) response_.body().clear();
    serializer_.emplace(response_);
    write_some();
  }

  /// A file takes as long as the line needs, if something of it goes again and again.
  void write_some() {
    lowest().expires_after(owner_.request_timeout());
    http::async_write_some(*socket_, *serializer_, [self = this->shared_from_this()](error_code error, std::size_t) {
      if (error) return self->end(error == beast::error::timeout);
      if (!self->serializer_->is_done()) return self->write_some();
      if (self->keep_alive_) return self->wait_for_request();
      self->finish();
    });
  }

  void end_file() {
    if (std::exchange(takes_file_, false)) owner_.end_file(*this);
  }

  /// Says that no more comes, and closes: the client gets all that was sent.
  void finish() {
    lowest().expires_after(owner_.request_timeout());
    if constexpr (kTls) {
      socket_->async_shutdown([self = this->shared_from_this()](error_code) { self->end(false); });
    } else {
      error_code ignored;
      lowest().socket().shutdown(tcp::socket::shutdown_send, ignored);
      drain(kMostBodyBytes);
    }
  }

  /// WHY: closing a socket from which not everything was read resets the connection, and the answer is lost.
  void drain(std::size_t most) {
    buffer_.clear();
    socket_->async_read_some(buffer_.prepare(kReadBytes),
                             [self = this->shared_from_this(), most](error_code error, std::size_t bytes) {
                               if (error || bytes >= most || self->closed_)
                                 return self->end(error == beast::error::timeout);
                               self->drain(most - bytes);
                             });
  }

  // A WebSocket from here on.

  void upgrade(std::shared_ptr<ReadyCall> ready) {
    ready_ = std::move(ready);
    stream_ = make_stream(*ready_->call, owner_.dispatcher().context(), *ready_->request);
    web_ = std::make_unique<websocket::stream<Socket>>(std::move(*socket_));
    websocket::stream_base::timeout limits{};
    limits.handshake_timeout = std::min<std::chrono::milliseconds>(owner_.request_timeout(), kClosing);
    limits.idle_timeout = std::chrono::seconds(30);
    limits.keep_alive_pings = true;
    web_->set_option(limits);
    web_->read_message_max(kMostMessageBytes);
    web_->auto_fragment(false);
    web_->async_accept(parser_->get(), [self = this->shared_from_this()](error_code error) {
      if (error) return self->end(false);
      self->parser_.reset();
      self->read_message();
      self->tick();
    });
  }

  void read_message() {
    buffer_.clear();
    web_->async_read(buffer_, [self = this->shared_from_this()](error_code error, std::size_t) {
      if (error) return self->end(error == beast::error::timeout);
      self->guarded([&] { self->take_message(); });
    });
  }

  void take_message() {
    owner_.used(*this);
    if (++messages_ > kMessagesPerSecond || answers_.size() >= kMostAnswers || !web_->got_text())
      return refuse_stream();
    std::string text = beast::buffers_to_string(buffer_.data());
    auto work = stream_->prepare(text);
    if (!work) return answer_to(text);
    // What comes meanwhile waits in the socket.
    if (!owner_.prepare(std::move(work), [self = this->shared_from_this(), text = std::move(text)] {
          self->guarded([&] { self->answer_to(text); });
        }))
      refuse_stream();
  }

  void answer_to(std::string_view text) {
    if (closed_ || closing_) return;
    std::string answer = stream_->take(text);
    if (!answer.empty()) answers_.push_back({false, std::move(answer)});
    pump();
    read_message();
  }

  void refuse_stream() {
    if (closing_) return;
    closing_ = true;
    web_->async_close(websocket::close_code::policy_error,
                      [self = this->shared_from_this()](error_code) { self->end(false); });
  }

  void tick() {
    if (closed_ || closing_) return;
    const auto now = std::chrono::steady_clock::now();
    if (now - checked_ >= std::chrono::seconds(1)) {
      checked_ = now;
      messages_ = 0;
      if (!owner_.dispatcher().may_go_on(*ready_)) return refuse_stream();
      owner_.goes_on(*this);
    }
    pump();
    timer_.expires_after(std::chrono::nanoseconds(stream_->period_ns()));
    timer_.async_wait([self = this->shared_from_this()](error_code error) {
      if (!error) self->guarded([&] { self->tick(); });
    });
  }

  /// Sends what there is, unless something is being sent: the next frame is made when this one has gone.
  void pump() {
    if (writing_ || closed_ || closing_) return;
    if (!answers_.empty()) {
      frame_ = std::move(answers_.front());
      answers_.pop_front();
    } else if (auto next = stream_->next()) {
      frame_ = std::move(*next);
      owner_.counted_frame();
    } else {
      return;
    }
    writing_ = true;
    web_->binary(frame_.binary);
    web_->async_write(asio::buffer(frame_.bytes), [self = this->shared_from_this()](error_code error, std::size_t) {
      self->writing_ = false;
      if (error) return self->end(error == beast::error::timeout);
      if (!self->frame_.binary) self->guarded([&] { self->pump(); });
    });
  }

  std::unique_ptr<Socket> socket_;
  std::unique_ptr<websocket::stream<Socket>> web_;
  asio::steady_timer timer_;
  ClientOwner& owner_;
  beast::flat_buffer buffer_{kMostHeaderBytes + kMostBodyBytes};
  std::optional<http::request_parser<http::string_body>> parser_;
  http::response<http::string_body> response_;
  std::optional<http::response_serializer<http::string_body>> serializer_;  ///< of response_
  std::shared_ptr<ReadyCall> ready_;
  std::unique_ptr<Stream> stream_;
  std::deque<Frame> answers_;
  Frame frame_;
  std::chrono::steady_clock::time_point checked_{};
  int messages_ = 0;
  bool keep_alive_ = true, closed_ = false, closing_ = false, writing_ = false, takes_file_ = false,
       head_alone_ = false;
};

}  // namespace plc::engineering
