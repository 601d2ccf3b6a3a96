#include "frontend-st/suggestions.h"

#include <cstdint>
#include <utility>

#include "core/guess.h"
#include "core/text.h"
#include "frontend-st/lexer.h"
#include "stdlib/library.h"
#include "stdlib/specials.h"

namespace plc::st {
namespace {

/// Types as other languages and hurried people write them.
constexpr std::pair<std::string_view, std::string_view> kTypeWords[] = {
    {"STR", "STRING"},   {"WSTR", "WSTRING"},  {"DW", "DWORD"},      {"W", "WORD"},        {"B", "BYTE"},
    {"BOOLEAN", "BOOL"}, {"BIT", "BOOL"},      {"FLOAT", "REAL"},    {"FLOAT32", "REAL"},  {"SINGLE", "REAL"},
    {"DOUBLE", "LREAL"}, {"FLOAT64", "LREAL"}, {"INTEGER", "INT"},   {"SHORT", "INT"},     {"LONG", "DINT"},
    {"INT8", "SINT"},    {"INT16", "INT"},     {"INT32", "DINT"},    {"INT64", "LINT"},    {"UINT8", "USINT"},
    {"UINT16", "UINT"},  {"UINT32", "UDINT"},  {"UINT64", "ULINT"},  {"TEXT", "STRING"},   {"DATETIME", "DT"},
    {"DATE_TIME", "DT"}, {"TIMEOFDAY", "TOD"}, {"UDINT32", "UDINT"}, {"LONGLONG", "LINT"},
};

std::string type_meant(std::string_view word) {
  if (core::type_named(word)) return core::uppered(word);
  for (const auto& [written, type] : kTypeWords) {
    if (core::iequals(written, word)) return std::string(type);
  }
  core::Guess guess(word);
  for (std::size_t i = 0; i < core::kTypeCount; ++i) guess.offer(core::name_of(static_cast<core::TypeId>(i)));
  return guess.best();
}

/// "INT_TO_STR" means INT_TO_STRING, whatever name is nearer by its letters.
std::string conversion_meant(std::string_view name) {
  const std::string upper = core::uppered(name);
  const bool from_any = upper.starts_with("TO_");
  const std::size_t to = from_any ? 0 : upper.find("_TO_");
  if (to == std::string::npos) return {};
  const std::string from = from_any ? "" : type_meant(std::string_view(name).substr(0, to));
  const std::string target = type_meant(std::string_view(name).substr(to + (from_any ? 3 : 4)));
  if (target.empty() || (!from_any && from.empty())) return {};
  const std::string meant = (from_any ? "" : from + "_") + "TO_" + target;
  return !core::iequals(meant, name) && stdlib::is_function(meant) ? meant : std::string{};
}

void offer_functions(const ir::Module& module, bool drawn, core::Guess& guess) {
  for (const ir::Pou& pou : module.pous) {
    if (pou.kind == ir::PouKind::kFunction || (drawn && pou.kind == ir::PouKind::kFunctionBlock)) guess.offer(pou.name);
  }
  for (const stdlib::FunctionSpec* spec : stdlib::function_specs()) {
    if (!stdlib::is_bundle_output(*spec)) guess.offer(spec->name);
  }
  for (const stdlib::BundleSpec& bundle : stdlib::bundles()) guess.offer(bundle.name);
  for (const stdlib::SpecialSpec& special : stdlib::specials()) {
    if (drawn || !special.drawn_only) guess.offer(special.name);
  }
}

struct Foreign {
  std::string_view written;
  std::string_view help;  ///< empty: ST has it, and it is right or wrong for other reasons
};

constexpr std::string_view kCopy = "assign arrays and structures as a whole, or copy their elements in a loop";
constexpr std::string_view kFill = "write the elements in a loop";
constexpr std::string_view kCompareAll = "compare the elements in a loop";
constexpr std::string_view kRising = "declare an R_TRIG, call it with CLK := the signal and read its Q";
constexpr std::string_view kFalling = "declare an F_TRIG, call it with CLK := the signal and read its Q";
constexpr std::string_view kPowerOf = "a power is EXPT(base, exponent) or base ** exponent";
constexpr std::string_view kRounds = "REAL_TO_DINT and its like round to the nearest, TRUNC cuts towards zero";

/// Functions of other tools and languages.
constexpr Foreign kFunctions[] = {
    {"MEMCPY", kCopy},
    {"MEMMOVE", kCopy},
    {"SYSMEMCPY", kCopy},
    {"SYSMEMMOVE", kCopy},
    {"MEMSET", kFill},
    {"SYSMEMSET", kFill},
    {"MEMCMP", kCompareAll},
    {"SYSMEMCMP", kCompareAll},
    {"RE", kRising},
    {"FE", kFalling},
    {"EDGEPOS", kRising},
    {"EDGENEG", kFalling},
    {"INC", "write x := x + 1"},
    {"DEC", "write x := x - 1"},
    {"SET", "write x := TRUE, or x S= condition"},
    {"RESET", "write x := FALSE, or x R= condition"},
    {"POW", kPowerOf},
    {"POWER", kPowerOf},
    {"FLOOR", kRounds},
    {"CEIL", kRounds},
    {"ROUND", kRounds},
    {"IIF", "a choice is SEL(G := condition, IN0 := value if FALSE, IN1 := value if TRUE)"},
    {"STRLEN", "the length of a text is LEN(text)"},
};

// Longer ones first: what is read is the longest that fits.
constexpr Foreign kOperators[] = {
    {"===", "\"equal\" is written ="},
    {"!==", "\"not equal\" is written <>"},
    {"==", "\"equal\" is written ="},
    {"!=", "\"not equal\" is written <>"},
    {"=<", "\"less or equal\" is written <="},
    {"=>", "\"greater or equal\" is written >=; => gives an output of a call to a variable"},
    {"&&", "\"and\" is written AND, or AND_THEN where the right side is not to be evaluated after a FALSE"},
    {"||", "\"or\" is written OR, or OR_ELSE where the right side is not to be evaluated after a TRUE"},
    {"<<", "shifting to the left is a function: SHL(IN := x, N := 3)"},
    {">>", "shifting to the right is a function: SHR(IN := x, N := 3)"},
    {"++", "write x := x + 1"},
    {"--", "write x := x - 1"},
    {"+=", "write x := x + .."},
    {"-=", "write x := x - .."},
    {"*=", "write x := x * .."},
    {"/=", "write x := x / .., and \"not equal\" as <>"},
    {"|=", "write x := x OR .."},
    {"&=", "write x := x AND .."},
    {":=", ":= assigns, and comes after the variable of a statement; \"equal\" is written ="},
    {"<>", {}},
    {"<=", {}},
    {">=", {}},
    {"**", {}},
    {"!", "\"not\" is written NOT"},
    {"~", "\"not\" is written NOT"},
    {"|", "\"or\" is written OR"},
    {"%", "the remainder of a division is written MOD"},
    {"?", "a choice is a function: SEL(G := condition, IN0 := value if FALSE, IN1 := value if TRUE)"},
};

bool is_operator_character(char c) { return std::string_view("=!<>&|:+-*/%~?").find(c) != std::string_view::npos; }

/// "%IX0.0", which is no remainder.
bool is_address(std::string_view text) {
  if (text.size() < 3 || text[0] != '%') return false;
  const char area = core::upper(text[1]);
  return (area == 'I' || area == 'Q' || area == 'M') &&
         (is_digit(text[2]) || is_identifier_start(text[2]) || text[2] == '*');
}

}  // namespace

std::string function_meant(const ir::Module& module, const ir::Pou& caller, std::string_view name) {
  const std::string conversion = conversion_meant(name);
  if (!conversion.empty()) return "did you mean \"" + conversion + "\"?";
  for (const Foreign& one : kFunctions) {
    if (core::iequals(one.written, name)) return std::string(one.help);
  }
  core::Guess guess(name);
  for (const auto& [action, index] : caller.actions) guess.offer(action);
  for (const ir::Pou& pou : module.pous) {
    if (pou.kind == ir::PouKind::kProgram && pou.owner == ir::Pou::kDeclared) guess.offer(pou.name);
  }
  offer_functions(module, false, guess);
  return guess.help();
}

std::string block_meant(const ir::Module& module, std::string_view name) {
  const std::string conversion = conversion_meant(name);
  if (!conversion.empty()) return "did you mean \"" + conversion + "\"?";
  core::Guess guess(name);
  offer_functions(module, true, guess);
  for (const stdlib::BlockSpec& block : stdlib::blocks()) guess.offer(block.name);
  return guess.help();
}

std::string operator_meant(std::string_view text, std::size_t position) {
  if (position >= text.size() || !is_operator_character(text[position]) || is_address(text.substr(position))) return {};
  std::size_t begin = position;
  while (begin > 0 && is_operator_character(text[begin - 1])) --begin;
  while (begin <= position) {
    const Foreign* found = nullptr;
    for (const Foreign& one : kOperators) {
      if (found == nullptr && text.substr(begin).starts_with(one.written)) found = &one;
    }
    const std::size_t end = begin + (found == nullptr ? 1 : found->written.size());
    if (position < end) return found == nullptr ? std::string{} : std::string(found->help);
    begin = end;
  }
  return {};
}

}  // namespace plc::st
