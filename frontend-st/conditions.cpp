#include "frontend-st/conditions.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <span>
#include <utility>

#include "frontend-st/ast.h"

namespace plc::st {

using core::Code;

namespace {

enum class Directive : std::uint8_t { kNone, kIf, kElsif, kElse, kEndIf, kDefine, kUndefine, kForeign };

constexpr std::pair<std::string_view, Directive> kDirectives[] = {
    {"IF", Directive::kIf},          {"ELSIF", Directive::kElsif},    {"ELSE", Directive::kElse},
    {"END_IF", Directive::kEndIf},   {"DEFINE", Directive::kDefine},  {"UNDEFINE", Directive::kUndefine},
    {"IFDEF", Directive::kForeign},  {"IFNDEF", Directive::kForeign}, {"ENDIF", Directive::kForeign},
    {"ELSEIF", Directive::kForeign},
};

std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

/// The first word of a pragma, and where what follows it begins.
Directive directive_of(std::string_view pragma, std::size_t& rest) {
  if (pragma.size() < 2 || pragma.back() != '}') return Directive::kNone;
  const std::string_view inner = pragma.substr(0, pragma.size() - 1);
  const std::size_t begin = inner.find_first_not_of(" \t\r\n", 1);
  if (begin == std::string_view::npos) return Directive::kNone;
  std::size_t end = begin;
  while (end < inner.size() && is_identifier_char(inner[end])) ++end;
  rest = end;
  // {else := 1} is no directive, but a word of another tool.
  const std::size_t next = inner.find_first_not_of(" \t\r\n", end);
  if (next != std::string_view::npos && inner[next] == ':') return Directive::kNone;
  for (const auto& [word, directive] : kDirectives) {
    if (core::iequals(word, inner.substr(begin, end - begin))) return directive;
  }
  return Directive::kNone;
}

std::string_view without_quotes(std::string_view text) {
  const bool quotes = text.size() >= 2 && text.front() == '\'' && text.back() == '\'';
  return quotes ? text.substr(1, text.size() - 2) : text;
}

/// One condition: reads and decides it. OR binds weaker than AND, AND weaker than NOT.
class Condition {
 public:
  Condition(const SourceText& source, std::uint32_t begin, std::uint32_t end, const Defines& defines,
            const Surroundings* surroundings, core::Diagnostics& diagnostics, std::string_view pou)
      : source_(source),
        begin_(begin),
        lexer_(source.text().substr(begin, end - begin)),
        defines_(defines),
        surroundings_(surroundings),
        diagnostics_(diagnostics),
        pou_(pou) {
    advance();
  }

  /// Nothing after an error.
  std::optional<bool> decide() {
    const bool holds = any();
    if (fine_ && token_.kind != TokenKind::kEnd) unexpected("AND, OR or \"}\"");
    return fine_ ? std::optional(holds) : std::nullopt;
  }

 private:
  void advance() {
    token_ = lexer_.next();
    token_.begin += begin_;
    token_.end += begin_;
  }
  [[nodiscard]] std::string_view text() const { return source_.slice(token_.begin, token_.end); }
  [[nodiscard]] bool at_word(std::string_view word) const {
    return token_.kind == TokenKind::kIdentifier && core::iequals(text(), word);
  }
  bool accept(TokenKind kind) {
    if (token_.kind != kind) return false;
    advance();
    return true;
  }
  bool fail(const Token& token, std::string message, std::string help = {}) {
    if (fine_) diagnostics_.report(Code::P4521, source_.locate(token.begin), pou_, std::move(message), std::move(help));
    fine_ = false;
    return false;
  }
  bool unexpected(std::string_view wanted) {
    return fail(token_,
                (token_.kind == TokenKind::kEnd ? std::string("the condition ends") : "found " + shown_token(text())) +
                    " where " + std::string(wanted) + " is expected",
                "conditions are made of defined (NAME), hasvalue, hasattribute and hastype, with AND, OR, NOT");
  }

