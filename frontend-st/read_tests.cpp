// Tests: TEST 'what it shows' .. END_TEST, at the level of POUs. A test has sections of variables and a body like a
// function block, and a text for a name.
#include <utility>

#include "frontend-st/declaration_reader.h"

namespace plc::st {

using core::Code;

namespace {
constexpr std::size_t kMaxTestName = 200;
}

bool DeclarationReader::opens_test() { return word_of(token_) == Word::kTest && peek(1).kind == TokenKind::kString; }

void DeclarationReader::test() {
  const Token opener = token_;
  plcopen::Pou out;
  out.kind = plcopen::PouKind::kFunctionBlock;
  out.test = true;
  out.at = place(opener.begin);
  advance();
  const std::string_view quoted = text_of(token_);
  out.name = quoted.substr(1, quoted.size() - 2);
  const bool named = !out.name.empty() && out.name.size() <= kMaxTestName;
  if (out.name.empty()) {
    fail(Code::P4040, token_, "test has no name", "write what it shows: TEST 'the pump stops when the tank is full'");
  } else if (!named) {
    fail(Code::P4044, token_, "name of a test is longer than " + std::to_string(kMaxTestName) + " bytes");
  }
  pou_ = "TEST " + std::string(quoted);
  advance();
  accept(TokenKind::kSemicolon);
  while (is_section(word_of(token_))) section(Owner::kTest, out.variables);
  body(out, opener, Word::kTest);
  count("TEST", plcopen::Fate::kPreserved, place(opener.begin), "plc test runs it");
  pou_.clear();
  if (named) project_.tests.push_back(std::move(out));
}

}  // namespace plc::st
