#include "native/code_memory.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cstring>
#include <utility>

namespace plc::native {
namespace {

core::Problem refused(const char* call) {
  return {core::Code::P9001, fmt::format("no memory for native code: {}: {}", call, std::strerror(errno)), {}};
}

int make_file() {
#ifdef MFD_EXEC
  // Kernels that may forbid executable files in memory want to be told of them.
  const int told = ::memfd_create("picard-code", MFD_CLOEXEC | MFD_EXEC);
  if (told >= 0) return told;
#endif
  return ::memfd_create("picard-code", MFD_CLOEXEC);
}

/// The file as executable pages. The system takes an address as a wish: the first ones are below and above what the
/// code works on, in steps of what programs and their memory usually leave between each other.
void* map_near(int file, std::size_t bytes, std::uintptr_t near) {
  constexpr std::uintptr_t kStep = std::uintptr_t{64} << 20, kReach = std::uintptr_t{1} << 30, kPage = 4096;
  const auto map = [&](std::uintptr_t wish) {
    return ::mmap(std::bit_cast<void*>(wish), bytes, PROT_READ | PROT_EXEC, MAP_SHARED | MAP_POPULATE, file, 0);
  };
  const std::uintptr_t page = near & ~(kPage - 1);
  for (std::uintptr_t away = kStep; away < kReach && bytes < kStep; away += kStep) {
    for (const std::uintptr_t wish : {page - away, page + away}) {
      void* const at = map(wish);
      if (at == MAP_FAILED || reinterpret_cast<std::uintptr_t>(at) == wish) return at;
      ::munmap(at, bytes);
    }
  }
  return map(0);
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

core::Result<CodeMemory> CodeMemory::make(std::size_t bytes, const void* near,
                                          const std::function<void(std::span<std::byte>, std::uint64_t)>& write) {
  const int file = make_file();
  if (file < 0) return refused("memfd_create");
  const auto give_up = [&](const char* call) {
    core::Problem problem = refused(call);
    ::close(file);
    return problem;
  };
  if (::ftruncate(file, static_cast<off_t>(bytes)) != 0) return give_up("ftruncate");
  void* const writable = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  if (writable == MAP_FAILED) return give_up("mmap");
  void* const at = map_near(file, bytes, reinterpret_cast<std::uintptr_t>(near));
  if (at == MAP_FAILED) {
    ::munmap(writable, bytes);
    return give_up("mmap of executable pages");
  }
  write({static_cast<std::byte*>(writable), bytes}, reinterpret_cast<std::uintptr_t>(at));
  ::munmap(writable, bytes);
  ::close(file);
  // Written through other addresses: processors whose caches of instructions do not look must be told.
  __builtin___clear_cache(static_cast<char*>(at), static_cast<char*>(at) + bytes);
  return CodeMemory(static_cast<std::byte*>(at), bytes);
}

}  // namespace plc::native
