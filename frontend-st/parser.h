// Parser of ST texts: expressions by operator precedence (IEC 61131-3:2013, table 71), and the statements an EXECUTE
// box holds. Syntax only: nothing is looked up.
//
// In: a SourceText. Out: an Ast. Errors are reported once per expression, or once per statement, and parsing goes on
// behind the statement. Does not belong here: names, types, IR.
#pragma once

#include <string>
#include <string_view>

#include "core/diagnostics.h"
#include "frontend-st/ast.h"
#include "frontend-st/lexer.h"
#include "frontend-st/source_text.h"

namespace plc::st {

class Parser {
 public:
  Parser(const SourceText& source, core::Diagnostics& diagnostics, std::string_view pou);

  /// The whole text as one expression; kNoNode when it is none.
  NodeId parse_expression();
  /// The whole text as statements; the first one, linked by next. Statements with syntax errors are left out.
  NodeId parse_statements();
  [[nodiscard]] const Ast& ast() const { return ast_; }
  [[nodiscard]] bool failed() const { return failed_; }

 private:
  void advance();
  [[nodiscard]] std::string_view text_of(const Token& token) const { return source_.slice(token.begin, token.end); }
  [[nodiscard]] bool at_keyword(std::string_view keyword) const;
  bool accept(TokenKind kind);
  /// Reports unless an error of the same statement was reported already; always returns kNoNode.
  NodeId fail(core::Code code, const Token& token, std::string message, std::string help = {});
  NodeId fail_unexpected(std::string_view wanted);
  bool enter();
  void leave() { --depth_; }

  NodeId expression(int min_power);
  NodeId unary();
  NodeId primary();
  NodeId postfix(NodeId base);
  NodeId indices(NodeId base);
  NodeId arguments(NodeId callee);
  NodeId argument();

  NodeId statement_list();
  NodeId statement();
  NodeId if_statement();
  [[nodiscard]] bool at_list_end() const;
  void skip_statement();
  NodeId refuse_compound(std::string_view keyword, std::string_view end_keyword);

  const SourceText& source_;
  core::Diagnostics& diagnostics_;
  std::string_view pou_;
  Lexer lexer_;
  Ast ast_;
  Token token_;   ///< the current token
  Token peeked_;  ///< the one behind it, if has_peeked_
  bool has_peeked_ = false;
  std::uint32_t last_end_ = 0;  ///< end of the token before the current one
  std::uint32_t depth_ = 0;
  bool in_error_ = false;  ///< an error of the current statement was reported
  bool failed_ = false;
};

}  // namespace plc::st
