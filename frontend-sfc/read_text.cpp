// Charts as text (IEC 61131-3:2013, annex A, sequential_function_chart):
//
//   network    := INITIAL_STEP name [times] ':' {association ';'} END_STEP { STEP .. | transition }
//   association := name '(' [qualifier [',' time] {',' indicator}] ')'
//   transition := TRANSITION [name] ['(' PRIORITY ':=' n ')'] FROM steps TO steps ':=' expression ';' END_TRANSITION
//
// PICARD's own, for what CODESYS and TwinCAT keep beside: the qualifiers ENTRY, MAIN and EXIT, and
//
//   times      := '(' {MIN ':=' time | MAX ':=' time, with ',' between} ')'
//
// Several networks may follow each other, steps come in any order, and ':' after a name may be left out. ACTIONs are
// actions of the POU: read_actions.cpp of frontend-st has read them.
#include <algorithm>
#include <map>
#include <unordered_set>
#include <utility>

#include "core/text.h"
#include "frontend-sfc/chart.h"
#include "frontend-st/conditions.h"
#include "frontend-st/lexer.h"
#include "frontend-st/source_text.h"

namespace plc::sfc {

using core::Code;
using core::ElementKind;
using st::Token;
using st::TokenKind;

namespace {

class TextReader {
 public:
  TextReader(const st::SourceText& source, const std::string& pou, core::Diagnostics& diagnostics)
      : source_(source), pou_(pou), diagnostics_(diagnostics), lexer_(source.text(), &pragmas_) {
    advance();
  }

  Chart read() {
    while (token_.kind != TokenKind::kEnd) {
      if (at("INITIAL_STEP") || at("STEP")) {
        step();
      } else if (at("TRANSITION")) {
        transition();
      } else if (token_.kind == TokenKind::kSemicolon) {
        advance();
      } else {
        fail("STEP, INITIAL_STEP, TRANSITION or ACTION");
        skip();
      }
    }
    resolve();
    refuse_choices();
    return std::move(chart_);
  }

 private:
  /// A transition whose steps are still names.
  struct Names {
    std::vector<std::pair<std::string, core::SourceRef>> from, to;
  };

  void advance() {
    last_end_ = token_.end;
    token_ = lexer_.next();
  }
  [[nodiscard]] std::string_view text() const { return source_.slice(token_.begin, token_.end); }
  [[nodiscard]] bool at(std::string_view word) const {
    return token_.kind == TokenKind::kIdentifier && core::iequals(text(), word);
  }
  bool accept(TokenKind kind) {
    if (token_.kind != kind) return false;
    advance();
    return true;
  }
  bool accept(std::string_view word) {
    if (!at(word)) return false;
    advance();
    return true;
  }
  [[nodiscard]] core::SourceRef place(std::uint32_t offset, ElementKind kind) const {
    core::SourceRef out = source_.locate(offset);
    out.kind = kind;
    return out;
  }
  void report(Code code, const core::SourceRef& at, std::string message, std::string help) {
    diagnostics_.report(code, at, pou_, std::move(message), std::move(help));
  }
  bool fail(std::string_view wanted) {
    const std::string found =
        token_.kind == TokenKind::kEnd ? "the end of the chart" : st::shown_token(std::string(text()));
    report(Code::P3110, place(token_.begin, ElementKind::kText),
           found + " where " + std::string(wanted) + " is expected",
           "docs/guides/charts.md has the grammar of charts as text");
    return false;
  }
  bool require(TokenKind kind, std::string_view wanted) { return accept(kind) || fail(wanted); }
  /// True where a step or transition begins: the word may be the name of a variable, too, but no name follows that.
  [[nodiscard]] bool begins_another() const {
    if (!at("STEP") && !at("INITIAL_STEP") && !at("TRANSITION")) return false;
    return st::Lexer(source_.text().substr(token_.end)).next().kind == TokenKind::kIdentifier;
  }

