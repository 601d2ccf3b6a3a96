#include "runtime/pointers/objects.h"

#include <algorithm>
#include <array>

#include "runtime/interpreter/handle.h"
#include "runtime/interpreter/operations.h"
#include "runtime/link/decoded.h"
#include "runtime/pointers/packed_access.h"

namespace plc::runtime {

using bytecode::FieldRole;
using bytecode::Image;
using bytecode::ImageField;
using bytecode::ImageType;
using bytecode::Opcode;
using bytecode::TypeKind;

namespace {

/// Bytes that are copied at once between values of different layouts.
constexpr std::uint32_t kChunk = 64;

bool is_object(const ImageField& field) {
  return field.role != FieldRole::kHidden && field.role != FieldRole::kState && field.role != FieldRole::kInOut;
}

/// A part of a value: `type` and where in it.
template <class Byte>
struct Slice {
  std::uint32_t type;
  Byte* value;
  std::uint32_t offset;
};

/// Copies `size` open bytes between values of different layouts. RT.
void copy_packed(const PackedTypes& types, Slice<std::byte> to, Slice<const std::byte> from, std::uint32_t size,
                 Finer finer) noexcept {
  std::array<std::byte, kChunk> bytes;
  for (std::uint32_t done = 0; done < size; done += kChunk) {
    const std::uint32_t here = std::min(kChunk, size - done);
    read_packed(types, from.type, from.value, from.offset + done, here, bytes.data());
    write_packed(types, to.type, to.value, to.offset + done, here, bytes.data(), finer);
  }
}

}  // namespace

core::Result<Objects> Objects::make(const Image& image, std::uint32_t body, const TaskLayout& layout,
                                    std::uint64_t tag) {
  Objects made(image);
  made.tag_ = tag;
  made.add_variables(image, image.global_type, 0, kNone, false);
  made.globals_ = static_cast<std::uint32_t>(made.objects_.size());
  made.add_variables(image, image.pous[body].instance_type, layout.instance, kNone, false);
  for (std::size_t pou = 0; pou < image.pous.size(); ++pou) {
    if (layout.frames[pou] == TaskLayout::kAbsent) continue;
    made.add_variables(image, image.pous[pou].frame_type, layout.frames[pou], kNone, false);
  }
  if (made.objects_.size() >= Pointer::kMaxObjects) {
    return core::Problem{core::Code::P9001, "image has more variables than pointers can name", {}};
  }
  made.give_addresses();
  return made;
}

void Objects::add_variables(const Image& image, std::uint32_t structure, std::uint32_t begin, std::uint32_t parent,
                            bool constant) {
  for (const ImageField& field : image.types[structure].fields) {
    if (!is_object(field) || objects_.size() >= Pointer::kMaxObjects) continue;
    const bool fixed = constant || field.constant;
    const auto number = static_cast<std::uint32_t>(objects_.size());
    objects_.push_back({begin + field.offset, field.type, parent, 0, fixed});
    add_instances(image, field.type, begin + field.offset, number, fixed);
  }
}

void Objects::add_instances(const Image& image, std::uint32_t type, std::uint32_t begin, std::uint32_t parent,
                            bool constant) {
  if (!types_[type].holds_instance) return;
  if (types_[type].instance) return add_variables(image, type, begin, parent, constant);
  const ImageType& t = image.types[type];
  if (t.kind == TypeKind::kArray) {
    for (std::uint32_t i = 0; i < t.count && objects_.size() < Pointer::kMaxObjects; ++i) {
      add_instances(image, t.element, begin + i * image.types[t.element].size, parent, constant);
    }
  }
  for (const ImageField& field : t.fields) {
    add_instances(image, field.type, begin + field.offset, parent, constant || field.constant);
  }
}

void Objects::give_addresses() {
  // From a number on that no small integer is.
  std::uint64_t next = 0x10000;
  for (Object& object : objects_) {
    const std::uint64_t address = next + kMargin;
    next = (address + types_[object.type].size + kMargin + 7) / 8 * 8;
    if (next > 0xffffffffu) return;
    object.address = static_cast<std::uint32_t>(address);
  }
}

// RT:
const Objects::Object* Objects::object_of(Pointer pointer) const noexcept {
  const std::uint64_t tag = pointer.tag();
  const std::uint32_t number = pointer.object();
  if (tag == Handle::kGlobalTag) return number < globals_ ? &objects_[number] : nullptr;
  const auto own = static_cast<std::uint32_t>(objects_.size()) - globals_;
  return tag == tag_ && number < own ? &objects_[globals_ + number] : nullptr;
}

// RT:
Objects::Spot Objects::spot_of(Pointer pointer) const noexcept {
  const Object* const object = object_of(pointer);
  const std::int64_t offset = pointer.offset();
  if (object == nullptr || offset < 0 || offset >= std::int64_t{types_[object->type].size}) return {};
  return {object, static_cast<std::uint32_t>(offset)};
}

// RT:
bool Objects::holds_open(Spot spot, std::uint32_t size) const noexcept {
  const std::uint32_t type = spot.object->type;
  return size <= types_[type].size - spot.offset && is_open(types_, type, spot.offset, size);
}

// RT:
Pointer Objects::pointer_to(const Object& object, std::int64_t offset) const noexcept {
  const auto number = static_cast<std::uint32_t>(&object - objects_.data());
  return number < globals_ ? Pointer::make(Handle::kGlobalTag, number, offset)
                           : Pointer::make(tag_, number - globals_, offset);
}

// RT:
Pointer Objects::address_of(std::uint32_t place, std::uint32_t type) const noexcept {
  const auto after = std::upper_bound(objects_.begin(), objects_.end(), place,
                                      [](std::uint32_t at, const Object& object) { return at < object.begin; });
  auto number = static_cast<std::uint32_t>(after - objects_.begin()) - 1;
  // From the innermost object outwards: as many steps as types nest.
  for (; number != kNone; number = objects_[number].parent) {
    const Object& object = objects_[number];
    const auto offset = types_.offset_of(object.type, place - object.begin, type);
    if (offset) return pointer_to(object, *offset);
  }
  return {};
}

// RT:
std::optional<std::uint32_t> Objects::place_of(Pointer pointer, std::uint32_t type) const noexcept {
  const Spot spot = spot_of(pointer);
  if (!spot || spot.object->constant) return std::nullopt;
  const auto storage = types_.storage_of(spot.object->type, spot.offset, type);
  return storage ? std::optional(spot.object->begin + *storage) : std::nullopt;
}

// RT:
Reached Objects::load(const std::byte* table, Pointer pointer, std::uint32_t type, std::byte* to,
                      std::uint16_t capacity) const noexcept {
  const Spot spot = spot_of(pointer);
  if (!spot) return Reached::kNowhere;
  const ImageType& t = types_.image_type(type);
  if (t.kind == TypeKind::kString) return load_text(table, spot, type, to, capacity);
  const std::byte* const value = table + spot.object->begin;
  if (const auto exact = types_.storage_of(spot.object->type, spot.offset, type)) {
    std::memmove(to, value + *exact, t.size);
    return Reached::kFine;
  }
  const std::uint32_t size = types_[type].size;
  const std::uint32_t there = spot.object->type;
  if (!types_[type].plain || !holds_open(spot, size)) return Reached::kNowhere;
  copy_packed(types_, {type, to, 0}, {there, value, spot.offset}, size, Finer::kNew);
  return Reached::kFine;
}

// RT:
Reached Objects::store(std::byte* table, Pointer pointer, std::uint32_t type, const std::byte* from,
                       std::uint16_t capacity) const noexcept {
  const Spot spot = spot_of(pointer);
  if (!spot || spot.object->constant) return Reached::kNowhere;
  const ImageType& t = types_.image_type(type);
  if (t.kind == TypeKind::kString) return store_text(table, spot, type, from, capacity);
  std::byte* const value = table + spot.object->begin;
  if (const auto exact = types_.storage_of(spot.object->type, spot.offset, type)) {
    std::memmove(value + *exact, from, t.size);
    return Reached::kFine;
  }
  const std::uint32_t size = types_[type].size;
  const std::uint32_t there = spot.object->type;
  if (!types_[type].plain || !holds_open(spot, size)) return Reached::kNowhere;
  copy_packed(types_, {there, value, spot.offset}, {type, from, 0}, size, Finer::kStays);
  return Reached::kFine;
}

// A text is read up to its zero, or to the capacity of the pointer's type: the zero has to be inside the object.
// RT:
Reached Objects::load_text(const std::byte* table, Spot spot, std::uint32_t type, std::byte* to,
                           std::uint16_t capacity) const noexcept {
  const ImageType& t = types_.image_type(type);
  const std::uint32_t width = types_[type].align;
  const std::uint32_t there = spot.object->type;
  const std::byte* const value = table + spot.object->begin;
  const PackedPart part = types_.find(there, spot.offset);
  const ImageType& leaf = types_.image_type(part.type);
  const bool string = part.kind == PackedPart::Kind::kLeaf && leaf.kind == TypeKind::kString;
  if (string && part.inside == 0 && leaf.elementary == t.elementary) {
    const std::uint32_t capacities = capacity | std::uint32_t{leaf.capacity} << 16;
    return copy_string(to, value + part.storage, capacities, width) ? Reached::kFine : Reached::kCut;
  }
  std::byte* const characters = to + sizeof(core::StringHeader);
  const std::uint32_t whole = types_[there].size - spot.offset;
  bool cut = false;
  std::uint32_t length = 0;
  for (std::uint32_t done = 0; length < t.capacity; done += width) {
    if (whole - done < width || !is_open(types_, there, spot.offset + done, width)) return Reached::kNowhere;
    std::uint16_t character = 0;
    read_packed(types_, there, value, spot.offset + done, width, reinterpret_cast<std::byte*>(&character));
    if (character == 0) break;
    cut = cut || length == capacity;
    if (length < capacity) std::memcpy(characters + std::size_t{length} * width, &character, width);
    ++length;
  }
  runtime::store(to,
                 core::StringHeader{capacity, static_cast<std::uint16_t>(std::min<std::uint32_t>(length, capacity))});
  return cut ? Reached::kCut : Reached::kFine;
}

// RT:
Reached Objects::store_text(std::byte* table, Spot spot, std::uint32_t type, const std::byte* from,
                            std::uint16_t capacity) const noexcept {
  const ImageType& t = types_.image_type(type);
  const std::uint32_t width = types_[type].align;
  const std::uint32_t there = spot.object->type;
  std::byte* const value = table + spot.object->begin;
  const std::uint32_t given = std::min<std::uint32_t>(runtime::load<core::StringHeader>(from).length, capacity);
  const std::uint32_t length = std::min<std::uint32_t>(given, t.capacity);
  const PackedPart part = types_.find(there, spot.offset);
  const ImageType& leaf = types_.image_type(part.type);
  const bool string = part.kind == PackedPart::Kind::kLeaf && leaf.kind == TypeKind::kString;
  if (string && part.inside == 0 && leaf.elementary == t.elementary) {
    const bool whole = copy_string(value + part.storage, from, leaf.capacity | length << 16, width);
    return whole && length == given ? Reached::kFine : Reached::kCut;
  }
  const std::uint32_t bytes = (length + 1) * width;
  if (!holds_open(spot, bytes)) return Reached::kNowhere;
  const std::byte* const characters = from + sizeof(core::StringHeader);
  write_packed(types_, there, value, spot.offset, length * width, characters);
  constexpr std::byte kZero[2] = {};
  write_packed(types_, there, value, spot.offset + length * width, width, kZero);
  return length == given ? Reached::kFine : Reached::kCut;
}

// RT:
std::optional<std::uint32_t> Objects::to_32(Pointer pointer) const noexcept {
  if (pointer.bits == 0) return 0;
  const Object* const object = object_of(pointer);
  if (object == nullptr || object->address == 0) return std::nullopt;
  const std::int64_t offset = pointer.offset();
  if (offset < -std::int64_t{kMargin} || offset >= std::int64_t{types_[object->type].size} + kMargin) {
    return std::nullopt;
  }
  return static_cast<std::uint32_t>(std::int64_t{object->address} + offset);
}

// RT:
std::optional<Pointer> Objects::from_32(std::uint32_t address) const noexcept {
  if (address == 0) return Pointer{};
  const auto after = std::upper_bound(
      objects_.begin(), objects_.end(), address,
      [](std::uint32_t at, const Object& object) { return object.address == 0 || at < object.address - kMargin; });
  if (after == objects_.begin()) return std::nullopt;
  const Object& object = *(after - 1);
  const std::int64_t offset = std::int64_t{address} - object.address;
  if (offset >= std::int64_t{types_[object.type].size} + kMargin) return std::nullopt;
  return pointer_to(object, offset);
}

bool uses_pointers(const Image& image, const std::vector<std::uint32_t>& reached) {
  return std::any_of(reached.begin(), reached.end(), [&image](std::uint32_t pou) {
    bool found = false;
    for_each_instruction(image.pous[pou], [&found](const Decoded& d) {
      found = found || (d.opcode >= Opcode::kAdrAt && d.opcode <= Opcode::kPtrFrom32);
    });
    return found;
  });
}

}  // namespace plc::runtime
