#include "runtime/memory/wait_free_exchange.h"

#include <algorithm>
#include <cstring>

#include "runtime/memory/shared_words.h"
#include "runtime/record/recorder.h"

namespace plc::runtime {
WaitFreeExchange::WaitFreeExchange(GlobalTable& globals, std::uint32_t task, std::byte* local)
    : globals_(globals), local_(local), task_(task) {
  globals_.attach(*this);
}

WaitFreeExchange::~WaitFreeExchange() { globals_.detach(*this); }

std::uint32_t WaitFreeExchange::add_range(std::uint32_t first, std::uint32_t count, Use use) {
  Range range;
  range.first = first;
  range.count = count;
  range.use = use;
  ranges_.push_back(range);
  return static_cast<std::uint32_t>(ranges_.size() - 1);
}

void WaitFreeExchange::prepare() {
  std::vector<Slice> slices;
  std::vector<Stretch> stretches;
  std::vector<std::uint32_t> all_leaves;
  std::vector<std::uint32_t> sources;
  const auto reads = [&sources](std::uint32_t owner) {
    if (std::find(sources.begin(), sources.end(), owner) == sources.end()) sources.push_back(owner);
  };
  std::size_t exports = 0;
  bool by_leaf = false;
  for (const Range& range : ranges_) {
    Slice slice;
    slice.first_stretch = static_cast<std::uint32_t>(stretches.size());
    slice.first_leaves = static_cast<std::uint32_t>(all_leaves.size());
    const bool to_export = range.use == Use::kExport;
    bool neighbour = false;  // the field before this one is the end of the last stretch
    for (std::uint32_t f = range.first; f < range.first + range.count && range.use != Use::kRaise; ++f) {
      const GlobalTable::Field& field = globals_.fields_[f];
      const bool owned = field.kind == GlobalTable::Kind::kOwned;
      const bool copied = owned && (field.owner == task_) == to_export && field.begin != field.end;
      if (copied) {
        // What other tasks export comes from the common table, where there is one.
        if (!to_export && (globals_.common_.size() == 0 || field.owner >= globals_.task_count_)) reads(field.owner);
        if (neighbour && stretches.back().owner == field.owner) {
          stretches.back().end = field.end;
        } else {
          stretches.push_back({field.owner, field.begin, field.end, field.at});
        }
      }
      neighbour = copied;
      if (owned || field.kind == GlobalTable::Kind::kConstant || field.begin == field.end) continue;
      by_leaf = true;
      for (std::uint32_t l = field.first_leaves; l < field.last_leaves; ++l) {
        all_leaves.push_back(l);
        const GlobalTable::Leaves& leaves = globals_.leaves_[l];
        for (std::uint32_t c = leaves.first_copy; c < leaves.last_copy; ++c) reads(globals_.copies_[c].owner);
      }
    }
    slice.last_stretch = static_cast<std::uint32_t>(stretches.size());
    slice.last_leaves = static_cast<std::uint32_t>(all_leaves.size());
    if (range.use == Use::kImport) {
      for (std::uint32_t s = slice.first_stretch; s < slice.last_stretch; ++s)
        slice.bytes += stretches[s].end - stretches[s].begin;
      // Of each leaf all copies, with their stamps.
      for (std::uint32_t l = slice.first_leaves; l < slice.last_leaves; ++l) {
        const GlobalTable::Leaves& leaves = globals_.leaves_[all_leaves[l]];
        slice.bytes += (std::size_t{leaves.bytes} + 8) * leaves.count * (leaves.last_copy - leaves.first_copy + 1);
      }
    }
    slices.push_back(slice);
    exports += to_export ? 1 : 0;
  }
  in_parts_ = exports > 1;
  Arena& arena = *globals_.arena_;
  const GlobalTable::Owner& own = globals_.owners_[task_];
  own_ = own.snapshot;
  journal_ = own.journal;
  shared_image_ = own.image;
  owned_bytes_ = own.shared_at;
  shared_bytes_ = own.snapshot->bytes() - own.shared_at;
  const std::byte* const first = arena.take(0);
  slices_ = arena.copy(std::span<const Slice>(slices));
  stretches_ = arena.copy(std::span<const Stretch>(stretches));
  leaves_ = arena.copy(std::span<const std::uint32_t>(all_leaves));
  held_ = arena.array<const std::byte*>(globals_.owners_.size());
  for (const std::uint32_t owner : globals_.owners_of_trigger(task_)) reads(owner);
  sources_ = arena.array<Source>(sources.size());
  for (std::size_t i = 0; i < sources.size(); ++i) {
    sources_[i] = {sources[i], globals_.owners_[sources[i]].snapshot->subscribe()};
  }
  const std::byte* const last = arena.take(0);
  used_ = last > first && last - first < kMostUsed ? std::span(first, last) : std::span<const std::byte>();
  if (by_leaf && shadow_.size() == 0) shadow_ = TableMemory(globals_.size());
  reset();
}

void WaitFreeExchange::reset() {
  if (shadow_.size() != 0) std::memcpy(shadow_.data(), local_, globals_.size());
  imported_.assign(globals_.leaves_.size(), kNotImported);
  turn_.store(Turn::kExchanging, std::memory_order_relaxed);
}

// RT:
void WaitFreeExchange::apply(const Journal::Entry& entry, const std::byte* value, const std::byte* mask) noexcept {
  globals_.merge(local_ + entry.offset, entry.type, value, mask);
  if (recorder_ != nullptr) [[unlikely]]
    recorder_->written(entry.offset, entry.bytes);
}

// RT:
void WaitFreeExchange::take_in(std::uint32_t at, const std::byte* from, std::uint32_t bytes) noexcept {
  if (recorder_ == nullptr) [[likely]] {
    std::memcpy(local_ + at, from, bytes);
  } else {
    recorder_->copy(at, from, bytes);
  }
}

// RT:
void WaitFreeExchange::next_import() noexcept {
  if (recorder_ != nullptr) [[unlikely]]
    recorder_->next_import();
}

// RT: never inlined, so that expect() warms the very code that begin() is going to run.
[[gnu::hot, gnu::noinline]] void WaitFreeExchange::take() noexcept {
  // What has gone cold, and what other processors have written, is fetched all at once.
  for (std::size_t at = 0; at < used_.size(); at += kTableAlign) __builtin_prefetch(used_.data() + at);
  for (const Source& source : sources_) source.reader.fetch();
  own_->fetch();
  writing_ = nullptr;
  publishing_ = false;
  stamp_ = 0;
  if (journal_->pending()) {
    journal_->drain([this](const Journal::Entry& entry, const std::byte* value, const std::byte* mask) noexcept {
      apply(entry, value, mask);
    });
  }
  for (Source& source : sources_) held_[source.owner] = source.reader.acquire();
  own_->choose();
}

// RT:
[[gnu::hot]] void WaitFreeExchange::begin() noexcept {
  take();
  // Release: the thread that revokes the task sees what its last publication left.
  turn_.store(Turn::kComputing, std::memory_order_release);
}

// RT: what it leaves in the local copy, the import of the cycle writes anew.
[[gnu::hot]] void WaitFreeExchange::expect(std::size_t bytes) noexcept {
  take();
  for (std::uint32_t range = 0; range < slices_.size(); ++range) {
    const std::size_t reads = slices_[range].bytes;
    if (reads == 0 || reads > bytes) continue;
    bytes -= reads;
    bring(range);
  }
}

// RT:
[[gnu::hot]] bool WaitFreeExchange::may_publish() noexcept {
  if (publishing_) return true;
  Turn turn = Turn::kComputing;
  publishing_ = turn_.compare_exchange_strong(turn, Turn::kExchanging, std::memory_order_relaxed);
  return publishing_;
}

bool WaitFreeExchange::revoke() noexcept {
  Turn turn = Turn::kComputing;
  return turn_.compare_exchange_strong(turn, Turn::kRevoked, std::memory_order_acquire, std::memory_order_relaxed);
}

// RT:
void WaitFreeExchange::import_leaves(std::uint32_t index) noexcept {
  const GlobalTable::Leaves& leaves = globals_.leaves_[index];
  const std::uint32_t total = leaves.bytes * leaves.count;
  std::byte* const shadow = shadow_.data() + leaves.offset;
  if (leaves.first_copy == leaves.last_copy) {
    copy_from_shared(shadow, globals_.overlapping_.data() + leaves.offset, total);
  } else if (const std::uint64_t version = globals_.version(held_, leaves); version != imported_[index]) {
    for (std::uint32_t i = 0; i < leaves.count; ++i) {
      globals_.read_shared(held_, leaves, i, shadow + std::size_t{leaves.bytes} * i);
    }
    imported_[index] = version;
  }
  // Also where nothing is new: what a cycle that faulted changed and did not export is undone.
  take_in(leaves.offset, shadow, total);
}

// RT: not inlined: see take().
[[gnu::hot, gnu::noinline]] void WaitFreeExchange::bring(std::uint32_t range) noexcept {
  for (const Stretch& s : stretches(range)) take_in(s.begin, held(s), s.end - s.begin);
  for (const std::uint32_t l : leaves(range)) import_leaves(l);
}

// RT:
[[gnu::hot]] void WaitFreeExchange::import(std::uint32_t range) noexcept {
  next_import();
  bring(range);
}

// RT:
[[gnu::hot]] void WaitFreeExchange::open_snapshot() noexcept {
  writing_ = own_->begin_write();
  // A body that leaves a range out this time publishes that range as it was.
  if (in_parts_) std::memcpy(writing_, own_->published(), owned_bytes_);
}

// RT:
void WaitFreeExchange::export_leaves(const GlobalTable::Leaves& leaves) noexcept {
  std::byte* const local = local_ + leaves.offset;
  std::byte* const shadow = shadow_.data() + leaves.offset;
  if (std::memcmp(local, shadow, std::size_t{leaves.bytes} * leaves.count) == 0) return;
  for (std::uint32_t i = 0; i < leaves.count; ++i) {
    const std::size_t at = std::size_t{leaves.bytes} * i;
    if (std::memcmp(local + at, shadow + at, leaves.bytes) == 0) continue;
    if (leaves.first_copy == leaves.last_copy) {
      copy_to_shared(globals_.overlapping_.data() + leaves.offset + at, local + at, leaves.bytes);
    } else {
      if (writing_ == nullptr) open_snapshot();
      if (stamp_ == 0) stamp_ = globals_.next_stamp();
      const GlobalTable::Stamped place = globals_.stamped(task_, leaves, i);
      std::memcpy(place.value, local + at, leaves.bytes);
      std::memcpy(place.stamp, &stamp_, sizeof stamp_);
      std::memcpy(place.newest, &stamp_, sizeof stamp_);
    }
    std::memcpy(shadow + at, local + at, leaves.bytes);
  }
}

// RT:
[[gnu::hot]] void WaitFreeExchange::export_range(std::uint32_t range) noexcept {
  if (!may_publish()) return;
  const std::span<const Stretch> all = stretches(range);
  if (writing_ == nullptr && !all.empty()) open_snapshot();
  for (const Stretch& s : all) {
    std::memcpy(writing_ + s.at, local_ + s.begin, s.end - s.begin);
  }
  for (const std::uint32_t l : leaves(range)) export_leaves(globals_.leaves_[l]);
}

// RT:
[[gnu::hot]] bool WaitFreeExchange::end() noexcept {
  const bool mine = may_publish();
  if (writing_ != nullptr) {
    if (shared_bytes_ != 0) std::memcpy(writing_ + owned_bytes_, shared_image_, shared_bytes_);
    own_->publish();
  }
  return mine;
}

// RT:
void WaitFreeExchange::publish_safe(std::span<const GlobalWrite> values) noexcept {
  GlobalTable::Owner& own = globals_.owners_[task_];
  Snapshot& snapshot = *own.snapshot;
  std::byte* const next = snapshot.begin_write();
  std::memcpy(next, snapshot.published(), own.shared_at);
  const std::uint64_t stamp = globals_.next_stamp();
  for (const GlobalWrite& w : values) {
    const GlobalTable::Field& field = globals_.field_at(w.offset);
    if (field.kind == GlobalTable::Kind::kOwned && field.owner == task_) {
      globals_.merge(next + field.at + (w.offset - field.begin), w.type, w.value, w.mask);
    } else if (field.kind == GlobalTable::Kind::kShared) {
      const GlobalTable::Leaves& leaves = globals_.leaves_at(field, w.offset);
      const GlobalTable::Stamped place = globals_.stamped(task_, leaves, (w.offset - leaves.offset) / leaves.bytes);
      if (!globals_.merge(place.value, w.type, w.value, w.mask)) continue;
      std::memcpy(place.stamp, &stamp, sizeof stamp);
      std::memcpy(place.newest, &stamp, sizeof stamp);
    } else if (field.kind == GlobalTable::Kind::kOverlapping) {
      globals_.write_overlapping(w);
    }
  }
  const std::size_t shared = snapshot.bytes() - own.shared_at;
  if (shared != 0) std::memcpy(next + own.shared_at, own.image, shared);
  snapshot.publish();
}

// RT:
bool WaitFreeExchange::read_bool(std::uint32_t offset) noexcept {
  for (Source& source : sources_) held_[source.owner] = source.reader.acquire();
  std::byte value{};
  globals_.read_held(held_, offset, 1, &value);
  return value != std::byte{0};
}

}  // namespace plc::runtime
