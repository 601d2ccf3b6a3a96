#include "io-drivers/config/bind.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <tuple>
#include <unordered_map>

#include "core/guess.h"
#include "core/text.h"
#include "io-drivers/config/driver_type.h"
#include "io-drivers/config/findings.h"
#include "runtime/access.h"
#include "runtime/value_text.h"

namespace plc::io {
namespace {

using bytecode::Image;
using bytecode::ImageField;
using bytecode::ImageTask;
using bytecode::ImageType;
using bytecode::TypeKind;
using core::Code;

std::string type_name(const ImageType& type) {
  return type.name.empty() ? std::string(core::name_of(type.elementary)) : type.name;
}

class Binder {
 public:
  Binder(const Configuration& configuration, runtime::Resource& resource)
      : configuration_(configuration), resource_(resource), image_(resource.image()), access_(resource) {}

  Binding run() {
    Binding binding;
    for (const DriverConfig& driver : configuration_.drivers) {
      drivers_.emplace(driver.name, binding.drivers.size());
      BoundDriver& bound = binding.drivers.emplace_back();
      bound.config = &driver;
      bound.task = task_of(driver);
    }
    for (const ChannelConfig& channel : configuration_.inputs) bind_input(channel, binding);
    for (const ChannelConfig& channel : configuration_.outputs) bind_output(channel, binding);
    for (BoundDriver& driver : binding.drivers) {
      if (!driver.config->ok.text.empty()) driver.ok = bind_flag("ok", driver.config->ok, driver.config);
    }
    const Placed& seen = configuration_.modbus.client_seen;
    if (!seen.text.empty()) binding.client_seen = bind_flag("client_seen", seen, nullptr);
    check_flag("no_force", configuration_.engineering.no_force);
    check_flag("no_program", configuration_.engineering.no_program);
    check_certificate();
    if (!binding.drivers.empty()) find_unmapped_outputs();
    return binding;
  }

  void report(core::Diagnostics& diagnostics) { findings_.report(diagnostics); }

 private:
  [[nodiscard]] const std::vector<ImageField>& globals() const { return image_.types[image_.global_type].fields; }

  /// The task a driver serves; the fastest when it names none.
  std::uint32_t task_of(const DriverConfig& driver) {
    const std::string_view name = core::trimmed(driver.task.text);
    std::uint32_t chosen = fastest_task(image_);
    if (!name.empty()) {
      const auto found = std::find_if(image_.tasks.begin(), image_.tasks.end(),
                                      [&](const ImageTask& task) { return core::iequals(task.name, name); });
      if (found == image_.tasks.end()) {
        core::Guess guess(name);
        std::string all;
        for (const ImageTask& task : image_.tasks) {
          guess.offer(task.name);
          all += (all.empty() ? "" : ", ") + task.name;
        }
        const std::string help = guess.help();
        findings_.add(Code::P7328, driver.task.at, fmt::format("no task \"{}\"", name),
                      help.empty() ? "the project has " + all : help);
        return chosen;
      }
      chosen = static_cast<std::uint32_t>(found - image_.tasks.begin());
    }
    if (chosen < image_.tasks.size() && !image_.tasks[chosen].single.empty()) {
      findings_.add(Code::P7329, name.empty() ? driver.at : driver.task.at,
                    fmt::format("driver \"{}\" works in task \"{}\", which waits for {} to rise", driver.name,
                                image_.tasks[chosen].name, image_.tasks[chosen].single),
                    "let it serve a task with an interval");
    }
    return chosen;
  }

