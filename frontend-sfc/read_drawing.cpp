// Drawn charts: wires between steps, divergences, convergences and transitions become the sets of steps that each
// transition leaves and enters. An order among choices is left to right, then that of the document.
#include <algorithm>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>

#include "core/text.h"
#include "frontend-sfc/chart.h"
#include "frontend-sfc/macro_steps.h"

namespace plc::sfc {

using core::Code;
using core::ElementKind;
using plcopen::Element;

namespace {

constexpr std::uint32_t kNone = 0xffffffffu;
/// Ways on which one transition may leave; above what anybody draws.
constexpr std::size_t kMaxAlternatives = 256;

using StepSet = std::vector<std::uint32_t>;

bool is_chart_element(ElementKind kind) {
  switch (kind) {
    case ElementKind::kStep:
    case ElementKind::kJumpStep:
    case ElementKind::kTransition:
    case ElementKind::kSelectionDivergence:
    case ElementKind::kSelectionConvergence:
    case ElementKind::kSimultaneousDivergence:
    case ElementKind::kSimultaneousConvergence:
    case ElementKind::kActionBlock:
      return true;
    default:
      return false;
  }
}

class DrawingReader {
 public:
  DrawingReader(const plcopen::Body& body, const std::string& pou, core::Diagnostics& diagnostics)
      : body_(body), pou_(pou), diagnostics_(diagnostics) {}

  Chart read() {
    index();
    connect();
    read_steps();
    read_action_blocks();
    read_transitions();
    order_choices();
    read_free_jumps();
    keep_drawing();
    return std::move(chart_);
  }

 private:
  void report(Code code, const core::SourceRef& at, std::string message, std::string help) {
    diagnostics_.report(code, at, pou_, std::move(message), std::move(help));
  }
  [[nodiscard]] const Element& element(std::uint32_t i) const { return body_.elements[i]; }
  [[nodiscard]] ElementKind kind(std::uint32_t i) const { return body_.elements[i].kind; }
  [[nodiscard]] std::string named(std::uint32_t i) const {
    const Element& e = element(i);
    std::string text(core::element_word(e.kind));
    if (e.kind == ElementKind::kStep || e.kind == ElementKind::kJumpStep) return text + " \"" + e.text + '"';
    return text + (e.at.local_id >= 0 ? " " + std::to_string(e.at.local_id) : "");
  }
  [[nodiscard]] bool left_out(std::uint32_t i) const {
    return element(i).chart != nullptr && element(i).chart->excluded;
  }

  void index() {
    for (std::uint32_t i = 0; i < body_.elements.size(); ++i) {
      if (element(i).at.local_id >= 0) by_id_.emplace(element(i).at.local_id, i);
      if (left_out(i)) {
        report(Code::P3118, element(i).at, named(i) + " is excluded from the build and left out",
               "delete it, or include it in the build");
      }
    }
  }

  /// The element that a wire comes from; kNone, and reported, when it is not drawn.
  std::uint32_t source_of(const plcopen::Connection& connection) {
    if (connection.refused) return kNone;
    const auto found = by_id_.find(connection.ref_local_id);
    if (found != by_id_.end()) return found->second;
    report(Code::P3103, connection.at,
           "wire comes from localId " + std::to_string(connection.ref_local_id) + ", which is not drawn in this chart",
           "draw the wire again");
    return kNone;
  }

  void connect() {
    sources_.resize(body_.elements.size());
    readers_.resize(body_.elements.size());
    for (std::uint32_t i = 0; i < body_.elements.size(); ++i) {
      if (!is_chart_element(kind(i))) continue;
      for (const plcopen::Pin& pin : element(i).inputs) {
        for (const plcopen::Connection& connection : pin.connections) {
          const std::uint32_t from = source_of(connection);
          if (from == kNone) continue;
          sources_[i].push_back(from);
          readers_[from].push_back(i);
        }
      }
    }
    for (auto& readers : readers_) {
      const bool placed = std::all_of(readers.begin(), readers.end(), [&](auto i) { return element(i).has_position; });
      if (!placed) continue;
      std::stable_sort(readers.begin(), readers.end(), [&](auto a, auto b) { return element(a).x < element(b).x; });
    }
  }

