#include "tools/taskblock_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/text.h"
#include "core/types.h"
#include "tools/taskblock_examples.h"

namespace plc::tools {
namespace {

using core::TypeId;

/// "1e-9" and not "1e-09".
std::string number_text(double value) {
  std::string text = fmt::format("{}", value);
  const std::size_t exponent = text.find_first_of('e');
  if (exponent != std::string::npos && text[exponent + 2] == '0') text.erase(exponent + 2, 1);
  return text;
}

/// A literal of the value that variables of this type begin with.
std::string zero_text(TypeId type) {
  switch (type) {
    case TypeId::kBool:
      return "FALSE";
    case TypeId::kReal:
    case TypeId::kLreal:
      return "0.0";
    case TypeId::kTime:
      return "T#0s";
    case TypeId::kLtime:
      return "LTIME#0s";
    case TypeId::kDate:
      return "D#1970-01-01";
    case TypeId::kLdate:
      return "LDATE#1970-01-01";
    case TypeId::kTod:
      return "TOD#00:00:00";
    case TypeId::kLtod:
      return "LTOD#00:00:00";
    case TypeId::kDt:
      return "DT#1970-01-01-00:00:00";
    case TypeId::kLdt:
      return "LDT#1970-01-01-00:00:00";
    case TypeId::kString:
      return "''";
    case TypeId::kWstring:
      return "\"\"";
    case TypeId::kChar:
      return "CHAR#'$00'";
    case TypeId::kWchar:
      return "WCHAR#\"$0000\"";
    default:
      return "0";
  }
}

/// Initial value of a variable of this type: zeros all of it, of enumerations the first.
std::string zeros_text(const picard_type& type) {
  switch (type.kind) {
    case PICARD_ARRAY:
      return fmt::format("[{}({})]", type.capacity, zeros_text(*type.element));
    case PICARD_STRUCT_TYPE: {
      std::string text;
      for (std::uint32_t i = 0; i < type.field_count; ++i) {
        text += fmt::format("{}{} := {}", i == 0 ? "" : ", ", type.fields[i].name, zeros_text(*type.fields[i].type));
      }
      return "(" + text + ")";
    }
    case PICARD_ENUM_TYPE:
      return type.enumerators[0].name;
    default:
      return zero_text(*core::type_named(type.name));
  }
}

std::string initial_text(const picard_port& port) {
  return port.initial[0] != '\0' ? std::string(port.initial) : zeros_text(*port.type);
}

bool is_queue(const picard_port& port) {
  return port.direction == PICARD_QUEUE_READER || port.direction == PICARD_QUEUE_WRITER;
}

/// Ports of these directions, one direction after the other, as declarations list them.
std::vector<const picard_port*> ports_of(const picard_block& block, std::initializer_list<std::uint32_t> directions) {
  std::vector<const picard_port*> ports;
  for (const std::uint32_t direction : directions) {
    for (std::uint32_t i = 0; i < block.port_count; ++i) {
      if (block.ports[i].direction == direction) ports.push_back(&block.ports[i]);
    }
  }
  return ports;
}

std::string_view wire_text(const picard_port& port) {
  if (is_queue(port)) return ">>>>";
  return port.direction == PICARD_CONFIG ? "====" : "----";
}

/// `head`, then the items, then `tail`; on lines of their own, where one line would be too long.
std::string list_text(const std::string& head, const std::vector<std::string>& items, std::string_view tail) {
  constexpr std::size_t kWidth = 100;
  std::string text = head;
  std::string line = head;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const std::string item = items[i] + (i + 1 < items.size() ? "," : std::string(tail));
    if (i != 0 && line.size() + 1 + item.size() > kWidth) {
      line = std::string(std::min<std::size_t>(head.size(), 24), ' ');
      text += "\n" + line + item;
    } else {
      text += (i == 0 ? "" : " ") + item;
    }
    line += " " + item;
  }
  return items.empty() ? text + std::string(tail) : text;
}

/// `name` without what tells file names from block names.
std::string bare(std::string_view name) {
  std::string text = core::folded(name);
  std::erase(text, '_');
  return text;
}

}  // namespace

