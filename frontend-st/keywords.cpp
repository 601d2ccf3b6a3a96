#include "frontend-st/keywords.h"

#include <array>
#include <utility>

#include "core/text.h"

namespace plc::st {
namespace {

using Entry = std::pair<std::string_view, Keyword>;

constexpr Entry kKeywords[] = {
    {"AND", Keyword::kAnd},
    {"AND_THEN", Keyword::kAndThen},
    {"BY", Keyword::kBy},
    {"CASE", Keyword::kCase},
    {"CONTINUE", Keyword::kContinue},
    {"DO", Keyword::kDo},
    {"ELSE", Keyword::kElse},
    {"ELSIF", Keyword::kElsif},
    {"END_CASE", Keyword::kEndCase},
    {"END_FOR", Keyword::kEndFor},
    {"END_IF", Keyword::kEndIf},
    {"END_REPEAT", Keyword::kEndRepeat},
    {"END_WHILE", Keyword::kEndWhile},
    {"EXIT", Keyword::kExit},
    {"FALSE", Keyword::kFalse},
    {"FOR", Keyword::kFor},
    {"IF", Keyword::kIf},
    {"MOD", Keyword::kMod},
    {"NOT", Keyword::kNot},
    {"OF", Keyword::kOf},
    {"OR", Keyword::kOr},
    {"OR_ELSE", Keyword::kOrElse},
    {"REPEAT", Keyword::kRepeat},
    {"RETURN", Keyword::kReturn},
    {"THEN", Keyword::kThen},
    {"TO", Keyword::kTo},
    {"TRUE", Keyword::kTrue},
    {"UNTIL", Keyword::kUntil},
    {"WHILE", Keyword::kWhile},
    {"XOR", Keyword::kXor},
};
constexpr std::size_t kLongest = 10;

}  // namespace

Keyword keyword_of(std::string_view word) {
  if (word.size() < 2 || word.size() > kLongest) return Keyword::kNone;
  const char first = core::upper(word[0]);
  for (const auto& [text, keyword] : kKeywords) {
    if (text[0] == first && text.size() == word.size() && core::iequals(text, word)) return keyword;
  }
  return Keyword::kNone;
}

}  // namespace plc::st
