// RTU frames: unit, PDU, checksum; and how long a frame is, which only its function tells.
//
// In: bytes of a line. Out: sizes, checksums. Pure, allocates nothing. Does not belong here: when a frame ends
// (request_stream.h), what PDUs mean.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace plc::modbus_rtu {

inline constexpr std::size_t kMaxFrame = 256;
inline constexpr std::size_t kChecksum = 2;
/// Unit, function, checksum.
inline constexpr std::size_t kMinFrame = 4;

std::uint16_t crc16(std::span<const std::uint8_t> bytes);
/// Puts the checksum of all other bytes into the last two.
void seal(std::span<std::uint8_t> frame);
/// Whether the last two bytes are the checksum of all others.
bool is_sealed(std::span<const std::uint8_t> frame);

inline constexpr std::size_t kNotKnownYet = 0;     ///< more bytes tell it
inline constexpr std::size_t kNeverKnown = 10000;  ///< of this function, or it is more than a frame has
/// Size of the request, or the answer, that begins with these bytes, unit to checksum.
std::size_t request_size(std::span<const std::uint8_t> bytes);
std::size_t answer_size(std::span<const std::uint8_t> bytes);

}  // namespace plc::modbus_rtu
