// CodeMemory: executable memory.
//
// In: code that runs at any address. Out: the code, resident. The pages are a memfd mapped twice, writable for the
// compiler and executable for the task: no page is ever both, none changes its protection while a task runs, and
// systemd's MemoryDenyWriteExecute allows it. Does not belong here: code.
#pragma once

#include <cstddef>
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

  /// A copy of the code that can be called. P9001 when the system refuses.
  static core::Result<CodeMemory> make(std::span<const std::byte> code);
  [[nodiscard]] const std::byte* data() const { return at_; }

 private:
  CodeMemory(std::byte* at, std::size_t size) : at_(at), size_(size) {}

  std::byte* at_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace plc::native
