#include "io-drivers/modbus/pdu.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace plc::modbus {
namespace {

enum Function : std::uint8_t {
  kReadCoils = 1,
  kReadDiscreteInputs = 2,
  kReadHoldingRegisters = 3,
  kReadInputRegisters = 4,
  kWriteSingleCoil = 5,
  kWriteSingleRegister = 6,
  kWriteMultipleCoils = 15,
  kWriteMultipleRegisters = 16,
  kMaskWriteRegister = 22,
  kReadWriteRegisters = 23,
  kEncapsulated = 43,
};

// Largest quantities (MODBUS Application Protocol V1.1b3, 6.1 .. 6.17).
constexpr std::uint32_t kMaxReadBits = 2000;
constexpr std::uint32_t kMaxReadRegisters = 125;
constexpr std::uint32_t kMaxWriteBits = 1968;
constexpr std::uint32_t kMaxWriteRegisters = 123;
constexpr std::uint32_t kMaxReadWriteWritten = 121;

// Function 43/14.
constexpr std::uint8_t kReadDeviceIdentification = 14;
constexpr std::uint8_t kConformity = 0x82;  ///< regular identification, stream and individual access
constexpr std::uint8_t kOneObject = 4;
constexpr std::uint8_t kLastBasic = 2;
constexpr std::uint8_t kLastRegular = 6;
constexpr std::size_t kIdentificationHead = 7;
/// So that any object fits into an answer of its own: head, id and length before it.
constexpr std::size_t kMaxObject = kMaxPdu - kIdentificationHead - 2;

std::uint32_t word(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint32_t>(bytes[at] << 8 | bytes[at + 1]);
}

bool is_between(std::uint32_t value, std::uint32_t low, std::uint32_t high) { return value >= low && value <= high; }

bool writes(std::uint8_t function) {
  switch (function) {
    case kWriteSingleCoil:
    case kWriteSingleRegister:
    case kWriteMultipleCoils:
    case kWriteMultipleRegisters:
    case kMaskWriteRegister:
    case kReadWriteRegisters:
      return true;
    default:
      return false;
  }
}

}  // namespace

PduHandler::PduHandler(ProcessData& data, Identification identification, bool read_only)
    : data_(data), identification_(std::move(identification)), read_only_(read_only) {
  for (std::string& text : identification_) text.resize(std::min(text.size(), kMaxObject));
}

std::size_t PduHandler::handle(Request request, Response response) {
  const std::uint8_t function = request.empty() ? std::uint8_t{0} : request[0];
  std::size_t size = 1;
  const Exception exception =
      read_only_ && writes(function) ? Exception::kIllegalFunction : dispatch(request, response, size);
  response[0] = function;
  if (exception == Exception::kNone) return size;
  response[0] = static_cast<std::uint8_t>(function | 0x80);
  response[1] = static_cast<std::uint8_t>(exception);
  return 2;
}

Exception PduHandler::dispatch(Request request, Response response, std::size_t& size) {
  // Writes answer with what they were asked: all of it, or the address and the quantity of several.
  const auto echo = [&](Exception result, std::size_t bytes) {
    if (result == Exception::kNone) {
      std::memcpy(response.data(), request.data(), bytes);
      size = bytes;
    }
    return result;
  };
  switch (request.empty() ? 0 : request[0]) {
    case kReadCoils:
    case kReadDiscreteInputs:
      return read_bits(request, response, size);
    case kReadHoldingRegisters:
    case kReadInputRegisters:
      return read_registers(request, response, size);
    case kWriteSingleCoil:
      return echo(write_single_coil(request), 5);
    case kWriteSingleRegister:
      return echo(write_single_register(request), 5);
    case kWriteMultipleCoils:
      return echo(write_multiple_coils(request), 5);
    case kWriteMultipleRegisters:
      return echo(write_multiple_registers(request), 5);
    case kMaskWriteRegister:
      return echo(mask_write_register(request), 7);
    case kReadWriteRegisters:
      return read_write_registers(request, response, size);
    case kEncapsulated:
      return identify(request, response, size);
    default:
      return Exception::kIllegalFunction;
  }
}

Exception PduHandler::read_bits(Request request, Response response, std::size_t& size) {
  if (request.size() != 5) return Exception::kIllegalValue;
  const std::uint32_t first = word(request, 1), count = word(request, 3);
  const Table table = request[0] == kReadCoils ? Table::kCoils : Table::kDiscreteInputs;
  if (!is_between(count, 1, kMaxReadBits)) return Exception::kIllegalValue;
  if (!data_.contains(table, first, count)) return Exception::kIllegalAddress;
  const std::size_t bytes = (count + 7) / 8;
  response[1] = static_cast<std::uint8_t>(bytes);
  data_.read_bits(table, first, response.subspan(2, bytes), count);
  size = 2 + bytes;
  return Exception::kNone;
}

Exception PduHandler::read_registers(Request request, Response response, std::size_t& size) {
  if (request.size() != 5) return Exception::kIllegalValue;
  const std::uint32_t first = word(request, 1), count = word(request, 3);
  const Table table = request[0] == kReadHoldingRegisters ? Table::kHoldingRegisters : Table::kInputRegisters;
  if (!is_between(count, 1, kMaxReadRegisters)) return Exception::kIllegalValue;
  if (!data_.contains(table, first, count)) return Exception::kIllegalAddress;
  response[1] = static_cast<std::uint8_t>(2 * count);
  data_.read_registers(table, first, response.subspan(2, std::size_t{2} * count));
  size = 2 + 2 * count;
  return Exception::kNone;
}

