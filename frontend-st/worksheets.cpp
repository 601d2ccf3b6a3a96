#include "frontend-st/worksheets.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include "frontend-st/lexer.h"

namespace plc::st {

using plcopen::Body;
using plcopen::Language;

namespace {

/// Pragmas may choose statements, or be code that is refused.
bool is_comment(std::string_view text) {
  std::vector<Token> pragmas;
  return Lexer(text, &pragmas).next().kind == TokenKind::kEnd && pragmas.empty();
}

Language family_of(Language language) { return language == Language::kFbd ? Language::kLd : language; }

}  // namespace

bool is_empty_body(const Body& body) {
  if (body.language == Language::kNone) return true;
  const bool text = body.language == Language::kSt || body.language == Language::kIl;
  return body.drawn_elements == 0 && body.elements.empty() && (body.text.empty() || (text && is_comment(body.text)));
}

Language language_of(const plcopen::Pou& pou) {
  Language empty = Language::kNone;
  for (const Body& body : pou.bodies) {
    if (!is_empty_body(body)) return body.language;
    if (empty == Language::kNone) empty = body.language;
  }
  return empty;
}

bool is_mixed(const plcopen::Pou& pou) {
  const Language first = family_of(language_of(pou));
  return std::any_of(pou.bodies.begin(), pou.bodies.end(),
                     [&](const Body& body) { return !is_empty_body(body) && family_of(body.language) != first; });
}

}  // namespace plc::st
