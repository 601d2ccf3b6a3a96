// Stream: what one WebSocket carries. The newest, never a queue: a client that reads slowly gets fewer frames.
//
// In: texts of the client, the clock. Out: a text or binary frame when there is something new, made when it can be
// sent. Threads: that of the connections. Does not belong here: sockets (server.cpp).
//
// A frame of values, little-endian; at least one a second, also when no value has changed:
//   u8   1, the version of this form
//   u8   1 when the frame has all values, as the first one after a subscription has; else 0
//   u16  number of the subscription, as the answer to it says
//   u32  values in the layout: n
//   u64  scans of the fastest task so far
//   i64  date and time, ns since 1970, UTC
//   ..   n bits in bytes, the first value in the lowest bit: which values follow
//   ..   those values one after another, as in the layout: numbers and BOOL (0, 1) of their size; STRING and CHAR as
//   u16
//        with the number of bytes, then UTF-8; times and dates as i64 in ns
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "engineering/context.h"

namespace plc::engineering {

struct Frame {
  bool binary = false;
  std::string bytes;
};

class Stream {
 public:
  virtual ~Stream() = default;
  /// What of taking this message takes long, for any thread, while the stream goes on or has gone: take() of the same
  /// message follows. Null: nothing does.
  virtual std::function<void()> prepare(std::string_view /*text*/) { return {}; }
  /// A message of the client. The answer, or an empty text.
  virtual std::string take(std::string_view text) = 0;
  /// The newest, or nothing new. Between two calls at least period_ns() pass.
  virtual std::optional<Frame> next() = 0;
  [[nodiscard]] virtual core::TimeNs period_ns() const = 0;
};

/// The stream of a row of the form kStream; `request` is good.
std::unique_ptr<Stream> make_stream(const Call& call, Context& context, const Json& request);

/// Largest message of a client.
inline constexpr std::size_t kMostMessageBytes = 1'048'576;

}  // namespace plc::engineering
