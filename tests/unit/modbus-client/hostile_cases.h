// Servers that misbehave, one row each, and what that is called: for the link and for the device.
//
// In: the request for two registers of unit 5. Out: what the server does, the error. Does not belong here: peers
// (tests/support/modbus_peers.h).
#pragma once

#include "io-drivers/modbus-client/link.h"
#include "tests/support/modbus_peers.h"

namespace plc::modbus_client {

using test::LinePeer;
using test::Reaction;
using test::TcpPeer;

inline constexpr core::TimeNs kMs = 1'000'000;
/// Long enough for a good peer on a busy machine; bad ones are waited for as long as kShort.
inline constexpr core::TimeNs kLong = 20'000 * kMs, kShort = 30 * kMs;
inline const Bytes kPdu = read_pdu(ModbusTable::kHoldingRegisters, 0, 2);
inline const Bytes kAnswer = {3, 4, 1, 2, 3, 4};
inline constexpr std::uint8_t kUnit = 5;

inline Bytes good_tcp(const Bytes& request) {
  return tcp_frame(static_cast<std::uint16_t>(request[0] << 8 | request[1]), request[6], kAnswer);
}
inline std::vector<Bytes> one_by_one(const Bytes& bytes) {
  std::vector<Bytes> pieces;
  for (const std::uint8_t byte : bytes) pieces.push_back({byte});
  return pieces;
}
inline Bytes changed(Bytes bytes, std::size_t place, std::uint8_t value) {
  bytes[place] = value;
  return bytes;
}
inline Bytes joined(Bytes first, const Bytes& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}
inline Bytes head(const Bytes& bytes, std::size_t size) {
  return {bytes.begin(), bytes.begin() + std::ptrdiff_t(size)};
}

struct Case {
  const char* name;
  std::function<Reaction(const Bytes&)> react;
  Error error;
  core::TimeNs timeout_ns = kLong;
};

inline const Case kTcpCases[] = {
    {"good", [](const Bytes& r) { return Reaction{{good_tcp(r)}}; }, Error::kNone},
    {"silent", [](const Bytes&) { return Reaction{}; }, Error::kNoAnswer, kShort},
    {"byte_by_byte",
     [](const Bytes& r) {
       return Reaction{one_by_one(good_tcp(r)), false, false, 1};
     },
     Error::kNone},
    {"too_slow",
     [](const Bytes& r) {
       return Reaction{one_by_one(good_tcp(r)), false, false, 10};
     },
     Error::kNoAnswer, kShort},
    {"other_transaction", [](const Bytes& r) { return Reaction{{changed(good_tcp(r), 1, 0xee)}}; },
     Error::kWrongAnswer},
    {"other_protocol", [](const Bytes& r) { return Reaction{{changed(good_tcp(r), 3, 1)}}; }, Error::kWrongAnswer},
    {"other_unit", [](const Bytes& r) { return Reaction{{changed(good_tcp(r), 6, 6)}}; }, Error::kWrongAnswer},
    {"other_function", [](const Bytes& r) { return Reaction{{changed(good_tcp(r), 7, 4)}}; }, Error::kWrongAnswer},
    {"length_0", [](const Bytes& r) { return Reaction{{changed(good_tcp(r), 5, 0)}}; }, Error::kWrongAnswer},
    {"length_short", [](const Bytes& r) { return Reaction{{changed(good_tcp(r), 5, 6)}}; }, Error::kWrongAnswer},
    {"length_long", [](const Bytes& r) { return Reaction{{changed(good_tcp(r), 5, 9)}}; }, Error::kNoAnswer, kShort},
    {"length_65535", [](const Bytes& r) { return Reaction{{changed(changed(good_tcp(r), 4, 255), 5, 255)}}; },
     Error::kWrongAnswer},
    {"byte_count", [](const Bytes& r) { return Reaction{{changed(good_tcp(r), 8, 6)}}; }, Error::kWrongAnswer},
    {"too_much", [](const Bytes& r) { return Reaction{{joined(good_tcp(r), {0})}}; }, Error::kWrongAnswer},
    {"twice", [](const Bytes& r) { return Reaction{{joined(good_tcp(r), good_tcp(r))}}; }, Error::kWrongAnswer},
    {"late",
     [](const Bytes& r) {
       return Reaction{{{}, good_tcp(r)}, false, false, 60};
     },
     Error::kNoAnswer, kShort},
    {"half", [](const Bytes& r) { return Reaction{{head(good_tcp(r), 8)}}; }, Error::kNoAnswer, kShort},
    {"half_and_closed",
     [](const Bytes& r) {
       return Reaction{{head(good_tcp(r), 8)}, true};
     },
     Error::kClosed},
    {"closed",
     [](const Bytes&) {
       return Reaction{{}, true};
     },
     Error::kClosed},
    {"reset",
     [](const Bytes&) {
       return Reaction{{}, false, true};
     },
     Error::kClosed},
    {"good_then_closed",
     [](const Bytes& r) {
       return Reaction{{good_tcp(r)}, true};
     },
     Error::kNone},
    {"exception_2",
     [](const Bytes& r) {
       return Reaction{{tcp_frame(std::uint16_t(r[0] << 8 | r[1]), r[6], Bytes{0x83, 2})}};
     },
     Error::kIllegalAddress},
    {"exception_0",
     [](const Bytes& r) {
       return Reaction{{tcp_frame(std::uint16_t(r[0] << 8 | r[1]), r[6], Bytes{0x83, 0})}};
     },
     Error::kWrongAnswer},
    {"garbage", [](const Bytes&) { return Reaction{{Bytes(4000, 0xa5)}}; }, Error::kWrongAnswer},
    {"text",
     [](const Bytes&) {
       return Reaction{{Bytes{'H', 'T', 'T', 'P', '/', '1', '.', '1', ' ', '4'}}};
     },
     Error::kWrongAnswer},
};

inline Bytes good_rtu() { return rtu_frame(kUnit, kAnswer); }

inline const Case kLineCases[] = {
    {"good", [](const Bytes&) { return Reaction{{good_rtu()}}; }, Error::kNone},
    {"silent", [](const Bytes&) { return Reaction{}; }, Error::kNoAnswer, kShort},
    {"byte_by_byte",
     [](const Bytes&) {
       return Reaction{one_by_one(good_rtu()), false, false, 1};
     },
     Error::kNone},
    {"pause_inside",
     [](const Bytes&) {
       return Reaction{{head(good_rtu(), 5), Bytes{3, 4}}, false, false, 40};
     },
     Error::kNoAnswer, kShort},
    {"other_unit", [](const Bytes&) { return Reaction{{rtu_frame(6, kAnswer)}}; }, Error::kWrongAnswer},
    {"other_function",
     [](const Bytes&) {
       return Reaction{{rtu_frame(kUnit, Bytes{4, 4, 1, 2, 3, 4})}};
     },
     Error::kWrongAnswer},
    {"wrong_crc", [](const Bytes&) { return Reaction{{changed(good_rtu(), 4, 0x55)}}; }, Error::kWrongAnswer},
    {"half", [](const Bytes&) { return Reaction{{head(good_rtu(), 5)}}; }, Error::kNoAnswer, kShort},
    {"noise_before",
     [](const Bytes&) {
       return Reaction{{joined({0, 0xff}, good_rtu())}};
     },
     Error::kWrongAnswer},
    {"noise_after",
     [](const Bytes&) {
       return Reaction{{joined(good_rtu(), {0xff, 0})}};
     },
     Error::kWrongAnswer},
    {"noise_for_long",
     [](const Bytes&) {
       return Reaction{std::vector<Bytes>(20, Bytes(50, 0xaa)), false, false, 1};
     },
     Error::kWrongAnswer},
    {"byte_count",
     [](const Bytes&) {
       return Reaction{{rtu_frame(kUnit, Bytes{3, 2, 1, 2})}};
     },
     Error::kWrongAnswer},
    {"exception_0",
     [](const Bytes&) {
       return Reaction{{rtu_frame(kUnit, Bytes{0x83, 0})}};
     },
     Error::kWrongAnswer},
    {"exception_6",
     [](const Bytes&) {
       return Reaction{{rtu_frame(kUnit, Bytes{0x83, 6})}};
     },
     Error::kBusy},
};

}  // namespace plc::modbus_client
