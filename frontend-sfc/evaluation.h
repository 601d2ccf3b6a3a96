// Evaluation: the code of one chart. It acts, then tests: takes over the marking decided last time; runs exit, entry
// and main actions; computes the control of each action and runs what is active; tests the transitions of active steps
// and decides the next marking (docs/adr/0036).
//
// In: a prepared chart. Out: IR through the Builder of its body. Split: evaluation.cpp is the order of work and the
// marking, control.cpp the actions, conditions.cpp the transitions, flags.cpp what CODESYS adds. Cost: what is active
// or stored is looked at, not what there is (tree.h). Does not belong here: names of actions (resolve.h).
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "frontend-sfc/prepare.h"
#include "frontend-sfc/tree.h"
#include "ir/builder.h"

namespace plc::sfc {

enum class Flag : std::uint8_t {
#define PLC_SFC_FLAG(Name, name, Type) k##Name,
#include "frontend-sfc/flags.def"
};

class Evaluation {
 public:
  Evaluation(ir::Builder& builder, const PreparedChart& chart, const PreparedCharts& all);
  void emit();

 private:
  using Emit = std::function<void()>;

  // evaluation.cpp: small code
  [[nodiscard]] ir::PlaceId at(std::uint32_t variable) { return b_.variable(variable); }
  ir::ValueId load(std::uint32_t variable) { return b_.load(at(variable)); }
  void store(std::uint32_t variable, ir::ValueId value) { b_.store(at(variable), value); }
  void store(std::uint32_t variable, bool value) { store(variable, b_.constant_bool(value)); }
  ir::ValueId and_(ir::ValueId a, ir::ValueId b) { return b_.logic(ir::Op::kAnd, a, b); }
  ir::ValueId or_(ir::ValueId a, ir::ValueId b) { return b_.logic(ir::Op::kOr, a, b); }
  void when(ir::ValueId condition, const Emit& code);
  void unless(ir::ValueId condition, const Emit& code);
  /// User code: what it compiles to is its own, for lint.
  void foreign(const Emit& code);
  ir::ValueId active(std::uint32_t step) { return b_.load(b_.field(at(chart_.steps[step].variable), 0)); }
  ir::PlaceId time(std::uint32_t step) { return b_.field(at(chart_.steps[step].variable), 1); }
  ir::ValueId minus(ir::ValueId a, ir::ValueId b);
  ir::ValueId compare(std::string_view function, ir::ValueId a, ir::ValueId b);
  /// A TIME as written at a step; nothing, and reported, when it is none.
  std::optional<ir::ValueId> duration(const std::string& text, const core::SourceRef& where, const std::string& what);

  // evaluation.cpp: what somebody may look at
  void probe_steps(ir::ProbeSide side);
  void probe_actions();

  // evaluation.cpp: the marking
  void begin();
  void take_over();
  void look_at_steps();
  void enter(std::uint32_t step);
  void run_step_actions(Tree& tree, const std::vector<std::uint32_t>& steps, std::uint32_t PreparedStep::*due,
                        Target PreparedStep::*action);
  void run_main_actions();
  void run(const Target& target);

  // control.cpp
  void compute_controls();
  void compute(std::uint32_t control);
  /// The BOOLs of one input: its part of Q, and what keeps it worth looking at.
  struct Part {
    ir::ValueId q{};
    ir::ValueId pulse{};  ///< of P0 and P1: once, whatever R does
    ir::ValueId kept{};
  };
  Part part_of(const Input& input, ir::ValueId reset);
  ir::ValueId on_delay(const Input& input, ir::ValueId in);
  void reset_everywhere(const Control& control);
  void drive(const Control& control, ir::ValueId q, ir::ValueId reset);
  void run_bodies();

  // conditions.cpp
  void lower_drawing();
  void test();
  void test_group(const Group& group);
  void test_transition(const Group& group, std::uint32_t transition, ir::LabelId end);
  ir::ValueId enabled(const Group& group, const std::vector<std::uint32_t>& sources);
  std::optional<ir::ValueId> condition(std::uint32_t transition);
  void clear(const Transition& transition, const std::vector<std::uint32_t>& sources);

  // flags.cpp
  void find_flags();
  [[nodiscard]] bool has(Flag flag) const { return flags_[static_cast<std::size_t>(flag)].has_value(); }
  ir::ValueId flag(Flag flag) { return b_.load(*flags_[static_cast<std::size_t>(flag)]); }
  void set(Flag flag, bool value);
  void set(Flag flag, const std::string& text);
  void obey_flags();
  void restart();
  void clear_errors();
  void watch_time(std::uint32_t step);
  void take_time();

  ir::Builder& b_;
  const PreparedChart& chart_;
  const PreparedCharts& all_;
  const Chart& c_;
  Tree steps_tree_;
  Tree controls_tree_;
  std::vector<std::uint32_t> bodies_, entries_, exits_, joins_;  ///< controls that run a body; steps; groups of several
  std::vector<std::uint32_t> place_in_bodies_, place_in_entries_, place_in_exits_, place_in_joins_;
  Tree bodies_tree_, entries_tree_, exits_tree_, joins_tree_;
  std::uint32_t started_, moved_;  ///< BOOL, hidden: the chart was evaluated before; a transition cleared
  std::map<std::uint32_t, std::uint32_t> wires_;  ///< by transition: hidden BOOL with the condition that is drawn
  ir::ValueId now_{};
  ir::LabelId end_{};
  bool final_scan_;
  std::array<std::optional<ir::PlaceId>, 16> flags_{};
  std::uint32_t quiet_ = kNoVariable;      ///< BOOL: SFCInit holds the chart
  std::uint32_t restarted_ = kNoVariable;  ///< BOOL: SFCInit or SFCReset began it anew
  std::uint32_t quitting_ = kNoVariable, tipped_ = kNoVariable, tip_ = kNoVariable;
  std::uint32_t last_time_ = kNoVariable, lost_time_ = kNoVariable;
};

}  // namespace plc::sfc
