#include "frontend-sfc/evaluation.h"

#include <algorithm>

#include "frontend-st/text.h"
#include "stdlib/library.h"

namespace plc::sfc {

using ir::LabelId;
using ir::ValueId;

namespace {

constexpr ir::TypeRef kTime = ir::ref_of(core::TypeId::kTime);

// Pins of a step that stand for the actions of its own (bytecode::DrawnKey).
constexpr std::size_t kEntryPin = 1;
constexpr std::size_t kMainPin = 2;
constexpr std::size_t kExitPin = 3;

std::uint32_t size_of(const std::vector<std::uint32_t>& list) { return static_cast<std::uint32_t>(list.size()); }

/// Numbers from 0 to `count` for which `has` holds.
template <class Has>
std::vector<std::uint32_t> those(std::size_t count, Has has) {
  std::vector<std::uint32_t> out;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (has(i)) out.push_back(i);
  }
  return out;
}

std::vector<std::uint32_t> places_in(const std::vector<std::uint32_t>& list, std::size_t count) {
  std::vector<std::uint32_t> out(count, kNoVariable);
  for (std::uint32_t i = 0; i < list.size(); ++i) out[list[i]] = i;
  return out;
}

}  // namespace

Evaluation::Evaluation(ir::Builder& builder, const PreparedChart& chart, const PreparedCharts& all)
    : b_(builder),
      chart_(chart),
      all_(all),
      c_(chart.chart),
      steps_tree_(builder, "steps", static_cast<std::uint32_t>(chart.steps.size())),
      controls_tree_(builder, "actions", static_cast<std::uint32_t>(chart.controls.size())),
      bodies_(those(chart.controls.size(), [&](std::uint32_t i) { return chart.controls[i].runs_body(); })),
      entries_(those(chart.steps.size(), [&](std::uint32_t i) { return chart.steps[i].entered != kNoVariable; })),
      exits_(those(chart.steps.size(), [&](std::uint32_t i) { return chart.steps[i].left != kNoVariable; })),
      joins_(those(chart.plan.groups.size(), [&](std::uint32_t i) { return !chart.plan.groups[i].is_simple(); })),
      place_in_bodies_(places_in(bodies_, chart.controls.size())),
      place_in_entries_(places_in(entries_, chart.steps.size())),
      place_in_exits_(places_in(exits_, chart.steps.size())),
      place_in_joins_(places_in(joins_, chart.plan.groups.size())),
      bodies_tree_(builder, "bodies", size_of(bodies_)),
      entries_tree_(builder, "entries", size_of(entries_)),
      exits_tree_(builder, "exits", size_of(exits_)),
      joins_tree_(builder, "joins", size_of(joins_)),
      started_(builder.hidden("started", ir::kBoolType)),
      moved_(builder.hidden("moved", ir::kBoolType)),
      final_scan_(builder.module().options.sfc_final_scan == core::FinalScan::kOn) {}

// ---- small code ---------------------------------------------------------------------------------------------------

void Evaluation::when(ValueId condition, const Emit& code) {
  const LabelId skip = b_.new_label();
  b_.jump_if_not(condition, skip);
  code();
  b_.bind(skip);
}

void Evaluation::unless(ValueId condition, const Emit& code) {
  const LabelId skip = b_.new_label();
  b_.jump_if(condition, skip);
  code();
  b_.bind(skip);
}

void Evaluation::foreign(const Emit& code) {
  const ir::PartScope part(b_, ir::Part::kPlain);
  code();
}

ValueId Evaluation::minus(ValueId a, ValueId b) {
  const ir::Operand operands[] = {ir::Operand::of(a), ir::Operand::of(b)};
  return *b_.call("SUB", operands, c_.at, kTime);
}

ValueId Evaluation::compare(std::string_view function, ValueId a, ValueId b) {
  const ir::Operand operands[] = {ir::Operand::of(a), ir::Operand::of(b)};
  return *b_.call(function, operands, c_.at);
}

std::optional<ValueId> Evaluation::duration(const std::string& text, const core::SourceRef& where,
                                            const std::string& what) {
  std::optional<ValueId> value;
  foreign([&] {
    const auto operand = st::lower_expression(text, where, b_, kTime);
    if (operand) value = b_.convert(*operand, kTime, what);
  });
  return value;
}

// ---- order of work ------------------------------------------------------------------------------------------------

void Evaluation::emit() {
  const ir::PartScope part(b_, ir::Part::kChart);
  b_.set_source(c_.at);
  end_ = b_.new_label();
  find_flags();
  take_time();
  set(Flag::kTrans, false);
  unless(load(started_), [&] {
    store(started_, true);
    begin();
  });
  obey_flags();
  when(load(moved_), [&] { take_over(); });
  probe_steps(ir::ProbeSide::kWhole);
  const auto if_quiet = [&](LabelId to) {
    if (quiet_ != kNoVariable) b_.jump_if(load(quiet_), to);
  };
  const LabelId compute = b_.new_label();
  if_quiet(compute);
  look_at_steps();
  run_step_actions(exits_tree_, exits_, &PreparedStep::left, &PreparedStep::exit);
  run_step_actions(entries_tree_, entries_, &PreparedStep::entered, &PreparedStep::entry);
  run_main_actions();
  b_.bind(compute);
  probe_steps(ir::ProbeSide::kOutput);
  compute_controls();
  probe_actions();
  if_quiet(end_);
  run_bodies();
  b_.set_source(c_.at);
  lower_drawing();
  test();
  if (has(Flag::kTrans)) b_.store(*flags_[static_cast<std::size_t>(Flag::kTrans)], load(moved_));
  b_.bind(end_);
}

