// Keywords of statements and expressions (IEC 61131-3:2013, 7.3): what cannot be a name inside a body.
//
// In: the text of an identifier token. Out: which keyword it is, if any. Does not belong here: keywords of
// declarations, which are ordinary names inside a body.
#pragma once

#include <cstdint>
#include <string_view>

namespace plc::st {

enum class Keyword : std::uint8_t {
  kNone,
  kAnd,
  kAndThen,
  kBy,
  kCase,
  kContinue,
  kDo,
  kElse,
  kElsif,
  kEndCase,
  kEndFor,
  kEndIf,
  kEndRepeat,
  kEndWhile,
  kExit,
  kFalse,
  kFor,
  kIf,
  kMod,
  kNot,
  kOf,
  kOr,
  kOrElse,
  kRepeat,
  kReturn,
  kThen,
  kTo,
  kTrue,
  kUntil,
  kWhile,
  kXor,
};

/// The keyword that `word` spells in any letter case, or kNone.
Keyword keyword_of(std::string_view word);

}  // namespace plc::st
