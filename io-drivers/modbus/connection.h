// Connection: one Modbus/TCP client: frames cut out of its stream, answers sent back in order.
//
// In: a connected socket, a function that answers requests. Out: answers. Bounded in both directions: what does not fit
// is left in the socket, and a client that takes no answers is not read from. A turn answers at most kRequestsPerTurn
// requests, so that no client starves the others. Threads: the server's I/O thread. Does not belong here: who may
// connect, PDUs.
#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "core/clock.h"
#include "io-drivers/modbus/pdu.h"

namespace plc::modbus {

/// Head of a frame (MBAP): transaction, protocol, length, unit.
inline constexpr std::size_t kFrameHead = 7;
inline constexpr std::size_t kMaxFrame = kFrameHead + kMaxPdu;

/// What is at the beginning of a stream.
struct FrameScan {
  enum class State : std::uint8_t {
    kPartial,  ///< more bytes are needed
    kWhole,    ///< a frame of `size` bytes
    kBroken,   ///< protocol id not 0 or a length that no frame has: where the next frame begins is unknown
  };
  State state = State::kPartial;
  std::size_t size = 0;
};
FrameScan scan_frame(std::span<const std::uint8_t> stream);

/// Now, on the clock that all times of connections are of: to some milliseconds, which time-outs can do with.
core::TimeNs connection_clock_ns();

/// With the executor that is always meant, instead of one that hides which.
using Executor = boost::asio::io_context::executor_type;
using Socket = boost::asio::basic_stream_socket<boost::asio::ip::tcp, Executor>;

class Connection : public std::enable_shared_from_this<Connection> {
 public:
  class Owner {
   public:
    /// Writes the answer to a whole frame into `answer` and returns its size, 0 for silence.
    virtual std::size_t answer(std::span<const std::uint8_t> frame, std::span<std::uint8_t, kMaxFrame> answer) = 0;
    /// `connection` is about to close its socket; `dropped` when it was the server that gave up.
    virtual void closed(Connection& connection, bool dropped) = 0;

   protected:
    ~Owner() = default;
  };
  static constexpr unsigned kRequestsPerTurn = 32;

  Connection(Socket socket, boost::asio::ip::address peer, Owner& owner);

  /// Sets the socket's options and begins to read.
  void start();
  /// Closes the socket; once.
  void close(bool dropped);

  [[nodiscard]] const boost::asio::ip::address& peer() const { return peer_; }
  /// When its last request was answered, or it was accepted.
  [[nodiscard]] core::TimeNs last_request_ns() const { return last_request_ns_; }
  [[nodiscard]] bool has_requested() const { return has_requested_; }
  /// Since when the client owes the rest of a frame, or the taking of an answer; 0 = it owes nothing.
  [[nodiscard]] core::TimeNs owing_since_ns() const;

 private:
  static constexpr std::size_t kReadChunk = 4096;
  static constexpr std::size_t kMaxWaiting = 8192;  ///< bytes of answers; beyond it nothing is read

  void read();
  void turn();
  /// Answers whole frames; false when the stream is broken.
  bool answer_frames();
  /// Sends what the socket takes; false when the connection is lost.
  bool flush();
  void go_on();

  Socket socket_;
  boost::asio::ip::address peer_;
  Owner& owner_;
  std::array<std::uint8_t, kMaxFrame + kReadChunk> in_;
  std::array<std::uint8_t, kMaxWaiting + kMaxFrame> out_;
  std::size_t in_size_ = 0;
  std::size_t out_size_ = 0;
  core::TimeNs last_request_ns_;
  core::TimeNs partial_since_ns_ = 0;
  core::TimeNs blocked_since_ns_ = 0;
  bool has_requested_ = false;
  bool more_whole_ = false;  ///< in_ begins with a whole frame that waits for the next turn
  bool ended_ = false;       ///< the client will send nothing more
  bool reading_ = false;
  bool scheduled_ = false;  ///< another turn will come: posted, or when the socket takes more
  bool closed_ = false;
};

}  // namespace plc::modbus
