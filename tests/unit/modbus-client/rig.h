// Rig: a device as plc.toml describes it, on a resource in virtual time, and a link that does what the test says.
//
// In: text of a plc.toml with one driver "dev". Out: globals In0.. (INT), Out0.. (INT), Flag, Lamp, Real, Ok, Age,
// Error, Text, Label (STRING[10]); Task0 copies In0 to Out0, In1 to Out1, Flag to Lamp, Text to Label. Does not belong
// here: sockets.
#pragma once

#include <gtest/gtest.h>

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "io-drivers/config/bind.h"
#include "io-drivers/modbus-client/modbus_driver.h"
#include "runtime/access.h"
#include "runtime/sched/simulation.h"
#include "tests/support/image_builder.h"

namespace plc::test {

using modbus_client::Bytes;
using modbus_client::Cells;
using modbus_client::Error;

/// Copies; every variable that plc.toml may name.
inline std::unique_ptr<runtime::Resource> copier() {
  ImageBuilder b;
  const std::uint32_t integer = b.type(TypeId::kInt);
  std::vector<Word> in, out;
  for (int i = 0; i < 8; ++i) in.push_back(b.global("In" + std::to_string(i), integer, {}, {.input = true}));
  const Word flag = b.global("Flag", b.boolean(), {}, {.input = true});
  b.global("Real", b.type(TypeId::kReal), {}, {.input = true});
  b.global("Ok", b.boolean(), {}, {.input = true});
  b.global("Age", b.type(TypeId::kTime), {}, {.input = true});
  b.global("Error", b.type(TypeId::kUint), {}, {.input = true});
  const Word text = b.global("Text", b.string(10), {}, {.input = true});
  for (int i = 0; i < 2; ++i) out.push_back(b.global("Out" + std::to_string(i), integer));
  const Word lamp = b.global("Lamp", b.boolean());
  const Word label = b.global("Label", b.string(10));
  const auto zero = b.constant<std::int16_t>(TypeId::kInt, 0);
  PouBuilder pou = b.pou("Main", PouKind::kProgram);
  for (std::size_t i = 0; i < 2; ++i) pou.op(Opcode::kAdd16, {out[i], in[i], zero});
  pou.record(0xaaaaaaaau, lamp, {flag});
  pou.op(Opcode::kMoveStr, {label, text});
  b.task("Task0", 10'000'000, {pou.finish()});
  core::Diagnostics diagnostics;
  auto verified = bytecode::verify(b.build(), diagnostics);
  for (const core::Diagnostic& d : diagnostics.all()) ADD_FAILURE() << diagnostics.render_one(d);
  return std::move(runtime::Resource::load(std::move(verified.value())).value());
}

/// Registers and coils of a device in memory, and what goes wrong next.
class FakeLink final : public modbus_client::Link {
 public:
  Error exchange(std::uint8_t unit, std::span<const std::uint8_t> pdu, core::TimeNs timeout_ns,
                 Bytes& answer) override {
    EXPECT_EQ(unit, 7);
    requests.emplace_back(pdu.begin(), pdu.end());
    Error error = always;
    if (!next.empty()) {
      error = next.front();
      next.pop_front();
    }
    if (silent == static_cast<std::uint16_t>(pdu[1] << 8 | pdu[2])) error = Error::kNoAnswer;
    // A silent device takes all the time there is.
    clock.sleep_until_ns(clock.now_ns() + (error == Error::kNoAnswer ? timeout_ns : 1'000'000));
    const auto first = static_cast<std::uint16_t>(pdu[1] << 8 | pdu[2]);
    const auto count = static_cast<std::uint16_t>(pdu[3] << 8 | pdu[4]);
    if (error == Error::kNone && pdu[0] >= 1 && pdu[0] <= 4) {
      for (std::uint32_t i = 0; i < count; ++i) {
        if (holes.contains(static_cast<std::uint16_t>(first + i))) error = Error::kIllegalAddress;
      }
    }
    if (modbus_client::is_exception(error)) {
      answer = {static_cast<std::uint8_t>(pdu[0] | 0x80), static_cast<std::uint8_t>(error)};
      return Error::kNone;
    }
    if (error != Error::kNone) return error;
    answer = {pdu[0]};
    switch (pdu[0]) {
      case 1:
      case 2:
        answer.resize(2 + (count + 7) / 8);
        answer[1] = static_cast<std::uint8_t>((count + 7) / 8);
        for (std::uint32_t i = 0; i < count; ++i) {
          if (coils[static_cast<std::uint16_t>(first + i)] != 0)
            answer[2 + i / 8] |= static_cast<std::uint8_t>(1 << i % 8);
        }
        break;
      case 3:
      case 4:
        answer.push_back(static_cast<std::uint8_t>(count * 2));
        for (std::uint32_t i = 0; i < count; ++i) {
          const std::uint16_t value = registers[static_cast<std::uint16_t>(first + i)];
          answer.push_back(static_cast<std::uint8_t>(value >> 8));
          answer.push_back(static_cast<std::uint8_t>(value));
        }
        break;
      case 5:
        coils[first] = pdu[3] != 0 ? 1 : 0;
        answer.assign(pdu.begin(), pdu.begin() + 5);
        break;
      case 6:
        registers[first] = count;
        answer.assign(pdu.begin(), pdu.begin() + 5);
        break;
      case 16:
        for (std::uint32_t i = 0; i < count; ++i) {
          registers[static_cast<std::uint16_t>(first + i)] =
              static_cast<std::uint16_t>(pdu[6 + 2 * i] << 8 | pdu[7 + 2 * i]);
        }
        answer.assign(pdu.begin(), pdu.begin() + 5);
        break;
      default:
        answer = {static_cast<std::uint8_t>(pdu[0] | 0x80), 1};
    }
    return Error::kNone;
  }

