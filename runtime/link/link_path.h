// Paths of LOAD_AT and the like, resolved: a distance in bytes and the indices that only the running program knows.
//
// In: types and path of a verified image. Out: ResolvedPath; which of the quick forms of internal_ops.def does.
// Internal to the linker. Does not belong here: operands as addresses (link.cpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "bytecode/image.h"
#include "runtime/interpreter/interpreter.h"
#include "runtime/pointers/packed_types.h"

namespace plc::runtime {

/// One index of a path.
struct PathIndex {
  std::uint32_t operand = 0;  ///< leaf that holds it
  core::Rep rep = core::Rep::kI64;
  std::int64_t lower = 0;
  std::uint32_t count = 0;
  std::uint32_t stride = 0;  ///< bytes from element to element
};
struct ResolvedPath {
  std::uint32_t type = 0;    ///< where it ends
  std::uint32_t offset = 0;  ///< of its fields and constant elements
  std::vector<PathIndex> indices;
};

/// `spaces`: structure of each bytecode::Space, to find the representation of indices. With `packed`, distances are
/// those in the layout that pointers see.
ResolvedPath resolve_path(const bytecode::Image& image, std::span<const std::uint32_t, 4> spaces, std::uint32_t root,
                          std::span<const std::uint32_t> path, const PackedTypes* packed = nullptr);

/// The value of `type` that an access leading nowhere reads: zeros, with the capacities of strings in place.
void fill_zeros(const bytecode::Image& image, std::uint32_t type, std::byte* to);

/// The form for scalars and references with at most one index, or nothing.
std::optional<ResolvedOp> quick_access(const bytecode::Image& image, const ResolvedPath& path, bool load, bool via);
/// The form for scalars and references with several indices, but not via references.
std::optional<ResolvedOp> path_access(const bytecode::Image& image, const ResolvedPath& path, bool load);

}  // namespace plc::runtime
