// CodeMemory: executable memory.
//
// In: who writes code. Out: the code, resident. The pages are a memfd mapped twice, writable for the
// compiler and executable for the task: no page is ever both, none changes its protection while a task runs, and
// systemd's MemoryDenyWriteExecute allows it. Does not belong here: code.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "core/result.h"

namespace plc::native {

class CodeMemory {
 public:
  CodeMemory() = default;
  ~CodeMemory();
  CodeMemory(CodeMemory&& other) noexcept;
  CodeMemory& operator=(CodeMemory&& other) noexcept;
  CodeMemory(const CodeMemory&) = delete;
  CodeMemory& operator=(const CodeMemory&) = delete;

  /// `bytes` of code that can be called, where it reaches what is at `near` with 32 bits if the system has room there.
  /// `write` is given the memory to fill and the address that the code will run at. P9001 when the system refuses.
  static core::Result<CodeMemory> make(std::size_t bytes, const void* near,
                                       const std::function<void(std::span<std::byte>, std::uint64_t)>& write);
  [[nodiscard]] const std::byte* data() const { return at_; }

 private:
  CodeMemory(std::byte* at, std::size_t size) : at_(at), size_(size) {}

  std::byte* at_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace plc::native
