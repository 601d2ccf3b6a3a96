// Taskblocks in words, and drawn with letters: what plc blocks and the reference pages say of them.
//
// In: a registry. Out: groups, cells and texts. Does not belong here: documents (taskblock_xml.h, taskblock_html.h),
// files.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "taskblocks/registry.h"

namespace plc::tools {

struct TaskblockGroup {
  std::string_view title;  ///< "Filters"
  std::vector<const taskblocks::Registry::Entry*> entries;
};

/// In the order in which their first blocks are registered; blocks as they are registered.
std::vector<TaskblockGroup> taskblock_groups(const taskblocks::Registry& registry);

/// Whether a literal is a value of the type: no array, no structure.
bool is_simple(const picard_type& type);
/// "input", "output", "configuration", "queue reader", "queue writer".
std::string_view port_word(const picard_port& port);
/// "0 .. 1", ">= 1e-9", "<= 5", or nothing: the range of a number, without its unit.
std::string range_text(const picard_port& port);
/// What the port has when nothing is connected, as a literal: "1.0", "FALSE", "T#0s"; nothing for arrays and structures
/// of zeros.
std::string default_text(const picard_port& port);

/// Heading, then a line a port: its name, what it is, type, unit, range, default, meaning. Columns that no port has
/// anything in are left out.
std::vector<std::vector<std::string>> port_cells(const picard_block& block);

/// The block as the standard draws it with letters (IEC 61131-3, 8.1): inputs on the left, outputs on the right, with
/// their types. "====" leads to ports that take constants, ">>>>" to and from those of queues.
std::string box_text(const picard_block& block);

/// How a program in ST declares and calls it, to be copied: compiles as it stands between PROGRAM and END_PROGRAM.
std::string call_text(const picard_block& block);

/// A paragraph of details, or an item of a list.
struct DetailsPart {
  bool item = false;
  std::string text;  ///< one line; `code` and **words** as written
};
/// Details are Markdown of paragraphs, items that begin with "- ", `code` and **words**.
std::vector<DetailsPart> details_parts(std::string_view markdown);
/// The same broken into lines of at most `width` letters, `indent` blanks among them.
std::string wrapped(std::string_view markdown, std::size_t indent, std::size_t width);

/// Folder of a group below taskblocks/, and the name of its page: "filters".
std::string taskblock_folder(std::string_view group);

/// A project that shows a block of the set that comes with PICARD: taskblocks/<group>/<file>.xml.
struct TaskblockExample {
  std::string_view path;  ///< "filters/low_pass.xml"
  std::string_view text;  ///< the PLCopen XML
};
/// The example of a block: the file in its group's folder that has its name, underscores and letter case apart. Null
/// for blocks of other libraries.
const TaskblockExample* taskblock_example(const picard_block& block);

}  // namespace plc::tools
