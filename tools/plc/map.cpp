// plc map: which Modbus address each variable has; import files for HMIs; freezes automatic addresses.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <memory>
#include <string>
#include <unordered_set>
#include <vector>

#include "core/text.h"
#include "io-drivers/config/bind.h"
#include "io-drivers/machine/driver_types.h"
#include "io-drivers/modbus/address_map.h"
#include "runtime/memory/global_ports.h"
#include "tools/command_line.h"
#include "tools/open.h"
#include "tools/plc/commands.h"
#include "tools/plc/map_formats.h"
#include "tools/taskblock_libraries.h"

namespace plc::tools {
namespace {

struct Map {
  std::string file, configuration, output, host;
  std::string format = "table";
  std::uint16_t port = 0;
  bool freeze = false;
  core::CompileOptions options;
  std::vector<std::string> libraries;
};

bool listens_everywhere(const io::ModbusConfig& config) {
  return config.address == "0.0.0.0" || config.address == "::";
}

/// Where HMIs connect to: what was asked for, else where the server listens. IPv6 without brackets.
std::string host_of(const Map& map, const io::ModbusConfig& config) {
  if (map.host.starts_with('[') && map.host.ends_with(']')) return map.host.substr(1, map.host.size() - 2);
  if (!map.host.empty()) return map.host;
  return listens_everywhere(config) ? "127.0.0.1" : config.address;
}

/// Says what the file tells HMIs when plc.toml does not say where they find the server.
void note_guesses(const Map& map, const io::ModbusConfig& config) {
  if (map.host.empty() && config.enabled && listens_everywhere(config)) {
    complain("plc map", "the file says 127.0.0.1: the server listens on every address of its machine",
             "--host NAME for HMIs on other machines");
  }
  if (!config.serves()) complain("plc map", "[modbus] listen is \"off\": plc-run serves nothing of this");
  if (config.enabled && config.port == 0 && map.port == 0) {
    complain("plc map", "the file says port 502: with port 0 in [modbus] listen the server takes any free one",
             "--port N for the one it takes, or give it one");
  }
}

bool would_overwrite(const Map& map, const std::string& lock_file) {
  const std::string sources[] = {map.file, map.configuration, lock_file};
  return std::any_of(std::begin(sources), std::end(sources), [&](const std::string& source) {
    std::error_code ignored;
    if (source.empty() || map.output.empty()) return false;
    return std::filesystem::equivalent(source, map.output, ignored) ||
           std::filesystem::weakly_canonical(source, ignored) ==
               std::filesystem::weakly_canonical(map.output, ignored);  // neither exists yet
  });
}

/// "A, B", at most ten, then "and N more".
std::string listed(const std::vector<std::string>& paths) {
  constexpr std::size_t kShown = 10;
  std::string text;
  for (std::size_t i = 0; i < std::min(paths.size(), kShown); ++i) text += (i == 0 ? "" : ", ") + paths[i];
  if (paths.size() > kShown) text += fmt::format(" and {} more", paths.size() - kShown);
  return text;
}

/// What the lock file does not have as the map has it, and what only the lock file has.
struct Changes {
  std::vector<std::string> fresh, gone;
};
Changes changes_of(const modbus::FrozenAddresses& before, const modbus::FrozenAddresses& after,
                   const modbus::AddressMap& map) {
  std::unordered_set<std::string, core::NameHash, core::NameEqual> mapped;
  for (const modbus::Point& point : map.points()) {
    if (point.automatic) mapped.insert(point.path);
  }
  Changes changes;
  for (const auto& [path, entry] : after.entries) {
    const auto known = before.entries.find(path);
    const bool same = known != before.entries.end() && known->second.address == entry.address &&
                      known->second.table == entry.table && known->second.elementary == entry.elementary;
    if (!same) changes.fresh.push_back(path);
    if (mapped.count(path) == 0) changes.gone.push_back(path);
  }
  return changes;
}

/// Writes the lock file, or says that it should be. kExitOk, or the exit code to end with.
int keep(const Map& map, const std::string& lock_file, const modbus::FrozenAddresses& frozen, const Changes& changes) {
  if (!changes.gone.empty()) {
    complain("plc map",
             fmt::format("{} has {} that the map does not have: {}", lock_file,
                         counted(changes.gone.size(), "variable"), listed(changes.gone)),
             "their addresses stay taken; delete the lines to give them back");
  }
  if (!map.freeze) {
    if (frozen.changed) {
      complain("plc map",
               fmt::format("{} automatic addresses are not frozen and may move when the project changes: {}",
                           changes.fresh.size(), listed(changes.fresh)),
               fmt::format("plc map {}{}{} --freeze keeps them in {}", shell_word(map.file),
                           compile_flags(map.options, map.libraries),
                           map.configuration.empty() ? "" : " --config " + shell_word(map.configuration), lock_file));
    }
    return kExitOk;
  }
  if (!frozen.changed) {
    std::cerr << (frozen.entries.empty()
                      ? "nothing to freeze: no variable has an automatic address\n"
                      : fmt::format("{}: unchanged, {}\n", lock_file, counted(frozen.entries.size(), "variable")));
    return kExitOk;
  }
  std::string why;
  if (!write_file(lock_file, modbus::frozen_text(frozen), why)) {
    complain("plc map", fmt::format("{} cannot be written: {}", lock_file, why));
    return kExitUsage;
  }
  std::cerr << fmt::format("{}: {}, {} new: {}\n", lock_file, counted(frozen.entries.size(), "variable"),
                           changes.fresh.size(), listed(changes.fresh));
  return kExitOk;
}

int run(Command command, const Map& map) {
  taskblocks::Registry registry;
  std::vector<std::string> libraries = map.libraries;
  if (const auto code = load_taskblocks(map.configuration, registry, libraries)) return *code;
  Compilation compilation;
  if (const auto code =
          open_or_explain(command, {map.file, map.options, Goal::kRun, libraries, {}, &registry, true}, compilation)) {
    return *code;
  }
  runtime::ProgramOptions program;
  program.taskblocks = &registry;
  program.start_taskblocks = false;  // nothing runs
  auto loaded = runtime::Resource::load(std::move(*compilation.image), program);
  if (!loaded) {
    complain(loaded.error());
    return kExitErrors;
  }
  runtime::Resource& resource = **loaded;

  core::Diagnostics diagnostics;
  if (map.options.show_all) diagnostics.show_all();
  std::optional<io::Configuration> configuration = io::Configuration{};
  std::optional<io::Binding> binding = io::Binding{};
  if (!map.configuration.empty()) {
    configuration = io::load_configuration(map.configuration, diagnostics);
    if (configuration) binding = io::bind(*configuration, resource, diagnostics);
  } else {
    diagnostics.add_file(map.file);
  }
  const auto give_up = [&] {
    diagnostics.render_with_lines(std::cerr);
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
  auto frozen = modbus::read_frozen(lock_file, resource.image());
  if (!frozen) {
    complain(frozen.error());
    return exit_code_of(frozen.error());
  }
  const modbus::FrozenAddresses before = *frozen;
  const auto built = modbus::AddressMap::build(resource, configuration->modbus, *frozen, diagnostics);
  if (!built) return give_up();
  diagnostics.render_with_lines(std::cerr);

  std::string name = resource.image().project;
  if (name.empty()) name = std::filesystem::path(map.file).stem().string();
  const std::uint16_t listening = configuration->modbus.port;
  const MapSource source = {*built,
                            resource.image(),
                            registry,
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
  if (format->names_host) note_guesses(map, configuration->modbus);
  // The lock file last: nothing is frozen by a command that failed.
  std::string why;
  if (!map.output.empty() && !write_file(map.output, text.text, why)) {
    complain("plc map", fmt::format("{} cannot be written: {}", map.output, why));
    return kExitUsage;
  }
  if (const int code = keep(map, lock_file, *frozen, changes_of(before, *frozen, *built)); code != kExitOk) return code;
  if (map.output.empty()) std::cout << text.text;
  return kExitOk;
}

}  // namespace

void add_map(Command program) {
  static Map map;
  const Command command = program.sub(
      "map",
      "Prints which Modbus address each variable has, for people, for scripts, or as the import file of an HMI.\n"
      "\n"
      "Examples:\n"
      "  plc map plant.xml\n"
      "  plc map plant.xml --config plc.toml --freeze              automatic addresses stay where they are from now "
      "on\n"
      "  plc map plant.xml --format csv -o plant.csv\n"
      "  plc map plant.xml --format fuxa --host 192.168.1.20 --port 1502 -o fuxa.json");
  command.option("FILE", map.file, "PLCopen XML or ST file, source folder, or image").required();
  command.option("--config=PLC.TOML", map.configuration,
                 "configuration with [modbus], [project] and [taskblocks]; without it, the defaults");
  std::vector<std::string> names;
  for (const MapFormat& format : kMapFormats) names.emplace_back(format.name);
  command.option("--format=NAME", map.format, "what to print (default table)").one_of(names);
  command.option("--host", map.host, "where HMIs find the server (default: where it listens)");
  command.option("--port", map.port, "and on which port").range(1, 65535);
  command.flag("--freeze", map.freeze, "keep automatic addresses in the lock file");
  command.option("-o,--output=OUT", map.output, "file to write instead of standard output");
  add_library_option(command, map.libraries);
  add_compile_options(command, map.options);
  command.on_run([command] { return run(command, map); });
}

}  // namespace plc::tools
