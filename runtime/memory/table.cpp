#include "runtime/memory/table.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

namespace plc::runtime {
namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20;

constexpr std::size_t round_up(std::size_t value, std::size_t to) { return (value + to - 1) / to * to; }

void copy_bytes(std::byte* to, std::span<const std::byte> from) {
  if (!from.empty()) std::memcpy(to, from.data(), from.size());
}

}  // namespace

TableMemory::TableMemory(std::size_t bytes, bool huge_pages)
    : size_(std::max(round_up(bytes, kTableAlign), kTableAlign)) {
  if (huge_pages) {
    mapped_ = round_up(size_, kHugePage);
    void* const at = mmap(nullptr, mapped_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (at != MAP_FAILED) {
      // Advice only: without huge pages the table works all the same.
      static_cast<void>(madvise(at, mapped_, MADV_HUGEPAGE));
      data_ = static_cast<std::byte*>(at);
      std::memset(data_, 0, size_);
      return;
    }
    mapped_ = 0;
  }
  data_ = static_cast<std::byte*>(::operator new (size_, std::align_val_t{kTableAlign}));
  std::memset(data_, 0, size_);
}

TableMemory::~TableMemory() {
  if (data_ == nullptr) return;
  if (mapped_ != 0) {
    munmap(data_, mapped_);
  } else {
    ::operator delete (data_, std::align_val_t{kTableAlign});
  }
}

TableMemory::TableMemory(TableMemory&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)),
      size_(std::exchange(other.size_, 0)),
      mapped_(std::exchange(other.mapped_, 0)) {}

TableMemory& TableMemory::operator=(TableMemory&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  std::swap(mapped_, other.mapped_);
  return *this;
}

TaskLayout lay_out(const bytecode::Image& image, std::uint32_t body, std::span<const std::uint8_t> reached) {
  TaskLayout layout;
  std::uint64_t next = 0;
  const auto part = [&next](std::size_t bytes) {
    const std::uint64_t at = next;
    next = round_up(next + bytes, kTableAlign);
    return static_cast<std::uint32_t>(at);
  };
  layout.global_bytes = static_cast<std::uint32_t>(image.global_initial.size());
  part(image.global_initial.size());
  layout.constants = part(image.const_bytes.size());
  layout.instance = part(image.pous[body].instance_initial.size());
  layout.frames.assign(image.pous.size(), TaskLayout::kAbsent);
  for (std::size_t i = 0; i < image.pous.size(); ++i) {
    if (reached[i] != 0) layout.frames[i] = part(image.pous[i].frame_initial.size());
  }
  layout.total = next;
  layout.scratch = static_cast<std::uint32_t>(next);
  return layout;
}

TaskTable::TaskTable(const bytecode::Image& image, std::uint32_t body, TaskLayout layout, bool huge_pages)
    : layout_(std::move(layout)), memory_(layout_.total + kScratchBytes, huge_pages) {
  reset(image, body);
}

void TaskTable::reset(const bytecode::Image& image, std::uint32_t body) {
  std::byte* const table = memory_.data();
  copy_bytes(table, image.global_initial);
  copy_bytes(table + layout_.constants, image.const_bytes);
  copy_bytes(table + layout_.instance, image.pous[body].instance_initial);
  for (std::size_t i = 0; i < image.pous.size(); ++i) {
    if (layout_.frames[i] != TaskLayout::kAbsent) copy_bytes(table + layout_.frames[i], image.pous[i].frame_initial);
  }
}

}  // namespace plc::runtime
