#include "frontend-il/parser.h"

#include <utility>

#include "core/text.h"

namespace plc::il {

using core::Code;
using st::kNoNode;
using st::Node;
using st::NodeId;
using st::NodeKind;
using st::Token;
using st::TokenKind;

namespace {

std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

bool begins_operand(TokenKind kind) {
  switch (kind) {
    case TokenKind::kIdentifier:
    case TokenKind::kInteger:
    case TokenKind::kReal:
    case TokenKind::kTyped:
    case TokenKind::kEnumValue:
    case TokenKind::kString:
    case TokenKind::kWstring:
    case TokenKind::kDirect:
    case TokenKind::kMinus:
    case TokenKind::kPlus:
      return true;
    default:
      return false;
  }
}

}  // namespace

const Token& Parser::peek() {
  if (!has_peeked_) peeked_ = lexer_.next();
  has_peeked_ = true;
  return peeked_;
}

bool Parser::on_new_line() const { return source_.slice(last_end_, token_.begin).find('\n') != std::string_view::npos; }

bool Parser::at_operand() const { return begins_operand(token_.kind); }

bool Parser::at_label() { return token_.kind == TokenKind::kIdentifier && peek().kind == TokenKind::kColon; }

/// Where an operand is due: whether the next instruction is here instead. Names of operators are names of variables,
/// too, so that a line end must tell.
bool Parser::operand_missing() {
  if (!at_operand()) return true;
  if (token_.kind != TokenKind::kIdentifier) return false;
  if (at_label()) return true;
  return on_new_line() && operator_named(text_of(token_)) &&
         (begins_operand(peek().kind) || peek().kind == TokenKind::kLeftParen);
}

/// At a word and "(": whether a call with named arguments follows, as in ADD(IN1 := a, IN2 := b).
bool Parser::at_formal_call() {
  if (peek().kind != TokenKind::kLeftParen) return false;
  st::Lexer ahead = lexer_;
  Token token = ahead.next();
  if (token.kind == TokenKind::kIdentifier && core::iequals(text_of(token), "NOT")) token = ahead.next();
  if (token.kind != TokenKind::kIdentifier) return false;
  const TokenKind next = ahead.next().kind;
  return next == TokenKind::kAssign || next == TokenKind::kOutput;
}

/// After "(": whether a load follows, and not a variable that is called LD.
bool Parser::at_bracketed_load() {
  const auto spelled = token_.kind == TokenKind::kIdentifier ? operator_named(text_of(token_)) : std::nullopt;
  return spelled && spelled->row->kind == Kind::kLoad && begins_operand(peek().kind);
}

Listing Parser::parse() {
  while (token_.kind != TokenKind::kEnd) {
    if (accept(TokenKind::kSemicolon)) continue;
    in_error_ = false;
    const std::uint32_t depth = depth_;
    const std::size_t before = listing_.instructions.size();
    const std::uint32_t begin = token_.begin;
    at_label() ? label() : instruction();
    depth_ = depth;
    if (!in_error_) continue;
    listing_.instructions.resize(before);
    Instruction broken;
    broken.begin = begin;
    broken.end = begin;
    listing_.instructions.push_back(broken);
    skip_instruction();
  }
  for (const Token& one : open_) {
    in_error_ = false;
    fail(Code::P4504, one, "the bracket of " + quoted(text_of(one)) + " is not closed",
         "write ) where its value is due");
  }
  refuse_pragmas();
  listing_.failed = failed_;
  listing_.ast = std::move(ast_);
  return std::move(listing_);
}

// After an error: to what begins a line, or to what follows a semicolon.
void Parser::skip_instruction() {
  while (token_.kind != TokenKind::kEnd && !on_new_line()) {
    if (accept(TokenKind::kSemicolon)) return;
    advance();
  }
}

bool Parser::refuse_in_bracket(std::string_view what, const Token& token) {
  if (open_.empty()) return false;
  fail(Code::P4504, token, std::string(what) + " is inside of the bracket of " + quoted(text_of(open_.back())),
       "what is in brackets is computed from its beginning to its end: jump before it or after it");
  return true;
}

void Parser::label() {
  if (!open_.empty()) {
    refuse_in_bracket("label " + quoted(text_of(token_)), token_);
    in_error_ = false;  // nothing is missing without it
  }
  listing_.labels.push_back({token_.begin, token_.end, static_cast<std::uint32_t>(listing_.instructions.size())});
  advance();
  advance();
}

void Parser::close() {
  Instruction out;
  out.kind = Kind::kClose;
  out.begin = token_.begin;
  out.end = token_.end;
  if (open_.empty()) {
    fail(Code::P4504, token_, "\")\" without a bracket", "an operator opens a bracket: AND( .. )");
    advance();
    return;
  }
  open_.pop_back();
  advance();
  listing_.instructions.push_back(out);
}

void Parser::instruction() {
  if (token_.kind == TokenKind::kRightParen) return close();
  const Token word = token_;
  if (token_.kind == TokenKind::kAnd) {
    Spelled spelled = *operator_named("&");
    Token whole = word;
    advance();
    // &N is ANDN; a variable N has a blank before it.
    if (core::iequals(text_of(token_), "N") && token_.begin == word.end &&
        (begins_operand(peek().kind) || peek().kind == TokenKind::kLeftParen)) {
      spelled.negated = true;
      whole.end = token_.end;
      advance();
    }
    return operation(spelled, whole);
  }
  if (token_.kind != TokenKind::kIdentifier) {
    fail(Code::P4502, token_, "found " + st::shown_token(text_of(token_)) + " where an operator is expected",
         st::stray_character(text_of(token_)) != 0 ? st::kStrayHelp : "an instruction is an operator and its operand");
    advance();
    return;
  }
  const auto spelled = operator_named(text_of(token_));
  const bool named =
      spelled && (at_formal_call() || (spelled->row->kind == Kind::kInput && peek().kind == TokenKind::kLeftParen));
  if (spelled && !named) {
    advance();
    return operation(*spelled, word);
  }
  function();
}

void Parser::operation(const Spelled& spelled, const Token& word) {
  const OperatorRow& row = *spelled.row;
  Instruction out;
  out.kind = row.kind;
  out.op = row.op;
  out.negated = spelled.negated;
  out.condition = spelled.condition;
  out.begin = word.begin;
  out.end = word.end;
  const std::string_view written = text_of(word);
  if (token_.kind == TokenKind::kLeftParen) {
    if (row.takes(kBracket)) return bracket(out, word);
    fail(Code::P4504, token_, "a bracket after " + quoted(written),
         "brackets follow AND, OR, XOR, arithmetic and comparisons");
    return;
  }
  switch (row.kind) {
    case Kind::kJump:
      if (refuse_in_bracket(quoted(written), word)) return;
      jump(out);
      break;
    case Kind::kCall:
      call(out);
      break;
    case Kind::kReturn:
      if (refuse_in_bracket(quoted(written), word)) return;
      break;
    case Kind::kNot:
      if (at_operand() && !on_new_line() && !at_label() && !operator_named(text_of(token_))) {
        fail(Code::P4503, token_, "NOT negates the accumulator and takes no operand",
             "the modifier N negates an operand: LDN, ANDN, ORN, XORN, STN");
      }
      break;
    default:
      operands(out, written, row.takes(kList));
      break;
  }
  if (!in_error_) listing_.instructions.push_back(out);
}

// "AND( x" loads x; "AND(" alone goes on with an LD or a call.
void Parser::bracket(Instruction& out, const Token& word) {
  out.opens = true;
  advance();
  if (token_.kind == TokenKind::kRightParen) {
    fail(Code::P4503, token_, "the bracket of " + quoted(text_of(word)) + " is empty",
         "write an operand or LD after (");
    advance();
    return;
  }
  if (!at_bracketed_load()) {
    out.operand = operand(text_of(word));
    if (out.operand == kNoNode) return;
    if (token_.kind == TokenKind::kComma) {
      fail(Code::P4503, token_, "a second operand in the bracket of " + quoted(text_of(word)),
           "name the arguments of a call: " + core::uppered(text_of(word)) + "(IN1 := a, IN2 := b)");
      return;
    }
  }
  open_.push_back(word);
  listing_.instructions.push_back(out);
}

NodeId Parser::name_node(const Token& token) {
  Node node;
  node.kind = NodeKind::kName;
  node.begin = node.name = token.begin;
  node.end = node.name_end = token.end;
  return ast_.add(node);
}

NodeId Parser::operand(std::string_view word) {
  if (operand_missing()) {
    const bool bracket = token_.kind == TokenKind::kLeftParen;
    Token at = token_;
    if (!bracket) {
      at.begin = static_cast<std::uint32_t>(word.data() - source_.text().data());
      at.end = at.begin + static_cast<std::uint32_t>(word.size());
    }
    return fail(Code::P4503, at,
                bracket ? "found \"(\" where the operand of " + quoted(word) + " is expected"
                        : "the operand of " + quoted(word) + " is missing");
  }
  return unary();
}

bool Parser::operands(Instruction& out, std::string_view word, bool several) {
  out.operand = operand(word);
  if (out.operand == kNoNode) return false;
  for (NodeId last = out.operand; token_.kind == TokenKind::kComma;) {
    if (!several) {
      fail(Code::P4503, token_, quoted(word) + " takes one operand");
      return false;
    }
    advance();
    const NodeId next = operand(word);
    if (next == kNoNode) return false;
    ast_.nodes[last].next = next;
    last = next;
  }
  return true;
}

void Parser::jump(Instruction& out) {
  if (token_.kind != TokenKind::kIdentifier || at_label()) {
    fail(Code::P4503, token_, "the label after " + quoted(source_.slice(out.begin, out.end)) + " is missing");
    return;
  }
  out.operand = name_node(token_);
  advance();
}

void Parser::call(Instruction& out) {
  const std::string_view word = source_.slice(out.begin, out.end);
  if (token_.kind != TokenKind::kIdentifier || operand_missing()) {
    fail(Code::P4503, token_, "the instance that " + quoted(word) + " calls is missing");
    return;
  }
  NodeId target = primary();
  if (target == kNoNode) return;
  if (ast_[target].kind != NodeKind::kCall) {
    Node node;
    node.kind = NodeKind::kCall;
    node.begin = ast_[target].begin;
    node.end = ast_[target].end;
    node.a = target;
    target = ast_.add(node);
  }
  out.operand = target;
}

// "LIMIT 1, 5": the accumulator is the first argument. "LIMIT(MN := 1, ..)": the arguments are in parentheses.
void Parser::function() {
  const Token word = token_;
  Instruction out;
  out.kind = Kind::kFunction;
  out.begin = word.begin;
  out.end = word.end;
  if (peek().kind == TokenKind::kLeftParen) {
    const NodeId callee = name_node(word);
    advance();
    out.operand = arguments(callee);
    out.formal = true;
    if (!in_error_) listing_.instructions.push_back(out);
    return;
  }
  if (keyword_ != st::Keyword::kNone || peek().kind == TokenKind::kDot || peek().kind == TokenKind::kAssign) {
    fail(Code::P4502, token_, quoted(text_of(token_)) + " is no operator of instruction lists",
         peek().kind == TokenKind::kAssign ? "write LD with the value, and ST with the variable"
                                           : operator_meant(text_of(token_)));
    advance();
    return;
  }
  advance();
  const auto spelled = token_.kind == TokenKind::kIdentifier ? operator_named(text_of(token_)) : std::nullopt;
  // Words as IN and PT are operands here; those of loads, stores and so on begin the next instruction.
  const bool next = on_new_line() || at_label() ||
                    (spelled && spelled->row->kind != Kind::kInput && peek().kind != TokenKind::kComma);
  if (at_operand() && !next) operands(out, text_of(word), true);
  if (!in_error_) listing_.instructions.push_back(out);
}

}  // namespace plc::il
