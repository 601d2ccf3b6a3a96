// Packs runs of boolean logic (packed_run.h). Compile time.
//
// In: records in an order in which they may run. Out: the words of a packed run, if all their variables fit into two
// words of bits and it is faster than a loop over the records. Does not belong here: which records stand side by side
// (arrange.h).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "runtime/bool_run.h"

namespace plc::runtime {

struct LogicRecord {
  GeneralRecord record;
  std::uint8_t inputs = 0;  ///< of the record's, what its truth table depends on
  bool scratch = false;     ///< the result lies in scratch memory: later records with the same place do not wait for it
  bool needed = true;       ///< the result is read behind the run
};

struct PackedWords {
  std::size_t bits = 0;  ///< words of bits, 1 or 2: see packed_run()
  std::uint32_t chunks = 0;
  bool pays = false;  ///< faster than a loop over the records
  std::vector<std::uint32_t> words;
};
/// Nothing when it does not fit, or when this processor has no fast way to run it.
std::optional<PackedWords> pack(std::span<const LogicRecord> records);

}  // namespace plc::runtime