  // ---- steps and actions ----

  /// The schema has negated steps and action blocks, and does not say what they do.
  void refuse_negation(std::uint32_t i) {
    if (!element(i).negated) return;
    report(Code::P3109, element(i).at, named(i) + " is negated, which has no meaning that tools agree on",
           "delete the negation, and draw what is meant");
  }

  void read_steps() {
    step_of_.assign(body_.elements.size(), kNone);
    for (std::uint32_t i = 0; i < body_.elements.size(); ++i) {
      const Element& e = element(i);
      if (e.kind != ElementKind::kStep || left_out(i) || e.text.empty()) continue;
      refuse_negation(i);
      step_of_[i] = static_cast<std::uint32_t>(chart_.steps.size());
      Step step;
      step.name = e.text;
      step.initial = e.chart->initial;
      step.entry = e.chart->entry;
      step.main = e.chart->main;
      step.exit = e.chart->exit;
      step.min_time = e.chart->min_time;
      step.max_time = e.chart->max_time;
      step.at = e.at;
      const auto [known, fresh] = by_name_.emplace(core::folded(e.text), step_of_[i]);
      if (!fresh) {
        report(Code::P3102, e.at,
               "step \"" + e.text + "\" is drawn twice, first at line " +
                   std::to_string(chart_.steps[known->second].at.line),
               "rename one of them");
      }
      chart_.steps.push_back(std::move(step));
    }
  }

  void read_action_blocks() {
    for (std::uint32_t i = 0; i < body_.elements.size(); ++i) {
      if (kind(i) != ElementKind::kActionBlock) continue;
      refuse_negation(i);
      if (sources_[i].empty()) {
        report(Code::P3112, element(i).at, "action block is at no step: its actions are never executed",
               "wire it to a step, or delete it");
        continue;
      }
      for (const std::uint32_t from : sources_[i]) {
        if (kind(from) != ElementKind::kStep) {
          report(Code::P3103, element(i).at, "action block is wired to a " + named(from) + ", which has no actions",
                 "wire it to a step");
        } else if (step_of_[from] != kNone) {
          for (const plcopen::ActionLink& link : element(i).actions) add_action(chart_.steps[step_of_[from]], link);
        }
      }
    }
  }

  void add_action(Step& step, const plcopen::ActionLink& link) {
    const auto qualifier = qualifier_of(link.qualifier);
    if (!qualifier) {
      report(Code::P3107, link.at, "qualifier \"" + link.qualifier + "\" at step \"" + step.name + "\" is not known",
             "qualifiers are N, R, S, L, D, P, P0, P1, SD, DS and SL");
      return;
    }
    Association action;
    action.qualifier = *qualifier;
    action.name = std::string(core::trimmed(link.name));
    action.text = link.text;
    action.text_at = link.text_at;
    action.has_text = action.name.empty() && !core::trimmed(link.text).empty();
    action.duration = std::string(core::trimmed(link.duration));
    action.at = link.at;
    if (!action.name.empty() && !core::trimmed(link.text).empty()) {
      report(Code::P3106, link.at, "action \"" + action.name + "\" at step \"" + step.name + "\" has a text as well",
             "it would be one or the other: delete the name or the text");
      return;
    }
    if (action.name.empty() && !action.has_text) {
      report(Code::P3106, link.at, "action at step \"" + step.name + "\" names nothing and has no text",
             "name an action or a BOOL variable, or delete it");
      return;
    }
    step.actions.push_back(std::move(action));
  }

  // ---- transitions ----

