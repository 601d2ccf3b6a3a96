// examine(): what is right and wrong with a machine for a project (plc doctor).
//
// In: a System, and what is to run there, as far as it is known. Out: a line for each thing that was looked at, and one
// more for each further thing that is wrong with it. Nothing on the machine is changed, taken or locked; each check
// ends in well below a second. Does not belong here: reading and compiling projects, printing (tools/plc/doctor.cpp).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/diagnostics.h"
#include "doctor/system.h"
#include "io-drivers/config/configuration.h"
#include "runtime/resource.h"

namespace plc::doctor {

/// What is to run on the machine.
struct Subject {
  io::Configuration configuration;        ///< of plc.toml; the defaults of plc-run without one
  bool configuration_is_known = true;     ///< false: plc.toml has errors
  std::string configuration_file;         ///< as given; empty: none
  std::string project_file;               ///< project or image, as given; empty: none
  runtime::Resource* resource = nullptr;  ///< the project, ready to run; null: none, or it has errors
  std::string state;                      ///< --state; empty: what plc.toml says
  core::Diagnostics diagnostics;          ///< from reading all that
};

enum class State : std::uint8_t { kOk, kUnknown, kNote, kWarning, kProblem };
/// "ok", "unknown", "note", "warning", "problem".
std::string_view state_word(State state);

struct Line {
  std::string_view area, what;  ///< "clock", "source"
  State state = State::kOk;
  core::Code code{};  ///< of what is wrong, or may be
  std::string seen;   ///< what is there; why it is not known
  std::string help;   ///< how to mend it; empty when there is nothing to mend
};

/// `process`: the number of the process whose rights and limits count, or "self".
std::vector<Line> examine(const System& system, std::string_view process, const Subject& subject);

}  // namespace plc::doctor
