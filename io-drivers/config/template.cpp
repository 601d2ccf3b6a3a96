#include "io-drivers/config/template.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <vector>

#include "core/text.h"
#include "io-drivers/config/bind.h"
#include "io-drivers/config/driver_type.h"
#include "runtime/access.h"

namespace plc::io {
namespace {

using bytecode::Image;
using bytecode::ImageField;
using bytecode::ImageType;
using bytecode::TypeKind;

/// Lines for parts of one array or structure.
constexpr std::size_t kMaxParts = 64;
constexpr std::size_t kWidth = 118;

/// Comments and keys must not hold control characters.
std::string plain(std::string_view text) {
  std::string out(text);
  for (char& c : out) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  }
  return out;
}

std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : plain(text)) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

std::string type_name(const ImageType& type) {
  if (!type.name.empty()) return plain(type.name);
  if (type.kind == TypeKind::kString) return fmt::format("{}[{}]", core::name_of(type.elementary), type.capacity);
  return std::string(core::name_of(type.elementary));
}

/// A part of a located variable that is a single value.
struct Part {
  std::string path;
  const ImageType* type = nullptr;
};

class Template {
 public:
  Template(runtime::Resource& resource, std::string_view project, DriverTypes types)
      : resource_(resource),
        image_(resource.image()),
        access_(resource),
        project_(plain(project)),
        types_(types),
        keys_(types) {}

  std::string run() {
    find_aliases();
    comment(fmt::format("plc.toml: what is connected to this machine, for {}.", project_));
    comment("");
    comment(
        "Comments have a blank after the #. A # without one is before a setting, with its default or an example: "
        "take "
        "it away to use the line.");
    comment(fmt::format("Check the file: plc config check plc.toml {}", project_));
    comment("All tables and keys: docs/reference/configuration.md");
    section(TableId::kProject, "[project]");
    section(TableId::kDriverKinds, "[driver_kinds]");
    out_ += '\n';
    table(TableId::kDriver);
    for (const DriverType* type : types_) {
      out_ += fmt::format("#[drivers.{}]\n", type->example);
      keys(TableId::kDriver, type);
      out_ += '\n';
    }

    table(TableId::kChannel);
    for (const KeyInfo& key : keys_.rows()) {
      if (key.table == TableId::kChannel) comment(fmt::format("  {}: {}", key.name, describe(key)), "    ");
    }
    variables('I', "\n[inputs]\n");
    variables('Q', "\n[outputs]\n");
    memory();

    section(TableId::kScheduler, "[scheduler]");
    out_ += '\n';
    table(TableId::kTask);
    tasks();
    section(TableId::kTaskblocks, "[taskblocks]");
    section(TableId::kRetain, "[retain]");
    section(TableId::kLog, "[log]");
    section(TableId::kRecord, "[record]");
    section(TableId::kClock, "[clock]");
    section(TableId::kModbus, "[modbus]");
    section(TableId::kModbusSerial, "[modbus.serial]");
    section(TableId::kModbusRange, "[[modbus.range]]");
    section(TableId::kEngineering, "[engineering]");
    section(TableId::kGuardian, "[guardian]");
    return std::move(out_);
  }

 private:
  [[nodiscard]] const std::vector<ImageField>& globals() const { return image_.types[image_.global_type].fields; }

  /// The text as comment lines; `indent` before all lines but the first.
  void comment(std::string_view text, std::string_view indent = "") {
    std::string line = "#";
    for (std::size_t at = 0; at < text.size();) {
      std::size_t end = text.find(' ', std::max(at, text.find_first_not_of(' ', at)));
      if (end == std::string_view::npos) end = text.size();
      const std::string_view word = text.substr(at, end - at);
      if (line.size() + word.size() + 1 > kWidth) {
        out_ += line + '\n';
        line = "#" + std::string(indent);
      }
      line += ' ';
      line += word;
      at = end + 1;
    }
    out_ += line + '\n';
  }

  void table(TableId id) {
    for (const TableInfo& info : config_tables()) {
      if (info.id == id) comment(fmt::format("{}: {}", info.heading, info.documentation));
    }
  }

  void section(TableId id, std::string_view heading) {
    out_ += '\n';
    table(id);
    out_ += fmt::format("#{}\n", heading);
    keys(id);
  }

  static std::string describe(const KeyInfo& key) {
    std::string text{key.documentation};
    const KeyKind kind = key.type.kind;
    // The default tells of other types what they are.
    const bool limited = kind == KeyKind::kInteger || kind == KeyKind::kChoice || kind == KeyKind::kDuration;
    if (limited) text += fmt::format(" Takes {}.", type_text(key.type));
    const std::string applies = applies_text(key);
    if (!applies.empty()) text += fmt::format(" ({})", applies);
    return text;
  }

