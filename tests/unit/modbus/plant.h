// Plant: a small project with a Modbus map for the tests of the server: variables of the outside, of a task, and those
// that must not be written.
#pragma once

#include <cstring>
#include <memory>
#include <string>

#include "io-drivers/modbus/address_map.h"
#include "io-drivers/modbus/pdu.h"
#include "io-drivers/modbus/server.h"
#include "runtime/access.h"
#include "runtime/resource.h"
#include "tests/support/image_builder.h"
#include "tests/support/modbus_client.h"

namespace plc::test {

// Addresses of the plant's variables, as docs/guides/modbus.md has them.
inline constexpr std::uint32_t kCoils = 0;           ///< 64 BOOLs at %QX0.0, written by nobody else
inline constexpr std::uint32_t kWords = 1024;        ///< 200 WORDs at %MW0
inline constexpr std::uint32_t kPercent = 1324;      ///< INT (0..100) at %MW300
inline constexpr std::uint32_t kFixed = 1325;        ///< CONSTANT INT 77 at %MW301
inline constexpr std::uint32_t kDoubles = 2048;      ///< 4 DINTs at %MD0
inline constexpr std::uint32_t kReal = 2056;         ///< REAL at %MD4
inline constexpr std::uint32_t kPercentWide = 2058;  ///< DINT (0..100) at %MD5
inline constexpr std::uint32_t kLongs = 4096;        ///< 2 LINTs at %ML0
// Written by the task, every cycle.
inline constexpr std::uint32_t kCounter = 2088;   ///< DINT at %MD20: + 16#00010001
inline constexpr std::uint32_t kInverse = 2090;   ///< DINT at %MD21: -1 - counter
inline constexpr std::uint32_t kHalf = 2092;      ///< DINT at %MD22: + 1
inline constexpr std::uint32_t kWide = 4176;      ///< LINT at %ML20: + 16#0001000100010001
inline constexpr std::uint32_t kWideCopy = 4180;  ///< LINT at %ML21: the same
inline constexpr std::uint32_t kSetpoint = 4184;  ///< LINT at %ML22: the task's, and written from outside
inline constexpr std::uint32_t kEcho = 4188;      ///< LINT at %ML23: := setpoint

inline Image plant_image(std::int64_t period_ns = 1'000'000) {
  ImageBuilder b;
  const auto outside = [](std::string address) {
    return ImageBuilder::GlobalOptions{false, true, {}, std::move(address)};
  };
  const auto of_task = [](std::string address) {
    return ImageBuilder::GlobalOptions{false, false, {}, std::move(address)};
  };
  const std::uint32_t dint = b.type(TypeId::kDint), lint = b.type(TypeId::kLint);
  b.global("Coils", b.array(b.boolean(), 64), {}, outside("%QX0.0"));
  b.global("Inputs", b.array(b.boolean(), 16), {}, outside("%IX0.0"));
  b.global("InputWords", b.array(b.type(TypeId::kInt), 8), {}, outside("%IW0"));
  b.global("Words", b.array(b.type(TypeId::kWord), 200), {}, outside("%MW0"));
  b.global("Percent", b.limited(TypeId::kInt, 0, 100), {}, outside("%MW300"));
  b.global("Fixed", b.type(TypeId::kInt), bytes_of<std::int16_t>(77), {true, false, {}, "%MW301"});
  b.global("Doubles", b.array(dint, 4), {}, outside("%MD0"));
  b.global("Real", b.type(TypeId::kReal), {}, outside("%MD4"));
  b.global("PercentWide", b.limited(TypeId::kDint, 0, 100), {}, outside("%MD5"));
  b.global("Longs", b.array(lint, 2), {}, outside("%ML0"));
  b.global("Small", b.type(TypeId::kSint), {}, outside({}));
  b.global("Seen", b.boolean(), {}, outside({}));
  const Word counter = b.global("Counter", dint, {}, of_task("%MD20"));
  const Word inverse = b.global("Inverse", dint, bytes_of<std::int32_t>(-1), of_task("%MD21"));
  const Word half = b.global("Half", dint, {}, of_task("%MD22"));
  const Word wide = b.global("Wide", lint, {}, of_task("%ML20"));
  const Word wide_copy = b.global("WideCopy", lint, {}, of_task("%ML21"));
  const Word setpoint = b.global("Setpoint", lint, {}, of_task("%ML22"));
  const Word echo = b.global("Echo", lint, {}, of_task("%ML23"));
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  main.op(Opcode::kAdd32, {counter, counter, b.constant<std::int32_t>(TypeId::kDint, 0x00010001)});
  main.op(Opcode::kSub32, {inverse, b.constant<std::int32_t>(TypeId::kDint, -1), counter});
  main.op(Opcode::kAdd32, {half, half, b.constant<std::int32_t>(TypeId::kDint, 1)});
  main.op(Opcode::kAdd64, {wide, wide, b.constant<std::int64_t>(TypeId::kLint, 0x0001'0001'0001'0001)});
  main.op(Opcode::kMove64, {wide_copy, wide});
  main.op(Opcode::kMove64, {echo, setpoint});
  b.task("Fast", period_ns, {main.finish()});
  return b.build();
}

class Plant {
 public:
  explicit Plant(io::ModbusConfig modbus = {}, Image image = plant_image()) : config(std::move(modbus)) {
    core::Diagnostics diagnostics;
    auto verified = bytecode::verify(std::move(image), diagnostics);
    if (!verified) throw std::runtime_error("image refused: " + diagnostics.all().front().message);
    auto loaded = runtime::Resource::load(std::move(*verified));
    if (!loaded) throw std::runtime_error(loaded.error().message);
    resource = std::move(*loaded);
    modbus::FrozenAddresses frozen;
    auto built = modbus::AddressMap::build(*resource, config, frozen, diagnostics);
    if (!built) throw std::runtime_error("map refused: " + diagnostics.all().front().message);
    map = std::move(*built);
  }

  /// The newest value of a global scalar, by path.
  template <class T>
  [[nodiscard]] T value(const std::string& path) const {
    const auto place = runtime::Access(*resource).find_leaf(path);
    if (!place) throw std::runtime_error(place.error().message);
    T value{};
    resource->globals().read(place->offset, sizeof value, reinterpret_cast<std::byte*>(&value));
    return value;
  }
  /// PDU address of the variable called `path`.
  [[nodiscard]] std::uint32_t address(const std::string& path) const {
    for (const modbus::Point& point : map.points()) {
      if (point.path == path) return point.address;
    }
    throw std::runtime_error("not in the map: " + path);
  }
  void scan(std::size_t times = 1) {
    for (; times != 0; --times) (void)resource->program(0).execute({now_ns += 1'000'000});
  }

  io::ModbusConfig config;
  std::unique_ptr<runtime::Resource> resource;
  modbus::AddressMap map;
  core::TimeNs now_ns = 0;
};

/// The handler over a plant, without a network.
class PlantPdu {
 public:
  explicit PlantPdu(io::ModbusConfig config = {}, Image image = plant_image())
      : plant(std::move(config), std::move(image)),
        data(*plant.resource, plant.map),
        handler(data, {"PICARD", "PLC", "1.2", "", "Product", "Model", "Project"}, plant.config.read_only) {}

  Pdu ask(const Pdu& request) {
    std::array<std::uint8_t, modbus::kMaxPdu> response;
    const std::size_t size = handler.handle(request, response);
    return {response.begin(), response.begin() + static_cast<std::ptrdiff_t>(size)};
  }
  /// The exception code of the answer, 0 when it is a normal one.
  int exception(const Pdu& request) {
    const Pdu answer = ask(request);
    return answer[0] >= 0x80 ? answer[1] : 0;
  }
  /// Registers read with FC3.
  std::vector<std::uint16_t> holding(std::uint32_t first, std::uint32_t count) {
    const Pdu answer = ask(pdu_of(3, {first, count}));
    std::vector<std::uint16_t> values;
    for (std::size_t i = 2; i + 1 < answer.size(); i += 2) {
      values.push_back(static_cast<std::uint16_t>(answer[i] << 8 | answer[i + 1]));
    }
    return values;
  }

  Plant plant;
  modbus::ProcessData data;
  modbus::PduHandler handler;
};

/// A server for a plant on a free port of 127.0.0.1.
class PlantServer {
 public:
  explicit PlantServer(io::ModbusConfig config = {}, Image image = plant_image())
      : plant(free_port(std::move(config)), std::move(image)),
        responder(*plant.resource, plant.map, plant.config),
        server(responder, plant.config) {
    const auto problem = server.start();
    if (problem) throw std::runtime_error(problem->message);
  }
  [[nodiscard]] ModbusClient client(std::uint8_t from = 1) const { return ModbusClient(server.port(), from); }
  /// Whether a new client is answered rightly within a second.
  [[nodiscard]] bool serves() const {
    ModbusClient fresh = client();
    const Answer answer = fresh.ask(pdu_of(3, {kWords, 1}), 99, 1, 10'000);
    return answer.is_normal() && answer.transaction == 99 && answer.pdu.size() == 4;
  }

  Plant plant;
  modbus::Responder responder;
  modbus::Server server;

 private:
  static io::ModbusConfig free_port(io::ModbusConfig config) {
    config.port = 0;
    return config;
  }
};

}  // namespace plc::test
