// Taskblocks as a small HTML reference to read without a network: an index, a page a block with the block drawn.
//
// In: a registry. Out: files as text; each holds all it needs, and no script. Does not belong here: writing them.
#pragma once

#include <string>
#include <vector>

#include "taskblocks/registry.h"

namespace plc::tools {

struct HtmlFile {
  std::string name;  ///< "index.html", "lowpass.html"; examples beside them as "lowpass.xml"
  std::string text;
};

/// The index first, then the blocks in its order, each followed by its example.
std::vector<HtmlFile> taskblock_html(const taskblocks::Registry& registry);

/// The block drawn, an <svg> that the page's style colours: pins with their names, types outside, a double wire to
/// ports that take constants.
std::string taskblock_svg(const picard_block& block);

}  // namespace plc::tools
