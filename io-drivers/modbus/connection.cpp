#include "io-drivers/modbus/connection.h"

#include <netinet/tcp.h>
#include <sys/socket.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <cstring>
#include <ctime>

namespace plc::modbus {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

// A client that is switched off is noticed after 60 + 3 * 10 s.
constexpr int kKeepAliveIdle_s = 60;
constexpr int kKeepAliveInterval_s = 10;
constexpr int kKeepAliveCount = 3;

/// What the kernel may hold for one client in either direction: some hundred answers, not its default of megabytes.
constexpr int kSocketBuffer = 64 * 1024;

/// Transaction, protocol and length: what is needed to know the size of a frame.
constexpr std::size_t kLengthEnd = 6;
constexpr std::size_t kMinLength = 2;  ///< unit and function
constexpr std::size_t kMaxLength = kMaxPdu + 1;

void set_options(Socket& socket) {
  error_code ignored;  // a socket whose peer is gone already tells so when it is read
  socket.non_blocking(true, ignored);
  socket.set_option(asio::ip::tcp::no_delay(true), ignored);
  socket.set_option(asio::socket_base::send_buffer_size(kSocketBuffer), ignored);
  socket.set_option(asio::socket_base::receive_buffer_size(kSocketBuffer), ignored);
  socket.set_option(asio::socket_base::keep_alive(true), ignored);
  ::setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_KEEPIDLE, &kKeepAliveIdle_s, sizeof kKeepAliveIdle_s);
  ::setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_KEEPINTVL, &kKeepAliveInterval_s, sizeof kKeepAliveInterval_s);
  ::setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_KEEPCNT, &kKeepAliveCount, sizeof kKeepAliveCount);
}

}  // namespace

core::TimeNs connection_clock_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC_COARSE, &now);
  return core::TimeNs{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

FrameScan scan_frame(std::span<const std::uint8_t> stream) {
  if (stream.size() < kLengthEnd) return {};
  const auto protocol = static_cast<std::size_t>(stream[2] << 8 | stream[3]);
  const auto length = static_cast<std::size_t>(stream[4] << 8 | stream[5]);
  if (protocol != 0 || length < kMinLength || length > kMaxLength) return {FrameScan::State::kBroken, 0};
  if (stream.size() < kLengthEnd + length) return {};
  return {FrameScan::State::kWhole, kLengthEnd + length};
}

Connection::Connection(Socket socket, asio::ip::address peer, Owner& owner)
    : socket_(std::move(socket)), peer_(std::move(peer)), owner_(owner), last_request_ns_(connection_clock_ns()) {}

void Connection::start() {
  set_options(socket_);
  read();
}

void Connection::close(bool dropped) {
  if (closed_) return;
  closed_ = true;
  const auto self = shared_from_this();
  owner_.closed(*this, dropped);  // first, so that a thread that sees the end of the connection sees it counted
  error_code ignored;
  socket_.close(ignored);
}

core::TimeNs Connection::owing_since_ns() const {
  return blocked_since_ns_ != 0 ? blocked_since_ns_ : partial_since_ns_;
}

void Connection::read() {
  reading_ = true;
  socket_.async_read_some(asio::buffer(in_.data() + in_size_, in_.size() - in_size_),
                          [self = shared_from_this()](const error_code& error, std::size_t bytes) {
                            if (self->closed_) return;
                            self->reading_ = false;
                            self->in_size_ += bytes;
                            if (error == asio::error::eof) {
                              self->ended_ = true;
                            } else if (error) {
                              return self->close(false);
                            }
                            self->turn();
                          });
}

void Connection::turn() {
  if (closed_) return;
  const bool in_step = answer_frames();
  if (!flush()) return close(false);
  // What the requests before the broken one got is on its way.
  if (!in_step) return close(true);
  go_on();
}

bool Connection::answer_frames() {
  std::size_t begin = 0;
  FrameScan scan;
  unsigned answered = 0;
  for (;;) {
    scan = scan_frame(std::span(in_).subspan(begin, in_size_ - begin));
    if (scan.state != FrameScan::State::kWhole || answered == kRequestsPerTurn || out_size_ >= kMaxWaiting) break;
    out_size_ += owner_.answer(std::span(in_).subspan(begin, scan.size),
                               std::span<std::uint8_t, kMaxFrame>(out_.data() + out_size_, kMaxFrame));
    begin += scan.size;
    ++answered;
  }
  in_size_ -= begin;
  if (begin != 0 && in_size_ != 0) std::memmove(in_.data(), in_.data() + begin, in_size_);

  more_whole_ = scan.state == FrameScan::State::kWhole;
  if (answered != 0) {
    has_requested_ = true;
    last_request_ns_ = connection_clock_ns();
  }
  const bool partial = scan.state == FrameScan::State::kPartial && in_size_ != 0;
  if (!partial) {
    partial_since_ns_ = 0;
  } else if (answered != 0 || partial_since_ns_ == 0) {
    partial_since_ns_ = connection_clock_ns();
  }
  return scan.state != FrameScan::State::kBroken;
}

bool Connection::flush() {
  std::size_t sent = 0;
  error_code error;
  while (sent < out_size_ && !error) {
    sent += socket_.write_some(asio::buffer(out_.data() + sent, out_size_ - sent), error);
  }
  if (error && error != asio::error::would_block) return false;
  out_size_ -= sent;
  if (sent != 0 && out_size_ != 0) std::memmove(out_.data(), out_.data() + sent, out_size_);
  if (out_size_ == 0) {
    blocked_since_ns_ = 0;
  } else if (sent != 0 || blocked_since_ns_ == 0) {
    blocked_since_ns_ = connection_clock_ns();
  }
  return true;
}

void Connection::go_on() {
  if (ended_ && !more_whole_ && out_size_ == 0) return close(false);
  if (!scheduled_ && out_size_ != 0) {
    scheduled_ = true;
    socket_.async_wait(asio::socket_base::wait_write, [self = shared_from_this()](const error_code&) {
      self->scheduled_ = false;
      self->turn();
    });
  } else if (!scheduled_ && more_whole_) {
    scheduled_ = true;
    asio::post(socket_.get_executor(), [self = shared_from_this()] {
      self->scheduled_ = false;
      self->turn();
    });
  }
  if (!reading_ && !ended_ && !more_whole_ && out_size_ < kMaxWaiting) read();
}

}  // namespace plc::modbus