  /// Sets of steps that are active before what follows element `i`. Jumps have no output and count for nothing.
  bool before(std::uint32_t i, std::vector<StepSet>& out, std::set<std::uint32_t>& path) {
    if (!path.insert(i).second) return wrong(i, "leads back to itself without a step between");
    bool fine = true;
    switch (kind(i)) {
      case ElementKind::kStep:
        if (step_of_[i] != kNone) out.push_back({step_of_[i]});
        break;
      case ElementKind::kSelectionDivergence:
      case ElementKind::kSelectionConvergence:
        for (const std::uint32_t from : sources_[i]) {
          if (kind(from) == ElementKind::kJumpStep) continue;
          fine = before(from, out, path) && fine;
        }
        break;
      case ElementKind::kSimultaneousConvergence: {
        std::vector<StepSet> product = {{}};
        for (const std::uint32_t from : sources_[i]) {
          if (kind(from) == ElementKind::kJumpStep) {
            report(Code::P3113, element(i).at,
                   "simultaneousConvergence waits for a branch that leaves by " + named(from) +
                       ": it does not wait for it, and what is active there stays",
                   "end the branch with a step that waits");
            continue;
          }
          std::vector<StepSet> branch;
          fine = before(from, branch, path) && fine;
          std::vector<StepSet> next;
          for (const StepSet& left : product) {
            for (const StepSet& right : branch) {
              StepSet both = left;
              both.insert(both.end(), right.begin(), right.end());
              std::sort(both.begin(), both.end());
              both.erase(std::unique(both.begin(), both.end()), both.end());
              next.push_back(std::move(both));
              if (next.size() > kMaxAlternatives) return wrong(i, "joins more than 256 combinations of steps");
            }
          }
          product = std::move(next);
        }
        for (StepSet& set : product) {
          if (!set.empty()) out.push_back(std::move(set));
        }
        break;
      }
      default:
        fine = wrong(i, "leads to a transition without a step between");
    }
    path.erase(i);
    return fine;
  }

  bool wrong(std::uint32_t i, const std::string& why) {
    report(Code::P3103, element(i).at, named(i) + " " + why, "between two transitions there is a step");
    return false;
  }

  /// Steps that become active after element `i`.
  bool after(std::uint32_t i, StepSet& out, std::set<std::uint32_t>& path) {
    if (!path.insert(i).second) return wrong(i, "leads back to itself without a step between");
    switch (kind(i)) {
      case ElementKind::kStep:
        if (step_of_[i] != kNone) out.push_back(step_of_[i]);
        return true;
      case ElementKind::kJumpStep: {
        const auto target = by_name_.find(core::folded(element(i).text));
        if (target == by_name_.end()) {
          report(Code::P3104, element(i).at,
                 "jump goes to step \"" + element(i).text + "\", which is not in this chart",
                 "correct the name, or draw the step");
          return false;
        }
        out.push_back(target->second);
        return true;
      }
      case ElementKind::kSelectionConvergence:
      case ElementKind::kSimultaneousDivergence: {
        if (readers_[i].empty()) return wrong(i, "leads nowhere");
        bool fine = true;
        for (const std::uint32_t to : readers_[i]) fine = after(to, out, path) && fine;
        return fine;
      }
      case ElementKind::kActionBlock:
        return true;
      default:
        return wrong(i, "comes after a transition without a step between");
    }
  }

  void read_transitions() {
    transition_of_.assign(body_.elements.size(), kNone);
    for (std::uint32_t i = 0; i < body_.elements.size(); ++i) {
      if (kind(i) != ElementKind::kTransition || left_out(i)) continue;
      const Element& e = element(i);
      Transition transition;
      transition.at = e.at;
      transition.priority = e.chart->priority;
      bool fine = true;
      std::set<std::uint32_t> path;
      for (const std::uint32_t from : sources_[i]) fine = before(from, transition.sources, path) && fine;
      path.clear();
      for (const std::uint32_t to : readers_[i]) fine = after(to, transition.targets, path) && fine;
      std::sort(transition.targets.begin(), transition.targets.end());
      transition.targets.erase(std::unique(transition.targets.begin(), transition.targets.end()),
                               transition.targets.end());
      if (readers_[i].size() > 1 && fine) {
        report(Code::P3103, e.at, "transition leads to several elements",
               "draw a simultaneousDivergence where several steps begin together");
        fine = false;
      }
      if (fine && (transition.sources.empty() || transition.targets.empty())) {
        report(Code::P3103, e.at,
               transition.sources.empty() ? "no step leads to this transition" : "this transition leads to no step",
               "wire it between two steps, or to a jump");
        fine = false;
      }
      read_condition(i, transition);
      if (!fine) continue;
      transition_of_[i] = static_cast<std::uint32_t>(chart_.transitions.size());
      chart_.transitions.push_back(std::move(transition));
    }
  }

