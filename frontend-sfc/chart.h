// Chart: one sequential function chart, whether it was drawn or written: steps, transitions with the steps they leave
// and enter, actions with their qualifiers (IEC 61131-3:2013, 6.7).
//
// In: a body (read_drawing.cpp, read_text.cpp). Out: read by everything else of this folder; nothing after this
// knows which form a chart had. Does not belong here: what names mean (resolve.h), order of work (plan.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/diagnostics.h"
#include "plcopen/project.h"

namespace plc::sfc {

enum class Qualifier : std::uint8_t {
#define PLC_QUALIFIER(Name, word, timed) k##Name,
#include "frontend-sfc/qualifiers.def"
};
/// "N", "SD", ..
std::string_view qualifier_word(Qualifier qualifier);
/// In any letter case; empty is N. Nothing for words that the standard does not know, as DL of the XML schema.
std::optional<Qualifier> qualifier_of(std::string_view word);
/// L, D, SD, DS, SL.
bool needs_time(Qualifier qualifier);

/// One action at one step.
struct Association {
  Qualifier qualifier = Qualifier::kN;
  std::string name;  ///< of an action or a BOOL variable; empty for one that is written where it is drawn
  std::string text;  ///< of such an action, in ST
  core::SourceRef text_at;
  bool has_text = false;
  std::string duration;  ///< a literal or a variable, as written; empty = none
  core::SourceRef at;
};

struct Step {
  std::string name;
  bool initial = false;
  std::vector<Association> actions;
  std::string entry, main, exit;     ///< actions of CODESYS, or empty
  std::string min_time, max_time;    ///< TIME as written, or empty
  std::vector<std::uint32_t> leads;  ///< transitions from this step, in the order in which they are drawn or written
  core::SourceRef at;
};

struct Condition {
  enum class Kind : std::uint8_t {
    kMissing,
    kText,          ///< `text` is an expression of ST
    kInstructions,  ///< `text` is an instruction list that leaves the condition in the accumulator
    kReference,     ///< `text` names a transition of the POU
    kWire,          ///< drawn in Chart::drawing, which has the transition as an element
  } kind = Kind::kMissing;
  std::string text;
  core::SourceRef at;
  bool negated = false;  ///< of a text or reference: the transition goes on when it is FALSE
};

struct Transition {
  std::string name;  ///< or empty
  /// Each is a set of steps that it leaves together; with several, it leaves from any one of them.
  std::vector<std::vector<std::uint32_t>> sources;
  std::vector<std::uint32_t> targets;
  std::int64_t priority = -1;  ///< small numbers first; -1 = none, after all that have one
  Condition condition;
  core::SourceRef at;
};

struct Chart {
  std::string name;  ///< of the body: "Pump", "Pump.Start"
  std::vector<Step> steps;
  std::vector<Transition> transitions;
  plcopen::Body drawing;           ///< elements of LD and FBD between the steps, and the transitions they are wired to
  std::vector<std::string> flags;  ///< that its settings declare and use, "SFCInit"
  core::SourceRef at;
};

/// Reads a body in SFC, drawn or as text. Reports what is wrong with its form (P3101 to P3112); what is read is
/// consistent: all steps that transitions name exist.
Chart read_chart(const plcopen::Body& body, const std::string& name, core::Diagnostics& diagnostics);

/// read_drawing.cpp, read_text.cpp
Chart read_drawing(const plcopen::Body& body, const std::string& name, core::Diagnostics& diagnostics);
Chart read_text(const plcopen::Body& body, const std::string& name, core::Diagnostics& diagnostics);

/// A condition as texts have it: ":= a", "a;", "name := a" are all a.
void trim_condition(Condition& condition, std::string_view name);

}  // namespace plc::sfc
