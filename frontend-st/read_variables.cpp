// Sections of variables.
#include <utility>

#include "core/text.h"
#include "frontend-st/declaration_reader.h"

namespace plc::st {

using core::Code;
using core::ElementKind;
using plcopen::Fate;
using plcopen::Section;
using plcopen::Variable;

namespace {

/// A million variables are 1 GB; no plant has them.
constexpr std::size_t kMaxDeclared = 1'000'000;
/// Bytes of declarations that `a, b, c : T` may repeat altogether.
constexpr std::size_t kMaxCopiedBytes = std::size_t{4} << 20;

Section section_of(Word word) {
  switch (word) {
    case Word::kVarInput:
      return Section::kInput;
    case Word::kVarOutput:
      return Section::kOutput;
    case Word::kVarInOut:
      return Section::kInOut;
    case Word::kVarTemp:
      return Section::kTemp;
    case Word::kVarExternal:
      return Section::kExternal;
    case Word::kVarGlobal:
      return Section::kGlobal;
    case Word::kVarAccess:
      return Section::kAccess;
    case Word::kVarConfig:
      return Section::kConfig;
    case Word::kVarInst:
      return Section::kInstance;
    case Word::kVarStat:
      return Section::kStatic;
    case Word::kVarGeneric:
      return Section::kGeneric;
    default:
      return Section::kLocal;
  }
}

}  // namespace

bool DeclarationReader::is_section(Word word) { return word >= Word::kVar && word <= Word::kVarStat; }

bool DeclarationReader::section_may_stand(Word word, Owner owner, const Token& opener) {
  const std::string text(text_of(opener));
  const bool in_pou = owner == Owner::kFunction || owner == Owner::kFunctionBlock || owner == Owner::kProgram;
  const auto refuse_here = [&](const char* why, const char* help) {
    return fail(Code::P4045, opener, core::uppered(text) + " " + why, help);
  };
  if (owner == Owner::kTest) {
    const bool fits = word == Word::kVar || word == Word::kVarTemp || word == Word::kVarExternal;
    return fits || refuse_here("is in a test, which nobody calls", "a test has VAR, VAR_TEMP and VAR_EXTERNAL");
  }
  switch (word) {
    case Word::kVarStat:
      if (!in_pou) return refuse_here("is outside of a POU", "globals are declared as VAR_GLOBAL");
      fail(Code::P4354, opener, "VAR_STAT is not in the standard",
           "declare the variables as VAR of a function block, or as globals");
      return true;
    case Word::kVarGeneric:
      if (owner == Owner::kFunctionBlock) return true;
      return refuse_here("is outside of a function block", "constants that a declaration gives belong to its type");
    case Word::kVarInst:
      if (owner == Owner::kFunctionBlock || owner == Owner::kProgram) return true;
      return refuse_here("is where nothing is kept from call to call",
                         "make the function a function block, or pass the variable as VAR_IN_OUT");
    case Word::kVarConfig:
      if (owner == Owner::kConfiguration || owner == Owner::kFile) return true;
      return refuse_here("is outside of a configuration", "move it into the CONFIGURATION");
    case Word::kVarAccess:
      if (owner == Owner::kConfiguration || owner == Owner::kFile || owner == Owner::kProgram) return true;
      return refuse_here("is outside of a configuration or program", "move it into the CONFIGURATION");
    case Word::kVarGlobal:
      if (owner != Owner::kFunction && owner != Owner::kFunctionBlock) return true;
      return refuse_here("is in a function or function block",
                         "declare the variable in a configuration, and here as VAR_EXTERNAL");
    default:
      return in_pou || refuse_here("is outside of a POU", "globals are declared as VAR_GLOBAL");
  }
}

/// CONSTANT, RETAIN, .. after the word that opens a section.
bool DeclarationReader::qualifier(Variable& model, const Token& opener) {
  if (peek(1).kind == TokenKind::kColon || peek(1).kind == TokenKind::kComma) return false;  // a variable of this name
  const Token word = token_;
  if (accept_text("CONSTANT")) {
    model.constant = true;
  } else if (accept_text("RETAIN")) {
    model.retain = true;
  } else if (accept_text("NON_RETAIN")) {
    model.nonretain = true;
  } else if (accept_text("PERSISTENT")) {
    model.persistent = true;
  } else if (accept_text("PUBLIC") || accept_text("PRIVATE") || accept_text("PROTECTED") || accept_text("INTERNAL")) {
    fail(Code::P4041, word, shown(word) + " belongs to object orientation, which is not supported", "remove it");
  } else {
    return false;
  }
  if (model.retain && model.nonretain) {
    fail(Code::P4045, opener, "section is RETAIN and NON_RETAIN at once", "keep one of them");
    model.nonretain = false;
  }
  return true;
}

void DeclarationReader::section(Owner owner, std::vector<Variable>& out) {
  const Token opener = token_;
  const Word word = word_of(opener);
  std::vector<Variable> unwanted;
  const bool wanted = section_may_stand(word, owner, opener);
  // What is local by mistake is still declared, so that its uses are no errors of their own.
  const bool keep = wanted || word == Word::kVarInst || word == Word::kVarGeneric;
  Variable model;
  if (word == Word::kVarGlobal && pou_.empty()) name_section(model);
  advance();
  model.section = wanted ? section_of(word) : Section::kLocal;
  while (at(TokenKind::kIdentifier) && qualifier(model, opener)) {
  }
  if (model.section == Section::kGeneric && !model.constant) {
    fail(Code::P4045, opener, "VAR_GENERIC without CONSTANT", "write VAR_GENERIC CONSTANT");
    model.constant = true;
  }
  if (model.constant && (model.retain || model.persistent)) {
    fail(Code::P4068, opener,
         core::uppered(text_of(opener)) + " is CONSTANT and " + (model.retain ? "RETAIN" : "PERSISTENT") +
             ": what never changes has nothing to keep",
         "leave one of them out");
  }
  count(core::uppered(text_of(opener)), wanted ? Fate::kUsed : Fate::kRefused, place(opener.begin),
        wanted ? "" : "it is not allowed here");
  std::vector<Variable>& target = keep ? out : unwanted;
  while (!at(TokenKind::kEnd)) {
    const Word inner = word_of(token_);
    if (inner == Word::kEndVar) {
      advance();
      accept(TokenKind::kSemicolon);
      return;
    }
    if (accept(TokenKind::kSemicolon)) continue;
    const TokenKind next = peek(1).kind;
    if (refuse_keyword(inner)) continue;
    const bool named = next == TokenKind::kColon || next == TokenKind::kComma;
    const bool opens = is_reserved(inner) || (inner != Word::kNone && !named);
    const std::uint32_t begin = token_.begin;
    if (opens || (word != Word::kVarConfig && begins_statement())) break;
    const std::size_t known = target.size();
    const bool fine = word == Word::kVarAccess   ? access_variable(target)
                      : word == Word::kVarConfig ? config_variable(target)
                                                 : variables(model, target);
    if (!fine) recover(begin);
    if (word != Word::kVarGlobal || !pou_.empty()) continue;
    std::vector<std::string> names;
    for (std::size_t i = known; i < target.size(); ++i) names.push_back(target[i].name);
    note_extent(std::move(names), begin);
  }
  fail_unclosed(core::uppered(text_of(opener)), opener, "END_VAR");
}

/// {attribute 'global_list' := 'GVL'} before VAR_GLOBAL names its list, which an XML file does by its element; with
/// {attribute 'qualified_only'} the name must come before the variables, else it may.
void DeclarationReader::name_section(Variable& model) {
  const bool required = attribute_here("qualified_only").has_value();
  const auto list = attribute_here("global_list");
  if (list && is_identifier(*list)) {
    (required ? model.list : model.prefix) = *list;
  } else {
    project_.qualified_globals |= required;
  }
}

/// True where a body begins though END_VAR was forgotten.
bool DeclarationReader::begins_statement() {
  if (!at(TokenKind::kIdentifier)) return false;
  for (const std::string_view word : {"IF", "CASE", "FOR", "WHILE", "REPEAT", "RETURN", "EXIT"}) {
    if (at_text(word) && peek(1).kind != TokenKind::kColon && peek(1).kind != TokenKind::kComma) return true;
  }
  const TokenKind next = peek(1).kind;
  return next == TokenKind::kAssign || next == TokenKind::kLeftParen || next == TokenKind::kDot ||
         next == TokenKind::kLeftBracket || next == TokenKind::kCaret;
}

/// Counts what is declared, and the text that `a, b : T` declares more than once. Beyond the limits reading stops.
bool DeclarationReader::pay(std::size_t things, std::size_t copied_bytes) {
  declared_ += things;
  copied_bytes_ += copied_bytes;
  if (declared_ <= kMaxDeclared && copied_bytes_ <= kMaxCopiedBytes) return true;
  fail(Code::P4044, token_,
       "the text declares more than " + std::to_string(kMaxDeclared) + " variables and values, or more than " +
           std::to_string(kMaxCopiedBytes >> 20) + " MiB in lists of names");
  exhausted_ = true;
  token_ = {TokenKind::kEnd, token_.begin, token_.begin};
  return false;
}

/// "a, b AT %IX0.0 : INT := 3;": one variable for each name. `model` has what the section says of all of them.
bool DeclarationReader::variables(const Variable& model, std::vector<Variable>& out) {
  const std::uint32_t before = last_end_;
  const std::uint32_t begin = token_.begin;
  Variable first = model;
  std::vector<Token> names;
  // The names stay known, so that their uses are no errors of their own.
  const auto refuse = [&] {
    for (const Token& token : names) {
      Variable& variable = out.emplace_back(model);
      variable.name = text_of(token);
      variable.at = place(token.begin, ElementKind::kVariable);
      variable.refused = true;
    }
    return false;
  };
  while (!at_text("AT") || !names.empty() || peek(1).kind != TokenKind::kDirect) {
    const Token token = token_;
    std::string text;
    if (!name(text, "the name of a variable")) return refuse();
    names.push_back(token);
    if (!accept(TokenKind::kComma)) break;
  }
  if (accept_text("AT")) {
    if (!at(TokenKind::kDirect)) return fail_expected("an address such as %IX0.0") || refuse();
    if (names.empty()) names.push_back(token_);  // a location without a name
    first.address = text_of(token_);
    if (names.size() > 1) return fail(Code::P4040, token_, "several variables have one address") || refuse();
    advance();
  }
  if (!require(TokenKind::kColon, "\":\"") || !type_spec(first.type)) return refuse();
  const Token edge = token_;
  const bool rising = accept_text("R_EDGE");
  if (rising || accept_text("F_EDGE")) {
    first.edge = rising ? plcopen::Edge::kRising : plcopen::Edge::kFalling;
    if (first.section != Section::kInput) {
      fail(Code::P4046, edge, shown(edge) + " follows a variable that is no VAR_INPUT",
           "call R_TRIG or F_TRIG in the body");
      first.edge = plcopen::Edge::kNone;
    }
  }
  // "r : REFERENCE TO INT REF= x;" is what ":= x" is there.
  const bool binds = first.type.kind == plcopen::TypeSpec::Kind::kReferenceTo && at_text("REF") &&
                     peek(1).kind == TokenKind::kEqual && peek(1).begin == token_.end;
  if (binds) advance();
  if (accept(binds ? TokenKind::kEqual : TokenKind::kAssign) && !initial_value(first.initial)) return refuse();
  if (!pay(names.size(), (names.size() - 1) * (last_end_ - begin))) return true;
  for (std::size_t i = 0; i < names.size(); ++i) {
    Variable& variable = i + 1 == names.size() ? out.emplace_back(std::exchange(first, {})) : out.emplace_back(first);
    variable.name = text_of(names[i]);
    variable.at = place(names[i].begin, ElementKind::kVariable);
    if (!kept_pragmas_.empty()) note_attributes(pou_, variable.name, before, begin);
  }
  end_declaration();
  return true;
}

/// "Alias : Resource.Program.Variable : INT READ_WRITE;"
bool DeclarationReader::access_variable(std::vector<Variable>& out) {
  Variable variable;
  variable.section = Section::kAccess;
  variable.at = place(token_.begin, ElementKind::kVariable);
  if (!name(variable.name, "the name of an access path") || !require(TokenKind::kColon, "\":\"")) return false;
  variable.address = dotted_path().text;
  if (variable.address.empty()) return fail_expected("the path of a variable");
  if (!require(TokenKind::kColon, "\":\"") || !type_spec(variable.type)) return false;
  variable.constant = !accept_text("READ_WRITE");
  accept_text("READ_ONLY");
  if (!pay(1)) return true;
  out.push_back(std::move(variable));
  end_declaration();
  return true;
}

/// "Resource.Program.Variable AT %QX0.0 : BOOL := TRUE;"
bool DeclarationReader::config_variable(std::vector<Variable>& out) {
  Variable variable;
  variable.section = Section::kConfig;
  variable.at = place(token_.begin, ElementKind::kVariable);
  variable.name = dotted_path().text;
  if (variable.name.empty()) return fail_expected("the path of a variable");
  if (accept_text("AT")) {
    if (!at(TokenKind::kDirect)) return fail_expected("an address such as %IX0.0");
    variable.address = text_of(token_);
    advance();
  }
  if (!require(TokenKind::kColon, "\":\"") || !type_spec(variable.type)) return false;
  if (accept(TokenKind::kAssign) && !initial_value(variable.initial)) return false;
  if (!pay(1)) return true;
  out.push_back(std::move(variable));
  end_declaration();
  return true;
}

}  // namespace plc::st
