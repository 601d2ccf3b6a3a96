// Lint of names: a local variable that hides something else a reader of the body may mean.
//
// Inputs, outputs and in-outs are left out: a block has its interface for itself, and "Start" is a good name there. So
// are names of standard functions and types: a variable called Limit does not hide LIMIT( .. ).
#include <fmt/format.h>

#include <unordered_map>

#include "core/text.h"
#include "ir/lint_findings.h"

namespace plc::ir {
namespace {

using EnumMembers = std::unordered_map<std::string_view, TypeRef, core::NameHash, core::NameEqual>;

EnumMembers members_of(const TypeTable& types) {
  EnumMembers all;
  for (const TypeRef ref : types.enumerations()) {
    for (const EnumMember& member : types[ref].members) all.emplace(member.name, ref);
  }
  return all;
}

/// True when `type` is, or holds, instances of `pou`: "Pump : Pump" names the same thing twice.
bool is_instance_of(const TypeTable& types, TypeRef type, std::uint32_t pou) {
  while (types[type].kind == TypeKind::kArray) type = types[type].element;
  return types[type].kind == TypeKind::kPou && types[type].pou == pou;
}

std::string place_of(const SourceRef& at) { return at.line == 0 ? "" : fmt::format(" (line {})", at.line); }

}  // namespace

void lint_names(const Module& module, Findings& findings) {
  if (!findings.wants(Lint::kShadowedName)) return;
  const EnumMembers members = members_of(module.types);
  for (const Pou& pou : module.pous) {
    if (!findings.is_linted(pou)) continue;
    for (const Variable& v : pou.variables) {
      const bool local = v.role == Role::kLocal || v.role == Role::kTemp;
      if (!local || !is_visible(v)) continue;
      const auto add = [&](std::string what) {
        findings.add(Lint::kShadowedName, v.at, pou.name,
                     fmt::format("local variable {} hides {}", quoted(v.name), what),
                     "in this POU the name means the local variable; rename one of them");
      };
      const auto global = module.global_by_name.find(v.name);
      const auto other = module.pou_by_name.find(v.name);
      const auto member = members.find(v.name);
      // A library has hundreds of names that the project does not mean.
      const auto hides = [&](bool of_library) { return !findings.skips_library(of_library); };
      if (global != module.global_by_name.end() && hides(module.globals[global->second].from_library)) {
        add("the global variable of this name" + place_of(module.globals[global->second].variable.at));
      } else if (other != module.pou_by_name.end() && hides(module.pous[other->second].from_library) &&
                 !is_instance_of(module.types, v.type, other->second)) {
        add("the POU of this name" + place_of(module.pous[other->second].at));
      } else if (member != members.end() && hides(module.types[member->second].from_library)) {
        add("a value of the enumeration " + module.types.name_of(member->second));
      }
    }
  }
}

}  // namespace plc::ir
