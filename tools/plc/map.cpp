// plc map: which Modbus address each variable has; import files for HMIs; freezes automatic addresses.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "io-drivers/config/bind.h"
#include "io-drivers/modbus/address_map.h"
#include "runtime/memory/global_ports.h"
#include "tools/command_line.h"
#include "tools/plc/commands.h"
#include "tools/plc/map_formats.h"

namespace plc::tools {
namespace {

struct Map {
  std::string file, configuration, output, host;
  std::string format = "table";
  std::uint16_t port = 0;
  bool freeze = false;
  core::CompileOptions options;
};

/// Where HMIs connect to: what was asked for, else where the server listens.
std::string host_of(const Map& map, const io::ModbusConfig& config) {
  if (!map.host.empty()) return map.host;
  const bool everywhere = config.address == "0.0.0.0" || config.address == "::";
  return everywhere ? "127.0.0.1" : config.address;
}

bool would_overwrite(const Map& map, const std::string& lock_file) {
  const std::string sources[] = {map.file, map.configuration, lock_file};
  return std::any_of(std::begin(sources), std::end(sources), [&](const std::string& source) {
    std::error_code ignored;
    return !source.empty() && std::filesystem::equivalent(source, map.output, ignored);
  });
}

/// Writes the lock file, or says that it should be. kExitOk, or the exit code to end with.
int keep(const Map& map, const std::string& lock_file, const modbus::FrozenAddresses& frozen, std::size_t fresh) {
  if (!map.freeze) {
    if (frozen.changed) {
      complain("plc map",
               fmt::format("{} automatic addresses are not frozen: they may move when the project changes", fresh),
               "plc map --freeze keeps them in " + lock_file);
    }
    return kExitOk;
  }
  std::string why;
  if (frozen.changed && !write_file(lock_file, modbus::frozen_text(frozen), why)) {
    complain("plc map", fmt::format("{} cannot be written: {}", lock_file, why));
    return kExitUsage;
  }
  std::cerr << fmt::format("{}: {}, {} new\n", lock_file, counted(frozen.entries.size(), "variable"), fresh);
  return kExitOk;
}

int run(const CLI::App& app, const Map& map) {
  Compilation compilation;
  if (const auto code = open_or_explain(app, {map.file, map.options, Goal::kRun}, compilation)) return *code;
  auto loaded = runtime::Resource::load(std::move(*compilation.image));
  if (!loaded) {
    complain(loaded.error());
    return kExitErrors;
  }
  runtime::Resource& resource = **loaded;

  core::Diagnostics diagnostics;
  std::optional<io::Configuration> configuration = io::Configuration{};
  std::optional<io::Binding> binding = io::Binding{};
  if (!map.configuration.empty()) {
    configuration = io::load_configuration(map.configuration, diagnostics);
    if (configuration) binding = io::bind(*configuration, resource, diagnostics);
  } else {
    diagnostics.add_file(map.file);
  }
  const auto give_up = [&] {
    diagnostics.render(std::cerr);
    const auto& all = diagnostics.all();
    const bool readable =
        std::none_of(all.begin(), all.end(), [](const core::Diagnostic& d) { return d.code == core::Code::P7001; });
    return readable ? kExitErrors : kExitUsage;
  };
  if (!configuration || !binding) return give_up();
  const std::vector<std::uint32_t> claimed = io::claimed_fields(*binding);
  std::unique_ptr<runtime::GlobalInputs> inputs;
  if (!claimed.empty()) inputs = std::make_unique<runtime::GlobalInputs>(resource.globals(), claimed);

  const std::string lock_file = modbus::lock_file_of(*configuration, map.file);
  if (would_overwrite(map, lock_file)) {
    complain("plc map", "-o " + map.output + " would overwrite what it is made from", "give another name");
    return kExitUsage;
  }
  auto frozen = modbus::read_frozen(lock_file);
  if (!frozen) {
    complain(frozen.error());
    return exit_code_of(frozen.error());
  }
  const modbus::FrozenAddresses before = *frozen;
  const auto built = modbus::AddressMap::build(resource, configuration->modbus, *frozen, diagnostics);
  if (!built) return give_up();
  diagnostics.render(std::cerr);

  std::string name = resource.image().project;
  if (name.empty()) name = std::filesystem::path(map.file).stem().string();
  const std::uint16_t listening = configuration->modbus.port;
  const MapSource source = {*built,
                            resource.image(),
                            std::move(name),
                            host_of(map, configuration->modbus),
                            map.port != 0    ? map.port
                            : listening != 0 ? listening
                                             : std::uint16_t{502},
                            configuration->modbus.unit_id.value_or(1)};
  const auto* const format =
      std::find_if(kMapFormats.begin(), kMapFormats.end(), [&](const MapFormat& f) { return f.name == map.format; });
  const MapText text = format->write(source);
  if (!text.left_out.empty()) {
    complain("plc map",
             fmt::format("{} left out, the first is \"{}\": {} has no type for their word order",
                         counted(text.left_out.size(), "variable"), text.left_out.front(), map.format),
             "set [modbus] word_order = \"ABCD\" in plc.toml");
  }
  const auto fresh =
      static_cast<std::size_t>(std::count_if(frozen->entries.begin(), frozen->entries.end(), [&](const auto& entry) {
        const auto known = before.entries.find(entry.first);
        return known == before.entries.end() || known->second.address != entry.second.address ||
               known->second.table != entry.second.table || known->second.elementary != entry.second.elementary;
      }));
  if (const int code = keep(map, lock_file, *frozen, fresh); code != kExitOk) return code;
  if (map.output.empty()) {
    std::cout << text.text;
    return kExitOk;
  }
  std::string why;
  if (!write_file(map.output, text.text, why)) {
    complain("plc map", fmt::format("{} cannot be written: {}", map.output, why));
    return kExitUsage;
  }
  return kExitOk;
}

}  // namespace

void add_map(CLI::App& app, int& exit_code) {
  static Map map;
  CLI::App* command = app.add_subcommand(
      "map",
      "Prints which Modbus address each variable has, for people, for scripts, or as the import file of an HMI.\n"
      "\n"
      "Examples:\n"
      "  plc map plant.xml\n"
      "  plc map plant.xml --config plc.toml --freeze              automatic addresses stay where they are from now "
      "on\n"
      "  plc map plant.xml --format csv -o plant.csv\n"
      "  plc map plant.xml --format fuxa --host 192.168.1.20 --port 1502 -o fuxa.json");
  command->add_option("FILE", map.file, "PLCopen XML file, or image")->required();
  command->add_option("--config", map.configuration, "configuration with [modbus]; without it, the defaults")
      ->type_name("PLC.TOML");
  std::vector<std::string> names;
  for (const MapFormat& format : kMapFormats) names.emplace_back(format.name);
  command->add_option("--format", map.format, "what to print (default table)")
      ->type_name("NAME")
      ->check(CLI::IsMember(names));
  command->add_option("--host", map.host, "where HMIs find the server (default: where it listens)");
  command->add_option("--port", map.port, "and on which port")->check(CLI::Range(1, 65535));
  command->add_flag("--freeze", map.freeze, "keep automatic addresses in the lock file");
  command->add_option("-o,--output", map.output, "file to write instead of standard output")->type_name("OUT");
  add_compile_options(*command, map.options);
  command->callback([&exit_code, command] { exit_code = run(*command, map); });
}

}  // namespace plc::tools
