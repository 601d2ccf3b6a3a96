// The row of kind = "simulated".
#include "io-drivers/simulated/simulated_device.h"

namespace plc::io {
namespace {

constexpr KeyInfo kDriverKeys[] = {
    {"stimulus", key::text(), key::otherwise("\"\""),
     "CSV file with the values of variables over time, as `plc sim --stimulus` takes it; relative to plc.toml. It may "
     "name more than what is in [inputs]. Empty: inputs keep their initial values."},
};
constexpr KeyInfo kChannelKeys[] = {
    {"channel", key::channel(), key::otherwise("\"\""), "Not used, may be omitted."},
};

std::string stimulus_of(const BoundDriver& bound, const Configuration& configuration) {
  return configuration.beside(bound.config->values.text("stimulus"));
}

std::optional<core::Problem> check_files(const BoundDriver& bound, const Configuration& configuration,
                                         runtime::Resource& resource) {
  const std::string path = stimulus_of(bound, configuration);
  if (path.empty()) return std::nullopt;
  const auto stimulus = Stimulus::load(path, resource);
  return stimulus ? stimulus->check_real_time(path, bound.task) : stimulus.error();
}

std::unique_ptr<Driver> make(const BoundDriver& bound, const Configuration& configuration,
                             runtime::Resource& resource) {
  auto device =
      std::make_unique<SimulatedDevice>(bound.config->name, stimulus_of(bound, configuration), bound.task, resource);
  device->claim(bound);
  return device;
}

}  // namespace

constexpr DriverType kSimulatedType = {
    .name = "simulated",
    .summary = "no device; inputs by a script, outputs go nowhere.",
    .example = "plant",
    .real = false,
    .driver_keys = kDriverKeys,
    .channel_keys = kChannelKeys,
    .device_key = "stimulus",
    .check_files = check_files,
    .make = make,
};

}  // namespace plc::io
