// Parser of instruction lists (IEC 61131-3:2013, 7.2). Tokens decide, not lines: some tools join the lines of a body
// when they write it. A line end tells only where an operand is missing, and where to go on after an error. Operands
// are read by the parser of ST.
//
// In: a SourceText. Out: a Listing. Each instruction with an error is reported once and becomes kBroken. Does not
// belong here: names, types, where labels are.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "frontend-il/listing.h"
#include "frontend-st/parser.h"

namespace plc::il {

class Parser : private st::Parser {
 public:
  Parser(const st::SourceText& source, core::Diagnostics& diagnostics, std::string_view pou)
      : st::Parser(source, diagnostics, pou) {}

  Listing parse();

 private:
  const st::Token& peek();
  [[nodiscard]] bool on_new_line() const;
  [[nodiscard]] bool at_operand() const;
  bool operand_missing();
  bool at_label();
  bool at_formal_call();
  [[nodiscard]] bool at_bracketed_load();

  void label();
  void instruction();
  void close();
  void operation(const Spelled& spelled, const st::Token& word);
  void bracket(Instruction& out, const st::Token& word);
  void jump(Instruction& out);
  void call(Instruction& out);
  void function();
  st::NodeId operand(std::string_view word);
  bool operands(Instruction& out, std::string_view word, bool several);
  st::NodeId name_node(const st::Token& token);
  bool refuse_in_bracket(std::string_view what, const st::Token& token);
  void skip_instruction();

  Listing listing_;
  std::vector<st::Token> open_;  ///< operators whose brackets are open
};

}  // namespace plc::il
