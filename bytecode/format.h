// The layout of an image file, shared by image_save.cpp and image_load.cpp.
//
//   header   8 bytes magic, u32 format version, u32 number of sections, u64 XXH3-64 of every byte after the header
//   section  u32 id, u64 size, `size` bytes; every section of the list below once, in its order, nothing after the
//   last; kAddresses, kDrawings and kProbes only where there are any
// Numbers are little-endian. Each text is once in the string pool; records refer to it by index.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace plc::bytecode::format {

inline constexpr std::array<unsigned char, 8> kMagic = {'P', 'I', 'C', 'A', 'R', 'D', 0x1a, '\n'};
inline constexpr std::size_t kVersionAt = 8;
inline constexpr std::size_t kSectionCountAt = 12;
inline constexpr std::size_t kChecksumAt = 16;
inline constexpr std::size_t kHeaderBytes = 24;
inline constexpr std::size_t kSectionHeaderBytes = 12;

enum class Section : std::uint32_t {
  kStrings = 1,
  kProject,
  kTypes,
  kTables,
  kPous,
  kLibrary,
  kQueues,
  kTasks,
  kAddresses,
  kDrawings,
  kProbes
};
inline constexpr std::uint32_t kSectionCount = 8;       ///< that every image has
inline constexpr std::uint32_t kMostSectionCount = 11;  ///< with those that are there where they have something

/// Longest text in the pool, bytes.
inline constexpr std::uint32_t kMaxTextBytes = 65535;
/// Records may name a text again and again; all copies together may be this many times as large as the file.
inline constexpr std::uint64_t kTextExpansion = 64;

// Smallest sizes of records, bytes: what a count is checked against before memory is reserved.
inline constexpr std::size_t kTextRecord = 4;
inline constexpr std::size_t kTypeRecord = 53;
inline constexpr std::size_t kFieldRecord = 14;
inline constexpr std::size_t kAliasRecord = 8;
inline constexpr std::size_t kMemberRecord = 12;
inline constexpr std::size_t kGlobalRecord = 12;
inline constexpr std::size_t kPouRecord = 37;
inline constexpr std::size_t kDebugRecord = 23;
inline constexpr std::size_t kWireRecord = 12;
inline constexpr std::size_t kQueuePortRecord = 13;
inline constexpr std::size_t kBlockRecord = 16;
inline constexpr std::size_t kQueueRecord = 20;
inline constexpr std::size_t kTaskRecord = 24;

// Bits of a field's flags.
inline constexpr std::uint8_t kFieldRetain = 1;
inline constexpr std::uint8_t kFieldConstant = 2;
inline constexpr std::uint8_t kFieldPersistent = 4;
inline constexpr std::uint8_t kFieldFresh = 8;
inline constexpr std::uint8_t kFieldInternal = 16;
inline constexpr std::uint8_t kFieldFlags = 31;

}  // namespace plc::bytecode::format