  bool any() {
    bool holds = all();
    while (fine_ && at_word("OR")) {
      advance();
      const bool right = all();
      holds = holds || right;
    }
    return holds;
  }
  bool all() {
    bool holds = one();
    while (fine_ && at_word("AND")) {
      advance();
      const bool right = one();
      holds = holds && right;
    }
    return holds;
  }
  bool one() {
    bool negated = false;
    for (; at_word("NOT"); advance()) negated = !negated;
    if (token_.kind == TokenKind::kLeftParen) {
      if (++depth_ > kMaxDepth) return fail(token_, "nested more than " + std::to_string(kMaxDepth) + " levels deep");
      advance();
      const bool holds = any();
      --depth_;
      if (fine_ && !accept(TokenKind::kRightParen)) unexpected("\")\"");
      return holds != negated;
    }
    return call() != negated;
  }

  /// defined (NAME), defined (variable: NAME), hasvalue (NAME, 'text'), ..
  bool call() {
    const Token asked = token_;
    const std::string word = core::uppered(text());
    const bool known = word == "DEFINED" || word == "HASVALUE" || word == "HASATTRIBUTE" || word == "HASTYPE";
    if (token_.kind != TokenKind::kIdentifier || !known) return unexpected("a condition");
    advance();
    if (!accept(TokenKind::kLeftParen)) return unexpected("\"(\"");
    std::string kind;
    std::string name;
    if (!path(name)) return false;
    if (accept(TokenKind::kColon)) {
      kind = core::uppered(name);
      if (!path(name)) return false;
    }
    std::string second;
    if (word != "DEFINED") {
      if (!accept(TokenKind::kComma)) return unexpected("\",\"");
      second = std::string(without_quotes(text()));
      const bool value =
          token_.kind == TokenKind::kString || (word != "HASATTRIBUTE" && token_.kind == TokenKind::kIdentifier);
      if (!value) return unexpected(word == "HASTYPE" ? "a type" : "a text in quotes");
      advance();
    }
    if (!accept(TokenKind::kRightParen)) return unexpected("\")\"");
    return answer(asked, word, kind, name, second);
  }

  bool path(std::string& out) {
    out.clear();
    for (;;) {
      if (token_.kind != TokenKind::kIdentifier) return unexpected("a name");
      out += text();
      advance();
      if (!accept(TokenKind::kDot)) return true;
      out += '.';
    }
  }

  bool answer(const Token& asked, const std::string& word, const std::string& kind, const std::string& name,
              const std::string& second) {
    if (kind.empty() && word == "DEFINED") return defines_.find(name) != nullptr || is_built_in(name);
    if (kind.empty() && word == "HASVALUE") {
      const std::string* text = defines_.find(name);
      return text != nullptr && *text == second;
    }
    const bool fits =
        (word == "DEFINED" && (kind == "VARIABLE" || kind == "TYPE" || kind == "POU" || kind == "TASK")) ||
        (word == "HASATTRIBUTE" && (kind == "VARIABLE" || kind == "POU")) || (word == "HASTYPE" && kind == "VARIABLE");
    if (!fits) {
      return fail(
          asked,
          "condition " + quoted(core::uppered(word)) + " of " + (kind.empty() ? "a name" : quoted(kind)) +
              " is not known",
          "known are defined (NAME), defined (variable: x), (type: x), (pou: x), (task: x), hasvalue (NAME, 'text'), "
          "hasattribute (variable: x, 'name'), (pou: x, 'name'), hastype (variable: x, TYPE)");
    }
    if (surroundings_ == nullptr) {
      return fail(asked, "what a project declares is not known where declarations are chosen",
                  "ask for a define there: defined (NAME), and plc --define NAME");
    }
    if (word == "HASTYPE") return surroundings_->is_of_type(name, second);
    if (word == "HASATTRIBUTE") {
      return kind == "POU" ? surroundings_->pou_has_attribute(name, second)
                           : surroundings_->variable_has_attribute(name, second);
    }
    if (kind == "VARIABLE") return surroundings_->has_variable(name);
    if (kind == "TYPE") return surroundings_->has_type(name);
    if (kind == "TASK") return surroundings_->has_task(name);
    return surroundings_->has_pou(name);
  }

  /// What CODESYS defines by itself, where it is the same for every target of PICARD. There is no simulation apart:
  /// what is simulated is what runs.
  static bool is_built_in(std::string_view name) {
    return core::iequals(name, "IsLittleEndian") || core::iequals(name, "IsFPUSupported");
  }

