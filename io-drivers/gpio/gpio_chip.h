// GpioChip: what libgpiod gives, the same for its versions: an open chip, what it tells, lines requested of it.
//
// In: paths, offsets, settings. Out: names, values, errno. libgpiod1.cpp and libgpiod2.cpp are the only files that know
// libgpiod; one of them is built. Does not belong here: which chip and which lines are meant, messages
// (gpio_lines.cpp).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tuple>

#include "core/clock.h"
#include "io-drivers/gpio/gpio_lines.h"

namespace plc::io {

/// What the others see as the user of our lines.
inline constexpr const char* kGpioConsumer = "plc-run";

struct LineFacts {
  std::string name, consumer;
  bool used = false;
};

/// Of all lines of a group.
struct LineSettings {
  bool output = false;
  bool active_low = false;
  Bias bias = Bias::kAsIs;
  LineEdge edge = LineEdge::kNone;
  Drive drive = Drive::kPushPull;
  /// Any order: for maps.
  bool operator<(const LineSettings& other) const {
    return std::tie(output, active_low, bias, edge, drive) <
           std::tie(other.output, other.active_low, other.bias, other.edge, other.drive);
  }
};

/// Up to kMostLinesPerGroup lines that were requested together. The destructor gives them back.
class LineGroup {
 public:
  virtual ~LineGroup() = default;
  /// Values of all lines, 0 or 1. 0, or errno. RT: one ioctl.
  virtual int read(std::span<std::uint8_t> values) noexcept = 0;
  /// Sets all lines. 0, or errno. RT: one ioctl.
  virtual int write(std::span<const std::uint8_t> values) noexcept = 0;
  /// Takes all edges that the kernel kept. When it saw the newest, on CLOCK_MONOTONIC; 0 when there was none; -errno.
  /// RT: one read that does not wait.
  virtual core::TimeNs take_edges() noexcept = 0;
};

class GpioChip {
 public:
  virtual ~GpioChip() = default;
  [[nodiscard]] virtual std::string name() const = 0;  ///< "gpiochip0"
  [[nodiscard]] virtual std::string label() const = 0;
  [[nodiscard]] virtual unsigned line_count() const = 0;
  /// Asks the kernel; nothing, with errno, when the line cannot be asked. Nothing moves on the line or a bus.
  [[nodiscard]] virtual std::optional<LineFacts> facts(unsigned line) noexcept = 0;
  /// `initial`: values of outputs from now on, as many as lines. Null with errno.
  virtual std::unique_ptr<LineGroup> request(const LineSettings& settings, std::span<const unsigned> lines,
                                             std::span<const std::uint8_t> initial) = 0;
};

/// Null with errno. `path`: of the node in /dev, or of a link to it.
std::unique_ptr<GpioChip> open_gpio_chip(const std::string& path);

}  // namespace plc::io
