// The reference pages, one function each: Markdown from tables. main.cpp writes or compares them.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "tools/feature_tables.h"

namespace plc::tools {

/// A file below docs/reference.
struct Page {
  std::string name;  ///< "opcodes.md", "library/timers.md"
  std::string text;
};

/// First line of a page: what it was made from, and how to make it again.
std::string generated_from(const std::string& source);
/// Text of a cell of a Markdown table.
std::string cell(std::string text);

/// A Markdown table; every line has as many cells as the heading.
std::string table(const std::vector<std::string>& heading, const std::vector<std::vector<std::string>>& rows);
/// `text`, in the quotes of Markdown.
std::string as_code(std::string_view text);

/// library.md, the index, and library/<group>.md for every group.
std::vector<Page> library_pages();
/// taskblocks.md, the index, and taskblocks/<group>.md for every group of the set that comes with PICARD.
std::vector<Page> taskblock_pages();
/// engineering.md: calls of the engineering server.
Page engineering_page();
/// conformance.md: features of the standard with their evidence, and what it leaves to the implementer. `cases`:
/// the folder of the cases, as the features were read from it.
Page conformance_page(const FeatureTables& features, const std::filesystem::path& cases);
/// File of the page about the group with this title: "library/bit-strings.md".
std::string page_of_group(std::string_view title);

}  // namespace plc::tools
