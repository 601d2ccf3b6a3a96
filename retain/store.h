// The file of retained values: two slots that are written in turn, so that one of them is whole whenever it ends.
//
//   header   magic, u32 version, u32 bytes of the layout, u64 bytes of a set of values, u64 XXH3 of the layout; layout
//   slot     twice, each from a multiple of 4096 on: u64 sequence, i64 time of the programs, i64 time of day, u64 XXH3
//            of all that, of the layout's and of the values; values
//
// Numbers are little-endian, values as the machine has them. The whole slot of the higher sequence counts. A layout
// that changed makes a new file, which takes the place of the old one when it is complete. Threads: one at a time.
// Does not belong here: which values (keeper.h), what they mean for another program (carry.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/clock.h"
#include "core/result.h"
#include "retain/layout.h"

namespace plc::retain {

/// Of the file in a state folder.
inline constexpr const char* kFileName = "retain";
/// The file that was there before, of another layout or not to be read.
inline constexpr const char* kPreviousName = "retain.previous";
/// Larger files are none of this program.
inline constexpr std::uint64_t kMostFileBytes = std::uint64_t{1} << 30;

/// What a file holds.
struct Stored {
  Layout layout;
  std::uint64_t sequence = 0;        ///< of the set of values; from 1 on
  core::TimeNs program_time_ns = 0;  ///< latest `now` of the scans that the values are of
  std::int64_t time_of_day_ns = 0;   ///< when they were stored, since 1970
  std::vector<std::byte> values;
};
/// P7611 when it is no such file, or has no whole slot.
core::Result<Stored> parse_file(std::span<const std::byte> bytes);
/// P7001 when it cannot be opened, P7611 as above.
core::Result<Stored> read_file(const std::string& path);

class Store {
 public:
  /// Files lie in `folder`, which is made when something is stored first.
  Store(std::string folder, const Layout& layout);
  ~Store();
  Store(const Store&) = delete;
  Store& operator=(const Store&) = delete;

  /// Stores a set of values: from here on it outlasts the process, and the machine once this has returned. Empty; or
  /// what went wrong, "cannot write /var/lib/..: No space left on device": nothing is lost, and it may be tried again.
  /// Blocks on the disk.
  std::string write(std::span<const std::byte> values, core::TimeNs program_time_ns, std::int64_t time_of_day_ns);

  [[nodiscard]] std::string path() const;
  /// Of the last set that was stored.
  [[nodiscard]] std::uint64_t sequence() const { return sequence_; }

 private:
  std::string open_folder();
  bool open_existing();
  std::string make_file();
  void close();
  bool write_at(std::uint64_t at, std::span<const std::byte> bytes) const;
  void fill(std::span<const std::byte> values, core::TimeNs program_time_ns, std::int64_t time_of_day_ns);

  std::string folder_;
  std::vector<std::byte> header_;
  std::uint64_t layout_hash_;
  std::size_t value_bytes_;
  std::size_t slot_bytes_;
  int directory_ = -1;
  int file_ = -1;
  std::uint64_t sequence_ = 0;
  std::uint32_t next_ = 0;             ///< slot to write
  std::vector<std::byte> image_;       ///< the slot to write
  std::vector<std::byte> on_disk_[2];  ///< what the slots have; empty = not known
};

}  // namespace plc::retain
