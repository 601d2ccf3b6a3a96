#include "runtime/pointers/packed_types.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "bytecode/type_map.h"
#include "core/packed.h"

namespace plc::runtime {

using bytecode::FieldRole;
using bytecode::ImageField;
using bytecode::ImageType;
using bytecode::TypeKind;

PackedTypes::PackedTypes(const bytecode::Image& image) : image_(&image), types_(image.types.size()) {
  // A type is built from types of lower index (rule V101), the targets of references apart, which are not looked at.
  for (std::uint32_t type = 0; type < image.types.size(); ++type) lay_out(type);
  find_equal_types();
}

void PackedTypes::lay_out(std::uint32_t type) {
  const ImageType& t = image_->types[type];
  PackedType& out = types_[type];
  switch (t.kind) {
    case TypeKind::kScalar:
      out.size = out.align = core::packed_bytes(t.elementary);
      return;
    case TypeKind::kString:
      out.align = t.elementary == core::TypeId::kWstring ? 2 : 1;
      out.size = (std::uint32_t{t.capacity} + 1) * out.align;
      return;
    case TypeKind::kRef:
      out.size = out.align = 8;
      out.plain = false;
      return;
    case TypeKind::kArray: {
      const PackedType& element = types_[t.element];
      out.align = element.align;
      out.size = element.size * t.count;
      out.plain = element.plain;
      out.holds_instance = element.holds_instance;
      return;
    }
    case TypeKind::kStruct:
      break;
  }
  // The variables of a POU and the ports of a block have roles, members of structures have none.
  out.instance =
      std::any_of(t.fields.begin(), t.fields.end(), [](const ImageField& f) { return f.role != FieldRole::kMember; });
  out.holds_instance = out.instance;
  if (out.instance) {
    out.size = t.size;
    out.align = t.align;
    out.plain = false;
    return;
  }
  for (const ImageField& field : t.fields) {
    const PackedType& member = types_[field.type];
    out.size = (out.size + member.align - 1) / member.align * member.align;
    out.at.push_back(out.size);
    out.size += member.size;
    out.align = std::max(out.align, member.align);
    out.plain = out.plain && member.plain;
    out.holds_instance = out.holds_instance || member.holds_instance;
  }
  out.size = (out.size + out.align - 1) / out.align * out.align;
}

void PackedTypes::find_equal_types() {
  using Key = std::tuple<TypeKind, std::uint32_t, bool, std::int64_t, std::int64_t>;
  std::map<Key, std::uint32_t> known;
  std::vector<std::uint32_t> references;
  for (std::uint32_t type = 0; type < types_.size(); ++type) {
    const ImageType& t = image_->types[type];
    std::uint32_t& first = types_[type].first;
    first = type;
    switch (t.kind) {
      case TypeKind::kStruct:
        break;
      case TypeKind::kRef: {
        const auto equal = std::find_if(references.begin(), references.end(),
                                        [&](std::uint32_t other) { return bytecode::same_type(*image_, other, type); });
        if (equal == references.end()) {
          references.push_back(type);
        } else {
          first = *equal;
        }
        break;
      }
      case TypeKind::kArray:
        first = known.try_emplace(Key{t.kind, types_[t.element].first, false, t.count, t.lower}, type).first->second;
        break;
      case TypeKind::kScalar:
      case TypeKind::kString: {
        const auto elementary = static_cast<std::uint32_t>(t.elementary);
        const std::int64_t lower = t.limited ? t.lower : t.capacity;
        first =
            known.try_emplace(Key{t.kind, elementary, t.limited, lower, t.limited ? t.upper : 0}, type).first->second;
        break;
      }
    }
  }
}

// RT:
PackedPart PackedTypes::find(std::uint32_t type, std::uint32_t offset) const noexcept {
  PackedPart part;
  for (;;) {
    const ImageType& t = image_->types[type];
    const PackedType& packed = types_[type];
    part.type = type;
    part.inside = offset;
    part.left = packed.size - offset;
    switch (t.kind) {
      case TypeKind::kScalar:
      case TypeKind::kString:
        part.kind = PackedPart::Kind::kLeaf;
        return part;
      case TypeKind::kRef:
        part.kind = PackedPart::Kind::kClosed;
        return part;
      case TypeKind::kArray: {
        const std::uint32_t stride = types_[t.element].size;
        if (stride == 0) return part;
        part.storage += offset / stride * image_->types[t.element].size;
        offset %= stride;
        type = t.element;
        continue;
      }
      case TypeKind::kStruct:
        break;
    }
    if (packed.instance) {
      part.kind = PackedPart::Kind::kClosed;
      return part;
    }
    const auto after = std::upper_bound(packed.at.begin(), packed.at.end(), offset);
    if (after == packed.at.begin()) return part;
    const auto number = static_cast<std::size_t>(after - packed.at.begin()) - 1;
    const std::uint32_t within = offset - packed.at[number];
    if (within >= types_[t.fields[number].type].size) {
      if (after != packed.at.end()) part.left = *after - offset;
      return part;
    }
    part.storage += t.fields[number].offset;
    offset = within;
    type = t.fields[number].type;
  }
}

// RT:
std::optional<std::uint32_t> PackedTypes::storage_of(std::uint32_t type, std::uint32_t offset,
                                                     std::uint32_t wanted) const noexcept {
  std::uint32_t storage = 0;
  for (;;) {
    if (offset == 0 && same(type, wanted)) return storage;
    const ImageType& t = image_->types[type];
    const PackedType& packed = types_[type];
    if (t.kind == TypeKind::kArray && types_[t.element].size != 0) {
      const std::uint32_t stride = types_[t.element].size;
      storage += offset / stride * image_->types[t.element].size;
      offset %= stride;
      type = t.element;
    } else if (t.kind == TypeKind::kStruct && !packed.instance) {
      const auto after = std::upper_bound(packed.at.begin(), packed.at.end(), offset);
      if (after == packed.at.begin()) return std::nullopt;
      const auto number = static_cast<std::size_t>(after - packed.at.begin()) - 1;
      offset -= packed.at[number];
      if (offset >= types_[t.fields[number].type].size) return std::nullopt;
      storage += t.fields[number].offset;
      type = t.fields[number].type;
    } else {
      return std::nullopt;
    }
  }
}

// RT:
std::optional<std::uint32_t> PackedTypes::offset_of(std::uint32_t type, std::uint32_t storage,
                                                    std::uint32_t wanted) const noexcept {
  std::uint32_t offset = 0;
  for (;;) {
    if (storage == 0 && same(type, wanted)) return offset;
    const ImageType& t = image_->types[type];
    const PackedType& packed = types_[type];
    if (t.kind == TypeKind::kArray && image_->types[t.element].size != 0) {
      const std::uint32_t size = image_->types[t.element].size;
      if (storage >= t.size) return std::nullopt;
      offset += storage / size * types_[t.element].size;
      storage %= size;
      type = t.element;
    } else if (t.kind == TypeKind::kStruct && !packed.instance) {
      const auto after = std::upper_bound(t.fields.begin(), t.fields.end(), storage,
                                          [](std::uint32_t at, const ImageField& field) { return at < field.offset; });
      if (after == t.fields.begin()) return std::nullopt;
      const auto number = static_cast<std::size_t>(after - t.fields.begin()) - 1;
      const ImageField& field = t.fields[number];
      if (storage - field.offset >= image_->types[field.type].size) return std::nullopt;
      storage -= field.offset;
      offset += packed.at[number];
      type = field.type;
    } else {
      return std::nullopt;
    }
  }
}

}  // namespace plc::runtime
