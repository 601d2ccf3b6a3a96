// Cuts the records of a BOOL_RUN into segments that one loop each can run (bool_run.h).
//
// In: records with resolved operands, in order. Out: segments that cover them in order, each in its cheapest form.
// Does not belong here: emitting code (link.cpp).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "runtime/interpreter/bool_run.h"

namespace plc::runtime {

struct BoolSegment {
  enum class Form : std::uint8_t {
    kShort4,   ///< 16-byte records on one window, four inputs
    kShort5,   ///< the same, five inputs
    kGeneral,  ///< any operands
  } form = Form::kGeneral;
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  std::uint32_t window = 0;  ///< short forms: the resolved operand that offsets count from
};

std::vector<BoolSegment> cut_into_segments(std::span<const GeneralRecord> records);

/// The short form of a record of a segment with this window.
ShortRecord shorten(const GeneralRecord& record, std::uint32_t window);

/// Appends the words of one segment: `handler`, what else the instruction says, its records. `records`: those of the
/// segment.
void append_segment(std::vector<std::uint32_t>& words, std::uint32_t handler, const BoolSegment& segment,
                    std::span<const GeneralRecord> records);

}  // namespace plc::runtime
