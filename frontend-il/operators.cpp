#include "frontend-il/operators.h"

#include "core/guess.h"
#include "core/text.h"

namespace plc::il {
namespace {

using enum st::Operator;

constexpr OperatorRow kRows[] = {
#define PLC_IL_OPERATOR(name, kind, op, modifiers, summary) {name, Kind::kind, op, modifiers, summary},
#include "frontend-il/operators.def"
};

}  // namespace

std::span<const OperatorRow> operator_rows() { return kRows; }

std::optional<Spelled> operator_named(std::string_view word) {
  for (const OperatorRow& row : kRows) {
    if (word.size() < row.name.size() || !core::iequals(word.substr(0, row.name.size()), row.name)) continue;
    const std::string_view rest = word.substr(row.name.size());
    if (rest.empty()) return Spelled{&row, false, Condition::kAlways};
    const bool n = core::iequals(rest, "N");
    if (n && row.takes(kC)) return Spelled{&row, false, Condition::kIfFalse};
    if (n && row.takes(kN)) return Spelled{&row, true, Condition::kAlways};
    if (row.takes(kC) && core::iequals(rest, "C")) return Spelled{&row, false, Condition::kIfTrue};
    if (row.takes(kC) && core::iequals(rest, "CN")) return Spelled{&row, false, Condition::kIfFalse};
  }
  return std::nullopt;
}

std::string operator_meant(std::string_view word) {
  core::Guess guess(word);
  for (const OperatorRow& row : kRows) {
    guess.offer(row.name);
    if (row.takes(kC)) {
      guess.offer(std::string(row.name) + "C");
      guess.offer(std::string(row.name) + "CN");
    } else if (row.takes(kN)) {
      guess.offer(std::string(row.name) + "N");
    }
  }
  return guess.help();
}

}  // namespace plc::il
