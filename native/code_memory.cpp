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

core::Result<CodeMemory> CodeMemory::make(std::span<const std::byte> code) {
  const int file = make_file();
  if (file < 0) return refused("memfd_create");
  const auto give_up = [&](const char* call) {
    const core::Problem problem = refused(call);
    ::close(file);
    return problem;
  };
  if (::ftruncate(file, static_cast<off_t>(code.size())) != 0) return give_up("ftruncate");
  void* const writable = ::mmap(nullptr, code.size(), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  if (writable == MAP_FAILED) return give_up("mmap");
  std::memcpy(writable, code.data(), code.size());
  ::munmap(writable, code.size());
  void* const at = ::mmap(nullptr, code.size(), PROT_READ | PROT_EXEC, MAP_SHARED | MAP_POPULATE, file, 0);
  if (at == MAP_FAILED) return give_up("mmap of executable pages");
  ::close(file);
  // Written through other addresses: processors whose caches of instructions do not look must be told.
  __builtin___clear_cache(static_cast<char*>(at), static_cast<char*>(at) + code.size());
  return CodeMemory(static_cast<std::byte*>(at), code.size());
}

}  // namespace plc::native
