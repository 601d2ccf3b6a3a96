#include "io-drivers/modbus-rtu/frame.h"

namespace plc::modbus_rtu {
namespace {

constexpr std::uint8_t kException = 0x80;

/// What is before `at`, the byte there, which counts what follows it, and the checksum.
std::size_t counted(std::span<const std::uint8_t> bytes, std::size_t at) {
  return bytes.size() > at ? at + 1 + bytes[at] + kChecksum : kNotKnownYet;
}
std::size_t limited(std::size_t size) { return size > kMaxFrame ? kNeverKnown : size; }

/// Function 43/14: each object says how long it is.
std::size_t identity_size(std::span<const std::uint8_t> bytes) {
  // Unit, function, type, code, conformity, more follows, next object, number of objects; then id, length, text of
  // each.
  constexpr std::size_t kCount = 7;
  if (bytes.size() <= kCount) return kNotKnownYet;
  std::size_t at = kCount + 1;
  for (unsigned left = bytes[kCount]; left > 0 && at <= kMaxFrame; --left) {
    if (bytes.size() < at + 2) return kNotKnownYet;
    at += 2u + bytes[at + 1];
  }
  return at + kChecksum;
}

}  // namespace

std::uint16_t crc16(std::span<const std::uint8_t> bytes) {
  std::uint16_t crc = 0xffff;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) {
      const bool low = (crc & 1u) != 0;
      crc = static_cast<std::uint16_t>(crc >> 1 ^ (low ? 0xa001u : 0u));
    }
  }
  return crc;
}

void seal(std::span<std::uint8_t> frame) {
  const std::uint16_t crc = crc16(frame.first(frame.size() - kChecksum));
  frame[frame.size() - 2] = static_cast<std::uint8_t>(crc);
  frame[frame.size() - 1] = static_cast<std::uint8_t>(crc >> 8);
}

bool is_sealed(std::span<const std::uint8_t> frame) {
  if (frame.size() < kMinFrame) return false;
  const std::uint16_t crc = crc16(frame.first(frame.size() - kChecksum));
  return frame[frame.size() - 2] == (crc & 0xff) && frame[frame.size() - 1] == crc >> 8;
}

std::size_t request_size(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < 2) return kNotKnownYet;
  switch (bytes[1]) {  // "Modbus application protocol" V1.1b3, 6
    case 1:
    case 2:
    case 3:
    case 4:
    case 5:
    case 6:
    case 8:
      return 8;
    case 7:
    case 11:
    case 12:
    case 17:
      return 4;
    case 15:
    case 16:
      return limited(counted(bytes, 6));
    case 20:
    case 21:
      return limited(counted(bytes, 2));
    case 22:
      return 10;
    case 23:
      return limited(counted(bytes, 10));
    case 24:
      return 6;
    case 43:
      return 7;
    default:
      return kNeverKnown;
  }
}

std::size_t answer_size(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < 2) return kNotKnownYet;
  if ((bytes[1] & kException) != 0) return 5;
  switch (bytes[1]) {
    case 1:
    case 2:
    case 3:
    case 4:
    case 12:
    case 17:
    case 20:
    case 21:
    case 23:
      return limited(counted(bytes, 2));
    case 5:
    case 6:
    case 8:
    case 11:
    case 15:
    case 16:
      return 8;
    case 7:
      return 5;
    case 22:
      return 10;
    case 43:
      return limited(identity_size(bytes));
    default:
      return kNeverKnown;
  }
}

}  // namespace plc::modbus_rtu
