// Questions to the typed map of a table, beyond leaf_at() and place_at() of image.h.
//
// In: an Image, verified or not: nothing here trusts indices or sizes. Out: equality of types, what lies at an offset,
// a dense map of one table for checks that come by the hundred thousand. Does not belong here: rules (verify_*.cpp).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "bytecode/image.h"

namespace plc::bytecode {

/// Types nest at most this deep (rule V106), so walks over them need no heap.
inline constexpr std::uint32_t kMaxTypeDepth = 64;

/// Equality of types across indices (docs/reference/verifier.md):
/// structures are equal when they are one index; scalars when elementary type and limits agree; strings when elementary
/// type and capacity agree; arrays when bounds and element types are equal; references when their targets are, where a
/// target that is itself a reference, or an array of references, is equal to its own index only.
bool same_type(const Image& image, std::uint32_t a, std::uint32_t b);

/// Places that a walk through a value of `type` comes to: leaves, and structures without fields. `known` has those of
/// the types before it. Stops counting far above what a table may hold.
std::uint64_t parts_of(const ImageType& type, std::span<const std::uint64_t> known);

/// What place_at() found on its way.
struct Found {
  std::uint32_t type = 0;
  bool constant = false;  ///< a field on the way is marked constant
};
/// The leaf at byte `offset` of `type`.
std::optional<Found> find_leaf(const Image& image, std::uint32_t type, std::uint32_t offset);
/// The value of exactly type `wanted` at byte `offset` of `type`. A value without bytes is found at any offset.
std::optional<Found> find_place(const Image& image, std::uint32_t type, std::uint32_t offset, std::uint32_t wanted);

/// Where one item of a path leads from `type`; nothing when the type has no such part. What is in the leaf of an index
/// is not looked at.
struct PathTarget {
  std::uint32_t type = 0;
  std::uint32_t offset = 0;  ///< of the part, 0 for an index
  bool constant = false;     ///< a field marked constant
};
std::optional<PathTarget> follow_path(const Image& image, std::uint32_t type, std::uint32_t step, std::uint32_t number);
/// True when a leaf of type `given` can be read or written as one of type `wanted`: the same width and kind (strings of
/// any capacity), or a reference to the same type.
bool leaf_fits(const Image& image, const ImageType& given, const ImageType& wanted);

/// One byte per byte of a table: 0, or 1 + Rep where a leaf starts, plus kConstantLeaf. Built from verified types only.
class LeafMap {
 public:
  static constexpr std::uint8_t kConstantLeaf = 0x80;

  LeafMap(const Image& image, std::uint32_t type);
  /// The byte at `offset`, 0 past the end.
  [[nodiscard]] std::uint8_t at(std::uint32_t offset) const { return offset < map_.size() ? map_[offset] : 0; }

 private:
  class Filler;
  std::vector<std::uint8_t> map_;
};

}  // namespace plc::bytecode
