#include "tools/plc-run/engineering_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <ostream>
#include <utility>

#include "tools/command_line.h"
#include "tools/version.h"
#include "web/files.h"

namespace plc::tools {
namespace {

constexpr core::TimeNs kServiceNs = 100'000'000;
constexpr core::TimeNs kDevicesNs = 500'000'000;

/// What people call the plant: "plant" of "/etc/picard/plant/plant.xml".
std::string plant_name(const std::string& project) {
  std::filesystem::path path(project);
  if (!path.has_filename()) path = path.parent_path();
  return path.stem().string();
}

}  // namespace

EngineeringRequest engineering_request(const io::Configuration& configuration,
                                       const std::optional<io::ListenText>& listen, const std::string& project,
                                       const std::string& state) {
  const io::EngineeringConfig& config = configuration.engineering;
  EngineeringRequest request;
  request.on = listen ? !listen->address.empty() : config.enabled;
  request.project = project;
  const std::filesystem::path beside(configuration.file.empty() ? project : configuration.file);
  std::error_code none;
  request.tables = (std::filesystem::is_directory(beside, none) ? beside : beside.parent_path()).string();
  if (request.tables.empty()) request.tables = ".";
  request.state = state;
  engineering::Options& options = request.options;
  options.address = listen ? listen->address : config.address;
  options.port = listen ? listen->port : config.port;
  options.max_clients = config.max_clients;
  for (const io::Placed& host : config.hosts) options.hosts.push_back(host.text);
  options.always_tls = config.tls == io::EngineeringTls::kEverywhere;
  options.certificate = configuration.beside(config.certificate.text);
  options.key = configuration.beside(config.key.text);
  request.no_force = config.no_force.text;
  request.no_program = config.no_program.text;
  if (!state.empty()) options.folder = state + "/engineering";
  options.pages = web::files();
  for (const io::Placed& keys : config.keys) request.keys.push_back(configuration.beside(keys.text));
  return request;
}

EngineeringService::EngineeringService(EngineeringRequest request, runtime::Resource& resource, RunLog& log,
                                       ProgramStart& program)
    : request_(std::move(request)), resource_(resource), log_(log), program_(program) {
  if (!request_.on) return;
  engineering::take_over(program_.from_log(), book_);
  values_.emplace(resource.globals());
  no_force_.emplace(resource, request_.no_force);
  no_program_.emplace(resource, request_.no_program);
  request_.options.no_force = &*no_force_;
  request_.options.no_program = &*no_program_;
  alarms_.emplace(request_.tables + "/alarms.toml", resource, request_.recorded);
  history_.emplace(request_.tables + "/historian.toml", resource);
  forces_.emplace(resource);
  log_.also_tell([this](const log::Record& record) { book_.add(record); });
}

EngineeringService::~EngineeringService() {
  if (request_.on) log_.also_tell({});
}

void EngineeringService::tell(const std::vector<engineering::Said>& all, const std::string& source) {
  for (const engineering::Said& said : all) {
    if (said.severity == core::Severity::kNote) {
      log_.talk() << said.text << std::endl;
    } else {
      log_.say(said.severity, said.text, source);
    }
  }
}

void EngineeringService::prepare(io::Plant& plant, shadow::Shadow* shadow, bool warm) {
  if (!request_.on) {
    log_.talk() << "engineering: off\n";
    return;
  }
  plant_ = &plant;
  engineering::Identity identity;
  identity.product = kVersionText;
  identity.plant = plant_name(request_.project);
  identity.project_path = request_.project;
  identity.options = describe(resource_.image().options);
  identity.image_hash = program_.image_hash();
  server_ = std::make_unique<engineering::Engineering>(request_.options, std::move(identity), resource_, *values_,
                                                       *forces_, plant.scheduler(), book_, clock_, calendar_);
  if (shadow != nullptr) values_->attach(*shadow);
  server_->set_shadow(shadow);
  read_keys();
  server_->set_program(&program_.control());
  if (auto failed = program_.failed_start()) server_->note_failed_start(program_.asked_by(), std::move(*failed));
  server_->take_over(program_.from_server());
  if (!program_.settled()) {
    server_->on_sessions([this](std::string handover) { program_.hand_over_on_trial(std::move(handover)); });
  }
  tell(server_->force_again(warm, !program_.settled()));
  std::vector<engineering::Said> said;
  alarms_->open(request_.state, shadow, said);
  tell(said, "alarms");
  server_->set_alarms(alarms_->alarms(), alarms_->store());
  said.clear();
  history_->open(request_.state, resource_, shadow, calendar_, said);
  tell(said, "historian");
  server_->set_historian(history_->historian());
}

void EngineeringService::start() {
  if (server_) tell(server_->start());
}

void EngineeringService::read_keys() {
  engineering::ProgramControl& control = program_.control();
  control.wants_signature = !request_.keys.empty();
  for (const std::string& path : request_.keys) {
    auto keys = engineering::read_public_key_files(path);
    if (keys) {
      control.keys.insert(control.keys.end(), keys->begin(), keys->end());
    } else {
      log_.say(core::Severity::kWarning,
               fmt::format("engineering: {}: {}: images that it has signed are refused",
                           core::info(keys.error().code).name, keys.error().message),
               "engineering");
    }
  }
}

void EngineeringService::note_devices(core::TimeNs now_ns) {
  const io::Machine& machine = plant_->machine();
  engineering::Devices devices;
  for (const auto& driver : machine.drivers()) {
    const io::DriverStatus status = driver->status();
    engineering::DeviceState one;
    one.name = driver->name();
    one.state = driver->timing() == io::Timing::kOffline ? "simulated" : status.connected ? "good" : "lost";
    one.problem = status.problem;
    one.outputs = driver->has_outputs();
    one.losses = status.losses;
    one.recoveries = status.recoveries;
    one.exchanges = status.exchanges;
    for (const io::InputStatus& input : driver->inputs(now_ns)) {
      ++one.inputs;
      one.inputs_good += input.quality == io::Quality::kGood ? 1 : 0;
      one.oldest_ns = std::max(one.oldest_ns, input.age_ns);
    }
    devices.drivers.push_back(std::move(one));
  }
  if (const auto tcp = machine.modbus_statistics())
    devices.modbus.push_back({"TCP", tcp->clients, tcp->requests, tcp->exceptions, tcp->refused, tcp->dropped});
  if (const auto serial = machine.serial_statistics())
    devices.modbus.push_back({"serial", 0, serial->requests, serial->exceptions, 0, serial->damaged});
  server_->note_devices(std::move(devices));
}

void EngineeringService::service(core::TimeNs now_ns) {
  if (!server_ || now_ns < next_ns_) return;
  next_ns_ = now_ns + kServiceNs;
  if (program_.settled()) server_->confirmed();
  tell(server_->service(now_ns));
  if (now_ns >= next_devices_ns_) {
    next_devices_ns_ = now_ns + kDevicesNs;
    note_devices(now_ns);
  }
  std::vector<engineering::Said> said;
  alarms_->service(plant_->scheduler().program_ns(now_ns), calendar_.utc_ns(), program_.settled(), said);
  tell(said, "alarms");
  said.clear();
  history_->service(said);
  tell(said, "historian");
}

void EngineeringService::stop() {
  if (!server_) return;
  if (program_.settled()) server_->confirmed();
  server_->stop();
  values_->detach();
  alarms_->stop(program_.settled());
  history_->stop();
}

}  // namespace plc::tools
