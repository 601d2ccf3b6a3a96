// Requests and answers of Modbus as bytes: PDUs, and the frames of TCP and RTU around them.
//
// In: what is to be read or written; bytes of a peer that may send anything. Out: bytes to send; cells, or what is
// wrong. A cell is a bit (0 or 1) or a register. Follows the Modbus application protocol V1.1b3. Does not
// belong here: sockets and lines (link.h), what cells mean (codec.h), checksums (modbus-rtu/frame.h).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io-drivers/config/configuration.h"

namespace plc::modbus_client {

using Bytes = std::vector<std::uint8_t>;
using Cells = std::vector<std::uint16_t>;
using io::ModbusTable;

/// Other exceptions than those of errors.def keep their number.
enum class Error : std::uint16_t {
#define PLC_MODBUS_ERROR(name, number, text) name = number,
#include "io-drivers/modbus-client/errors.def"
};
/// "exception 2: it has no such address".
std::string error_text(Error error);
/// The device answered, and refused.
constexpr bool is_exception(Error error) { return error != Error::kNone && static_cast<std::uint16_t>(error) < 256; }

constexpr bool is_bits(ModbusTable table) {
  return table == ModbusTable::kCoils || table == ModbusTable::kDiscreteInputs;
}
constexpr bool is_writable(ModbusTable table) {
  return table == ModbusTable::kCoils || table == ModbusTable::kHoldingRegisters;
}
// The most that one request may ask for (V1.1b3, 6).
inline constexpr std::uint16_t kMaxReadRegisters = 125, kMaxReadBits = 2000;
inline constexpr std::uint16_t kMaxWriteRegisters = 123, kMaxWriteBits = 1968;
inline constexpr std::size_t kMaxPdu = 253;

Bytes read_pdu(ModbusTable table, std::uint16_t first, std::uint16_t count);
/// Functions 5 and 6 for one cell unless `multiple`, else 15 and 16.
Bytes write_pdu(ModbusTable table, std::uint16_t first, std::span<const std::uint16_t> cells, bool multiple);
/// Function 43/14: who the device is; objects 0 to 2.
Bytes identify_pdu();

/// What the answer says to the request: cells of a read; none of a write.
Error parse_answer(std::span<const std::uint8_t> request, std::span<const std::uint8_t> answer, Cells& cells);
/// Vendor, product and version of an answer to identify_pdu(); nothing when it is not one.
std::optional<std::vector<std::string>> parse_identity(std::span<const std::uint8_t> answer);

/// How much of an answer is there.
enum class Progress : std::uint8_t { kMore, kComplete, kWrong };

/// "Modbus messaging on TCP/IP" V1.0b, 3.1.3.
Bytes tcp_frame(std::uint16_t transaction, std::uint8_t unit, std::span<const std::uint8_t> pdu);
/// Looks at what came so far. kComplete: `answer` is the PDU.
Progress parse_tcp(std::span<const std::uint8_t> bytes, std::uint16_t transaction, std::uint8_t unit,
                   std::span<const std::uint8_t>& answer);

Bytes rtu_frame(std::uint8_t unit, std::span<const std::uint8_t> pdu);
/// As parse_tcp(); RTU frames do not say how long they are: the request does.
Progress parse_rtu(std::span<const std::uint8_t> bytes, std::uint8_t unit, std::span<const std::uint8_t> request,
                   std::span<const std::uint8_t>& answer);

}  // namespace plc::modbus_client
