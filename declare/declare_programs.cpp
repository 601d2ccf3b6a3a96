// Programs by name: which programs texts and drawings name, and where their one instance lies.
//
// A program that is named is a global: all code reaches it, and other tasks see it as they see any global. Those that
// are never named stay in the memory of their task, as they always were.
#include <algorithm>
#include <utility>
#include <vector>

#include "core/text.h"
#include "declare/declarer.h"
#include "frontend-st/lexer.h"

namespace plc::st {

using core::Code;

namespace {

std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

/// Collects the programs that bodies name. It may find one too many, which costs a copy, and never one too few.
class Mentions {
 public:
  explicit Mentions(const ir::Module& module) : module_(module) {
    for (std::uint32_t i = 0; i < module.pous.size(); ++i) {
      const ir::Pou& pou = module.pous[i];
      if (pou.kind == ir::PouKind::kProgram && pou.owner == ir::Pou::kDeclared) programs_.emplace(pou.name, i);
    }
  }

  std::vector<std::uint32_t> found;  ///< programs, in the order in which they are named first

  void look_at(const plcopen::Pou& bodies, std::uint32_t pou) {
    pou_ = pou;
    if (module_.pous[pou].test) return;  // it works on copies of programs
    // A program's own name means the instance that runs.
    if (programs_.size() < 2 && module_.pous[pou].kind == ir::PouKind::kProgram) return;
    for (const plcopen::Body& body : bodies.bodies) look_at(body);
    for (const plcopen::Pou& action : bodies.actions) look_at(action, pou);
    for (const plcopen::Pou& transition : bodies.transitions) look_at(transition, pou);
  }

 private:
  /// Texts in ST and IL, charts as text, drawings.
  void look_at(const plcopen::Body& body) {
    body.language == plcopen::Language::kSfc ? look_at_chart(body.text) : look_at(body.text);
    for (const plcopen::Element& e : body.elements) {
      look_at(e);
      if (e.chart) look_at(*e.chart);
    }
  }

  /// Steps, with their X and T, hide programs of their names.
  void look_at_chart(std::string_view text) {
    if (!may_name(text)) return;
    std::vector<Token> tokens;
    Lexer lexer(text);
    for (Token token = lexer.next(); token.kind != TokenKind::kEnd && token.kind != TokenKind::kUnterminatedComment;
         token = lexer.next()) {
      tokens.push_back(token);
    }
    const auto word = [&](std::size_t i) {
      const bool is_word = i < tokens.size() && tokens[i].kind == TokenKind::kIdentifier;
      return is_word ? text.substr(tokens[i].begin, tokens[i].end - tokens[i].begin) : std::string_view();
    };
    ir::NameSet steps;
    for (std::size_t i = 0; i < tokens.size(); ++i) {
      if (core::iequals(word(i), "STEP") || core::iequals(word(i), "INITIAL_STEP")) steps.emplace(word(i + 1));
    }
    for (std::size_t i = 0; i < tokens.size(); ++i) {
      if (word(i).empty() || (i != 0 && tokens[i - 1].kind == TokenKind::kDot)) continue;
      const bool dotted = i + 1 < tokens.size() && tokens[i + 1].kind == TokenKind::kDot;
      const bool of_step = !dotted || core::iequals(word(i + 2), "X") || core::iequals(word(i + 2), "T");
      if (!of_step || !steps.contains(word(i))) add(word(i));
    }
  }

  void look_at(const plcopen::ChartPart& part) {
    for (const auto* text : {&part.main, &part.entry, &part.exit, &part.min_time, &part.max_time, &part.reference,
                             &part.text, &part.condition.expression}) {
      look_at(*text);
    }
    if (part.macro) look_at(*part.macro);
  }