std::vector<TaskblockGroup> taskblock_groups(const taskblocks::Registry& registry) {
  std::vector<TaskblockGroup> groups;
  for (const taskblocks::Registry::Entry& entry : registry.entries()) {
    auto group = std::find_if(groups.begin(), groups.end(),
                              [&entry](const TaskblockGroup& g) { return core::iequals(g.title, entry.block->group); });
    if (group == groups.end()) group = groups.insert(groups.end(), {entry.block->group, {}});
    group->entries.push_back(&entry);
  }
  return groups;
}

bool is_simple(const picard_type& type) { return type.kind != PICARD_ARRAY && type.kind != PICARD_STRUCT_TYPE; }

std::string_view port_word(const picard_port& port) {
  switch (port.direction) {
    case PICARD_INPUT:
      return "input";
    case PICARD_OUTPUT:
      return "output";
    case PICARD_CONFIG:
      return "configuration";
    case PICARD_QUEUE_READER:
      return "queue reader";
    case PICARD_QUEUE_WRITER:
      return "queue writer";
    default:
      return "";
  }
}

std::string range_text(const picard_port& port) {
  const bool from = std::isfinite(port.lowest), to = std::isfinite(port.highest);
  if (from && to) return number_text(port.lowest) + " .. " + number_text(port.highest);
  if (from) return ">= " + number_text(port.lowest);
  return to ? "<= " + number_text(port.highest) : std::string{};
}

std::string default_text(const picard_port& port) {
  if (is_queue(port) || port.direction == PICARD_OUTPUT) return port.initial;
  return port.initial[0] != '\0' || !is_simple(*port.type) ? port.initial : zeros_text(*port.type);
}

std::vector<std::vector<std::string>> port_cells(const picard_block& block) {
  std::vector<std::vector<std::string>> lines = {{"port", "", "type", "unit", "range", "default", "meaning"}};
  for (const picard_port* port :
       ports_of(block, {PICARD_INPUT, PICARD_QUEUE_READER, PICARD_QUEUE_WRITER, PICARD_CONFIG, PICARD_OUTPUT})) {
    lines.push_back({port->name, std::string(port_word(*port)), taskblocks::type_text(*port->type), port->unit,
                     range_text(*port), default_text(*port), port->summary});
  }
  for (std::size_t column = lines.front().size(); column-- > 0;) {
    const bool used = std::any_of(lines.begin() + 1, lines.end(),
                                  [column](const std::vector<std::string>& cells) { return !cells[column].empty(); });
    if (used) continue;
    for (auto& cells : lines) cells.erase(cells.begin() + static_cast<std::ptrdiff_t>(column));
  }
  return lines;
}

std::string box_text(const picard_block& block) {
  // Queues are named on the left, as in-outs are, whether elements go in or out.
  const auto left = ports_of(block, {PICARD_INPUT, PICARD_QUEUE_READER, PICARD_QUEUE_WRITER, PICARD_CONFIG});
  const auto right = ports_of(block, {PICARD_OUTPUT});
  const std::string_view title = block.name;
  std::size_t type_width = 0, left_width = 0, right_width = 0;
  for (const picard_port* port : left) {
    type_width = std::max(type_width, taskblocks::type_text(*port->type).size());
    left_width = std::max(left_width, std::string_view(port->name).size());
  }
  for (const picard_port* port : right) right_width = std::max(right_width, std::string_view(port->name).size());
  const std::size_t width = std::max(left_width + 2 + right_width, title.size() + 2);
  const std::string edge = fmt::format("{:{}}+{:-<{}}+\n", "", type_width + 5, "", width);
  std::string text = fmt::format("{0}{1:{2}}|{3:^{4}}|\n", edge, "", type_width + 5, title, width);
  for (std::size_t row = 0; row < std::max(left.size(), right.size()); ++row) {
    std::string line = row < left.size() ? fmt::format("{:>{}} {}|{}", taskblocks::type_text(*left[row]->type),
                                                       type_width, wire_text(*left[row]), left[row]->name)
                                         : fmt::format("{:{}}|", "", type_width + 5);
    const std::string_view name = row < right.size() ? right[row]->name : "";
    line += fmt::format("{:>{}}|", name, type_width + 6 + width - line.size());
    if (row < right.size()) {
      line += fmt::format("{} {}", wire_text(*right[row]), taskblocks::type_text(*right[row]->type));
    }
    text += line + '\n';
  }
  return text + edge;
}

