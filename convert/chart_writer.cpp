#include "convert/chart_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "core/diagnostics.h"
#include "core/text.h"
#include "core/types.h"
#include "frontend-sfc/chart.h"
#include "frontend-st/keywords.h"
#include "frontend-st/lexer.h"

namespace plc::convert {
namespace {

using sfc::Chart;
using sfc::Condition;
using sfc::Step;
using sfc::Transition;

struct FlagRow {
  std::string_view name;
  core::TypeId type;
};
constexpr FlagRow kFlags[] = {
#define PLC_SFC_FLAG(Name, name, Type) {name, core::TypeId::k##Type},
#include "frontend-sfc/flags.def"
};

/// An instruction list without its last instruction where that stores `result`, which is what remains in the
/// accumulator. Nothing where the list names the result elsewhere, too.
std::optional<std::string> without_result(const std::string& text, std::string_view result) {
  st::Lexer lexer(text);
  st::Token before;
  std::optional<std::uint32_t> store;  // where it begins
  for (st::Token token = lexer.next(); token.kind != st::TokenKind::kEnd; before = token, token = lexer.next()) {
    const auto is = [&](const st::Token& one, std::string_view word) {
      return core::iequals(std::string_view(text).substr(one.begin, one.end - one.begin), word);
    };
    if (token.kind == st::TokenKind::kSemicolon) continue;
    if (store) return std::nullopt;
    if (!is(token, result)) continue;
    if (!is(before, "ST")) return std::nullopt;
    store = before.begin;
  }
  return text.substr(0, store.value_or(static_cast<std::uint32_t>(text.size())));
}

/// A transition with one set of steps that it leaves, which is what a text has.
struct Edge {
  std::uint32_t transition = 0;
  std::vector<std::uint32_t> from;
};

class ChartWriter {
 public:
  ChartWriter(const plcopen::Pou& owner, const ir::Module& module, const ir::Pou& made, AddedVariables& added)
      : owner_(owner), module_(module), made_(made), added_(added) {}

  WrittenChart run(const Chart& chart) {
    chart_ = &chart;
    for (const Step& step : chart.steps) taken_.insert(core::folded(step.name));
    for (const plcopen::Pou& action : owner_.actions) taken_.insert(core::folded(action.name));
    for (const plcopen::Variable& variable : owner_.variables) taken_.insert(core::folded(variable.name));
    for (const std::string& flag : chart.flags) declare(flag);
    for (const Step& step : chart.steps) write(step);
    for (const Edge& edge : edges()) write(edge);
    return std::move(out_);
  }

 private:
  void fail(const core::SourceRef& at, std::string problem) {
    if (!out_.problem.empty()) return;
    out_.problem = std::move(problem);
    out_.at = at;
  }

  /// A flag that the settings of the chart declare is a variable of the POU.
  void declare(const std::string& flag) {
    const auto* const row = std::find_if(std::begin(kFlags), std::end(kFlags),
                                         [&](const FlagRow& f) { return core::iequals(f.name, flag); });
    const auto& added = added_.all();  // another chart of the POU may have the flag, too
    const bool known = taken_.contains(core::folded(flag)) ||
                       std::any_of(added.begin(), added.end(),
                                   [&](const AddedVariable& one) { return core::iequals(one.name, flag); });
    if (row == std::end(kFlags) || known) return;
    added_.declare(std::string(row->name), std::string(core::name_of(row->type)));
  }

  // ---- steps ----

  void write(const Step& step) {
    if (!st::is_identifier(step.name) || st::keyword_of(step.name) != st::Keyword::kNone) {
      fail(step.at, "has a step \"" + step.name + "\", which is no name in a text");
    }
    out_.text += fmt::format("  {} {}", step.initial ? "INITIAL_STEP" : "STEP", step.name);
    std::string times;
    for (const auto& [word, time] : {std::pair("MIN", &step.min_time), std::pair("MAX", &step.max_time)}) {
      if (!time->empty()) times += fmt::format("{}{} := {}", times.empty() ? " (" : ", ", word, *time);
    }
    out_.text += times + (times.empty() ? ":\n" : "):\n");
    for (const auto& [word, action] :
         {std::pair("ENTRY", &step.entry), std::pair("MAIN", &step.main), std::pair("EXIT", &step.exit)}) {
      if (!action->empty()) out_.text += fmt::format("    {}({});\n", *action, word);
    }
    for (const sfc::Association& action : step.actions) {
      const std::string name = action.has_text ? written(action, step) : action.name;
      out_.text += fmt::format("    {}({}{}{});\n", name, sfc::qualifier_word(action.qualifier),
                               action.duration.empty() ? "" : ", ", action.duration);
    }
    out_.text += "  END_STEP\n";
  }

