#include "runtime/link/link_path.h"

#include <bit>
#include <cstring>

#include "bytecode/type_map.h"
#include "runtime/interpreter/operations.h"

namespace plc::runtime {

using bytecode::ImageType;
using bytecode::PathStep;
using bytecode::TypeKind;

ResolvedPath resolve_path(const bytecode::Image& image, std::span<const std::uint32_t, 4> spaces, std::uint32_t root,
                          std::span<const std::uint32_t> path, const PackedTypes* packed) {
  const auto size_of = [&](std::uint32_t type) {
    return packed != nullptr ? (*packed)[type].size : image.types[type].size;
  };
  ResolvedPath resolved;
  resolved.type = root;
  for (; !path.empty(); path = path.subspan(bytecode::kPathWords)) {
    const auto next = bytecode::follow_path(image, resolved.type, path[0], path[1]);
    if (path[0] == static_cast<std::uint32_t>(PathStep::kIndex)) {
      const ImageType& array = image.types[resolved.type];
      const std::uint32_t space = spaces[static_cast<std::size_t>(bytecode::space_of(path[1]))];
      const auto leaf = bytecode::leaf_at(image, space, bytecode::offset_of(path[1]));
      resolved.indices.push_back(
          {path[1], bytecode::rep_of(image.types[*leaf]), array.lower, array.count, size_of(array.element)});
    } else if (packed == nullptr) {
      resolved.offset += next->offset;
    } else if (path[0] == static_cast<std::uint32_t>(PathStep::kElement)) {
      resolved.offset += path[1] * size_of(next->type);
    } else if (!(*packed)[resolved.type].at.empty()) {
      resolved.offset += (*packed)[resolved.type].at[path[1]];
    } else {
      // Members of instances: nothing is there for a pointer to read.
      resolved.offset += next->offset;
    }
    resolved.type = next->type;
  }
  return resolved;
}

void fill_zeros(const bytecode::Image& image, std::uint32_t type, std::byte* to) {
  const ImageType& t = image.types[type];
  switch (t.kind) {
    case TypeKind::kScalar:
    case TypeKind::kRef:
      std::memset(to, 0, t.size);
      return;
    case TypeKind::kString:
      std::memset(to, 0, t.size);
      store(to, core::StringHeader{t.capacity, 0});
      return;
    case TypeKind::kArray:
      for (std::uint32_t i = 0; i < t.count; ++i)
        fill_zeros(image, t.element, to + std::size_t{i} * image.types[t.element].size);
      return;
    case TypeKind::kStruct:
      std::memset(to, 0, t.size);
      for (const bytecode::ImageField& field : t.fields) fill_zeros(image, field.type, to + field.offset);
      return;
  }
}

namespace {

/// Forms of a family are in a row by size: 1, 2, 4, 8 bytes. Nothing for what has no such size.
std::optional<unsigned> number_of_size(const ImageType& part) {
  if (part.kind != TypeKind::kScalar && part.kind != TypeKind::kRef) return std::nullopt;
  return static_cast<unsigned>(std::countr_zero(part.size));
}
ResolvedOp form_after(ResolvedOp first, unsigned number) {
  return static_cast<ResolvedOp>(static_cast<unsigned>(first) + number);
}

}  // namespace

std::optional<ResolvedOp> quick_access(const bytecode::Image& image, const ResolvedPath& path, bool load, bool via) {
  const auto size = number_of_size(image.types[path.type]);
  if (!size || path.indices.size() > 1) return std::nullopt;
  if (path.indices.empty()) {
    if (!via) return std::nullopt;
    const ResolvedOp first = load ? ResolvedOp::kLoadVia8 : ResolvedOp::kStoreVia8;
    return form_after(first, *size);
  }
  const ResolvedOp first = load ? (via ? ResolvedOp::kLoadVia8I16 : ResolvedOp::kLoadAt8I16)
                                : (via ? ResolvedOp::kStoreVia8I16 : ResolvedOp::kStoreAt8I16);
  const core::Rep rep = path.indices.front().rep;
  const unsigned index = rep == core::Rep::kI16 ? 0 : rep == core::Rep::kI32 ? 1 : 2;
  return form_after(first, 3 * *size + index);
}

std::optional<ResolvedOp> path_access(const bytecode::Image& image, const ResolvedPath& path, bool load) {
  const auto size = number_of_size(image.types[path.type]);
  if (!size || path.indices.size() < 2) return std::nullopt;
  return form_after(load ? ResolvedOp::kLoadPath8 : ResolvedOp::kStorePath8, *size);
}

}  // namespace plc::runtime
