// A check: one thing that the doctor looks at, as a row with its code. checks.def has the rows.
//
// In: the machine, the process, what is to run there. Out: what was seen, and what is wrong with it. Checks change
// nothing, and do not depend on each other. Does not belong here: printing.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/diagnostics.h"
#include "doctor/examine.h"
#include "doctor/process.h"
#include "doctor/system.h"

namespace plc::doctor {

struct Context {
  const System& system;
  const Process& process;
  const Subject& subject;
};

/// Something that is wrong.
struct Found {
  std::string seen;
  std::string help;
  std::optional<core::Code> code;          ///< nothing = the row's
  std::optional<core::Severity> severity;  ///< nothing = the code's
};

struct Outcome {
  std::string seen;  ///< when all is well, or why it could not be looked at
  bool known = true;
  std::vector<Found> found;
};

inline Outcome fine(std::string seen) { return {std::move(seen), true, {}}; }
inline Outcome unknown(std::string why) { return {std::move(why), false, {}}; }
Outcome missing(const std::string& file);
inline Outcome wrong(std::string seen, std::string help) {
  return {{}, true, {{std::move(seen), std::move(help), {}, {}}}};
}

/// Commas between.
std::string joined(const std::vector<std::string>& words);
/// "0-3,5".
std::string list_text(const std::vector<int>& numbers);

#define PLC_CHECK(code, area, what, function) Outcome function(const Context& context);
#include "doctor/checks.def"

}  // namespace plc::doctor
