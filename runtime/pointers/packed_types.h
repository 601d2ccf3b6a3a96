// PackedTypes: the layout that pointers see of each type of an image: natural alignment and the widths of CODESYS, as
// SIZEOF states them. A STRING is its characters and a zero, TIME and DATE are 32 bits; function blocks, and
// references, take room that no pointer reads or writes.
//
// In: a verified image. Out: sizes and offsets by type, which leaf lies at an offset. Built when a program is loaded;
// find() is RT. Does not belong here: bytes (packed_access.h), objects (objects.h).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bytecode/image.h"

namespace plc::runtime {

/// One type as pointers see it.
struct PackedType {
  std::uint32_t size = 0;  ///< bytes
  std::uint32_t align = 1;
  std::uint32_t first = 0;        ///< number of the equal type of lowest index: equal types have equal numbers
  bool plain = true;              ///< nothing in it is closed to pointers
  bool instance = false;          ///< of a function block or program
  bool holds_instance = false;    ///< it is one, or has one in it
  std::vector<std::uint32_t> at;  ///< of structures: offset of each field
};

/// What lies at a byte of a value.
struct PackedPart {
  enum class Kind : std::uint8_t {
    kLeaf,    ///< a scalar or string
    kGap,     ///< between fields
    kClosed,  ///< a reference, or a function block instance
  } kind = Kind::kGap;
  std::uint32_t type = 0;     ///< kLeaf, kClosed: image type
  std::uint32_t storage = 0;  ///< where it starts in the table, from the start of the value
  std::uint32_t inside = 0;   ///< bytes from its start
  std::uint32_t left = 0;     ///< bytes from here to its end
};

class PackedTypes {
 public:
  explicit PackedTypes(const bytecode::Image& image);

  [[nodiscard]] const PackedType& operator[](std::uint32_t type) const { return types_[type]; }
  [[nodiscard]] const bytecode::ImageType& image_type(std::uint32_t type) const { return image_->types[type]; }
  /// True when both are one type (bytecode::same_type).
  [[nodiscard]] bool same(std::uint32_t a, std::uint32_t b) const { return types_[a].first == types_[b].first; }

  /// The part at byte `offset`, below its size, of a value of `type`. RT: as many steps as types nest, at most 64.
  [[nodiscard]] PackedPart find(std::uint32_t type, std::uint32_t offset) const noexcept;
  /// Where a value of exactly type `wanted` that starts at byte `offset` of a value of `type` lies in the table, from
  /// the start of that value; nothing when there is none. RT: as find().
  [[nodiscard]] std::optional<std::uint32_t> storage_of(std::uint32_t type, std::uint32_t offset,
                                                        std::uint32_t wanted) const noexcept;
  /// The other way: the offset that pointers see of a value of type `wanted` that starts at byte `storage` of the table
  /// within a value of `type`. Nothing inside of instances. RT: as find().
  [[nodiscard]] std::optional<std::uint32_t> offset_of(std::uint32_t type, std::uint32_t storage,
                                                       std::uint32_t wanted) const noexcept;

 private:
  void lay_out(std::uint32_t type);
  /// Numbers of equal types.
  void find_equal_types();

  const bytecode::Image* image_;
  std::vector<PackedType> types_;
};

}  // namespace plc::runtime