  void keys(TableId id, const DriverType* type = nullptr) {
    for (const KeyInfo& key : keys_.rows()) {
      if (key.table != id || (key.kind != nullptr && key.kind != type)) continue;
      comment(describe(key));
      std::string value{key.fallback.toml};
      if (id == TableId::kDriver && key.name == "kind") value = quoted(type->name);
      if (id == TableId::kDriver && key.name == "task") value = quoted(image_.tasks[fastest_task(image_)].name);
      out_ += fmt::format("#{} = {}\n", key.name, value);
    }
  }

  /// Every key for the first task; the others are named.
  void tasks() {
    for (const bytecode::ImageTask& task : image_.tasks) {
      out_ += fmt::format("#[tasks.{}]\n", toml_key(task.name));
      if (&task == &image_.tasks.front()) keys(TableId::kTask);
    }
  }

  /// Located variables of POUs have no name among the globals; the path below the first instance is theirs.
  void find_aliases() {
    for (const bytecode::ImageTask& task : image_.tasks) {
      const ImageType& whole = image_.types[image_.pous[task.body].instance_type];
      for (const bytecode::ImageAlias& alias : whole.aliases) aliases_.emplace(alias.global, alias.name);
      for (const ImageField& instance : whole.fields) find_aliases(instance.name, image_.types[instance.type]);
    }
  }
  void find_aliases(const std::string& path, const ImageType& type) {
    if (type.kind != TypeKind::kStruct || path.find('#') != std::string::npos) return;
    for (const bytecode::ImageAlias& alias : type.aliases) aliases_.emplace(alias.global, path + "." + alias.name);
    for (const ImageField& field : type.fields) find_aliases(path + "." + field.name, image_.types[field.type]);
  }

  /// Words that lead to global number `field`: its address, when no other has the same, or its name.
  std::string key_of(std::uint32_t field) {
    const std::string& list = image_.globals[field].list;
    const std::string& name = globals()[field].name;
    std::vector<std::string> words = {image_.globals[field].address, list.empty() ? name : list + "." + name};
    const auto alias = aliases_.find(field);
    if (alias != aliases_.end()) words.push_back(alias->second);
    for (const std::string& word : words) {
      const auto place = access_.find(word);
      if (place && place->task == runtime::Place::kGlobal && place->offset == globals()[field].offset &&
          place->type == globals()[field].type) {
        return word;
      }
    }
    return {};
  }

  void parts_of(const std::string& path, std::uint32_t type_index, std::vector<Part>& parts) {
    const ImageType& type = image_.types[type_index];
    if (parts.size() > kMaxParts || type.kind == TypeKind::kRef) return;
    if (type.kind == TypeKind::kScalar || type.kind == TypeKind::kString) {
      parts.push_back({path, &type});
    } else if (type.kind == TypeKind::kArray) {
      for (std::uint32_t i = 0; i < type.count && parts.size() <= kMaxParts; ++i) {
        parts_of(fmt::format("{}[{}]", path, type.lower + static_cast<std::int64_t>(i)), type.element, parts);
      }
    } else {
      for (const ImageField& field : type.fields) parts_of(path + "." + field.name, field.type, parts);
    }
  }

  /// The fields at addresses of an area: 'I', 'Q' or 'M'.
  [[nodiscard]] std::vector<std::uint32_t> located(char area) const {
    std::vector<std::uint32_t> fields;
    for (std::uint32_t i = 0; i < globals().size(); ++i) {
      const std::string& address = image_.globals[i].address;
      if (address.size() > 1 && core::upper(address[1]) == area) fields.push_back(i);
    }
    return fields;
  }

  /// "%IX0.0 StartButton", "%IX0.0 Main.Start"; without the address after a key that is the address.
  std::string heading(std::uint32_t field, std::string_view key = {}) {
    const std::string& name = globals()[field].name;
    const bool declared = !name.starts_with('%') && name.find('.') == std::string::npos;
    const auto alias = aliases_.find(field);
    const std::string shown = !declared && alias != aliases_.end() ? alias->second : name;
    const std::string& address = image_.globals[field].address;
    if (shown == address || key == address) return plain(shown == key ? "" : shown);
    return plain(address + " " + shown);
  }

