#include "runtime/record/ring.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "runtime/record/record.h"

namespace plc::runtime {
namespace {

core::Problem no_memory(int error) {
  return {core::Code::P9001, "no memory for recorded scans: " + std::system_category().message(error), {}};
}

}  // namespace

core::Result<std::unique_ptr<RecordRing>> RecordRing::make(std::size_t bytes, std::size_t most_record_bytes) {
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  most_record_bytes = padded(most_record_bytes);
  const std::size_t capacity = (std::max(bytes, 2 * most_record_bytes) + page - 1) / page * page;
  const int file = ::memfd_create("picard-records", MFD_CLOEXEC);
  if (file < 0) return no_memory(errno);
  std::byte* memory = nullptr;
  if (::ftruncate(file, static_cast<off_t>(capacity)) == 0) {
    // Addresses for both mappings first, which then take their places.
    void* const both = ::mmap(nullptr, 2 * capacity, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (both != MAP_FAILED) {
      memory = static_cast<std::byte*>(both);
      for (std::byte* const at : {memory, memory + capacity}) {
        if (::mmap(at, capacity, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_FIXED | MAP_POPULATE, file, 0) != MAP_FAILED)
          continue;
        const int error = errno;
        ::munmap(memory, 2 * capacity);
        ::close(file);
        return no_memory(error);
      }
    }
  }
  const int error = errno;
  ::close(file);
  if (memory == nullptr) return no_memory(error);
  return std::unique_ptr<RecordRing>(new RecordRing(memory, capacity, most_record_bytes));
}

RecordRing::~RecordRing() { ::munmap(memory_, 2 * capacity_); }

// RT:
std::byte* RecordRing::open() noexcept {
  const std::uint64_t head = head_.load(std::memory_order_relaxed);
  if (head + most_record_bytes_ - tail_seen_ > capacity_) {
    // What the reader gave back it has read.
    tail_seen_ = tail_.load(std::memory_order_acquire);
    if (head + most_record_bytes_ - tail_seen_ > capacity_) return nullptr;
  }
  return memory_ + head % capacity_;
}

// RT:
void RecordRing::close(std::size_t bytes) noexcept {
  head_.store(head_.load(std::memory_order_relaxed) + bytes, std::memory_order_release);
}

std::span<const std::byte> RecordRing::next() noexcept {
  tail_.store(read_, std::memory_order_release);
  if (head_.load(std::memory_order_acquire) == read_) return {};
  const std::byte* const record = memory_ + read_ % capacity_;
  RecordHead head;
  std::memcpy(&head, record, sizeof head);
  read_ += head.bytes;
  return {record, head.bytes};
}

}  // namespace plc::runtime