// ---- what somebody may look at ------------------------------------------------------------------------------------

/// Which steps are active in this evaluation; for how long.
void Evaluation::probe_steps(ir::ProbeSide side) {
  for (std::uint32_t s = 0; s < c_.steps.size() && b_.notes_probes(); ++s) {
    const ir::PlaceId step = at(chart_.steps[s].variable);
    b_.probe(ir::ProbeKey::of(c_.steps[s].at, side), b_.field(step, side == ir::ProbeSide::kWhole ? 0 : 1));
  }
}

/// Which actions are executed in this evaluation, at each step that has them.
void Evaluation::probe_actions() {
  for (std::uint32_t s = 0; s < c_.steps.size() && b_.notes_probes(); ++s) {
    for (const Use& use : chart_.steps[s].uses) {
      const Control& control = chart_.controls[use.control];
      b_.probe(ir::ProbeKey::of(c_.steps[s].actions[use.association].at, ir::ProbeSide::kWhole),
               at(control.runs_body() ? control.due : control.active));
    }
  }
}

// ---- marking ------------------------------------------------------------------------------------------------------

/// The initial steps are entered in the evaluation that comes now.
void Evaluation::begin() {
  for (std::uint32_t s = 0; s < c_.steps.size(); ++s) {
    if (c_.steps[s].initial) enter(s);
  }
  store(moved_, true);
}

void Evaluation::enter(std::uint32_t step) {
  store(chart_.steps[step].on, true);
  steps_tree_.mark(step);
}

/// The marking that was decided becomes that of this evaluation: what leaves is off first, then what is entered is on,
/// so a step that is both stays active; its time begins anew.
void Evaluation::take_over() {
  store(moved_, false);
  steps_tree_.walk(
      [&](std::uint32_t s) {
        const PreparedStep& step = chart_.steps[s];
        b_.set_source(c_.steps[s].at);
        const ValueId on = load(step.on);
        const ValueId off = load(step.off);
        when(or_(on, off), [&] {
          const ValueId before = active(s);
          const ValueId after = or_(load(step.on), and_(before, b_.not_(load(step.off))));
          if (step.left != kNoVariable) {
            ValueId left = and_(before, b_.not_(after));
            if (restarted_ != kNoVariable) left = and_(left, b_.not_(load(restarted_)));
            when(left, [&] {
              store(step.left, true);
              exits_tree_.mark(place_in_exits_[s]);
            });
          }
          if (step.entered != kNoVariable) {
            when(and_(after, b_.not_(before)), [&] {
              store(step.entered, true);
              entries_tree_.mark(place_in_entries_[s]);
            });
          }
          b_.store(b_.field(at(step.variable), 0), after);
          when(load(step.on), [&] {
            store(step.since, now_);
            const std::uint32_t group = chart_.plan.group_of_step[s];
            if (group != Plan::kNone && place_in_joins_[group] != kNoVariable) joins_tree_.mark(place_in_joins_[group]);
          });
          store(step.on, false);
          store(step.off, false);
        });
      },
      [&](std::uint32_t s) { return active(s); });
}

/// Times of active steps, and which actions they ask for.
void Evaluation::look_at_steps() {
  steps_tree_.walk([&](std::uint32_t s) {
    const PreparedStep& step = chart_.steps[s];
    b_.set_source(c_.steps[s].at);
    when(active(s), [&] {
      b_.store(time(s), minus(now_, load(step.since)));
      watch_time(s);
      for (const Use& use : step.uses) {
        const Control& control = chart_.controls[use.control];
        store(control.inputs[use.input].active, true);
        unless(load(control.pending), [&] {
          store(control.pending, true);
          controls_tree_.mark(use.control);
        });
      }
    });
  });
}

void Evaluation::run_step_actions(Tree& tree, const std::vector<std::uint32_t>& steps, std::uint32_t PreparedStep::*due,
                                  Target PreparedStep::*action) {
  if (steps.empty()) return;
  const std::size_t pin = action == &PreparedStep::entry ? kEntryPin : kExitPin;
  tree.walk(
      [&](std::uint32_t i) {
        const PreparedStep& step = chart_.steps[steps[i]];
        b_.set_source(c_.steps[steps[i]].at);
        when(load(step.*due), [&] {
          store(step.*due, false);
          b_.probe_reached(ir::ProbeKey::of(c_.steps[steps[i]].at, ir::ProbeSide::kWhole, pin));
          run(step.*action);
        });
      },
      [&](std::uint32_t i) { return load(chart_.steps[steps[i]].*due); });
}

void Evaluation::run_main_actions() {
  const bool any = std::any_of(chart_.steps.begin(), chart_.steps.end(),
                               [](const PreparedStep& s) { return s.main.kind != Target::Kind::kNothing; });
  if (!any) return;
  steps_tree_.walk([&](std::uint32_t s) {
    const Target& main = chart_.steps[s].main;
    if (main.kind == Target::Kind::kNothing) return;
    b_.set_source(c_.steps[s].at);
    when(active(s), [&] {
      b_.probe_reached(ir::ProbeKey::of(c_.steps[s].at, ir::ProbeSide::kWhole, kMainPin));
      run(main);
    });
  });
}

/// Calls an action of the POU or of an instance.
void Evaluation::run(const Target& target) {
  foreign([&] {
    if (target.kind == Target::Kind::kAction) {
      b_.module().pous[target.action].freezes |= !final_scan_;
      b_.run_action(b_.self(), target.action);
    } else {
      st::lower_statements(target.name + "();", target.at, b_);
    }
  });
}

}  // namespace plc::sfc
