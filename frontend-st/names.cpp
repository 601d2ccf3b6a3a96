#include "frontend-st/names.h"

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
  if (global != module.global_by_name.end()) return {Named::Kind::kGlobal, global->second};
  return {module.refused.contains(name) ? Named::Kind::kRefused : Named::Kind::kNothing};
}

EnumValueRef find_enum_value(const ir::TypeTable& types, ir::TypeRef type, std::string_view name) {
  const ir::Type& t = types[type];
  if (t.kind != ir::TypeKind::kEnum) return {};
  const auto position = types.position_of(type, name);
  return position ? EnumValueRef{type, t.members[*position].value} : EnumValueRef{};
}

std::vector<EnumValueRef> find_enum_values(const ir::TypeTable& types, std::string_view name) {
  std::vector<EnumValueRef> out;
  for (const ir::TypeRef type : types.enumerations()) {
    const EnumValueRef one = find_enum_value(types, type, name);
    if (one.type.valid()) out.push_back(one);
  }
  return out;
}

}  // namespace plc::st
