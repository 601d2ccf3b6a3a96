#include "runtime/record/table_types.h"

#include <algorithm>
#include <cstring>

#include "bytecode/type_map.h"
#include "core/types.h"
#include "runtime/interpreter/handle.h"

namespace plc::runtime {
namespace {

using bytecode::ImageType;
using bytecode::TypeKind;
using core::Rep;

template <class T>
T load(const std::byte* from) noexcept {
  T value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

}  // namespace

TableTypes::TableTypes(const bytecode::Image& image, std::uint32_t task, std::uint32_t body, const TaskLayout& layout)
    : image_(image), task_tag_(Handle::task_tag(task)), constants_(layout.constants), demands_(image.types.size()) {
  for (std::size_t t = 0; t < image.types.size(); ++t) {
    const ImageType& type = image.types[t];
    bool demands = false;
    switch (type.kind) {
      case TypeKind::kScalar:
        demands = bytecode::rep_of(type) == Rep::kBool;
        break;
      case TypeKind::kString:
      case TypeKind::kRef:
        demands = true;
        break;
      case TypeKind::kArray:
        demands = demands_[type.element] != 0;
        break;
      case TypeKind::kStruct:
        for (const bytecode::ImageField& field : type.fields) demands = demands || demands_[field.type] != 0;
        break;
    }
    demands_[t] = demands ? 1 : 0;
  }
  add_region(0, image.global_type);
  add_region(layout.instance, image.pous[body].instance_type);
  for (std::size_t pou = 0; pou < layout.frames.size(); ++pou) {
    if (layout.frames[pou] != TaskLayout::kAbsent) add_region(layout.frames[pou], image.pous[pou].frame_type);
  }
  std::sort(regions_.begin(), regions_.end(), [](const Region& a, const Region& b) { return a.at < b.at; });
  std::sort(rows_.begin(), rows_.end(), [](const Row& a, const Row& b) { return a.at < b.at; });
}

void TableTypes::add_region(std::uint32_t at, std::uint32_t type) {
  regions_.push_back({at, type});
  add(at, type);
}

// Nesting is bounded by the verifier.
void TableTypes::add(std::uint32_t at, std::uint32_t index) {
  if (!demands(index)) return;
  const ImageType& type = image_.types[index];
  if (type.kind == TypeKind::kStruct) {
    for (const bytecode::ImageField& field : type.fields) add(at + field.offset, field.type);
  } else if (type.kind == TypeKind::kArray) {
    const ImageType& element = image_.types[type.element];
    if (element.kind != TypeKind::kStruct && element.kind != TypeKind::kArray) {
      if (type.count != 0) rows_.push_back({at, type.element, element.size, static_cast<std::uint32_t>(type.count)});
      return;
    }
    for (std::uint32_t i = 0; i < type.count; ++i) add(at + i * element.size, type.element);
  } else {
    rows_.push_back({at, index, type.size, 1});
  }
}

bool TableTypes::leads_to_a_value(std::uint64_t bits) const noexcept {
  const Handle handle{bits};
  if (handle.type() >= image_.types.size()) return false;
  if (handle.tag() == Handle::kGlobalTag) {
    return bytecode::find_place(image_, image_.global_type, handle.offset(), handle.type()).has_value();
  }
  // Another task's is null here.
  if (handle.tag() != task_tag_) return true;
  const auto after = std::partition_point(regions_.begin(), regions_.end(),
                                          [&](const Region& one) { return one.at <= handle.offset(); });
  if (after == regions_.begin()) return false;
  const Region& region = *std::prev(after);
  const std::uint32_t offset = handle.offset() - region.at;
  if (bytecode::find_place(image_, region.type, offset, handle.type())) return true;
  return handle.offset() >= constants_ && handle.offset() - constants_ < image_.const_bytes.size() &&
         bytecode::find_place(image_, image_.const_type, handle.offset() - constants_, handle.type()).has_value();
}

bool TableTypes::mend_leaf(std::uint32_t index, std::byte* value) const noexcept {
  const ImageType& type = image_.types[index];
  if (type.kind == TypeKind::kRef) {
    const auto handle = load<std::uint64_t>(value);
    if (handle == 0 || leads_to_a_value(handle)) return true;
    std::memset(value, 0, sizeof handle);
    return false;
  }
  if (type.kind == TypeKind::kString) {
    auto header = load<core::StringHeader>(value);
    if (header.capacity == type.capacity && header.length <= type.capacity) return true;
    header = {type.capacity, std::min(header.length, type.capacity)};
    std::memcpy(value, &header, sizeof header);
    return false;
  }
  if (load<std::uint8_t>(value) <= 1) return true;
  *value = std::byte{1};
  return false;
}

bool TableTypes::mend(std::span<std::byte> table, std::size_t at, std::size_t bytes) const noexcept {
  bool good = true;
  const std::size_t end = at + bytes;
  const std::vector<std::byte>& constants = image_.const_bytes;
  const std::size_t from = std::max<std::size_t>(at, constants_);
  const std::size_t to = std::min(end, constants_ + constants.size());
  if (from < to && std::memcmp(&table[from], &constants[from - constants_], to - from) != 0) {
    std::memcpy(&table[from], &constants[from - constants_], to - from);
    good = false;
  }
  auto row = std::partition_point(rows_.begin(), rows_.end(), [at](const Row& one) { return one.end() <= at; });
  for (; row != rows_.end() && row->at < end; ++row) {
    const std::uint32_t first = at > row->at ? static_cast<std::uint32_t>((at - row->at) / row->bytes) : 0;
    for (std::uint32_t i = first; i < row->count && row->at + std::uint64_t{i} * row->bytes < end; ++i)
      good = mend_leaf(row->type, &table[row->at + std::size_t{i} * row->bytes]) && good;
  }
  return good;
}

}  // namespace plc::runtime
