// docs/reference/taskblocks.md and docs/reference/taskblocks/: the taskblocks that come with PICARD, by groups.
#include <fmt/format.h>

#include <algorithm>

#include "tools/plcdoc/pages.h"
#include "tools/taskblock_text.h"

namespace plc::tools {
namespace {

std::string block_part(const picard_block& block) {
  std::string text = fmt::format("\n## {}\n\n{}\n\n```\n{}```\n\n", block.name, block.summary, box_text(block));
  std::vector<std::vector<std::string>> cells = port_cells(block);
  const std::vector<std::string> heading = cells.front();
  cells.erase(cells.begin());
  const auto code_cell = [&heading](std::vector<std::string>& line, std::string_view column) {
    const auto at = std::find(heading.begin(), heading.end(), column);
    if (at == heading.end()) return;
    std::string& content = line[static_cast<std::size_t>(at - heading.begin())];
    if (!content.empty()) content = as_code(content);
  };
  for (auto& line : cells) {
    for (const char* const column : {"port", "default"}) code_cell(line, column);
  }
  text += table(heading, cells);
  if (block.details[0] != '\0') text += fmt::format("\n{}\n", block.details);
  std::string types;
  for (const picard_type* type : taskblocks::data_types_of(block)) types += taskblocks::declaration(*type);
  if (!types.empty()) text += fmt::format("\n```\n{}```\n", types);
  text += fmt::format("\n```\n{}```\n", call_text(block));
  if (const TaskblockExample* example = taskblock_example(block)) {
    text += fmt::format("\n[Drawn example](../../../taskblocks/{})\n", example->path);
  }
  return text;
}

}  // namespace

std::vector<Page> taskblock_pages() {
  const std::string from = generated_from("taskblocks/");
  std::vector<Page> pages = {{"taskblocks.md", {}}};
  std::string index =
      from +
      "# Taskblocks\n\n"
      "Components in C++ that drawings and texts use like any function block: the set that comes with PICARD. `plc\n"
      "blocks` prints the same, also for libraries of your own: `plc blocks LOWPASS`. How to use and to write them:\n"
      "[guide](../guides/taskblocks.md). `====` in a drawing leads to a configuration port, which takes constants.\n";
  for (const TaskblockGroup& group : taskblock_groups(taskblocks::Registry::built_in())) {
    const std::string name = fmt::format("taskblocks/{}.md", taskblock_folder(group.title));
    std::string page =
        from + fmt::format("# {}\n\n[Taskblocks](../taskblocks.md) that come with PICARD.\n", group.title);
    std::vector<std::vector<std::string>> rows;
    for (const taskblocks::Registry::Entry* entry : group.entries) {
      rows.push_back({as_code(entry->block->name), entry->block->summary});
      page += block_part(*entry->block);
    }
    index += fmt::format("\n## [{}]({})\n\n", group.title, name) + table({"name", ""}, rows);
    pages.push_back({name, std::move(page)});
  }
  pages.front().text = std::move(index);
  return pages;
}

}  // namespace plc::tools