  void read_condition(std::uint32_t i, Transition& transition) {
    const plcopen::ChartPart& part = *element(i).chart;
    Condition& condition = transition.condition;
    condition.at = part.text_at.line != 0 ? part.text_at : element(i).at;
    condition.negated = part.negated;
    if (!part.reference.empty()) {
      condition.kind = Condition::Kind::kReference;
      condition.text = part.reference;
      return;
    }
    if (!part.text.empty()) {
      condition.kind = Condition::Kind::kText;
      condition.text = part.text;
      trim_condition(condition, {});
      return;
    }
    const auto& wires = part.condition.connections;
    if (wires.empty()) {
      if (part.condition.expression.empty()) {
        report(Code::P3105, element(i).at, "transition has no condition", "write one; TRUE goes on at once");
      } else {
        condition.kind = Condition::Kind::kText;
        condition.text = part.condition.expression;
      }
      return;
    }
    condition.kind = Condition::Kind::kWire;
    condition.negated = false;  // its pin is
    if (wires.size() != 1) return;
    // CODESYS and TwinCAT have the text of the condition in a variable of its own: it is tested where it counts.
    const auto found = by_id_.find(wires.front().ref_local_id);
    if (found == by_id_.end() || kind(found->second) != ElementKind::kInVariable) return;
    const Element& text = element(found->second);
    if (text.negated || text.edge != plcopen::Edge::kNone || text.storage != plcopen::Storage::kNone) return;
    condition.kind = Condition::Kind::kText;
    condition.negated = part.negated;
    condition.text = text.text;
    condition.at = text.text_at;
    condition.at.kind = ElementKind::kTransition;
    condition.at.local_id = element(i).at.local_id;
    trim_condition(condition, {});
    texts_.insert(found->second);
    if (condition.text.empty()) {
      condition.kind = Condition::Kind::kMissing;
      report(Code::P3105, element(i).at, "transition has no condition", "write one; TRUE goes on at once");
    }
  }

  // ---- choices ----

  /// Transitions that read element `i` through divergences and convergences, nested choices in the place of their
  /// branch.
  void leads_of(std::uint32_t i, std::vector<std::uint32_t>& out, std::set<std::uint32_t>& path) {
    if (!path.insert(i).second) return;
    for (const std::uint32_t to : readers_[i]) {
      if (kind(to) == ElementKind::kTransition) {
        if (transition_of_[to] != kNone) out.push_back(transition_of_[to]);
      } else if (kind(to) == ElementKind::kSelectionDivergence || kind(to) == ElementKind::kSelectionConvergence ||
                 kind(to) == ElementKind::kSimultaneousConvergence) {
        leads_of(to, out, path);
      }
    }
  }

  void order_choices() {
    for (std::uint32_t i = 0; i < body_.elements.size(); ++i) {
      if (kind(i) != ElementKind::kStep || step_of_[i] == kNone) continue;
      std::set<std::uint32_t> path;
      leads_of(i, chart_.steps[step_of_[i]].leads, path);
    }
  }

  // ---- jumps without a transition ----

  /// Steps from which one comes to element `i` without passing a transition.
  void steps_into(std::uint32_t i, StepSet& out, std::set<std::uint32_t>& path) {
    if (!path.insert(i).second) return;
    for (const std::uint32_t from : sources_[i]) {
      if (kind(from) == ElementKind::kStep) {
        if (step_of_[from] != kNone) out.push_back(step_of_[from]);
      } else if (kind(from) == ElementKind::kSelectionConvergence || kind(from) == ElementKind::kSelectionDivergence) {
        steps_into(from, out, path);
      }
    }
  }