  /// An action that is written at its step gets a name.
  std::string written(const sfc::Association& action, const Step& step) {
    // Charts of one POU may have steps of the same names.
    std::string name;
    do name = added_.unused(step.name + "_action");
    while (taken_.contains(core::folded(name)));
    out_.actions += "ACTION " + name + ":\n" + action.text;
    if (!out_.actions.ends_with('\n')) out_.actions += '\n';
    out_.actions += "END_ACTION\n\n";
    out_.remarks.push_back(fmt::format("calls the ST at step {} {}", step.name, name));
    return name;
  }

  // ---- transitions ----

  /// In an order in which each step has its transitions as the drawing chooses among them, and else as drawn.
  std::vector<Edge> edges() {
    const std::vector<Transition>& all = chart_->transitions;
    std::vector<std::uint32_t> left(all.size());
    for (std::uint32_t t = 0; t < all.size(); ++t) left[t] = t;
    const auto goes_first = [&](std::uint32_t t) {
      return std::none_of(chart_->steps.begin(), chart_->steps.end(), [&](const Step& step) {
        const auto own = std::find(step.leads.begin(), step.leads.end(), t);
        if (own == step.leads.end()) return false;
        return std::any_of(step.leads.begin(), own, [&](std::uint32_t before) {
          return before != t && std::find(left.begin(), left.end(), before) != left.end();
        });
      });
    };
    std::vector<Edge> out;
    while (!left.empty()) {
      auto next = std::find_if(left.begin(), left.end(), goes_first);
      if (next == left.end()) {
        next = left.begin();
        out_.remarks.emplace_back("has steps whose choices are drawn in contrary orders");
      }
      const Transition& transition = all[*next];
      for (const auto& from : transition.sources) out.push_back({*next, from});
      if (transition.sources.size() > 1) {
        out_.remarks.push_back(fmt::format("has {} transitions for one that {} steps share", transition.sources.size(),
                                           transition.sources.size()));
      }
      left.erase(next);
    }
    return out;
  }

  [[nodiscard]] std::string names(const std::vector<std::uint32_t>& steps) const {
    std::vector<std::string> list;
    for (const std::uint32_t step : steps) list.push_back(chart_->steps[step].name);
    return list.size() == 1 ? list.front() : fmt::format("({})", fmt::join(list, ", "));
  }

  void write(const Edge& edge) {
    const Transition& transition = chart_->transitions[edge.transition];
    out_.text += "  TRANSITION ";
    if (!transition.name.empty()) out_.text += transition.name + " ";
    if (transition.priority >= 0) out_.text += fmt::format("(PRIORITY := {}) ", transition.priority);
    out_.text += "FROM " + names(edge.from) + " TO " + names(transition.targets) + "\n";
    out_.text += condition(transition.condition) + "  END_TRANSITION\n";
  }

  static std::string expression(std::string_view text) {
    // What follows a comment up to the end of its line would be part of it.
    return "    := " + std::string(text) + (text.find("//") != std::string_view::npos ? "\n    ;\n" : ";\n");
  }

  static std::string negation(const std::string& text) {
    return expression("NOT (" + text + (text.find("//") != std::string::npos ? "\n    )" : ")"));
  }

  static std::string instructions(std::string_view text) { return "    :\n" + std::string(text) + "\n"; }

