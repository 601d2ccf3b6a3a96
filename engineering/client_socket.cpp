#include "engineering/client_socket.h"

#include <boost/beast/ssl.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <boost/beast/websocket/teardown.hpp>

namespace plc::engineering {

namespace beast = boost::beast;
using boost::asio::ip::tcp;
using boost::system::error_code;

struct ClientSocket::Plain final : ClientSocket::Layers {
  explicit Plain(tcp::socket socket) : stream(std::move(socket)) {}

  beast::tcp_stream& tcp() override { return stream; }
  void handshake(Completion done) override { done({}); }
  void shut_down(Completion done) override {
    error_code error;
    stream.socket().shutdown(tcp::socket::shutdown_send, error);
    done(error);
  }
  void tear_down(beast::role_type role, Completion done) override {
    beast::websocket::async_teardown(role, stream.socket(), std::move(done));
  }
  [[nodiscard]] bool has_tls() const override { return false; }
  void read(boost::asio::mutable_buffer into, Completion done) override {
    stream.async_read_some(into, std::move(done));
  }
  void write(const GatheredBuffers& bytes, Completion done) override {
    stream.async_write_some(bytes, std::move(done));
  }

  beast::tcp_stream stream;
};

struct ClientSocket::Tls final : ClientSocket::Layers {
  Tls(tcp::socket socket, boost::asio::ssl::context& context) : stream(std::move(socket), context) {}

  beast::tcp_stream& tcp() override { return stream.next_layer(); }
  void handshake(Completion done) override {
    stream.async_handshake(boost::asio::ssl::stream_base::server, std::move(done));
  }
  void shut_down(Completion done) override { stream.async_shutdown(std::move(done)); }
  void tear_down(beast::role_type role, Completion done) override { async_teardown(role, stream, std::move(done)); }
  [[nodiscard]] bool has_tls() const override { return true; }
  void read(boost::asio::mutable_buffer into, Completion done) override {
    stream.async_read_some(into, std::move(done));
  }
  void write(const GatheredBuffers& bytes, Completion done) override {
    stream.async_write_some(bytes, std::move(done));
  }

  beast::ssl_stream<beast::tcp_stream> stream;
};

ClientSocket::ClientSocket(tcp::socket socket, boost::asio::ssl::context* context) {
  if (context != nullptr) {
    layers_ = std::make_unique<Tls>(std::move(socket), *context);
  } else {
    layers_ = std::make_unique<Plain>(std::move(socket));
  }
}

}  // namespace plc::engineering
