// Packs stretches of boolean logic (packed_run.h). Compile time.
//
// In: instructions in an order in which they may run, most of them boolean records. Out: packed runs, and what runs
// between them, if the variables of the records fit into two words of bits and that is faster than loops over them.
// Variables stay bits from the first run of a stretch to the last. Does not belong here: how the other instructions
// run (arrange.h).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "runtime/packed_logic.h"
#include "runtime/packed_run.h"

namespace plc::runtime {

/// A packed run, or other instructions.
struct PackedStep {
  std::vector<std::uint32_t> items;  ///< numbers of other instructions, in order; empty: a packed run
  std::uint32_t chunks = 0;
  std::vector<std::uint32_t> words;
};
struct PackedStretch {
  PackedForm form;
  bool pays = false;  ///< faster than loops over the records
  std::vector<PackedStep> steps;
};

/// `places`: operands of the cells. `scratch`: operand of kPackedStateBytes that belong to nobody else while the
/// stretch runs. Nothing when it does not fit, or when this processor has no fast way to run it.
std::optional<PackedStretch> pack(std::span<const StretchItem> items, std::span<const std::uint32_t> places,
                                  std::uint32_t scratch);

}  // namespace plc::runtime
