#include "runtime/memory/global_table.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "bytecode/paths.h"
#include "runtime/interpreter/operations.h"
#include "runtime/link/link.h"
#include "runtime/memory/exchange.h"
#include "runtime/memory/process_image.h"
#include "runtime/memory/shared_words.h"
#include "stdlib/arithmetic.h"

namespace plc::runtime {
namespace {

using bytecode::ImageField;
using bytecode::ImageType;
using bytecode::TypeKind;
using core::Rep;

/// Room for some thousand writes of a value each between two starts of a task; strings of any size fit once.
constexpr std::size_t kJournalBytes = 64 * 1024;

bool is_leaf(const ImageType& type) { return type.kind != TypeKind::kArray && type.kind != TypeKind::kStruct; }

std::size_t aligned(std::size_t bytes, std::size_t to) { return (bytes + to - 1) / to * to; }

template <class T>
bool within(const ImageType& type, const std::byte* value) noexcept {
  const auto v = static_cast<std::int64_t>(load<T>(value));
  return !type.limited || (v >= type.lower && v <= type.upper);
}

template <class T>
void canonical_in_place(std::byte* value) noexcept {
  store(value, stdlib::canonical(load<T>(value)));
}

void clamp_string(const ImageType& type, std::byte* value) noexcept {
  const auto header = load<core::StringHeader>(value);
  store(value, core::StringHeader{type.capacity, std::min(header.length, type.capacity)});
}

}  // namespace

// RT:
bool normalise(const ImageType& type, std::byte* value) noexcept {
  switch (bytecode::rep_of(type)) {
    case Rep::kBool:
      store<std::uint8_t>(value, load<std::uint8_t>(value) != 0 ? 1 : 0);
      return true;
    case Rep::kI8:
      return within<std::int8_t>(type, value);
    case Rep::kU8:
      return within<std::uint8_t>(type, value);
    case Rep::kI16:
      return within<std::int16_t>(type, value);
    case Rep::kU16:
      return within<std::uint16_t>(type, value);
    case Rep::kI32:
      return within<std::int32_t>(type, value);
    case Rep::kU32:
      return within<std::uint32_t>(type, value);
    case Rep::kI64:
    case Rep::kU64:
      return within<std::int64_t>(type, value);
    case Rep::kF32:
      canonical_in_place<float>(value);
      return true;
    case Rep::kF64:
      canonical_in_place<double>(value);
      return true;
    case Rep::kStr:
    case Rep::kWstr:
      clamp_string(type, value);
      return true;
    case Rep::kRef:
      break;
  }
  return false;
}

GlobalTable::GlobalTable(const bytecode::Image& image, std::span<const std::int32_t> priorities)
    : image_(image),
      size_(image.global_initial.size()),
      task_count_(static_cast<std::uint32_t>(image.tasks.size())),
      owners_(task_count_ + 1) {
  const std::vector<ImageField>& declared = image.types[image.global_type].fields;
  overlapping_bits_ = overlapping_globals(image);
  std::vector<bool> overlapping(declared.size(), false);
  for (const FieldBits& bits : overlapping_bits_) overlapping[bits.field] = true;
  fields_.resize(declared.size());
  for (std::uint32_t task = 0; task < task_count_; ++task) {
    const std::int32_t priority = priorities.empty() ? image.tasks[task].priority : priorities[task];
    priorities_.push_back(priority);
    for (const FieldRange& range : exchanged_ranges(image, image.tasks[task].body)) {
      for (std::uint32_t f = range.first; f < range.first + range.count; ++f) {
        Field& field = fields_[f];
        field.ceiling = std::min(field.ceiling.value_or(priority), priority);
        if (range.exported && (field.exporters.empty() || field.exporters.back() != task)) {
          field.exporters.push_back(task);
        }
      }
    }
  }
  for (std::size_t f = 0; f < fields_.size(); ++f) {
    Field& field = fields_[f];
    field.begin = declared[f].offset;
    field.end = field.begin + image.types[declared[f].type].size;
    field.owner = field.exporters.size() == 1 ? field.exporters.front() : outside();
    field.kind = declared[f].constant         ? Kind::kConstant
                 : overlapping[f]             ? Kind::kOverlapping
                 : field.exporters.size() > 1 ? Kind::kShared
                                              : Kind::kOwned;
    field.first_leaves = static_cast<std::uint32_t>(leaves_.size());
    if (field.kind == Kind::kShared || field.kind == Kind::kOverlapping) add_leaves(declared[f].type, field.begin);
    field.last_leaves = static_cast<std::uint32_t>(leaves_.size());
  }
  if (image.options.coherence != core::Coherence::kWaitFree) common_ = TableMemory(size_);
  for (const bytecode::ImageQueue& queue : image.queues) queues_.emplace_back(image, queue);
  pthread_mutexattr_t attributes;
  pthread_mutexattr_init(&attributes);
  pthread_mutexattr_setprotocol(&attributes, PTHREAD_PRIO_INHERIT);
  pthread_mutex_init(&common_mutex_, &attributes);
  pthread_mutexattr_destroy(&attributes);
  if (!overlapping_bits_.empty()) overlapping_ = TableMemory(size_);
  for (std::uint32_t task = 0; task < task_count_; ++task) {
    owners_[task].stopped = std::make_unique<std::atomic<bool>>(false);
  }
  reset();
}

GlobalTable::~GlobalTable() { pthread_mutex_destroy(&common_mutex_); }

void GlobalTable::add_leaves(std::uint32_t type, std::uint32_t offset) {
  const ImageType& t = image_.types[type];
  if (t.kind == TypeKind::kStruct) {
    for (const ImageField& field : t.fields) add_leaves(field.type, offset + field.offset);
  } else if (t.kind == TypeKind::kArray && !is_leaf(image_.types[t.element])) {
    for (std::uint32_t i = 0; i < t.count; ++i) add_leaves(t.element, offset + i * image_.types[t.element].size);
  } else if (t.kind == TypeKind::kArray) {
    leaves_.push_back({offset, image_.types[t.element].size, t.count, 0, 0});
  } else {
    leaves_.push_back({offset, t.size, 1, 0, 0});
  }
}

// What an owner has is close together in its snapshot, so that publishing costs what it owns and not what lies
// between. Neighbours in the table are neighbours there: they are copied in one piece.
void GlobalTable::place_owned(std::vector<std::size_t>& bytes) {
  const Field* before = nullptr;
  for (Field& field : fields_) {
    const bool owned = field.kind == Kind::kOwned;
    if (owned && before != nullptr && before->owner == field.owner) {
      field.at = before->at + (field.begin - before->begin);
    } else if (owned) {
      // Aligned as in the table.
      field.at = aligned(bytes[field.owner], kTableAlign) + field.begin % kTableAlign;
    }
    if (owned) bytes[field.owner] = field.at + (field.end - field.begin);
    before = owned ? &field : nullptr;
  }
}

void GlobalTable::place_shared(std::vector<std::size_t>& bytes) {
  copies_.clear();
  for (const Field& field : fields_) {
    if (field.kind != Kind::kShared) continue;
    for (std::uint32_t l = field.first_leaves; l < field.last_leaves; ++l) {
      Leaves& leaves = leaves_[l];
      leaves.first_copy = static_cast<std::uint32_t>(copies_.size());
      const auto add_copy = [&](std::uint32_t owner) {
        const std::size_t stamps = bytes[owner] + 8;
        const std::size_t values = stamps + std::size_t{8} * leaves.count;
        copies_.push_back({owner, values, stamps});
        bytes[owner] = aligned(values + std::size_t{leaves.bytes} * leaves.count, 8);
      };
      for (const std::uint32_t task : field.exporters) add_copy(task);
      add_copy(outside());
      leaves.last_copy = static_cast<std::uint32_t>(copies_.size());
    }
  }
}

void GlobalTable::rebuild(std::span<const std::byte> values) {
  std::vector<std::size_t> bytes(owners_.size(), 0);
  place_owned(bytes);
  for (std::size_t o = 0; o < owners_.size(); ++o) owners_[o].shared_at = bytes[o] = aligned(bytes[o], kTableAlign);
  place_shared(bytes);
  std::size_t largest = 8;
  for (const ImageType& type : image_.types) {
    if (type.kind == TypeKind::kString) largest = std::max<std::size_t>(largest, type.size);
  }
  // What was in the old one is not looked at any more.
  arena_ = std::make_unique<Arena>();
  const std::uint32_t readers = task_count_ + 1 + static_cast<std::uint32_t>(views_.size());
  for (std::uint32_t o = 0; o < owners_.size(); ++o) {
    Owner& owner = owners_[o];
    owner.image_from = o < task_count_ ? owner.shared_at : 0;
    owner.image = arena_->take(bytes[o] - owner.image_from);
    owner.snapshot = arena_->make<Snapshot>(*arena_, bytes[o], readers);
    if (o < task_count_) owner.journal = arena_->make<Journal>(*arena_, std::max(kJournalBytes, 4 * largest));
  }
  if (common_.size() != 0 && size_ != 0) std::memcpy(common_.data(), values.data(), size_);
  for (const Leaves& leaves : leaves_) {
    for (std::uint32_t c = leaves.first_copy; c < leaves.last_copy; ++c) {
      std::memcpy(owners_[copies_[c].owner].next(copies_[c].values), values.data() + leaves.offset,
                  std::size_t{leaves.bytes} * leaves.count);
    }
  }
  for (Owner& owner : owners_) {
    if (owner.snapshot->bytes() == 0) continue;
    std::byte* const first = owner.snapshot->begin_write();
    for (const Field& field : fields_) {
      if (field.kind != Kind::kOwned || &owners_[field.owner] != &owner) continue;
      std::memcpy(first + field.at, values.data() + field.begin, field.end - field.begin);
    }
    if (owner.image_from == 0) std::memcpy(owner.image, first, owner.shared_at);
    if (owner.snapshot->bytes() != owner.shared_at) {
      std::memcpy(first + owner.shared_at, owner.next(owner.shared_at), owner.snapshot->bytes() - owner.shared_at);
    }
    owner.snapshot->publish();
  }
  const auto subscribe = [this](View& view) {
    view.held.assign(owners_.size(), nullptr);
    view.readers.clear();
    for (const Owner& owner : owners_) view.readers.push_back(owner.snapshot->subscribe());
  };
  subscribe(outside_view_);
  for (View* const view : views_) subscribe(*view);
  for (Exchange* const exchange : exchanges_) exchange->prepare();
}

void GlobalTable::reset() { reset(image_.global_initial); }

void GlobalTable::reset(std::span<const std::byte> values) {
  for (Queue& queue : queues_) queue.clear();
  if (overlapping_.size() != 0) std::memcpy(overlapping_.data(), values.data(), size_);
  for (std::uint32_t task = 0; task < task_count_; ++task) owners_[task].stopped->store(false);
  rebuild(values);
}

std::optional<std::uint32_t> GlobalTable::owning_task(std::uint32_t field) const {
  const Field& f = fields_[field];
  if (f.kind != Kind::kOwned || f.owner >= task_count_) return std::nullopt;
  return f.owner;
}

void GlobalTable::task_stopped(std::uint32_t task) noexcept {
  owners_[task].stopped->store(true, std::memory_order_relaxed);
}

void GlobalTable::add_view(View& view) {
  std::vector<std::byte> values(size_);
  copy(values.data());
  views_.push_back(&view);
  rebuild(values);
}

std::vector<std::uint32_t> GlobalTable::owners_of_trigger(std::uint32_t task) const {
  const auto trigger = bytecode::find_global(image_, image_.tasks[task].single);
  if (image_.tasks[task].single.empty() || !trigger) return {};
  const Field& field = field_at(trigger->offset);
  if (field.kind == Kind::kOwned) return {field.owner};
  std::vector<std::uint32_t> owners;
  for (std::uint32_t l = field.first_leaves; l < field.last_leaves; ++l) {
    for (std::uint32_t c = leaves_[l].first_copy; c < leaves_[l].last_copy; ++c) owners.push_back(copies_[c].owner);
  }
  std::sort(owners.begin(), owners.end());
  owners.erase(std::unique(owners.begin(), owners.end()), owners.end());
  return owners;
}

std::uint32_t GlobalTable::claim(std::span<const std::uint32_t> fields) {
  std::vector<std::byte> values(size_);
  copy(values.data());
  const auto owner = static_cast<std::uint32_t>(owners_.size());
  owners_.emplace_back();
  for (const std::uint32_t field : fields) {
    fields_[field].owner = owner;
    // A write to what shares its bits would be a write to it.
    for_each_overlapping(field, [&](std::uint32_t other) { fields_[other].owner = owner; });
  }
  rebuild(values);
  return owner;
}

const GlobalTable::Field& GlobalTable::field_at(std::uint32_t offset) const noexcept {
  const auto after = std::upper_bound(fields_.begin(), fields_.end(), offset,
                                      [](std::uint32_t o, const Field& field) { return o < field.begin; });
  return *(after - 1);
}

const GlobalTable::Leaves& GlobalTable::leaves_at(const Field& field, std::uint32_t offset) const noexcept {
  const auto begin = leaves_.begin() + field.first_leaves;
  const auto after = std::upper_bound(begin, leaves_.begin() + field.last_leaves, offset,
                                      [](std::uint32_t o, const Leaves& leaves) { return o < leaves.offset; });
  return *(after == begin ? begin : after - 1);
}

template <class Visit>
void GlobalTable::for_each_overlapping(std::uint32_t field, Visit visit) const {
  for (const FieldBits& own : overlapping_bits_) {
    if (own.field != field) continue;
    for (const FieldBits& other : overlapping_bits_) {
      const bool meets = other.area == own.area && other.first_bit < own.first_bit + own.bits &&
                         own.first_bit < other.first_bit + other.bits;
      if (meets && other.field != field) visit(other.field);
    }
  }
}

// RT:
void GlobalTable::hold(View& view) noexcept {
  for (std::size_t o = 0; o < view.readers.size(); ++o) view.held[o] = view.readers[o].acquire();
}

// RT:
void GlobalTable::read_shared(Held held, const Leaves& leaves, std::uint32_t index, std::byte* to) const noexcept {
  const std::byte* newest = nullptr;
  std::uint64_t stamp = 0;
  for (std::uint32_t c = leaves.first_copy; c < leaves.last_copy; ++c) {
    const std::byte* const snapshot = held[copies_[c].owner];
    const auto written = load<std::uint64_t>(snapshot + copies_[c].stamps + std::size_t{8} * index);
    if (newest != nullptr && written <= stamp) continue;
    newest = snapshot + copies_[c].values + std::size_t{leaves.bytes} * index;
    stamp = written;
  }
  std::memcpy(to, newest, leaves.bytes);
}

// RT:
void GlobalTable::read_held(Held held, std::uint32_t offset, std::uint32_t bytes, std::byte* to) const noexcept {
  const std::uint32_t end = offset + bytes;
  for (const Field* field = &field_at(offset); field < fields_.data() + fields_.size() && field->begin < end; ++field) {
    const std::uint32_t first = std::max(field->begin, offset);
    std::uint32_t last = std::min(field->end, end);
    if (first >= last) continue;
    std::byte* const out = to + (first - offset);
    switch (field->kind) {
      case Kind::kConstant:
        std::memcpy(out, image_.global_initial.data() + first, last - first);
        break;
      case Kind::kOwned: {
        const std::byte* const piece = held[field->owner] + field->at;
        const std::uint32_t begin = field->begin;
        // Neighbours of the same owner in one piece: what drivers and servers read is mostly side by side.
        for (const Field* next = field + 1; next < fields_.data() + fields_.size() && next->begin < end &&
                                            next->kind == Kind::kOwned && next->owner == field->owner;
             ++next) {
          last = std::max(last, std::min(next->end, end));
          field = next;
        }
        std::memcpy(out, piece + (first - begin), last - first);
        break;
      }
      case Kind::kOverlapping:
        copy_from_shared(out, overlapping_.data() + first, last - first);
        break;
      case Kind::kShared:
        // Whole leaves only: parts of one are not read.
        for (const Leaves* leaves = &leaves_at(*field, first);
             leaves < leaves_.data() + field->last_leaves && leaves->offset < last; ++leaves) {
          const std::uint32_t skipped = first > leaves->offset ? first - leaves->offset : 0;
          for (std::uint32_t i = (skipped + leaves->bytes - 1) / leaves->bytes;
               i < leaves->count && leaves->offset + (i + 1) * leaves->bytes <= last; ++i) {
            read_shared(held, *leaves, i, to + (leaves->offset + i * leaves->bytes - offset));
          }
        }
        break;
    }
  }
}

// RT:
GlobalTable::Stamped GlobalTable::stamped(std::uint32_t owner, const Leaves& leaves, std::uint32_t index) noexcept {
  std::uint32_t c = leaves.first_copy;
  while (copies_[c].owner != owner) ++c;
  Owner& own = owners_[owner];
  return {own.next(copies_[c].values + std::size_t{leaves.bytes} * index),
          own.next(copies_[c].stamps + std::size_t{8} * index), own.next(copies_[c].stamps - 8)};
}

// RT:
std::uint64_t GlobalTable::version(Held held, const Leaves& leaves) const noexcept {
  // A sum, not the highest: an owner may publish a change after others published later ones. None ever falls.
  std::uint64_t version = 0;
  for (std::uint32_t c = leaves.first_copy; c < leaves.last_copy; ++c) {
    version += load<std::uint64_t>(held[copies_[c].owner] + copies_[c].stamps - 8);
  }
  return version;
}

void GlobalTable::publish_image(std::uint32_t o) noexcept {
  Owner& owner = owners_[o];
  if (owner.image_from != 0 || owner.snapshot->bytes() == 0) return;
  std::memcpy(owner.snapshot->begin_write(), owner.image, owner.snapshot->bytes());
  owner.snapshot->publish();
}

void GlobalTable::read(std::uint32_t offset, std::uint32_t bytes, std::byte* to) const {
  const std::lock_guard lock(outside_mutex_);
  const Field& field = field_at(offset);
  if (field.kind == Kind::kOwned) {
    // The usual case: one snapshot.
    outside_view_.held[field.owner] = outside_view_.readers[field.owner].acquire();
    read_held(outside_view_.held, offset, bytes, to);
    return;
  }
  hold(outside_view_);
  read_held(outside_view_.held, offset, bytes, to);
}

void GlobalTable::copy(std::byte* to) const {
  const std::lock_guard lock(outside_mutex_);
  if (size_ == 0) return;
  std::memcpy(to, image_.global_initial.data(), size_);  // what lies between fields
  hold(outside_view_);
  read_held(outside_view_.held, 0, static_cast<std::uint32_t>(size_), to);
}

// RT:
bool GlobalTable::merge(std::byte* place, std::uint32_t type, const std::byte* value,
                        const std::byte* mask) const noexcept {
  const ImageType& t = image_.types[type];
  if (mask == nullptr && t.kind == TypeKind::kString) {
    std::memcpy(place, value, t.size);
    return normalise(t, place);
  }
  std::byte merged[8];
  for (std::uint32_t i = 0; i < t.size; ++i) {
    merged[i] = mask == nullptr ? value[i] : (place[i] & ~mask[i]) | (value[i] & mask[i]);
  }
  if (!normalise(t, merged)) return false;
  std::memcpy(place, merged, t.size);
  return true;
}

void GlobalTable::write_overlapping(const GlobalWrite& write) noexcept {
  const std::uint32_t bytes = image_.types[write.type].size;
  std::byte* const shared = overlapping_.data() + write.offset;
  std::byte before[8] = {};
  std::byte value[8];
  // Only numbers, bit strings and BOOLs share bits (overlapping_globals()): nothing longer may ever come this far.
  if (bytes > sizeof before) return;
  // A task may export the value meanwhile; some rounds later it is this write's turn in any case.
  for (int round = 0; round < 16; ++round) {
    copy_from_shared(before, shared, bytes);
    std::memcpy(value, before, sizeof value);
    if (!merge(value, write.type, write.value, write.mask)) return;
    if (replace_shared(shared, before, value, bytes)) return;
  }
  copy_to_shared(shared, value, bytes);
}

void GlobalTable::set_forced(std::vector<std::uint32_t> offsets) {
  std::sort(offsets.begin(), offsets.end());
  const std::lock_guard lock(outside_mutex_);
  forced_ = std::move(offsets);
}

bool GlobalTable::is_forced(std::uint32_t offset) const {
  const std::lock_guard lock(outside_mutex_);
  return std::binary_search(forced_.begin(), forced_.end(), offset);
}

WriteResult GlobalTable::write(std::span<const GlobalWrite> batch) {
  const std::lock_guard lock(outside_mutex_);
  struct Wanted {
    std::size_t room = 0;
    std::size_t largest = 0;
  };
  std::vector<Wanted> wanted(task_count_);
  const auto entry_of = [this](const GlobalWrite& w) {
    return Journal::Entry{w.offset, w.type, image_.types[w.type].size, w.mask != nullptr};
  };
  for (const GlobalWrite& w : batch) {
    const Field& field = field_at(w.offset);
    if (!writable(static_cast<std::uint32_t>(&field - fields_.data()))) return WriteResult::kRefused;
    if (image_.types[w.type].kind == TypeKind::kRef) return WriteResult::kRefused;
    if (std::binary_search(forced_.begin(), forced_.end(), w.offset)) return WriteResult::kRefused;
    if (field.kind != Kind::kOwned || field.owner >= task_count_) continue;
    if (owners_[field.owner].stopped->load(std::memory_order_relaxed)) return WriteResult::kBusy;
    const std::size_t room = Journal::room_for(entry_of(w));
    wanted[field.owner].room += room;
    wanted[field.owner].largest = std::max(wanted[field.owner].largest, room);
  }
  for (std::uint32_t task = 0; task < task_count_; ++task) {
    if (wanted[task].room != 0 && !owners_[task].journal->fits(wanted[task].room, wanted[task].largest)) {
      return WriteResult::kBusy;
    }
  }
  Owner& own = owners_[outside()];
  const std::uint64_t before = stamp_.load(std::memory_order_relaxed);
  bool published = false;
  bool holding = false;
  for (const GlobalWrite& w : batch) {
    const Field& field = field_at(w.offset);
    if (field.kind == Kind::kOverlapping) {
      write_overlapping(w);
    } else if (field.kind == Kind::kShared) {
      if (!holding) hold(outside_view_);
      holding = true;
      const Leaves& leaves = leaves_at(field, w.offset);
      const std::uint32_t index = (w.offset - leaves.offset) / leaves.bytes;
      const Stamped place = stamped(outside(), leaves, index);
      // A masked write changes the newest value, or what this batch has made of it.
      if (load<std::uint64_t>(place.stamp) <= before) read_shared(outside_view_.held, leaves, index, place.value);
      if (merge(place.value, w.type, w.value, w.mask)) {
        const std::uint64_t stamp = next_stamp();
        store(place.stamp, stamp);
        store(place.newest, stamp);
      }
      published = true;
    } else if (field.owner == outside()) {
      merge(own.next(field.at + (w.offset - field.begin)), w.type, w.value, w.mask);
      published = true;
    } else {
      owners_[field.owner].journal->append(entry_of(w), w.value, w.mask);
    }
  }
  for (std::uint32_t task = 0; task < task_count_; ++task) {
    if (wanted[task].room != 0) owners_[task].journal->commit();
  }
  if (published) publish_image(outside());
  return WriteResult::kDone;
}

bool GlobalTable::writable(std::uint32_t field) const {
  const Field& f = fields_[field];
  return f.kind != Kind::kConstant && f.owner <= outside();
}

bool GlobalTable::claimable(std::uint32_t field) const {
  const Field& f = fields_[field];
  bool free = f.kind != Kind::kConstant && f.exporters.empty() && f.owner == outside();
  // A write to what shares its bits writes it.
  for_each_overlapping(field, [&](std::uint32_t other) { free = free && fields_[other].exporters.empty(); });
  return free;
}

std::vector<std::uint32_t> GlobalTable::exporters(std::uint32_t field) const { return fields_[field].exporters; }

}  // namespace plc::runtime
