// plc lib: the standard library for people: what there is, and what one function or block means; as JSON for scripts,
// and as a PLCopen XML library for editors.
#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/glob.h"
#include "core/guess.h"
#include "core/text.h"
#include "tools/command_line.h"
#include "tools/library_text.h"
#include "tools/library_xml.h"
#include "tools/plc/commands.h"

namespace plc::tools {
namespace {

using nlohmann::ordered_json;

struct Lib {
  std::string name;
  bool json = false;
  bool xml = false;
  std::string output;
};

/// Names before summaries; longer lists are on a line of their own.
constexpr std::size_t kNameWidth = 24;

bool is_pattern(std::string_view name) { return name.find_first_of("*?") != std::string_view::npos; }

/// Functions and blocks that were asked for.
struct Selection {
  std::vector<LibraryFunction> functions;
  std::vector<const stdlib::BundleSpec*> bundles;
  std::vector<const stdlib::BlockSpec*> blocks;
  std::vector<const stdlib::SpecialSpec*> specials;
  [[nodiscard]] bool empty() const {
    return functions.empty() && bundles.empty() && blocks.empty() && specials.empty();
  }
};

Selection everything() {
  Selection all;
  for (const stdlib::FunctionSpec* spec : stdlib::function_specs()) {
    if (!stdlib::is_bundle_output(*spec)) all.functions.push_back(library_function(*spec));
  }
  for (const stdlib::BundleSpec& bundle : stdlib::bundles()) all.bundles.push_back(&bundle);
  for (const stdlib::SpecialSpec& special : stdlib::specials()) all.specials.push_back(&special);
  for (const stdlib::BlockSpec& block : stdlib::blocks()) all.blocks.push_back(&block);
  return all;
}

Selection named(std::string_view name) {
  Selection found{functions_named(name), {}, {}, {}};
  for (const stdlib::SpecialSpec& special : stdlib::specials()) {
    if (core::iequals(special.name, name)) found.specials.push_back(&special);
  }
  if (const stdlib::BundleSpec* bundle = stdlib::bundle_named(name)) found.bundles.push_back(bundle);
  if (const stdlib::BlockSpec* block = stdlib::block_named(name)) found.blocks.push_back(block);
  return found;
}

/// All names that match, members of families too; one row under one name.
Selection matching(std::string_view pattern) {
  Selection found;
  std::string_view last;
  for (const stdlib::Overload& overload : stdlib::overloads()) {
    if (overload.name == last || stdlib::is_bundle_output(*overload.spec)) continue;
    if (!core::glob_match(pattern, overload.name)) continue;
    last = overload.name;
    for (LibraryFunction& function : functions_named(last)) found.functions.push_back(std::move(function));
  }
  for (const stdlib::BundleSpec& bundle : stdlib::bundles()) {
    if (core::glob_match(pattern, bundle.name)) found.bundles.push_back(&bundle);
  }
  for (const stdlib::BlockSpec& block : stdlib::blocks()) {
    if (core::glob_match(pattern, block.name)) found.blocks.push_back(&block);
  }
  for (const stdlib::SpecialSpec& special : stdlib::specials()) {
    if (core::glob_match(pattern, special.name)) found.specials.push_back(&special);
  }
  return found;
}

// ---- text -----------------------------------------------------------------------------------------------------

/// Names, then the summary beside or below them.
void print_line(const std::string& names, std::string_view summary) {
  if (names.size() > kNameWidth) {
    std::cout << fmt::format("  {}\n  {:{}}  {}\n", names, "", kNameWidth, summary);
  } else {
    std::cout << fmt::format("  {:<{}}  {}\n", names, kNameWidth, summary);
  }
}

void print_overview() {
  std::string_view group;
  for (const LibraryTopic& topic : library_topics()) {
    if (topic.group != group) {
      std::cout << (group.empty() ? "" : "\n") << topic.group << '\n';
      group = topic.group;
    }
    print_line(joined(topic.names()), topic.summary());
  }
  std::cout << "\nplc lib NAME tells more: plc lib LIMIT, plc lib TON, plc lib DINT_TO_REAL, plc lib '*_TO_STRING'\n";
}

void print_matches(const Selection& found) {
  for (const LibraryFunction& function : found.functions) std::cout << fmt::format("  {}\n", function.signature());
  for (const stdlib::BundleSpec* bundle : found.bundles) std::cout << fmt::format("  {}\n", signature(*bundle));
  for (const stdlib::SpecialSpec* special : found.specials) std::cout << fmt::format("  {}\n", special->signature);
  for (const stdlib::BlockSpec* block : found.blocks) print_line(std::string(block->name), block->summary);
}

void print_function(const LibraryFunction& function) {
  std::cout << fmt::format("{}\n  {}\n\n", function.signature(), function.spec->summary);
  for (const std::string& line : function.type_lines()) std::cout << fmt::format("  {}\n", line);
  std::cout << fmt::format("  events{}: {}\n  source: {}\n",
                           is_family(*function.spec) ? " of " + std::string(function.spec->name) : "",
                           events_text(function.events()), function.spec->clause);
  std::vector<std::vector<std::string>> lines;
  for (const stdlib::Example& example : function.examples()) {
    const std::string types = function.name == function.spec->name ? example_types(*function.spec, example) : "";
    lines.push_back({std::string(example.call), "= " + example_result(example), types});
  }
  if (!lines.empty()) std::cout << "\n";
  std::cout << columns_text(lines, 2);
}

void print_bundle(const stdlib::BundleSpec& bundle) {
  std::cout << fmt::format("{}\n  {}\n\n", signature(bundle), bundle.summary);
  std::vector<std::vector<std::string>> lines;
  for (const stdlib::FunctionSpec* output : bundle.outputs) {
    lines.push_back({std::string(stdlib::output_name(*output)), std::string(output->summary)});
  }
  std::cout << columns_text(lines, 2);
  std::cout << fmt::format("\n  source: {}\n\n  {}\n", bundle.clause, bundle.example);
}

void print_block(const stdlib::BlockSpec& block) {
  std::cout << fmt::format("{}\n  {}\n\n", block.name, block.summary);
  std::vector<std::vector<std::string>> lines;
  for (const stdlib::Field& field : block.fields) {
    lines.push_back({std::string(direction_word(field.direction)), std::string(field.name),
                     std::string(core::name_of(field.type)), std::string(field.summary),
                     field.alias.empty() ? "" : fmt::format("(also {})", field.alias)});
  }
  std::cout << columns_text(lines, 2);
  std::cout << fmt::format("\n  source: {}\n", block.clause);
  for (const stdlib::BlockExample& example : block.examples) {
    std::cout << fmt::format("\n  {}\n", example.title);
    std::cout << columns_text(example_cells(example), 4);
  }
}

void print_details(const Selection& found, std::string_view name) {
  bool first = true;
  const auto part = [&first] {
    if (!first) std::cout << '\n';
    first = false;
  };
  for (const LibraryFunction& function : found.functions) {
    part();
    print_function(function);
  }
  for (const stdlib::BundleSpec* bundle : found.bundles) {
    part();
    print_bundle(*bundle);
  }
  for (const stdlib::SpecialSpec* special : found.specials) {
    part();
    std::cout << fmt::format("{}\n  {}\n\n  source: {}\n\n  {}\n", special->signature, special->summary,
                             special->clause, special->example);
  }
  for (const stdlib::BlockSpec* block : found.blocks) {
    part();
    print_block(*block);
  }
  std::vector<std::string_view> related;
  if (found.functions.empty() || !is_family(*found.functions.front().spec)) {
    related = related_names(name);
  } else if (found.functions.front().name != found.functions.front().spec->name) {
    related = {found.functions.front().spec->name};
  }
  if (!related.empty()) std::cout << fmt::format("\nSee also: {}\n", joined(related));
}

// ---- JSON -----------------------------------------------------------------------------------------------------

ordered_json to_json(const LibraryFunction& function) {
  const stdlib::FunctionSpec& spec = *function.spec;
  ordered_json row{{"name", function.name}, {"signature", function.signature()}, {"types", function.type_lines()}};
  row["extensible"] = spec.extensible;
  row["summary"] = spec.summary;
  row["events"] = ordered_json::array();
  for (const std::string_view event : event_names(function.events())) row["events"].push_back(event);
  row["clause"] = spec.clause;
  row["examples"] = ordered_json::array();
  for (const stdlib::Example& example : function.examples()) {
    row["examples"].push_back({{"types", example.types}, {"call", example.call}, {"result", example.result}});
  }
  return row;
}

ordered_json to_json(const stdlib::BundleSpec& bundle) {
  ordered_json row{{"name", bundle.name}, {"signature", signature(bundle)}, {"types", ordered_json::array()}};
  row["extensible"] = false;
  row["summary"] = bundle.summary;
  row["events"] = ordered_json::array();
  row["clause"] = bundle.clause;
  row["examples"] = ordered_json::array({{{"types", ""}, {"call", bundle.example}, {"result", ""}}});
  return row;
}

ordered_json to_json(const stdlib::SpecialSpec& special) {
  ordered_json row{{"name", special.name}, {"signature", special.signature}, {"types", ordered_json::array()}};
  row["extensible"] = false;
  row["summary"] = special.summary;
  row["events"] = ordered_json::array();
  row["clause"] = special.clause;
  row["examples"] = ordered_json::array({{{"types", ""}, {"call", special.example}, {"result", ""}}});
  return row;
}

ordered_json to_json(const stdlib::BlockSpec& block) {
  ordered_json row{{"name", block.name}, {"summary", block.summary}, {"clause", block.clause}};
  row["fields"] = ordered_json::array();
  for (const stdlib::Field& field : block.fields) {
    row["fields"].push_back({{"name", field.name},
                             {"direction", direction_word(field.direction)},
                             {"type", core::name_of(field.type)},
                             {"alias", field.alias},
                             {"summary", field.summary}});
  }
  row["examples"] = ordered_json::array();
  for (const stdlib::BlockExample& example : block.examples) {
    row["examples"].push_back({{"title", example.title}, {"table", example_cells(example)}});
  }
  return row;
}

std::string json_text(const Selection& found) {
  ordered_json document{{"functions", ordered_json::array()}, {"blocks", ordered_json::array()}};
  for (const LibraryFunction& function : found.functions) document["functions"].push_back(to_json(function));
  for (const stdlib::BundleSpec* bundle : found.bundles) document["functions"].push_back(to_json(*bundle));
  for (const stdlib::SpecialSpec* special : found.specials) document["functions"].push_back(to_json(*special));
  for (const stdlib::BlockSpec* block : found.blocks) document["blocks"].push_back(to_json(*block));
  return document.dump(2) + '\n';
}

// ---- documents ------------------------------------------------------------------------------------------------

/// Writes a document to the file asked for, or to standard output.
int write(const Lib& lib, const std::string& text) {
  std::string why;
  if (lib.output.empty()) {
    std::cout << text;
  } else if (!write_file(lib.output, text, why)) {
    complain("plc lib", fmt::format("{} cannot be written: {}", lib.output, why));
    return kExitUsage;
  } else {
    std::cout << fmt::format("{}: {} bytes\n", lib.output, text.size());
  }
  return kExitOk;
}

int write_xml(const Lib& lib, const Selection& found) {
  if (lib.name.empty()) return write(lib, library_xml());
  std::vector<const stdlib::FunctionSpec*> functions;
  for (const LibraryFunction& function : found.functions) {
    if (!is_family(*function.spec)) functions.push_back(function.spec);
  }
  const bool drawn = std::any_of(found.specials.begin(), found.specials.end(),
                                 [](const stdlib::SpecialSpec* special) { return special->drawn_only; });
  if (functions.empty() && found.bundles.empty() && found.blocks.empty() && !drawn) {
    if (!found.specials.empty()) {
      complain("plc lib", lib.name + " is of variables, and has no POU", "write it in ST");
      return kExitErrors;
    }
    complain("plc lib",
             fmt::format("{} is of the family {}, which has no POU", lib.name, found.functions.front().spec->name),
             "editors that know the standard's third edition draw it");
    return kExitErrors;
  }
  return write(lib, library_xml(functions, found.bundles, found.specials, found.blocks));
}

int unknown(const std::string& name) {
  if (is_pattern(name)) {
    complain("plc lib", fmt::format("no function or function block matches \"{}\"", name), "plc lib lists all of them");
    return kExitErrors;
  }
  core::Guess guess(name);
  for (const stdlib::BlockSpec& block : stdlib::blocks()) guess.offer(block.name);
  for (const stdlib::BundleSpec& bundle : stdlib::bundles()) guess.offer(bundle.name);
  for (const stdlib::SpecialSpec& special : stdlib::specials()) guess.offer(special.name);
  for (const stdlib::Overload& overload : stdlib::overloads()) {
    if (!stdlib::is_bundle_output(*overload.spec)) guess.offer(overload.name);
  }
  const std::string help = guess.help();
  complain("plc lib", fmt::format("there is no function or function block \"{}\"", name),
           help.empty() ? "plc lib lists all of them" : help);
  return kExitErrors;
}

int run(const Lib& lib) {
  Selection found = lib.name.empty() ? everything() : named(lib.name);
  const bool by_pattern = found.empty() && is_pattern(lib.name);
  if (by_pattern) found = matching(lib.name);
  if (found.empty()) return unknown(lib.name);
  if (!lib.output.empty() && !lib.json && !lib.xml) {
    complain("plc lib", "-o writes documents", "add --json or --xml");
    return kExitUsage;
  }
  if (lib.xml) return write_xml(lib, found);
  if (lib.json) return write(lib, json_text(found));
  if (lib.name.empty()) {
    print_overview();
  } else if (by_pattern) {
    print_matches(found);
  } else {
    print_details(found, lib.name);
  }
  return kExitOk;
}

}  // namespace

void add_lib(Command program) {
  static Lib lib;
  const Command command = program.sub(
      "lib",
      "Prints the functions and function blocks of the library, or what one of them means: inputs, types, events,\n"
      "examples.\n"
      "\n"
      "Examples:\n"
      "  plc lib                            everything, in groups\n"
      "  plc lib LIMIT                      one function\n"
      "  plc lib TON                        one function block, with what it does scan by scan\n"
      "  plc lib DINT_TO_REAL               one conversion of the family *_TO_*\n"
      "  plc lib '*_TO_STRING'              all names that match\n"
      "  plc lib --xml -o picard.xml        blocks beyond the standard, as a library for editors\n"
      "  plc lib --xml 'CTU_*' -o ctu.xml   the same of other blocks");
  command.option("NAME", lib.name, "function or block in any letter case, or a pattern with * and ?");
  const Flag json = command.flag("--json", lib.json, "one JSON document on standard output");
  command.flag("--xml", lib.xml, "a PLCopen XML library: interfaces to draw with, the runtime has the bodies")
      .excludes({json});
  command.option("-o,--output=FILE", lib.output, "--json, --xml: file to write instead of standard output");
  command.on_run([] { return run(lib); });
}

}  // namespace plc::tools
