// Lints of what declarations ask for: names and addresses.
#include <fmt/format.h>

#include <algorithm>

#include "core/text.h"
#include "ir/lint_findings.h"
#include "ir/reach.h"

namespace plc::ir {
namespace {

/// POUs that the tasks reach; all of them where no task runs anything.
std::vector<bool> running_pous(const Module& module) {
  std::vector<bool> running(module.pous.size());
  bool any = false;
  for (const Task& task : module.tasks) {
    for (const std::uint32_t pou : reached_pous(module, task)) {
      running[pou] = true;
      any = true;
    }
  }
  if (!any) running.assign(module.pous.size(), true);
  return running;
}

// Several POUs may share an address under one name: that is how texts without global variables do it. Under two names
// it is hard to see that a write undoes another.
void look_at_names(const Module& module, Findings& findings) {
  if (!findings.wants(Lint::kTwoNames)) return;
  const std::vector<bool> running = running_pous(module);
  for (const auto& [global, names] : module.written_names) {
    std::vector<const WrittenName*> different;
    for (const WrittenName& name : names) {
      const bool counts = running[name.pou] && findings.is_linted(module.pous[name.pou]);
      const bool known = std::any_of(different.begin(), different.end(),
                                     [&](const WrittenName* other) { return core::iequals(other->name, name.name); });
      if (counts && !known) different.push_back(&name);
    }
    if (different.size() < 2) continue;
    std::string list;
    for (std::size_t i = 0; i < different.size(); ++i) {
      const WrittenName& name = *different[i];
      list += i == 0 ? "" : i + 1 == different.size() ? " and " : ", ";
      list += fmt::format("{} ({}, line {})", quoted(name.name), module.pous[name.pou].name, name.at.line);
    }
    findings.add(
        Lint::kTwoNames, different.back()->at, module.pous[different.back()->pou].name,
        fmt::format("{} are one variable at {}, and all are written", list, module.globals[global].variable.address),
        "the last write in a scan wins; give each an address of its own, or use one of the names");
  }
}

/// "%IW0.1" has one number more than a word of the process image, "%IX0.0.1" one more than a bit.
bool has_numbers_too_many(std::string_view address) {
  if (address.size() < 3 || address.ends_with('*')) return false;
  const auto dots = std::count(address.begin(), address.end(), '.');
  return dots > (core::upper(address[2]) == 'X' ? 1 : 0);
}

void look_at_address(const Global& global, Findings& findings) {
  const Variable& v = global.variable;
  if (findings.skips_library(global.from_library) || !has_numbers_too_many(v.address)) return;
  const std::string whole = v.address.substr(0, v.address.find('.', v.address[2] == 'X' ? v.address.find('.') + 1 : 0));
  findings.add(Lint::kDottedAddress, v.at, {},
               fmt::format("{} is a place of its own, and no part of {}: HMIs find it at an automatic address",
                           v.address, whole),
               "plc map shows which; where one number is meant, write it like %IW0, %IW1 or %QD2");
}

}  // namespace

void lint_declarations(const Module& module, Findings& findings) {
  look_at_names(module, findings);
  for (const Global& global : module.globals) look_at_address(global, findings);
}

}  // namespace plc::ir
