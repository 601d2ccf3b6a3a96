// Statements. An error is reported once per statement; reading continues after it, inside compound statements too.
#include <utility>

#include "core/text.h"
#include "frontend-st/parser.h"
#include "frontend-st/suggestions.h"

namespace plc::st {
namespace {

using core::Code;

/// The statement that a keyword belongs to, for words that occur without it.
std::string_view opener_of(Keyword keyword) {
  switch (keyword) {
    case Keyword::kElsif:
    case Keyword::kElse:
    case Keyword::kEndIf:
      return "IF";
    case Keyword::kEndCase:
      return "CASE";
    case Keyword::kEndFor:
      return "FOR";
    case Keyword::kEndWhile:
      return "WHILE";
    case Keyword::kUntil:
    case Keyword::kEndRepeat:
      return "REPEAT";
    default:
      return {};
  }
}

bool opens(Keyword keyword) {
  return keyword == Keyword::kIf || keyword == Keyword::kCase || keyword == Keyword::kFor ||
         keyword == Keyword::kWhile || keyword == Keyword::kRepeat;
}

bool closes(Keyword keyword) {
  return keyword == Keyword::kEndIf || keyword == Keyword::kEndCase || keyword == Keyword::kEndFor ||
         keyword == Keyword::kEndWhile || keyword == Keyword::kEndRepeat;
}

}  // namespace

NodeId Parser::next_statement() {
  ast_.nodes.clear();
  while (token_.kind != TokenKind::kEnd) {
    if (!at_list_end()) {
      const NodeId one = listed_statement();
      if (one != kNoNode) return one;
      continue;
    }
    // A part of a compound statement without its head: say so and continue after it.
    in_error_ = false;
    fail(Code::P4013, token_,
         "\"" + std::string(text_of(token_)) + "\" without its " + std::string(opener_of(keyword_)));
    advance();
    accept(TokenKind::kSemicolon);
  }
  refuse_pragmas();
  return kNoNode;
}

// At the first token of a label of a CASE branch. Literals and parentheses begin no statement; a name is a label when
// what follows it and its members is ":", "," or "..", or an operator.
bool Parser::at_case_label() {
  switch (token_.kind) {
    case TokenKind::kInteger:
    case TokenKind::kReal:
    case TokenKind::kTyped:
    case TokenKind::kEnumValue:
    case TokenKind::kString:
    case TokenKind::kWstring:
    case TokenKind::kMinus:
    case TokenKind::kPlus:
    case TokenKind::kLeftParen:
      return true;
    case TokenKind::kIdentifier:
    case TokenKind::kDot:
      break;
    default:
      return false;
  }
  if (keyword_ != Keyword::kNone) return keyword_ == Keyword::kTrue || keyword_ == Keyword::kFalse;
  Lexer ahead = lexer_;
  if (token_.kind == TokenKind::kDot) {
    const Token name = has_peeked_ ? peeked_ : ahead.next();
    if (name.kind != TokenKind::kIdentifier) return false;
  }
  for (;;) {
    switch (ahead.next().kind) {
      case TokenKind::kDot:
        if (ahead.next().kind != TokenKind::kIdentifier) return false;
        break;
      case TokenKind::kColon:
      case TokenKind::kComma:
      case TokenKind::kRange:
      case TokenKind::kPlus:
      case TokenKind::kMinus:
      case TokenKind::kStar:
        return true;
      default:
        return false;
    }
  }
}

// The labels of a CASE branch and their colon: they begin no statement, so that a compound statement inside the branch
// before must have lost its end.
bool Parser::at_whole_label() {
  if (!at_case_label()) return false;
  Lexer ahead = lexer_;
  for (;;) {
    switch (ahead.next().kind) {
      case TokenKind::kColon:
        return true;
      case TokenKind::kInteger:
      case TokenKind::kTyped:
      case TokenKind::kEnumValue:
      case TokenKind::kString:
      case TokenKind::kWstring:
      case TokenKind::kIdentifier:
      case TokenKind::kDot:
      case TokenKind::kComma:
      case TokenKind::kRange:
      case TokenKind::kPlus:
      case TokenKind::kMinus:
        break;
      default:
        return false;
    }
  }
}

bool Parser::at_list_end() {
  correct_spelling();
  if (token_.kind == TokenKind::kEnd || !opener_of(keyword_).empty()) return true;
  return in_case_ ? at_case_label() : open_branches_ > 0 && at_whole_label();
}

NodeId Parser::statement_list() {
  NodeId first = kNoNode;
  NodeId last = kNoNode;
  while (!at_list_end()) {
    const NodeId one = listed_statement();
    if (one == kNoNode) continue;
    (last == kNoNode ? first : ast_.nodes[last].next) = one;
    last = one;
  }
  in_error_ = false;
  return first;
}

// After RETURN: a value as other languages give it there, and no statement that follows.
bool Parser::at_result() {
  if (token_.kind != TokenKind::kIdentifier || keyword_ == Keyword::kTrue || keyword_ == Keyword::kFalse) {
    return token_.kind != TokenKind::kDirect && token_.kind != TokenKind::kDot;
  }
  Lexer ahead = lexer_;
  return keyword_ == Keyword::kNone && (has_peeked_ ? peeked_ : ahead.next()).kind == TokenKind::kSemicolon;
}

// One statement and its semicolon. kNoNode for a semicolon alone, and after an error.
NodeId Parser::listed_statement() {
  if (accept(TokenKind::kSemicolon)) return kNoNode;
  in_error_ = false;
  const std::uint32_t depth = depth_;
  const bool in_case = std::exchange(in_case_, false);
  const bool compound = opens(keyword_);
  const NodeId one = statement();
  depth_ = depth;
  in_case_ = in_case;
  if (one == kNoNode) {
    if (in_error_ && !at_list_end()) skip_statement();
    return kNoNode;
  }
  // END_IF and its like end a statement by themselves: many tools take them without a semicolon.
  if (accept(TokenKind::kSemicolon) || compound) return one;
  // The last statement of a text may lack its semicolon: EXECUTE boxes are often one assignment.
  if (token_.kind == TokenKind::kEnd) return one;
  in_error_ = false;
  const bool returns = ast_[one].kind == NodeKind::kReturn && at_result();
  fail(Code::P4013, token_, "\";\" is missing before " + shown_token(text_of(token_)),
       stray_character(text_of(token_)) != 0 ? kStrayHelp
       : returns                             ? "the result of a function is assigned to its name"
                                             : operator_meant(source_.text(), token_.begin));
  const bool begins_statement =
      !returns && token_.kind == TokenKind::kIdentifier && (keyword_ == Keyword::kNone || opens(keyword_));
  if (!at_list_end() && !begins_statement) skip_statement();
  return one;
}

// After an error: to the end of the statement that has it, nested ones included.
void Parser::skip_statement() {
  std::uint32_t nested = 0;
  for (;;) {
    if (token_.kind == TokenKind::kEnd) return;
    if (nested == 0 && accept(TokenKind::kSemicolon)) return;
    if (nested == 0 && !opener_of(keyword_).empty()) return;
    if (opens(keyword_)) ++nested;
    if (closes(keyword_) && nested > 0) --nested;
    advance();
  }
}

NodeId Parser::statement() {
  switch (keyword_) {
    case Keyword::kIf:
      return if_statement();
    case Keyword::kCase:
      return case_statement();
    case Keyword::kFor:
      return for_statement();
    case Keyword::kWhile:
      return while_statement();
    case Keyword::kRepeat:
      return repeat_statement();
    case Keyword::kExit:
      return word_statement(NodeKind::kExit);
    case Keyword::kContinue:
      return word_statement(NodeKind::kContinue);
    case Keyword::kReturn:
      return word_statement(NodeKind::kReturn);
    default:
      return assignment_or_call();
  }
}

NodeId Parser::word_statement(NodeKind kind) {
  Node node;
  node.kind = kind;
  node.begin = token_.begin;
  node.end = token_.end;
  advance();
  return ast_.add(node);
}

std::optional<Operator> Parser::assignment_operator() {
  if (accept(TokenKind::kAssign)) return Operator::kNone;
  if (token_.kind != TokenKind::kIdentifier) return std::nullopt;
  const bool binds = core::iequals(text_of(token_), "REF");
  const char letter = core::upper(text_of(token_)[0]);
  if (!binds && (token_.end - token_.begin != 1 || (letter != 'S' && letter != 'R'))) return std::nullopt;
  if (!has_peeked_) peeked_ = lexer_.next();
  has_peeked_ = true;
  if (peeked_.kind != TokenKind::kEqual || peeked_.begin != token_.end) return std::nullopt;
  advance();
  advance();
  if (binds) return Operator::kBind;
  return letter == 'S' ? Operator::kSet : Operator::kReset;
}

NodeId Parser::assignment_or_call() {
  Node node;
  node.begin = token_.begin;
  if (refuse_foreign_statement()) return kNoNode;
  if (token_.kind != TokenKind::kIdentifier && token_.kind != TokenKind::kDirect && !at_global_name())
    return fail_unexpected("a statement");
  NodeId target = primary();
  if (target == kNoNode) return kNoNode;
  const NodeKind named = ast_[target].kind;
  const bool ends = token_.kind == TokenKind::kSemicolon || token_.kind == TokenKind::kEnd;
  if (ends && (named == NodeKind::kName || named == NodeKind::kMember)) {
    // "Start;" calls an action (CODESYS 2.3); the lowering knows whether it is one.
    Node call;
    call.kind = NodeKind::kCall;
    call.begin = node.begin;
    call.end = ast_[target].end;
    call.name = token_.begin;
    call.name_end = token_.begin + 1;
    call.a = target;
    target = ast_.add(call);
  }
  // a := b := c: each value but the last is a variable of its own.
  std::vector<std::pair<NodeId, Operator>> targets;
  NodeId value = target;
  while (const auto op = assignment_operator()) {
    targets.emplace_back(value, *op);
    value = expression(1);
    if (value == kNoNode) return kNoNode;
  }
  if (!targets.empty()) {
    for (; !targets.empty(); targets.pop_back()) {
      node.kind = NodeKind::kAssign;
      node.a = targets.back().first;
      node.op = targets.back().second;
      node.b = value;
      node.begin = ast_[node.a].begin;
      node.end = ast_[value].end;
      value = ast_.add(node);
    }
    return value;
  }
  if (refuse_foreign_operator(target)) return kNoNode;
  if (ast_[target].kind != NodeKind::kCall) {
    if (token_.kind == TokenKind::kEqual) {
      return fail(Code::P4013, token_, "\"=\" compares and is no statement", "assignments are written with :=");
    }
    return fail_unexpected("\":=\" or \"(\"");
  }
  node.kind = NodeKind::kCallStatement;
  node.a = target;
  node.end = ast_[target].end;
  return ast_.add(node);
}

NodeId Parser::head_expression(Keyword terminator, std::string_view word) {
  const std::uint32_t depth = depth_;
  NodeId head = expression(1);
  depth_ = depth;
  if (head != kNoNode && !at_keyword(terminator)) {
    fail_unexpected("an operator or " + std::string(word));
    head = kNoNode;
  }
  if (head == kNoNode) {
    while (token_.kind != TokenKind::kEnd && token_.kind != TokenKind::kSemicolon && !at_keyword(terminator)) advance();
  }
  if (at_keyword(terminator)) advance();
  return head;
}

// The keyword that ends the compound statement `what`, which began at `begin`.
bool Parser::end_compound(Keyword end, std::string_view word, const Token& begin, std::string_view what,
                          std::string_view help) {
  if (at_keyword(end)) {
    advance();
    return true;
  }
  in_error_ = false;
  if (token_.kind == TokenKind::kEnd) {
    fail(Code::P4013, begin, std::string(what) + " without " + std::string(word), std::string(help));
  } else if (!help.empty()) {
    fail(Code::P4001, token_, "found " + shown_token(text_of(token_)) + " where " + std::string(word) + " is expected",
         std::string(help));
  } else {
    fail(Code::P4001, token_, "found " + shown_token(text_of(token_)) + " where " + std::string(word) + " is expected",
         "the " + std::string(what) + " of line " + std::to_string(source_.locate(begin.begin).line) +
             " is open: write " + std::string(word) + " where it ends");
  }
  return false;
}

NodeId Parser::if_statement() {
  if (!enter()) return kNoNode;
  const Token begin = token_;
  NodeId first = kNoNode;
  NodeId last = kNoNode;
  const auto link = [&](const Node& part) {
    const NodeId id = ast_.add(part);
    (last == kNoNode ? first : ast_.nodes[last].c) = id;
    last = id;
  };
  do {
    Node node;
    node.kind = NodeKind::kIf;
    node.begin = token_.begin;
    advance();
    node.a = head_expression(Keyword::kThen, "THEN");
    node.b = statement_list();
    node.end = last_end_;
    link(node);
  } while (at_keyword(Keyword::kElsif));
  std::string_view help;
  if (at_keyword(Keyword::kElse)) {
    Node node;
    node.kind = NodeKind::kElse;
    node.begin = token_.begin;
    advance();
    // "ELSE IF" opens an IF inside of the ELSE. On one line it was probably meant otherwise.
    const bool same_line =
        source_.text().substr(last_end_, token_.begin - last_end_).find('\n') == std::string_view::npos;
    if (at_keyword(Keyword::kIf) && same_line) {
      help = "ELSE IF begins an IF of its own, with its own END_IF: the next condition of the same IF is ELSIF";
    }
    node.b = statement_list();
    node.end = last_end_;
    link(node);
  }
  leave();
  return end_compound(Keyword::kEndIf, "END_IF", begin, "IF", help) ? first : kNoNode;
}

NodeId Parser::case_label() {
  const NodeId from = expression(1);
  if (from == kNoNode || !accept(TokenKind::kRange)) return from;
  const NodeId to = expression(1);
  if (to == kNoNode) return kNoNode;
  Node node;
  node.kind = NodeKind::kRange;
  node.begin = ast_[from].begin;
  node.end = ast_[to].end;
  node.a = from;
  node.b = to;
  return ast_.add(node);
}

NodeId Parser::case_statement() {
  if (!enter()) return kNoNode;
  const Token begin = token_;
  Node node;
  node.kind = NodeKind::kCase;
  node.begin = token_.begin;
  advance();
  node.a = head_expression(Keyword::kOf, "OF");
  NodeId last = kNoNode;
  const auto link = [&](const Node& part) {
    const NodeId id = ast_.add(part);
    (last == kNoNode ? node.c : ast_.nodes[last].c) = id;
    last = id;
  };
  while (accept(TokenKind::kSemicolon)) {
  }
  while (token_.kind != TokenKind::kEnd && opener_of(keyword_).empty()) {
    Node branch;
    branch.kind = NodeKind::kBranch;
    branch.begin = token_.begin;
    in_error_ = false;
    NodeId last_label = kNoNode;
    bool labels_good = true;
    do {
      const NodeId label = case_label();
      labels_good = labels_good && label != kNoNode;
      if (!labels_good) break;
      (last_label == kNoNode ? branch.a : ast_.nodes[last_label].next) = label;
      last_label = label;
    } while (accept(TokenKind::kComma));
    if (labels_good && token_.kind != TokenKind::kColon) {
      fail_unexpected("\",\", \"..\" or \":\"");
      labels_good = false;
    }
    if (!labels_good) {
      while (token_.kind != TokenKind::kEnd && token_.kind != TokenKind::kColon &&
             token_.kind != TokenKind::kSemicolon && opener_of(keyword_).empty()) {
        advance();
      }
    }
    if (!accept(TokenKind::kColon)) accept(TokenKind::kSemicolon);
    in_case_ = true;
    ++open_branches_;
    branch.b = statement_list();
    --open_branches_;
    in_case_ = false;
    branch.end = last_end_;
    link(branch);
  }
  if (at_keyword(Keyword::kElse)) {
    Node other;
    other.kind = NodeKind::kElse;
    other.begin = token_.begin;
    advance();
    accept(TokenKind::kColon);  // some tools write "ELSE:"
    other.b = statement_list();
    other.end = last_end_;
    link(other);
  }
  leave();
  if (!end_compound(Keyword::kEndCase, "END_CASE", begin, "CASE")) return kNoNode;
  node.end = last_end_;
  return ast_.add(node);
}

NodeId Parser::for_statement() {
  if (!enter()) return kNoNode;
  const Token begin = token_;
  Node node;
  node.kind = NodeKind::kFor;
  node.begin = token_.begin;
  advance();
  const auto head = [&] {
    if (token_.kind != TokenKind::kIdentifier) {
      fail_unexpected("the control variable");
      return false;
    }
    node.a = primary();
    if (node.a == kNoNode) return false;
    if (!accept(TokenKind::kAssign)) {
      fail_unexpected("\":=\"");
      return false;
    }
    node.c = expression(1);
    if (node.c == kNoNode) return false;
    if (!at_keyword(Keyword::kTo)) {
      fail_unexpected("an operator or TO");
      return false;
    }
    advance();
    const NodeId final_value = expression(1);
    if (final_value == kNoNode) return false;
    ast_.nodes[node.c].next = final_value;
    if (at_keyword(Keyword::kBy)) {
      advance();
      const NodeId increment = expression(1);
      if (increment == kNoNode) return false;
      ast_.nodes[final_value].next = increment;
    }
    if (at_keyword(Keyword::kDo)) return true;
    fail_unexpected("an operator, BY or DO");
    return false;
  };
  const std::uint32_t depth = depth_;
  const bool good = head();
  depth_ = depth;
  if (!good) {
    while (token_.kind != TokenKind::kEnd && token_.kind != TokenKind::kSemicolon && !at_keyword(Keyword::kDo))
      advance();
  }
  if (at_keyword(Keyword::kDo)) advance();
  node.b = statement_list();
  leave();
  if (!end_compound(Keyword::kEndFor, "END_FOR", begin, "FOR")) return kNoNode;
  node.end = last_end_;
  return ast_.add(node);
}

NodeId Parser::while_statement() {
  if (!enter()) return kNoNode;
  const Token begin = token_;
  Node node;
  node.kind = NodeKind::kWhile;
  node.begin = token_.begin;
  advance();
  node.a = head_expression(Keyword::kDo, "DO");
  node.b = statement_list();
  leave();
  if (!end_compound(Keyword::kEndWhile, "END_WHILE", begin, "WHILE")) return kNoNode;
  node.end = last_end_;
  return ast_.add(node);
}

NodeId Parser::repeat_statement() {
  if (!enter()) return kNoNode;
  const Token begin = token_;
  Node node;
  node.kind = NodeKind::kRepeat;
  node.begin = token_.begin;
  advance();
  node.b = statement_list();
  leave();
  if (!end_compound(Keyword::kUntil, "UNTIL", begin, "REPEAT")) return kNoNode;
  const std::uint32_t depth = depth_;
  node.a = expression(1);
  depth_ = depth;
  if (node.a == kNoNode) {
    while (token_.kind != TokenKind::kEnd && opener_of(keyword_).empty()) advance();
  }
  accept(TokenKind::kSemicolon);
  if (!end_compound(Keyword::kEndRepeat, "END_REPEAT", begin, "REPEAT")) return kNoNode;
  node.end = last_end_;
  return ast_.add(node);
}

}  // namespace plc::st