  const SourceText& source_;
  std::uint32_t begin_;
  Lexer lexer_;
  Token token_;
  const Defines& defines_;
  const Surroundings* surroundings_;
  core::Diagnostics& diagnostics_;
  std::string_view pou_;
  std::uint32_t depth_ = 0;
  bool fine_ = true;
};

/// Follows pragmas in their order, and notes what they blank out.
class Chooser {
 public:
  Chooser(const SourceText& source, Defines& defines, const Surroundings* surroundings, core::Diagnostics& diagnostics,
          std::string_view pou)
      : source_(source), defines_(defines), surroundings_(surroundings), diagnostics_(diagnostics), pou_(pou) {}

  /// Whether what comes next counts.
  [[nodiscard]] bool active() const { return frames_.empty() || frames_.back().active; }
  [[nodiscard]] bool fine() const { return fine_; }
  /// Whether an {IF} is not closed yet.
  [[nodiscard]] bool open() const { return !frames_.empty(); }
  const std::vector<std::pair<std::uint32_t, std::uint32_t>>& blanks() const { return blanks_; }

  void pragma(const Token& pragma) {
    const bool before = active();
    std::size_t rest = 0;
    const std::string_view text = source_.slice(pragma.begin, pragma.end);
    const Directive directive = directive_of(text, rest);
    const auto from = static_cast<std::uint32_t>(pragma.begin + rest);
    switch (directive) {
      case Directive::kNone:
        return;
      case Directive::kForeign:
        if (before) {
          fail(Code::P4520, pragma, quoted(text) + " is no pragma of the language",
               "write {IF defined (NAME)} .. {END_IF}");
        }
        return;
      case Directive::kDefine:
      case Directive::kUndefine:
        if (before) define(pragma, from, directive == Directive::kDefine);
        return;
      case Directive::kIf:
        frames_.push_back({pragma, before, false, false, false});
        choose(pragma, from);
        break;
      case Directive::kElsif:
        if (!belongs(pragma, "{ELSIF}")) return;
        choose(pragma, from);
        break;
      case Directive::kElse: {
        if (!belongs(pragma, "{ELSE}")) return;
        Frame& frame = frames_.back();
        frame.active = frame.outer && !frame.taken;
        frame.otherwise = true;
        break;
      }
      case Directive::kEndIf:
        if (frames_.empty()) {
          fail(Code::P4520, pragma, "{END_IF} without its {IF}");
          return;
        }
        frames_.pop_back();
        break;
    }
    if (before && active()) {
      blanks_.emplace_back(pragma.begin, pragma.end);
    } else if (before) {
      off_from_ = pragma.begin;
    } else if (active()) {
      blanks_.emplace_back(off_from_, pragma.end);
    }
  }

  /// The text ends.
  void finish() {
    if (!active()) blanks_.emplace_back(off_from_, static_cast<std::uint32_t>(source_.text().size()));
    for (const Frame& frame : frames_) {
      fail(Code::P4520, frame.opener, "{IF} without its {END_IF}",
           "write {END_IF} where the choice ends, in the same body");
    }
    frames_.clear();
  }

 private:
  struct Frame {
    Token opener;
    bool outer = true;       ///< what is around it counts
    bool active = false;     ///< the branch that is open counts
    bool taken = false;      ///< one of the branches counted
    bool otherwise = false;  ///< {ELSE} was passed
  };

  void fail(Code code, const Token& token, std::string message, std::string help = {}) {
    diagnostics_.report(code, source_.locate(token.begin), pou_, std::move(message), std::move(help));
    fine_ = false;
  }
  bool belongs(const Token& pragma, std::string_view what) {
    if (!frames_.empty() && !frames_.back().otherwise) return true;
    fail(Code::P4520, pragma,
         frames_.empty() ? std::string(what) + " without its {IF}"
                         : std::string(what) + " after the {ELSE} of the same {IF}");
    return false;
  }
  void choose(const Token& pragma, std::uint32_t from) {
    Frame& frame = frames_.back();
    const bool counts = frame.outer && !frame.taken;
    Condition condition(source_, from, pragma.end - 1, defines_, surroundings_, diagnostics_, pou_);
    // What is passed over is not asked: names in it need not exist.
    const auto holds = counts ? condition.decide() : std::optional(false);
    if (!holds) fine_ = false;
    frame.active = counts && holds.value_or(false);
    frame.taken = frame.taken || frame.active;
  }
  void define(const Token& pragma, std::uint32_t from, bool adds) {
    Lexer lexer(source_.slice(from, pragma.end - 1));
    const Token name = lexer.next();
    if (name.kind != TokenKind::kIdentifier) {
      return fail(Code::P4521, pragma, "the name after define or undefine is missing");
    }
    const std::string_view written = source_.slice(from + name.begin, from + name.end);
    if (!adds) return defines_.undefine(written);
    const std::string_view rest = core::trimmed(source_.slice(from + name.end, pragma.end - 1));
    defines_.define(written, without_quotes(rest));
  }

