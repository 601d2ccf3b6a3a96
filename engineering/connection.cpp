#include "engineering/connection.h"

#include <boost/asio/buffer.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/error.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <deque>
#include <exception>
#include <optional>
#include <string_view>
#include <utility>

#include "engineering/client_socket.h"
#include "engineering/http.h"
#include "engineering/streams.h"

namespace plc::engineering {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;

/// Nothing is compressed: frames are small, and their bytes hardly repeat.
using WebSocket = websocket::stream<ClientSocket, false>;

class Connection final : public Client, public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket socket, asio::ssl::context* context, ClientOwner& owner)
      : socket_(std::move(socket), context), tcp_(socket_.next_layer()), timer_(tcp_.get_executor()), owner_(owner) {}

  void start() override {
    tcp_.expires_after(owner_.request_timeout());
    socket_.handshake(Completion([self = shared_from_this()](error_code error) {
      if (error) return self->end(true);
      self->wait_for_request();
    }));
  }

  void close() override {
    if (closed_) return;
    closed_ = true;
    timer_.cancel();
    error_code ignored;
    tcp_.socket().close(ignored);
  }

 private:
  static constexpr std::size_t kMostAnswers = 16;
  static constexpr std::size_t kReadBytes = 16'384;
  static constexpr int kMessagesPerSecond = 20;
  /// For the last frames of a WebSocket.
  static constexpr std::chrono::milliseconds kClosing{3000};

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
    tcp_.expires_after(owner_.idle_timeout());
    socket_.async_read_some(buffer_.prepare(kReadBytes),
                            [self = shared_from_this()](error_code error, std::size_t bytes) {
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
    tcp_.expires_after(owner_.request_timeout());
    http::async_read_header(socket_, buffer_, *parser_, [self = shared_from_this()](error_code error, std::size_t) {
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
    if (takes_file_) has_logged_in = true;
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
    asio::async_write(socket_, asio::buffer(kGoOn.data(), kGoOn.size()),
                      [self = shared_from_this()](error_code error, std::size_t) {
                        if (error) return self->end(error == beast::error::timeout);
                        self->read_body();
                      });
  }

  /// A file takes as long as the line needs, if something of it comes again and again.
  void read_body() {
    if (parser_->is_done()) return guarded([&] { take_request(); });
    if (takes_file_) tcp_.expires_after(owner_.request_timeout());
    const auto done = [self = shared_from_this()](error_code error, std::size_t) {
      if (error) return self->give_up(error);
      self->guarded([&] { self->read_body(); });
    };
    if (takes_file_) {
      http::async_read_some(socket_, buffer_, *parser_, done);
    } else {
      http::async_read(socket_, buffer_, *parser_, done);
    }
  }

  void take_request() {
    keep_alive_ = parser_->get().keep_alive();
    tcp_.expires_never();
    owner_.used(*this);
    std::string body = std::move(parser_->get().body());  // not copied: it may be large
    HttpRequest request = request_of(parser_->get(), peer);
    request.body = std::move(body);
    auto ready = std::make_shared<ReadyCall>(owner_.dispatcher().check(std::move(request)));
    if (ready->call == nullptr) return end_file(), send(std::move(ready->response));
    if (!ready->caller.user.empty()) {
      has_logged_in = true;
      user = ready->caller.user;
    }
    if (ready->call->form == Form::kStream) return upgrade(ready);
    const bool taken = owner_.run(ready, [self = shared_from_this(), ready](HttpResponse response) {
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
    tcp_.expires_after(owner_.request_timeout());
    http::async_write_some(socket_, *serializer_, [self = shared_from_this()](error_code error, std::size_t) {
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
    tcp_.expires_after(owner_.request_timeout());
    socket_.shut_down(Completion([self = shared_from_this()](error_code) {
      if (self->socket_.has_tls()) return self->end(false);
      self->drain(kMostBodyBytes);
    }));
  }

  /// WHY: closing a socket from which not everything was read resets the connection, and the answer is lost.
  void drain(std::size_t most) {
    buffer_.clear();
    socket_.async_read_some(buffer_.prepare(kReadBytes),
                            [self = shared_from_this(), most](error_code error, std::size_t bytes) {
                              if (error || bytes >= most || self->closed_)
                                return self->end(error == beast::error::timeout);
                              self->drain(most - bytes);
                            });
  }

  // A WebSocket from here on.

  void upgrade(std::shared_ptr<ReadyCall> ready) {
    ready_ = std::move(ready);
    stream_ = make_stream(*ready_->call, owner_.dispatcher().context(), *ready_->request);
    web_ = std::make_unique<WebSocket>(std::move(socket_));
    websocket::stream_base::timeout limits{};
    limits.handshake_timeout = std::min<std::chrono::milliseconds>(owner_.request_timeout(), kClosing);
    limits.idle_timeout = std::chrono::seconds(30);
    limits.keep_alive_pings = true;
    web_->set_option(limits);
    web_->read_message_max(kMostMessageBytes);
    web_->auto_fragment(false);
    web_->async_accept(parser_->get(), [self = shared_from_this()](error_code error) {
      if (error) return self->end(false);
      self->parser_.reset();
      self->read_message();
      self->tick();
    });
  }

  void read_message() {
    buffer_.clear();
    web_->async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
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
    if (!owner_.prepare(std::move(work), [self = shared_from_this(), text = std::move(text)] {
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
                      [self = shared_from_this()](error_code) { self->end(false); });
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
    timer_.async_wait([self = shared_from_this()](error_code error) {
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
    web_->async_write(asio::buffer(frame_.bytes), [self = shared_from_this()](error_code error, std::size_t) {
      self->writing_ = false;
      if (error) return self->end(error == beast::error::timeout);
      if (!self->frame_.binary) self->guarded([&] { self->pump(); });
    });
  }

  ClientSocket socket_;  ///< until it becomes a WebSocket
  beast::tcp_stream& tcp_;
  std::unique_ptr<WebSocket> web_;
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

}  // namespace

std::shared_ptr<Client> make_connection(tcp::socket socket, asio::ssl::context* context, ClientOwner& owner) {
  return std::make_shared<Connection>(std::move(socket), context, owner);
}

}  // namespace plc::engineering
