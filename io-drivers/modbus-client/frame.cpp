#include "io-drivers/modbus-client/frame.h"

#include <fmt/format.h>

#include <algorithm>

#include "io-drivers/modbus-rtu/frame.h"

namespace plc::modbus_client {
namespace {

constexpr std::uint8_t kException = 0x80;
constexpr std::uint8_t kIdentify = 0x2b, kIdentifyType = 0x0e;

void put16(Bytes& to, std::uint32_t value) {
  to.push_back(static_cast<std::uint8_t>(value >> 8));
  to.push_back(static_cast<std::uint8_t>(value));
}
std::uint16_t get16(std::span<const std::uint8_t> from, std::size_t at) {
  return static_cast<std::uint16_t>(from[at] << 8 | from[at + 1]);
}

/// By table: functions that read, write one cell, write several.
struct Functions {
  std::uint8_t read, write_one, write_many;
};
constexpr Functions kFunctions[] = {{1, 5, 15}, {2, 0, 0}, {4, 0, 0}, {3, 6, 16}};
const Functions& functions_of(ModbusTable table) { return kFunctions[static_cast<std::size_t>(table)]; }

bool reads_bits(std::uint8_t function) { return function == 1 || function == 2; }
bool reads(std::uint8_t function) { return function >= 1 && function <= 4; }

/// Bytes of the data in the answer to a read.
std::size_t data_bytes(std::span<const std::uint8_t> request) {
  const std::size_t count = get16(request, 3);
  return reads_bits(request[0]) ? (count + 7) / 8 : count * 2;
}

}  // namespace

std::string error_text(Error error) {
  switch (error) {
#define PLC_MODBUS_ERROR(name, number, text) \
  case Error::name:                          \
    return text;
#include "io-drivers/modbus-client/errors.def"
  }
  return fmt::format("exception {}", static_cast<unsigned>(error));
}

Bytes read_pdu(ModbusTable table, std::uint16_t first, std::uint16_t count) {
  Bytes pdu = {functions_of(table).read};
  put16(pdu, first);
  put16(pdu, count);
  return pdu;
}

Bytes write_pdu(ModbusTable table, std::uint16_t first, std::span<const std::uint16_t> cells, bool multiple) {
  const bool bits = is_bits(table);
  const bool one = cells.size() == 1 && !multiple;
  Bytes pdu = {one ? functions_of(table).write_one : functions_of(table).write_many};
  put16(pdu, first);
  if (one) {
    put16(pdu, !bits ? cells[0] : cells[0] != 0 ? 0xff00u : 0u);
    return pdu;
  }
  put16(pdu, static_cast<std::uint32_t>(cells.size()));
  const std::size_t bytes = bits ? (cells.size() + 7) / 8 : cells.size() * 2;
  pdu.push_back(static_cast<std::uint8_t>(bytes));
  if (!bits) {
    for (const std::uint16_t cell : cells) put16(pdu, cell);
    return pdu;
  }
  pdu.resize(pdu.size() + bytes);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (cells[i] != 0) pdu[6 + i / 8] = static_cast<std::uint8_t>(pdu[6 + i / 8] | 1u << i % 8);
  }
  return pdu;
}

Bytes identify_pdu() { return {kIdentify, kIdentifyType, 1, 0}; }

Error parse_answer(std::span<const std::uint8_t> request, std::span<const std::uint8_t> answer, Cells& cells) {
  cells.clear();
  if (answer.empty()) return Error::kWrongAnswer;
  if (answer[0] == (request[0] | kException)) {
    if (answer.size() != 2 || answer[1] == 0) return Error::kWrongAnswer;
    return static_cast<Error>(answer[1]);
  }
  if (answer[0] != request[0]) return Error::kWrongAnswer;
  if (!reads(request[0])) {
    // Function, address, and value or quantity come back as they were.
    const bool same = answer.size() == 5 && std::equal(answer.begin(), answer.end(), request.begin());
    return same ? Error::kNone : Error::kWrongAnswer;
  }
  const std::size_t bytes = data_bytes(request);
  if (answer.size() != 2 + bytes || answer[1] != bytes) return Error::kWrongAnswer;
  const std::size_t count = get16(request, 3);
  cells.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    cells.push_back(static_cast<std::uint16_t>(reads_bits(request[0]) ? (answer[2 + i / 8] >> i % 8) & 1u
                                                                      : get16(answer, 2 + 2 * i)));
  }
  return Error::kNone;
}

