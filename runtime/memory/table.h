// The memory that programs run on: aligned blocks of bytes and their layout per task.
//
// In: sizes from a verified image. Out: stable addresses, 64-byte aligned, on huge pages when asked and available.
// A task's table holds [copy of the global table][constants][task instance][one static frame per POU it reaches];
// recursion is impossible, so frames never move. Does not belong here: what the bytes mean (access.h), when they are
// copied (exchange.h), the global table itself (global_table.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bytecode/image.h"

namespace plc::runtime {

/// Every table and every part of one starts at a multiple of this: a cache line, and enough for all types.
inline constexpr std::size_t kTableAlign = 64;

/// Zeroed, aligned, fixed-size memory. Move only.
class TableMemory {
 public:
  TableMemory() = default;
  /// Throws std::bad_alloc when the machine has not enough memory. `huge_pages` asks for transparent huge pages.
  explicit TableMemory(std::size_t bytes, bool huge_pages = false);
  ~TableMemory();
  TableMemory(TableMemory&& other) noexcept;
  TableMemory& operator=(TableMemory&& other) noexcept;
  TableMemory(const TableMemory&) = delete;
  TableMemory& operator=(const TableMemory&) = delete;

  [[nodiscard]] std::byte* data() { return data_; }
  [[nodiscard]] const std::byte* data() const { return data_; }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  std::byte* data_ = nullptr;
  std::size_t size_ = 0;
  std::size_t mapped_ = 0;
};

/// Of the memory after each table in which the interpreter keeps values that are overwritten in the same scan.
inline constexpr std::size_t kScratchBytes = std::size_t{16} * 1024;

/// Byte offsets of the parts of one task's table.
struct TaskLayout {
  static constexpr std::uint32_t kAbsent = 0xffffffffu;
  std::uint32_t global_bytes = 0;  ///< the copy of the global table is at offset 0
  std::uint32_t constants = 0;
  std::uint32_t instance = 0;
  std::uint32_t scratch = 0;          ///< kScratchBytes for values inside a scan, after the table
  std::vector<std::uint32_t> frames;  ///< per POU of the image; kAbsent when the task cannot reach it
  std::uint64_t total = 0;            ///< without scratch; may exceed what can be addressed: link refuses that
};
/// Lays out the table of a task whose body is `body` and which reaches the POUs marked in `reached`.
TaskLayout lay_out(const bytecode::Image& image, std::uint32_t body, std::span<const std::uint8_t> reached);

/// A task's own table, filled with initial values.
class TaskTable {
 public:
  TaskTable(const bytecode::Image& image, std::uint32_t body, TaskLayout layout, bool huge_pages);
  [[nodiscard]] std::byte* data() { return memory_.data(); }
  [[nodiscard]] const std::byte* data() const { return memory_.data(); }
  [[nodiscard]] const TaskLayout& layout() const { return layout_; }
  /// Initial values again, as after construction.
  void reset(const bytecode::Image& image, std::uint32_t body);

 private:
  TaskLayout layout_;
  TableMemory memory_;
};

}  // namespace plc::runtime
