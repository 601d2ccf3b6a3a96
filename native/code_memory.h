// CodeMemory: executable memory within reach of a task's table, so that code names variables by their distance.
//
// In: the memory that the code works on. Out: an address that code can be made for, then the code at that address. The
// pages are a memfd mapped twice, writable for the compiler and executable for the task: no page is ever both, none
// changes its protection while a task runs, and systemd's MemoryDenyWriteExecute allows it. Does not belong here: code.
#pragma once

#include <cstddef>
#include <cstdint>
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

  /// Reserves addresses for `bytes` of code, all of them less than 2 GiB from all of `data`. P9001 when there are none.
  static core::Result<CodeMemory> reserve(std::span<const std::byte> data, std::size_t bytes);
  /// Where the code will start.
  [[nodiscard]] std::uint64_t address() const { return reinterpret_cast<std::uint64_t>(at_); }
  [[nodiscard]] std::size_t reserved() const { return size_; }
  /// Puts the code, at most what was reserved, in its place, resident; gives the other addresses back. Once. P9001 when
  /// the system refuses.
  core::Result<const std::byte*> fill(std::span<const std::byte> code);

 private:
  std::byte* at_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace plc::native
