#include "bytecode/codegen/layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

#include "bytecode/type_map.h"
#include "core/packed.h"
#include "ir/foreign_size.h"

namespace plc::bytecode {
namespace {

std::uint64_t aligned(std::uint64_t at, std::uint32_t align) { return (at + align - 1) / align * align; }

/// Whether the variable has a place in its POU's instance or frame.
bool has_memory(const ir::Variable& v) { return v.role != ir::Role::kExternal && v.role != ir::Role::kQueue; }

FieldRole role_of(ir::Role role) {
  switch (role) {
    case ir::Role::kInput:
      return FieldRole::kInput;
    case ir::Role::kOutput:
      return FieldRole::kOutput;
    case ir::Role::kInOut:
      return FieldRole::kInOut;
    case ir::Role::kTemp:
      return FieldRole::kTemp;
    case ir::Role::kReturnValue:
      return FieldRole::kReturnValue;
    case ir::Role::kHidden:
      return FieldRole::kHidden;
    default:
      return FieldRole::kLocal;
  }
}

FieldRole role_of(stdlib::Direction direction) {
  switch (direction) {
    case stdlib::Direction::kInput:
      return FieldRole::kInput;
    case stdlib::Direction::kOutput:
      return FieldRole::kOutput;
    case stdlib::Direction::kInOut:
      return FieldRole::kInOut;
    default:
      return FieldRole::kState;
  }
}

/// Largest numbers that 64-bit limits of a representation may name.
std::pair<std::int64_t, std::int64_t> widest(core::Rep rep) {
  const std::uint32_t bits = core::rep_bytes(rep) * 8;
  const bool is_signed =
      rep == core::Rep::kI8 || rep == core::Rep::kI16 || rep == core::Rep::kI32 || rep == core::Rep::kI64;
  if (bits == 64) {
    return {is_signed ? std::numeric_limits<std::int64_t>::min() : 0, std::numeric_limits<std::int64_t>::max()};
  }
  if (is_signed) return {-(std::int64_t{1} << (bits - 1)), (std::int64_t{1} << (bits - 1)) - 1};
  return {0, (std::int64_t{1} << bits) - 1};
}

}  // namespace

void keep(const ir::Variable& variable, bool kept, ImageField& field) {
  field.retain = kept && variable.retain;
  field.persistent = kept && variable.persistent;
  field.fresh = variable.nonretain;
}

// ---- structures ---------------------------------------------------------------------------------------------------

std::uint32_t StructBuilder::add(const Image& image, ImageField field) {
  const ImageType& type = image.types[field.type];
  const std::uint64_t at = aligned(end_, type.align);
  end_ = at + type.size;
  align_ = std::max(align_, type.align);
  field.offset = static_cast<std::uint32_t>(std::min<std::uint64_t>(at, kMaxTableBytes));
  fields_.push_back(std::move(field));
  return static_cast<std::uint32_t>(fields_.size() - 1);
}

ImageType StructBuilder::finish(std::string name) {
  ImageType type;
  type.kind = TypeKind::kStruct;
  type.name = std::move(name);
  type.align = align_;
  type.size = static_cast<std::uint32_t>(std::min<std::uint64_t>(aligned(end_, align_), kMaxTableBytes));
  type.fields = std::move(fields_);
  return type;
}

// ---- types --------------------------------------------------------------------------------------------------------

std::uint32_t Layout::add(ImageType type) {
  image_.types.push_back(std::move(type));
  while (parts_.size() < image_.types.size()) parts_.push_back(parts_of(image_.types[parts_.size()], parts_));
  too_large_ = too_large_ || parts_.back() > kMaxTableBytes;
  return static_cast<std::uint32_t>(image_.types.size() - 1);
}

std::uint32_t Layout::empty_struct() {
  if (empty_ == kNoIndex) empty_ = add(StructBuilder{}.finish(""));
  return empty_;
}

std::uint32_t Layout::type(ir::TypeRef ref) {
  if (by_ref_.size() < module_.types.size()) {
    by_ref_.resize(module_.types.size(), kNoIndex);
    block_fields_.resize(module_.types.size());
  }
  if (by_ref_[ref.index] == kNoIndex) {
    const std::uint32_t made = make(ref);
    by_ref_[ref.index] = made;
  }
  return by_ref_[ref.index];
}

std::uint32_t Layout::make(ir::TypeRef ref) {
  const ir::Type& type = module_.types[ref];
  switch (type.kind) {
    case ir::TypeKind::kElementary:
    case ir::TypeKind::kEnum:
    case ir::TypeKind::kSubrange:
    case ir::TypeKind::kPointer:
      return make_scalar(type);
    case ir::TypeKind::kUnion:
      return make_union(ref);
    case ir::TypeKind::kString:
      return make_string(type.elementary, type.capacity);
    case ir::TypeKind::kArray:
      return make_array(type);
    case ir::TypeKind::kStruct:
      return make_struct(type);
    case ir::TypeKind::kBlock: {
      const std::uint32_t made = make_block(*type.block);
      std::vector<std::uint32_t>& fields = block_fields_[ref.index];
      for (const stdlib::Field& port : type.block->fields) {
        const std::vector<ImageField>& all = image_.types[made].fields;
        const auto it =
            std::find_if(all.begin(), all.end(), [&](const ImageField& f) { return f.offset == port.offset; });
        fields.push_back(static_cast<std::uint32_t>(it - all.begin()));
      }
      return made;
    }
    case ir::TypeKind::kPou:
      return make_instance(type.pou);
    case ir::TypeKind::kReference:
      return reference(type.element);
  }
  return empty_struct();
}

std::uint32_t Layout::reference(ir::TypeRef target) {
  const auto [it, fresh] = references_.try_emplace(target.index, kNoIndex);
  if (fresh) {
    ImageType out;
    out.kind = TypeKind::kRef;
    out.size = out.align = core::rep_bytes(core::Rep::kRef);
    it->second = add(std::move(out));
    // The target may hold this reference: it is made when nothing else is under construction.
    pending_.push_back({it->second, target});
  }
  return it->second;
}

void Layout::finish() {
  while (!pending_.empty()) {
    const Pending p = pending_.back();
    pending_.pop_back();
    const std::uint32_t target = type(p.target);
    image_.types[p.image_type].element = target;
  }
}

std::uint32_t Layout::make_scalar(const ir::Type& type) {
  ImageType out;
  out.kind = TypeKind::kScalar;
  out.elementary = type.elementary;
  out.name = type.name;
  const core::Rep rep = core::rep_of(type.elementary);
  out.size = out.align = core::rep_bytes(rep);
  if (type.kind == ir::TypeKind::kSubrange) {
    out.limited = true;
    out.lower = type.lower;
    out.upper = type.upper;
  }
  if (type.kind == ir::TypeKind::kEnum && !type.members.empty()) {
    out.limited = true;
    out.lower = out.upper = type.members.front().value;
    for (const ir::EnumMember& member : type.members) {
      out.lower = std::min(out.lower, member.value);
      out.upper = std::max(out.upper, member.value);
      out.members.push_back(member.name);
      out.member_values.push_back(member.value);
    }
  }
  if (out.limited) {
    const auto [least, most] = widest(rep);
    out.lower = std::max(out.lower, least);
    out.upper = std::min(out.upper, most);
  }
  return add(std::move(out));
}

std::uint32_t Layout::make_string(core::TypeId id, std::uint16_t capacity) {
  const auto [it, fresh] = strings_.try_emplace({id, capacity}, kNoIndex);
  if (fresh) {
    ImageType out;
    out.kind = TypeKind::kString;
    out.elementary = id;
    out.capacity = capacity;
    out.align = 2;
    const std::uint32_t width = id == core::TypeId::kWstring ? 2 : 1;
    out.size = static_cast<std::uint32_t>(aligned(sizeof(core::StringHeader) + std::uint64_t{capacity} * width, 2));
    it->second = add(std::move(out));
  }
  return it->second;
}

std::uint32_t Layout::make_array(const ir::Type& type) {
  const std::uint32_t element = this->type(type.element);
  const ImageType& e = image_.types[element];
  ImageType out;
  out.kind = TypeKind::kArray;
  out.name = type.name;
  out.element = element;
  out.lower = type.lower;
  out.align = e.align;
  const std::uint64_t count = static_cast<std::uint64_t>(type.upper) - static_cast<std::uint64_t>(type.lower) + 1;
  const bool fits =
      type.upper >= type.lower && count - 1 < kMaxTableBytes && (e.size == 0 || count <= kMaxTableBytes / e.size);
  too_large_ = too_large_ || !fits;
  out.count = fits ? static_cast<std::uint32_t>(count) : 1;
  out.size = out.count * e.size;
  return add(std::move(out));
}

std::uint32_t Layout::make_struct(const ir::Type& type) {
  StructBuilder builder;
  for (const ir::TypeField& field : type.fields) {
    ImageField f;
    f.name = field.name;
    f.type = this->type(field.type);
    builder.add(image_, std::move(f));
  }
  too_large_ = too_large_ || builder.too_large();
  return add(builder.finish(type.name));
}

// Words of the size that the members are aligned to: what lies in them is read as pointers read.
std::uint32_t Layout::make_union(ir::TypeRef ref) {
  const auto align = ir::foreign_align(module_.types, ref).value_or(1);
  const auto bytes = ir::foreign_size(module_.types, ref).value_or(0);
  using enum core::TypeId;
  const core::TypeId word = align == 1 ? kByte : align == 2 ? kWord : align == 4 ? kDword : kLword;
  ImageType out;
  out.kind = TypeKind::kArray;
  out.name = module_.types[ref].name;
  out.element = type(ir::ref_of(word));
  out.align = static_cast<std::uint32_t>(align);
  const bool fits = bytes != 0 && bytes <= kMaxTableBytes;
  too_large_ = too_large_ || !fits;
  out.count = fits ? static_cast<std::uint32_t>(bytes / align) : 1;
  out.size = out.count * out.align;
  return add(std::move(out));
}

std::uint32_t Layout::make_block(const stdlib::BlockSpec& spec) {
  ImageType out;
  out.kind = TypeKind::kStruct;
  out.name = std::string(spec.name);
  out.size = spec.size;
  out.align = spec.align;
  for (const stdlib::Field& port : spec.fields) {
    ImageField f;
    f.name = std::string(port.name);
    f.offset = port.offset;
    f.role = role_of(port.direction);
    const core::Rep rep = core::rep_of(port.type);
    if (rep == core::Rep::kStr || rep == core::Rep::kWstr) {
      core::StringHeader header;
      header.capacity = core::kDefaultStringCapacity;
      if (spec.initial != nullptr) {
        std::memcpy(&header, static_cast<const std::byte*>(spec.initial) + port.offset, sizeof header);
      }
      f.type = make_string(port.type, header.capacity);
    } else {
      f.type = type(ir::ref_of(port.type));
    }
    out.fields.push_back(std::move(f));
  }
  std::sort(out.fields.begin(), out.fields.end(),
            [](const ImageField& a, const ImageField& b) { return a.offset < b.offset; });
  return add(std::move(out));
}

std::uint32_t Layout::make_instance(std::uint32_t index) {
  if (pous_.size() < module_.pous.size()) pous_.resize(module_.pous.size());
  const ir::Pou& pou = module_.pous[index];
  PouLayout layout;
  layout.offset.assign(pou.variables.size(), kNoIndex);
  layout.field.assign(pou.variables.size(), kNoIndex);
  StructBuilder builder;
  // Hidden ones last: adding an edge to a drawing moves no declared variable. But the number of a taskblock's object is
  // where every engine finds it, at the start.
  for (const bool hidden : {pou.taskblock != 0, pou.taskblock == 0}) {
    for (std::uint32_t i = 0; i < pou.variables.size(); ++i) {
      const ir::Variable& v = pou.variables[i];
      if (v.in_frame || !has_memory(v) || (v.role == ir::Role::kHidden) != hidden) continue;
      ImageField f;
      // The outside sees the global that belongs to it, under the same path.
      const bool located = !v.address.empty();
      f.name = located ? v.name + "#" : v.name;
      f.type = type(v.type);
      f.role = role_of(v.role);
      // Callers give inputs their values and in-outs their variables, and references are made when the POU first runs.
      // Inputs of taskblocks that are constant have theirs from the start: what ready() checked stays.
      const bool given = v.role == ir::Role::kInOut || (v.role == ir::Role::kInput && pou.taskblock == 0);
      f.constant = v.constant && !given && v.references.empty();
      keep(v, !v.constant && !located, f);
      f.internal = located || v.step || v.role == ir::Role::kHidden;
      layout.field[i] = builder.add(image_, std::move(f));
      layout.offset[i] = builder.offset(layout.field[i]);
    }
  }
  too_large_ = too_large_ || builder.too_large();
  ImageType instance = builder.finish(pou.name);
  for (const ir::Variable& v : pou.variables) {
    const bool alias = v.role == ir::Role::kExternal && !v.in_frame && !module_.globals[v.global].queue;
    if (alias) instance.aliases.push_back({v.name, global_fields_[v.global]});
  }
  layout.instance_type = add(std::move(instance));
  const std::uint32_t made = layout.instance_type;
  pous_[index] = std::move(layout);
  return made;
}

// ---- POUs ---------------------------------------------------------------------------------------------------------

const PouLayout& Layout::pou(std::uint32_t index) {
  if (pous_.size() < module_.pous.size()) pous_.resize(module_.pous.size());
  if (pous_[index]) return *pous_[index];
  const ir::Pou& pou = module_.pous[index];
  if (pou.owner != ir::Pou::kDeclared) return this->pou(pou.owner);
  if (pou.instance_type.valid()) {
    type(pou.instance_type);
  } else {
    PouLayout layout;
    layout.offset.assign(pou.variables.size(), kNoIndex);
    layout.field.assign(pou.variables.size(), kNoIndex);
    layout.instance_type = empty_struct();
    pous_[index] = std::move(layout);
  }
  return *pous_[index];
}

void Layout::lay_out_frame(std::uint32_t index, StructBuilder& frame) {
  pou(index);
  if (module_.pous[index].owner != ir::Pou::kDeclared) return;
  PouLayout& layout = *pous_[index];
  const ir::Pou& p = module_.pous[index];
  for (std::uint32_t i = 0; i < p.variables.size(); ++i) {
    const ir::Variable& v = p.variables[i];
    if (!v.in_frame || !has_memory(v)) continue;
    ImageField f;
    f.name = v.name;
    f.type = type(v.type);
    f.role = role_of(v.role);
    layout.field[i] = frame.add(image_, std::move(f));
    layout.offset[i] = frame.offset(layout.field[i]);
  }
}

std::uint32_t Layout::field_index(ir::TypeRef ref, std::uint32_t index) {
  const ir::Type& t = module_.types[ref];
  type(ref);
  if (t.kind == ir::TypeKind::kPou) return pou(t.pou).field[index];
  if (t.kind == ir::TypeKind::kBlock) return block_fields_[ref.index][index];
  return index;
}

std::uint32_t Layout::field_offset(ir::TypeRef ref, std::uint32_t index) {
  const std::uint32_t struct_type = type(ref);
  return image_.types[struct_type].fields[field_index(ref, index)].offset;
}

// ---- initial values -----------------------------------------------------------------------------------------------

void Layout::write_constant(const ir::Constant& constant, ir::TypeRef as, std::byte* to) const {
  const ir::Type& type = module_.types[as];
  if (type.kind == ir::TypeKind::kString) {
    const std::size_t width = type.elementary == core::TypeId::kWstring ? 2 : 1;
    core::StringHeader header;
    header.capacity = type.capacity;
    header.length = static_cast<std::uint16_t>(std::min<std::size_t>(constant.text.size() / width, type.capacity));
    std::memcpy(to, &header, sizeof header);
    std::memcpy(to + sizeof header, constant.text.data(), header.length * width);
    return;
  }
  if (const auto rep = module_.types.rep_of(as)) std::memcpy(to, &constant.bits, core::rep_bytes(*rep));
}

void Layout::initialise_raw(std::uint32_t image_type, std::byte* to) const {
  const ImageType& t = image_.types[image_type];
  switch (t.kind) {
    case TypeKind::kString: {
      core::StringHeader header;
      header.capacity = t.capacity;
      std::memcpy(to, &header, sizeof header);
      return;
    }
    case TypeKind::kArray:
      for (std::uint32_t i = 0; i < t.count; ++i) {
        initialise_raw(t.element, to + std::size_t{i} * image_.types[t.element].size);
      }
      return;
    case TypeKind::kStruct:
      for (const ImageField& f : t.fields) initialise_raw(f.type, to + f.offset);
      return;
    case TypeKind::kScalar:
      if (t.limited && (t.lower > 0 || t.upper < 0)) std::memcpy(to, &t.lower, t.size);
      return;
    case TypeKind::kRef:
      return;
  }
}

void Layout::initialise(ir::TypeRef ref, std::byte* to) {
  const ir::Type& t = module_.types[ref];
  const std::uint32_t made = type(ref);
  switch (t.kind) {
    case ir::TypeKind::kElementary:
    case ir::TypeKind::kReference:
    case ir::TypeKind::kPointer:
    case ir::TypeKind::kUnion:
      return;
    case ir::TypeKind::kString:
      initialise_raw(made, to);
      return;
    case ir::TypeKind::kEnum:
    case ir::TypeKind::kSubrange: {
      const ImageType& image_type = image_.types[made];
      const std::int64_t value =
          image_type.limited ? std::clamp(t.initial, image_type.lower, image_type.upper) : t.initial;
      std::memcpy(to, &value, image_type.size);
      return;
    }
    case ir::TypeKind::kArray: {
      const std::uint32_t count = image_.types[made].count;
      const std::uint32_t stride = image_.types[image_.types[made].element].size;
      initialise(t.element, to);
      for (std::uint32_t i = 1; i < count; ++i) std::memcpy(to + std::size_t{i} * stride, to, stride);
      return;
    }
    case ir::TypeKind::kStruct:
      for (std::uint32_t i = 0; i < t.fields.size(); ++i) initialise(t.fields[i].type, to + field_offset(ref, i));
      return;
    case ir::TypeKind::kBlock:
      if (t.block->initial != nullptr) std::memcpy(to, t.block->initial, t.block->size);
      return;
    case ir::TypeKind::kPou: {
      const std::vector<std::byte>& fresh = instance_initial(t.pou);
      if (!fresh.empty()) std::memcpy(to, fresh.data(), fresh.size());
      return;
    }
  }
}

void Layout::initialise(const ir::Variable& variable, std::byte* to) {
  initialise(variable.type, to);
  override_values(variable.type, variable.initial, to);
}

void Layout::override_values(ir::TypeRef ref, std::span<const ir::InitItem> items, std::byte* to) {
  for (const ir::InitItem& item : items) {
    if (write_in_union(item, ref, to)) continue;
    ir::TypeRef at = ref;
    std::byte* const leaf = to + walk(at, item.path);
    write_constant(item.value, at, leaf);
  }
}

// In a union values lie as pointers see them (runtime/pointers/packed_types.h).
bool Layout::write_in_union(const ir::InitItem& item, ir::TypeRef ref, std::byte* to) {
  const std::span<const std::uint32_t> path = item.path;
  ir::TypeRef at = ref;
  std::size_t steps = 0;
  for (; steps < path.size() && module_.types[at].kind != ir::TypeKind::kUnion; ++steps) walk_step(at, path[steps]);
  if (steps == path.size()) return false;
  at = ref;
  std::uint64_t offset = walk(at, path.first(steps));
  for (; steps < path.size(); ++steps) {
    offset += ir::foreign_offset(module_.types, at, path[steps]).value_or(0);
    const ir::Type& t = module_.types[at];
    at = t.kind == ir::TypeKind::kArray ? t.element : t.fields[path[steps]].type;
  }
  const ir::Type& type = module_.types[at];
  std::byte* const member = to + offset;
  if (type.kind == ir::TypeKind::kString) {
    const std::size_t width = type.elementary == core::TypeId::kWstring ? 2 : 1;
    const std::size_t bytes = std::min<std::size_t>(item.value.text.size(), type.capacity * width);
    std::memcpy(member, item.value.text.data(), bytes);
    std::memset(member + bytes, 0, width);
    return true;
  }
  std::uint64_t bits = item.value.bits;
  const std::int64_t step = core::packed_step_ns(type.elementary);
  if (step != 0) bits = static_cast<std::uint64_t>(static_cast<std::int64_t>(bits) / step);
  std::memcpy(member, &bits, ir::foreign_size(module_.types, at).value_or(0));
  return true;
}

std::uint32_t Layout::offset_of(ir::TypeRef ref, std::span<const std::uint32_t> path) { return walk(ref, path); }

std::uint32_t Layout::walk(ir::TypeRef& at, std::span<const std::uint32_t> path) {
  std::uint32_t offset = 0;
  for (const std::uint32_t step : path) offset += walk_step(at, step);
  return offset;
}

std::uint32_t Layout::walk_step(ir::TypeRef& at, std::uint32_t step) {
  const ir::Type& t = module_.types[at];
  if (t.kind == ir::TypeKind::kArray) {
    at = t.element;
    return step * image_.types[type(t.element)].size;
  }
  const std::uint32_t offset = field_offset(at, step);
  if (t.kind == ir::TypeKind::kStruct) at = t.fields[step].type;
  if (t.kind == ir::TypeKind::kBlock) at = ir::ref_of(t.block->fields[step].type);
  if (t.kind == ir::TypeKind::kPou) at = module_.pous[t.pou].variables[step].type;
  return offset;
}

const std::vector<std::byte>& Layout::instance_initial(std::uint32_t index) {
  if (instance_initial_.size() < module_.pous.size()) instance_initial_.resize(module_.pous.size());
  if (instance_initial_[index]) return *instance_initial_[index];
  if (module_.pous[index].owner != ir::Pou::kDeclared) return instance_initial(module_.pous[index].owner);
  const PouLayout& layout = pou(index);
  std::vector<std::byte> bytes(image_.types[layout.instance_type].size);
  const ir::Pou& p = module_.pous[index];
  for (std::uint32_t i = 0; i < p.variables.size(); ++i) {
    if (!p.variables[i].in_frame && layout.offset[i] != kNoIndex)
      initialise(p.variables[i], bytes.data() + layout.offset[i]);
  }
  instance_initial_[index] = std::move(bytes);
  return *instance_initial_[index];
}

}  // namespace plc::bytecode
