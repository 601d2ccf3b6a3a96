#include "io-drivers/external/external_types.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <deque>
#include <map>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "core/duration.h"
#include "io-drivers/config/findings.h"
#include "io-drivers/external/external_driver.h"
#include "io-drivers/threaded.h"
#include "taskblocks/shared_library.h"

namespace plc::io {
namespace {

using core::Code;
using core::Problem;

/// What every kind of a library has, since the runtime does it.
constexpr KeyInfo kOwnKeys[] = {
    {"poll", key::duration("1ms", "10s"), key::otherwise("\"10ms\""),
     "How often the device is exchanged with, on a thread of its own."},
    {"wait", key::boolean(), key::otherwise("false"),
     "true: a device that cannot be opened at the start does not keep control from starting. It is tried again every "
     "`retry`; until it is there its inputs are as on_loss says, and `ok` is FALSE."},
};
constexpr std::string_view kTakenDriverKeys[] = {"kind", "task", "on_loss", "retry", "ok", "poll", "wait"};
constexpr std::string_view kTakenChannelKeys[] = {"driver", "invert", "safe", "initial"};

/// A kind of a library as a row. Rows are asked for by address alone: `driver.type` is one of these where its functions
/// run.
struct ExternalType : DriverType {
  const picard_driver_kind* kind = nullptr;
  std::vector<KeyInfo> own_driver_keys, own_channel_keys;
};
const ExternalType& external(const DriverConfig& driver) { return static_cast<const ExternalType&>(*driver.type); }

bool is_name(const char* name) {
  const std::string_view text = name == nullptr ? "" : name;
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

std::optional<std::string_view> quoted(std::string_view text) {
  if (text.size() < 2 || text.front() != '"' || text.back() != '"') return std::nullopt;
  text = text.substr(1, text.size() - 2);
  if (text.find_first_of("\"\\") != std::string_view::npos) return std::nullopt;
  return text;
}

KeyType type_of(const picard_key& key) {
  switch (key.kind) {
    case PICARD_KEY_BOOLEAN:
      return key::boolean();
    case PICARD_KEY_INTEGER:
      return key::integer(key.lowest, key.highest);
    case PICARD_KEY_CHOICE:
      return key::choice(key.choices);
    case PICARD_KEY_DURATION:
      return key::duration(key.shortest, key.longest);
    default:
      return key::text();
  }
}

/// Whether TOML's spelling of a value is one that the key takes.
bool takes(const picard_key& key, std::string_view value) {
  const KeyType type = type_of(key);
  const auto text = quoted(value);
  switch (key.kind) {
    case PICARD_KEY_BOOLEAN:
      return value == "true" || value == "false";
    case PICARD_KEY_INTEGER: {
      std::int64_t number = 0;
      const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
      return error == std::errc{} && end == value.data() + value.size() && number >= key.lowest &&
             number <= key.highest;
    }
    case PICARD_KEY_CHOICE:
      return text && choice_index(type, *text) >= 0;
    case PICARD_KEY_DURATION: {
      const auto ns = text ? core::parse_duration_ns(*text) : std::nullopt;
      return ns && *ns >= *core::parse_duration_ns(key.shortest) && *ns <= *core::parse_duration_ns(key.longest);
    }
    default:
      return text.has_value();
  }
}

std::string key_complaint(const picard_key& key) {
  if (!is_name(key.name)) return "a key has no name of letters, digits, _ and -";
  for (const char* const text : {key.choices, key.shortest, key.longest, key.example, key.documentation}) {
    if (text == nullptr) return fmt::format("key \"{}\" lacks a text", key.name);
  }
  if (key.kind > PICARD_KEY_DURATION) return fmt::format("key \"{}\" is of no kind", key.name);
  if (key.applies == 0 || key.applies > PICARD_BOTH) return fmt::format("key \"{}\" applies to nothing", key.name);
  const bool durations = core::parse_duration_ns(key.shortest) && core::parse_duration_ns(key.longest);
  if (key.kind == PICARD_KEY_DURATION && !durations) return fmt::format("key \"{}\" has no limits", key.name);
  if (key.otherwise != nullptr && !takes(key, key.otherwise))
    return fmt::format("{} is no value of key \"{}\"", key.otherwise, key.name);
  return {};
}

std::string keys_complaint(const picard_key* keys, std::uint32_t count, std::span<const std::string_view> taken) {
  if (count != 0 && keys == nullptr) return "its keys are missing";
  std::vector<std::string_view> names(taken.begin(), taken.end());
  for (std::uint32_t i = 0; i < count; ++i) {
    if (std::string wrong = key_complaint(keys[i]); !wrong.empty()) return wrong;
    if (std::find(names.begin(), names.end(), keys[i].name) != names.end())
      return fmt::format("key \"{}\" is there already", keys[i].name);
    names.emplace_back(keys[i].name);
  }
  return {};
}

KeyInfo row_of(const picard_key& key) {
  return {key.name, type_of(key), key.otherwise == nullptr ? key::required(key.example) : key::otherwise(key.otherwise),
          key.documentation, static_cast<Applies>(key.applies)};
}

std::string channel_name(const DriverConfig& driver, const ChannelConfig& channel) {
  const ExternalType& type = external(driver);
  const auto has = [](const std::vector<KeyInfo>& keys, std::string_view name) {
    return std::any_of(keys.begin(), keys.end(), [name](const KeyInfo& key) { return key.name == name; });
  };
  if (!has(type.own_channel_keys, "channel") || !channel.values.has("channel")) return {};
  const std::string& device = type.device_key.empty() ? driver.name : driver.values.text(type.device_key);
  return fmt::format("{} {} of {}", channel.direction == kInputsOnly ? "input" : "output",
                     channel.values.text("channel"), device);
}

std::string_view refuses(const KeyValues&, const bytecode::ImageType& type) { return refuses_number(type); }

std::unique_ptr<Driver> make(const BoundDriver& bound, const Configuration& configuration,
                             runtime::Resource& resource) {
  auto driver = std::make_unique<ExternalDriver>(*external(*bound.config).kind, bound, configuration, resource);
  return std::make_unique<ThreadedDriver>(std::move(driver), bound.config->values.number("poll"));
}

/// The kinds of one library, or why it is refused.
std::optional<Problem> add_kinds(const picard_driver_library* library, const std::string& path,
                                 std::vector<const DriverType*>& types) {
  const auto refused = [&path](const std::string& why) {
    return Problem{Code::P7420, path + ": " + why, "build it against the SDK of this version of PICARD"};
  };
  if (library == nullptr) return refused("it has no description");
  if (library->abi_version != PICARD_DRIVER_ABI_VERSION) {
    return refused(fmt::format("it speaks version {} of the driver interface, this program version {}",
                               library->abi_version, PICARD_DRIVER_ABI_VERSION));
  }
  if (library->kind_bytes != sizeof(picard_driver_kind) || library->key_bytes != sizeof(picard_key))
    return refused("its structures have other sizes than this program's");
  if (library->kind_count != 0 && library->kinds == nullptr) return refused("its kinds are missing");
  for (std::uint32_t i = 0; i < library->kind_count; ++i) {
    if (const std::string wrong = complaint(library->kinds[i], types); !wrong.empty()) return refused(wrong);
    types.push_back(make_external_type(library->kinds[i]));
  }
  return std::nullopt;
}

}  // namespace

std::string complaint(const picard_driver_kind& kind, DriverTypes known) {
  if (!is_name(kind.name)) return "a kind has no name of letters, digits, _ and -";
  const auto wrong = [&kind](const std::string& why) { return fmt::format("kind \"{}\": {}", kind.name, why); };
  if (std::any_of(known.begin(), known.end(), [&](const DriverType* type) { return type->name == kind.name; }))
    return wrong("there is one of this name already");
  if (kind.summary == nullptr || kind.device == nullptr || !is_name(kind.example)) return wrong("it lacks a text");
  if (kind.create == nullptr || kind.open == nullptr || kind.read == nullptr || kind.write == nullptr ||
      kind.close == nullptr || kind.destroy == nullptr)
    return wrong("it lacks a function");
  std::string key = keys_complaint(kind.driver_keys, kind.driver_key_count, kTakenDriverKeys);
  if (key.empty()) key = keys_complaint(kind.channel_keys, kind.channel_key_count, kTakenChannelKeys);
  if (!key.empty()) return wrong(key);
  const std::span<const picard_key> keys(kind.driver_keys, kind.driver_key_count);
  const std::string_view device = kind.device;
  if (!device.empty() && std::none_of(keys.begin(), keys.end(), [&](const picard_key& k) { return k.name == device; }))
    return wrong(fmt::format("there is no key \"{}\"", device));
  return {};
}

const DriverType* make_external_type(const picard_driver_kind& kind) {
  static std::deque<ExternalType> all;
  ExternalType& type = all.emplace_back();
  type.kind = &kind;
  for (std::uint32_t i = 0; i < kind.driver_key_count; ++i) type.own_driver_keys.push_back(row_of(kind.driver_keys[i]));
  type.own_driver_keys.insert(type.own_driver_keys.end(), std::begin(kOwnKeys), std::end(kOwnKeys));
  for (std::uint32_t i = 0; i < kind.channel_key_count; ++i)
    type.own_channel_keys.push_back(row_of(kind.channel_keys[i]));
  type.name = kind.name;
  type.summary = kind.summary;
  type.example = kind.example;
  type.driver_keys = type.own_driver_keys;
  type.channel_keys = type.own_channel_keys;
  type.device_key = kind.device;
  type.device_problems = kExternalDeviceProblems;
  type.channel_name = channel_name;
  type.refuses = refuses;
  type.make = make;
  return &type;
}

DriverTypes load_external_types(const Configuration& configuration, DriverTypes known, Findings& findings) {
  // Each file once, however often a configuration is read; and each list as long as configurations point into it.
  static std::map<std::string, std::vector<const DriverType*>> loaded;
  static std::deque<std::vector<const DriverType*>> lists;
  std::vector<const DriverType*>& types = lists.emplace_back(known.begin(), known.end());
  for (const Placed& library : configuration.driver_kinds.libraries) {
    const std::string path = configuration.beside(library.text);
    if (const auto before = loaded.find(path); before != loaded.end()) {
      types.insert(types.end(), before->second.begin(), before->second.end());
      continue;
    }
    const std::size_t first = types.size();
    const taskblocks::LibraryUse use{PICARD_DRIVER_ENTRY,
                                     [&types, first](void* entry, const std::string& file) {
                                       types.resize(first);
                                       return add_kinds(reinterpret_cast<picard_driver_entry>(entry)(), file, types);
                                     },
                                     "list its classes: PICARD_DRIVER_LIBRARY(name, version, ..)"};
    if (const auto problem = taskblocks::load_library(path, use)) {
      types.resize(first);
      findings.add(Code::P7420, library.at, problem->message, problem->help);
      continue;
    }
    loaded[path] = {types.begin() + static_cast<std::ptrdiff_t>(first), types.end()};
  }
  return types;
}

}  // namespace plc::io
