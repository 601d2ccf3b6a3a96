#include "frontend-st/parser.h"

#include <utility>

#include "core/text.h"
#include "frontend-st/suggestions.h"

namespace plc::st {
namespace {

using core::Code;

struct Infix {
  Operator op = Operator::kNone;
  int power = 0;  ///< binding power, 0 = no infix operator
};

// Equal powers associate to the left (IEC 61131-3:2013, 7.3.2).
constexpr int kUnaryPower = 9;

Infix infix_of(const Token& token, Keyword keyword) {
  switch (token.kind) {
    case TokenKind::kPower:
      return {Operator::kPower, 8};
    case TokenKind::kStar:
      return {Operator::kMultiply, 7};
    case TokenKind::kSlash:
      return {Operator::kDivide, 7};
    case TokenKind::kPlus:
      return {Operator::kAdd, 6};
    case TokenKind::kMinus:
      return {Operator::kSubtract, 6};
    case TokenKind::kLess:
      return {Operator::kLess, 5};
    case TokenKind::kLessEqual:
      return {Operator::kLessEqual, 5};
    case TokenKind::kGreater:
      return {Operator::kGreater, 5};
    case TokenKind::kGreaterEqual:
      return {Operator::kGreaterEqual, 5};
    case TokenKind::kEqual:
      return {Operator::kEqual, 4};
    case TokenKind::kNotEqual:
      return {Operator::kNotEqual, 4};
    case TokenKind::kAnd:
      return {Operator::kAnd, 3};
    default:
      break;
  }
  switch (keyword) {
    case Keyword::kMod:
      return {Operator::kModulo, 7};
    case Keyword::kAnd:
      return {Operator::kAnd, 3};
    case Keyword::kAndThen:
      return {Operator::kAndThen, 3};
    case Keyword::kXor:
      return {Operator::kXor, 2};
    case Keyword::kOr:
      return {Operator::kOr, 1};
    case Keyword::kOrElse:
      return {Operator::kOrElse, 1};
    default:
      return {};
  }
}

}  // namespace

Parser::Parser(const SourceText& source, core::Diagnostics& diagnostics, std::string_view pou)
    : source_(source), diagnostics_(diagnostics), pou_(pou), lexer_(source.text(), &pragmas_) {
  advance();
}

void Parser::advance() {
  last_end_ = token_.end;
  if (has_peeked_) {
    token_ = peeked_;
    has_peeked_ = false;
  } else {
    token_ = lexer_.next();
  }
  keyword_ = token_.kind == TokenKind::kIdentifier ? keyword_of(text_of(token_)) : Keyword::kNone;
}

bool Parser::accept(TokenKind kind) {
  if (token_.kind != kind) return false;
  advance();
  return true;
}

NodeId Parser::fail(Code code, const Token& token, std::string message, std::string help) {
  if (!in_error_) {
    diagnostics_.report(code, source_.locate(token.begin), pou_, std::move(message), std::move(help));
  }
  in_error_ = true;
  failed_ = true;
  return kNoNode;
}

NodeId Parser::fail_unexpected(std::string_view wanted) {
  const std::string found(text_of(token_));
  switch (token_.kind) {
    case TokenKind::kEnd:
      return fail(Code::P4001, token_, "the text ends where " + std::string(wanted) + " should follow");
    case TokenKind::kUnterminatedString:
      return fail(Code::P4003, token_, "string without end",
                  "close it with the quote that opened it; a quote inside is $' or $\"");
    case TokenKind::kUnterminatedComment:
      return fail(Code::P4001, token_, "comment or pragma without end");
    case TokenKind::kBadNumber:
      return fail(Code::P4003, token_, "\"" + found + "\" is neither a number nor a name",
                  "names begin with a letter; durations are written T#5s");
    default:
      break;
  }
  return fail(Code::P4001, token_, "found " + shown_token(found) + " where " + std::string(wanted) + " is expected",
              stray_character(found) != 0 ? kStrayHelp : operator_meant(source_.text(), token_.begin));
}

bool Parser::enter() {
  if (++depth_ <= kMaxDepth) return true;
  fail(Code::P4002, token_, "nested more than " + std::to_string(kMaxDepth) + " levels deep",
       "split it with variables for the parts");
  return false;
}

// ---- expressions ----------------------------------------------------------------------------------------------

NodeId Parser::parse_expression() {
  if (token_.kind == TokenKind::kEnd)
    return fail(Code::P4001, token_, "the text is empty where an expression is expected");
  const NodeId root = expression(1);
  if (root == kNoNode) return root;
  if (token_.kind != TokenKind::kEnd) return fail_unexpected("an operator or the end of the expression");
  return root;
}

NodeId Parser::expression(int min_power) {
  NodeId left = unary();
  while (left != kNoNode) {
    const Infix infix = infix_of(token_, keyword_);
    if (infix.power < min_power || infix.power == 0) return left;
    advance();
    const NodeId right = expression(infix.power + 1);
    if (right == kNoNode) return kNoNode;
    Node node;
    node.kind = NodeKind::kBinary;
    node.op = infix.op;
    node.begin = ast_[left].begin;
    node.end = ast_[right].end;
    node.a = left;
    node.b = right;
    left = ast_.add(node);
  }
  return left;
}

NodeId Parser::unary() {
  Operator op = Operator::kNone;
  if (token_.kind == TokenKind::kMinus) op = Operator::kNegate;
  if (token_.kind == TokenKind::kPlus) op = Operator::kPlus;
  if (at_keyword(Keyword::kNot)) op = Operator::kNot;
  if (op == Operator::kNone) return primary();
  const std::uint32_t begin = token_.begin;
  if (!enter()) return kNoNode;
  advance();
  const NodeId operand = expression(kUnaryPower);
  leave();
  if (operand == kNoNode) return kNoNode;
  Node node;
  node.kind = NodeKind::kUnary;
  node.op = op;
  node.begin = begin;
  node.end = ast_[operand].end;
  node.a = operand;
  return ast_.add(node);
}

// AND(a, b): where a value is expected, an operator before a parenthesis is the function of this name.
bool Parser::at_operator_name() {
  if (keyword_ != Keyword::kAnd && keyword_ != Keyword::kOr && keyword_ != Keyword::kXor && keyword_ != Keyword::kMod) {
    return false;
  }
  if (!has_peeked_) peeked_ = lexer_.next();
  has_peeked_ = true;
  return peeked_.kind == TokenKind::kLeftParen;
}

// ".x": the global variable x, whatever the POU calls so (CODESYS, TwinCAT).
bool Parser::at_global_name() {
  if (token_.kind != TokenKind::kDot) return false;
  if (!has_peeked_) peeked_ = lexer_.next();
  has_peeked_ = true;
  return peeked_.kind == TokenKind::kIdentifier && peeked_.begin == token_.end;
}

NodeId Parser::primary() {
  Node node;
  node.begin = node.name = token_.begin;
  node.end = node.name_end = token_.end;
  switch (token_.kind) {
    case TokenKind::kInteger:
    case TokenKind::kReal:
    case TokenKind::kTyped:
    case TokenKind::kString:
    case TokenKind::kWstring:
      node.kind = NodeKind::kLiteral;
      if (has_blank_inside(token_, text_of(token_))) warn_of_blank();
      break;
    case TokenKind::kEnumValue:
      node.kind = NodeKind::kEnumValue;
      break;
    case TokenKind::kDirect:
      node.kind = NodeKind::kDirect;
      break;
    case TokenKind::kIdentifier:
      node.kind = at_keyword(Keyword::kTrue) || at_keyword(Keyword::kFalse) ? NodeKind::kLiteral : NodeKind::kName;
      if (node.kind == NodeKind::kName && keyword_ != Keyword::kNone && !at_operator_name()) {
        return fail_unexpected("a value");
      }
      break;
    case TokenKind::kDot:
      if (!at_global_name()) {
        if (peeked_.kind != TokenKind::kInteger || peeked_.begin != token_.end) return fail_unexpected("a value");
        return fail(Code::P4001, token_, "found \".\" where a value is expected",
                    "a number has a digit before its point: 0." + std::string(text_of(peeked_)));
      }
      advance();
      node.kind = NodeKind::kName;  // with the dot, which find_name() knows
      node.end = node.name_end = token_.end;
      break;
    case TokenKind::kLeftParen: {
      const std::uint32_t begin = token_.begin;
      if (!enter()) return kNoNode;
      advance();
      const NodeId inner = expression(1);
      leave();
      if (inner == kNoNode) return kNoNode;
      if (token_.kind != TokenKind::kRightParen) return fail_unexpected("an operator or \")\"");
      advance();
      ast_.nodes[inner].begin = begin;
      ast_.nodes[inner].end = last_end_;
      return postfix(inner);
    }
    default:
      return fail_unexpected("a value");
  }
  advance();
  return postfix(ast_.add(node));
}

void Parser::warn_of_blank() {
  std::string plain;
  for (const char c : text_of(token_)) {
    if (c != ' ' && c != '\t') plain += c;
  }
  diagnostics_.report(Code::P4065, source_.locate(token_.begin), pou_,
                      "blank inside the literal \"" + std::string(text_of(token_)) + '"', "write " + plain);
}

NodeId Parser::postfix(NodeId base) {
  while (base != kNoNode) {
    switch (token_.kind) {
      case TokenKind::kDot: {
        advance();
        Node node;
        node.kind = NodeKind::kMember;
        if (token_.kind == TokenKind::kInteger || token_.kind == TokenKind::kDirect) {
          node.kind = NodeKind::kBit;
        } else if (token_.kind != TokenKind::kIdentifier) {
          return fail_unexpected("the name of a member");
        }
        node.begin = ast_[base].begin;
        node.end = token_.end;
        node.name = token_.begin;
        node.name_end = token_.end;
        node.a = base;
        advance();
        base = ast_.add(node);
        break;
      }
      case TokenKind::kLeftBracket:
        base = indices(base);
        break;
      case TokenKind::kLeftParen:
        base = arguments(base);
        break;
      case TokenKind::kCaret: {
        advance();
        Node node;
        node.kind = NodeKind::kDeref;
        node.begin = ast_[base].begin;
        node.end = last_end_;
        node.a = base;
        base = ast_.add(node);
        break;
      }
      default:
        return base;
    }
  }
  return base;
}

NodeId Parser::indices(NodeId base) {
  if (!enter()) return kNoNode;
  Node node;
  node.kind = NodeKind::kIndex;
  node.begin = ast_[base].begin;
  node.a = base;
  NodeId last = kNoNode;
  do {
    advance();
    const NodeId index = expression(1);
    if (index == kNoNode) return kNoNode;
    (last == kNoNode ? node.b : ast_.nodes[last].next) = index;
    last = index;
  } while (token_.kind == TokenKind::kComma);
  leave();
  if (token_.kind != TokenKind::kRightBracket) return fail_unexpected("\",\" or \"]\"");
  advance();
  node.end = last_end_;
  return ast_.add(node);
}

NodeId Parser::arguments(NodeId callee) {
  if (!enter()) return kNoNode;
  Node node;
  node.kind = NodeKind::kCall;
  node.begin = ast_[callee].begin;
  node.a = callee;
  NodeId last = kNoNode;
  advance();
  if (token_.kind != TokenKind::kRightParen) {
    for (;;) {
      const NodeId one = argument();
      if (one == kNoNode) return kNoNode;
      (last == kNoNode ? node.b : ast_.nodes[last].next) = one;
      last = one;
      if (!accept(TokenKind::kComma)) break;
    }
  }
  leave();
  if (token_.kind != TokenKind::kRightParen) return fail_unexpected("\",\" or \")\"");
  advance();
  node.end = last_end_;
  return ast_.add(node);
}

// Whether REF= is next, whose REF is known already.
bool Parser::binds_next() {
  if (peeked_.kind != TokenKind::kIdentifier || !core::iequals(text_of(peeked_), "REF")) return false;
  Lexer ahead = lexer_;
  const Token equal = ahead.next();
  return equal.kind == TokenKind::kEqual && equal.begin == peeked_.end;
}

NodeId Parser::argument() {
  Node node;
  node.kind = NodeKind::kArgument;
  node.begin = token_.begin;
  bool negated = false;
  if (token_.kind == TokenKind::kIdentifier) {
    if (at_keyword(Keyword::kNot)) {
      // "NOT Q => x" negates an output; anything else after NOT is an expression. Two tokens decide.
      Lexer ahead = lexer_;
      negated = ahead.next().kind == TokenKind::kIdentifier && ahead.next().kind == TokenKind::kOutput;
      if (negated) advance();
    }
    peeked_ = lexer_.next();
    has_peeked_ = true;
    if (binds_next()) {
      // "r REF= x"
      node.argument = ArgumentKind::kInput;
      node.op = Operator::kBind;
      node.name = token_.begin;
      node.name_end = token_.end;
      for (int token = 0; token < 3; ++token) advance();
    } else if (peeked_.kind == TokenKind::kAssign || peeked_.kind == TokenKind::kOutput) {
      node.argument = peeked_.kind == TokenKind::kAssign ? ArgumentKind::kInput
                      : negated                          ? ArgumentKind::kNegatedOutput
                                                         : ArgumentKind::kOutput;
      node.name = token_.begin;
      node.name_end = token_.end;
      advance();
      advance();
      // "Q =>" and "IN :=" with nothing after them are unconnected (matiec and CODESYS write them).
      if (token_.kind == TokenKind::kComma || token_.kind == TokenKind::kRightParen) {
        node.end = last_end_;
        return ast_.add(node);
      }
    }
  }
  node.a = expression(1);
  if (node.a == kNoNode) return kNoNode;
  node.end = ast_[node.a].end;
  return ast_.add(node);
}

}  // namespace plc::st
