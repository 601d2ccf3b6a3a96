#include "io-drivers/config/read_alarms.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <unordered_set>

#include "core/text.h"
#include "io-drivers/config/table_file.h"

namespace plc::io {
namespace {

using alarms::Comparison;
using alarms::Definition;
using core::Code;
using namespace key;

constexpr KeyInfo kKeys[] = {
    {"variable", text(), required("\"Level\""), "Path of a BOOL, a number, a duration or an enumeration."},
    {"text", text(), required("\"Level is too high\""), "What has happened, for people."},
    {"name", text(), otherwise("\"\""), "What calls and the history name it by. Empty: the variable."},
    {"above", value(), nothing("90.0"), "It holds while the value is greater; durations in seconds."},
    {"below", value(), nothing("5.0"), "It holds while the value is less."},
    {"equal", value(), nothing("3"), "It holds while the value is this one."},
    {"unequal", value(), nothing("0"), "It holds while the value is another one."},
    {"when", boolean(), nothing("false"), "It holds while a BOOL is this; without any of these five keys: TRUE."},
    {"hysteresis", value(), otherwise("0"),
     "With above and below: it ends when the value is that far on the good side of the limit."},
    {"on_delay", duration("0s", "24h"), otherwise("\"0s\""), "The condition has to hold so long."},
    {"off_delay", duration("0s", "24h"), otherwise("\"0s\""), "It has to be gone so long."},
    {"latch", boolean(), otherwise("false"),
     "It stays until somebody has acknowledged it, even when the condition is gone."},
    {"priority", choice("low|medium|high|critical"), otherwise("\"medium\""), "How soon somebody has to act."},
    {"class", text(), otherwise("\"\""), "What it is about: \"process\", \"drive\"."},
    {"help", text(), otherwise("\"\""), "What to do."},
    {"group", text(), otherwise("\"\""),
     "Alarms of one group are numbered in the order of their scans: which one was first?"},
    {"suppress", text(), otherwise("\"\""),
     "Path of a BOOL: while it is TRUE, the alarm has no meaning and is not shown."},
};
constexpr FileTable kTables[] = {{"alarm", kKeys, true}};

/// The condition; false and reported when it is none.
bool read_condition(const ReadTable& row, Definition& to, core::Diagnostics& diagnostics) {
  struct Key {
    std::string_view name;
    Comparison comparison;
  };
  constexpr Key kComparisons[] = {{"above", Comparison::kAbove},
                                  {"below", Comparison::kBelow},
                                  {"equal", Comparison::kEqual},
                                  {"unequal", Comparison::kUnequal},
                                  {"when", Comparison::kTrue}};
  const auto number = [](const std::string& text) {
    return core::iequals(text, "true") ? 1.0 : std::strtod(text.c_str(), nullptr);
  };
  std::string_view first;
  for (const Key& key : kComparisons) {
    if (!row.values.has(key.name)) continue;
    if (!first.empty()) {
      diagnostics.report(Code::P7311, row.values.place(key.name, row.at), {},
                         fmt::format("\"{}\" and \"{}\" are two conditions", first, key.name),
                         "take one out; two conditions are two alarms");
      return false;
    }
    first = key.name;
    to.comparison = key.comparison;
    const std::string text = row.values.text(key.name);
    to.limit = number(text);
    const bool compares = key.comparison == Comparison::kAbove || key.comparison == Comparison::kBelow;
    if (compares && (text == "true" || text == "false")) {
      diagnostics.report(Code::P7304, row.values.place(key.name, row.at), {},
                         fmt::format("\"{}\" takes a number, not {}", key.name, text),
                         "of a BOOL \"when\" says which value it is");
      return false;
    }
    if (!std::isfinite(to.limit)) {
      diagnostics.report(Code::P7305, row.values.place(key.name, row.at), {},
                         fmt::format("\"{}\" is {}: the condition never changes", key.name, text));
      return false;
    }
  }
  if (to.comparison == Comparison::kTrue && first == "when" && to.limit == 0) to.comparison = Comparison::kFalse;
  to.hysteresis = number(row.values.text("hysteresis"));
  const bool analog = to.comparison == Comparison::kAbove || to.comparison == Comparison::kBelow;
  if (!(to.hysteresis >= 0) || !std::isfinite(to.hysteresis)) {
    diagnostics.report(Code::P7305, row.values.place("hysteresis", row.at), {},
                       to.hysteresis < 0 ? "\"hysteresis\" is less than 0" : "\"hysteresis\" is no number");
    return false;
  }
  if (row.values.has("hysteresis") && !analog) {
    diagnostics.report(Code::P7307, row.values.place("hysteresis", row.at), {},
                       "\"hysteresis\" belongs to \"above\" and \"below\"",
                       "take it out; on_delay and off_delay serve all");
    return false;
  }
  return true;
}

}  // namespace

std::span<const KeyInfo> alarm_keys() { return kKeys; }

std::vector<Definition> read_alarms(std::string_view text, std::string_view file, core::Diagnostics& diagnostics) {
  std::vector<Definition> all;
  std::unordered_set<std::string> names;
  for (const ReadTable& row : read_table_file(text, file, kTables, diagnostics)) {
    Definition alarm;
    alarm.at = row.at;
    alarm.variable = row.values.text("variable");
    alarm.name = row.values.text("name").empty() ? alarm.variable : row.values.text("name");
    alarm.text = row.values.text("text");
    alarm.on_delay_ns = row.values.number("on_delay");
    alarm.off_delay_ns = row.values.number("off_delay");
    alarm.latch = row.values.flag("latch");
    alarm.priority = row.values.choice<alarms::Priority>("priority");
    alarm.category = row.values.text("class");
    alarm.help = row.values.text("help");
    alarm.group = row.values.text("group");
    alarm.suppress = row.values.text("suppress");
    if (!read_condition(row, alarm, diagnostics)) continue;
    if (!names.insert(core::folded(alarm.name)).second) {
      diagnostics.report(Code::P7309, row.at, {}, fmt::format("there are two alarms \"{}\"", alarm.name),
                         "give this one another name = \"..\"");
      continue;
    }
    all.push_back(std::move(alarm));
  }
  return all;
}

}  // namespace plc::io