  /// The global that a key means, once for each. `help`: for one that is not there.
  std::optional<BoundChannel> resolve(const Placed& variable, std::string_view help = {}) {
    const core::Result<runtime::Place> place = access_.find_leaf(variable.text);
    if (!place) {
      findings_.add(Code::P7320, variable.at, place.error().message,
                    place.error().help.empty() ? std::string(help) : place.error().help);
      return std::nullopt;
    }
    if (place->task != runtime::Place::kGlobal) {
      findings_.add(Code::P7321, variable.at,
                    fmt::format("\"{}\" is a variable of task \"{}\"", variable.text, image_.tasks[place->task].name),
                    "declare it AT an address, or copy it into a global");
      return std::nullopt;
    }
    if (place->constant) {
      findings_.add(Code::P7324, variable.at, fmt::format("\"{}\" is a constant", variable.text));
      return std::nullopt;
    }
    const auto [first, fresh] = used_.emplace(place->offset, &variable);
    if (!fresh) {
      findings_.add(
          Code::P7309, variable.at,
          core::iequals(variable.text, first->second->text)
              ? fmt::format("\"{}\" is configured twice, first at line {}", variable.text, first->second->at.line)
              : fmt::format("\"{}\" is the same variable as \"{}\" in line {}", variable.text, first->second->text,
                            first->second->at.line),
          "one variable has one channel");
      return std::nullopt;
    }
    BoundChannel channel;
    channel.offset = place->offset;
    channel.type = place->type;
    const auto next = std::upper_bound(globals().begin(), globals().end(), place->offset,
                                       [](std::uint32_t offset, const ImageField& f) { return offset < f.offset; });
    channel.field = static_cast<std::uint32_t>(next - globals().begin()) - 1;
    return channel;
  }

  /// Whether the variable has an address in this area: 'I', 'Q' or 'M'.
  [[nodiscard]] bool is_at(const BoundChannel& channel, char area) const {
    const std::string& address = image_.globals[channel.field].address;
    return address.size() >= 2 && core::upper(address[1]) == area;
  }

  /// Whether the variable can be an input of `owner`: a driver, or null for the Modbus server.
  bool claim(const Placed& variable, const BoundChannel& channel, const DriverConfig* owner) {
    const std::vector<std::uint32_t> writers = resource_.globals().exporters(channel.field);
    if (!writers.empty()) {
      findings_.add(Code::P7323, variable.at,
                    fmt::format("\"{}\" is written by task \"{}\"", variable.text, image_.tasks[writers.front()].name),
                    is_at(channel, 'Q') ? "it is an output: [outputs]"
                                        : "an input has one source: take another variable, or the writing out of the "
                                          "program");
      return false;
    }
    if (!resource_.globals().claimable(channel.field)) {
      findings_.add(Code::P7330, variable.at,
                    fmt::format("\"{}\" is an input of something else already", variable.text));
      return false;
    }
    const auto [first, fresh] = owners_.emplace(channel.field, owner);
    if (!fresh && first->second != owner) {
      const auto name = [](const DriverConfig* d) {
        return d == nullptr ? "the Modbus server" : "driver \"" + d->name + '"';
      };
      findings_.add(Code::P7330, variable.at,
                    fmt::format("parts of \"{}\" are inputs of {} and of {}", globals()[channel.field].name,
                                name(first->second), name(owner)),
                    "split the variable in the project");
      return false;
    }
    return true;
  }

  /// A BOOL global that the program writes, and others only read.
  void check_flag(std::string_view key, const Placed& variable) {
    if (variable.text.empty()) return;
    const auto place = access_.find_leaf(variable.text);
    if (!place) {
      findings_.add(
          Code::P7320, variable.at, place.error().message,
          place.error().help.empty() ? "declare it in the project: a global of type BOOL" : place.error().help);
    } else if (place->task != runtime::Place::kGlobal) {
      findings_.add(Code::P7321, variable.at,
                    fmt::format("\"{}\" is a variable of task \"{}\"", variable.text, image_.tasks[place->task].name),
                    "declare it AT an address, or copy it into a global");
    } else if (!is_bool(image_.types[place->type])) {
      findings_.add(Code::P7322, variable.at,
                    fmt::format("\"{}\" has type {}, \"{}\" takes a BOOL", variable.text,
                                type_name(image_.types[place->type]), key));
    }
  }

