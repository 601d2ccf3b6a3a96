// The links against peers that misbehave, over real sockets and pty pairs: what each case is called, and that a good
// answer after it is a good one.
#include "io-drivers/modbus-client/link.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <thread>

#include "tests/unit/modbus-client/hostile_cases.h"

namespace plc::modbus_client {
namespace {

using test::LinePeer;
using test::Reaction;
using test::TcpPeer;

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

INSTANTIATE_TEST_SUITE_P(Tcp, HostileTcp, ::testing::ValuesIn(kTcpCases),
                         [](const auto& test) { return std::string(test.param.name); });

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

TEST(Link, ANameIsResolvedForEachConnection) {
  TcpPeer peer([](const Bytes& request) { return Reaction{{good_tcp(request)}, true}; });
  const auto link = make_link(parse_bus("localhost:" + std::to_string(peer.port())).value());
  Cells cells;
  // localhost may be ::1 first, where nobody listens: the next address has its turn at once.
  for (int i = 0; i < 20; ++i) EXPECT_EQ(ask(*link, kUnit, kPdu, kLong, cells), Error::kNone);
}

TEST(Link, NoWaitGoesBeyondTheEnd) {
  TcpPeer peer([](const Bytes&) { return Reaction{}; });
  const auto link = make_link(parse_bus(peer.bus()).value());
  const core::MonotonicClock clock;
  std::thread end([&] {
    while (peer.requests() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    link->end_by(clock.now_ns() + 20 * kMs);
  });
  Cells cells;
  const core::TimeNs begin = clock.now_ns();
  EXPECT_EQ(ask(*link, kUnit, kPdu, 60'000 * kMs, cells), Error::kNoAnswer) << "one that had begun";
  end.join();
  // There may be no time for a connection.
  EXPECT_NE(ask(*link, kUnit, kPdu, 60'000 * kMs, cells), Error::kNone);
  EXPECT_LT(clock.now_ns() - begin, 30'000 * kMs);
}

TEST(Link, WhatIsAnsweredPutsOffTheEnd) {
  TcpPeer peer([](const Bytes& request) {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    return Reaction{{good_tcp(request)}};
  });
  const auto link = make_link(parse_bus(peer.bus()).value());
  const core::MonotonicClock clock;
  const core::TimeNs end = clock.now_ns() + 2'000 * kMs;
  link->end_by(end);
  Cells cells;
  for (int i = 0; i < 11; ++i) EXPECT_EQ(ask(*link, kUnit, kPdu, 60'000 * kMs, cells), Error::kNone);
  EXPECT_GE(clock.now_ns(), end);
}

TEST(Link, ANameThatNobodyKnowsIsSaidInTime) {
  const auto link = make_link(parse_bus("no-such-host.invalid").value());
  Cells cells;
  const core::MonotonicClock clock;
  const core::TimeNs begin = clock.now_ns();
  EXPECT_EQ(ask(*link, kUnit, kPdu, 200 * kMs, cells), Error::kNotConnected);
  // As long as it may take and no longer, whatever the machine's resolver does; with time for a busy machine.
  EXPECT_LT(clock.now_ns() - begin, 3'000 * kMs);
  EXPECT_FALSE(link->reason().empty());
}

TEST(Link, OneConnectionServesAllRequests) {
  TcpPeer peer([](const Bytes& request) { return Reaction{{good_tcp(request)}}; });
  const auto link = make_link(parse_bus(peer.bus()).value());
  Cells cells;
  for (int i = 0; i < 200; ++i) ASSERT_EQ(ask(*link, 1, kPdu, kLong, cells), Error::kNone);
  EXPECT_EQ(peer.connections(), 1);
}

TEST(Link, MemoryStaysFlat) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "AddressSanitizer keeps what has been freed for a while";
#endif
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
      {"plc.local", "plc.local:502"},         {"Meter-3:1502", "Meter-3:1502"},   {"3com.plant", "3com.plant:502"},
  };
  for (const auto& [text, name] : rows) {
    const auto bus = parse_bus(text);
    ASSERT_TRUE(bus.has_value()) << text;
    EXPECT_EQ(bus_name(*bus), name);
  }
  for (const char* text :
       {"", "10.0.0", "10.0.0.5:", "10.0.0.5:0", "10.0.0.5:70000", "10.0.0.5:5x", "[fd00::20", "[fd00::20]5",
        "10.0.0.256", "ttyUSB0", "COM3", "a..b", "-a", "a-", ".a", "a_b", "a b", "a/b"}) {
    EXPECT_FALSE(parse_bus(text).has_value()) << text;
  }
}

}  // namespace
}  // namespace plc::modbus_client
