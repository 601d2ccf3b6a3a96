// docs/reference/library.md and docs/reference/library/: the library by groups.
#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "core/text.h"
#include "tools/library_text.h"
#include "tools/plcdoc/pages.h"

namespace plc::tools {
namespace {

std::string quoted_list(const std::vector<std::string_view>& names) {
  std::string text;
  for (const std::string_view name : names) text += (text.empty() ? "" : ", ") + as_code(name);
  return text;
}

/// Signature, types and examples of one row; events and clause once, after the rows of the topic.
void write_function(std::ostream& out, const LibraryFunction& function) {
  out << "\n```\n" << function.signature() << "\n```\n";
  const std::vector<std::string> types = function.type_lines();
  if (!types.empty()) out << '\n';
  for (const std::string& line : types) out << "- " << line << '\n';
  const std::vector<stdlib::Example> examples = function.examples();
  if (examples.empty()) return;
  std::vector<std::vector<std::string>> rows;
  bool typed = false;
  for (const stdlib::Example& example : examples) {
    rows.push_back({as_code(example.call), example_result(example), example_types(*function.spec, example)});
    typed = typed || !rows.back()[2].empty();
  }
  std::vector<std::string> heading = {"example", "result", "types"};
  if (!typed) {
    heading.pop_back();
    for (auto& cells : rows) cells.pop_back();
  }
  out << '\n' << table(heading, rows);
}

void write_functions(std::ostream& out, const LibraryTopic& topic) {
  for (const stdlib::FunctionSpec* spec : topic.functions) write_function(out, library_function(*spec));
  const LibraryFunction first = library_function(*topic.functions.front());
  out << "\nEvents: " << events_text(first.events()) << ".\n\n" << first.spec->clause << '\n';
}

void write_bundles(std::ostream& out, const LibraryTopic& topic) {
  for (const stdlib::BundleSpec* bundle : topic.bundles) {
    out << "\n```\n" << signature(*bundle) << "\n```\n\n    " << bundle->example << '\n';
  }
  std::vector<std::vector<std::string>> rows;
  for (const stdlib::FunctionSpec* output : topic.bundles.front()->outputs) {
    rows.push_back({as_code(stdlib::output_name(*output)), std::string(output->summary)});
  }
  out << '\n' << table({"output", ""}, rows) << '\n' << topic.bundles.front()->clause << '\n';
}

/// "PV, CV: DINT" for the pins of `other` whose types differ from those of `block`.
std::string differences(const stdlib::BlockSpec& block, const stdlib::BlockSpec& other) {
  std::string names;
  std::string_view type;
  for (const stdlib::Field& field : other.fields) {
    const stdlib::Field* same = stdlib::field_named(block, field.name);
    if (field.direction == stdlib::Direction::kState || (same != nullptr && same->type == field.type)) continue;
    names += (names.empty() ? "" : ", ") + std::string(field.name);
    type = core::name_of(field.type);
  }
  return names.empty() ? "the same" : fmt::format("{}: {}", names, type);
}

void write_blocks(std::ostream& out, const LibraryTopic& topic) {
  const stdlib::BlockSpec& block = *topic.blocks.front();
  std::vector<std::vector<std::string>> rows;
  for (const stdlib::Field& field : block.fields) {
    std::string summary(field.summary);
    if (!field.alias.empty()) summary += fmt::format(" (also {})", field.alias);
    rows.push_back({as_code(field.name), std::string(direction_word(field.direction)),
                    std::string(core::name_of(field.type)), summary});
  }
  out << '\n' << table({"pin", "", "type", ""}, rows);
  if (topic.blocks.size() > 1) {
    rows.clear();
    for (const stdlib::BlockSpec* other : topic.blocks) {
      if (other != &block) rows.push_back({as_code(other->name), differences(block, *other)});
    }
    out << '\n' << table({"typed form", "types"}, rows);
  }
  for (const stdlib::BlockExample& example : block.examples) {
    auto lines = example_cells(example);
    if (lines.empty()) continue;
    // The bar between inputs and outputs would end a cell.
    for (auto& cells : lines) std::replace(cells.begin(), cells.end(), std::string("|"), std::string());
    out << '\n' << example.title << ":\n\n" << table(lines.front(), {lines.begin() + 1, lines.end()});
  }
  out << '\n' << block.clause << '\n';
}

std::string group_page(std::string_view title, const std::vector<const LibraryTopic*>& topics) {
  std::ostringstream out;
  out << generated_from("stdlib/") << "# " << title << "\n\nOf the [standard library](../library.md).\n";
  for (const LibraryTopic* topic : topics) {
    const auto names = topic->names();
    out << "\n## "
        << (topic->functions.empty() || !is_family(*topic->functions.front()) ? std::string(names.front())
                                                                              : as_code(names.front()))
        << "\n\n"
        << topic->summary() << '\n';
    if (names.size() > 1) out << "\nAlso " << quoted_list({names.begin() + 1, names.end()}) << ".\n";
    if (!topic->functions.empty()) {
      write_functions(out, *topic);
    } else if (!topic->bundles.empty()) {
      write_bundles(out, *topic);
    } else if (!topic->specials.empty()) {
      for (const stdlib::SpecialSpec* special : topic->specials) {
        out << "\n```\n"
            << special->signature << "\n```\n\n    " << special->example << "\n\n"
            << special->clause << '\n';
      }
    } else {
      write_blocks(out, *topic);
    }
  }
  return out.str();
}

}  // namespace

std::string page_of_group(std::string_view title) {
  std::string name = core::folded(title);
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c < 'a' || c > 'z'; }, '-');
  return "library/" + name + ".md";
}

std::vector<Page> library_pages() {
  const std::vector<LibraryTopic> topics = library_topics();
  std::vector<Page> pages = {{"library.md", {}}};
  std::string index =
      generated_from("stdlib/") +
      "# Standard library\n\n"
      "`plc lib` prints the same: `plc lib TON`, `plc lib DINT_TO_REAL`. T and U stand for any of the types\n"
      "named with them; `..` takes more inputs of the last type. [Events](../guides/events.md) say when ENO is\n"
      "FALSE, [conformance](conformance.md) what of the standard is there. Examples are tests.\n\n"
      "Blocks that are in no table of the standard can be drawn in editors that do not know them:\n"
      "[picard-library.xml](picard-library.xml) declares them, `plc lib --xml` writes the file.\n";
  for (auto begin = topics.begin(); begin != topics.end();) {
    const auto end = std::find_if(begin, topics.end(), [&](const LibraryTopic& t) { return t.group != begin->group; });
    std::vector<const LibraryTopic*> group;
    std::vector<std::vector<std::string>> rows;
    for (auto topic = begin; topic != end; ++topic) {
      group.push_back(&*topic);
      rows.push_back({quoted_list(topic->names()), std::string(topic->summary())});
    }
    const std::string page = page_of_group(begin->group);
    index += fmt::format("\n## [{}]({})\n\n", begin->group, page) + table({"name", ""}, rows);
    pages.push_back({page, group_page(begin->group, group)});
    begin = end;
  }
  pages.front().text = index;
  return pages;
}

}  // namespace plc::tools
