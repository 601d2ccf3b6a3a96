// The only user of toml++.
#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <concepts>
#include <map>

#include "core/duration.h"
#include "core/guess.h"
#include "core/text.h"
#include "core/time_zone.h"
#include "core/toml_limits.h"
#include "io-drivers/config/configuration.h"
#include "io-drivers/config/driver_type.h"
#include "io-drivers/config/findings.h"
#include "io-drivers/config/keys.h"
#include "io-drivers/modbus-rtu/line.h"

namespace plc::io {
namespace {

using core::Code;
using core::SourceRef;

/// The fields of `listen`.
struct Listen {
  bool& enabled;
  std::string& address;
  std::uint16_t& port;
  SourceRef& at;
};

std::string_view type_word(const toml::node& node) {
  // In the order of toml::node_type.
  constexpr std::string_view kWords[] = {
      "nothing", "a table", "a list", "a text", "a whole number", "a number with a fraction", "true or false"};
  const auto type = static_cast<std::size_t>(node.type());
  return type < std::size(kWords) ? kWords[type] : "a date or time";
}

/// The scalar as text, the way runtime/value_text.h reads it.
std::string scalar_text(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* integer = node.as_integer()) return std::to_string(integer->get());
  if (const auto* number = node.as_floating_point()) return fmt::format("{}", number->get());
  if (const auto* boolean = node.as_boolean()) return boolean->get() ? "TRUE" : "FALSE";
  return {};
}

bool has_control_character(std::string_view text) {
  return std::any_of(text.begin(), text.end(),
                     [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
}

/// What an entry is that decides which keys it has.
struct Entry {
  const DriverType* kind = nullptr;  ///< null: not known, or not of a driver
  Applies direction = 0;             ///< 0: of no channel
};

/// A value that was found good, on its way into the structure.
struct Value {
  const toml::node& node;
  const KeyInfo& key;
  SourceRef at;
};

void put(const Value& value, bool& to) { to = value.node.as_boolean()->get(); }
void put(const Value& value, Placed& to) { to = {scalar_text(value.node), value.at}; }
void put(const Value& value, Listen to) {
  const auto text = parse_listen(value.node.as_string()->get());
  to.at = value.at;
  to.enabled = !text->address.empty();
  if (to.enabled) to.address = text->address;
  if (to.enabled) to.port = text->port;
}
/// Found before the other keys, which depend on it.
void put(const Value&, const DriverType*) {}
void put(const Value& value, core::TimeNs& to) { to = *core::parse_duration_ns(value.node.as_string()->get()); }
void put(const Value& value, std::unsigned_integral auto& to) {
  to = static_cast<std::remove_reference_t<decltype(to)>>(value.node.as_integer()->get());
}
void put(const Value& value, std::vector<Placed>& to) {
  to.clear();
  for (const toml::node& one : *value.node.as_array()) {
    SourceRef at = value.at;
    at.line = one.source().begin.line;
    at.column = one.source().begin.column;
    to.push_back({one.as_string()->get(), at});
  }
}
template <class Enum>
requires std::is_enum_v<Enum>
void put(const Value& value, Enum& to) {
  to = static_cast<Enum>(choice_index(value.key.type, value.node.as_string()->get()));
}
template <class T>
void put(const Value& value, std::optional<T>& to) {
  put(value, to.emplace());
}

template <class T>
inline constexpr TableId kTableOf = TableId::kModbus;
#define PLC_CONFIG_TABLE(table, Config, ...) \
  template <>                                \
  inline constexpr TableId kTableOf<Config> = TableId::table;
#include "io-drivers/config/keys.def"

/// Puts the value where the key's row says; of a kind's own key, to its values.
template <class T>
void store(const Value& value, T& c) {
  if constexpr (requires { c.cpu_at; }) c.cpu_at = value.key.name == "cpu" ? value.at : c.cpu_at;
  if constexpr (requires { c.values; }) {
    std::vector<Placed> list;
    if (value.key.type.kind == KeyKind::kTexts) put(value, list);
    if (value.key.kind != nullptr) return c.values.set(value.key.name, {scalar_text(value.node), value.at}, list);
  }
#define PLC_CONFIG_KEY(table, key_name, place, ...)           \
  if constexpr (kTableOf<T> == TableId::table) {              \
    if (value.key.name == key_name) return put(value, place); \
  }
#include "io-drivers/config/keys.def"
}

class Reader {
 public:
  Reader(std::uint16_t file, DriverTypes types, Findings& findings) : types_(types), keys_(types), findings_(findings) {
    file_at_.file = file;
  }

  void read(const toml::table& root, Configuration& configuration) {
    configuration.at = configuration.outputs_at = file_at_;
    static constexpr std::string_view kNames[] = {"project", "drivers",    "inputs",       "outputs", "scheduler",
                                                  "tasks",   "taskblocks", "retain",       "log",     "clock",
                                                  "modbus",  "guardian",   "driver_kinds", "record",  "engineering"};
    for (const auto& [key, node] : root) {
      if (std::find(std::begin(kNames), std::end(kNames), key.str()) == std::end(kNames)) {
        core::Guess guess(key.str());
        for (const std::string_view name : kNames) guess.offer(name);
        std::string help = guess.help();
        if (help.empty()) help = home_of(key.str());
        problem(Code::P7303, place(key), fmt::format("no table \"{}\" in plc.toml", key.str()), std::move(help));
      } else if (!node.is_table()) {
        problem(Code::P7304, place(key), fmt::format("\"{}\" is {}; it is a table", key.str(), type_word(node)),
                fmt::format("write [{}]", key.str()));
      }
    }
    const auto read_section = [&](std::string_view name, auto& to) {
      const toml::table* table = root[name].as_table();
      if (table == nullptr) return;
      to.at = place(*table);
      read_table(*table, to, {}, to.at, fmt::format("[{}]", name));
    };
    if (const auto* table = root["modbus"].as_table()) read_modbus(*table, configuration.modbus);
    read_section("scheduler", configuration.scheduler);
    read_section("project", configuration.project);
    read_section("driver_kinds", configuration.driver_kinds);
    read_section("taskblocks", configuration.taskblocks);
    read_section("retain", configuration.retain);
    read_section("log", configuration.log);
    read_section("record", configuration.record);
    read_section("clock", configuration.clock);
    read_section("engineering", configuration.engineering);
    check_zone(configuration.clock);
    read_section("guardian", configuration.guardian);
    if (const auto* table = root["tasks"].as_table()) read_tasks(*table, configuration.tasks);
    if (const auto* table = root["drivers"].as_table()) read_drivers(*table, configuration.drivers);
    if (const auto* table = root["inputs"].as_table()) read_channels(*table, kInputsOnly, configuration.inputs);
    if (const auto* table = root["outputs"].as_table()) {
      configuration.outputs_at = place(*table);
      read_channels(*table, kOutputsOnly, configuration.outputs);
    }
    check_channels(configuration, findings_);
  }

  /// [driver_kinds] alone.
  void read_kinds(const toml::table& root, Configuration& configuration) {
    const toml::table* table = root["driver_kinds"].as_table();
    if (table != nullptr) read_table(*table, configuration.driver_kinds, {}, place(*table), "[driver_kinds]");
  }

 private:
  void check_zone(const ClockConfig& clock) {
    if (core::TimeZone::load(clock.zone.text)) return;
    problem(Code::P7312, clock.zone.at, fmt::format("there is no time zone \"{}\" on this machine", clock.zone.text),
            "timedatectl list-timezones lists them; the package tzdata has them");
  }
  void problem(Code code, const SourceRef& at, std::string message, std::string help = {}) {
    findings_.add(code, at, std::move(message), std::move(help));
  }
  [[nodiscard]] SourceRef place(const toml::source_region& region) const {
    SourceRef at = file_at_;
    at.line = region.begin.line;
    at.column = region.begin.column;
    return at;
  }
  [[nodiscard]] SourceRef place(const toml::key& key) const { return place(key.source()); }
  [[nodiscard]] SourceRef place(const toml::node& node) const { return place(node.source()); }
  /// Of a key's value, or of the table when the key is not there.
  [[nodiscard]] SourceRef place(const toml::table& table, std::string_view key) const {
    const toml::node* node = table.get(key);
    return node != nullptr ? place(*node) : place(table);
  }

  /// "it belongs to [guardian]", for a key that is in the wrong table.
  [[nodiscard]] std::string home_of(std::string_view name) const {
    for (const KeyInfo& key : keys_.rows()) {
      if (key.name != name) continue;
      for (const TableInfo& table : config_tables()) {
        if (table.id == key.table) return fmt::format("\"{}\" belongs to {}", name, table.heading);
      }
    }
    return {};
  }

  void unknown_key(TableId table, const toml::key& key, std::string_view where) {
    core::Guess guess(key.str());
    for (const KeyInfo& known : keys_.rows()) {
      if (known.table == table) guess.offer(known.name);
    }
    std::string help = guess.help();
    if (help.empty()) help = home_of(key.str());
    problem(Code::P7303, place(key), fmt::format("{} has no key \"{}\"", where, key.str()), std::move(help));
  }

  /// Why the key does not belong to the entry: "gpio only, outputs only"; empty when it does.
  [[nodiscard]] std::string misplaced(const KeyInfo& key, const Entry& entry) const {
    const bool of_kind = key.kind == nullptr || entry.kind == nullptr || key.kind == entry.kind;
    if (of_kind && (key.applies & entry.direction) == entry.direction) return {};
    std::string text = applies_text(key);
    if (of_kind) return text;
    std::string others;  // that have a key of this name
    for (const KeyInfo& other : keys_.rows()) {
      if (other.table != key.table || other.name != key.name || &other == &key) continue;
      others += ", " + std::string(other.kind->name);
    }
    return text.insert(key.kind->name.size(), others);
  }

  /// Reads all keys of one table into `to`.
  template <class T>
  void read_table(const toml::table& table, T& to, const Entry& entry, const SourceRef& at, const std::string& where) {
    for (const auto& [name, node] : table) {
      const KeyInfo* key = keys_.find(kTableOf<T>, name.str(), entry.kind);
      if (key == nullptr) {
        const bool own = kTableOf<T> == TableId::kModbus && (name.str() == "range" || name.str() == "serial");
        if (!own) unknown_key(kTableOf<T>, name, where);
      } else if (const std::string only = misplaced(*key, entry); !only.empty()) {
        problem(Code::P7307, place(name), fmt::format("\"{}\" does not belong to {}", name.str(), where),
                only + ": take it out");
      } else if (check(*key, node)) {
        store(Value{node, *key, place(node)}, to);
      }
    }
    for (const KeyInfo& key : keys_.rows()) {
      if (key.table != kTableOf<T> || key.fallback.kind != KeyDefault::Kind::kRequired || table.contains(key.name))
        continue;
      if (!misplaced(key, entry).empty() || (key.kind != nullptr && entry.kind == nullptr)) continue;
      problem(Code::P7306, at, fmt::format("{} has no \"{}\"", where, key.name),
              fmt::format("add {} = {}", key.name, key.fallback.toml));
    }
  }

  bool check(const KeyInfo& key, const toml::node& node) {
    const auto refuse = [&](Code code, std::string help = {}) {
      const std::string found =
          code == Code::P7304 ? std::string(type_word(node)) : fmt::format("\"{}\"", scalar_text(node));
      problem(code, place(node), fmt::format("\"{}\" is {}; it takes {}", key.name, found, type_text(key.type)),
              std::move(help));
      return false;
    };
    const auto* text = node.as_string();
    const auto* integer = node.as_integer();
    switch (key.type.kind) {
      case KeyKind::kBoolean:
        return node.is_boolean() || refuse(Code::P7304);
      case KeyKind::kInteger:
        if (integer == nullptr) return refuse(Code::P7304);
        return (integer->get() >= key.type.low && integer->get() <= key.type.high) || refuse(Code::P7305);
      case KeyKind::kText:
        if (text == nullptr) return refuse(Code::P7304, "texts are written in quotes");
        return check_text(key, text->get(), node);
      case KeyKind::kTexts:
        return check_texts(key, node);
      case KeyKind::kChoice: {
        if (text == nullptr) return refuse(Code::P7304);
        if (choice_index(key.type, text->get()) >= 0) return true;
        core::Guess guess(text->get());
        for_choices(key.type, [&](std::string_view one) { guess.offer(one); });
        return refuse(Code::P7305, guess.help());
      }
      case KeyKind::kDuration: {
        if (text == nullptr) return refuse(Code::P7304, "write a number with its unit in quotes: \"500ms\", \"5s\"");
        const auto ns = core::parse_duration_ns(text->get());
        const bool has_unit = !text->get().empty() && core::fold(text->get().back()) >= 'a';
        if (!ns || !has_unit) return refuse(Code::P7305, "write a number with its unit: \"500ms\", \"5s\"");
        const auto low = core::parse_duration_ns(key.type.low_text), high = core::parse_duration_ns(key.type.high_text);
        return (*ns >= *low && *ns <= *high) || refuse(Code::P7305);
      }
      case KeyKind::kListen: {
        if (text == nullptr) return refuse(Code::P7304, "write \"127.0.0.1:502\", or \"off\"");
        if (parse_listen(text->get())) return true;
        return refuse(
            Code::P7305,
            "\"127.0.0.1:502\" is this machine only, \"0.0.0.0:502\" every IPv4 network, \"[::]:502\" every network");
      }
      case KeyKind::kChannel:
        if (text != nullptr) return check_text(key, text->get(), node);
        if (integer == nullptr) return refuse(Code::P7304);
        return (integer->get() >= 0 && integer->get() <= key.type.high) || refuse(Code::P7305);
      case KeyKind::kValue:
        return text != nullptr || node.is_number() || node.is_boolean() || refuse(Code::P7304);
    }
    return false;
  }

  bool check_text(const KeyInfo& key, std::string_view text, const toml::node& node) {
    if (has_control_character(text)) {
      problem(Code::P7305, place(node), fmt::format("\"{}\" has a control character in it", key.name));
      return false;
    }
    if (key.fallback.kind != KeyDefault::Kind::kRequired || !core::trimmed(text).empty()) return true;
    problem(Code::P7305, place(node), fmt::format("\"{}\" is empty", key.name));
    return false;
  }

  bool check_texts(const KeyInfo& key, const toml::node& node) {
    const toml::array* list = node.as_array();
    if (list == nullptr) {
      problem(Code::P7304, place(node),
              fmt::format("\"{}\" is {}; it takes a list of texts", key.name, type_word(node)),
              "write it in brackets: [\"Main.*\"]");
      return false;
    }
    bool good = true;
    for (const toml::node& one : *list) {
      const auto* text = one.as_string();
      if (text == nullptr) {
        problem(Code::P7304, place(one),
                fmt::format("\"{}\" has {} in it; it takes a list of texts", key.name, type_word(one)));
      } else if (core::trimmed(text->get()).empty()) {
        problem(Code::P7305, place(one), fmt::format("\"{}\" has an empty text in it", key.name));
      } else if (check_text(key, text->get(), one)) {
        continue;
      }
      good = false;
    }
    return good;
  }

  void read_modbus(const toml::table& table, ModbusConfig& to) {
    to.at = place(table);
    read_table(table, to, {}, to.at, "[modbus]");
    if (to.max_clients_per_address > to.max_clients) {
      problem(Code::P7311, place(table, "max_clients_per_address"),
              fmt::format("{} connections from one address are more than {} in all", to.max_clients_per_address,
                          to.max_clients));
    }
    if (to.unit_exception && !table.contains("unit_id")) {
      problem(Code::P7311, place(table, "unit_exception"), "there are no other units to answer: \"unit_id\" is omitted",
              "add unit_id = 1, or take unit_exception out");
    }
    if (const toml::node* serial = table.get("serial")) read_serial(*serial, to.serial.emplace());
    const toml::node* ranges = table.get("range");
    if (ranges == nullptr) return;
    if (!ranges->is_array_of_tables()) {
      problem(Code::P7304, place(*ranges), fmt::format("\"range\" is {}; it is a list of tables", type_word(*ranges)),
              "write [[modbus.range]] with two brackets");
      return;
    }
    for (const toml::node& one : *ranges->as_array()) read_range(*one.as_table(), to.ranges.emplace_back());
  }

  void read_serial(const toml::node& node, ModbusSerialConfig& to) {
    to.at = place(node);
    if (!node.is_table()) {
      problem(Code::P7304, to.at, fmt::format("\"serial\" is {}; it is a table", type_word(node)),
              "write [modbus.serial]");
      return;
    }
    read_table(*node.as_table(), to, {}, to.at, "[modbus.serial]");
    if (!to.path.text.empty() && !to.path.text.starts_with('/')) {
      problem(Code::P7305, to.path.at, fmt::format("\"{}\" is not the path of a serial line", to.path.text),
              "write \"/dev/ttyUSB0\"");
    }
    if (modbus_rtu::parse_line(to.line.text)) return;
    problem(Code::P7305, to.line.at, fmt::format("\"{}\" is no setting of a serial line", to.line.text),
            "write speed, data bits, parity and stop bits: \"19200 8E1\", \"9600 8N1\"");
  }

  void read_range(const toml::table& table, ModbusRange& to) {
    to.at = place(table);
    read_table(table, to, {}, to.at, "[[modbus.range]]");
    if (to.first > to.last) {
      problem(Code::P7311, place(table, table.contains("last") ? "last" : "first"),
              fmt::format("the range ends with {}, before its first address {}", to.last, to.first));
    }
    if (table["table"].value<std::string_view>() != modbus_table_text(to.table)) return;
    const bool of_bits = to.table == ModbusTable::kCoils || to.table == ModbusTable::kDiscreteInputs;
    const bool of_inputs = to.table == ModbusTable::kDiscreteInputs || to.table == ModbusTable::kInputRegisters;
    if (of_inputs && to.writable.value_or(false)) {
      problem(Code::P7311, place(table, "writable"),
              fmt::format("no function of Modbus writes {}", modbus_table_text(to.table)),
              "coils and holding-registers can be written");
    }
    if (to.table != ModbusTable::kCoils && to.latch.value_or(false)) {
      problem(Code::P7307, place(table, "latch"), fmt::format("{} are not latched", modbus_table_text(to.table)),
              "only coils are: take it out");
    }
    if (of_bits && to.word_order) {
      problem(Code::P7307, place(table, "word_order"),
              fmt::format("{} have no word order", modbus_table_text(to.table)),
              "only registers have one: take it out");
    }
  }

  void read_tasks(const toml::table& table, std::vector<TaskConfig>& tasks) {
    for (const auto& [key, node] : table) {
      const std::string_view name = key.str();
      const toml::table* one = node.as_table();
      if (one == nullptr) {
        problem(Code::P7304, place(key), fmt::format("task \"{}\" is {}; it is a table", name, type_word(node)),
                fmt::format("write [tasks.{}]", name));
        continue;
      }
      TaskConfig& task = tasks.emplace_back();
      task.name = name;
      task.at = place(key);
      read_table(*one, task, {}, task.at, fmt::format("task \"{}\"", name));
    }
    std::ranges::sort(tasks, before, &TaskConfig::at);
  }

  void read_drivers(const toml::table& table, std::vector<DriverConfig>& drivers) {
    for (const auto& [key, node] : table) {
      const std::string_view name = key.str();
      const toml::table* one = node.as_table();
      if (one == nullptr) {
        problem(Code::P7304, place(key), fmt::format("driver \"{}\" is {}; it is a table", name, type_word(node)),
                fmt::format("write [drivers.{}]", name));
        continue;
      }
      const bool plain = !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
        const char f = core::fold(c);
        return (f >= 'a' && f <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
      });
      if (!plain) {
        problem(Code::P7305, place(key), fmt::format("\"{}\" is no name for a driver", name),
                "names have letters, digits, _ and -");
      }
      DriverConfig& driver = drivers.emplace_back();
      driver.name = name;
      driver.at = place(key);
      const auto kind = (*one)["kind"].value<std::string_view>();
      const auto type = std::find_if(types_.begin(), types_.end(), [&](const auto* t) { return t->name == kind; });
      if (type != types_.end()) {
        driver.type = *type;
        driver.values = KeyValues(driver.type->driver_keys);
      }
      read_table(*one, driver, {.kind = driver.type}, driver.at, fmt::format("driver \"{}\"", name));
      drivers_[driver.name] = driver.type;
    }
    std::ranges::sort(drivers, before, &DriverConfig::at);
  }

  void read_channels(const toml::table& table, Applies direction, std::vector<ChannelConfig>& channels) {
    const char* const word = direction == kInputsOnly ? "input" : "output";
    for (const auto& [key, node] : table) {
      const toml::table* one = node.as_table();
      const std::string name{core::trimmed(key.str())};
      if (one == nullptr) {
        std::string help = home_of(name);
        if (help.empty()) help = "write { driver = \"panel\", channel = 17 }";
        problem(Code::P7304, place(node), fmt::format("{} \"{}\" is {}; it is a table", word, name, type_word(node)),
                std::move(help));
        continue;
      }
      if (name.empty()) problem(Code::P7305, place(key), fmt::format("the name of an {} is empty", word));
      if (!one->empty() && std::all_of(one->begin(), one->end(), [](const auto& e) { return e.second.is_table(); })) {
        problem(
            Code::P7303, place(key), fmt::format("{} \"{}\" holds tables, not keys", word, name),
            fmt::format("a path is written in quotes: \"{}.{}\" = {{ driver = .. }}", name, one->begin()->first.str()));
        continue;
      }
      ChannelConfig& channel = channels.emplace_back();
      channel.variable = {name, place(key)};
      channel.direction = direction;
      Entry entry = {.direction = direction};
      if (const auto driver = (*one)["driver"].value<std::string_view>()) {
        const auto known = drivers_.find(*driver);
        if (known != drivers_.end()) {
          entry.kind = known->second;
        } else if (!core::trimmed(*driver).empty()) {
          unknown_driver(*driver, place(*one, "driver"));
        }
      }
      if (entry.kind != nullptr) channel.values = KeyValues(entry.kind->channel_keys);
      for (const auto& [named, value] : *one) channel.values.mention(named.str());
      read_table(*one, channel, entry, channel.variable.at, fmt::format("{} \"{}\"", word, name));
    }
    std::ranges::sort(channels, before, [](const ChannelConfig& channel) { return channel.variable.at; });
  }

  void unknown_driver(std::string_view name, const SourceRef& at) {
    core::Guess guess(name);
    // Not for a file of mistakes: every one of them would be compared with every driver.
    if (findings_.size() < core::Diagnostics::kMaxKept) {
      for (const auto& [known, what] : drivers_) guess.offer(known);
    }
    std::string help = guess.help();
    if (help.empty()) help = fmt::format("declare it: [drivers.{}]", name);
    problem(Code::P7308, at, fmt::format("no driver \"{}\"", name), std::move(help));
  }

  SourceRef file_at_;
  DriverTypes types_;
  Keys keys_;
  std::map<std::string, const DriverType*, std::less<>> drivers_;  ///< null: of no kind that is known
  Findings& findings_;
};

/// The most frequent cause of a syntax error.
std::string syntax_help(std::string_view text, const toml::parse_error& error) {
  std::size_t begin = 0;
  for (std::uint32_t line = 1; line < error.source().begin.line && begin != std::string_view::npos; ++line) {
    begin = text.find('\n', begin);
    if (begin != std::string_view::npos) ++begin;
  }
  if (begin == std::string_view::npos) return {};
  const std::string_view line = core::trimmed(text.substr(begin, text.find('\n', begin) - begin));
  if (line.starts_with('%'))
    return "addresses are written in quotes: \"%IX0.0\" = { driver = \"panel\", channel = 17 }";
  const std::string_view what = error.description();
  if (what.find("could not determine value type") != std::string_view::npos) return "texts are written in quotes";
  if (what.find("representable") != std::string_view::npos) return "the number is too great for any key";
  if (what.find("decimal integer") != std::string_view::npos)
    return "a number with a unit is written in quotes: \"500ms\"";
  if (what.find("inline table") != std::string_view::npos) return "from { to } is one line";
  return {};
}

std::string syntax_message(const toml::parse_error& error) {
  std::string message{error.description()};
  constexpr std::string_view kPrefix = "Error while parsing ";
  if (message.starts_with(kPrefix)) return "in a " + message.substr(kPrefix.size());
  if (!message.empty()) message.front() = core::fold(message.front());
  return message;
}

}  // namespace

std::optional<Configuration> read_configuration(std::string_view text, std::string_view file, DriverTypes types,
                                                core::Diagnostics& diagnostics, const LoadKinds& load_kinds) {
  Configuration configuration;
  configuration.file = file;
  SourceRef at;
  at.file = diagnostics.add_file(std::string(file));
  if (text.size() > core::kMaxTomlBytes) {
    diagnostics.report(Code::P7302, at, {}, fmt::format("file has more than {} bytes", core::kMaxTomlBytes));
    return std::nullopt;
  }
  if (const auto unsafe = core::find_unsafe(text)) {
    at.line = unsafe->line;
    at.column = unsafe->column;
    if (unsafe->kind == core::TextProblem::Kind::kTooDeep) {
      diagnostics.report(Code::P7302, at, {}, fmt::format("nested more than {} deep", core::kMaxTomlDepth));
    } else {
      diagnostics.report(Code::P7301, at, {},
                         "a character that may be in quotes or comments only, or a quote inside a word",
                         "texts, and names with other than letters, digits, _ and -, are written in quotes as a whole");
    }
    return std::nullopt;
  }
  Findings findings;
  try {
    const toml::table root = toml::parse(text, file);
    if (load_kinds && root.contains("driver_kinds")) {
      // Into a configuration of its own: the rest is read by the rows of all kinds.
      Configuration kinds;
      kinds.file = file;
      Findings ignored;
      Reader(at.file, types, ignored).read_kinds(root, kinds);
      types = load_kinds(kinds, findings);
    }
    // Without a kind its drivers have no keys: all else that is wrong follows from that.
    if (findings.size() != 0) return findings.report(diagnostics), std::nullopt;
    Reader(at.file, types, findings).read(root, configuration);
  } catch (const toml::parse_error& error) {
    at.line = error.source().begin.line;
    at.column = error.source().begin.column;
    diagnostics.report(Code::P7301, at, {}, syntax_message(error), syntax_help(text, error));
    return std::nullopt;
  }
  findings.report(diagnostics);
  if (findings.size() != 0) return std::nullopt;
  return configuration;
}

}  // namespace plc::io
