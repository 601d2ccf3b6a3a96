#include "doctor/examine.h"

#include <fmt/format.h>

#include <utility>

#include "doctor/check.h"

namespace plc::doctor {
namespace {

struct Row {
  core::Code code;
  std::string_view area, what;
  Outcome (*look)(const Context&);
};
constexpr Row kRows[] = {
#define PLC_CHECK(code, area, what, function) {core::Code::code, area, what, function},
#include "doctor/checks.def"
};

State state_of(const Found& found, core::Code code) {
  switch (found.severity.value_or(core::info(code).severity)) {
    case core::Severity::kNote:
      return State::kNote;
    case core::Severity::kWarning:
      return State::kWarning;
    case core::Severity::kError:
      return State::kProblem;
  }
  return State::kProblem;
}

}  // namespace

Outcome missing(const std::string& file) { return unknown(file + " is not there"); }

std::string_view state_word(State state) {
  constexpr std::string_view kWords[] = {"ok", "unknown", "note", "warning", "problem"};
  return kWords[static_cast<std::size_t>(state)];
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string list_text(const std::vector<int>& numbers) {
  std::string text;
  for (std::size_t i = 0; i < numbers.size();) {
    std::size_t last = i;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    if (!text.empty()) text += ',';
    text += std::to_string(numbers[i]);
    if (last > i) text += "-" + std::to_string(numbers[last]);
    i = last + 1;
  }
  return text;
}

std::vector<Line> examine(const System& system, std::string_view process_id, const Subject& subject) {
  const Process process(system, process_id);
  const Context context{system, process, subject};
  std::vector<Line> lines;
  for (const Row& row : kRows) {
    Outcome outcome = row.look(context);
    if (outcome.found.empty()) {
      lines.push_back(
          {row.area, row.what, outcome.known ? State::kOk : State::kUnknown, row.code, std::move(outcome.seen), {}});
    }
    for (Found& found : outcome.found) {
      const core::Code code = found.code.value_or(row.code);
      if (found.help.empty()) found.help = fmt::format("`plc explain {}` says more", core::info(code).name);
      lines.push_back({row.area, row.what, state_of(found, code), code, std::move(found.seen), std::move(found.help)});
    }
  }
  return lines;
}

}  // namespace plc::doctor
