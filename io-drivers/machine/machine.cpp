#include "io-drivers/machine/machine.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <unordered_set>
#include <utility>

#include "io-drivers/simulated/simulated_device.h"
#include "runtime/access.h"

namespace plc::io {
namespace {

/// Between attempts at an address that cannot be had.
constexpr core::TimeNs kListenAgainNs = 1'000'000'000;

void report(core::Diagnostics& diagnostics, const core::SourceRef& at, const core::Problem& problem) {
  diagnostics.report(problem.code, at, {}, problem.message, problem.help);
}

/// By a fault. Any thread.
bool has_stopped(const runtime::RealtimeScheduler& scheduler, std::uint32_t task) {
  return scheduler.plan(task).on_fault != runtime::FaultPolicy::kContinue &&
         scheduler.statistics(task).faults.load(std::memory_order_relaxed) != 0;
}

}  // namespace

Machine::~Machine() { stop(); }

std::unique_ptr<Machine> Machine::configure(MachineOptions options, runtime::Resource& resource,
                                            core::Diagnostics& diagnostics) {
  std::unique_ptr<Machine> machine(new Machine(resource));
  machine->configuration_ = std::move(options.configuration);
  machine->guardian_ended_ = std::move(options.guardian_ended);
  if (options.modbus) {
    ModbusConfig& modbus = machine->configuration_.modbus;
    modbus.enabled = !options.modbus->address.empty();
    modbus.address = options.modbus->address;
    modbus.port = options.modbus->port;
    modbus.listen_at = {};
  }
  machine->take_socket(options);
  if (options.simulate) machine->configuration_.modbus.serial.reset();
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
    const auto problem = options.ask_drivers ? driver->check() : std::nullopt;
    if (problem) {
      report(diagnostics, config.values.place(config.type->device_key, config.at), *problem);
    }
    machine->drivers_.push_back(std::move(driver));
  }
  if (const auto& seen = machine->binding_.client_seen; seen && machine->configuration_.modbus.serves()) {
    machine->client_seen_.emplace(resource.globals(), std::span(&seen->field, 1));
  }
  // After what was claimed, which cannot be written over Modbus.
  if (machine->configuration_.modbus.serves() && !machine->make_map(options, diagnostics)) return nullptr;
  if (diagnostics.has_errors()) return nullptr;
  return machine;
}

void Machine::take_socket(const MachineOptions& options) {
  if (!options.socket) return;
  ModbusConfig& modbus = configuration_.modbus;
  const std::string passed = listen_text(options.socket->at);
  if (!modbus.enabled) {
    notes_.push_back(
        {fmt::format("modbus: off, and nobody serves the socket {} that the service manager opened", passed)});
    return;
  }
  const std::string wanted = listen_text({modbus.address, modbus.port});
  const bool said = options.modbus || modbus.listen_at.line != 0;
  if (said && wanted != passed) {
    notes_.push_back(
        {fmt::format("modbus: the socket {} that the service manager opened counts, not {}", passed, wanted)});
  }
  modbus.address = options.socket->at.address;
  modbus.port = options.socket->at.port;
  modbus.socket = options.socket->descriptor;
}

bool Machine::make_map(const MachineOptions& options, core::Diagnostics& diagnostics) {
  auto frozen = modbus::read_frozen(modbus::lock_file_of(configuration_, options.project), resource_.image());
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
  const ModbusConfig& modbus = configuration_.modbus;
  responder_.emplace(resource_, *map_, modbus, seen);
  if (modbus.enabled) server_ = std::make_unique<modbus::Server>(*responder_, modbus);
  if (modbus.serial) serial_server_ = std::make_unique<modbus::SerialServer>(*responder_, *modbus.serial);
  return true;
}

std::optional<core::Problem> Machine::add(std::unique_ptr<Driver> driver) {
  auto problem = driver->check();
  if (!problem) drivers_.push_back(std::move(driver));
  return problem;
}