  /// After an error: to the end of the step or transition, or to where another begins.
  void skip() {
    advance();
    while (token_.kind != TokenKind::kEnd && !at("STEP") && !at("INITIAL_STEP") && !at("TRANSITION")) {
      const bool ends = at("END_STEP") || at("END_TRANSITION");
      advance();
      if (ends) return;
    }
  }

  bool name(std::string& out, std::string_view what) {
    if (token_.kind != TokenKind::kIdentifier) return fail(what);
    out = std::string(text());
    advance();
    return true;
  }

  // ---- steps ----

  void step() {
    Step step;
    step.initial = at("INITIAL_STEP");
    advance();
    step.at = place(token_.begin, ElementKind::kStep);
    if (!name(step.name, "the name of a step")) return skip();
    bool fine = token_.kind != TokenKind::kLeftParen || times(step);
    if (fine) accept(TokenKind::kColon);
    while (fine && !at("END_STEP")) {
      if (accept(TokenKind::kSemicolon)) continue;
      if (begins_another()) {
        fail("END_STEP of step \"" + step.name + "\"");
        break;
      }
      if (token_.kind != TokenKind::kIdentifier) {
        fine = fail("an action of the step or END_STEP");
        break;
      }
      fine = association(step);
    }
    const auto [known, fresh] = by_name_.emplace(core::folded(step.name), chart_.steps.size());
    if (!fresh) {
      report(Code::P3102, step.at,
             "step \"" + step.name + "\" is written twice, first at line " +
                 std::to_string(chart_.steps[known->second].at.line),
             "rename one of them");
    }
    chart_.steps.push_back(std::move(step));
    if (!fine) return skip();
    accept("END_STEP");
    accept(TokenKind::kSemicolon);
  }

  /// (MIN := T#1s, MAX := T#2s)
  bool times(Step& step) {
    do {
      advance();
      std::string* const time = at("MIN") ? &step.min_time : at("MAX") ? &step.max_time : nullptr;
      if (time == nullptr) return fail("MIN or MAX");
      advance();
      if (!require(TokenKind::kAssign, "\":=\" and a time")) return false;
      *time = argument();
      if (time->empty()) return fail("a time");
    } while (token_.kind == TokenKind::kComma);
    return require(TokenKind::kRightParen, "\")\" after the times of a step");
  }

  /// Where the action of a step is kept that `word` means; null for a qualifier.
  std::string* step_action(Step& step) {
    return at("ENTRY") ? &step.entry : at("MAIN") ? &step.main : at("EXIT") ? &step.exit : nullptr;
  }

  /// A name with its members, as written: "Motor.Start", "a[3]".
  std::string path() {
    const std::uint32_t begin = token_.begin;
    advance();
    std::uint32_t depth = 0;
    while (token_.kind == TokenKind::kDot || token_.kind == TokenKind::kLeftBracket || depth != 0) {
      if (token_.kind == TokenKind::kEnd) break;
      if (token_.kind == TokenKind::kLeftBracket) ++depth;
      if (token_.kind == TokenKind::kRightBracket) --depth;
      const bool dot = token_.kind == TokenKind::kDot;
      advance();
      if (dot && token_.kind == TokenKind::kIdentifier) advance();
    }
    return std::string(core::trimmed(source_.slice(begin, last_end_)));
  }

