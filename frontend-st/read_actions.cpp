// Actions of POUs: ACTION .. END_ACTION inside a POU, after it, or in ACTIONS .. END_ACTIONS. The body stays text, as
// that of a POU.
#include <algorithm>
#include <utility>

#include "core/text.h"
#include "frontend-st/declaration_reader.h"

namespace plc::st {

using core::Code;
using plcopen::Fate;

/// At ACTION, with a name after it. `owner` is the POU it is in or after; "ACTION Pump.Start" names another.
void DeclarationReader::action(const std::string& owner) {
  const Token opener = token_;
  advance();
  PendingAction out{owner, {}};
  out.action.at = place(token_.begin);
  bool named = name(out.action.name, "the name of the ACTION");
  if (named && accept(TokenKind::kDot)) {
    out.owner = std::exchange(out.action.name, {});
    out.action.at = place(token_.begin);
    named = name(out.action.name, "the name of the ACTION");
  }
  accept(TokenKind::kColon);
  const std::string before =
      std::exchange(pou_, out.owner.empty() ? out.action.name : out.owner + "." + out.action.name);
  const bool in_body = std::exchange(in_body_, true);
  action_body(out.action, opener);
  in_body_ = in_body;
  pou_ = before;
  count("ACTION", Fate::kUsed, place(opener.begin));
  if (named) actions_.push_back(std::move(out));
}

void DeclarationReader::action_body(plcopen::Pou& action, const Token& opener) {
  const std::string label = "ACTION" + (action.name.empty() ? "" : " \"" + action.name + '"');
  plcopen::Body& body = action.bodies.emplace_back();
  const std::uint32_t begin = first_choice(last_end_, token_.begin, token_.begin);
  const std::uint32_t lead = first_comment(last_end_, begin);
  std::uint32_t text_end = begin;
  std::uint32_t end_at = begin;
  body.language = language();
  body.at = body.text_at = place(begin, core::ElementKind::kText);
  body.defines = defines_at(begin);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> blanks;
  TokenKind before = TokenKind::kEnd;
  bool closed = false;
  while (!at(TokenKind::kEnd) && !closed) {
    const Word word = before == TokenKind::kDot ? Word::kNone : word_of(token_);
    if (word == Word::kEndAction) {
      closed = true;
      end_at = token_.begin;
      advance();
      accept(TokenKind::kSemicolon);
      break;
    }
    const bool another = word == Word::kAction && peek(1).kind == TokenKind::kIdentifier;
    const bool ends = word == Word::kEndFunctionBlock || word == Word::kEndProgram || word == Word::kEndFunction ||
                      word == Word::kEndActions;
    if (another || ends || (word != Word::kNone && opens_another())) break;
    if (is_section(word)) {
      fail(Code::P4045, token_, "variables are declared in " + label + ", which has none of its own",
           "declare them in the POU: an action works on its variables");
      const std::uint32_t here = token_.begin;
      skip_to(Word::kEndVar);
      blanks.emplace_back(here, last_end_);
      before = TokenKind::kEnd;
    } else {
      before = token_.kind;
      advance();
    }
    text_end = last_end_;
  }
  text_end = last_choice(text_end, closed ? end_at : token_.begin, text_end);
  if (text_end > begin) text_end = last_comment(text_end, closed ? end_at : token_.begin);
  bodies_.emplace_back(begin, text_end);
  body.text = source_.slice(begin, text_end);
  keep_lead(body, lead, begin);
  if (body.text.empty()) body.language = plcopen::Language::kNone;
  for (const auto& [first, last] : blanks) {
    std::replace_if(
        body.text.begin() + (first - begin), body.text.begin() + (last - begin), [](char c) { return c != '\n'; }, ' ');
  }
  if (body.language == plcopen::Language::kSfc) body.drawn_elements = 1;
  if (!closed) fail_unclosed(label, opener, "END_ACTION");
}

/// ACTIONS Pump .. END_ACTIONS; without a name those of the POU before.
void DeclarationReader::actions() {
  const Token opener = token_;
  advance();
  std::string owner = project_.pous.empty() ? std::string() : project_.pous.back().name;
  if (at(TokenKind::kIdentifier) && word_of(token_) == Word::kNone) name(owner, "the name of a POU");
  accept(TokenKind::kColon);
  while (!at(TokenKind::kEnd)) {
    const Word word = word_of(token_);
    if (word == Word::kAction && peek(1).kind == TokenKind::kIdentifier) {
      action(owner);
    } else if (word == Word::kEndActions) {
      advance();
      accept(TokenKind::kSemicolon);
      return;
    } else if (!accept(TokenKind::kSemicolon)) {
      break;
    }
  }
  if (at(TokenKind::kEnd) || opens_another()) {
    fail_unclosed("ACTIONS \"" + owner + '"', opener, "END_ACTIONS");
    return;
  }
  fail_expected("ACTION or END_ACTIONS");
  skip_to(Word::kEndActions);
}

/// Gives every action to its POU, once all POUs of the text are known.
void DeclarationReader::give_actions() {
  for (PendingAction& one : actions_) {
    const auto owner = std::find_if(project_.pous.rbegin(), project_.pous.rend(),
                                    [&](const plcopen::Pou& pou) { return core::iequals(pou.name, one.owner); });
    if (owner != project_.pous.rend()) {
      owner->actions.push_back(std::move(one.action));
      continue;
    }
    std::string message = "action \"" + one.action.name + '"';
    message += one.owner.empty() ? " comes before all POUs" : " is one of \"" + one.owner + "\", which is no POU";
    if (!exhausted_) {
      diagnostics_.report(Code::P4050, one.action.at, one.action.name, std::move(message),
                          "write it in its POU, after it, or in ACTIONS <POU> .. END_ACTIONS");
    }
  }
  actions_.clear();
}

}  // namespace plc::st
