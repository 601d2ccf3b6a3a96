// Records: what one scan of a task took in from outside of its table, so that the same scan can be executed again
// elsewhere, from the table before it (docs/adr/0053).
//
// A record is a head and its entries, in the order in which the scan asked for them, so that they need no names. It
// holds bytes, not versions: what others wrote into the local copy of the globals, whoever and by whatever protocol;
// answers of queues; outputs and status of every taskblock. Whatever else a scan may see one day needs its kind of
// entry. The form here is that of rings, in memory of this machine. Does not belong here: files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "core/clock.h"

namespace plc::runtime {

/// Heads and entries begin at a multiple of this, and take one.
inline constexpr std::size_t kRecordAlign = 16;

enum class RecordKind : std::uint16_t {
  kScan,
  /// Here records were left out, or the table was changed by something that is no scan: RecordHead::events times. The
  /// table is unknown until the next checkpoint.
  kLost,
  kCheckpointed,  ///< the checkpoint has the table as it is before scan `scan`
};

/// RecordHead::flags.
enum RecordFlag : std::uint16_t {
  kCut = 1,          ///< its loops were cut from outside, where is not known: it cannot be executed again
  kRevoked = 2,      ///< it had no right to publish any more
  kFaulted = 8,      ///< it ended with a fault
  kShortCheck = 16,  ///< of `check` the lower 16 bits alone are there, as files have it
  kFloatMode = 4,    ///< the floating-point mode was another one when it ended (core/floating_point.h)
};

struct alignas(kRecordAlign) RecordHead {
  std::uint32_t bytes = 0;  ///< with its entries
  RecordKind kind = RecordKind::kScan;
  std::uint16_t flags = 0;
  std::uint32_t events = 0;  ///< raised by the scan
  std::uint32_t slice = 0;   ///< `check` is that of the bytes [512 slice, 512 slice + 512) of the table after the scan
  std::uint64_t check = 0;   ///< XXH3
  std::uint64_t scan = 0;    ///< executions of the task before this one, since recording began
  core::TimeNs now_ns = 0;   ///< what the scan was told, as CycleContext has it
  core::TimeNs start_ns = 0;
  core::TimeNs utc_ns = 0;
};
static_assert(sizeof(RecordHead) == 64);

enum class EntryKind : std::uint16_t {
  kBytes,      ///< bytes that others wrote into the table at `at`; `detail` is the moment
  kQueue,      ///< answer of a queue: `at` is 1 when the element was put or taken; the element, where one was taken
  kNumber,     ///< `at` elements, or room for so many
  kTaskblock,  ///< object `at` ran, with status `detail`; all its outputs, one after the other
  kFault,      ///< how the scan ended: kind `at`; POU, word and taskblock
  kForced,     ///< bytes at `at` that were forced before the export number `detail` of the scan, or at its end
};
/// EntryHead::detail of kForced: after the last instruction.
inline constexpr std::uint32_t kForcedAtEnd = 0xffffffffu;

struct alignas(kRecordAlign) EntryHead {
  std::uint32_t bytes = 0;  ///< that follow, without what fills them up to a multiple of kRecordAlign
  EntryKind kind = EntryKind::kBytes;
  std::uint32_t at = 0;
  std::uint32_t detail = 0;  ///< the moment: 0 = before the first instruction, n = at the n-th import of the scan
};
static_assert(sizeof(EntryHead) == 16);

/// Bytes that an entry of `bytes` takes after its head.
constexpr std::size_t padded(std::size_t bytes) noexcept { return (bytes + kRecordAlign - 1) & ~(kRecordAlign - 1); }

/// A taskblock's output in the table.
struct PortBytes {
  std::byte* at = nullptr;
  std::uint32_t bytes = 0;
};

/// The fault of a scan, as records have it.
struct RecordedFault {
  std::uint32_t kind = 0;  ///< FaultKind; 0 = none
  std::uint32_t pou = 0;
  std::uint32_t word = 0;
  std::uint32_t taskblock = 0;
  friend bool operator==(const RecordedFault&, const RecordedFault&) = default;
};

/// Bytes of the table that one check covers.
inline constexpr std::uint32_t kSliceBytes = 512;
/// RecordHead::check of a slice of the table. RT.
std::uint64_t check_of_slice(std::span<const std::byte> table, std::uint32_t slice) noexcept;

}  // namespace plc::runtime