  bool association(Step& step) {
    Association action;
    action.at = place(token_.begin, ElementKind::kStep);
    action.name = path();
    if (!require(TokenKind::kLeftParen, "\"(\" after the name of an action")) return false;
    bool known = true;
    if (std::string* const own = step_action(step)) {
      if (!own->empty()) {
        report(Code::P3107, place(token_.begin, ElementKind::kStep),
               "step \"" + step.name + "\" has a second action with the qualifier " + std::string(text()),
               "call both in one action");
      }
      *own = action.name;
      known = false;
      advance();
    } else if (token_.kind == TokenKind::kIdentifier) {
      const auto qualifier = qualifier_of(text());
      known = qualifier.has_value();
      if (!known) {
        report(Code::P3107, place(token_.begin, ElementKind::kStep),
               "qualifier \"" + std::string(text()) + "\" at step \"" + step.name + "\" is not known",
               "qualifiers are N, R, S, L, D, P, P0, P1, SD, DS and SL");
      } else {
        action.qualifier = *qualifier;
      }
      advance();
      if (accept(TokenKind::kComma)) {
        // The first is the time where the qualifier needs one; what follows are indicators, which do nothing.
        const bool timed = known && needs_time(*qualifier);
        if (known && !timed && token_.kind != TokenKind::kIdentifier) {
          report(Code::P3107, place(token_.begin, ElementKind::kStep),
                 "action \"" + action.name + "\" of step \"" + step.name + "\" has the qualifier " +
                     std::string(qualifier_word(*qualifier)) + ", which takes no time",
                 "delete the time, or write the qualifier that is meant: L, D, SD, DS or SL");
        }
        std::string first = argument();
        if (timed) action.duration = std::move(first);
        while (accept(TokenKind::kComma)) argument();
      }
    }
    if (!require(TokenKind::kRightParen, "\")\" after the qualifier")) return false;
    if (token_.kind != TokenKind::kSemicolon && !at("END_STEP")) return fail("\";\" after an action of the step");
    if (known) step.actions.push_back(std::move(action));
    return true;
  }

  /// Up to the comma or bracket that ends an argument.
  std::string argument() {
    const std::uint32_t begin = token_.begin;
    std::uint32_t depth = 0;
    while (token_.kind != TokenKind::kEnd && token_.kind != TokenKind::kSemicolon) {
      if (depth == 0 && (token_.kind == TokenKind::kComma || token_.kind == TokenKind::kRightParen)) break;
      if (token_.kind == TokenKind::kLeftParen || token_.kind == TokenKind::kLeftBracket) ++depth;
      if (token_.kind == TokenKind::kRightParen || token_.kind == TokenKind::kRightBracket) --depth;
      advance();
    }
    return std::string(core::trimmed(source_.slice(begin, std::max(begin, last_end_))));
  }

  // ---- transitions ----

  bool steps(std::vector<std::pair<std::string, core::SourceRef>>& out) {
    const auto one = [&] {
      const core::SourceRef where = place(token_.begin, ElementKind::kTransition);
      std::string step;
      if (!name(step, "the name of a step")) return false;
      out.emplace_back(std::move(step), where);
      return true;
    };
    if (!accept(TokenKind::kLeftParen)) return one();
    if (!one()) return false;
    while (accept(TokenKind::kComma)) {
      if (!one()) return false;
    }
    return require(TokenKind::kRightParen, "\")\" after the names of steps");
  }

  bool head(Transition& out, Names& names) {
    if (token_.kind == TokenKind::kIdentifier && !at("FROM")) name(out.name, "the name of a transition");
    if (accept(TokenKind::kLeftParen)) {
      if (!accept("PRIORITY")) return fail("PRIORITY");
      if (!require(TokenKind::kAssign, "\":=\" after PRIORITY")) return false;
      if (token_.kind != TokenKind::kInteger) return fail("a number");
      const std::string digits(text());
      out.priority = digits.size() < 10 ? std::stoll(digits) : 999'999'999;
      advance();
      if (!require(TokenKind::kRightParen, "\")\" after the priority")) return false;
    }
    if (!accept("FROM")) return fail("FROM");
    if (!steps(names.from)) return false;
    if (!accept("TO")) return fail("TO");
    return steps(names.to);
  }

