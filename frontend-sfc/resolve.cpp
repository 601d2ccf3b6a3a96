#include "frontend-sfc/resolve.h"

#include <algorithm>

#include "core/guess.h"
#include "core/text.h"
#include "frontend-st/names.h"
#include "frontend-st/text.h"

namespace plc::sfc {

using core::Code;

namespace {

/// The name before the first member, index or dereference.
std::string_view root_of(std::string_view path) { return core::trimmed(path.substr(0, path.find_first_of(".[^"))); }

bool is_known(const ir::Module& module, const ir::Pou& pou, std::string_view name) {
  if (name.starts_with('%')) return true;
  const std::string_view root = root_of(name);
  if (st::find_name(module, pou, root).kind != st::Named::Kind::kNothing) return true;
  if (st::find_program(module, root)) return true;
  // A variable of a list of globals.
  return std::any_of(module.globals.begin(), module.globals.end(), [&](const ir::Global& global) {
    return core::iequals(global.list, root) || core::iequals(global.prefix, root);
  });
}

}  // namespace

Target resolve(const ir::Module& module, const ir::Pou& pou, const std::string& name, const Step& step,
               const core::SourceRef& at, bool actions_only, core::Diagnostics& diagnostics) {
  Target target;
  target.name = name;
  target.at = at;
  if (const auto own = pou.actions.find(name); own != pou.actions.end()) {
    target.kind = Target::Kind::kAction;
    target.action = own->second;
    return target;
  }
  const bool plain = name.find('.') == std::string::npos;
  if (!plain && st::find_action(module, pou, name)) {
    target.kind = Target::Kind::kPath;
    return target;
  }
  if (!actions_only && st::is_variable_text(name) && is_known(module, pou, name)) {
    target.kind = Target::Kind::kVariable;
    return target;
  }
  core::Guess guess(name);
  for (const auto& [action, index] : pou.actions) {
    if (action.find('#') == std::string::npos) guess.offer(action);
  }
  if (!actions_only) {
    for (const ir::Variable& variable : pou.variables) {
      if (variable.type == ir::kBoolType && variable.role != ir::Role::kHidden) guess.offer(variable.name);
    }
  }
  std::string help = guess.help();
  if (help.empty()) help = "declare a BOOL variable, or add an action of this name to the POU";
  diagnostics.report(Code::P3106, at, pou.name, "action \"" + name + "\" of step \"" + step.name + "\" does not exist",
                     std::move(help));
  return target;
}

std::string key_of(const Target& target) {
  if (target.kind == Target::Kind::kAction) return "#" + std::to_string(target.action);
  std::string key = core::folded(target.name);
  std::erase_if(key, [](char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; });
  return key;
}

}  // namespace plc::sfc
