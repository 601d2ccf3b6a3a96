// Footprint: which bytes of a task's table an instruction reads and writes, and what else its effect depends on.
//
// In: resolved code. Out: ranges; for calls, those of everything that is called. What cannot be said is said to be
// unknown, never guessed. Compile time. Does not belong here: what is skipped when (changed_plan.h).
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "native/operation.h"
#include "runtime/bool_run.h"
#include "runtime/link.h"

namespace plc::native {

/// Bytes of the table, from an operand on: in relative bodies perhaps from the instance (runtime::kRelativeBit).
struct Range {
  std::uint32_t begin = 0;
  std::uint32_t bytes = 0;
  friend bool operator==(const Range&, const Range&) = default;
};

struct Footprint {
  std::vector<Range> reads;   ///< with those that are not pure: incomplete
  std::vector<Range> writes;  ///< complete when `writes_known`
  bool writes_known = false;
  /// Nothing but the bytes read decides what is written, and there is no other effect but events. While a timer runs,
  /// time does too.
  bool pure = false;
  /// Each byte in `writes` is written whatever happens.
  bool always_writes = false;
  bool raises = false;                  ///< events, perhaps
  std::optional<std::uint32_t> timer;   ///< operand of the STATE of a timer
  std::optional<std::uint32_t> target;  ///< position that it may jump to
};

/// Bytes that pure instructions may read or write at once; what moves more is not worth watching.
inline constexpr std::uint32_t kMostPureBytes = 256;

class Footprints {
 public:
  explicit Footprints(const runtime::LinkedCode& linked);

  /// Of an instruction that is no boolean run.
  [[nodiscard]] Footprint of(const runtime::LinkedInstruction& instruction);
  /// The records of a boolean run, with operands as in GeneralRecord.
  [[nodiscard]] std::vector<runtime::GeneralRecord> records_of(const runtime::LinkedInstruction& instruction) const;

 private:
  /// What a whole body writes; nothing when that is unknown.
  using Writes = std::optional<std::vector<Range>>;
  const Writes& writes_of_body(std::uint32_t entry);
  void add_call(Footprint& footprint, std::uint32_t entry, std::uint32_t instance);
  void add_function(Footprint& footprint, const std::uint32_t* words);
  static void add_library(Footprint& footprint, const std::uint32_t* words);
  static void add_block(Footprint& footprint, const std::uint32_t* words);

  const runtime::LinkedCode& linked_;
  std::unordered_map<std::uint32_t, std::size_t> body_at_;  ///< by entry
  std::unordered_map<std::uint32_t, Writes> writes_;        ///< by entry
};

}  // namespace plc::native