  void look_at(const plcopen::Element& e) {
    look_at(e.text);
    look_at(e.instance_name);
    look_at(e.code);
    for (const auto* pins : {&e.inputs, &e.in_outs, &e.outputs}) {
      for (const plcopen::Pin& pin : *pins) look_at(pin.expression);
    }
    for (const plcopen::ActionLink& action : e.actions) {
      look_at(action.name);
      look_at(action.text);
      look_at(action.duration);
    }
  }

  void look_at(std::string_view text) {
    if (!may_name(text)) return;
    Lexer lexer(text);
    TokenKind before = TokenKind::kEnd;
    for (Token token = lexer.next(); token.kind != TokenKind::kEnd; token = lexer.next()) {
      if (token.kind == TokenKind::kIdentifier && before != TokenKind::kDot) {
        add(text.substr(token.begin, token.end - token.begin));
      }
      if (token.kind == TokenKind::kUnterminatedComment) return;
      before = token.kind;
    }
  }

  /// Whether a word of the text, comments included, is the name of a program: most texts need no lexer.
  [[nodiscard]] bool may_name(std::string_view text) const {
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (!is_identifier_start(text[i])) continue;
      const std::size_t begin = i;
      while (i < text.size() && is_identifier_char(text[i])) ++i;
      if (programs_.find(text.substr(begin, i - begin)) != programs_.end()) return true;
    }
    return false;
  }

  void add(std::string_view name) {
    const auto program = programs_.find(name);
    if (program == programs_.end() || program->second == pou_) return;
    if (module_.pous[pou_].find(name) != nullptr || module_.global_by_name.find(name) != module_.global_by_name.end())
      return;
    if (std::find(found.begin(), found.end(), program->second) == found.end()) found.push_back(program->second);
  }

  const ir::Module& module_;
  NameMap<std::uint32_t> programs_;
  std::uint32_t pou_ = 0;
};

}  // namespace

void Declarer::place_programs() {
  Mentions mentions(module_);
  for (std::uint32_t i = 0; i < project_.pous.size(); ++i) mentions.look_at(project_.pous[i], i);
  for (const std::uint32_t program : mentions.found) {
    std::vector<InstanceRoot> roots;
    for (std::uint32_t t = 0; t < module_.tasks.size(); ++t) {
      for (std::uint32_t p = 0; p < module_.tasks[t].programs.size(); ++p) {
        if (module_.tasks[t].programs[p].pou == program) roots.push_back({t, p});
      }
    }
    if (roots.size() > 1) continue;  // reported where it is named
    ir::ProgramInstance* const run = roots.empty() ? nullptr : &module_.tasks[roots[0].task].programs[roots[0].index];
    ir::Pou& pou = module_.pous[program];
    const auto index = static_cast<std::uint32_t>(module_.globals.size());
    ir::Global global;
    global.program = true;
    global.from_library = pou.from_library;
    global.variable.name = run != nullptr ? run->name : pou.name;
    global.variable.type = pou.instance_type;
    global.variable.at = run != nullptr ? run->at : pou.at;
    const auto same = module_.global_by_name.find(global.variable.name);
    if (same != module_.global_by_name.end()) {
      report(Code::P4018, global.variable.at, {},
             "program instance " + quoted(global.variable.name) + " has the name of a global variable",
             "rename one of them: both are seen from outside by this name");
    }
    if (run != nullptr) {
      global.variable.retain = run->retain;
      global.variable.initial = std::move(run->initial);
      run->initial.clear();
      run->global = index;
      // Addresses that VAR_CONFIG gives go with the instance.
      std::vector<std::pair<std::vector<std::uint32_t>, std::string>> given;
      for (const auto& [part, address] : given_addresses_) {
        if (part.first == roots[0]) given.emplace_back(part.second, address);
      }
      for (auto& [path, address] : given) {
        given_addresses_.emplace(std::pair{InstanceRoot{InstanceRoot::kGlobal, index}, path}, address);
      }
    }
    pou.instance = index;
    module_.globals.push_back(std::move(global));
  }
}

}  // namespace plc::st