std::optional<std::vector<std::string>> parse_identity(std::span<const std::uint8_t> answer) {
  // Function, type, code, conformity, more follows, next object, number of objects; then id, length, text of each.
  if (answer.size() < 7 || answer[0] != kIdentify || answer[1] != kIdentifyType) return std::nullopt;
  std::vector<std::string> texts;
  std::size_t at = 7;
  for (int left = answer[6]; left > 0; --left) {
    if (at + 2 > answer.size() || at + 2 + answer[at + 1] > answer.size()) return std::nullopt;
    std::string text;
    for (const std::uint8_t c : answer.subspan(at + 2, answer[at + 1])) {
      text += c >= 0x20 && c < 0x7f ? static_cast<char>(c) : '?';
    }
    texts.push_back(std::move(text));
    at += 2 + answer[at + 1];
  }
  return texts;
}

Bytes tcp_frame(std::uint16_t transaction, std::uint8_t unit, std::span<const std::uint8_t> pdu) {
  Bytes frame;
  frame.reserve(7 + pdu.size());
  put16(frame, transaction);
  put16(frame, 0);
  put16(frame, static_cast<std::uint32_t>(pdu.size() + 1));
  frame.push_back(unit);
  frame.insert(frame.end(), pdu.begin(), pdu.end());
  return frame;
}

Progress parse_tcp(std::span<const std::uint8_t> bytes, std::uint16_t transaction, std::uint8_t unit,
                   std::span<const std::uint8_t>& answer) {
  // Wrong as soon as it shows: a peer that sends slowly must not hold the bus with a frame that is none.
  if (bytes.size() >= 2 && get16(bytes, 0) != transaction) return Progress::kWrong;
  if (bytes.size() >= 4 && get16(bytes, 2) != 0) return Progress::kWrong;
  if (bytes.size() < 6) return Progress::kMore;
  const std::size_t length = get16(bytes, 4);
  if (length < 2 || length > kMaxPdu + 1) return Progress::kWrong;
  if (bytes.size() >= 7 && bytes[6] != unit) return Progress::kWrong;
  if (bytes.size() < 6 + length) return Progress::kMore;
  if (bytes.size() > 6 + length) return Progress::kWrong;  // nobody asked for more
  answer = bytes.subspan(7, length - 1);
  return Progress::kComplete;
}

Bytes rtu_frame(std::uint8_t unit, std::span<const std::uint8_t> pdu) {
  Bytes frame = {unit};
  frame.insert(frame.end(), pdu.begin(), pdu.end());
  frame.resize(frame.size() + modbus_rtu::kChecksum);
  modbus_rtu::seal(frame);
  return frame;
}

Progress parse_rtu(std::span<const std::uint8_t> bytes, std::uint8_t unit, std::span<const std::uint8_t> request,
                   std::span<const std::uint8_t>& answer) {
  // Wrong as soon as it shows, as in parse_tcp().
  if (!bytes.empty() && bytes[0] != unit) return Progress::kWrong;
  if (bytes.size() >= 2 && (bytes[1] & ~kException) != request[0]) return Progress::kWrong;
  const std::size_t size = modbus_rtu::answer_size(bytes);
  if (size == modbus_rtu::kNotKnownYet) return Progress::kMore;
  // Unit, function, number of bytes, checksum.
  if (bytes[1] == request[0] && reads(request[0]) && size != 5 + data_bytes(request)) return Progress::kWrong;
  if (size == modbus_rtu::kNeverKnown || bytes.size() > size) return Progress::kWrong;
  if (bytes.size() < size) return Progress::kMore;
  if (!modbus_rtu::is_sealed(bytes)) return Progress::kWrong;
  answer = bytes.subspan(1, size - 1 - modbus_rtu::kChecksum);
  return Progress::kComplete;
}

}  // namespace plc::modbus_client
