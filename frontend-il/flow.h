// Flow: the basic blocks of an instruction list, where control goes from each, and before which of them the value of
// the accumulator is needed.
//
// In: a Listing and the text its names are in. Out: blocks; P4505 for labels that are unknown or there twice. Does not
// belong here: types, IR.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/diagnostics.h"
#include "frontend-il/listing.h"
#include "frontend-st/source_text.h"

namespace plc::il {

using BlockId = std::uint32_t;

struct Block {
  std::uint32_t first = 0;  ///< instructions [first, last)
  std::uint32_t last = 0;
  std::optional<BlockId> jump;  ///< where its last instruction goes, perhaps under a condition
  std::optional<BlockId> next;  ///< where it goes else
  std::vector<BlockId> before;  ///< blocks that control comes from, one entry for each way
  bool jump_target = false;
  bool reads = false;        ///< the accumulator as it was before the block
  bool writes = false;       ///< the accumulator
  bool needs_value = false;  ///< the block, or one after it, reads the accumulator as it was before it
};

/// Whether an instruction reads what was in the accumulator, and whether it puts something there.
bool reads_accumulator(const Instruction& instruction);
bool writes_accumulator(const Instruction& instruction);

struct Flow {
  /// The last one is the end of the list: it has no instructions.
  std::vector<Block> blocks;
  bool failed = false;
  [[nodiscard]] BlockId end() const { return static_cast<BlockId>(blocks.size() - 1); }
};

/// `gives_value`: the value in the accumulator at the end counts, and RET goes there with it.
Flow flow_of(const Listing& listing, const st::SourceText& source, bool gives_value, core::Diagnostics& diagnostics,
             std::string_view pou);

}  // namespace plc::il
