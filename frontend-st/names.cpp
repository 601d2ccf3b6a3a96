#include "frontend-st/names.h"

#include <algorithm>

#include "core/text.h"

namespace plc::st {

Named find_name(const ir::Module& module, const ir::Pou& pou, std::string_view name) {
  const auto local = pou.by_name.find(name);
  if (local != pou.by_name.end()) {
    const auto edge = pou.edges.find(local->second);
    return {Named::Kind::kVariable, edge == pou.edges.end() ? local->second : edge->second};
  }
  if (pou.refused.contains(name)) return {Named::Kind::kRefused};
  const auto global = module.global_by_name.find(name);
  if (global != module.global_by_name.end()) {
    // A library's global does not hide the values of the project's enumerations.
    const bool gives_way = module.globals[global->second].from_library && !module.library.at(pou.at) &&
                           is_project_enum_value(module.types, name);
    return gives_way ? Named{} : Named{Named::Kind::kGlobal, global->second};
  }
  return {module.refused.contains(name) ? Named::Kind::kRefused : Named::Kind::kNothing};
}

bool is_project_enum_value(const ir::TypeTable& types, std::string_view name) {
  const std::vector<ir::TypeRef>& all = types.enumerations();
  return std::any_of(all.begin(), all.end(), [&](ir::TypeRef type) {
    return !types[type].from_library && types.position_of(type, name);
  });
}

EnumValueRef find_enum_value(const ir::TypeTable& types, ir::TypeRef type, std::string_view name) {
  const ir::Type& t = types[type];
  if (t.kind != ir::TypeKind::kEnum) return {};
  const auto position = types.position_of(type, name);
  return position ? EnumValueRef{type, t.members[*position].value} : EnumValueRef{};
}

std::vector<EnumValueRef> find_enum_values(const ir::TypeTable& types, std::string_view name, bool in_library) {
  std::vector<EnumValueRef> out;
  for (const ir::TypeRef type : types.enumerations()) {
    const EnumValueRef one = find_enum_value(types, type, name);
    if (one.type.valid()) out.push_back(one);
  }
  const auto elsewhere = [&](const EnumValueRef& one) { return types[one.type].from_library != in_library; };
  if (!std::all_of(out.begin(), out.end(), elsewhere)) std::erase_if(out, elsewhere);
  return out;
}

}  // namespace plc::st
