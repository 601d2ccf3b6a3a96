// ProcessImage: direct addresses that overlap, under --profile=overlay: %IW0 contains %IX0.0 .. %IX1.7, %ID0 contains
// %IW0 and %IW1 (word, double and long addresses count in their own size, as CODESYS does).
//
// In: the addresses of an image's globals. Out: sync(), which lets every location that changed since the last sync show
// up in all locations that share bits with it. Inside, each location stays a value of its own (one byte per BOOL), so
// programs run at full speed; the packing happens here, at the ends of a cycle (docs/adr/0011).
// Threads: sync() may be called by every task; when two meet, one does the work for both. Does not belong here:
// devices.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "bytecode/image.h"
#include "runtime/memory/global_table.h"

namespace plc::runtime {

/// The fields of Image::global_type that share bits with another one; none under --profile=separate.
std::vector<FieldBits> overlapping_globals(const bytecode::Image& image);

class ProcessImage {
 public:
  /// Under --profile=separate, and when no two locations overlap, there is nothing to do ever.
  ProcessImage(const bytecode::Image& image, GlobalTable& globals);

  /// Brings overlapping locations into agreement. Of two that changed and overlap, the one declared later wins. RT.
  void sync() noexcept;
  /// Locations that share bits with another one.
  [[nodiscard]] std::size_t location_count() const { return locations_.size(); }

 private:
  struct Location {
    std::uint32_t global = 0;     ///< byte offset in the global table
    std::uint32_t bytes = 1;      ///< of the value there
    std::uint32_t first_bit = 0;  ///< in packed_
    std::uint32_t bits = 1;       ///< 1 for BOOL
  };
  [[nodiscard]] std::uint64_t load(const Location& location) const noexcept;
  [[nodiscard]] std::uint64_t packed(const Location& location) const noexcept;
  void pack(const Location& location, std::uint64_t value) noexcept;

  GlobalTable& globals_;
  std::vector<Location> locations_;
  std::vector<std::uint8_t> packed_;  ///< as the last sync left it
  std::vector<std::uint8_t> next_;    ///< equal to packed_ outside sync()
  std::vector<std::uint64_t> found_;  ///< by location: what sync() found there
  std::atomic_flag busy_ = ATOMIC_FLAG_INIT;
};

}  // namespace plc::runtime
