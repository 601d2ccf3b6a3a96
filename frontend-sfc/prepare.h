// Prepared charts of one POU: what they need in its instance, before any body of it is lowered, since all bodies may
// name the steps, and all charts share the control of an action.
//
// In: the bodies of a POU and of its actions. Out: charts with plans, step variables, controls. Does not belong here:
// code (evaluation.h).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/diagnostics.h"
#include "frontend-sfc/chart.h"
#include "frontend-sfc/plan.h"
#include "ir/ir.h"
#include "plcopen/project.h"

namespace plc::sfc {

inline constexpr std::uint32_t kNoVariable = 0xffffffffu;

/// What a name at a step, or the text there, is (6.7.4.1). Names are looked up as an action of the POU, then as a
/// variable, then as an action of an instance.
struct Target {
  enum class Kind : std::uint8_t {
    kNothing,   ///< reported
    kVariable,  ///< a BOOL, `name` is its text
    kAction,    ///< action `action` of the POU
    kPath,      ///< action of an instance, `name` is its path
  } kind = Kind::kNothing;
  std::string name;
  std::uint32_t action = 0;  ///< into Module::pous
  core::SourceRef at;
};

/// Associations of one action that add up to one input of its control: all of one qualifier, or one alone that has a
/// timer or an edge of its own. Variables of the instance.
struct Input {
  Qualifier qualifier = Qualifier::kN;
  std::uint32_t active = kNoVariable;  ///< BOOL: some step of it is active in this evaluation
  std::uint32_t memory = kNoVariable;  ///< BOOL: stored (S, SD, DS, SL), or active in the evaluation before (P, P0, P1)
  std::uint32_t timer = kNoVariable;   ///< TON
  std::string duration;
  core::SourceRef at;
};

/// The control of one action by one chart (6.7.4.5).
struct Control {
  Target target;
  std::vector<Input> inputs;
  std::uint32_t active = kNoVariable;   ///< BOOL: Q of the evaluation before
  std::uint32_t pending = kNoVariable;  ///< BOOL: there is something to look at
  std::uint32_t due = kNoVariable;      ///< BOOL, of bodies: it runs in this evaluation
  std::uint32_t ends = kNoVariable;     ///< BOOL, of bodies: it has its final scan in this evaluation
  [[nodiscard]] bool runs_body() const { return target.kind != Target::Kind::kVariable; }
};

/// Where an association of a step is: input `input` of control `control`.
struct Use {
  std::uint32_t control = 0;
  std::uint32_t input = 0;
  std::uint32_t association = 0;  ///< into Step::actions
};

struct PreparedStep {
  std::uint32_t variable = kNoVariable;  ///< the structure of X and T
  std::uint32_t since = kNoVariable;     ///< TIME of its activation
  std::uint32_t on = kNoVariable;        ///< BOOL: a transition enters it
  std::uint32_t off = kNoVariable;       ///< BOOL: a transition leaves it
  std::uint32_t left = kNoVariable;      ///< BOOL: its exit action is due; only with one
  std::uint32_t entered = kNoVariable;   ///< BOOL: its entry action is due; only with one
  Target entry, main, exit;
  std::vector<Use> uses;
};

struct PreparedChart {
  std::uint32_t pou = 0;   ///< whose body it is, into Module::pous: the POU or one of its actions
  std::uint32_t body = 0;  ///< into the bodies of that
  Chart chart;
  Plan plan;
  std::vector<PreparedStep> steps;
  std::vector<Control> controls;  ///< variables first, then bodies, each as first drawn or written
};

class PreparedCharts {
 public:
  std::vector<PreparedChart> charts;

  /// All steps by the names that bodies of the POU and its actions may use: those of its own chart, and those that one
  /// chart of an action alone has.
  void name_steps(ir::Module& module, std::uint32_t pou) const;
};

/// Reads all charts of `pou`, which is `index` in the module, and of its actions, and declares what they need. Actions
/// that are written at a step become actions of the POU. Reports every problem. Null when it has no chart.
std::unique_ptr<PreparedCharts> prepare(plcopen::Pou& pou, ir::Module& module, std::uint32_t index,
                                        core::Diagnostics& diagnostics);

}  // namespace plc::sfc
