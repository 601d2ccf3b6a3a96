// Cause: why a BOOL has its value: back to the contact, the rung and the scan that changed it, and on from there to
// what changed the variable of that contact, across POUs and tasks.
//
// In: a past, the drawings of its image, a variable in a scan. Out: links, the present first. Threads: that of the
// past. Does not belong here: words.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "shadow/past.h"
#include "shadow/writers.h"

namespace plc::shadow {

struct CauseLink {
  enum class Kind : std::uint8_t {
    kAsked,    ///< the variable that was asked for
    kWrote,    ///< a coil, an output variable, a statement, an action: it gave the variable its value
    kContact,  ///< a contact or variable that changed the power: what is asked for next
    kBlock,    ///< the end: the value comes from this block
    kRail,     ///< the end: nothing is between it and a rail
    kNotRun,   ///< the end: what writes the variable is not executed
    kOutside,  ///< the end: nothing drawn or written has changed it: an input, an HMI, a force, another machine
    kAsBegun,  ///< the value is as old as the recording; with what keeps it so
    kSeen,     ///< the end: the variable has been looked at before, it keeps itself
    kTooFar,   ///< the end: it would have taken too long
  };
  Kind kind = Kind::kAsked;
  std::string variable;  ///< as it stands there
  bool value = false;
  std::uint32_t task = 0;
  std::uint64_t scan = 0;  ///< in which it got the value
  core::TimeNs now_ns = 0, utc_ns = 0;
  bool placed = false;  ///< what follows counts
  const bytecode::DrawnBody* body = nullptr;
  std::uint32_t pou = 0;
  PouInstance instance;
  std::uint32_t element = 0;  ///< into DrawnBody::elements, of a drawing
  std::uint32_t line = 0;     ///< of a text
};

/// Why `name` in the POU of `view`, an instance on `task`, has the value that it has after `scan`. Empty when it is no
/// BOOL, or the scan is not here. Ends after `limit`, or once `ending` is true, with kTooFar.
std::vector<CauseLink> cause_of(Past& past, const bytecode::Drawings& drawings, std::uint32_t task, std::uint64_t scan,
                                const PouInstance& instance, const std::string& name, std::chrono::milliseconds limit,
                                const std::atomic<bool>* ending = nullptr);

}  // namespace plc::shadow
