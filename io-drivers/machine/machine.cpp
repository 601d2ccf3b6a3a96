#include "io-drivers/machine/machine.h"

#include <algorithm>

#include "io-drivers/simulated/simulated_device.h"

namespace plc::io {
namespace {

void report(core::Diagnostics& diagnostics, const core::SourceRef& at, const core::Problem& problem) {
  diagnostics.report(problem.code, at, {}, problem.message, problem.help);
}

}  // namespace

Machine::~Machine() { stop(); }

std::unique_ptr<Machine> Machine::configure(MachineOptions options, runtime::Resource& resource,
                                            core::Diagnostics& diagnostics) {
  std::unique_ptr<Machine> machine(new Machine(resource));
  machine->configuration_ = std::move(options.configuration);
  machine->modbus_asked_for_ = machine->configuration_.modbus.listen_at.line != 0;
  if (options.modbus) {
    ModbusConfig& modbus = machine->configuration_.modbus;
    modbus.enabled = !options.modbus->address.empty();
    modbus.address = options.modbus->address;
    modbus.port = options.modbus->port;
    modbus.listen_at = {};
    machine->modbus_asked_for_ = true;
  }
  std::vector<bool> stands_in;  // for a device, by driver
  for (DriverConfig& driver : machine->configuration_.drivers) {
    stands_in.push_back(options.simulate && driver.type->real);
    if (!stands_in.back()) continue;
    driver.type = &kSimulatedType;
    driver.values = KeyValues(kSimulatedType.driver_keys);
  }
  auto binding = bind(machine->configuration_, resource, diagnostics);
  if (!binding) return nullptr;
  machine->binding_ = std::move(*binding);
  for (BoundDriver& bound : machine->binding_.drivers) {
    const auto index = static_cast<std::size_t>(bound.config - machine->configuration_.drivers.data());
    if (stands_in[index]) bound.inputs.clear();
  }
  for (const BoundDriver& bound : machine->binding_.drivers) {
    const DriverConfig& config = *bound.config;
    auto driver = config.type->make(bound, machine->configuration_, resource);
    if (const auto problem = driver->check()) {
      report(diagnostics, config.values.place(config.type->device_key, config.at), *problem);
    }
    machine->drivers_.push_back(std::move(driver));
  }
  if (const auto& seen = machine->binding_.client_seen; seen && machine->configuration_.modbus.enabled) {
    machine->client_seen_.emplace(resource.globals(), std::span(&seen->field, 1));
  }
  // After what was claimed, which cannot be written over Modbus.
  if (machine->configuration_.modbus.enabled && !machine->make_map(options, diagnostics)) return nullptr;
  if (diagnostics.has_errors()) return nullptr;
  return machine;
}

bool Machine::make_map(const MachineOptions& options, core::Diagnostics& diagnostics) {
  auto frozen = modbus::read_frozen(modbus::lock_file_of(configuration_, options.project));
  if (!frozen) {
    const core::SourceRef& at = configuration_.modbus.lock_file.at;
    report(diagnostics, at.line != 0 ? at : configuration_.at, frozen.error());
    return false;
  }
  map_ = modbus::AddressMap::build(resource_, configuration_.modbus, *frozen, diagnostics);
  if (!map_) return false;
  if (frozen->changed) {
    freeze_command_ = (options.map_command.empty() ? "plc map " + options.project : options.map_command) +
                      (configuration_.file.empty() ? "" : " --config " + configuration_.file) + " --freeze";
  }
  std::optional<modbus::SeenFlag> seen;
  if (client_seen_) seen = {&*client_seen_, binding_.client_seen->offset, binding_.client_seen->type};
  server_ = std::make_unique<modbus::Server>(resource_, *map_, configuration_.modbus, seen);
  return true;
}

std::optional<core::Problem> Machine::add(std::unique_ptr<Driver> driver) {
  auto problem = driver->check();
  if (!problem) drivers_.push_back(std::move(driver));
  return problem;
}

std::optional<core::Problem> Machine::open() {
  // A port that another process has is found before an output moves.
  if (server_ && modbus_asked_for_) {
    if (auto problem = server_->check()) return problem;
  }
  for (std::size_t i = 0; i < drivers_.size(); ++i) {
    auto problem = drivers_[i]->open();
    if (!problem) continue;
    while (i-- > 0) drivers_[i]->close();
    return problem;
  }
  GuardianOptions options;
  options.hang_timeout_ns = configuration_.guardian.hang_timeout_ns;
  bool outputs = false;
  std::vector<Driver*> all;  // also those with inputs only: the guardian shares their handles, and lets go of dead ones
  for (const auto& driver : drivers_) {
    all.push_back(driver.get());
    if (!driver->has_outputs()) continue;
    outputs = true;
    const bytecode::ImageTask& task = resource_.image().tasks[driver->task()];
    const auto known = [&](const WatchedTask& w) { return w.task == driver->task(); };
    if (!task.single.empty() || std::any_of(options.watched.begin(), options.watched.end(), known)) continue;
    options.watched.push_back({driver->task(), task.name, runtime::grid_period(task)});
  }
  if (!outputs || !configuration_.guardian.enabled) return std::nullopt;
  auto pulse = start_guardian(options, all);
  if (!pulse) {
    for (const auto& driver : drivers_) driver->close();
    return pulse.error();
  }
  pulse_ = std::move(*pulse);
  return std::nullopt;
}

std::optional<core::Problem> Machine::start(runtime::RealtimeScheduler& scheduler, std::vector<std::string>& notes) {
  for (const auto& driver : drivers_) {
    driver->start();
    scheduler.add_listener(*driver);
  }
  if (pulse_) scheduler.add_listener(*pulse_);
  if (!server_) {
    notes.push_back("modbus: off");
    return std::nullopt;
  }
  if (auto problem = server_->start()) {
    if (modbus_asked_for_) return problem;
    notes.push_back("modbus: off: " + problem->message + " (--modbus 127.0.0.1:PORT takes another one)");
    return std::nullopt;
  }
  const bool six = configuration_.modbus.address.find(':') != std::string::npos;
  notes.push_back("modbus: listening on " +
                  (six ? "[" + configuration_.modbus.address + "]" : configuration_.modbus.address) + ":" +
                  std::to_string(server_->port()) + ", " + std::to_string(map_->points().size()) +
                  " values (plc map lists them)");
  if (!freeze_command_.empty()) {
    notes.push_back("modbus: automatic addresses are not frozen and may move with the next change: " + freeze_command_);
  }
  return std::nullopt;
}

std::vector<std::string> Machine::service(core::TimeNs now_ns) {
  std::vector<std::string> sentences;
  for (const auto& driver : drivers_) {
    for (std::string& sentence : driver->service(now_ns)) sentences.push_back(std::move(sentence));
  }
  return sentences;
}

void Machine::stopping() {
  if (pulse_) pulse_->stopping();
}

void Machine::stop() {
  if (server_) server_->stop();
  for (const auto& driver : drivers_) driver->close();
  if (pulse_) pulse_->finished();
}

std::vector<runtime::SafeValue> Machine::safe_values() const {
  std::vector<runtime::SafeValue> values;
  for (const BoundDriver& driver : binding_.drivers) {
    for (const BoundChannel& output : driver.outputs) values.push_back({output.offset, output.type, output.safe});
  }
  return values;
}

std::optional<modbus::ServerStatistics> Machine::modbus_statistics() const {
  if (!server_) return std::nullopt;
  return server_->statistics();
}

}  // namespace plc::io