std::string call_text(const picard_block& block) {
  const std::string instance = core::folded(block.name) + "1";
  std::vector<std::string> constants, inputs, outputs;
  std::string variables, queues;
  for (const picard_port* port : ports_of(block, {PICARD_CONFIG})) {
    constants.push_back(fmt::format("{} := {}", port->name, initial_text(*port)));
  }
  for (const picard_port* port : ports_of(block, {PICARD_INPUT})) {
    if (is_simple(*port->type)) {
      inputs.push_back(fmt::format("{} := {}", port->name, initial_text(*port)));
      continue;
    }
    // Only variables hold such values.
    const std::string variable = fmt::format("{}_{}", instance, core::folded(port->name));
    variables += fmt::format("  {} : {}{}{};\n", variable, taskblocks::type_text(*port->type),
                             port->initial[0] != '\0' ? " := " : "", port->initial);
    inputs.push_back(fmt::format("{} := {}", port->name, variable));
  }
  for (const picard_port* port : ports_of(block, {PICARD_QUEUE_READER, PICARD_QUEUE_WRITER})) {
    const std::string queue = core::folded(port->name);
    queues += fmt::format("  {} : ARRAY [0..63] OF {};\n", queue, taskblocks::type_text(*port->type));
    inputs.push_back(fmt::format("{} := {}", port->name, queue));
  }
  for (const picard_port* port : ports_of(block, {PICARD_OUTPUT})) outputs.push_back(instance + "." + port->name);
  const std::string declared = fmt::format("  {} : {}", instance, block.name);
  std::string text = queues.empty() ? "VAR\n" : "VAR_GLOBAL\n" + queues + "END_VAR\nVAR\n";
  text += constants.empty() ? declared + ";\n" : list_text(declared + " := (", constants, ");") + "\n";
  text += variables + "END_VAR\n\n" + list_text(instance + "(", inputs, ");") + "\n";
  return outputs.empty() ? text : text + list_text("(* then: ", outputs, " *)") + "\n";
}

std::vector<DetailsPart> details_parts(std::string_view markdown) {
  std::vector<DetailsPart> parts;
  std::istringstream lines{std::string(markdown)};
  bool open = false;
  for (std::string line; std::getline(lines, line);) {
    const std::string_view text = core::trimmed(line);
    if (text.empty()) {
      open = false;
    } else if (text.starts_with("- ")) {
      parts.push_back({true, std::string(text.substr(2))});
      open = true;
    } else if (open) {
      parts.back().text += " " + std::string(text);
    } else {
      parts.push_back({false, std::string(text)});
      open = true;
    }
  }
  return parts;
}

std::string wrapped(std::string_view markdown, std::size_t indent, std::size_t width) {
  std::string text;
  bool after_item = false;
  for (const DetailsPart& part : details_parts(markdown)) {
    if (!text.empty() && !(part.item && after_item)) text += '\n';
    after_item = part.item;
    std::string line = std::string(indent, ' ') + (part.item ? "-" : "");
    std::istringstream words(part.text);
    bool first = !part.item;
    for (std::string word; words >> word;) {
      if (!first && line.size() + 1 + word.size() > width) {
        text += line + '\n';
        line = std::string(indent + (part.item ? 2 : 0), ' ');
        first = true;
      }
      line += (first ? "" : " ") + word;
      first = false;
    }
    text += line + '\n';
  }
  return text;
}

std::string taskblock_folder(std::string_view group) {
  std::string name = core::folded(group);
  std::replace_if(
      name.begin(), name.end(), [](char c) { return (c < 'a' || c > 'z') && (c < '0' || c > '9'); }, '_');
  return name;
}

const TaskblockExample* taskblock_example(const picard_block& block) {
  const std::string folder = taskblock_folder(block.group) + "/";
  for (const TaskblockExample& example : taskblock_examples()) {
    if (!example.path.starts_with(folder) || !example.path.ends_with(".xml")) continue;
    const std::string_view name = example.path.substr(folder.size(), example.path.size() - folder.size() - 4);
    if (bare(name) == bare(block.name)) return &example;
  }
  return nullptr;
}

}  // namespace plc::tools
