// A device against servers that misbehave, over real sockets and pty pairs: what its inputs are worth meanwhile, what
// the program is told, what the operator is told, and that all of it ends with the first good answer.
#include <gtest/gtest.h>
#include <malloc.h>

#include "tests/unit/modbus-client/hostile_cases.h"
#include "tests/unit/modbus-client/rig.h"

namespace plc::modbus_client {
namespace {

/// In0 has a substitute, In1 holds its value; both are in one request.
std::string configuration(const std::string& bus, core::TimeNs timeout_ns) {
  return "[drivers.dev]\nkind = \"modbus\"\nunit = 5\nretries = 0\nretry = \"10ms\"\nretry_max = \"10ms\"\npoll = "
         "\"2ms\"\n"
         "line = \"115200 8E1\"\ntimeout = \"" +
         std::to_string(timeout_ns / kMs) + "ms\"\nbus = \"" + bus +
         "\"\n[inputs]\nIn0 = { driver = \"dev\", table = \"holding-registers\", address = 0, substitute = -1 }\n"
         "In1 = { driver = \"dev\", table = \"holding-registers\", address = 1 }\n"
         "Ok = { driver = \"dev\", status = \"ok\" }\nError = { driver = \"dev\", status = \"error\" }\n";
}

/// The device of a rig in real time, on a link of its own.
struct RealDevice {
  RealDevice(const std::string& bus, core::TimeNs timeout_ns) : rig(configuration(bus, timeout_ns)) {
    BusAddress address = parse_bus(bus).value();
    address.line.baud = 115200;
    link = make_link(address);
  }
  /// Turns until it holds; false after 20 s.
  template <class Holds>
  bool turn_until(Holds holds) {
    const core::TimeNs end = clock.now_ns() + kLong;
    while (!holds()) {
      if (clock.now_ns() > end) return false;
      clock.sleep_until_ns(rig.device->due());
      rig.device->turn(*link, clock);
    }
    return true;
  }
  [[nodiscard]] std::string values() const { return rig.value("In0") + ' ' + rig.value("In1"); }
  [[nodiscard]] std::string status() const { return rig.value("Ok") + ' ' + rig.value("Error"); }
  [[nodiscard]] bool are(io::Quality quality) const {
    const auto inputs = rig.device->inputs(clock.now_ns());
    return std::ranges::all_of(inputs, [&](const io::InputStatus& input) { return input.quality == quality; });
  }
  std::string said() {
    std::string all;
    for (const io::Sentence& sentence : rig.device->take_said(clock.now_ns())) all += sentence.text + '\n';
    return all;
  }

  test::Rig rig;
  core::MonotonicClock clock;
  std::unique_ptr<Link> link;
};

const std::string kGood = "258 772";  // 0x102, 0x304
const std::string kBad = "-1 772";

void expect_as_declared(const Case& one, const std::string& bus, const std::string& where, std::atomic<bool>& bad) {
  RealDevice device(bus, one.timeout_ns);
  bad = false;
  ASSERT_TRUE(device.turn_until([&] { return device.values() == kGood; }));
  EXPECT_EQ(device.said(), "");
  bad = true;
  if (one.error == Error::kNone) {
    const std::uint64_t begin = device.rig.device->status().exchanges;
    ASSERT_TRUE(device.turn_until([&] { return device.rig.device->status().exchanges >= begin + 3; }));
    EXPECT_EQ(device.values() + ", " + device.status(), kGood + ", 1 0");
    EXPECT_EQ(device.said(), "");
    return;
  }
  const std::string number = std::to_string(static_cast<unsigned>(one.error));
  ASSERT_TRUE(device.turn_until([&] { return device.are(io::Quality::kLost); })) << device.status();
  EXPECT_EQ(device.values() + ", " + device.status(), kBad + ", 0 " + number);
  const bool refused = is_exception(one.error);
  EXPECT_EQ(device.rig.device->status().connected, refused);
  const std::string begin = "dev: " + where +
                            ", unit 5: " + (refused ? "holding registers 0 to 1 cannot be read: " : "") +
                            error_text(one.error);
  const std::string said = device.said();
  EXPECT_EQ(said.substr(0, begin.size()), begin);
  EXPECT_EQ(std::ranges::count(said, '\n'), 1) << said;
  // It stays so, and is not said again.
  for (int i = 0; i < 4; ++i) {
    device.clock.sleep_until_ns(device.rig.device->due());
    device.rig.device->turn(*device.link, device.clock);
  }
  EXPECT_EQ(device.values() + ", " + device.status(), kBad + ", 0 " + number);
  EXPECT_EQ(device.said(), "");
  bad = false;
  ASSERT_TRUE(device.turn_until([&] { return device.are(io::Quality::kGood); })) << device.status();
  EXPECT_EQ(device.values() + ", " + device.status(), kGood + ", 1 0");
  EXPECT_NE(device.said().find(refused ? "can be read again" : "is back after"), std::string::npos);
}

class HostileTcpServer : public ::testing::TestWithParam<Case> {};

TEST_P(HostileTcpServer, LeavesValuesQualityAndLogAsDeclared) {
  const Case& one = GetParam();
  std::atomic<bool> bad = false;
  TcpPeer peer([&](const Bytes& request) { return bad ? one.react(request) : Reaction{{good_tcp(request)}}; });
  expect_as_declared(one, peer.bus(), peer.bus(), bad);
}
INSTANTIATE_TEST_SUITE_P(All, HostileTcpServer, ::testing::ValuesIn(kTcpCases),
                         [](const auto& test) { return std::string(test.param.name); });

class HostileLineServer : public ::testing::TestWithParam<Case> {};

TEST_P(HostileLineServer, LeavesValuesQualityAndLogAsDeclared) {
  const Case& one = GetParam();
  std::atomic<bool> bad = false;
  LinePeer peer([&](const Bytes& request) { return bad ? one.react(request) : Reaction{{good_rtu()}}; });
  expect_as_declared(one, peer.path(), peer.path(), bad);
}
INSTANTIATE_TEST_SUITE_P(All, HostileLineServer, ::testing::ValuesIn(kLineCases),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(HostileServers, MemoryStaysFlat) {
  // Every row that needs no time-out, in turn with good answers: losses and returns by the thousand.
  std::vector<const Case*> cases;
  for (const Case& one : kTcpCases) {
    if (one.timeout_ns == kLong) cases.push_back(&one);
  }
  std::size_t round = 0;
  TcpPeer peer([&](const Bytes& request) {
    ++round;
    return round % 2 == 0 ? Reaction{{good_tcp(request)}} : cases[round / 2 % cases.size()]->react(request);
  });
  RealDevice device(peer.bus(), kLong);
  const auto lose = [&](std::uint64_t times) {
    const std::uint64_t end = device.rig.device->status().losses + times;
    ASSERT_TRUE(device.turn_until([&] {
      device.said();
      return device.rig.device->status().losses >= end;
    }));
  };
  lose(100);
  const std::size_t before = ::mallinfo2().uordblks;
  lose(500);
  EXPECT_LE(::mallinfo2().uordblks, before + 64 * 1024) << "bytes in use";
}

}  // namespace
}  // namespace plc::modbus_client
