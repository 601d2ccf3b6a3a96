#include "native/code_memory.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace plc::native {
namespace {

/// Reach of a 32-bit distance, with a page to spare at either end.
constexpr std::uint64_t kReach = (std::uint64_t{1} << 31) - 8192;

std::size_t round_up(std::size_t value, std::size_t to) { return (value + to - 1) / to * to; }
std::size_t page() { return static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)); }

core::Problem refused(const char* call) {
  return {core::Code::P9001, fmt::format("no memory for native code: {}: {}", call, std::strerror(errno)), {}};
}

/// Addresses at exactly this place, or null.
std::byte* reserve_at(std::uint64_t address, std::size_t bytes) {
  // Without access, so that mlockall() does not make pages of them.
  void* const wanted = reinterpret_cast<void*>(address);  // NOLINT(performance-no-int-to-ptr): places are numbers here
  void* const at =
      ::mmap(wanted, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | MAP_FIXED_NOREPLACE, -1, 0);
  if (at == MAP_FAILED) return nullptr;
  if (at == wanted) return static_cast<std::byte*>(at);
  ::munmap(at, bytes);
  return nullptr;
}

int make_file() {
#ifdef MFD_EXEC
  // Kernels that may forbid executable files in memory want to be told of them.
  const int told = ::memfd_create("picard-code", MFD_CLOEXEC | MFD_EXEC);
  if (told >= 0) return told;
#endif
  return ::memfd_create("picard-code", MFD_CLOEXEC);
}

}  // namespace

CodeMemory::~CodeMemory() {
  if (at_ != nullptr) ::munmap(at_, size_);
}
CodeMemory::CodeMemory(CodeMemory&& other) noexcept
    : at_(std::exchange(other.at_, nullptr)), size_(std::exchange(other.size_, 0)) {}
CodeMemory& CodeMemory::operator=(CodeMemory&& other) noexcept {
  std::swap(at_, other.at_);
  std::swap(size_, other.size_);
  return *this;
}

core::Result<CodeMemory> CodeMemory::reserve(std::span<const std::byte> data, std::size_t bytes) {
  const std::size_t size = round_up(bytes, page());
  const auto begin = reinterpret_cast<std::uint64_t>(data.data());
  const std::uint64_t end = begin + data.size();
  CodeMemory memory;
  // Below the data first: above a heap there is what it grows into. The nearest places are mostly taken.
  constexpr std::uint64_t kStep = std::uint64_t{8} << 20;
  for (std::uint64_t away = kStep; size + data.size() + away < kReach && memory.at_ == nullptr; away += kStep) {
    const std::uint64_t below = (begin - away - size) / page() * page();
    if (begin > away + size) memory.at_ = reserve_at(below, size);
    if (memory.at_ == nullptr) memory.at_ = reserve_at(round_up(end + away, page()), size);
  }
  if (memory.at_ == nullptr) {
    return core::Problem{core::Code::P9001,
                         fmt::format("no addresses for {} bytes of native code within reach of {} bytes of variables",
                                     size, data.size()),
                         "native code and the variables of its task share 2 GiB of addresses"};
  }
  memory.size_ = size;
  return memory;
}

core::Result<const std::byte*> CodeMemory::fill(std::span<const std::byte> code) {
  const std::size_t size = round_up(code.size(), page());
  const int file = make_file();
  if (file < 0) return refused("memfd_create");
  const auto give_up = [&](const char* call) {
    const core::Problem problem = refused(call);
    ::close(file);
    return problem;
  };
  if (::ftruncate(file, static_cast<off_t>(size)) != 0) return give_up("ftruncate");
  void* const writable = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  if (writable == MAP_FAILED) return give_up("mmap");
  std::memcpy(writable, code.data(), code.size());
  ::munmap(writable, size);
  void* const at = ::mmap(at_, size, PROT_READ | PROT_EXEC, MAP_SHARED | MAP_FIXED | MAP_POPULATE, file, 0);
  if (at == MAP_FAILED) return give_up("mmap of executable pages");
  ::close(file);
  // Written through other addresses: processors whose caches of instructions do not look must be told.
  __builtin___clear_cache(static_cast<char*>(at), static_cast<char*>(at) + size);
  if (size < size_) ::munmap(at_ + size, size_ - size);
  size_ = size;
  return static_cast<const std::byte*>(at_);
}

}  // namespace plc::native
