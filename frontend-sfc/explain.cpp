#include "frontend-sfc/explain.h"

#include <fmt/format.h>

#include <algorithm>

#include "frontend-sfc/chart.h"
#include "frontend-sfc/plan.h"

namespace plc::sfc {

namespace {

std::string names_of(const Chart& chart, const std::vector<std::uint32_t>& steps) {
  std::string text;
  for (const std::uint32_t step : steps) text += (text.empty() ? "" : ", ") + chart.steps[step].name;
  return text;
}

std::string condition_of(const Condition& condition) {
  switch (condition.kind) {
    case Condition::Kind::kText:
    case Condition::Kind::kInstructions:
      return condition.negated ? "NOT (" + condition.text + ")" : condition.text;
    case Condition::Kind::kReference:
      return (condition.negated ? "NOT transition " : "transition ") + condition.text;
    case Condition::Kind::kWire:
      return "what is wired to it";
    case Condition::Kind::kMissing:
      break;
  }
  return "nothing";
}

std::string place_of(const core::SourceRef& at) {
  return at.local_id >= 0 ? fmt::format("{} {}, line {}", core::element_word(at.kind), at.local_id, at.line)
                          : fmt::format("line {}", at.line);
}

void add_action(std::vector<std::string>& lines, const char* when, const std::string& name) {
  if (!name.empty()) lines.push_back(fmt::format("      {} {}", when, name));
}

}  // namespace

std::vector<std::string> explain_chart(const plcopen::Body& body, bool final_scan) {
  core::Diagnostics quiet;
  const Chart chart = read_chart(body, {}, quiet);
  const Plan plan = make_plan(chart);
  std::vector<std::string> lines;
  lines.push_back(fmt::format("  acts, then tests; final scan of actions: {}", final_scan ? "on" : "off"));
  for (std::uint32_t s = 0; s < chart.steps.size(); ++s) {
    const Step& step = chart.steps[s];
    lines.push_back(fmt::format("  step {}{}  ({})", step.name, step.initial ? ", initial" : "", place_of(step.at)));
    add_action(lines, "entry", step.entry);
    add_action(lines, "main", step.main);
    for (const Association& action : step.actions) {
      lines.push_back(fmt::format("      {} {}{}", qualifier_word(action.qualifier),
                                  action.name.empty() ? std::string("ST written here") : action.name,
                                  action.duration.empty() ? std::string() : ", " + action.duration));
    }
    add_action(lines, "exit", step.exit);
    add_action(lines, "not left before", step.min_time);
    add_action(lines, "an error after", step.max_time);
    std::uint32_t place = 0;
    for (const std::uint32_t t : plan.choices[s]) {
      const Transition& transition = chart.transitions[t];
      std::string with;
      for (const auto& set : transition.sources) {
        if (set.size() < 2 || std::find(set.begin(), set.end(), s) == set.end()) continue;
        with = " from " + names_of(chart, set);
        break;
      }
      lines.push_back(fmt::format("    {}.{} to {} when {}{}  ({})", ++place, with, names_of(chart, transition.targets),
                                  condition_of(transition.condition),
                                  transition.priority >= 0 ? fmt::format(", priority {}", transition.priority) : "",
                                  place_of(transition.at)));
    }
  }
  return lines;
}

}  // namespace plc::sfc
