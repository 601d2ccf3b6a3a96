// Code of one POU: three-address instructions and look-up records from a linear IR body.
//
// In: a POU whose instance is laid out, the tables shared by all bodies. Out: an ImagePou with code, debug entries,
// frame type and initial bytes. Does not belong here: task bodies (tasks.cpp), memory layout, the choice of look-up
// tables.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "bytecode/codegen/analysis.h"
#include "bytecode/codegen/constants.h"
#include "bytecode/codegen/layout.h"
#include "bytecode/image.h"
#include "ir/ir.h"

namespace plc::bytecode {

/// What all bodies of an image share.
struct Shared {
  const ir::Module& module;
  Image& image;
  Layout& layout;
  ConstantPool& constants;
  std::vector<std::uint32_t> image_pou;      ///< by ir POU: index into Image::pous, kNoIndex when not reached
  std::vector<std::uint32_t> global_offset;  ///< by ir global: offset in the global table; of queues meaningless
  std::vector<std::uint32_t> queue_of;       ///< by ir global: index into Image::queues, kNoIndex for variables
  std::unordered_map<const stdlib::Overload*, std::uint32_t> functions;
  std::unordered_map<std::uint32_t, std::uint32_t> blocks;  ///< by TypeRef, of a standard block or taskblock
  Analysis analysis;                                        ///< scratch of the body under construction

  std::uint32_t function(const stdlib::Overload& overload);
  std::uint32_t block(ir::TypeRef block_type);
};

/// Generates POU `pou` of the module into `out`, and `probes` where front ends noted some. False when its frame is
/// larger than a table may be.
bool generate_body(Shared& shared, std::uint32_t pou, ImagePou& out, PouProbes& probes);

}  // namespace plc::bytecode
