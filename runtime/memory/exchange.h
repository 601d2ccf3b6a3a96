// Exchange: moves values between the global table and one task's local copy at the ends of its cycle (paper, 3.2.2).
//
// In: field ranges of the global table as READ_N, WRITE_N and WRITE_CHANGED_N name them. Out: import and export without
// locks. Values of up to 8 bytes never tear: both sides move naturally aligned words as relaxed atomics, and no export
// touches a byte outside the leaves it names. Whole snapshots are not promised: two values imported together may be of
// different cycles of their writer. Interpreter and engines know this interface only, so that a coherent exchange can
// take its place. Threads: import and export on the task's thread; the global table is shared by all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bytecode/image.h"
#include "runtime/memory/table.h"

namespace plc::runtime {

/// Copies `bytes` out of or into shared memory, in words as the shared address is aligned. RT.
void copy_from_shared(std::byte* to, const std::byte* shared, std::size_t bytes) noexcept;
void copy_to_shared(std::byte* shared, const std::byte* from, std::size_t bytes) noexcept;

class Exchange {
 public:
  /// `local` is the start of the task's table; its first bytes are the copy of the global table.
  Exchange(const bytecode::Image& image, GlobalTable& globals, std::byte* local);

  /// Makes a range of `count` fields from `first` on known; returns its number. `changed`: for export_changed().
  std::uint32_t add_range(std::uint32_t first, std::uint32_t count, bool changed);

  /// RT.
  void import(std::uint32_t range) noexcept;
  /// RT.
  void export_all(std::uint32_t range) noexcept;
  /// Exports the leaves that differ from what the last import brought (or the last export sent). RT.
  void export_changed(std::uint32_t range) noexcept;
  /// Forgets what was imported, as after a cold start.
  void reset();

 private:
  /// `count` leaves of `bytes` each, side by side. Strings are leaves of their full size.
  struct Leaves {
    std::uint32_t offset = 0;
    std::uint32_t bytes = 0;
    std::uint32_t count = 0;
  };
  struct Range {
    std::uint32_t begin = 0;
    std::uint32_t end = 0;
    std::uint32_t first_leaves = 0;  ///< into leaves_
    std::uint32_t last_leaves = 0;
  };
  void add_leaves(std::uint32_t type, std::uint32_t offset);

  const bytecode::Image& image_;
  GlobalTable& globals_;
  std::byte* local_;
  std::vector<Range> ranges_;
  std::vector<Leaves> leaves_;
  TableMemory shadow_;  ///< size 0 while no range is exported by change
};

}  // namespace plc::runtime
