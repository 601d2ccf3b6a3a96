// Probes: what somebody may look at while a body runs: what drawn pins, contacts, coils and texts have at their place.
//
// In: front ends that lower a module with Module::probes note values, variables and places of the body (Builder::probe
// and its like). Out: code generation says where each of them is found (bytecode/codegen/probe_notes.h). No instruction
// is made for a probe. Does not belong here: what drawings look like.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/source_ref.h"

namespace plc::ir {

/// Which point of an element it is, as bytecode::DrawnSide says.
enum class ProbeSide : std::uint8_t { kWhole, kInput, kOutput };

/// The key of a point of a drawing or text, as bytecode::DrawnKey says.
struct ProbeKey {
  std::int64_t local_id = -1;
  std::uint32_t line = 0, column = 0;
  std::uint16_t pin = 0;
  ProbeSide side = ProbeSide::kWhole;

  static ProbeKey of(const core::SourceRef& at, ProbeSide side, std::size_t pin = 0) {
    return {at.local_id, at.line, at.column, static_cast<std::uint16_t>(pin), side};
  }
  /// Texts have no localId, also where they stand in an element.
  static ProbeKey text(const core::SourceRef& at, ProbeSide side) { return {-1, at.line, at.column, 0, side}; }
  friend bool operator==(const ProbeKey&, const ProbeKey&) = default;
};

}  // namespace plc::ir
