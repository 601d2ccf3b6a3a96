// plc retain: what a file of retained values holds.
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cstring>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "retain/carry.h"
#include "retain/store.h"
#include "runtime/value_text.h"
#include "tools/command_line.h"
#include "tools/plc/commands.h"
#include "tools/statistics.h"

namespace plc::tools {
namespace {

using bytecode::ImageField;
using bytecode::ImageType;
using bytecode::TypeKind;
using nlohmann::ordered_json;

struct Retain {
  std::string file;
  bool json = false;
  bool all = false;
};

/// Walks through the variables that are to be seen.
class Shown {
 public:
  Shown(const retain::Stored& stored, bool all) : stored_(stored), types_(stored.layout.types), all_(all) {}

  std::vector<std::vector<std::string>> rows() {
    rows_ = {{"variable", "type", "value", "kept"}};
    for (const retain::Root& root : stored_.layout.roots) {
      if (hides(root.internal)) continue;
      add_rows(root.path, root.type, stored_.values.data() + root.at, root.persistent);
    }
    return std::move(rows_);
  }

  ordered_json json() {
    ordered_json variables = ordered_json::array();
    for (const retain::Root& root : stored_.layout.roots) {
      if (hides(root.internal)) continue;
      ordered_json variable;
      variable["path"] = root.path;
      variable["type"] = retain::type_text(types_, root.type);
      variable["kept"] = word_of(root.persistent);
      variable["value"] = value_json(root.type, stored_.values.data() + root.at);
      variables.push_back(std::move(variable));
    }
    return variables;
  }

 private:
  static const char* word_of(bool persistent) { return persistent ? "PERSISTENT" : "RETAIN"; }
  [[nodiscard]] bool hides(bool internal) const { return internal && !all_; }
  [[nodiscard]] bool hides(const ImageField& field) const {
    return hides(field.internal) || field.fresh || field.constant || retain::is_reference(types_[field.type]);
  }

  /// As a program would see it, whatever the file says.
  static std::string text_of(const ImageType& type, const std::byte* from) {
    std::vector<std::byte> value(from, from + type.size);
    if (type.kind == TypeKind::kString) {
      core::StringHeader header{};
      std::memcpy(&header, value.data(), sizeof header);
      header = {type.capacity, std::min(header.length, type.capacity)};
      std::memcpy(value.data(), &header, sizeof header);
    }
    std::string text;
    runtime::append_value(type, value.data(), text, runtime::ValueStyle::kNames);
    return text;
  }

  void add_rows(const std::string& path, std::uint32_t index, const std::byte* from, bool persistent) {
    const ImageType& type = types_[index];
    if (type.kind == TypeKind::kStruct) {
      for (const ImageField& field : type.fields) {
        if (hides(field)) continue;
        add_rows(path + "." + field.name, field.type, from + field.offset, persistent || field.persistent);
      }
    } else if (type.kind == TypeKind::kArray) {
      const std::uint32_t bytes = type.size / type.count;
      for (std::uint32_t i = 0; i < type.count; ++i) {
        add_rows(fmt::format("{}[{}]", path, type.lower + std::int64_t{i}), type.element, from + std::size_t{i} * bytes,
                 persistent);
      }
    } else if (!retain::is_reference(type)) {
      rows_.push_back({path, retain::type_text(types_, index), text_of(type, from), word_of(persistent)});
    }
  }

  ordered_json value_json(std::uint32_t index, const std::byte* from) {
    const ImageType& type = types_[index];
    if (type.kind == TypeKind::kStruct) {
      ordered_json value = ordered_json::object();
      for (const ImageField& field : type.fields) {
        if (!hides(field)) value[field.name] = value_json(field.type, from + field.offset);
      }
      return value;
    }
    if (type.kind == TypeKind::kArray) {
      ordered_json value = ordered_json::array();
      const std::uint32_t bytes = type.size / type.count;
      for (std::uint32_t i = 0; i < type.count; ++i) {
        value.push_back(value_json(type.element, from + std::size_t{i} * bytes));
      }
      return value;
    }
    if (retain::is_reference(type)) return nullptr;
    const std::string text = text_of(type, from);
    if (type.elementary == core::TypeId::kBool && type.members.empty()) return from[0] != std::byte{0};
    const bool number = type.members.empty() && core::in_category(type.elementary, core::kAnyNum | core::kAnyBit);
    ordered_json value = number ? ordered_json::parse(text, nullptr, false) : ordered_json(text);
    return value.is_discarded() ? ordered_json(text) : value;
  }

  const retain::Stored& stored_;
  const std::vector<ImageType>& types_;
  bool all_;
  std::vector<std::vector<std::string>> rows_;
};

int run(const Retain& retain) {
  std::error_code error;
  const bool folder = std::filesystem::is_directory(retain.file, error);
  const std::string path = folder ? (std::filesystem::path(retain.file) / retain::kFileName).string() : retain.file;
  const auto stored = retain::read_file(path);
  if (!stored) return complain(stored.error()), exit_code_of(stored.error());
  const std::string when = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(stored->time_of_day_ns / 1'000'000'000));
  Shown shown(*stored, retain.all);
  if (retain.json) {
    ordered_json document;
    document["file"] = path;
    document["project"] = stored->layout.project;
    document["sequence"] = stored->sequence;
    document["stored"] = when;
    document["bytes"] = stored->layout.bytes;
    document["variables"] = shown.json();
    std::cout << document.dump(-1, ' ', false, ordered_json::error_handler_t::replace) << '\n';
    return kExitOk;
  }
  std::cout << fmt::format("{}: project {}, set {}, stored {}, {} bytes\n\n", path, stored->layout.project,
                           stored->sequence, when, stored->layout.bytes);
  print_table(shown.rows(), std::cout);
  return kExitOk;
}

}  // namespace

void add_retain(Command program) {
  static Retain retain;
  const Command command = program.sub("retain",
                                      "Shows the retained values that plc-run has stored. It may run meanwhile.\n"
                                      "\n"
                                      "Examples:\n"
                                      "  plc retain /var/lib/picard/plant          the file in a state folder\n"
                                      "  plc retain state/retain.previous --json   what an earlier program has kept");
  command.option("FILE", retain.file, "file of retained values, or the state folder with it").required();
  command.flag("--json", retain.json, "one JSON document: structures as objects, arrays as arrays");
  command.flag("--all", retain.all, "also what code alone knows: edges of contacts, active steps of charts");
  command.on_run([] { return run(retain); });
}

}  // namespace plc::tools