Exception PduHandler::write_single_coil(Request request) {
  if (request.size() != 5) return Exception::kIllegalValue;
  const std::uint32_t address = word(request, 1), value = word(request, 3);
  if (value != 0x0000 && value != 0xff00) return Exception::kIllegalValue;
  if (!data_.contains(Table::kCoils, address, 1)) return Exception::kIllegalAddress;
  data_.begin_write();
  if (!data_.change(Table::kCoils, address, value != 0, 1)) return Exception::kIllegalAddress;
  return data_.commit();
}

Exception PduHandler::write_single_register(Request request) {
  if (request.size() != 5) return Exception::kIllegalValue;
  const std::uint32_t address = word(request, 1);
  if (!data_.contains(Table::kHoldingRegisters, address, 1)) return Exception::kIllegalAddress;
  return change_registers(address, request.subspan(3, 2));
}

Exception PduHandler::write_multiple_coils(Request request) {
  if (request.size() < 6) return Exception::kIllegalValue;
  const std::uint32_t first = word(request, 1), count = word(request, 3), bytes = request[5];
  if (!is_between(count, 1, kMaxWriteBits) || bytes != (count + 7) / 8 || request.size() != 6 + bytes) {
    return Exception::kIllegalValue;
  }
  if (!data_.contains(Table::kCoils, first, count)) return Exception::kIllegalAddress;
  data_.begin_write();
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto value = static_cast<std::uint16_t>(request[6 + i / 8] >> i % 8 & 1);
    if (!data_.change(Table::kCoils, first + i, value, 1)) return Exception::kIllegalAddress;
  }
  return data_.commit();
}

Exception PduHandler::write_multiple_registers(Request request) {
  if (request.size() < 6) return Exception::kIllegalValue;
  const std::uint32_t first = word(request, 1), count = word(request, 3), bytes = request[5];
  if (!is_between(count, 1, kMaxWriteRegisters) || bytes != 2 * count || request.size() != 6 + bytes) {
    return Exception::kIllegalValue;
  }
  if (!data_.contains(Table::kHoldingRegisters, first, count)) return Exception::kIllegalAddress;
  return change_registers(first, request.subspan(6));
}

Exception PduHandler::mask_write_register(Request request) {
  if (request.size() != 7) return Exception::kIllegalValue;
  const std::uint32_t address = word(request, 1);
  if (!data_.contains(Table::kHoldingRegisters, address, 1)) return Exception::kIllegalAddress;
  // Result = (present AND and_mask) OR (or_mask AND NOT and_mask): the bits that are not in and_mask are set anew.
  const auto taken = static_cast<std::uint16_t>(~word(request, 3));
  data_.begin_write();
  if (!data_.change(Table::kHoldingRegisters, address, static_cast<std::uint16_t>(word(request, 5)), taken)) {
    return Exception::kIllegalAddress;
  }
  return data_.commit();
}

Exception PduHandler::read_write_registers(Request request, Response response, std::size_t& size) {
  if (request.size() < 10) return Exception::kIllegalValue;
  const std::uint32_t read_first = word(request, 1), read_count = word(request, 3);
  const std::uint32_t first = word(request, 5), count = word(request, 7), bytes = request[9];
  if (!is_between(read_count, 1, kMaxReadRegisters) || !is_between(count, 1, kMaxReadWriteWritten) ||
      bytes != 2 * count || request.size() != 10 + bytes) {
    return Exception::kIllegalValue;
  }
  if (!data_.contains(Table::kHoldingRegisters, read_first, read_count) ||
      !data_.contains(Table::kHoldingRegisters, first, count)) {
    return Exception::kIllegalAddress;
  }
  const Exception written = change_registers(first, request.subspan(10));
  if (written != Exception::kNone) return written;
  response[1] = static_cast<std::uint8_t>(2 * read_count);
  data_.read_registers(Table::kHoldingRegisters, read_first, response.subspan(2, std::size_t{2} * read_count));
  size = 2 + 2 * read_count;
  return Exception::kNone;
}

Exception PduHandler::change_registers(std::uint32_t first, Request values) {
  data_.begin_write();
  for (std::uint32_t i = 0; i < values.size() / 2; ++i) {
    const auto value = static_cast<std::uint16_t>(word(values, std::size_t{2} * i));
    if (!data_.change(Table::kHoldingRegisters, first + i, value, 0xffff)) return Exception::kIllegalAddress;
  }
  return data_.commit();
}

Exception PduHandler::identify(Request request, Response response, std::size_t& size) const {
  if (request.size() < 2 || request[1] != kReadDeviceIdentification) return Exception::kIllegalFunction;
  if (request.size() != 4) return Exception::kIllegalValue;
  const std::uint8_t code = request[2];
  if (!is_between(code, 1, kOneObject)) return Exception::kIllegalValue;
  std::uint8_t first = request[3];
  std::uint8_t last = code == 1 ? kLastBasic : kLastRegular;
  if (code == kOneObject) {
    if (first > kLastRegular) return Exception::kIllegalAddress;
    last = first;
  } else if (first > last) {
    first = 0;  // the protocol's rule for a stream: an unknown object starts it anew
  }
  response[1] = kReadDeviceIdentification;
  response[2] = code;
  response[3] = kConformity;
  response[4] = 0;  // more follows
  response[5] = 0;  // from this object on
  size = kIdentificationHead;
  std::uint8_t objects = 0;
  for (std::uint8_t id = first; id <= last; ++id) {
    const std::string& text = identification_[id];
    if (size + 2 + text.size() > kMaxPdu) {
      response[4] = 0xff;
      response[5] = id;
      break;
    }
    response[size] = id;
    response[size + 1] = static_cast<std::uint8_t>(text.size());
    std::memcpy(response.data() + size + 2, text.data(), text.size());
    size += 2 + text.size();
    ++objects;
  }
  response[6] = objects;
  return Exception::kNone;
}

}  // namespace plc::modbus
