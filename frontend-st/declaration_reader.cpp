// Tokens, errors and what every declaration has.
#include "frontend-st/declaration_reader.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "core/text.h"
#include "frontend-st/keywords.h"

namespace plc::st {

using core::Code;
using core::SourceRef;

namespace {

/// Nesting of types and of initial values.
constexpr std::uint32_t kMaxNesting = 64;
constexpr std::size_t kMaxShown = 40;

constexpr std::pair<std::string_view, Word> kWords[] = {
    {"TYPE", Word::kType},
    {"END_TYPE", Word::kEndType},
    {"STRUCT", Word::kStruct},
    {"END_STRUCT", Word::kEndStruct},
    {"UNION", Word::kUnion},
    {"END_UNION", Word::kEndUnion},
    {"FUNCTION", Word::kFunction},
    {"END_FUNCTION", Word::kEndFunction},
    {"FUNCTION_BLOCK", Word::kFunctionBlock},
    {"END_FUNCTION_BLOCK", Word::kEndFunctionBlock},
    {"PROGRAM", Word::kProgram},
    {"END_PROGRAM", Word::kEndProgram},
    {"CONFIGURATION", Word::kConfiguration},
    {"END_CONFIGURATION", Word::kEndConfiguration},
    {"RESOURCE", Word::kResource},
    {"END_RESOURCE", Word::kEndResource},
    {"TASK", Word::kTask},
    {"VAR", Word::kVar},
    {"VAR_INPUT", Word::kVarInput},
    {"VAR_OUTPUT", Word::kVarOutput},
    {"VAR_IN_OUT", Word::kVarInOut},
    {"VAR_TEMP", Word::kVarTemp},
    {"VAR_EXTERNAL", Word::kVarExternal},
    {"VAR_GLOBAL", Word::kVarGlobal},
    {"VAR_ACCESS", Word::kVarAccess},
    {"VAR_CONFIG", Word::kVarConfig},
    {"VAR_INST", Word::kVarInst},
    {"VAR_GENERIC", Word::kVarGeneric},
    {"VAR_STAT", Word::kVarStat},
    {"END_VAR", Word::kEndVar},
    {"CLASS", Word::kClass},
    {"END_CLASS", Word::kEndClass},
    {"INTERFACE", Word::kInterface},
    {"END_INTERFACE", Word::kEndInterface},
    {"NAMESPACE", Word::kNamespace},
    {"END_NAMESPACE", Word::kEndNamespace},
    {"METHOD", Word::kMethod},
    {"END_METHOD", Word::kEndMethod},
    {"PROPERTY", Word::kProperty},
    {"END_PROPERTY", Word::kEndProperty},
    {"USING", Word::kUsing},
    {"ACTION", Word::kAction},
    {"END_ACTION", Word::kEndAction},
    {"ACTIONS", Word::kActions},
    {"END_ACTIONS", Word::kEndActions},
    {"STEP", Word::kStep},
    {"END_STEP", Word::kEndStep},
    {"INITIAL_STEP", Word::kInitialStep},
    {"TRANSITION", Word::kTransition},
    {"END_TRANSITION", Word::kEndTransition},
    {"TEST", Word::kTest},
    {"END_TEST", Word::kEndTest},
    // Other spellings come after those of the standard.
    {"FUNCTIONBLOCK", Word::kFunctionBlock},
    {"END_FUNCTIONBLOCK", Word::kEndFunctionBlock},
};

/// Words that no declared thing can be called. Those of later editions and of charts are names in older texts.
bool is_reserved_word(Word word) {
  return word != Word::kNone && word != Word::kTask && word != Word::kResource && word != Word::kUnion &&
         (word < Word::kClass || word == Word::kEndClass);
}

bool is_operator(std::string_view text) {
  return core::iequals(text, "AND") || core::iequals(text, "OR") || core::iequals(text, "XOR") ||
         core::iequals(text, "MOD") || core::iequals(text, "NOT");
}

}  // namespace

DeclarationReader::DeclarationReader(const SourceText& source, plcopen::Project& project,
                                     core::Diagnostics& diagnostics, const DeclaredText* chosen)
    : source_(source),
      project_(project),
      diagnostics_(diagnostics),
      chosen_(chosen),
      lexer_(source.text(), &pragmas_, &comments_) {
  advance();
}

// ---- tokens ---------------------------------------------------------------------------------------------------

void DeclarationReader::advance() {
  last_end_ = token_.end;
  if (ahead_count_ != 0) {
    token_ = ahead_[0];
    std::copy(ahead_.begin() + 1, ahead_.begin() + static_cast<std::ptrdiff_t>(ahead_count_), ahead_.begin());
    --ahead_count_;
  } else {
    token_ = lexer_.next();
  }
  if (!pragmas_.empty()) keep_pragmas();
  if (token_.kind == TokenKind::kUnterminatedComment && !exhausted_) {
    fail(Code::P4040, token_, "comment or pragma does not end", "close it with *), */ or }");
    exhausted_ = true;
  }
  if (exhausted_) token_ = {TokenKind::kEnd, token_.begin, token_.begin};
}

const Token& DeclarationReader::peek(std::size_t ahead) {
  while (ahead_count_ < ahead) ahead_[ahead_count_++] = lexer_.next();
  return ahead_[ahead - 1];
}

bool DeclarationReader::is_reserved(Word word) { return is_reserved_word(word); }

Word DeclarationReader::word_of(const Token& token) const {
  static const auto kTable = [] {
    std::unordered_map<std::string_view, Word, core::NameHash, core::NameEqual> table;
    for (const auto& [text, word] : kWords) table.emplace(text, word);
    return table;
  }();
  // The shortest word is VAR, the longest END_FUNCTION_BLOCK.
  const std::uint32_t length = token.end - token.begin;
  if (token.kind != TokenKind::kIdentifier || length < 3 || length > 18) return Word::kNone;
  const auto found = kTable.find(text_of(token));
  return found == kTable.end() ? Word::kNone : found->second;
}

void DeclarationReader::note_spelling(const Token& token, Word word) {
  const std::string_view standard = kWords[static_cast<std::size_t>(word) - 1].first;
  if (core::iequals(text_of(token), standard)) return;
  fail(Code::P4350, token, "keyword " + shown(token) + " is " + std::string(standard) + " in the standard",
       "write " + std::string(standard));
}

bool DeclarationReader::is_text(const Token& token, std::string_view word) const {
  return token.kind == TokenKind::kIdentifier && core::iequals(text_of(token), word);
}

bool DeclarationReader::at_text(std::string_view word) const { return is_text(token_, word); }

bool DeclarationReader::accept(TokenKind kind) {
  if (!at(kind)) return false;
  advance();
  return true;
}

bool DeclarationReader::accept_text(std::string_view word) {
  if (!at_text(word)) return false;
  advance();
  return true;
}

SourceRef DeclarationReader::place(std::uint32_t offset, core::ElementKind kind) const {
  SourceRef out = source_.locate(offset);
  out.kind = kind;
  return out;
}

std::string DeclarationReader::shown(const Token& token) const {
  if (token.kind == TokenKind::kEnd) return "the end of the text";
  std::string text(text_of(token).substr(0, kMaxShown));
  while (!text.empty() && text.size() == kMaxShown && (static_cast<unsigned char>(text.back()) & 0x80u) != 0) {
    text.pop_back();
  }
  return shown_token(text);
}

// ---- errors ---------------------------------------------------------------------------------------------------

bool DeclarationReader::fail(Code code, const Token& token, std::string message, std::string help) {
  if (!exhausted_) diagnostics_.report(code, place(token.begin), pou_, std::move(message), std::move(help));
  return false;
}

bool DeclarationReader::fail_expected(std::string_view wanted) {
  return fail(Code::P4040, token_, shown(token_) + " where " + std::string(wanted) + " is expected",
              stray_character(text_of(token_)) != 0 ? kStrayHelp : "");
}

bool DeclarationReader::fail_unclosed(std::string_view what, const Token& opener, std::string_view end) {
  return fail(
      Code::P4042, opener,
      std::string(what) + " has no " + std::string(end) + " before " +
          (token_.kind == TokenKind::kEnd ? "the end of the text"
                                          : shown(token_) + " in line " + std::to_string(place(token_.begin).line)),
      "write " + std::string(end) + " where it ends");
}

bool DeclarationReader::require(TokenKind kind, std::string_view wanted) {
  return accept(kind) || fail_expected(wanted);
}

bool DeclarationReader::enter(const Token& token) {
  if (++depth_ <= kMaxNesting) return true;
  return fail(Code::P4044, token, "nested more than " + std::to_string(kMaxNesting) + " levels deep");
}

/// "type : INT;" among variables or members is one wrong name, and no end of them.
bool DeclarationReader::refuse_keyword(Word word) {
  if (!is_reserved(word) || peek(1).kind != TokenKind::kColon) return false;
  fail(Code::P4040, token_, shown(token_) + " is a keyword, and names no variable", "give it another name");
  advance();
  skip_declaration();
  return true;
}

/// To the `;` of the declaration, or to a word that cannot be part of it.
void DeclarationReader::skip_declaration() {
  std::uint32_t structures = 0;
  for (; !at(TokenKind::kEnd); advance()) {
    if (structures == 0 && accept(TokenKind::kSemicolon)) return;
    // A text without its quote took the ";" along.
    if (structures == 0 && accept(TokenKind::kUnterminatedString)) return;
    const Word word = word_of(token_);
    if (word == Word::kStruct) {
      ++structures;
    } else if (word == Word::kEndStruct && structures != 0) {
      --structures;
    } else if (is_reserved(word)) {
      return;
    }
  }
}

/// Past a declaration that failed and began at `begin`. Always makes progress.
void DeclarationReader::recover(std::uint32_t begin) {
  skip_declaration();
  if (token_.begin == begin) advance();
}

/// Past `end`, passing over inner constructs of the same kind by their own `end`.
void DeclarationReader::skip_to(Word end) {
  while (!at(TokenKind::kEnd) && word_of(token_) != end) advance();
  if (!at(TokenKind::kEnd)) advance();
}

/// To a word that opens something at the level of the file.
void DeclarationReader::skip_to_opener() {
  for (; !at(TokenKind::kEnd); advance()) {
    const Word word = word_of(token_);
    const bool opens = word == Word::kType || word == Word::kConfiguration || word == Word::kVarGlobal ||
                       word == Word::kFunction || word == Word::kFunctionBlock || word == Word::kProgram;
    const bool names = (word == Word::kClass || word == Word::kInterface || word == Word::kNamespace) &&
                       peek(1).kind == TokenKind::kIdentifier;
    if (opens || names) return;
  }
}

/// The `;` of a declaration. A missing one is reported where it should be; what looks like the next declaration is
/// not skipped.
bool DeclarationReader::end_declaration() {
  if (accept(TokenKind::kSemicolon)) return true;
  fail(Code::P4040, token_, "\";\" is missing before " + shown(token_),
       at(TokenKind::kEqual) ? "values of declarations follow :=" : "");
  const TokenKind next = at(TokenKind::kIdentifier) ? peek(1).kind : TokenKind::kEnd;
  if (next != TokenKind::kColon && next != TokenKind::kComma && !is_reserved(word_of(token_))) skip_declaration();
  return false;
}

void DeclarationReader::note_extent(std::vector<std::string> names, std::uint32_t begin) {
  project_.extents.push_back({std::move(names), place(begin), place(last_end_)});
}

/// The names among two tokens.
std::vector<std::string> DeclarationReader::names_of(const Token& first, const Token& second) const {
  std::vector<std::string> names;
  for (const Token& token : {first, second}) {
    if (token.kind == TokenKind::kIdentifier && word_of(token) == Word::kNone) names.emplace_back(text_of(token));
  }
  return names;
}

/// Object orientation: one error for the construct, nothing for what is in it.
std::string DeclarationReader::refuse(Word opener, Word end, std::string_view what) {
  const Token first = token_;
  advance();
  while (at_text("PUBLIC") || at_text("PRIVATE") || at_text("PROTECTED") || at_text("INTERNAL") || at_text("FINAL") ||
         at_text("ABSTRACT")) {
    advance();
  }
  std::string label(what);
  std::vector<std::string> names;  // of what is in it, too: a namespace has types and POUs
  if (at(TokenKind::kIdentifier)) names.emplace_back(text_of(token_));
  std::string name = names.empty() ? std::string() : names.front();
  if (at(TokenKind::kIdentifier)) label += " \"" + std::string(text_of(token_).substr(0, kMaxShown)) + '"';
  fail(Code::P4041, first, label + " belongs to object orientation, which is not supported",
       "write it as function blocks, functions and structures");
  count(std::string(what), plcopen::Fate::kRefused, place(first.begin), "object orientation is not supported");
  for (std::uint32_t open = 1; !at(TokenKind::kEnd); advance()) {
    const Word word = word_of(token_);
    if (word == opener) ++open;
    if (word == end && --open == 0) break;
    const bool names_next = word == Word::kFunction || word == Word::kFunctionBlock || word == Word::kProgram ||
                            word == Word::kClass || word == Word::kInterface || word == Word::kType;
    if (opener == Word::kNamespace && names_next && peek(1).kind == TokenKind::kIdentifier) {
      names.emplace_back(text_of(peek(1)));
    }
  }
  if (!at(TokenKind::kEnd)) {
    advance();
  } else {
    fail_unclosed(label, first, kWords[static_cast<std::size_t>(end) - 1].first);
  }
  if (pou_.empty()) note_extent(std::move(names), first.begin);
  return name;
}

void DeclarationReader::count(std::string element, plcopen::Fate fate, const SourceRef& at, std::string_view reason) {
  for (plcopen::ReportRow& row : project_.report) {
    if (row.element != element || row.fate != fate) continue;
    ++row.count;
    return;
  }
  project_.report.push_back({std::move(element), fate, 1, at.line, std::string(reason)});
}

void DeclarationReader::keep_pragmas() {
  for (const Token& pragma : pragmas_) {
    const SourceRef at = place(pragma.begin);
    count("pragma", plcopen::Fate::kPreserved, at, "kept as text");
    project_.pragmas.push_back({std::string(text_of(pragma)), at});
    kept_pragmas_.push_back(pragma);
  }
  pragmas_.clear();
}

void DeclarationReader::keep_comments() {
  std::sort(bodies_.begin(), bodies_.end());
  auto body = bodies_.begin();
  for (const Token& comment : comments_) {
    while (body != bodies_.end() && body->second <= comment.begin) ++body;
    if (body != bodies_.end() && body->first <= comment.begin) continue;
    // Up to the begin of the line; a comment before this one is there, too.
    const std::string_view before = source_.slice(0, comment.begin);
    const std::size_t line = before.find_last_of("\r\n");
    const std::string_view left = core::trimmed(before.substr(line == std::string_view::npos ? 0 : line));
    const bool alone = left.empty() || (left.starts_with("(*") && left.ends_with("*)"));
    project_.comments.push_back({std::string(text_of(comment)), place(comment.begin), !alone});
  }
  comments_.clear();
}

std::uint32_t DeclarationReader::last_comment(std::uint32_t begin, std::uint32_t end) const {
  std::uint32_t last = begin;
  for (auto comment = comments_.rbegin(); comment != comments_.rend() && comment->begin >= begin; ++comment) {
    if (comment->end <= end) last = std::max(last, comment->end);
  }
  return last;
}

/// Notes the attributes that stand right before the declaration that begins at `to`; `from` is where the one before
/// ends.
void DeclarationReader::note_attributes(std::string_view pou, std::string_view variable, std::uint32_t from,
                                        std::uint32_t to) {
  for (auto pragma = kept_pragmas_.rbegin(); pragma != kept_pragmas_.rend() && pragma->begin >= from; ++pragma) {
    if (pragma->begin >= to) continue;
    Lexer lexer(text_of(*pragma).substr(1));
    const std::string_view inner = text_of(*pragma).substr(1);
    const Token word = lexer.next();
    const Token name = lexer.next();
    if (!core::iequals(inner.substr(word.begin, word.end - word.begin), "attribute")) continue;
    if (name.kind != TokenKind::kString || name.end - name.begin < 2) continue;
    project_.attributes.push_back({std::string(pou), std::string(variable),
                                   std::string(inner.substr(name.begin + 1, name.end - name.begin - 2))});
  }
}

namespace {

/// The text in the quotes that begin at or after `at`; moves past them.
std::optional<std::string_view> quoted_from(std::string_view text, std::size_t& at) {
  const std::size_t begin = text.find('\'', at);
  const std::size_t end = begin == std::string_view::npos ? begin : text.find('\'', begin + 1);
  if (end == std::string_view::npos) return std::nullopt;
  at = end + 1;
  return text.substr(begin + 1, end - begin - 1);
}

}  // namespace

std::optional<std::string> DeclarationReader::attribute_here(std::string_view name) const {
  const std::string_view gap = source_.slice(last_end_, token_.begin);
  std::vector<Token> pragmas;
  Lexer(gap, &pragmas).next();
  for (const Token& pragma : pragmas) {
    std::string_view text = core::trimmed(gap.substr(pragma.begin + 1, pragma.end - pragma.begin - 1));
    if (text.size() < 9 || !core::iequals(text.substr(0, 9), "attribute")) continue;
    std::size_t at = 0;
    const auto key = quoted_from(text, at);
    if (!key || !core::iequals(*key, name)) continue;
    return std::string(quoted_from(text, at).value_or(std::string_view()));
  }
  return std::nullopt;
}

// ---- parts of declarations ------------------------------------------------------------------------------------

bool DeclarationReader::name(std::string& out, std::string_view what) {
  constexpr std::size_t kMaxName = 1024;
  if (!at(TokenKind::kIdentifier)) return fail_expected(what);
  if (is_reserved(word_of(token_)) || keyword_of(text_of(token_)) != Keyword::kNone) {
    return fail(Code::P4040, token_, shown(token_) + " is a keyword, where " + std::string(what) + " is expected");
  }
  if (token_.end - token_.begin > kMaxName) {
    return fail(Code::P4044, token_, "name is longer than " + std::to_string(kMaxName) + " bytes");
  }
  out = text_of(token_);
  advance();
  return true;
}

/// The tokens up to one that ends an expression outside of all brackets, as written; empty when there is none.
DeclarationReader::Piece DeclarationReader::expression() {
  const std::uint32_t begin = token_.begin;
  std::uint32_t end = begin;
  std::uint32_t open = 0;
  bool operand = false;  // the last token ended an operand: a name after it belongs to the next declaration
  for (; !at(TokenKind::kEnd) && !at(TokenKind::kSemicolon); advance()) {
    const TokenKind kind = token_.kind;
    if (kind == TokenKind::kLeftParen || kind == TokenKind::kLeftBracket) {
      ++open;
    } else if (kind == TokenKind::kRightParen || kind == TokenKind::kRightBracket) {
      if (open == 0) break;
      --open;
    } else if (open == 0 && (kind == TokenKind::kComma || kind == TokenKind::kRange || kind == TokenKind::kColon ||
                             kind == TokenKind::kAssign || kind == TokenKind::kOutput)) {
      break;
    } else if (kind == TokenKind::kIdentifier) {
      const bool is_op = is_operator(text_of(token_));
      if (is_reserved(word_of(token_)) || (open == 0 && operand && !is_op)) break;
      operand = !is_op;
      end = token_.end;
      continue;
    }
    operand = kind == TokenKind::kRightParen || kind == TokenKind::kRightBracket || kind == TokenKind::kInteger ||
              kind == TokenKind::kReal || kind == TokenKind::kTyped || kind == TokenKind::kEnumValue ||
              kind == TokenKind::kString || kind == TokenKind::kWstring || kind == TokenKind::kDirect;
    end = token_.end;
  }
  return {std::string(source_.slice(begin, end)), place(begin, core::ElementKind::kText)};
}

/// "Res.Prog.fb[1].x" or "Res.%QX0.0" without blanks; empty when there is none.
DeclarationReader::Piece DeclarationReader::dotted_path() {
  Piece out{{}, place(token_.begin)};
  while (true) {
    if (!at(TokenKind::kIdentifier) && !at(TokenKind::kDirect)) return out;
    out.text += text_of(token_);
    advance();
    while (accept(TokenKind::kLeftBracket)) {
      out.text += '[';
      while (!at(TokenKind::kRightBracket) && !at(TokenKind::kSemicolon) && !at(TokenKind::kEnd)) {
        out.text += text_of(token_);
        advance();
      }
      if (accept(TokenKind::kRightBracket)) out.text += ']';
    }
    if (!accept(TokenKind::kDot)) return out;
    out.text += '.';
  }
}

/// The configuration for what is outside all configurations.
plcopen::Configuration& DeclarationReader::outside() {
  if (!has_outside_) outside_at_ = project_.configurations.size();
  has_outside_ = true;
  return outside_;
}

// ---- the file -------------------------------------------------------------------------------------------------

void DeclarationReader::read_file() {
  while (!at(TokenKind::kEnd)) {
    const Word word = word_of(token_);
    const bool names = peek(1).kind == TokenKind::kIdentifier;
    if (accept(TokenKind::kSemicolon)) continue;
    if (word == Word::kType) {
      type_block();
    } else if (word == Word::kFunction || word == Word::kFunctionBlock || word == Word::kProgram) {
      pou(word);
    } else if (opens_test()) {
      test();
    } else if (word == Word::kConfiguration) {
      configuration();
    } else if (word == Word::kResource) {
      resource(outside());
    } else if (word == Word::kVarGlobal) {
      section(Owner::kFile, outside().globals);
    } else if (word == Word::kVarConfig) {
      section(Owner::kFile, outside().configs);
    } else if (word == Word::kVarAccess) {
      section(Owner::kFile, outside().access);
    } else if (names && word == Word::kClass) {
      refuse(Word::kClass, Word::kEndClass, "CLASS");
    } else if (names && word == Word::kInterface) {
      refuse(Word::kInterface, Word::kEndInterface, "INTERFACE");
    } else if (names && word == Word::kNamespace) {
      refuse(Word::kNamespace, Word::kEndNamespace, "NAMESPACE");
    } else if (names && word == Word::kMethod) {
      refuse(Word::kMethod, Word::kEndMethod, "METHOD");
    } else if (names && word == Word::kProperty) {
      refuse(Word::kProperty, Word::kEndProperty, "PROPERTY");
    } else if (names && word == Word::kUsing) {
      fail(Code::P4041, token_, "USING belongs to namespaces, which are not supported", "remove it");
      skip_declaration();
    } else if (names && word == Word::kAction) {
      action(project_.pous.empty() ? std::string() : project_.pous.back().name);
    } else if (word == Word::kActions) {
      actions();
    } else {
      fail(Code::P4040, token_,
           shown(token_) +
               " where a declaration is expected: TYPE, FUNCTION, FUNCTION_BLOCK, PROGRAM, VAR_GLOBAL or "
               "CONFIGURATION",
           word == Word::kTest ? "the name of a test is a text in single quotes: TEST 'the pump stops'" : "");
      const std::uint32_t begin = token_.begin;
      std::vector<std::string> words = names_of(token_, peek(1));
      advance();
      skip_to_opener();
      note_extent(std::move(words), begin);
    }
  }
  give_actions();
  keep_comments();
  if (!has_outside_) return;
  const auto place = project_.configurations.begin() + static_cast<std::ptrdiff_t>(outside_at_);
  project_.configurations.insert(place, std::move(outside_));
}

void DeclarationReader::read_interface(plcopen::Pou& target) {
  const Word word = word_of(token_);
  pou_ = target.name;
  if (word == Word::kFunction || word == Word::kFunctionBlock || word == Word::kProgram) {
    plcopen::Pou head;
    if (!pou_head(head, word)) skip_declaration();
    if (target.return_type.kind == plcopen::TypeSpec::Kind::kMissing) target.return_type = std::move(head.return_type);
  }
  const Owner owner = target.kind == plcopen::PouKind::kFunction        ? Owner::kFunction
                      : target.kind == plcopen::PouKind::kFunctionBlock ? Owner::kFunctionBlock
                                                                        : Owner::kProgram;
  while (is_section(word_of(token_))) section(owner, target.variables);
  if (!at(TokenKind::kEnd)) fail_expected("a section of variables");
}

bool DeclarationReader::read_head(plcopen::Pou& target, std::vector<std::string>& objects) {
  const Word word = word_of(token_);
  if (word != Word::kFunction && word != Word::kFunctionBlock && word != Word::kProgram) {
    return fail_expected("PROGRAM, FUNCTION_BLOCK or FUNCTION");
  }
  objects_ = &objects;
  if (!pou_head(target, word)) {
    while (!at(TokenKind::kEnd) && !is_section(word_of(token_))) advance();
  }
  objects_ = nullptr;
  const Owner owner = word == Word::kFunction        ? Owner::kFunction
                      : word == Word::kFunctionBlock ? Owner::kFunctionBlock
                                                     : Owner::kProgram;
  while (is_section(word_of(token_))) section(owner, target.variables);
  if (!at(TokenKind::kEnd)) fail_expected("a section of variables");
  keep_comments();
  pou_.clear();
  return !target.name.empty();
}

void DeclarationReader::read_pragmas() {
  // What does not end is another reader's problem: nothing of this text counts.
  while (!at(TokenKind::kEnd) && peek(1).kind != TokenKind::kUnterminatedComment) advance();
}

void DeclarationReader::read_globals(std::vector<plcopen::Variable>& out, const std::string& list) {
  const std::size_t first = out.size();
  while (word_of(token_) == Word::kVarGlobal) section(Owner::kFile, out);
  if (!at(TokenKind::kEnd)) fail_expected("VAR_GLOBAL");
  for (std::size_t i = first; i < out.size(); ++i) out[i].list = list;
}

}  // namespace plc::st
