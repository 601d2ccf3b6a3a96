// PowerTrace: from an element of a drawing against the power to what has changed it, by what two scans had at all pins.
//
// In: a body, the flow of a scan, and that of the scan before. Out: the contact, variable, block or rail where it
// began. Threads: one. Does not belong here: scans, other POUs.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "bytecode/drawings.h"
#include "bytecode/probes.h"
#include "shadow/probe_view.h"

namespace plc::shadow {

/// What a POU had at all its probes in one scan.
struct Flow {
  const bytecode::PouProbes* map = nullptr;
  std::vector<Shown> shown;  ///< by point of the map

  [[nodiscard]] const Shown* at(bytecode::DrawnKey key) const;
  /// Of a BOOL that was computed; nothing else.
  [[nodiscard]] std::optional<bool> power(const bytecode::DrawnKey& key) const;
};

class PowerTrace {
 public:
  /// `before`: null when it is not known.
  PowerTrace(const bytecode::DrawnBody& body, const Flow& now, const Flow* before);

  struct End {
    std::uint32_t element = 0;
    std::string variable;       ///< whose value it is; empty: a block, a rail
    std::string output;         ///< of a function block: its instance and the output, "Timer.Q"
    std::optional<bool> value;  ///< of the variable, else of the power; nothing: it is not known from the drawing
  };
  /// What has the power at an input pin (into DrawnElement::pins) from.
  [[nodiscard]] End from(std::uint32_t element, std::uint32_t pin);

 private:
  using Pin = std::pair<std::uint32_t, std::uint32_t>;
  [[nodiscard]] bytecode::DrawnKey key(Pin pin) const;
  [[nodiscard]] std::optional<bool> now(Pin pin) const { return now_.power(key(pin)); }
  [[nodiscard]] bool changed(Pin pin) const;
  /// The wire that counts at an input.
  [[nodiscard]] std::optional<Pin> source_of(Pin input) const;
  /// The input of an element behind whose output the power is looked for; nothing: it ends here.
  [[nodiscard]] std::optional<Pin> through(Pin output) const;
  [[nodiscard]] std::optional<Pin> first_input(std::uint32_t element) const;

  const bytecode::DrawnBody& body_;
  const Flow& now_;
  const Flow* before_;
  std::multimap<Pin, Pin> sources_;  ///< by input
};

}  // namespace plc::shadow
