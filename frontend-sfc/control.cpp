// Controls of actions (IEC 61131-3:2013, 6.7.4.5): what the associations of one action add up to.
//
//   Q = NOT R AND (N OR S_FF OR (L AND NOT L_TMR) OR D_TMR OR P_EDGE OR SD_TMR OR DS_FF OR (SL_FF AND NOT SL_TMR))
//
// P0 and P1 are pulses beside Q. A variable is TRUE in each evaluation in which Q is, and becomes FALSE once when Q
// falls and whenever R is active. A body runs while Q is TRUE, and once more with the final scan.
#include <algorithm>

#include "frontend-sfc/evaluation.h"
#include "frontend-sfc/resolve.h"
#include "frontend-st/text.h"

namespace plc::sfc {

using ir::LabelId;
using ir::ValueId;

void Evaluation::compute_controls() {
  controls_tree_.walk(
      [&](std::uint32_t i) {
        b_.set_source(chart_.controls[i].target.at);
        when(load(chart_.controls[i].pending), [&] { compute(i); });
      },
      [&](std::uint32_t i) { return load(chart_.controls[i].pending); });
}

ValueId Evaluation::on_delay(const Input& input, ValueId in) {
  const ir::PlaceId timer = at(input.timer);
  b_.store(*b_.member(timer, "IN"), in);
  if (const auto time = duration(input.duration, input.at, "time of an action")) {
    b_.store(*b_.member(timer, "PT"), *time);
  }
  b_.run(timer);
  return b_.load(*b_.member(timer, "Q"));
}

/// `reset`: R is active; invalid when the action has no R in this chart.
Evaluation::Part Evaluation::part_of(const Input& input, ValueId reset) {
  const ValueId in = load(input.active);
  const auto stored = [&](ValueId set) {
    ValueId value = or_(load(input.memory), set);
    if (reset.valid()) value = and_(value, b_.not_(reset));
    store(input.memory, value);
    return value;
  };
  const auto edge = [&](bool rising) {
    const ValueId before = load(input.memory);
    const ValueId pulse = rising ? and_(in, b_.not_(before)) : and_(before, b_.not_(in));
    store(input.memory, in);
    return pulse;
  };
  switch (input.qualifier) {
    case Qualifier::kN:
      return {in, {}, in};
    case Qualifier::kR:
      return {{}, {}, in};
    case Qualifier::kS: {
      const ValueId value = stored(in);
      return {value, {}, or_(value, in)};
    }
    case Qualifier::kL:
      return {and_(in, b_.not_(on_delay(input, in))), {}, in};
    case Qualifier::kD:
      return {on_delay(input, in), {}, in};
    case Qualifier::kP:
      return {edge(true), {}, in};
    case Qualifier::kP1:
      return {{}, edge(true), in};
    case Qualifier::kP0:
      return {{}, edge(false), in};
    case Qualifier::kSD: {
      const ValueId value = stored(in);
      return {on_delay(input, value), {}, or_(value, in)};
    }
    case Qualifier::kDS: {
      const ValueId value = stored(on_delay(input, in));
      return {value, {}, or_(value, in)};
    }
    case Qualifier::kSL: {
      const ValueId value = stored(in);
      return {and_(value, b_.not_(on_delay(input, value))), {}, or_(value, in)};
    }
  }
  return {};
}

void Evaluation::compute(std::uint32_t index) {
  const Control& control = chart_.controls[index];
  ValueId reset{};
  for (const Input& input : control.inputs) {
    if (input.qualifier == Qualifier::kR) reset = load(input.active);
  }
  ValueId q{}, pulse{}, kept{};
  const auto add = [&](ValueId& sum, ValueId value) {
    if (value.valid()) sum = sum.valid() ? or_(sum, value) : value;
  };
  for (const Input& input : control.inputs) {
    const Part part = part_of(input, reset);
    add(q, part.q);
    add(pulse, part.pulse);
    add(kept, part.kept);
  }
  if (!q.valid()) q = b_.constant_bool(false);
  if (reset.valid()) {
    q = and_(q, b_.not_(reset));
    when(reset, [&] { reset_everywhere(control); });
  }
  if (!control.runs_body()) {
    add(q, pulse);
    drive(control, q, reset);
  } else {
    const ValueId due = pulse.valid() ? or_(q, pulse) : q;
    store(control.due, due);
    ValueId run = due;
    if (final_scan_) {
      ValueId ends = and_(load(control.active), b_.not_(due));
      if (restarted_ != kNoVariable) ends = and_(ends, b_.not_(load(restarted_)));
      store(control.ends, ends);
      run = or_(due, ends);
    }
    when(run, [&] { bodies_tree_.mark(place_in_bodies_[index]); });
  }
  store(control.active, q);
  store(control.pending, or_(q, kept));
  for (const Input& input : control.inputs) store(input.active, false);
}

/// R clears what other charts of the POU store for the action, too.
void Evaluation::reset_everywhere(const Control& control) {
  const std::string key = key_of(control.target);
  for (const PreparedChart& chart : all_.charts) {
    if (&chart == &chart_) continue;
    for (const Control& other : chart.controls) {
      if (key_of(other.target) != key) continue;
      for (const Input& input : other.inputs) {
        const bool stores = input.qualifier == Qualifier::kS || input.qualifier == Qualifier::kSD ||
                            input.qualifier == Qualifier::kDS || input.qualifier == Qualifier::kSL;
        if (!stores) continue;
        store(input.memory, false);
        if (input.timer == kNoVariable || input.qualifier == Qualifier::kDS) continue;
        b_.store(*b_.member(at(input.timer), "IN"), b_.constant_bool(false));
        b_.run(at(input.timer));
      }
      // The variable is FALSE from now on: it does not fall once more when that chart is evaluated.
      if (!other.runs_body()) store(other.active, false);
    }
  }
}

void Evaluation::drive(const Control& control, ValueId q, ValueId reset) {
  std::optional<ir::PlaceId> place;
  foreign([&] { place = st::lower_place(control.target.name, control.target.at, b_, true); });
  if (!place) return;
  if (b_.type_of(*place) != ir::kBoolType) {
    b_.report(core::Code::P3106, control.target.at,
              "action \"" + control.target.name + "\" of a step is a variable of type " +
                  b_.module().types.name_of(b_.type_of(*place)) + ", not BOOL",
              "name a BOOL variable, or an action that assigns it");
    return;
  }
  const LabelId done = b_.new_label();
  const LabelId off = b_.new_label();
  b_.jump_if_not(q, off);
  b_.store(*place, b_.constant_bool(true));
  b_.jump(done);
  b_.bind(off);
  ValueId falls = load(control.active);
  const std::string key = key_of(control.target);
  for (const PreparedChart& chart : all_.charts) {
    if (&chart == &chart_) continue;
    for (const Control& other : chart.controls) {
      if (key_of(other.target) == key) falls = and_(falls, b_.not_(load(other.active)));
    }
  }
  if (reset.valid()) falls = or_(falls, reset);
  b_.jump_if_not(falls, done);
  b_.store(*place, b_.constant_bool(false));
  b_.bind(done);
}

/// First what ends, then what is active, each body once.
void Evaluation::run_bodies() {
  if (bodies_.empty()) return;
  const auto each = [&](std::uint32_t Control::*when_set, const std::function<ValueId(std::uint32_t)>& alive) {
    bodies_tree_.walk(
        [&](std::uint32_t i) {
          const Control& control = chart_.controls[bodies_[i]];
          b_.set_source(control.target.at);
          when(load(control.*when_set), [&] {
            store(control.*when_set, false);
            run(control.target);
          });
        },
        alive);
  };
  if (final_scan_) each(&Control::ends, nullptr);
  each(&Control::due, [&](std::uint32_t i) { return load(chart_.controls[bodies_[i]].due); });
}

}  // namespace plc::sfc