  void read_free_jumps() {
    for (std::uint32_t i = 0; i < body_.elements.size(); ++i) {
      if (kind(i) != ElementKind::kJumpStep && kind(i) != ElementKind::kStep) continue;
      StepSet from;
      std::set<std::uint32_t> path;
      steps_into(i, from, path);
      if (from.empty()) continue;
      const std::string& name = chart_.steps[from.front()].name;
      if (kind(i) == ElementKind::kStep) {
        report(Code::P3103, element(i).at, named(i) + " comes after step \"" + name + "\" without a transition between",
               "draw a transition; with the condition TRUE it goes on at once");
        continue;
      }
      const auto target = by_name_.find(core::folded(element(i).text));
      if (target == by_name_.end()) {
        std::set<std::uint32_t> again;
        StepSet none;
        after(i, none, again);
        continue;
      }
      report(Code::P3108, element(i).at,
             named(i) + " comes after step \"" + name + "\" without a transition: read as one that is always TRUE",
             "draw a transition with the condition that is meant");
      Transition always;
      for (const std::uint32_t step : from) {
        always.sources.push_back({step});
        chart_.steps[step].leads.push_back(static_cast<std::uint32_t>(chart_.transitions.size()));
      }
      always.targets = {target->second};
      always.condition = {Condition::Kind::kText, "TRUE", element(i).at};
      always.at = element(i).at;
      chart_.transitions.push_back(std::move(always));
    }
  }

  // ---- what is drawn in LD and FBD ----

  void keep_drawing() {
    chart_.drawing.language = plcopen::Language::kFbd;
    chart_.drawing.at = body_.at;
    chart_.drawing.closed_branches = body_.closed_branches;
    bool drawn = false;
    for (std::uint32_t i = 0; i < body_.elements.size(); ++i) {
      if (kind(i) == ElementKind::kTransition && transition_of_[i] != kNone) {
        const Transition& transition = chart_.transitions[transition_of_[i]];
        if (transition.condition.kind != Condition::Kind::kWire) continue;
        Element& e = chart_.drawing.elements.emplace_back(element(i));
        e.inputs = {e.chart->condition};
        e.text = std::to_string(transition_of_[i]);
        drawn = true;
      } else if (!is_chart_element(kind(i)) && !texts_.contains(i)) {
        chart_.drawing.elements.push_back(element(i));
        drawn = drawn || kind(i) != ElementKind::kNone;
      }
    }
    if (!drawn) chart_.drawing.elements.clear();
  }

  const plcopen::Body& body_;
  const std::string& pou_;
  core::Diagnostics& diagnostics_;
  Chart chart_;
  std::unordered_map<std::int64_t, std::uint32_t> by_id_;
  std::map<std::string, std::uint32_t> by_name_;        ///< steps, letter case aside
  std::vector<std::vector<std::uint32_t>> sources_;     ///< by element: what is wired to it
  std::vector<std::vector<std::uint32_t>> readers_;     ///< by element: what it is wired to, left to right
  std::vector<std::uint32_t> step_of_, transition_of_;  ///< by element
  std::set<std::uint32_t> texts_;                       ///< variables that are only the text of a condition
};

}  // namespace

Chart read_drawing(const plcopen::Body& body, const std::string& name, core::Diagnostics& diagnostics) {
  if (!has_macro_steps(body)) return DrawingReader(body, name, diagnostics).read();
  const std::size_t errors = diagnostics.error_count();
  const plcopen::Body whole = expand_macro_steps(body, name, diagnostics);
  // Without what is in a macro step, wires lead nowhere.
  return diagnostics.error_count() == errors ? DrawingReader(whole, name, diagnostics).read() : Chart{};
}

}  // namespace plc::sfc
