// Compile options: everything that changes what a program means. Stored in the image and printed at start, so that
// simulation and plant cannot differ (docs/adr/0004).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace plc::core {

/// Which rule orders networks and elements (docs/guides/execution-order.md).
enum class Order : std::uint8_t { kDrawing, kDocument };
/// Whose semantics to reproduce where tools disagree.
enum class Compat : std::uint8_t { kNone, kBeremiz };
/// How direct addresses relate: kSeparate = %IX, %IB, %IW .. are independent (OpenPLC); kOverlay = %IW0 contains
/// %IX0.0..%IX1.7.
enum class AddressProfile : std::uint8_t { kSeparate, kOverlay };
/// How tasks exchange globals at the ends of their cycles (docs/guides/coherence.md).
enum class Coherence : std::uint8_t {
  kWaitFree,         ///< one snapshot per writing task, nobody waits
  kPriorityCeiling,  ///< groups of globals copied at raised priority (paper, 3.2.3); all tasks on one processor
  kGlobalLock,       ///< one lock around every copy (Chimera)
};

/// "wait-free", "priority-ceiling", "global-lock": the words of --coherence.
constexpr std::string_view coherence_name(Coherence coherence) {
  switch (coherence) {
    case Coherence::kWaitFree:
      return "wait-free";
    case Coherence::kPriorityCeiling:
      return "priority-ceiling";
    case Coherence::kGlobalLock:
      return "global-lock";
  }
  return {};
}

struct CompileOptions {
  Order order = Order::kDrawing;
  Compat compat = Compat::kNone;
  AddressProfile profile = AddressProfile::kSeparate;
  Coherence coherence = Coherence::kWaitFree;
  bool stub_missing = false;  ///< POUs, blocks and types that cannot be compiled become stubs that do nothing, loudly
  bool strict =
      false;  ///< notes are errors: only what the standard knows compiles. Not in the image: it changes no meaning
  bool show_all = false;  ///< every warning and note is printed, not 20 of one code. Not in the image either
  std::string pou;  ///< --pou: instantiate this program or function block alone in a 20 ms task; empty = the file's
                    ///< configuration
  friend bool operator==(const CompileOptions&, const CompileOptions&) = default;
};

}  // namespace plc::core
