// Charts that are written become drawings: what a drawn chart has between its steps, bars and jumps, is added.
#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "drawings/sheet.h"
#include "frontend-sfc/chart.h"

namespace plc::drawings {
namespace {

class ChartDrawer {
 public:
  explicit ChartDrawer(const sfc::Chart& chart) : chart_(chart) {}

  Sheet draw() {
    for (const sfc::Step& step : chart_.steps) add_step(step);
    for (const sfc::Transition& transition : chart_.transitions) add_transition(transition);
    find_jumps();
    for (std::uint32_t t = 0; t < chart_.transitions.size(); ++t) draw_sources(t);
    for (std::uint32_t s = 0; s < chart_.steps.size(); ++s) {
      join(exits_[s], step_at_[s], ElementKind::kSelectionDivergence, true);
    }
    for (std::uint32_t t = 0; t < chart_.transitions.size(); ++t) draw_targets(t);
    for (std::uint32_t s = 0; s < chart_.steps.size(); ++s) {
      join(entries_[s], step_at_[s], ElementKind::kSelectionConvergence, false);
    }
    sheet_.pin_places.resize(sheet_.elements.size());
    sheet_.drawn_lines.resize(sheet_.wires.size());
    return std::move(sheet_);
  }

 private:
  std::uint32_t add(ElementKind kind) {
    DrawnElement& e = sheet_.elements.emplace_back();
    e.kind = kind;
    DrawnPin in, out;
    in.pin = out.pin = kNoPin;
    out.output = true;
    e.pins = {in, out};
    return static_cast<std::uint32_t>(sheet_.elements.size() - 1);
  }
  void wire(std::uint32_t from, std::uint32_t to) { sheet_.wires.push_back({from, 1, to, 0, {}}); }

  void add_step(const sfc::Step& step) {
    step_at_.push_back(add(ElementKind::kStep));
    {
      DrawnElement& e = sheet_.elements.back();
      e.text = step.name;
      e.initial = step.initial;
      e.line = step.at.line;
      e.column = step.at.column;
      const auto own = [&](const char* when, const std::string& name) {
        if (!name.empty()) e.actions.push_back({when, name, {}, {}, 0, 0});
      };
      own("entry", step.entry);
      own("main", step.main);
      own("exit", step.exit);
    }
    if (step.actions.empty()) return;
    const std::uint32_t block = add(ElementKind::kActionBlock);
    for (const sfc::Association& action : step.actions) {
      sheet_.elements.back().actions.push_back({std::string(sfc::qualifier_word(action.qualifier)),
                                                action.name.empty() ? action.text : action.name,
                                                action.duration,
                                                {},
                                                action.at.line,
                                                action.at.column});
    }
    wire(step_at_.back(), block);
  }

  void add_transition(const sfc::Transition& transition) {
    transition_at_.push_back(add(ElementKind::kTransition));
    DrawnElement& e = sheet_.elements.back();
    e.text = transition.condition.text;
    e.priority = transition.priority;
    e.line = transition.at.line;
    e.column = transition.at.column;
  }

  /// Transitions that lead back, on ways that begin at the initial steps, are drawn as jumps.
  void find_jumps() {
    jumps_.resize(chart_.transitions.size());
    enum : std::uint8_t { kNew, kOpen, kDone };
    std::vector<std::uint8_t> state(chart_.steps.size(), kNew);
    const auto visit = [&](std::uint32_t start) {
      if (state[start] != kNew) return;
      struct At {
        std::uint32_t step;
        std::size_t lead = 0, target = 0;
      };
      std::vector<At> path = {{start}};
      state[start] = kOpen;
      while (!path.empty()) {
        At& at = path.back();
        const auto& leads = chart_.steps[at.step].leads;
        if (at.lead == leads.size()) {
          state[at.step] = kDone;
          path.pop_back();
          continue;
        }
        const std::uint32_t t = leads[at.lead];
        const auto& targets = chart_.transitions[t].targets;
        if (at.target == targets.size()) {
          ++at.lead;
          at.target = 0;
          continue;
        }
        const std::uint32_t to = targets[at.target++];
        if (state[to] == kOpen) {
          jumps_[t].push_back(to);
        } else if (state[to] == kNew) {
          state[to] = kOpen;
          path.push_back({to});
        }
      }
    };
    for (const bool any : {false, true}) {
      for (std::uint32_t s = 0; s < chart_.steps.size(); ++s) {
        if (any || chart_.steps[s].initial) visit(s);
      }
    }
    exits_.resize(chart_.steps.size());
    entries_.resize(chart_.steps.size());
  }

  /// What leads to a transition: a step, several at once, or any of several of these.
  void draw_sources(std::uint32_t t) {
    std::vector<std::uint32_t> ways;
    const auto& sources = chart_.transitions[t].sources;
    std::uint32_t into = transition_at_[t];
    if (sources.size() > 1) {
      into = add(ElementKind::kSelectionConvergence);
      wire(into, transition_at_[t]);
    }
    for (const auto& set : sources) {
      std::uint32_t target = into;
      if (set.size() > 1) {
        target = add(ElementKind::kSimultaneousConvergence);
        wire(target, into);
      }
      for (const std::uint32_t step : set) exits_[step].push_back(target);
    }
  }

  void draw_targets(std::uint32_t t) {
    const auto& targets = chart_.transitions[t].targets;
    std::uint32_t from = transition_at_[t];
    if (targets.size() > 1) {
      from = add(ElementKind::kSimultaneousDivergence);
      wire(transition_at_[t], from);
    }
    for (const std::uint32_t step : targets) {
      if (std::find(jumps_[t].begin(), jumps_[t].end(), step) == jumps_[t].end()) {
        entries_[step].push_back(from);
        continue;
      }
      const std::uint32_t jump = add(ElementKind::kJumpStep);
      sheet_.elements[jump].text = chart_.steps[step].name;
      sheet_.elements[jump].pins.pop_back();
      wire(from, jump);
    }
  }

  /// Wires between an element and several others: through a bar.
  void join(const std::vector<std::uint32_t>& others, std::uint32_t one, ElementKind bar, bool outwards) {
    std::uint32_t at = one;
    if (others.size() > 1) {
      at = add(bar);
      outwards ? wire(one, at) : wire(at, one);
    }
    for (const std::uint32_t other : others) outwards ? wire(at, other) : wire(other, at);
  }

  const sfc::Chart& chart_;
  Sheet sheet_;
  std::vector<std::uint32_t> step_at_, transition_at_;
  std::vector<std::vector<std::uint32_t>> jumps_;            ///< by transition: steps it leads back to
  std::vector<std::vector<std::uint32_t>> exits_, entries_;  ///< by step: elements behind and before it
};

}  // namespace

Sheet read_chart_sheet(const plcopen::Body& body, core::Diagnostics& quiet) {
  const sfc::Chart chart = sfc::read_chart(body, {}, quiet);
  return ChartDrawer(chart).draw();
}

}  // namespace plc::drawings