  std::string condition(const Condition& condition) {
    switch (condition.kind) {
      case Condition::Kind::kMissing:
        fail(condition.at, "has a transition without a condition");
        return {};
      case Condition::Kind::kText:
        return condition.negated ? negation(condition.text) : expression(condition.text);
      case Condition::Kind::kInstructions:
        return instructions(condition.text);
      case Condition::Kind::kWire:
        fail(condition.at, "has a transition whose condition is wired to what is drawn between its steps");
        return {};
      case Condition::Kind::kReference:
        break;
    }
    const auto named = std::find_if(owner_.transitions.begin(), owner_.transitions.end(),
                                    [&](const plcopen::Pou& one) { return core::iequals(one.name, condition.text); });
    if (named == owner_.transitions.end()) {
      return condition.negated ? negation(condition.text) : expression(condition.text);
    }
    if (!condition.negated) return body_of(*named, condition.at);
    fail(condition.at, "has a transition whose condition is another one, negated");
    return {};
  }

  /// The condition that is a transition of the POU.
  std::string body_of(const plcopen::Pou& transition, const core::SourceRef& at) {
    const std::string shown = transition.name.starts_with('#') ? "a condition" : "transition " + transition.name;
    if (!transition.bodies.empty()) {
      const plcopen::Body& body = transition.bodies.front();
      if (body.language == plcopen::Language::kSt) {
        Condition text{Condition::Kind::kText, body.text, body.at};
        sfc::trim_condition(text, transition.result.empty() ? transition.name : transition.result);
        note(shown);
        return expression(text.text);
      }
      if (body.language == plcopen::Language::kIl) {
        const auto text = without_result(body.text, transition.result.empty() ? transition.name : transition.result);
        if (!text) {
          fail(at, "has " + shown + ", which uses its result before its end");
          return {};
        }
        note(shown);
        return instructions(*text);
      }
      if (const auto text = drawn(transition)) {
        note(shown);
        return expression(*text);
      }
    }
    fail(at, "has " + shown + ", whose drawing is no single expression");
    return {};
  }

  void note(const std::string& transition) {
    const std::string remark = "has " + transition + " where it is tested, and not as a body of its own";
    if (std::find(out_.remarks.begin(), out_.remarks.end(), remark) == out_.remarks.end())
      out_.remarks.push_back(remark);
  }

  /// A drawing whose statements are one assignment to the result.
  std::optional<std::string> drawn(const plcopen::Pou& transition) {
    const auto owner = module_.pou_by_name.find(owner_.name);
    if (owner == module_.pou_by_name.end()) return std::nullopt;
    const auto index = module_.find_transition(owner->second, transition.name);
    if (!index) return std::nullopt;
    AddedVariables::State before = added_.save();
    const WrittenBody body = write_body(module_, module_.pous[*index], made_, added_);
    const bool plain = added_.all().size() == before.all.size() + 1;  // the result
    added_.restore(std::move(before));
    const std::string_view text = core::trimmed(body.text);
    const std::size_t assign = text.find(" := ");
    if (!body.problem.empty() || body.loop || !plain || assign == std::string_view::npos) return std::nullopt;
    if (!st::is_identifier(text.substr(0, assign)) || text.find(';') != text.size() - 1) return std::nullopt;
    return std::string(text.substr(assign + 4, text.size() - assign - 5));
  }

  const plcopen::Pou& owner_;
  const ir::Module& module_;
  const ir::Pou& made_;
  AddedVariables& added_;
  const Chart* chart_ = nullptr;
  std::set<std::string> taken_;  ///< names of the POU, letter case aside
  WrittenChart out_;
};

}  // namespace

WrittenChart write_chart(const plcopen::Body& body, const plcopen::Pou& owner, const std::string& name,
                         const ir::Module& module, const ir::Pou& made, AddedVariables& added) {
  // What is wrong with the chart, and what was warned of, was reported when it was compiled.
  core::Diagnostics said;
  const Chart chart = sfc::read_chart(body, name, said);
  WrittenChart out = ChartWriter(owner, module, made, added).run(chart);
  if (said.has_errors() && out.problem.empty()) {
    out.problem = "is a chart that is not compiled";
    out.at = body.at;
  }
  return out;
}

}  // namespace plc::convert