  void transition() {
    const std::uint32_t begin = token_.begin;
    advance();
    Transition out;
    Names names;
    out.at = place(begin, ElementKind::kTransition);
    if (!head(out, names)) return skip();
    const bool instructions = accept(TokenKind::kColon);
    if (!instructions && !require(TokenKind::kAssign, "\":=\" and the condition")) return skip();
    const std::uint32_t first = token_.begin;
    const auto is_over = [&] {  // another one after a complete condition, END_TRANSITION is missing
      return at("END_TRANSITION") ||
             (!instructions && source_.slice(first, std::max(first, last_end_)).ends_with(';') && begins_another());
    };
    while (token_.kind != TokenKind::kEnd && !is_over()) advance();
    out.condition = {instructions ? Condition::Kind::kInstructions : Condition::Kind::kText,
                     std::string(source_.slice(first, std::max(first, last_end_))),
                     place(first, ElementKind::kTransition)};
    if (!instructions) trim_condition(out.condition, {});
    if (instructions) forget_pragmas(first, last_end_);
    if (out.condition.text.empty()) {
      report(Code::P3105, out.at, "transition has no condition", "write one after \":=\"; TRUE goes on at once");
    }
    if (!accept("END_TRANSITION")) {
      fail("END_TRANSITION");
      return;
    }
    accept(TokenKind::kSemicolon);
    chart_.transitions.push_back(std::move(out));
    names_.push_back(std::move(names));
  }

  std::optional<std::vector<std::uint32_t>> numbers(const std::vector<std::pair<std::string, core::SourceRef>>& names) {
    std::vector<std::uint32_t> out;
    std::unordered_set<std::uint32_t> seen;
    bool fine = true;
    for (const auto& [step, where] : names) {
      const auto found = by_name_.find(core::folded(step));
      if (found == by_name_.end()) {
        report(Code::P3104, where, "transition names step \"" + step + "\", which is not in this chart",
               "correct the name, or write the step");
        fine = false;
        continue;
      }
      const auto number = static_cast<std::uint32_t>(found->second);
      if (!seen.insert(number).second) {
        report(Code::P3104, where, "transition names step \"" + step + "\" twice", "name the step that is meant");
        fine = false;
      }
      out.push_back(number);
    }
    std::sort(out.begin(), out.end());
    return fine ? std::optional(std::move(out)) : std::nullopt;
  }

  void resolve() {
    std::vector<Transition> kept;
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const auto from = numbers(names_[i].from);
      const auto to = numbers(names_[i].to);
      if (!from || !to) continue;
      Transition& transition = chart_.transitions[i];
      transition.sources = {*from};
      transition.targets = *to;
      for (const std::uint32_t step : *from) {
        chart_.steps[step].leads.push_back(static_cast<std::uint32_t>(kept.size()));
      }
      kept.push_back(std::move(transition));
    }
    chart_.transitions = std::move(kept);
  }

  /// Lists choose for themselves.
  void forget_pragmas(std::uint32_t begin, std::uint32_t end) {
    const auto before = [](const Token& pragma, std::uint32_t offset) { return pragma.begin < offset; };
    const auto first = std::lower_bound(pragmas_.begin(), pragmas_.end(), begin, before);
    pragmas_.erase(first, std::lower_bound(first, pragmas_.end(), std::max(begin, end), before));
  }

  /// A chart that is chosen by pragmas would be both of the charts that they choose from.
  void refuse_choices() {
    for (const Token& pragma : pragmas_) {
      if (!st::is_choosing_pragma(source_.slice(pragma.begin, pragma.end))) continue;
      report(Code::P3110, place(pragma.begin, ElementKind::kText),
             "{IF}, {define} and their like do nothing between the steps of a chart",
             "choose inside of actions, or among whole POUs");
      return;
    }
  }

  const st::SourceText& source_;
  const std::string& pou_;
  core::Diagnostics& diagnostics_;
  std::vector<Token> pragmas_;
  st::Lexer lexer_;
  Token token_;
  std::uint32_t last_end_ = 0;
  Chart chart_;
  std::vector<Names> names_;                    ///< by transition
  std::map<std::string, std::size_t> by_name_;  ///< steps, letter case aside
};

}  // namespace

Chart read_text(const plcopen::Body& body, const std::string& name, core::Diagnostics& diagnostics) {
  const st::SourceText source(body.text, body.text_at.line != 0 ? body.text_at : body.at, diagnostics);
  return TextReader(source, name, diagnostics).read();
}

}  // namespace plc::sfc