  /// One without the other leads to no encrypted connection.
  void check_certificate() {
    const Placed& certificate = configuration_.engineering.certificate;
    const Placed& key = configuration_.engineering.key;
    if (certificate.text.empty() == key.text.empty()) return;
    const bool no_key = key.text.empty();
    findings_.add(Code::P7306, no_key ? certificate.at : key.at,
                  no_key ? "\"certificate\" is given without \"key\"" : "\"key\" is given without \"certificate\"",
                  "give both, or neither: then plc-run makes its own");
  }

  std::optional<BoundChannel> bind_flag(std::string_view key, const Placed& variable, const DriverConfig* owner) {
    auto channel = resolve(variable, "declare it in the project: a global of type BOOL");
    if (!channel) return std::nullopt;
    if (!is_bool(image_.types[channel->type])) {
      findings_.add(Code::P7322, variable.at,
                    fmt::format("\"{}\" has type {}, \"{}\" takes a BOOL", variable.text,
                                type_name(image_.types[channel->type]), key));
      return std::nullopt;
    }
    if (!claim(variable, *channel, owner)) return std::nullopt;
    return channel;
  }

  /// The channel with its driver, when the variable fits there.
  std::optional<BoundChannel> bind_channel(const ChannelConfig& config, const DriverConfig& driver) {
    auto channel = resolve(config.variable);
    if (!channel) return std::nullopt;
    channel->config = &config;
    const ImageType& type = image_.types[channel->type];
    const auto refuses = driver.type->refuses;
    if (const std::string_view why = refuses == nullptr ? "" : refuses(config.values, type); !why.empty()) {
      findings_.add(Code::P7322, config.variable.at,
                    fmt::format("\"{}\" has type {}, {}", config.variable.text, type_name(type), why));
      return std::nullopt;
    }
    if (config.invert && !is_bool(type)) {
      findings_.add(Code::P7322, config.variable.at,
                    fmt::format("\"{}\" has type {}, \"invert\" is for a BOOL", config.variable.text, type_name(type)));
      return std::nullopt;
    }
    return channel;
  }

  BoundDriver* driver_of(const ChannelConfig& channel, Binding& binding) {
    const auto found = drivers_.find(channel.driver.text);
    return found == drivers_.end() ? nullptr : &binding.drivers[found->second];
  }

  void bind_input(const ChannelConfig& config, Binding& binding) {
    BoundDriver* driver = driver_of(config, binding);
    if (driver == nullptr) return;
    auto channel = bind_channel(config, *driver->config);
    if (channel && claim(config.variable, *channel, driver->config)) driver->inputs.push_back(std::move(*channel));
  }

  void bind_output(const ChannelConfig& config, Binding& binding) {
    BoundDriver* driver = driver_of(config, binding);
    if (driver == nullptr) return;
    auto channel = bind_channel(config, *driver->config);
    if (!channel) return;
    mapped_.push_back(channel->field);
    if (resource_.globals().exporters(channel->field).empty()) {
      findings_.add(Code::P7325, config.variable.at, fmt::format("no task writes \"{}\"", config.variable.text),
                    is_at(*channel, 'I') ? "it is an input: [inputs]" : "name a variable that the program writes");
    }
    const ImageType& type = image_.types[channel->type];
    auto safe = value_of("safe", config.safe, config.variable, type);
    if (!safe) return;
    auto initial = config.initial.text.empty() ? safe : value_of("initial", config.initial, config.variable, type);
    if (!initial) return;
    channel->safe = std::move(*safe);
    channel->initial = std::move(*initial);
    driver->outputs.push_back(std::move(*channel));
  }

  /// The bytes of a `safe` or `initial` value; without one those of FALSE, 0 or the empty string.
  std::optional<std::vector<std::byte>> value_of(std::string_view key, const Placed& value, const Placed& variable,
                                                 const ImageType& type) {
    std::vector<std::byte> bytes(type.size);
    if (value.text.empty() && type.kind == TypeKind::kScalar) {
      if (!type.limited || (type.lower <= 0 && type.upper >= 0)) return bytes;
      findings_.add(
          Code::P7327, variable.at, fmt::format("0 is outside the limits of \"{}\"", variable.text),
          "add a value from " + std::to_string(type.lower) + " to " + std::to_string(type.upper) + " as safe");
      return std::nullopt;
    }
    const auto problem = runtime::parse_value(type, value.text, bytes);
    if (!problem) return bytes;
    findings_.add(Code::P7327, value.at, fmt::format("{} value of \"{}\": {}", key, variable.text, problem->message),
                  problem->help);
    return std::nullopt;
  }