  core::VirtualClock clock;
  std::map<std::uint16_t, std::uint16_t> registers, coils, holes;
  std::deque<Error> next;               ///< for the next exchanges
  Error always = Error::kNone;          ///< for those after them
  std::optional<std::uint16_t> silent;  ///< requests from this address on have no answer
  std::vector<Bytes> requests;
};

struct Rig {
  explicit Rig(const std::string& text) : resource(copier()) {
    static constexpr const io::DriverType* types[] = {&modbus_client::kModbusType};
    core::Diagnostics diagnostics;
    configuration = io::read_configuration(text, "plc.toml", types, diagnostics);
    std::optional<io::Binding> binding;
    if (configuration) binding = io::bind(*configuration, *resource, diagnostics);
    for (const core::Diagnostic& d : diagnostics.all()) ADD_FAILURE() << diagnostics.render_one(d);
    const io::BoundDriver& bound = binding.value().drivers.at(0);
    auto points = modbus_client::points_of(bound, *resource);
    device = std::make_unique<modbus_client::Device>(
        modbus_client::settings_of(*bound.config), bound.task, std::move(points.reads), std::move(points.status),
        std::move(points.writes), io::claimed_fields(bound), resource->globals());
    simulation = std::make_unique<runtime::Simulation>(*resource);
    device->begin(0);
  }

  [[nodiscard]] std::string value(const std::string& path) const {
    const runtime::Access variables(*resource);
    return variables.read(*variables.find(path));
  }
  void scan() {
    simulation->run_cycles(1);
    device->scanned(0);
  }
  /// Turns until so much time has passed.
  void run(core::TimeNs ns) {
    const core::TimeNs end = link.clock.now_ns() + ns;
    for (int turns = 0; device->due() <= end; ++turns) {
      ASSERT_LT(turns, 100'000) << "turns without end";
      link.clock.sleep_until_ns(device->due());
      device->turn(link, link.clock);
    }
    link.clock.sleep_until_ns(end);
  }
  std::string said() {
    std::string all;
    for (const io::Sentence& said : device->take_said(link.clock.now_ns())) all += said.text + '\n';
    return all;
  }

  std::unique_ptr<runtime::Resource> resource;
  std::optional<io::Configuration> configuration;
  FakeLink link;
  std::unique_ptr<modbus_client::Device> device;
  std::unique_ptr<runtime::Simulation> simulation;
};

}  // namespace plc::test
