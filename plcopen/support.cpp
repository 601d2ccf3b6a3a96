#include "plcopen/support.h"

#include "plcopen/account.h"
#include "plcopen/rules.h"

namespace plc::plcopen {

namespace {

std::string_view fate_word(Fate fate) {
  switch (fate) {
    case Fate::kUsed:
      return "used";
    case Fate::kPreserved:
      return "preserved";
    case Fate::kIgnored:
      return "ignored";
    case Fate::kRefused:
      return "refused";
  }
  return "";
}

std::string element_text(const Rule& rule) {
  if (rule.name == "*") return "any other";
  std::string text = '`' + std::string(rule.name);
  if (!rule.variant.empty()) {
    text += rule.variant.front() == '/' ? " name=\".." : " xsi:type=\"";
    text += rule.variant;
    text += '"';
  }
  return text + '`';
}

}  // namespace

std::string support_tables() {
  std::string out;
  State open = State::kSkip;
  // Rows of one place may be in several tables of the source: gather them by state.
  for (std::size_t s = 0; s <= static_cast<std::size_t>(State::kSkip); ++s) {
    const auto state = static_cast<State>(s);
    for (const Rule& rule : all_rules()) {
      if (rule.parent != state || rule.inherit) continue;
      if (open != state) {
        open = state;
        out += "\n### In " + std::string(state_title(state)) + "\n\n| element | fate | note |\n| --- | --- | --- |\n";
      }
      out += "| " + element_text(rule) + " | " + std::string(fate_word(rule.fate)) + " | " + std::string(rule.reason) +
             " |\n";
    }
  }
  return out;
}

}  // namespace plc::plcopen
