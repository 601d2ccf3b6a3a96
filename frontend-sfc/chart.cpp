#include "frontend-sfc/chart.h"

#include <algorithm>
#include <iterator>

#include "core/text.h"

namespace plc::sfc {

using core::Code;

namespace {

struct QualifierRow {
  std::string_view word;
  bool timed;
};
constexpr QualifierRow kQualifiers[] = {
#define PLC_QUALIFIER(Name, word, timed) {word, timed},
#include "frontend-sfc/qualifiers.def"
};

}  // namespace

std::string_view qualifier_word(Qualifier qualifier) { return kQualifiers[static_cast<std::size_t>(qualifier)].word; }

bool needs_time(Qualifier qualifier) { return kQualifiers[static_cast<std::size_t>(qualifier)].timed; }

std::optional<Qualifier> qualifier_of(std::string_view word) {
  if (word.empty()) return Qualifier::kN;
  for (std::size_t i = 0; i < std::size(kQualifiers); ++i) {
    if (core::iequals(kQualifiers[i].word, word)) return static_cast<Qualifier>(i);
  }
  return std::nullopt;
}

void trim_condition(Condition& condition, std::string_view name) {
  const std::string_view all = condition.text;
  std::string_view text = core::trimmed(all);
  if (!name.empty() && text.size() > name.size() && core::iequals(text.substr(0, name.size()), name)) {
    const std::string_view rest = core::trimmed(text.substr(name.size()));
    if (rest.starts_with(":=")) text = rest;
  }
  if (text.starts_with(":=")) text = core::trimmed(text.substr(2));
  while (text.ends_with(';')) text = core::trimmed(text.substr(0, text.size() - 1));
  // What is cut off before the text moves its place, as far as it is in one line.
  const auto before = static_cast<std::size_t>(text.data() - all.data());
  const std::string_view cut = all.substr(0, text.empty() ? 0 : before);
  const std::size_t line = cut.rfind('\n');
  condition.at.line += static_cast<std::uint32_t>(std::count(cut.begin(), cut.end(), '\n'));
  condition.at.column = line == std::string_view::npos ? condition.at.column + static_cast<std::uint32_t>(cut.size())
                                                       : static_cast<std::uint32_t>(cut.size() - line);
  condition.text = std::string(text);
}

Chart read_chart(const plcopen::Body& body, const std::string& name, core::Diagnostics& diagnostics) {
  const std::size_t errors = diagnostics.error_count();
  Chart chart = body.text.empty() ? read_drawing(body, name, diagnostics) : read_text(body, name, diagnostics);
  chart.name = name;
  chart.flags = body.flags;
  chart.at = body.at;
  if (diagnostics.error_count() != errors) return chart;
  const bool begins = std::any_of(chart.steps.begin(), chart.steps.end(), [](const Step& s) { return s.initial; });
  if (!begins) {
    diagnostics.report(Code::P3101, chart.at, name, "chart has no initial step: nothing in it would ever be active",
                       "mark the step it begins with as the initial step");
  }
  return chart;
}

}  // namespace plc::sfc
