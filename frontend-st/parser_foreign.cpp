// What other tools write in bodies and PICARD does not know: named, instead of the first token that does not fit.
#include <set>

#include "core/text.h"
#include "frontend-st/foreign.h"
#include "frontend-st/parser.h"

namespace plc::st {

using core::Code;

// Code in C between braces does not run.
void Parser::refuse_pragmas() {
  // Looking ahead passes some of them twice.
  std::set<std::uint32_t> seen;
  for (const Token& pragma : pragmas_) {
    if (!seen.insert(pragma.begin).second) continue;
    in_error_ = false;
    if (is_c_code(text_of(pragma))) {
      diagnostics_.report(Code::P4067, source_.locate(pragma.begin), pou_, kCodeInC, kCodeInCHelp);
    }
  }
}

// A word alone is a name like any other: what follows it decides.
bool Parser::refuse_foreign_statement() {
  if (token_.kind != TokenKind::kIdentifier) return false;
  Lexer ahead = lexer_;
  const Token next = has_peeked_ ? peeked_ : ahead.next();
  if (next.kind == TokenKind::kColon) {
    fail(Code::P4066, token_, "label \"" + std::string(text_of(token_)) + "\": jumps inside a text are not supported",
         "use IF and CASE, loops with EXIT and CONTINUE, or RETURN");
    advance();
    advance();
    in_error_ = false;
    return true;
  }
  const std::optional<Foreign> foreign = foreign_word(text_of(token_));
  const bool doubled = text_of(token_).starts_with("__");
  if (!foreign || (next.kind != TokenKind::kIdentifier && next.kind != TokenKind::kCaret && !doubled)) return false;
  if (next.kind == TokenKind::kAssign || next.kind == TokenKind::kDot) return false;
  fail(Code::P4066, token_, core::uppered(text_of(token_)) + ": " + std::string(foreign->what) + " is not supported",
       std::string(foreign->help));
  // __TRY, __CATCH(exc), .. end without a semicolon: the statement after is one of its own.
  if (core::iequals(text_of(token_), "__DELETE") || !doubled) return true;
  advance();
  if (token_.kind == TokenKind::kLeftParen) {
    while (token_.kind != TokenKind::kEnd && token_.kind != TokenKind::kRightParen &&
           token_.kind != TokenKind::kSemicolon) {
      advance();
    }
    accept(TokenKind::kRightParen);
  }
  in_error_ = false;
  return true;
}

// target ?= .., target REF= .., target += ..
bool Parser::refuse_foreign_operator(NodeId target) {
  const std::string_view word = text_of(token_);
  const std::string_view rest = source_.text().substr(token_.end);
  const std::string left(source_.slice(ast_[target].begin, ast_[target].end));
  if (word == "?" && rest.starts_with('=')) {
    fail(Code::P4066, token_, "\"?=\", the attempt of an assignment, is not supported",
         "references of one type are assigned with :=, and compared with NULL");
    return true;
  }
  const bool sign = token_.kind == TokenKind::kPlus || token_.kind == TokenKind::kMinus ||
                    token_.kind == TokenKind::kStar || token_.kind == TokenKind::kSlash;
  if (!sign) return false;
  if (rest.starts_with('=')) {
    fail(Code::P4066, token_, "\"" + std::string(word) + "=\" is no operator of ST",
         "write " + left + " := " + left + ' ' + std::string(word) + " value");
    return true;
  }
  if (!rest.starts_with(word)) return false;
  fail(Code::P4066, token_, "\"" + std::string(word) + std::string(word) + "\" is no operator of ST",
       "write " + left + " := " + left + ' ' + std::string(word) + " 1");
  return true;
}

}  // namespace plc::st
