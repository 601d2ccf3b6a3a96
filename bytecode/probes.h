// Probes: where code has what drawings and texts show, so that a replica can take it while it executes a scan
// (docs/adr/0055).
//
// A map belongs to the code of one POU. Its steps say which variable holds a value at which code word, or which earlier
// steps make it; points say which step belongs to which place of a drawing or text. Nothing in the code is there for a
// map. In: made with the code (codegen/probe_notes.h), or loaded; then verified (rules V319 to V323). Out: read by the
// linker of replicas. Does not belong here: drawings (drawings.h), values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bytecode/drawn_key.h"

namespace plc::bytecode {

enum class ProbeOp : std::uint8_t {
  kCapture,      ///< what is in operand `a`
  kConst,        ///< `a`, and `b` above its 32 bits
  kAnd,          ///< BOOL: steps `a` and `b`
  kOr,           ///< ..
  kXor,          ///< ..
  kNot,          ///< BOOL: step `a`
  kReached,      ///< control came here; no value
  kNotComputed,  ///< the code does not compute it
};
inline constexpr ProbeOp kLastProbeOp = ProbeOp::kNotComputed;

inline constexpr std::uint32_t kNoStep = 0xffffffffu;
/// ProbeStep::type of a BOOL that is in no variable, and where there is no value.
inline constexpr std::uint32_t kNoProbeType = 0xffffffffu;
/// Bytes of a text that are taken, beside its capacity and length.
inline constexpr std::uint32_t kProbedTextBytes = 80;

/// Steps are in the order in which they are executed: by word, at one word by order.
struct ProbeStep {
  /// Before the instruction that begins here, or the look-up record of a BOOL_RUN.
  std::uint32_t word = 0;
  /// At one word: how many jump targets with steps between them lie before it. Who jumps to the n-th of them (n from 1)
  /// executes steps of order n and above; who comes from the instruction before, all.
  std::uint32_t order = 0;
  ProbeOp op = ProbeOp::kReached;
  std::uint32_t a = 0, b = 0;
  std::uint32_t type = kNoProbeType;  ///< kCapture: of the leaf; kConst: a scalar, or BOOL
  std::uint32_t when = kNoStep;       ///< an earlier BOOL step: this one is executed where it is TRUE
  friend bool operator==(const ProbeStep&, const ProbeStep&) = default;
};

/// A jump that does not execute all steps at the word it goes to.
struct ProbeJump {
  std::uint32_t word = 0;   ///< of the jump
  std::uint32_t order = 0;  ///< of the first step that it does execute
  friend bool operator==(const ProbeJump&, const ProbeJump&) = default;
};

struct ProbePoint {
  DrawnKey key;  ///< without its pou, which is 0
  std::uint32_t step = 0;
  friend bool operator==(const ProbePoint&, const ProbePoint&) = default;
};

struct PouProbes {
  std::vector<ProbeStep> steps;
  std::vector<ProbeJump> jumps;    ///< ascending words
  std::vector<ProbePoint> points;  ///< ascending keys, each once
  [[nodiscard]] bool empty() const { return points.empty(); }
  friend bool operator==(const PouProbes&, const PouProbes&) = default;
};

/// The maps of all POUs as bytes: differences to what comes before, in as few bytes as they need.
std::vector<std::byte> pack_probes(const std::vector<PouProbes>& probes);
/// The maps in `bytes`; false when they are none. What they say is not checked here (verify()).
bool unpack_probes(std::span<const std::byte> bytes, std::vector<PouProbes>& probes);

}  // namespace plc::bytecode
