// Parser of ST texts: expressions by operator precedence (IEC 61131-3:2013, table 71) and statements (table 72). Syntax
// only: nothing is looked up. Expressions are in parser.cpp, statements in parser_statements.cpp, what other tools
// know in parser_foreign.cpp. Instruction lists have the same operands: their parser is derived from this one.
//
// In: a SourceText. Out: an Ast. Errors are reported once per expression, or once per statement, and parsing continues
// after the statement. Does not belong here: names, types, IR, declarations.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/diagnostics.h"
#include "frontend-st/ast.h"
#include "frontend-st/keywords.h"
#include "frontend-st/lexer.h"
#include "frontend-st/source_text.h"

namespace plc::st {

class Parser {
 public:
  Parser(const SourceText& source, core::Diagnostics& diagnostics, std::string_view pou);

  /// The whole text as one expression; kNoNode when it is none.
  NodeId parse_expression();
  /// The next statement of the text, kNoNode after the last one. The nodes of those before are gone: a text may be
  /// long. Statements with syntax errors are left out; compound ones whose head has one keep their statements, and
  /// kNoNode stands for what could not be read of the head.
  NodeId next_statement();
  [[nodiscard]] const Ast& ast() const { return ast_; }
  [[nodiscard]] bool failed() const { return failed_; }

 protected:
  void refuse_pragmas();
  void advance();
  [[nodiscard]] std::string_view text_of(const Token& token) const { return source_.slice(token.begin, token.end); }
  [[nodiscard]] bool at_keyword(Keyword keyword) const { return keyword_ == keyword; }
  bool accept(TokenKind kind);
  /// Reports unless an error of the same statement was reported already; always returns kNoNode.
  NodeId fail(core::Code code, const Token& token, std::string message, std::string help = {});
  NodeId fail_unexpected(std::string_view wanted);
  bool enter();
  void leave() { --depth_; }

  /// A value without infix operators.
  NodeId unary();
  NodeId primary();
  /// A call of `callee`; the current token is "(".
  NodeId arguments(NodeId callee);

  const SourceText& source_;
  core::Diagnostics& diagnostics_;
  std::string_view pou_;
  std::vector<Token> pragmas_;  ///< passed over
  Lexer lexer_;
  Ast ast_;
  Token token_;                       ///< the current token
  Keyword keyword_ = Keyword::kNone;  ///< what the current token spells
  Token peeked_;                      ///< the one after it, if has_peeked_
  bool has_peeked_ = false;
  std::uint32_t last_end_ = 0;  ///< end of the token before the current one
  std::uint32_t depth_ = 0;
  bool in_error_ = false;  ///< an error of the current statement was reported
  bool failed_ = false;

 private:
  NodeId expression(int min_power);
  [[nodiscard]] bool at_operator_name();
  [[nodiscard]] bool at_global_name();
  void warn_of_blank();
  NodeId postfix(NodeId base);
  NodeId indices(NodeId base);
  bool binds_next();
  NodeId argument();

  NodeId statement_list();
  NodeId listed_statement();
  NodeId statement();
  NodeId assignment_or_call();
  /// Reports a statement or operator that other tools have, if one is here; after `target` where it has a left
  /// side.
  bool refuse_foreign_statement();
  bool refuse_foreign_operator(NodeId target);
  /// The operator of an assignment that is here, passed over: ":=", "S=" or "R=".
  std::optional<Operator> assignment_operator();
  NodeId if_statement();
  NodeId case_statement();
  NodeId for_statement();
  NodeId while_statement();
  NodeId repeat_statement();
  NodeId word_statement(NodeKind kind);
  /// The expression of a statement's head and the keyword that ends it. After an error reading continues past that
  /// keyword, and the statement is kept without it: a head that cannot be read does not hide errors of the statements
  /// inside.
  NodeId head_expression(Keyword terminator, std::string_view word);
  NodeId case_label();
  [[nodiscard]] bool at_case_label();
  [[nodiscard]] bool at_whole_label();
  void correct_spelling();
  /// Whether the text has fewer `end` than `opener`.
  [[nodiscard]] bool lacks(Keyword end, Keyword opener) const;
  [[nodiscard]] bool leads_to_then() const;
  [[nodiscard]] bool at_result();
  [[nodiscard]] bool at_list_end();
  bool end_compound(Keyword end, std::string_view word, const Token& begin, std::string_view what,
                    std::string_view help = {});
  void skip_statement();

  std::uint32_t open_branches_ = 0;  ///< CASE branches around the current token
  bool in_case_ = false;             ///< statements of a CASE branch: a label ends them
};

}  // namespace plc::st