  void find_unmapped_outputs() {
    std::sort(mapped_.begin(), mapped_.end());
    std::vector<std::string> unmapped;
    for (std::uint32_t field = 0; field < globals().size(); ++field) {
      const std::string& address = image_.globals[field].address;
      if (address.size() < 2 || core::upper(address[1]) != 'Q') continue;
      if (std::binary_search(mapped_.begin(), mapped_.end(), field)) continue;
      if (resource_.globals().exporters(field).empty()) continue;
      const std::string& name = globals()[field].name;
      unmapped.push_back(name == address ? address : fmt::format("{} ({})", address, name));
    }
    constexpr std::size_t kOneByOne = 3, kListed = 10;
    if (unmapped.size() <= kOneByOne) {
      for (const std::string& output : unmapped) {
        findings_.add(Code::P7326, configuration_.outputs_at, fmt::format("output {} leads to no channel", output),
                      "add it to [outputs]");
      }
      return;
    }
    std::string list;
    for (std::size_t i = 0; i < std::min(unmapped.size(), kListed); ++i) list += (i == 0 ? "" : ", ") + unmapped[i];
    if (unmapped.size() > kListed) list += fmt::format(" and {} more", unmapped.size() - kListed);
    findings_.add(Code::P7326, configuration_.outputs_at,
                  fmt::format("{} outputs lead to no channel: {}", unmapped.size(), list), "add them to [outputs]");
  }

  const Configuration& configuration_;
  runtime::Resource& resource_;
  const Image& image_;
  runtime::Access access_;
  Findings findings_;
  std::unordered_map<std::string_view, std::size_t> drivers_;      ///< by name
  std::unordered_map<std::uint32_t, const Placed*> used_;          ///< by offset
  std::unordered_map<std::uint32_t, const DriverConfig*> owners_;  ///< of claimed fields
  std::vector<std::uint32_t> mapped_;                              ///< fields with an output channel
};

}  // namespace

std::vector<std::uint32_t> claimed_fields(const BoundDriver& driver) {
  std::set<std::uint32_t> fields;
  if (driver.ok) fields.insert(driver.ok->field);
  for (const BoundChannel& input : driver.inputs) fields.insert(input.field);
  return {fields.begin(), fields.end()};
}

std::vector<std::uint32_t> claimed_fields(const Binding& binding) {
  std::set<std::uint32_t> fields;
  for (const BoundDriver& driver : binding.drivers) {
    for (const std::uint32_t field : claimed_fields(driver)) fields.insert(field);
  }
  if (binding.client_seen) fields.insert(binding.client_seen->field);
  return {fields.begin(), fields.end()};
}

std::uint32_t fastest_task(const Image& image) {
  // Tasks with an interval come before freewheeling ones, those before tasks that wait for an event.
  const auto rank = [](const ImageTask& task) {
    const int kind = !task.single.empty() ? 2 : task.period_ns <= 0 ? 1 : 0;
    return std::tuple(kind, kind == 0 ? task.period_ns : 0, task.priority);
  };
  const auto best = std::min_element(image.tasks.begin(), image.tasks.end(),
                                     [&](const ImageTask& a, const ImageTask& b) { return rank(a) < rank(b); });
  return static_cast<std::uint32_t>(best - image.tasks.begin());
}

std::optional<Binding> bind(const Configuration& configuration, runtime::Resource& resource,
                            core::Diagnostics& diagnostics) {
  Binder binder(configuration, resource);
  Binding binding = binder.run();
  const std::size_t errors = diagnostics.error_count();
  binder.report(diagnostics);
  if (diagnostics.error_count() != errors) return std::nullopt;
  return binding;
}

}  // namespace plc::io
