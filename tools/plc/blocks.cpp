// plc blocks: the taskblocks for people: which there are, and what one of them does; as JSON for scripts and HMIs, as
// declarations for editors, as an HTML reference.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/guess.h"
#include "stdlib/library.h"
#include "taskblocks/registry.h"
#include "tools/command_line.h"
#include "tools/plc/commands.h"
#include "tools/taskblock_html.h"
#include "tools/taskblock_libraries.h"
#include "tools/taskblock_text.h"
#include "tools/taskblock_xml.h"

namespace plc::tools {
namespace {

using nlohmann::ordered_json;
using taskblocks::Registry;

struct Blocks {
  std::string name;
  std::string configuration;  ///< plc.toml that names further libraries
  bool json = false;
  bool xml = false;
  bool st = false;
  bool example = false;
  std::string html;
  std::string output;
};

using Entries = std::vector<const Registry::Entry*>;

// ---- text -----------------------------------------------------------------------------------------------------

void print_overview(const Registry& registry) {
  std::vector<std::vector<std::string>> lines;
  for (const TaskblockGroup& group : taskblock_groups(registry)) {
    if (!lines.empty()) lines.emplace_back();
    lines.push_back({std::string(group.title)});
    for (const Registry::Entry* entry : group.entries) {
      lines.push_back({fmt::format("  {}", entry->block->name), entry->block->summary});
    }
  }
  std::cout << columns_text(lines)
            << "\nplc blocks NAME tells more: plc blocks LOWPASS. The standard function blocks: plc lib\n";
}

/// `text` after `indent` blanks.
std::string indented(const std::string& text, std::size_t indent) {
  std::string out;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    if (end != begin) out += std::string(indent, ' ') + text.substr(begin, end - begin);
    out += '\n';
    begin = end + 1;
  }
  return out;
}

std::string origin_text(const Registry::Entry& entry) {
  return fmt::format("{} {}{}", entry.library->name, entry.library->version,
                     entry.source.empty() ? ", comes with PICARD" : ", " + entry.source);
}

void print_block(const Registry::Entry& entry) {
  const picard_block& block = *entry.block;
  std::cout << fmt::format("{} ({})\n  {}\n\n{}\n{}", block.name, block.group, block.summary,
                           indented(box_text(block), 2), columns_text(port_cells(block), 2));
  if (block.details[0] != '\0') std::cout << '\n' << wrapped(block.details, 2, 100);
  std::string types;
  for (const picard_type* type : taskblocks::data_types_of(block)) types += taskblocks::declaration(*type);
  if (!types.empty()) std::cout << "\n  data types\n" << indented(types, 4);
  std::cout << "\n  in ST\n" << indented(call_text(block), 4);
  std::cout << fmt::format("\n  library: {}\n", origin_text(entry));
  if (block.budget_ns != 0) {
    std::cout << fmt::format("  time budget: {}; an execution that takes longer is a fault of the task (R1005)\n",
                             duration_text(static_cast<double>(block.budget_ns)));
  }
  if (taskblock_example(block) != nullptr) {
    std::cout << fmt::format("  drawn example: plc blocks {} --example -o example.xml\n", block.name);
  }
}

// ---- JSON -----------------------------------------------------------------------------------------------------

ordered_json limit_json(double limit) { return std::isfinite(limit) ? ordered_json(limit) : ordered_json(nullptr); }

ordered_json to_json(const picard_port& port) {
  return {{"name", port.name},
          {"direction", port_word(port)},
          {"type", taskblocks::type_text(*port.type)},
          {"unit", port.unit},
          {"min", limit_json(port.lowest)},
          {"max", limit_json(port.highest)},
          {"default", default_text(port)},
          {"summary", port.summary}};
}

ordered_json to_json(const picard_type& type) {
  if (type.kind == PICARD_ENUM_TYPE) {
    ordered_json values = ordered_json::array();
    for (std::uint32_t i = 0; i < type.enumerator_count; ++i) {
      values.push_back({{"name", type.enumerators[i].name}, {"value", type.enumerators[i].value}});
    }
    return {{"name", type.name}, {"type", taskblocks::type_text(*type.element)}, {"values", std::move(values)}};
  }
  ordered_json fields = ordered_json::array();
  for (std::uint32_t i = 0; i < type.field_count; ++i) {
    fields.push_back({{"name", type.fields[i].name}, {"type", taskblocks::type_text(*type.fields[i].type)}});
  }
  return {{"name", type.name}, {"fields", std::move(fields)}};
}

ordered_json to_json(const Registry::Entry& entry) {
  const picard_block& block = *entry.block;
  ordered_json row{{"name", block.name},       {"group", block.group},           {"summary", block.summary},
                   {"details", block.details}, {"library", entry.library->name}, {"version", entry.library->version},
                   {"file", entry.source},     {"budget_ns", block.budget_ns}};
  row["ports"] = ordered_json::array();
  for (std::uint32_t i = 0; i < block.port_count; ++i) row["ports"].push_back(to_json(block.ports[i]));
  row["data_types"] = ordered_json::array();
  for (const picard_type* type : taskblocks::data_types_of(block)) row["data_types"].push_back(to_json(*type));
  row["call"] = call_text(block);
  return row;
}

std::string json_text(const Entries& entries) {
  ordered_json document{{"blocks", ordered_json::array()}};
  for (const Registry::Entry* entry : entries) document["blocks"].push_back(to_json(*entry));
  return document.dump(2) + '\n';
}

// ---- documents ------------------------------------------------------------------------------------------------

std::string st_text(const Entries& entries) {
  std::vector<std::string> types;
  std::string blocks;
  for (const Registry::Entry* entry : entries) {
    for (const picard_type* type : taskblocks::data_types_of(*entry->block)) {
      std::string text = taskblocks::declaration(*type);
      if (std::find(types.begin(), types.end(), text) == types.end()) types.push_back(std::move(text));
    }
    blocks += (blocks.empty() ? "" : "\n") + taskblocks::block_declaration(*entry->block);
  }
  std::string text;
  for (const std::string& type : types) text += type + '\n';
  return text + blocks;
}

/// Writes a document to the file asked for, or to standard output.
int write(const Blocks& blocks, std::string_view text) {
  std::string why;
  if (blocks.output.empty()) {
    std::cout << text;
  } else if (!write_file(blocks.output, text, why)) {
    complain("plc blocks", fmt::format("{} cannot be written: {}", blocks.output, why));
    return kExitUsage;
  } else {
    std::cout << fmt::format("{}: {} bytes\n", blocks.output, text.size());
  }
  return kExitOk;
}

int write_html(const Blocks& blocks, const Registry& registry) {
  std::error_code error;
  std::filesystem::create_directories(blocks.html, error);
  if (error) {
    complain("plc blocks", fmt::format("{} cannot be made: {}", blocks.html, error.message()));
    return kExitUsage;
  }
  const std::vector<HtmlFile> files = taskblock_html(registry);
  for (const HtmlFile& file : files) {
    const std::string path = (std::filesystem::path(blocks.html) / file.name).string();
    std::string why;
    if (write_file(path, file.text, why)) continue;
    complain("plc blocks", fmt::format("{} cannot be written: {}", path, why));
    return kExitUsage;
  }
  std::cout << fmt::format("{}: {}\n", (std::filesystem::path(blocks.html) / "index.html").string(),
                           counted(files.size(), "file"));
  return kExitOk;
}

int write_example(const Blocks& blocks, const Registry::Entry& entry) {
  const TaskblockExample* const example = taskblock_example(*entry.block);
  if (example == nullptr) {
    complain("plc blocks", fmt::format("{} has no example: it comes from {}", entry.block->name, origin_text(entry)),
             fmt::format(
                 "plc blocks {0} prints a call in ST to begin with, plc blocks {0} --xml the declaration to draw with",
                 entry.block->name));
    return kExitErrors;
  }
  return write(blocks, example->text);
}

int unknown(const std::string& name, const Registry& registry) {
  core::Guess guess(name);
  for (const Registry::Entry& entry : registry.entries()) guess.offer(entry.block->name);
  const std::string help = guess.help();
  complain("plc blocks", fmt::format("there is no taskblock \"{}\"", name),
           !help.empty()                          ? help
           : stdlib::block_named(name) != nullptr ? fmt::format("it is of the standard library: plc lib {}", name)
                                                  : "plc blocks lists all of them");
  return kExitErrors;
}

int misused(std::string_view message, std::string_view help) {
  complain("plc blocks", message, help);
  return kExitUsage;
}

int run(const Blocks& blocks) {
  Registry registry;
  std::vector<std::string> libraries;  // of declarations: without blocks
  if (const auto code = load_taskblocks(blocks.configuration, registry, libraries)) return *code;
  const bool document = blocks.json || blocks.xml || blocks.st || blocks.example;
  if (!blocks.output.empty() && !document)
    return misused("-o writes documents", "add --json, --xml, --st or --example");
  if (!blocks.html.empty()) {
    return blocks.name.empty() ? write_html(blocks, registry)
                               : misused("--html writes the pages of all blocks", "leave the name out");
  }
  if (blocks.example && blocks.name.empty()) return misused("--example is of one block", "give its name");
  Entries entries;
  if (!blocks.name.empty()) {
    const Registry::Entry* const entry = registry.find(blocks.name);
    if (entry == nullptr) return unknown(blocks.name, registry);
    entries.push_back(entry);
  } else {
    for (const TaskblockGroup& group : taskblock_groups(registry)) {
      entries.insert(entries.end(), group.entries.begin(), group.entries.end());
    }
  }
  if (blocks.example) return write_example(blocks, *entries.front());
  if (blocks.xml) return write(blocks, taskblocks_xml(entries));
  if (blocks.st) return write(blocks, st_text(entries));
  if (blocks.json) return write(blocks, json_text(entries));
  if (blocks.name.empty()) {
    print_overview(registry);
  } else {
    print_block(*entries.front());
  }
  return kExitOk;
}

}  // namespace