  const SourceText& source_;
  Defines& defines_;
  const Surroundings* surroundings_;
  core::Diagnostics& diagnostics_;
  std::string_view pou_;
  std::vector<Frame> frames_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> blanks_;
  std::uint32_t off_from_ = 0;
  bool fine_ = true;
};

/// Whether a text may have pragmas that choose: most have none, and are not looked through twice.
bool may_choose(std::string_view text) {
  for (std::size_t i = text.find('{'); i != std::string_view::npos; i = text.find('{', i + 1)) {
    const std::size_t end = text.find('}', i);
    if (end == std::string_view::npos) return false;
    if (is_choosing_pragma(text.substr(i, end - i + 1))) return true;
  }
  return false;
}

}  // namespace

bool is_choosing_pragma(std::string_view pragma) {
  std::size_t rest = 0;
  return directive_of(pragma, rest) != Directive::kNone;
}

Defines::Defines(const std::vector<std::string>& entries) {
  for (const std::string& entry : entries) {
    const std::size_t equal = entry.find('=');
    define(std::string_view(entry).substr(0, equal),
           equal == std::string::npos ? std::string_view{} : std::string_view(entry).substr(equal + 1));
  }
}

const std::string* Defines::find(std::string_view name) const {
  const auto found = texts_.find(std::string(name));
  return found == texts_.end() ? nullptr : &found->second;
}

std::vector<std::string> Defines::entries() const {
  std::vector<std::string> out;
  for (const auto& [name, text] : texts_) out.push_back(text.empty() ? name : name + "=" + text);
  return out;
}

std::string blanked(std::string_view text, const std::vector<std::pair<std::uint32_t, std::uint32_t>>& ranges) {
  std::string out;
  out.reserve(text.size());
  std::size_t at = 0;
  for (const auto& [begin, end] : ranges) {
    out.append(text, at, begin - at);
    for (at = begin; at < end; ++at) {
      if ((static_cast<unsigned char>(text[at]) & 0xC0u) != 0x80u) out += text[at] == '\n' ? '\n' : ' ';
    }
  }
  return out.append(text, at);
}

ChosenText::ChosenText(const SourceText& source, Defines defines, const Surroundings& surroundings,
                       core::Diagnostics& diagnostics, std::string_view pou)
    : text_(source.text()) {
  if (!may_choose(text_)) return;
  std::vector<Token> pragmas;
  Lexer lexer(text_, &pragmas);
  while (lexer.next().kind != TokenKind::kEnd) {
  }
  Chooser chooser(source, defines, &surroundings, diagnostics, pou);
  for (const Token& pragma : pragmas) chooser.pragma(pragma);
  chooser.finish();
  fine_ = chooser.fine();
  is_changed_ = !chooser.blanks().empty();
  if (is_changed_) changed_ = blanked(text_, chooser.blanks());
}

// ---- declarations -----------------------------------------------------------------------------------------------

namespace {

/// Where a token stands: among declarations, or in a body.
class Context {
 public:
  /// Whether `token`, which comes next, belongs to a body.
  [[nodiscard]] bool in_body(std::string_view token) const { return code_ && !section_ && !opens_section(token); }
  [[nodiscard]] bool in_code() const { return code_; }
  void pass(std::string_view word, bool named) {
    if (core::iequals(word, "END_VAR")) {
      section_ = false;
    } else if (opens_section(word)) {
      section_ = true;
    } else if (core::iequals(word, "CONFIGURATION") && named) {
      configuration_ = true;
    } else if (core::iequals(word, "END_CONFIGURATION")) {
      configuration_ = false;
    } else if (named && !configuration_ && is_one_of(word, kOpeners)) {
      code_ = true;
      section_ = false;
    } else if (is_one_of(word, kClosers)) {
      code_ = false;
      section_ = false;
    }
  }

