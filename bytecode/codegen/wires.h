// Wires: inputs of taskblocks that need no copy, because what they are wired to stays as it is until the block runs.
//
// In: a body of a POU and its analysis. Out: which stores are no copies but wires (ImageWire). A store is a wire when
// the instance runs at one place, the store comes straight before it and is all that touches the input, and what it
// stores is a variable of the same instance that nothing writes in between (paper, 3.1: ports that are connected are
// one variable).
#pragma once

#include <cstdint>
#include <vector>

#include "bytecode/codegen/analysis.h"
#include "ir/ir.h"

namespace plc::bytecode {

struct Wire {
  std::uint32_t store = 0;   ///< instruction
  std::uint32_t block = 0;   ///< place of the taskblock instance
  std::uint32_t input = 0;   ///< variable of the taskblock
  std::uint32_t source = 0;  ///< place
};

std::vector<Wire> find_wires(const ir::Module& module, const ir::Pou& pou, const ir::Body& body,
                             const Analysis& analysis);

}  // namespace plc::bytecode
