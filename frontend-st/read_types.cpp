// Data types and initial values.
#include <utility>

#include "core/text.h"
#include "core/types.h"
#include "frontend-st/declaration_reader.h"

namespace plc::st {

using core::Code;
using core::ElementKind;
using plcopen::Fate;
using plcopen::InitialValue;
using plcopen::TypeSpec;

void DeclarationReader::type_block() {
  const Token opener = token_;
  const bool qualified = attribute_here("qualified_only").has_value();
  advance();
  while (!at(TokenKind::kEnd)) {
    const Word word = word_of(token_);
    if (word == Word::kEndType) {
      advance();
      accept(TokenKind::kSemicolon);
      return;
    }
    if (accept(TokenKind::kSemicolon)) continue;
    if (word == Word::kEndStruct || word == Word::kEndUnion) {  // left over from a declaration that failed
      advance();
      continue;
    }
    if (is_reserved(word) || (word != Word::kNone && peek(1).kind != TokenKind::kColon)) break;
    const std::uint32_t begin = token_.begin;
    std::vector<std::string> names = names_of(token_, token_);
    if (!type_declaration(qualified)) recover(begin);
    note_extent(std::move(names), begin);
  }
  fail_unclosed("TYPE", opener, "END_TYPE");
}

bool DeclarationReader::type_declaration(bool qualified) {
  plcopen::DataType type;
  type.qualified = qualified || attribute_here("qualified_only").has_value();
  const std::uint32_t at_name = token_.begin;
  if (!name(type.name, "the name of a data type")) return false;
  type.at = place(at_name, ElementKind::kType);
  const Token extends = token_;
  std::shared_ptr<TypeSpec> extended;
  if (at_text("EXTENDS")) {
    advance();
    extended = std::make_shared<TypeSpec>();
    if (!type_spec(*extended)) return false;
  }
  if (!require(TokenKind::kColon, "\":\"")) return false;
  const bool fine = type_spec(type.type) && (!accept(TokenKind::kAssign) || initial_value(type.initial));
  if (!fine) return false;
  if (extended != nullptr && !extend(type, extended, extends)) return false;
  count("data type", Fate::kUsed, type.at);
  // Tools omit the ";" after END_STRUCT.
  const bool structure = (type.type.kind == TypeSpec::Kind::kStruct || type.type.kind == TypeSpec::Kind::kUnion) &&
                         type.initial.kind == InitialValue::Kind::kNone;
  project_.data_types.push_back(std::move(type));
  if (structure && !at(TokenKind::kSemicolon)) return true;
  end_declaration();
  return true;
}

/// Structures of CODESYS and TwinCAT extend others; declare/extended_structures.h joins their members.
bool DeclarationReader::extend(plcopen::DataType& type, const std::shared_ptr<TypeSpec>& extended, const Token& at) {
  if (type.type.kind != TypeSpec::Kind::kStruct || extended->kind != TypeSpec::Kind::kNamed) {
    return fail(Code::P4017, at, "data type \"" + type.name + "\" EXTENDS another, and is no structure",
                "only a structure extends a structure");
  }
  fail(Code::P4358, at, "structure \"" + type.name + "\" EXTENDS \"" + extended->name + '"',
       "give it a member of type " + extended->name);
  type.type.base = extended;
  return true;
}

bool DeclarationReader::type_spec(TypeSpec& out) {
  out.at = place(token_.begin, ElementKind::kType);
  const bool fine = enter(token_) && type_spec_inner(out);
  leave();
  return fine;
}

bool DeclarationReader::type_spec_inner(TypeSpec& out) {
  const Word word = word_of(token_);
  if (word == Word::kStruct) return struct_spec(out);
  if (word == Word::kUnion) return struct_spec(out);
  if (at_text("ARRAY")) return array_spec(out);
  if (at(TokenKind::kLeftParen)) return enumeration(out);
  const bool two_words = (at_text("POINTER") || at_text("REFERENCE")) && is_text(peek(1), "TO");
  if (at_text("REF_TO") || two_words) {
    out.kind = !two_words           ? TypeSpec::Kind::kReference
               : at_text("POINTER") ? TypeSpec::Kind::kPointer
                                    : TypeSpec::Kind::kReferenceTo;
    advance();
    if (two_words) advance();
    out.base = std::make_shared<TypeSpec>();
    return type_spec(*out.base);
  }
  return named_spec(out);
}

bool DeclarationReader::array_spec(TypeSpec& out) {
  advance();
  out.kind = TypeSpec::Kind::kArray;
  if (!require(TokenKind::kLeftBracket, "\"[\"")) return false;
  do {
    if (accept(TokenKind::kStar)) {
      out.dimensions.push_back({"*", "*"});
      continue;
    }
    Piece lower = expression();
    if (lower.text.empty()) return fail_expected("the lower bound of an array");
    if (!require(TokenKind::kRange, "\"..\"")) return false;
    Piece upper = expression();
    if (upper.text.empty()) return fail_expected("the upper bound of an array");
    out.dimensions.push_back({std::move(lower.text), std::move(upper.text), lower.at, upper.at});
  } while (accept(TokenKind::kComma));
  if (!require(TokenKind::kRightBracket, "\"]\"")) return false;
  if (!accept_text("OF")) return fail_expected("OF");
  out.base = std::make_shared<TypeSpec>();
  return type_spec(*out.base);
}

bool DeclarationReader::struct_spec(TypeSpec& out) {
  const Token opener = token_;
  const bool united = word_of(token_) == Word::kUnion;
  advance();
  out.kind = united ? TypeSpec::Kind::kUnion : TypeSpec::Kind::kStruct;
  if (at_text("OVERLAP") && peek(1).kind == TokenKind::kIdentifier) {
    fail(Code::P4043, token_, "structures with OVERLAP are not supported", "use partial access as in w.%B0");
    advance();
  }
  while (!at(TokenKind::kEnd)) {
    const Word word = word_of(token_);
    if (word == (united ? Word::kEndUnion : Word::kEndStruct)) {
      advance();
      return true;
    }
    if (accept(TokenKind::kSemicolon)) continue;
    const TokenKind next = peek(1).kind;
    if (refuse_keyword(word)) continue;
    if (is_reserved(word) || (word != Word::kNone && next != TokenKind::kColon && next != TokenKind::kComma)) break;
    // A wrong member is one error; those after it are read.
    plcopen::Variable model;
    const std::uint32_t begin = token_.begin;
    if (!variables(model, out.members)) recover(begin);
  }
  return united ? fail_unclosed("UNION", opener, "END_UNION") : fail_unclosed("STRUCT", opener, "END_STRUCT");
}

/// At "<" after the name of a block: FB<10, (2 * n)>. The values become part of the name, without blanks.
bool DeclarationReader::generic_values(std::string& type_name) {
  type_name += '<';
  do {
    advance();
    std::string value;
    std::size_t open = 0;
    while (!at(TokenKind::kEnd) && !at(TokenKind::kSemicolon)) {
      if (open == 0 && (at(TokenKind::kComma) || at(TokenKind::kGreater))) break;
      if (at(TokenKind::kLeftParen)) ++open;
      if (at(TokenKind::kRightParen) && open-- == 0) break;
      if (!value.empty() && is_identifier_char(value.back()) && is_identifier_char(text_of(token_)[0])) value += ' ';
      value += text_of(token_);
      advance();
    }
    if (value.empty()) return fail_expected("the value of a generic constant");
    if (type_name.back() != '<') type_name += ',';
    type_name += value;
  } while (at(TokenKind::kComma));
  type_name += '>';
  return require(TokenKind::kGreater, "\">\"");
}

bool DeclarationReader::named_spec(TypeSpec& out) {
  std::string type_name;
  const Token first = token_;
  if (!name(type_name, "a type")) return false;
  while (at(TokenKind::kDot) && peek(1).kind == TokenKind::kIdentifier) {
    advance();
    type_name += '.' + std::string(text_of(token_));
    advance();
  }
  if (core::iequals(type_name, "STRING") || core::iequals(type_name, "WSTRING")) {
    out.kind = TypeSpec::Kind::kString;
    out.name = core::uppered(type_name);
    return string_length(out);
  }
  if (at(TokenKind::kLess) && !generic_values(type_name)) return false;
  if (!at(TokenKind::kLeftParen)) {
    out.kind = TypeSpec::Kind::kNamed;
    out.name = std::move(type_name);
    return true;
  }
  out.base = std::make_shared<TypeSpec>();
  out.base->kind = TypeSpec::Kind::kNamed;
  out.base->name = std::move(type_name);
  out.base->at = out.at;
  const TokenKind following = peek(2).kind;
  const bool names =
      peek(1).kind == TokenKind::kIdentifier &&
      (following == TokenKind::kComma || following == TokenKind::kRightParen || following == TokenKind::kAssign);
  if (!names) return subrange(out);
  if (following == TokenKind::kAssign && !core::type_named(out.base->name)) {
    return fail(Code::P4043, first, "arguments of a function block's declaration are not supported",
                "initial values are written as in: fb : T := (In := 1);");
  }
  return enumeration(out);
}

bool DeclarationReader::string_length(TypeSpec& out) {
  const bool bracket = at(TokenKind::kLeftBracket);
  if (!bracket && !at(TokenKind::kLeftParen)) return true;
  advance();
  Piece length = expression();
  if (length.text.empty()) return fail_expected("the length of a string");
  out.length = std::move(length.text);
  out.length_at = length.at;
  return bracket ? require(TokenKind::kRightBracket, "\"]\"") : require(TokenKind::kRightParen, "\")\"");
}

bool DeclarationReader::enumeration(TypeSpec& out) {
  out.kind = TypeSpec::Kind::kEnum;
  advance();
  do {
    if (at(TokenKind::kRightParen) && !out.values.empty()) break;
    if (!pay(1)) return false;
    plcopen::EnumValue value;
    value.at = place(token_.begin);
    if (!name(value.name, "the name of an enumeration value")) return false;
    if (accept(TokenKind::kAssign)) {
      Piece number = expression();
      if (number.text.empty()) return fail_expected("the value of \"" + value.name + '"');
      value.value = std::move(number.text);
      value.value_at = number.at;
    }
    out.values.push_back(std::move(value));
  } while (accept(TokenKind::kComma));
  if (!require(TokenKind::kRightParen, "\",\" or \")\"")) return false;
  // CODESYS writes the base type after the values.
  if (out.base == nullptr && at(TokenKind::kIdentifier) && core::type_named(text_of(token_))) {
    out.base = std::make_shared<TypeSpec>();
    return type_spec(*out.base);
  }
  return true;
}

bool DeclarationReader::subrange(TypeSpec& out) {
  out.kind = TypeSpec::Kind::kSubrange;
  advance();
  Piece lower = expression();
  if (lower.text.empty()) return fail_expected("the lower limit of a range");
  if (!require(TokenKind::kRange, "\"..\"")) return false;
  Piece upper = expression();
  if (upper.text.empty()) return fail_expected("the upper limit of a range");
  out.dimensions.push_back({std::move(lower.text), std::move(upper.text), lower.at, upper.at});
  return require(TokenKind::kRightParen, "\")\"");
}

// ---- initial values -------------------------------------------------------------------------------------------

/// The value of a declaration. Older tools write lists without brackets: "ARRAY [1..3] OF INT := 1, 2(0)".
bool DeclarationReader::initial_value(InitialValue& out) {
  const Token first = token_;
  const bool repetition = at(TokenKind::kInteger) && peek(1).kind == TokenKind::kLeftParen;
  if (!repetition && !value(out)) return false;
  if (!repetition && !at(TokenKind::kComma)) return true;
  InitialValue list;
  list.kind = InitialValue::Kind::kArray;
  list.at = place(first.begin);
  if (!repetition) {
    list.values.push_back(std::move(out));
    advance();
  }
  do {
    if (!array_element(list)) return false;
  } while (accept(TokenKind::kComma));
  out = std::move(list);
  return true;
}

bool DeclarationReader::value(InitialValue& out) {
  out.at = place(token_.begin, ElementKind::kText);
  if (!pay(1)) return false;
  const bool list = at(TokenKind::kLeftBracket);
  const bool structure =
      at(TokenKind::kLeftParen) && peek(1).kind == TokenKind::kIdentifier && peek(2).kind == TokenKind::kAssign;
  if (list || structure) {
    const bool fine = enter(token_) && (list ? array_value(out) : struct_value(out));
    leave();
    return fine;
  }
  Piece text = expression();
  if (text.text.empty()) return fail_expected("a value");
  out.kind = InitialValue::Kind::kSimple;
  out.text = std::move(text.text);
  return true;
}

bool DeclarationReader::array_value(InitialValue& out) {
  out.kind = InitialValue::Kind::kArray;
  advance();
  if (accept(TokenKind::kRightBracket)) return true;
  do {
    if (!array_element(out)) return false;
  } while (accept(TokenKind::kComma));
  return require(TokenKind::kRightBracket, "\",\" or \"]\"");
}

/// One element, or `n(value)`, or `n()`, which leaves the defaults.
bool DeclarationReader::array_element(InitialValue& list) {
  InitialValue& element = list.values.emplace_back();
  const bool counted = (at(TokenKind::kInteger) || at(TokenKind::kIdentifier) || at(TokenKind::kTyped)) &&
                       peek(1).kind == TokenKind::kLeftParen;
  if (!counted) return value(element);
  const Token number = token_;
  advance();
  advance();
  element.at = place(number.begin);
  bool fine = true;
  if (!at(TokenKind::kRightParen)) fine = value(element);
  element.repetition = text_of(number);
  element.repetition_at = place(number.begin, ElementKind::kText);
  return fine && require(TokenKind::kRightParen, "\")\"");
}

bool DeclarationReader::struct_value(InitialValue& out) {
  out.kind = InitialValue::Kind::kStruct;
  advance();
  do {
    InitialValue& member = out.values.emplace_back();
    std::string member_name;
    if (!name(member_name, "the name of a member") || !require(TokenKind::kAssign, "\":=\"")) return false;
    const bool fine = value(member);
    member.member = std::move(member_name);
    if (!fine) return false;
  } while (accept(TokenKind::kComma));
  return require(TokenKind::kRightParen, "\",\" or \")\"");
}

}  // namespace plc::st
