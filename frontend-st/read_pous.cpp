// POUs: heads and bodies. A body stays text, from its first token to its last; what cannot be in it is blanked out,
// so that the places of the rest stay true.
#include <algorithm>
#include <utility>

#include "core/text.h"
#include "core/types.h"
#include "frontend-st/declaration_reader.h"
#include "frontend-st/foreign.h"

namespace plc::st {

using core::Code;
using plcopen::Fate;
using plcopen::Language;
using plcopen::PouKind;

namespace {

Word end_of(Word opener) {
  return opener == Word::kFunction        ? Word::kEndFunction
         : opener == Word::kFunctionBlock ? Word::kEndFunctionBlock
         : opener == Word::kTest          ? Word::kEndTest
                                          : Word::kEndProgram;
}
const char* text_of_word(Word opener) {
  return opener == Word::kFunction        ? "FUNCTION"
         : opener == Word::kFunctionBlock ? "FUNCTION_BLOCK"
         : opener == Word::kTest          ? "TEST"
                                          : "PROGRAM";
}
bool ends_pou(Word word) {
  return word == Word::kEndFunction || word == Word::kEndFunctionBlock || word == Word::kEndProgram;
}

/// Whether a body is an instruction list, by its first instruction. A name after a name is no ST.
bool begins_instructions(std::string_view text) {
  Lexer lexer(text);
  const auto is_instruction = [&](const Token& token) {
    static constexpr std::string_view kInstructions[] = {"LD",   "LDN", "ST",   "STN",   "CAL",  "CALC", "CALCN",
                                                         "CALN", "JMP", "JMPC", "JMPCN", "JMPN", "S",    "R"};
    return token.kind == TokenKind::kIdentifier &&
           std::any_of(std::begin(kInstructions), std::end(kInstructions), [&](std::string_view one) {
             return core::iequals(text.substr(token.begin, token.end - token.begin), one);
           });
  };
  const auto is_operand = [](TokenKind kind) {
    return kind == TokenKind::kIdentifier || kind == TokenKind::kInteger || kind == TokenKind::kReal ||
           kind == TokenKind::kTyped || kind == TokenKind::kEnumValue || kind == TokenKind::kString ||
           kind == TokenKind::kWstring || kind == TokenKind::kDirect || kind == TokenKind::kMinus;
  };
  Token first = lexer.next();
  Token second = lexer.next();
  while (first.kind == TokenKind::kIdentifier && second.kind == TokenKind::kColon) {
    first = lexer.next();
    second = lexer.next();
  }
  if (is_instruction(first) && is_operand(second.kind)) {
    // The next instruction follows the operand, or its members; in ST something that continues the statement.
    const TokenKind then = lexer.next().kind;
    return second.kind == TokenKind::kMinus || then == TokenKind::kIdentifier || then == TokenKind::kEnd ||
           then == TokenKind::kDot || then == TokenKind::kLeftBracket || then == TokenKind::kLeftParen ||
           then == TokenKind::kRightParen || then == TokenKind::kComma || then == TokenKind::kSemicolon ||
           then == TokenKind::kCaret || then == TokenKind::kAnd;
  }
  if (first.kind != TokenKind::kIdentifier || second.kind != TokenKind::kLeftParen) return false;
  // LIMIT(MN := 1, ..) and what is done with its result.
  std::size_t open = 1;
  while (open != 0) {
    const TokenKind kind = lexer.next().kind;
    if (kind == TokenKind::kEnd || kind == TokenKind::kSemicolon) return false;
    if (kind == TokenKind::kLeftParen) ++open;
    if (kind == TokenKind::kRightParen) --open;
  }
  Token next = lexer.next();
  if (next.kind == TokenKind::kSemicolon) next = lexer.next();
  return is_instruction(next) && is_operand(lexer.next().kind);
}

}  // namespace

void DeclarationReader::pou(Word opener_word) {
  const Token opener = token_;
  const std::uint32_t before = last_end_;
  note_spelling(opener, opener_word);
  plcopen::Pou out;
  // Which dialect a chart has is not seen by its text.
  if (attribute_here("sfc_final_scan")) project_.has_3s_charts = true;
  const bool named = pou_head(out, opener_word);
  pou_ = out.name;
  note_attributes(out.name, {}, before, opener.begin);
  if (!named) {
    // What follows up to the sections belongs to the head.
    while (!at(TokenKind::kEnd) && !is_section(word_of(token_)) && !ends_pou(word_of(token_)) && !opens_another()) {
      advance();
    }
  }
  const Owner owner = opener_word == Word::kFunction        ? Owner::kFunction
                      : opener_word == Word::kFunctionBlock ? Owner::kFunctionBlock
                                                            : Owner::kProgram;
  while (is_section(word_of(token_))) section(owner, out.variables);
  body(out, opener, opener_word);
  count(text_of_word(opener_word), Fate::kUsed, place(opener.begin));
  pou_.clear();
  note_extent({out.name}, opener.begin);
  if (!out.name.empty()) project_.pous.push_back(std::move(out));
}

bool DeclarationReader::pou_head(plcopen::Pou& out, Word opener_word) {
  const char* const what = text_of_word(opener_word);
  out.kind = opener_word == Word::kFunction        ? PouKind::kFunction
             : opener_word == Word::kFunctionBlock ? PouKind::kFunctionBlock
                                                   : PouKind::kProgram;
  out.at = place(token_.begin);
  advance();
  while ((at_text("FINAL") || at_text("ABSTRACT") || at_text("PUBLIC") || at_text("INTERNAL")) &&
         peek(1).kind == TokenKind::kIdentifier) {
    if (objects_ != nullptr) {
      objects_->push_back(core::uppered(text_of(token_)));
    } else {
      fail(Code::P4041, token_, shown(token_) + " belongs to object orientation, which is not supported", "remove it");
    }
    advance();
  }
  const std::uint32_t at_name = token_.begin;
  if (!name(out.name, std::string("the name of the ") + what)) return false;
  out.at = place(at_name);
  pou_ = out.name;
  bool reported = false;
  while (at_text("EXTENDS") || at_text("IMPLEMENTS")) {
    const std::uint32_t clause = token_.begin;
    if (objects_ == nullptr && !std::exchange(reported, true)) {
      fail(Code::P4041, token_,
           std::string(what) + " \"" + out.name + "\" " + core::uppered(text_of(token_)) +
               ": inheritance belongs to object orientation, which is not supported",
           "declare an instance of the other block as a variable");
    }
    advance();
    dotted_path();
    while (accept(TokenKind::kComma)) dotted_path();
    if (objects_ != nullptr) objects_->emplace_back(source_.slice(clause, last_end_));
  }
  while (at_text("USING")) {
    fail(Code::P4041, token_, "USING belongs to namespaces, which are not supported", "remove it");
    while (!at(TokenKind::kEnd) && !accept(TokenKind::kSemicolon)) advance();
  }
  if (at(TokenKind::kColon)) {
    if (opener_word != Word::kFunction) return fail_expected("a section of variables or a statement");
    advance();
    if (!type_spec(out.return_type)) return false;
  } else if (opener_word == Word::kFunction && at(TokenKind::kIdentifier) && core::type_named(text_of(token_)) &&
             (peek(1).kind == TokenKind::kIdentifier || peek(1).kind == TokenKind::kSemicolon)) {
    fail(Code::P4040, token_, "\":\" is missing before " + shown(token_));
    if (!type_spec(out.return_type)) return false;
  }
  accept(TokenKind::kSemicolon);
  return true;
}

/// True at a word that opens another POU or part of a file: the END_ of the open POU is missing.
bool DeclarationReader::opens_another() {
  if (opens_test()) return true;
  const Word word = word_of(token_);
  const bool opens = word == Word::kFunction || word == Word::kFunctionBlock || word == Word::kProgram ||
                     word == Word::kConfiguration || word == Word::kType || word == Word::kClass ||
                     word == Word::kInterface || word == Word::kNamespace;
  return opens && peek(1).kind == TokenKind::kIdentifier;
}

/// The language of the body that begins at the current token, by its first words.
Language DeclarationReader::language() {
  const Word word = word_of(token_);
  const TokenKind next = peek(1).kind;
  const bool chart = word == Word::kInitialStep || word == Word::kStep || word == Word::kTransition;
  if (chart && (next == TokenKind::kIdentifier || (word == Word::kTransition && next == TokenKind::kLeftParen))) {
    return Language::kSfc;
  }
  return at(TokenKind::kIdentifier) && begins_instructions(source_.text().substr(token_.begin)) ? Language::kIl
                                                                                                : Language::kSt;
}

/// Pragmas before the first statement and after the last one are no part of the text, which its parser looks at.
void DeclarationReader::refuse_code(std::uint32_t begin, std::uint32_t end) {
  if (begin >= end) return;
  std::vector<Token> pragmas;
  Lexer(source_.slice(begin, end), &pragmas).next();
  for (const Token& pragma : pragmas) {
    if (!is_c_code(source_.slice(begin + pragma.begin, begin + pragma.end))) continue;
    fail(Code::P4067, {TokenKind::kUnknown, begin + pragma.begin, begin + pragma.end}, kCodeInC, kCodeInCHelp);
  }
}

std::uint32_t DeclarationReader::first_choice(std::uint32_t begin, std::uint32_t end, std::uint32_t none) const {
  std::vector<Token> pragmas;
  Lexer(source_.slice(begin, end), &pragmas).next();
  for (const Token& pragma : pragmas) {
    if (is_choosing_pragma(source_.slice(begin + pragma.begin, begin + pragma.end))) return begin + pragma.begin;
  }
  return none;
}

std::uint32_t DeclarationReader::last_choice(std::uint32_t begin, std::uint32_t end, std::uint32_t none) const {
  if (begin >= end) return none;
  std::vector<Token> pragmas;
  Lexer(source_.slice(begin, end), &pragmas).next();
  std::uint32_t last = none;
  for (const Token& pragma : pragmas) {
    if (is_choosing_pragma(source_.slice(begin + pragma.begin, begin + pragma.end))) last = begin + pragma.end;
  }
  return last;
}

std::uint32_t DeclarationReader::first_comment(std::uint32_t begin, std::uint32_t end) const {
  auto comment = std::lower_bound(comments_.begin(), comments_.end(), begin,
                                  [](const Token& one, std::uint32_t at) { return one.begin < at; });
  for (; comment != comments_.end() && comment->end <= end; begin = comment++->end) {
    const std::string_view before = source_.slice(begin, comment->begin);
    const std::size_t line = before.find_last_of("\r\n");
    // One behind the declarations is about those.
    if (line != std::string_view::npos) return begin + static_cast<std::uint32_t>(line) + 1;
  }
  return end;
}

void DeclarationReader::keep_lead(plcopen::Body& body, std::uint32_t lead, std::uint32_t begin) const {
  if (lead >= begin || body.text.empty()) return;
  body.lead = source_.slice(lead, begin);
  body.lead_at = place(lead, core::ElementKind::kText);
}

std::shared_ptr<const std::vector<std::string>> DeclarationReader::defines_at(std::uint32_t offset) const {
  if (chosen_ == nullptr || !chosen_->has_defines()) return nullptr;
  return std::make_shared<const std::vector<std::string>>(chosen_->defines_at(offset));
}

void DeclarationReader::body(plcopen::Pou& out, const Token& opener, Word opener_word) {
  const std::string label = std::string(text_of_word(opener_word)) + (out.name.empty() ? "" : " \"" + out.name + '"');
  const Word end = end_of(opener_word);
  while (word_of(token_) == Word::kAction && peek(1).kind == TokenKind::kIdentifier) action(out.name);
  plcopen::Body& body = out.bodies.emplace_back();
  // Pragmas that choose belong to the text, also before its first token and after its last one.
  const std::uint32_t begin = first_choice(last_end_, token_.begin, token_.begin);
  const std::uint32_t lead = first_comment(last_end_, begin);
  std::uint32_t text_end = begin;
  std::uint32_t end_at = begin;
  in_body_ = true;
  refuse_code(last_end_, token_.begin);
  body.language = language();
  body.at = body.text_at = place(begin, core::ElementKind::kText);
  body.defines = defines_at(begin);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> blanks;
  bool misplaced = false;
  bool closed = false;
  TokenKind before = TokenKind::kEnd;
  while (!at(TokenKind::kEnd)) {
    const Word word = before == TokenKind::kDot ? Word::kNone : word_of(token_);
    if (ends_pou(word) || (opener_word == Word::kTest && word == Word::kEndTest)) {
      closed = true;
      note_spelling(token_, word);
      if (word != end) {
        const std::string wanted = std::string("END_") + text_of_word(opener_word);
        fail(Code::P4042, token_, label + " ends with " + core::uppered(text_of(token_)), "write " + wanted);
      }
      end_at = token_.begin;
      advance();
      accept(TokenKind::kSemicolon);
      break;
    }
    if (word != Word::kNone && opens_another()) break;
    const std::uint32_t here = token_.begin;
    const bool names = peek(1).kind == TokenKind::kIdentifier;
    if (is_section(word)) {
      if (!std::exchange(misplaced, true)) {
        fail(Code::P4045, token_, "variables are declared after the first statement of " + label,
             "move the section before the statements");
      }
      skip_to(Word::kEndVar);
    } else if (names && word == Word::kMethod) {
      out.unread_members.push_back(refuse(Word::kMethod, Word::kEndMethod, "METHOD"));
    } else if (names && word == Word::kProperty) {
      out.unread_members.push_back(refuse(Word::kProperty, Word::kEndProperty, "PROPERTY"));
    } else if (names && word == Word::kAction) {
      action(out.name);
      in_body_ = true;
    } else {
      before = token_.kind;
      text_end = token_.end;
      advance();
      continue;
    }
    before = TokenKind::kEnd;
    blanks.emplace_back(here, last_end_);
    text_end = last_end_;
  }
  in_body_ = false;
  refuse_code(text_end, closed ? end_at : token_.begin);
  text_end = last_choice(text_end, closed ? end_at : token_.begin, text_end);
  if (text_end > begin) text_end = last_comment(text_end, closed ? end_at : token_.begin);
  bodies_.emplace_back(begin, text_end);
  for (auto& [first, last] : blanks) {
    first -= begin;
    last -= begin;
  }
  body.text = blanked(source_.slice(begin, text_end), blanks);
  keep_lead(body, lead, begin);
  if (body.text.empty()) body.language = Language::kNone;
  if (body.language == Language::kSfc) {
    out.has_chart = true;
    body.drawn_elements = 1;
  }
  if (!closed) fail_unclosed(label, opener, std::string("END_") + text_of_word(opener_word));
}

}  // namespace plc::st
