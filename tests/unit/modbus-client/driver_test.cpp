// The kind in a machine: real tasks, a real connection; start without a device, values both ways, safe values at the
// end.
#include <gtest/gtest.h>

#include <map>
#include <mutex>
#include <thread>

#include "io-drivers/machine/driver_types.h"
#include "io-drivers/machine/machine.h"
#include "tests/support/modbus_peers.h"
#include "tests/unit/modbus-client/rig.h"

namespace plc::test {
namespace {

/// Holding registers of several units behind one port.
class Registers {
 public:
  Reaction react(const Bytes& request) {
    const std::scoped_lock lock(mutex_);
    const std::uint8_t unit = request[6];
    const auto first = static_cast<std::uint16_t>(request[8] << 8 | request[9]);
    const auto second = static_cast<std::uint16_t>(request[10] << 8 | request[11]);
    Bytes pdu = {request[7]};
    if (request[7] == 3) {
      pdu.push_back(static_cast<std::uint8_t>(second * 2));
      for (std::uint32_t i = 0; i < second; ++i) {
        const std::uint16_t value = cells_[{unit, first + i}];
        pdu.push_back(static_cast<std::uint8_t>(value >> 8));
        pdu.push_back(static_cast<std::uint8_t>(value));
      }
    } else {
      cells_[{unit, first}] = second;
      pdu.assign(request.begin() + 7, request.begin() + 12);
    }
    return {{modbus_client::tcp_frame(static_cast<std::uint16_t>(request[0] << 8 | request[1]), unit, pdu)}};
  }
  void set(std::uint8_t unit, std::uint32_t address, std::uint16_t value) {
    const std::scoped_lock lock(mutex_);
    cells_[{unit, address}] = value;
  }
  std::uint16_t get(std::uint8_t unit, std::uint32_t address) {
    const std::scoped_lock lock(mutex_);
    return cells_[{unit, address}];
  }

