// instrument: makes of a module one that stores what its probes show into variables of their own: what probe maps are
// compared with. It knows values and places in the IR only, no code.
//
// In: a module whose front ends noted probes. Out: the same with hidden variables and stores. Does not belong here:
// running.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ir/ir.h"

namespace plc::test {

/// The variables of one probe: in the instances of its POU, of functions in globals.
struct Instrumented {
  ir::ProbeKey key;
  std::string value;  ///< name, or empty: it has none
  std::string ran, was_false, was_true;
  bool is_bool = false;
};

/// By POU of the module. Changes the module, whose probes are gone.
std::vector<std::vector<Instrumented>> instrument(ir::Module& module);

}  // namespace plc::test
