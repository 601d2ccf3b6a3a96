// What other tools write in bodies and PICARD does not know: named, instead of the first token that does not fit.
#include <cstdint>
#include <set>
#include <utility>

#include "core/text.h"
#include "frontend-st/foreign.h"
#include "frontend-st/keywords.h"
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

// Keywords of a whole text. Names after a dot are members, whatever they spell.
bool Parser::lacks(Keyword end, Keyword opener) const {
  std::int64_t open = 0;
  Lexer all(source_.text());
  TokenKind before = TokenKind::kEnd;
  for (Token token = all.next(); token.kind != TokenKind::kEnd; before = std::exchange(token, all.next()).kind) {
    if (token.kind != TokenKind::kIdentifier || before == TokenKind::kDot) continue;
    const Keyword keyword = keyword_of(text_of(token));
    open += keyword == opener ? 1 : keyword == end ? -1 : 0;
  }
  return open > 0;
}

// "ELSIF (a > b) THEN" has its THEN before the semicolon that would end a call.
bool Parser::leads_to_then() const {
  constexpr int kMaxTokens = 256;  // of a condition: texts without a semicolon would be read again for each of them
  Lexer ahead = lexer_;
  for (int i = 0; i < kMaxTokens; ++i) {
    const Token token = ahead.next();
    if (token.kind == TokenKind::kSemicolon || token.kind == TokenKind::kEnd) return false;
    if (token.kind == TokenKind::kIdentifier && keyword_of(text_of(token)) == Keyword::kThen) return true;
  }
  return false;
}

// ENDIF, END IF, ELSEIF at the begin of a statement: reported, and taken for the keyword that is meant. What may be a
// call or a set of something with such a name is none of them: no right program has a statement without its end.
void Parser::correct_spelling() {
  struct Misspelt {
    std::string_view written;
    Keyword keyword;
    Keyword opener;
    std::string_view meant;
  };
  static constexpr Misspelt kWords[] = {
      {"ENDIF", Keyword::kEndIf, Keyword::kIf, "END_IF"},
      {"ENDFOR", Keyword::kEndFor, Keyword::kFor, "END_FOR"},
      {"ENDWHILE", Keyword::kEndWhile, Keyword::kWhile, "END_WHILE"},
      {"ENDCASE", Keyword::kEndCase, Keyword::kCase, "END_CASE"},
      {"ENDREPEAT", Keyword::kEndRepeat, Keyword::kRepeat, "END_REPEAT"},
      {"ELSEIF", Keyword::kElsif, Keyword::kIf, "ELSIF"},
      {"ELIF", Keyword::kElsif, Keyword::kIf, "ELSIF"},
  };
  if (token_.kind != TokenKind::kIdentifier || keyword_ != Keyword::kNone) return;
  const std::string_view word = text_of(token_);
  if (core::upper(word[0]) != 'E' || word.size() < 3 || word.size() > 9) return;
  Lexer ahead = lexer_;
  const Token next = has_peeked_ ? peeked_ : ahead.next();
  const bool apart = core::iequals(word, "END") && next.kind == TokenKind::kIdentifier;
  const std::string written = std::string(word) + (apart ? std::string(text_of(next)) : "");
  for (const Misspelt& one : kWords) {
    if (!core::iequals(one.written, written)) continue;
    const bool condition = one.keyword == Keyword::kElsif;
    const bool ends = next.kind == TokenKind::kSemicolon || next.kind == TokenKind::kEnd;
    if (next.kind == TokenKind::kIdentifier) {
      // EndIf S= go
      const std::string_view name = text_of(next);
      const bool operates = core::iequals(name, "S") || core::iequals(name, "R") || core::iequals(name, "REF");
      if (!apart && operates && source_.text().substr(next.end).starts_with('=') && !leads_to_then()) return;
    } else if (condition ? next.kind != TokenKind::kLeftParen || !leads_to_then()
                         : !ends || !lacks(one.keyword, one.opener)) {
      return;
    }
    in_error_ = false;
    fail(Code::P4001, token_,
         '"' + std::string(source_.slice(token_.begin, apart ? next.end : token_.end)) + "\" is written " +
             std::string(one.meant));
    in_error_ = false;
    if (apart) advance();
    keyword_ = one.keyword;
    return;
  }
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
