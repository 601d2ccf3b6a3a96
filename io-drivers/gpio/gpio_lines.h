// GpioLines: lines of one GPIO chip, requested as a driver needs them.
//
// In: chip (name, label or path), lines (offset or name) with direction, bias, polarity, drive, edges. Out: values of
// all inputs and outputs, each side in the order it was asked for. GpioLines is abstract so that tests can stand in for
// a chip; libgpiod is behind gpio_chip.h. Does not belong here: variables, inversion by the program, what happens when
// the chip is gone.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"

namespace plc::io {

enum class Bias : std::uint8_t { kAsIs, kDisabled, kPullUp, kPullDown };
enum class Drive : std::uint8_t { kPushPull, kOpenDrain, kOpenSource };
/// Which edges of an input are remembered between two reads, as the value goes (after active-low).
enum class LineEdge : std::uint8_t { kNone, kRising, kFalling };

struct LineSpec {
  std::string line;      ///< offset ("17") or name ("RELAY1")
  std::string variable;  ///< for messages
  bool active_low = false;
  Bias bias = Bias::kAsIs;
  LineEdge edge = LineEdge::kNone;  ///< inputs
  Drive drive = Drive::kPushPull;   ///< outputs
  bool initial = false;             ///< outputs: value from the request on
};

struct LinesRequest {
  std::string chip;  ///< "gpiochip0", a label, "/dev/gpiochip0"
  std::vector<LineSpec> inputs;
  std::vector<LineSpec> outputs;
};

/// One input at a read.
struct LineInput {
  std::uint8_t value = 0;  ///< 0 or 1
  bool edge = false;       ///< the edge asked for happened since the last read
};

/// Requested lines. One thread at a time. The destructor gives the lines back.
class GpioLines {
 public:
  virtual ~GpioLines() = default;
  /// Values of all inputs, as many as requested. 0, or the errno of the first call that failed. RT: one ioctl per group
  /// of up to 64 lines with equal settings; one ioctl and one read that does not wait per line with an edge.
  virtual int read(std::span<LineInput> inputs) noexcept = 0;
  /// Sets all outputs (0 or 1), as many as requested. Tries every group; 0, or the first errno. RT: one ioctl per
  /// group.
  virtual int write(std::span<const std::uint8_t> outputs) noexcept = 0;
  /// Whether the device is gone for good: these lines will never work again. Not RT.
  [[nodiscard]] virtual bool gone() noexcept = 0;
};

/// How lines are checked and requested: the kernel's, or a test's.
struct GpioAccess {
  /// Whether open() would succeed, as far as one can tell without touching a line.
  std::function<std::optional<core::Problem>(const LinesRequest&)> check;
  /// All lines or none: names and use of all are checked first, then inputs are requested, then outputs.
  std::function<core::Result<std::unique_ptr<GpioLines>>(const LinesRequest&)> open;
};

/// The kernel's character devices, through libgpiod.
GpioAccess kernel_gpio();

/// Most lines of one direction a request can hold (GPIO ABI: 64); groups of more are split.
inline constexpr std::size_t kMostLinesPerGroup = 64;

}  // namespace plc::io
