// TableTypes: what may be where in the table of a task, for tables and records that come from files.
//
// In: an image, the layout of a task's table. Out: values that the engines rely on, mended where a file has others: a
// BOOL that is neither 0 nor 1, a text longer than its room, a reference to nothing. What a recording of this image has
// is never changed: numbers are not looked at, since a program may leave the limits of a subrange. Threads: one makes
// it; looking at tables: any. Does not belong here: initial values of images (the verifier).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bytecode/image.h"
#include "runtime/memory/table.h"

namespace plc::runtime {

class TableTypes {
 public:
  /// Of the table of the task whose body is `body`. The image outlives it.
  TableTypes(const bytecode::Image& image, std::uint32_t task, std::uint32_t body, const TaskLayout& layout);

  /// Mends what [at, at + bytes) of the table touches. False when something was not as it must be; constants are the
  /// image's again.
  bool mend(std::span<std::byte> table, std::size_t at, std::size_t bytes) const noexcept;

 private:
  /// Leaves of one type side by side.
  struct Row {
    std::uint32_t at = 0;
    std::uint32_t type = 0;
    std::uint32_t bytes = 0;  ///< of one
    std::uint32_t count = 0;
    [[nodiscard]] std::uint64_t end() const { return at + std::uint64_t{bytes} * count; }
  };
  /// A value of `type` lies at `at`.
  struct Region {
    std::uint32_t at = 0;
    std::uint32_t type = 0;
  };

  void add_region(std::uint32_t at, std::uint32_t type);
  void add(std::uint32_t at, std::uint32_t type);
  [[nodiscard]] bool demands(std::uint32_t type) const { return demands_[type] != 0; }
  bool mend_leaf(std::uint32_t type, std::byte* value) const noexcept;
  [[nodiscard]] bool leads_to_a_value(std::uint64_t handle) const noexcept;

  const bytecode::Image& image_;
  std::uint64_t task_tag_;
  std::uint32_t constants_;            ///< where they are in the table
  std::vector<std::uint8_t> demands_;  ///< by type: something in it must be looked at
  std::vector<Region> regions_;        ///< ascending
  std::vector<Row> rows_;              ///< ascending
};

}  // namespace plc::runtime