  void variables(char area, std::string_view header) {
    out_ += header;
    const std::vector<std::uint32_t> fields = located(area);
    if (fields.empty()) comment(fmt::format("The project has no variable at a %{} address.", area));
    for (const std::uint32_t field : fields) {
      std::vector<Part> parts;
      const std::string key = key_of(field);
      const auto writers = resource_.globals().exporters(field);
      const std::string head = heading(field);
      if (globals()[field].constant) {
        comment(head + ": a constant");
      } else if (area == 'I' && !writers.empty()) {
        comment(
            fmt::format("{}: task {} writes it, so no device can", head, plain(image_.tasks[writers.front()].name)));
      } else if (key.empty()) {
        comment(head + ": hidden by another variable of the same name");
      } else {
        parts_of(key, globals()[field].type, parts);
        if (parts.size() != 1) comment(head);
      }
      for (std::size_t i = 0; i < std::min(parts.size(), kMaxParts); ++i) {
        channel(parts[i], area == 'Q', parts.size() == 1 ? heading(field, key) : std::string());
      }
      if (parts.size() > kMaxParts) comment("and so on");
    }
  }

  /// The keys that lead to the next free channel for a variable of this type; nothing when no driver takes it.
  std::optional<std::string> next_channel(const ImageType& type) {
    for (const bool real : {true, false}) {  // something at the machine, where there is something for it
      for (const DriverType* kind : types_) {
        if (kind->real != real) continue;
        if (kind->refuses != nullptr && !kind->refuses(KeyValues(kind->channel_keys), type).empty()) continue;
        const auto keys =
            kind->example_channel == nullptr ? std::optional(std::string()) : kind->example_channel(type, used_[kind]);
        if (!keys) continue;
        return fmt::format("driver = {}{}{}", quoted(kind->example), keys->empty() ? "" : ", ", *keys);
      }
    }
    return std::nullopt;
  }

  void channel(const Part& part, bool output, const std::string& head) {
    const auto keys = next_channel(*part.type);
    if (!keys) return;
    std::string text = *keys;
    const bool bit = is_bool(*part.type);
    const bool is_number =
        part.type->kind == TypeKind::kScalar && !bit && !core::in_category(part.type->elementary, core::kAnyChar);
    if (output && bit) text += ", safe = false";
    if (output && is_number) text += ", safe = " + safe_number(*part.type);
    out_ += fmt::format("#{} = {{ {} }}  # {}{}{}\n", quoted(part.path), text, head, head.empty() ? "" : ": ",
                        type_name(*part.type));
  }

  /// 0, or what is nearest to it.
  static std::string safe_number(const ImageType& type) {
    if (!type.limited) return "0";
    return std::to_string(std::clamp<std::int64_t>(0, type.lower, type.upper));
  }

  void memory() {
    const std::vector<std::uint32_t> fields = located('M');
    if (fields.empty()) return;
    out_ += '\n';
    comment("Variables at %M addresses have no channel; they are read and written over Modbus:");
    for (const std::uint32_t field : fields) comment("  " + heading(field));
  }

  runtime::Resource& resource_;
  const Image& image_;
  runtime::Access access_;
  std::string project_;
  std::map<std::uint32_t, std::string> aliases_;  ///< by global
  DriverTypes types_;
  Keys keys_;
  std::map<const DriverType*, std::uint32_t> used_;  ///< channels
  std::string out_;
};

}  // namespace

std::string configuration_template(runtime::Resource& resource, std::string_view project, DriverTypes types) {
  return Template(resource, project, types).run();
}

std::string configuration_reference(DriverTypes types) {
  std::string out =
      "# Configuration: plc.toml\n\n"
      "What is connected to a machine, in [TOML](https://toml.io/en/v1.0.0). `plc config init` writes a file for a "
      "project,\n"
      "`plc config check` checks one; the [guide](../guides/configuration.md) has an example. Unknown keys are errors. "
      "Durations\n"
      "are texts: `\"500ms\"`, `\"5s\"`, `\"1.5min\"`.\n";
  const Keys keys(types);
  for (const TableInfo& table : config_tables()) {
    out += fmt::format("\n## {}\n\n{}\n\n| key | takes | default | |\n| --- | --- | --- | --- |\n", table.heading,
                       table.documentation);
    for (const KeyInfo& key : keys.rows()) {
      if (key.table != table.id) continue;
      const std::string applies = applies_text(key);
      const bool has_default = key.fallback.kind == KeyDefault::Kind::kValue;
      const std::string without = has_default ? fmt::format("`{}`", key.fallback.toml)
                                  : key.fallback.kind == KeyDefault::Kind::kNothing ? "none"
                                                                                    : "required";
      out += fmt::format("| `{}` | {}{} | {} | {} |\n", key.name, type_text(key.type),
                         applies.empty() ? "" : "; " + applies, without, key.documentation);
    }
  }
  return out;
}

std::string toml_key(std::string_view name) {
  const bool bare = !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    const char f = core::fold(c);
    return (f >= 'a' && f <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
  return bare ? std::string(name) : quoted(name);
}

}  // namespace plc::io
