// Serial lines as Modbus RTU uses them: settings, opening, the times that depend on the speed.
//
// In: "19200 8E1", a path. Out: a descriptor that nobody else opens meanwhile, silences. Follows "Modbus over serial
// line" V1.02. Does not belong here: frames (frame.h), who asks and who answers.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/clock.h"

namespace plc::modbus_rtu {

enum class Parity : std::uint8_t { kNone, kEven, kOdd };

/// "19200 8E1".
struct LineSettings {
  std::uint32_t baud = 19200;
  std::uint8_t data_bits = 8;
  Parity parity = Parity::kEven;
  std::uint8_t stop_bits = 1;
  bool operator==(const LineSettings&) const = default;
};
/// RTU has 8 data bits; nothing when the text is not such settings, or of a speed that Linux does not have.
std::optional<LineSettings> parse_line(std::string_view text);

/// Between two frames: 3.5 characters, and 1.75 ms above 19200 baud (2.5.1.1).
core::TimeNs silence_ns(const LineSettings& line);
/// How long so many characters take, each of 11 bits.
core::TimeNs characters_ns(const LineSettings& line, std::size_t count);
/// The longest pause inside of a frame that is seen: a USB adapter hands on what came every 16 ms.
/// WHY not 1.5 characters, as the standard has it: what a process reads in pieces came without a pause over the line.
inline constexpr core::TimeNs kLongestPauseNs = 20'000'000;

/// A descriptor in raw mode, non-blocking; other processes cannot open the line meanwhile. -errno: it cannot be had.
int open_line(const std::string& path, const LineSettings& line);

}  // namespace plc::modbus_rtu
