#include "runtime/record/ring.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>
#include <system_error>

#include "runtime/record/record.h"

namespace plc::runtime {
namespace {

core::Problem no_memory(int error) {
  return {core::Code::P9001, "no memory for recorded scans: " + std::system_category().message(error), {}};
}

std::size_t page_bytes() { return static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)); }
std::size_t capacity_of(std::size_t bytes, std::size_t most_record_bytes) {
  const std::size_t page = page_bytes();
  return (std::max(bytes, 2 * padded(most_record_bytes)) + page - 1) / page * page;
}

}  // namespace

std::size_t RecordRing::file_bytes(std::size_t bytes, std::size_t most_record_bytes) {
  return capacity_of(bytes, most_record_bytes) + page_bytes();
}

core::Result<std::unique_ptr<RecordRing>> RecordRing::make(std::size_t bytes, std::size_t most_record_bytes, int file) {
  const std::size_t capacity = capacity_of(bytes, most_record_bytes);
  if (file < 0) {
    const int own = ::memfd_create("picard-records", MFD_CLOEXEC);
    if (own < 0) return no_memory(errno);
    // WHY not ftruncate(): memory that there is not would be noticed by the cycle that writes to it.
    const int error = ::posix_fallocate(own, 0, static_cast<off_t>(file_bytes(bytes, most_record_bytes)));
    auto made =
        error == 0 ? make(bytes, most_record_bytes, own) : core::Result<std::unique_ptr<RecordRing>>(no_memory(error));
    ::close(own);
    return made;
  }
  // Addresses for all mappings first, which then take their places.
  const std::size_t all = 2 * capacity + page_bytes();
  void* const reserved = ::mmap(nullptr, all, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (reserved == MAP_FAILED) return no_memory(errno);
  auto* const memory = static_cast<std::byte*>(reserved);
  struct Part {
    std::size_t at, bytes, offset;
  };
  for (const Part& part :
       {Part{0, capacity, 0}, Part{capacity, capacity, 0}, Part{2 * capacity, page_bytes(), capacity}}) {
    if (::mmap(memory + part.at, part.bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_FIXED | MAP_POPULATE, file,
               static_cast<off_t>(part.offset)) != MAP_FAILED) {
      continue;
    }
    const int error = errno;
    ::munmap(memory, all);
    return no_memory(error);
  }
  auto* const end = new (memory + 2 * capacity) RingEnd;
  end->capacity = capacity;
  end->most_record_bytes = padded(most_record_bytes);
  return std::unique_ptr<RecordRing>(new RecordRing(memory, end));
}

RecordRing::~RecordRing() { ::munmap(memory_, 2 * capacity_ + page_bytes()); }

// RT:
std::byte* RecordRing::open() noexcept {
  const std::uint64_t head = end_->head.load(std::memory_order_relaxed);
  if (head + most_record_bytes_ - tail_seen_ > capacity_) {
    // What the reader gave back it has read.
    tail_seen_ = end_->tail.load(std::memory_order_acquire);
    if (head + most_record_bytes_ - tail_seen_ > capacity_) return nullptr;
  }
  return memory_ + head % capacity_;
}

// RT:
void RecordRing::close(std::size_t bytes) noexcept {
  end_->head.store(end_->head.load(std::memory_order_relaxed) + bytes, std::memory_order_release);
}

std::span<const std::byte> RecordRing::next() noexcept {
  end_->tail.store(read_, std::memory_order_release);
  if (end_->head.load(std::memory_order_acquire) == read_) return {};
  const std::byte* const record = memory_ + read_ % capacity_;
  RecordHead head;
  std::memcpy(&head, record, sizeof head);
  read_ += head.bytes;
  return {record, head.bytes};
}

}  // namespace plc::runtime
