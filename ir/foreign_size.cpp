#include "ir/foreign_size.h"

#include <algorithm>

#include "core/packed.h"

namespace plc::ir {
namespace {

struct Extent {
  std::uint64_t size = 0;
  std::uint64_t align = 1;
};

std::uint64_t aligned(std::uint64_t offset, std::uint64_t align) { return (offset + align - 1) / align * align; }

std::optional<Extent> extent_of(const TypeTable& types, TypeRef ref) {
  const Type& type = types[ref];
  switch (type.kind) {
    case TypeKind::kElementary:
    case TypeKind::kEnum:
    case TypeKind::kSubrange: {
      const std::uint64_t bytes = core::packed_bytes(type.elementary);
      return Extent{bytes, bytes};
    }
    case TypeKind::kReference:
    case TypeKind::kPointer:
      return Extent{8, 8};
    case TypeKind::kString: {
      // With the zero that ends it.
      const std::uint64_t width = type.elementary == TypeId::kWstring ? 2 : 1;
      return Extent{(std::uint64_t{type.capacity} + 1) * width, width};
    }
    case TypeKind::kArray: {
      const auto element = type.open ? std::nullopt : extent_of(types, type.element);
      if (!element) return std::nullopt;
      const std::uint64_t count = static_cast<std::uint64_t>(type.upper) - static_cast<std::uint64_t>(type.lower) + 1;
      Extent out = *element;
      if (__builtin_mul_overflow(element->size, count, &out.size)) return std::nullopt;
      return out;
    }
    case TypeKind::kUnion: {
      Extent out;
      for (const TypeField& field : type.fields) {
        const auto member = extent_of(types, field.type);
        if (!member) return std::nullopt;
        out.size = std::max(out.size, member->size);
        out.align = std::max(out.align, member->align);
      }
      out.size = aligned(out.size, out.align);
      return out;
    }
    case TypeKind::kStruct: {
      if (type.stub) return std::nullopt;
      Extent out;
      for (const TypeField& field : type.fields) {
        const auto member = extent_of(types, field.type);
        if (!member) return std::nullopt;
        out.size = aligned(out.size, member->align) + member->size;
        out.align = std::max(out.align, member->align);
      }
      out.size = aligned(out.size, out.align);
      return out;
    }
    case TypeKind::kBlock:
    case TypeKind::kPou:
      return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::uint64_t> foreign_size(const TypeTable& types, TypeRef type) {
  const auto extent = extent_of(types, type);
  return extent ? std::optional(extent->size) : std::nullopt;
}

std::optional<std::uint64_t> foreign_align(const TypeTable& types, TypeRef type) {
  const auto extent = extent_of(types, type);
  return extent ? std::optional(extent->align) : std::nullopt;
}

std::optional<std::uint64_t> foreign_offset(const TypeTable& types, TypeRef whole, std::uint32_t part) {
  const Type& type = types[whole];
  if (type.kind == TypeKind::kUnion) return 0;
  if (type.kind == TypeKind::kArray) {
    const auto element = extent_of(types, type.element);
    return element ? std::optional(element->size * part) : std::nullopt;
  }
  if (type.kind != TypeKind::kStruct) return std::nullopt;
  std::uint64_t offset = 0;
  for (std::uint32_t i = 0; i < type.fields.size(); ++i) {
    const auto member = extent_of(types, type.fields[i].type);
    if (!member) return std::nullopt;
    offset = aligned(offset, member->align);
    if (i == part) return offset;
    offset += member->size;
  }
  return std::nullopt;
}

}  // namespace plc::ir
