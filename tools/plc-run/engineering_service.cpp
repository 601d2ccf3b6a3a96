#include "tools/plc-run/engineering_service.h"

#include <fmt/format.h>

#include <filesystem>
#include <ostream>
#include <utility>

#include "tools/command_line.h"
#include "tools/version.h"
#include "web/files.h"

namespace plc::tools {
namespace {

constexpr core::TimeNs kServiceNs = 100'000'000;

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
  engineering::Options& options = request.options;
  options.address = listen ? listen->address : config.address;
  options.port = listen ? listen->port : config.port;
  options.max_clients = config.max_clients;
  for (const io::Placed& host : config.hosts) options.hosts.push_back(host.text);
  options.always_tls = config.tls == io::EngineeringTls::kEverywhere;
  options.certificate = configuration.beside(config.certificate.text);
  options.key = configuration.beside(config.key.text);
  options.no_force = config.no_force.text;
  options.no_program = config.no_program.text;
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
  forces_.emplace(resource);
  log_.also_tell([this](const log::Record& record) { book_.add(record); });
}

EngineeringService::~EngineeringService() {
  if (request_.on) log_.also_tell({});
}

void EngineeringService::tell(const std::vector<engineering::Said>& all) {
  for (const engineering::Said& said : all) {
    if (said.severity == core::Severity::kNote) {
      log_.talk() << said.text << std::endl;
    } else {
      log_.say(said.severity, said.text, "engineering");
    }
  }
}

void EngineeringService::prepare(const io::Plant& plant, shadow::Shadow* shadow, bool warm) {
  if (!request_.on) {
    log_.talk() << "engineering: off\n";
    return;
  }
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
  server_->take_over(program_.from_server());
  tell(server_->force_again(warm));
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

void EngineeringService::service(core::TimeNs now_ns) {
  if (!server_ || now_ns < next_ns_) return;
  next_ns_ = now_ns + kServiceNs;
  tell(server_->service(now_ns));
}

void EngineeringService::stop() {
  if (!server_) return;
  server_->stop();
  values_->detach();
}

}  // namespace plc::tools
