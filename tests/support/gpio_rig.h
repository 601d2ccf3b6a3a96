// GpioRig: GPIO drivers on a resource in virtual time, for tests on a chip in memory and on the kernel's simulated one.
//
// In: text of a plc.toml, access to lines. Out: variables in0.. at %IX0.0.., out0.. at %QX0.0.., "ok"; Task0 copies
// each input to the output of its number. Does not belong here: real time, what the lines do.
#pragma once

#include <cstdlib>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io-drivers/config/bind.h"
#include "io-drivers/gpio/gpio_driver.h"
#include "runtime/access.h"
#include "runtime/sched/simulation.h"
#include "tests/support/image_builder.h"

namespace plc::test {

/// A resource whose programs copy input i to output i, and a driver for them as `toml` says. Tasks are 10 ms apart.
struct GpioRig {
  GpioRig(const std::string& toml, const io::GpioAccess& access, int points = 4, int tasks = 1) {
    ImageBuilder b;
    const auto at = [](int i) { return std::to_string(i / 8) + "." + std::to_string(i % 8); };
    std::vector<Word> in, out;
    for (int i = 0; i < points; ++i) {
      in.push_back(b.global("in" + std::to_string(i), b.boolean(), {}, {.input = true, .address = "%IX" + at(i)}));
    }
    b.global("ok", b.boolean(), {}, {.input = true});
    for (int i = 0; i < points; ++i) {
      out.push_back(b.global("out" + std::to_string(i), b.boolean(), {}, {.address = "%QX" + at(i)}));
    }
    for (int task = 0; task < tasks; ++task) {
      PouBuilder pou = b.pou("P" + std::to_string(task), PouKind::kProgram);
      for (int i = 0; task == 0 && i < points; ++i) pou.record(0xaaaaaaaau, out[std::size_t(i)], {in[std::size_t(i)]});
      b.task("Task" + std::to_string(task), 10'000'000, {pou.finish()});
    }
    core::Diagnostics diagnostics;
    auto verified = bytecode::verify(b.build(), diagnostics);
    stop_at(verified.has_value(), diagnostics);
    resource = std::move(*runtime::Resource::load(std::move(*verified)));
    static constexpr const io::DriverType* types[] = {&io::kGpioType};
    configuration = io::read_configuration(toml, "plc.toml", types, diagnostics);
    std::optional<io::Binding> binding;
    if (configuration) binding = io::bind(*configuration, *resource, diagnostics);
    stop_at(binding.has_value(), diagnostics);
    simulation = std::make_unique<runtime::Simulation>(*resource);
    for (const io::BoundDriver& bound : binding->drivers) {
      drivers.push_back(std::make_unique<io::GpioDriver>(bound, *resource, access));
      simulation->add_listener(*drivers.back());
    }
  }

  [[nodiscard]] std::string value(const std::string& path) const {
    const runtime::Access variables(*resource);
    return variables.read(*variables.find(path));
  }
  /// Sentences of all drivers, a line each.
  std::string serve() {
    std::string all;
    for (const auto& driver : drivers) {
      for (const io::Sentence& said : driver->service(simulation->now_ns())) all += said.text + "\n";
    }
    return all;
  }

  static void stop_at(bool good, const core::Diagnostics& diagnostics) {
    if (good) return;
    diagnostics.render(std::cerr);
    std::abort();
  }

  std::unique_ptr<runtime::Resource> resource;
  std::optional<io::Configuration> configuration;
  std::vector<std::unique_ptr<io::GpioDriver>> drivers;
  std::unique_ptr<runtime::Simulation> simulation;
};

}  // namespace plc::test
