// Configurations: resources, tasks, program instances.
#include <utility>

#include "core/text.h"
#include "frontend-st/declaration_reader.h"

namespace plc::st {

using core::Code;
using core::ElementKind;
using plcopen::Fate;

void DeclarationReader::configuration() {
  const Token opener = token_;
  advance();
  plcopen::Configuration out;
  out.at = place(token_.begin);
  if (!name(out.name, "the name of the CONFIGURATION")) skip_declaration();
  count("CONFIGURATION", Fate::kUsed, place(opener.begin));
  plcopen::Resource single;  // tasks and programs without a RESOURCE around them
  single.at = out.at;
  bool closed = false;
  while (!at(TokenKind::kEnd) && !closed) {
    const Word word = word_of(token_);
    if (accept(TokenKind::kSemicolon)) continue;
    if (word == Word::kEndConfiguration) {
      advance();
      accept(TokenKind::kSemicolon);
      closed = true;
    } else if (word == Word::kVarConfig) {
      section(Owner::kConfiguration, out.configs);
    } else if (word == Word::kVarAccess) {
      section(Owner::kConfiguration, out.access);
    } else if (is_section(word)) {
      section(Owner::kConfiguration, out.globals);
    } else if (word == Word::kResource) {
      resource(out);
    } else if (!resource_part(single)) {
      break;
    }
  }
  if (!single.tasks.empty() || !single.instances.empty()) out.resources.push_back(std::move(single));
  if (!closed) {
    fail_unclosed("CONFIGURATION" + (out.name.empty() ? "" : " \"" + out.name + '"'), opener, "END_CONFIGURATION");
  }
  project_.configurations.push_back(std::move(out));
}

void DeclarationReader::resource(plcopen::Configuration& owner) {
  const Token opener = token_;
  advance();
  plcopen::Resource out;
  out.at = place(token_.begin);
  bool head = name(out.name, "the name of the RESOURCE");
  // The kind of processor after ON has no meaning here; some tools omit it.
  if (head && accept_text("ON")) {
    head = at(TokenKind::kIdentifier) || fail_expected("the type of the resource");
    if (head) dotted_path();
  }
  if (!head) skip_declaration();
  count("RESOURCE", Fate::kUsed, place(opener.begin));
  bool closed = false;
  while (!at(TokenKind::kEnd) && !closed) {
    const Word word = word_of(token_);
    if (accept(TokenKind::kSemicolon)) continue;
    if (word == Word::kEndResource) {
      advance();
      accept(TokenKind::kSemicolon);
      closed = true;
    } else if (is_section(word) && word != Word::kVarConfig && word != Word::kVarAccess) {
      section(Owner::kResource, out.globals);
    } else if (word == Word::kEndConfiguration || !resource_part(out)) {
      break;
    }
  }
  if (!closed) fail_unclosed("RESOURCE" + (out.name.empty() ? "" : " \"" + out.name + '"'), opener, "END_RESOURCE");
  owner.resources.push_back(std::move(out));
}

/// A task or a program instance; false when something else opens here.
bool DeclarationReader::resource_part(plcopen::Resource& out) {
  const Word word = word_of(token_);
  if (word == Word::kTask) {
    if (!task(out)) skip_declaration();
    return true;
  }
  // A POU after a configuration without its end: its name comes before variables, not before ":" or WITH.
  const bool instance = peek(2).kind == TokenKind::kColon || is_text(peek(2), "WITH") || is_text(peek(1), "RETAIN") ||
                        is_text(peek(1), "NON_RETAIN");
  if (word == Word::kProgram && instance) {
    if (!program_instance(out)) skip_declaration();
    return true;
  }
  if (is_section(word)) {
    std::vector<plcopen::Variable> unwanted;
    section(Owner::kResource, unwanted);
    return true;
  }
  if (word != Word::kNone) return false;
  fail_expected("TASK, PROGRAM or VAR_GLOBAL");
  advance();
  skip_declaration();
  return true;
}

/// "TASK t (SINGLE := x, INTERVAL := T#20ms, PRIORITY := 1);"
bool DeclarationReader::task(plcopen::Resource& resource) {
  count("TASK", Fate::kUsed, place(token_.begin));
  advance();
  plcopen::Task out;
  out.at = place(token_.begin, ElementKind::kTask);
  if (!name(out.name, "the name of the TASK")) return false;
  // Declared whatever its parameters are: programs that run with it are no errors of their own.
  resource.tasks.push_back(std::move(out));
  if (!task_parameters(resource.tasks.back())) return false;
  end_declaration();
  return true;
}

bool DeclarationReader::task_parameters(plcopen::Task& out) {
  if (!require(TokenKind::kLeftParen, "\"(\"")) return false;
  do {
    const Token key = token_;
    if (at(TokenKind::kRightParen)) break;
    std::string* target = at_text("SINGLE")     ? &out.single
                          : at_text("INTERVAL") ? &out.interval
                          : at_text("PRIORITY") ? &out.priority
                                                : nullptr;
    if (target == nullptr) return fail_expected("SINGLE, INTERVAL or PRIORITY");
    advance();
    if (!require(TokenKind::kAssign, "\":=\"")) return false;
    *target = expression().text;
    if (target->empty()) return fail_expected("the value of " + core::uppered(text_of(key)));
  } while (accept(TokenKind::kComma));
  return require(TokenKind::kRightParen, "\",\" or \")\"");
}

/// "PROGRAM RETAIN p WITH t : Type (In := x, Out => y);"
bool DeclarationReader::program_instance(plcopen::Resource& resource) {
  count("program instance", Fate::kUsed, place(token_.begin));
  advance();
  plcopen::PouInstance out;
  if (peek(1).kind == TokenKind::kIdentifier) {
    out.retain = accept_text("RETAIN");
    if (!out.retain) accept_text("NON_RETAIN");
  }
  out.at = place(token_.begin, ElementKind::kInstance);
  if (!name(out.name, "the name of the program instance")) return false;
  Token with;
  std::string task_name;
  if (accept_text("WITH")) {
    with = token_;
    if (!name(task_name, "the name of a TASK")) return false;
  }
  if (!require(TokenKind::kColon, "\":\"")) return false;
  out.type_name = dotted_path().text;
  if (out.type_name.empty()) return fail_expected("the name of a PROGRAM");
  if (accept(TokenKind::kLeftParen) && !accept(TokenKind::kRightParen)) {
    do {
      if (!connection(out)) return false;
    } while (accept(TokenKind::kComma));
    if (!require(TokenKind::kRightParen, "\",\" or \")\"")) return false;
  }
  std::vector<plcopen::PouInstance>* target = task_name.empty() ? &resource.instances : nullptr;
  for (plcopen::Task& one : resource.tasks) {
    if (!task_name.empty() && core::iequals(one.name, task_name)) target = &one.instances;
  }
  if (target == nullptr) {
    fail(Code::P4026, with,
         "program instance \"" + out.name + "\" runs WITH the task \"" + task_name +
             "\", which the resource does not declare before it",
         "declare the TASK before the PROGRAM");
    target = &resource.instances;
  }
  target->push_back(std::move(out));
  end_declaration();
  return true;
}

/// "In := x", "Out => y"; "fb WITH t" is refused.
bool DeclarationReader::connection(plcopen::PouInstance& instance) {
  plcopen::InstanceConnection out;
  out.at = place(token_.begin);
  const Token first = token_;
  out.variable = dotted_path().text;
  if (out.variable.empty()) return fail_expected("a variable of the program");
  if (accept_text("WITH")) {
    fail(Code::P4043, first, "function block \"" + out.variable + "\" with a task of its own is not supported",
         "make it a program, or call it in the program");
    dotted_path();
    return true;
  }
  out.output = at(TokenKind::kOutput);
  if (!out.output && !at(TokenKind::kAssign)) return fail_expected("\":=\" or \"=>\"");
  advance();
  Piece other = expression();
  if (other.text.empty()) return fail_expected("what \"" + out.variable + "\" is connected to");
  out.other = std::move(other.text);
  out.other_at = other.at;
  instance.connections.push_back(std::move(out));
  return true;
}

}  // namespace plc::st