 private:
  static constexpr std::string_view kOpeners[] = {"FUNCTION", "FUNCTION_BLOCK", "PROGRAM", "ACTION", "METHOD"};
  static constexpr std::string_view kClosers[] = {"END_FUNCTION", "END_FUNCTION_BLOCK", "END_PROGRAM", "END_ACTION",
                                                  "END_METHOD"};
  static bool is_one_of(std::string_view word, std::span<const std::string_view> words) {
    return std::any_of(words.begin(), words.end(), [&](std::string_view one) { return core::iequals(one, word); });
  }
  static bool opens_section(std::string_view word) {
    static constexpr std::string_view kSections[] = {"VAR",          "VAR_INPUT",  "VAR_OUTPUT", "VAR_IN_OUT",
                                                     "VAR_TEMP",     "VAR_GLOBAL", "VAR_ACCESS", "VAR_CONFIG",
                                                     "VAR_EXTERNAL", "VAR_INST",   "VAR_STAT",   "VAR_GENERIC"};
    return is_one_of(word, kSections);
  }
  bool code_ = false;
  bool section_ = false;
  bool configuration_ = false;
};

}  // namespace

DeclaredText::DeclaredText(const SourceText& source, Defines defines, core::Diagnostics& diagnostics)
    : text_(source.text()) {
  if (!may_choose(text_)) return;
  std::vector<Token> pragmas;
  Lexer lexer(text_, &pragmas);
  Chooser chooser(source, defines, nullptr, diagnostics, {});
  Context context;
  std::vector<std::pair<std::uint32_t, std::vector<std::string>>> noted;
  Defines outside = defines;
  std::size_t next_pragma = 0;
  std::uint32_t in_body = 0;  // {IF}s of a body that are open
  Token token = lexer.next();
  for (;;) {
    const std::size_t passed = pragmas.size();
    const Token ahead = token.kind == TokenKind::kEnd ? token : lexer.next();
    const std::string_view word = source.slice(token.begin, token.end);
    for (; next_pragma < passed; ++next_pragma) {
      const Token& pragma = pragmas[next_pragma];
      std::size_t rest = 0;
      const Directive directive = directive_of(source.slice(pragma.begin, pragma.end), rest);
      const bool of_body = chooser.active() && (in_body != 0 || context.in_body(word));
      if (directive == Directive::kIf && of_body) {
        ++in_body;
      } else if (directive == Directive::kEndIf && in_body != 0) {
        --in_body;
      } else if (in_body == 0 && !(of_body && (directive == Directive::kDefine || directive == Directive::kUndefine ||
                                               !chooser.open()))) {
        chooser.pragma(pragma);
        noted.emplace_back(pragma.end, defines.entries());
      }
    }
    if (token.kind == TokenKind::kEnd) break;
    if (chooser.active()) {
      const bool code = context.in_code();
      context.pass(token.kind == TokenKind::kIdentifier ? word : std::string_view{},
                   ahead.kind == TokenKind::kIdentifier);
      if (code != context.in_code()) {
        // What a POU defines is its own.
        code ? static_cast<void>(defines = outside) : static_cast<void>(outside = defines);
        noted.emplace_back(token.begin, defines.entries());
        in_body = 0;
      }
    }
    token = ahead;
  }
  chooser.finish();
  // Blanks may take less bytes than what was there.
  std::size_t range = 0;
  std::uint32_t shorter = 0;
  for (auto& [offset, entries] : noted) {
    for (; range < chooser.blanks().size() && chooser.blanks()[range].second <= offset; ++range) {
      const auto [begin, end] = chooser.blanks()[range];
      for (std::uint32_t i = begin; i < end; ++i) {
        if ((static_cast<unsigned char>(text_[i]) & 0xC0u) == 0x80u) ++shorter;
      }
    }
    defines_.emplace_back(offset - shorter, std::move(entries));
  }
  if (!chooser.blanks().empty()) changed_ = blanked(text_, chooser.blanks());
}

std::vector<std::string> DeclaredText::defines_at(std::uint32_t offset) const {
  const auto after = std::upper_bound(defines_.begin(), defines_.end(), offset,
                                      [](std::uint32_t at, const auto& entry) { return at < entry.first; });
  return after == defines_.begin() ? std::vector<std::string>{} : std::prev(after)->second;
}

}  // namespace plc::st