 private:
  std::mutex mutex_;
  std::map<std::pair<std::uint8_t, std::uint32_t>, std::uint16_t> cells_;
};

/// Waits as long as a busy machine may need.
bool comes_true(const std::function<bool()>& condition) {
  for (int i = 0; i < 6'000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

/// A machine with this file, running.
struct Running {
  explicit Running(const std::string& text) : resource(copier()), variables(*resource), scheduler(*resource) {
    core::Diagnostics diagnostics;
    auto configuration = io::read_configuration("[modbus]\nlisten = \"off\"\n[guardian]\nenabled = false\n" + text,
                                                "plc.toml", io::driver_types(), diagnostics);
    if (configuration) {
      machine = io::Machine::configure({.project = "p.st", .configuration = std::move(*configuration), .modbus = {}},
                                       *resource, diagnostics);
    }
    for (const core::Diagnostic& d : diagnostics.all()) ADD_FAILURE() << diagnostics.render_one(d);
    EXPECT_EQ(machine->open(), std::nullopt);
    std::vector<io::Sentence> notes;
    machine->start(scheduler, notes);
    scheduler.start();
  }
  void stop() {
    if (machine == nullptr) return;
    scheduler.request_stop();
    scheduler.join();
    machine->stop();
    machine.reset();
  }
  ~Running() { stop(); }
  [[nodiscard]] std::string value(const std::string& path) const { return variables.read(*variables.find(path)); }

  std::unique_ptr<runtime::Resource> resource;
  runtime::Access variables;
  std::unique_ptr<io::Machine> machine;
  runtime::RealtimeScheduler scheduler;
};

TEST(Driver, ValuesGoBothWaysAndEndSafe) {
  Registers registers;
  registers.set(3, 10, 42);
  registers.set(4, 10, 43);
  TcpPeer peer([&](const Bytes& request) { return registers.react(request); });
  const std::string bus = "bus = \"" + peer.bus() + "\"\npoll = \"5ms\"\n";
  Running running("[drivers.a]\nkind = \"modbus\"\nunit = 3\nok = \"Ok\"\n" + bus +
                  "[drivers.b]\nkind = \"modbus\"\nunit = 4\n" + bus +
                  "[inputs]\nIn0 = { driver = \"a\", table = \"holding-registers\", address = 10 }\n"
                  "In1 = { driver = \"b\", table = \"holding-registers\", address = 10 }\n"
                  "[outputs]\nOut0 = { driver = \"b\", table = \"holding-registers\", address = 20, safe = 99 }\n");
  EXPECT_TRUE(comes_true([&] { return registers.get(4, 20) == 42 && running.value("In1") == "43"; }));
  EXPECT_EQ(running.value("Ok"), "1");
  EXPECT_EQ(peer.connections(), 1) << "one bus";
  running.stop();
  EXPECT_EQ(registers.get(4, 20), 99);
}

TEST(Driver, ADeviceThatIsNotThereStopsNoStart) {
  std::uint16_t port = 0;
  {
    port = TcpPeer([](const Bytes&) { return Reaction{}; }).port();
  }
  Running running(
      "[drivers.a]\nkind = \"modbus\"\nretry = \"10ms\"\nok = \"Ok\"\nbus = \"127.0.0.1:" + std::to_string(port) +
      "\"\n[inputs]\nIn0 = { driver = \"a\", table = \"holding-registers\", address = 10, substitute = 7 }\n"
      "Error = { driver = \"a\", status = \"error\" }\n");
  EXPECT_TRUE(comes_true([&] { return running.value("Error") == "1001"; }));
  EXPECT_EQ(running.value("In0"), "7");
  EXPECT_EQ(running.value("Ok"), "0");
  std::vector<std::string> said;
  EXPECT_TRUE(comes_true([&] {
    for (auto& line : running.machine->service(core::MonotonicClock().now_ns())) said.push_back(line.text);
    return !said.empty();
  }));
  EXPECT_EQ(said.at(0),
            "a: 127.0.0.1:" + std::to_string(port) + ", unit 1: it cannot be connected to (Connection refused)");
}

TEST(Driver, ASilentDeviceHoldsNoTask) {
  TcpPeer peer([](const Bytes&) { return Reaction{}; });
  Running running("[drivers.a]\nkind = \"modbus\"\ntimeout = \"200ms\"\nretries = 0\nbus = \"" + peer.bus() +
                  "\"\n[inputs]\nIn0 = { driver = \"a\", table = \"holding-registers\", address = 10 }\n"
                  "Error = { driver = \"a\", status = \"error\" }\n"
                  "[outputs]\nOut1 = { driver = \"a\", table = \"holding-registers\", address = 11 }\n");
  const auto scans = [&] { return running.scheduler.statistics(0).scans.load(); };
  EXPECT_TRUE(comes_true([&] { return peer.requests() == 1; }));
  const std::uint64_t before = scans();
  EXPECT_TRUE(comes_true([&] { return scans() > before + 3; })) << "while the bus waits for the answer";
  EXPECT_TRUE(comes_true([&] { return running.value("Error") == "1002"; }));
}

TEST(Driver, SilentDevicesHoldUpNeitherTheEndNorOthers) {
  Registers registers;
  registers.set(1, 20, 55);
  TcpPeer good([&](const Bytes& request) { return registers.react(request); });
  TcpPeer silent([](const Bytes&) { return Reaction{}; });
  const std::string wait = "timeout = \"60s\"\nkind = \"modbus\"\n";
  Running running("[drivers.a]\n" + wait + "unit = 1\nbus = \"" + silent.bus() + "\"\n[drivers.b]\n" + wait +
                  "unit = 2\nbus = \"" + silent.bus() + "\"\n[drivers.c]\n" + wait + "bus = \"" + good.bus() +
                  "\"\n[outputs]\nOut0 = { driver = \"a\", table = \"holding-registers\", address = 1 }\n"
                  "Out1 = { driver = \"c\", table = \"holding-registers\", address = 20, safe = 99 }\n"
                  "[inputs]\nIn0 = { driver = \"b\", table = \"holding-registers\", address = 1 }\n");
  EXPECT_TRUE(comes_true([&] { return silent.requests() > 0 && registers.get(1, 20) != 55; }));
  const auto began = std::chrono::steady_clock::now();
  running.stop();
  // Three seconds; the guardian would kill it after five.
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(20));
  EXPECT_EQ(registers.get(1, 20), 99);
}

}  // namespace
}  // namespace plc::test