std::optional<core::Problem> Machine::open() {
  for (std::size_t i = 0; i < drivers_.size(); ++i) {
    auto problem = drivers_[i]->open();
    if (!problem) continue;
    while (i-- > 0) drivers_[i]->close();
    return problem;
  }
  GuardianOptions options;
  options.hang_timeout_ns = configuration_.guardian.hang_timeout_ns;
  options.ended = guardian_ended_;
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

void Machine::start(runtime::RealtimeScheduler& scheduler, std::vector<Sentence>& notes) {
  for (const auto& driver : drivers_) {
    driver->start();
    scheduler.add_listener(*driver);
  }
  if (pulse_) scheduler.add_listener(*pulse_);
  std::move(notes_.begin(), notes_.end(), std::back_inserter(notes));
  notes_.clear();
  if (!responder_) {
    notes.push_back({"modbus: off", core::Severity::kNote, "modbus"});
    return;
  }
  responder_->set_system([this, &scheduler, begin_ns = core::MonotonicClock().now_ns()] {
    return system_state(scheduler, core::MonotonicClock().now_ns() - begin_ns);
  });
  responder_->set_scans([&scheduler](std::uint32_t task) {
    const runtime::TaskStatistics& statistics = scheduler.statistics(task);
    return has_stopped(scheduler, task) ? modbus::kNoMoreScans : statistics.scans.load(std::memory_order_acquire);
  });
  if (serial_server_) serial_server_->start();
  if (server_) return listen(notes);
  tell_map(notes);
}

/// Any thread.
modbus::SystemState Machine::system_state(const runtime::RealtimeScheduler& scheduler, core::TimeNs ran_ns) const {
  using modbus::PlantState;
  modbus::SystemState state;
  const std::uint32_t fastest = fastest_task(resource_.image());
  bool stopped = false;
  for (std::uint32_t task = 0; task < resource_.task_count(); ++task) {
    state.faults += static_cast<std::uint32_t>(scheduler.statistics(task).faults.load(std::memory_order_relaxed));
    stopped = stopped || has_stopped(scheduler, task);
  }
  if (fastest < resource_.task_count()) {
    state.scans = static_cast<std::uint32_t>(scheduler.statistics(fastest).scans.load(std::memory_order_relaxed));
  }
  state.seconds = static_cast<std::uint32_t>(ran_ns / 1'000'000'000);
  if (forces_ != nullptr) state.forced = static_cast<std::uint16_t>(forces_->size());
  if (state.faults != 0) {
    // Of each task the first faults are kept: enough to know the kind of the last one.
    core::TimeNs latest_ns = INT64_MIN;
    for (const runtime::TaskFault& fault : scheduler.faults()) {
      if (fault.now_ns < latest_ns) continue;
      latest_ns = fault.now_ns;
      const std::string_view name = core::info(runtime::fault_code(fault.fault.kind)).name;
      std::from_chars(name.data() + 1, name.data() + name.size(), state.fault_code);
    }
  }
  state.state = scheduler.stop_requested() ? PlantState::kStops
                : stopped                  ? PlantState::kTaskStopped
                : state.faults != 0        ? PlantState::kFaulted
                : state.scans != 0         ? PlantState::kRuns
                                           : PlantState::kStarts;
  return state;
}

void Machine::listen(std::vector<Sentence>& said) {
  if (const auto problem = server_->start()) {
    if (refusal_ == problem->message) return;
    refusal_ = problem->message;
    said.push_back({fmt::format("modbus: {}: {}; it is tried again ({})", core::info(problem->code).name,
                                problem->message, problem->help),
                    core::Severity::kWarning, "modbus"});
    return;
  }
  listening_ = true;
  said.push_back({fmt::format("modbus: listening on {}, {} values (plc map lists them)",
                              listen_text({configuration_.modbus.address, server_->port()}), map_->points().size()),
                  core::Severity::kNote, "modbus"});
  const std::uint32_t wanted = configuration_.modbus.max_clients;
  if (server_->places() < wanted) {
    said.push_back({fmt::format("modbus: {}: {} clients at a time, not {}: the process may not have more descriptors "
                                "(raise LimitNOFILE of the service, or ulimit -n)",
                                core::info(core::Code::P7511).name, server_->places(), wanted),
                    core::Severity::kWarning, "modbus"});
  }
  tell_map(said);
}

void Machine::tell_map(std::vector<Sentence>& said) const {
  if (freeze_command_.empty()) return;
  said.push_back({"modbus: automatic addresses are not frozen and may move with the next change: " + freeze_command_,
                  core::Severity::kNote, "modbus"});
}

std::vector<Sentence> Machine::service(core::TimeNs now_ns) {
  std::vector<Sentence> said;
  for (const auto& driver : drivers_) {
    for (Sentence& sentence : driver->service(now_ns)) {
      said.push_back(std::move(sentence));
      said.back().source = driver->name();
    }
  }
  if (server_ && !listening_ && now_ns >= next_listen_ns_) {
    next_listen_ns_ = now_ns + kListenAgainNs;
    listen(said);
  }
  if (serial_server_) {
    for (Sentence& sentence : serial_server_->take_said()) said.push_back(std::move(sentence));
  }
  return said;
}

void Machine::stopping() {
  if (pulse_) pulse_->stopping();
}

void Machine::stop() {
  if (server_) server_->stop();
  if (serial_server_) serial_server_->stop();
  std::vector<Driver*> all;
  for (const auto& driver : drivers_) all.push_back(driver.get());
  for_all_at_once(all, [](Driver& driver) { driver.close(); });
  if (pulse_) pulse_->finished();
}

std::vector<runtime::SafeValue> Machine::safe_values() const {
  std::vector<runtime::SafeValue> values;
  for (const BoundDriver& driver : binding_.drivers) {
    for (const BoundChannel& output : driver.outputs) values.push_back({output.offset, output.type, output.safe});
  }
  if (configuration_.scheduler.outputs == FaultOutputs::kHold) return values;
  std::unordered_set<std::uint32_t> known;
  for (const runtime::SafeValue& value : values) known.insert(value.offset);
  const bytecode::Image& image = resource_.image();
  const runtime::Access access(resource_);
  for (const runtime::Listed& listed : access.list_places("*")) {
    const bytecode::ImageType& type = image.types[listed.place.type];
    if (listed.place.task != runtime::Place::kGlobal || type.kind != bytecode::TypeKind::kScalar) continue;
    const std::uint32_t field = resource_.globals().field_of(listed.place.offset);
    if (!image.globals[field].address.starts_with("%Q") || !known.insert(listed.place.offset).second) continue;
    const auto initial = image.global_initial.begin() + listed.place.offset;
    values.push_back({listed.place.offset, listed.place.type, {initial, initial + type.size}});
  }
  return values;
}

std::optional<modbus::ServerStatistics> Machine::modbus_statistics() const {
  if (!server_) return std::nullopt;
  return server_->statistics();
}

std::optional<modbus::SerialStatistics> Machine::serial_statistics() const {
  if (!serial_server_) return std::nullopt;
  return serial_server_->statistics();
}

}  // namespace plc::io