void add_blocks(Command program) {
  static Blocks blocks;
  const Command command = program.sub(
      "blocks",
      "Prints the taskblocks, components in C++ that drawings and texts use like function blocks; or what one of them\n"
      "does: ports with types, units, ranges and defaults, details, a call in ST.\n"
      "\n"
      "Examples:\n"
      "  plc blocks                                 everything, in groups\n"
      "  plc blocks LOWPASS                         one block, drawn, with its ports\n"
      "  plc blocks LOWPASS --example -o show.xml   a project that draws it: plc sim show.xml --watch '*'\n"
      "  plc blocks --xml -o blocks.xml             all of them for editors to import\n"
      "  plc blocks --html reference                a reference to read in a browser: reference/index.html\n"
      "  plc blocks --json                          for scripts, editors and HMIs");
  command.option("NAME", blocks.name, "taskblock, in any letter case");
  add_taskblocks_option(command, blocks.configuration);
  const Flag json = command.flag("--json", blocks.json, "one JSON document on standard output");
  const Flag xml =
      command.flag("--xml", blocks.xml, "a PLCopen XML library: interfaces to draw with, the runtime has the bodies");
  const Flag st = command.flag("--st", blocks.st, "the same declarations in ST");
  const Flag example = command.flag("--example", blocks.example, "a PLCopen XML project that shows the block");
  const Flag html =
      command.option("--html=DIR", blocks.html, "folder for an HTML reference: an index and a page a block");
  const Flag output = command.option("-o,--output=FILE", blocks.output, "file to write instead of standard output");
  json.excludes({xml, st, example, html});
  xml.excludes({st, example, html});
  st.excludes({example, html});
  example.excludes({html});
  html.excludes({output});
  command.on_run([] { return run(blocks); });
}

}  // namespace plc::tools
