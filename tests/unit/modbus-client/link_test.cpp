// The links against peers that misbehave, over real sockets and pty pairs: what each case is called, and that a good
// answer after it is a good one.
#include "io-drivers/modbus-client/link.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "tests/unit/modbus-client/hostile.h"

namespace plc::modbus_client {
namespace {

using test::LinePeer;
using test::Reaction;
using test::TcpPeer;

constexpr core::TimeNs kMs = 1'000'000;
/// Long enough for a good peer on a busy machine; bad ones are waited for as long as kShort.
constexpr core::TimeNs kLong = 20'000 * kMs, kShort = 30 * kMs;
const Bytes kPdu = read_pdu(ModbusTable::kHoldingRegisters, 0, 2);
const Bytes kAnswer = {3, 4, 1, 2, 3, 4};
constexpr std::uint8_t kUnit = 5;

Bytes good_tcp(const Bytes& request) {
  return tcp_frame(static_cast<std::uint16_t>(request[0] << 8 | request[1]), request[6], kAnswer);
}
std::vector<Bytes> one_by_one(const Bytes& bytes) {
  std::vector<Bytes> pieces;
  for (const std::uint8_t byte : bytes) pieces.push_back({byte});
  return pieces;
}
Bytes changed(Bytes bytes, std::size_t place, std::uint8_t value) {
  bytes[place] = value;
  return bytes;
}
Bytes joined(Bytes first, const Bytes& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}
Bytes head(const Bytes& bytes, std::size_t size) { return {bytes.begin(), bytes.begin() + std::ptrdiff_t(size)}; }

struct Case {
  const char* name;
  std::function<Reaction(const Bytes&)> react;
  Error error;
  core::TimeNs timeout_ns = kLong;
};

class HostileTcp : public ::testing::TestWithParam<Case> {};

TEST_P(HostileTcp, IsNamedAndForgotten) {
  const Case& one = GetParam();
  std::atomic<bool> bad = true;
  TcpPeer peer([&](const Bytes& request) { return bad ? one.react(request) : Reaction{{good_tcp(request)}}; });
  const auto link = make_link(parse_bus(peer.bus()).value());
  for (int round = 0; round < 2; ++round) {
    bad = true;
    Cells cells;
    EXPECT_EQ(ask(*link, kUnit, kPdu, one.timeout_ns, cells), one.error);
    EXPECT_EQ(cells, (one.error == Error::kNone ? Cells{0x102, 0x304} : Cells{}));
    bad = false;
    EXPECT_EQ(ask(*link, kUnit, kPdu, kLong, cells), Error::kNone);
    EXPECT_EQ(cells, (Cells{0x102, 0x304}));
  }
}

const Case kTcpCases[] = {
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
INSTANTIATE_TEST_SUITE_P(Tcp, HostileTcp, ::testing::ValuesIn(kTcpCases),
                         [](const auto& test) { return std::string(test.param.name); });

Bytes good_rtu() { return rtu_frame(kUnit, kAnswer); }

class HostileLine : public ::testing::TestWithParam<Case> {};

TEST_P(HostileLine, IsNamedAndForgotten) {
  const Case& one = GetParam();
  std::atomic<bool> bad = true;
  LinePeer peer([&](const Bytes& request) { return bad ? one.react(request) : Reaction{{good_rtu()}}; });
  BusAddress bus = parse_bus(peer.path()).value();
  bus.line.baud = 115200;
  const auto link = make_link(bus);
  for (int round = 0; round < 2; ++round) {
    bad = true;
    Cells cells;
    EXPECT_EQ(ask(*link, kUnit, kPdu, one.timeout_ns, cells), one.error);
    bad = false;
    EXPECT_EQ(ask(*link, kUnit, kPdu, kLong, cells), Error::kNone);
    EXPECT_EQ(cells, (Cells{0x102, 0x304}));
  }
  EXPECT_GE(peer.shortest_silence_ns(), silence_ns(bus.line));
}

const Case kLineCases[] = {
    {"good", [](const Bytes&) { return Reaction{{good_rtu()}}; }, Error::kNone},
    {"silent", [](const Bytes&) { return Reaction{}; }, Error::kNoAnswer, kShort},
    {"byte_by_byte",
     [](const Bytes&) {
       return Reaction{one_by_one(good_rtu()), false, false, 1};
     },
     Error::kNone},
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
    {"exception_6",
     [](const Bytes&) {
       return Reaction{{rtu_frame(kUnit, Bytes{0x83, 6})}};
     },
     Error::kBusy},
};
INSTANTIATE_TEST_SUITE_P(Line, HostileLine, ::testing::ValuesIn(kLineCases),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(Link, NobodyListens) {
  std::uint16_t port = 0;
  {
    port = TcpPeer([](const Bytes&) { return Reaction{}; }).port();
  }
  const auto link = make_link(parse_bus("127.0.0.1:" + std::to_string(port)).value());
  Cells cells;
  EXPECT_EQ(ask(*link, 1, kPdu, kLong, cells), Error::kNotConnected);
  EXPECT_EQ(link->reason(), "Connection refused");
  const auto line = make_link(parse_bus("/dev/no-such-line").value());
  EXPECT_EQ(ask(*line, 1, kPdu, kLong, cells), Error::kNotConnected);
  EXPECT_EQ(line->reason(), "No such file or directory");
}

TEST(Link, OneConnectionServesAllRequests) {
  TcpPeer peer([](const Bytes& request) { return Reaction{{good_tcp(request)}}; });
  const auto link = make_link(parse_bus(peer.bus()).value());
  Cells cells;
  for (int i = 0; i < 200; ++i) ASSERT_EQ(ask(*link, 1, kPdu, kLong, cells), Error::kNone);
  EXPECT_EQ(peer.connections(), 1);
}

TEST(Link, MemoryStaysFlat) {
  int round = 0;
  TcpPeer peer([&](const Bytes& request) { return kTcpCases[4 + ++round % 10].react(request); });
  const auto link = make_link(parse_bus(peer.bus()).value());
  const auto most = [] {
    rusage usage = {};
    ::getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
  };
  Cells cells;
  for (int i = 0; i < 200; ++i) ask(*link, kUnit, kPdu, kMs, cells);
  const long before = most();
  for (int i = 0; i < 5'000; ++i) ask(*link, kUnit, kPdu, kMs, cells);
  EXPECT_LE(most() - before, 512) << "KiB";
}

TEST(Link, AddressesAreReadAsPeopleWriteThem) {
  const std::pair<const char*, const char*> rows[] = {
      {"10.0.0.5", "10.0.0.5:502"},           {"10.0.0.5:1502", "10.0.0.5:1502"}, {" 10.0.0.5 ", "10.0.0.5:502"},
      {"[fd00::20]:1502", "[fd00::20]:1502"}, {"fd00::20", "[fd00::20]:502"},     {"/dev/ttyUSB0", "/dev/ttyUSB0"},
  };
  for (const auto& [text, name] : rows) {
    const auto bus = parse_bus(text);
    ASSERT_TRUE(bus.has_value()) << text;
    EXPECT_EQ(bus_name(*bus), name);
  }
  for (const char* text : {"", "10.0.0", "10.0.0.5:", "10.0.0.5:0", "10.0.0.5:70000", "10.0.0.5:5x", "[fd00::20",
                           "[fd00::20]5", "plc.local", "ttyUSB0"}) {
    EXPECT_FALSE(parse_bus(text).has_value()) << text;
  }
  EXPECT_EQ(parse_line("19200 8E1"), LineSettings{});
  EXPECT_EQ(parse_line("9600 8n2"), (LineSettings{9600, 8, Parity::kNone, 2}));
  for (const char* text : {"", "9600", "9600 7E1", "9600 8X1", "9600 8E3", "9601 8E1", "x 8E1", "9600 8E1 "}) {
    EXPECT_EQ(parse_line(text).has_value(), std::string_view(text) == "9600 8E1 ") << text;
  }
  EXPECT_EQ(silence_ns({9600, 8, Parity::kEven, 1}), 4'010'416);
  EXPECT_EQ(silence_ns({115200, 8, Parity::kEven, 1}), 1'750'000);
}

}  // namespace
}  // namespace plc::modbus_client
