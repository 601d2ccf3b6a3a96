#include "frontend-st/names.h"

#include <algorithm>

#include "core/text.h"
#include "stdlib/specials.h"

namespace plc::st {

Named find_name(const ir::Module& module, const ir::Pou& pou, std::string_view name) {
  if (name.starts_with('.')) {
    name.remove_prefix(1);
    const auto global = module.global_by_name.find(name);
    if (global != module.global_by_name.end()) return {Named::Kind::kGlobal, global->second};
    return {module.refused.contains(name) ? Named::Kind::kRefused : Named::Kind::kNothing};
  }
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
  return std::any_of(all.begin(), all.end(),
                     [&](ir::TypeRef type) { return !types[type].from_library && types.position_of(type, name); });
}

std::optional<std::uint32_t> find_program(const ir::Module& module, std::string_view name) {
  const auto found = module.pou_by_name.find(name);
  if (found == module.pou_by_name.end() || module.pous[found->second].kind != ir::PouKind::kProgram)
    return std::nullopt;
  return found->second;
}

bool names_function(const ir::Module& module, const ir::Pou& pou, std::string_view name) {
  const auto declared = module.pou_by_name.find(name);
  const bool own = declared != module.pou_by_name.end() && module.pous[declared->second].kind == ir::PouKind::kFunction;
  const bool special =
      std::any_of(stdlib::specials().begin(), stdlib::specials().end(),
                  [&](const stdlib::SpecialSpec& one) { return !one.drawn_only && core::iequals(one.name, name); });
  if (!own && !special && !stdlib::is_function(name)) return false;
  const Named named = find_name(module, pou, name);
  if (!named.is_place()) return true;
  const bool local = named.kind == Named::Kind::kVariable;
  const ir::Variable& variable = local ? pou.variables[named.index] : module.globals[named.index].variable;
  const bool in_out = local && variable.role == ir::Role::kInOut;
  const ir::TypeKind kind = module.types[in_out ? module.types[variable.type].element : variable.type].kind;
  return kind != ir::TypeKind::kBlock && kind != ir::TypeKind::kPou;
}

namespace {

/// "a[i.x]" and "b" of "a[i.x].b": split at the dots outside of brackets.
std::vector<std::string_view> steps_of(std::string_view path) {
  std::vector<std::string_view> steps;
  std::size_t begin = 0, open = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (path[i] == '[' || path[i] == '(') ++open;
    if ((path[i] == ']' || path[i] == ')') && open != 0) --open;
    if (path[i] != '.' || open != 0 || i == 0) continue;  // ".x.y" begins with the name ".x"
    steps.push_back(core::trimmed(path.substr(begin, i - begin)));
    begin = i + 1;
  }
  steps.push_back(core::trimmed(path.substr(begin)));
  return steps;
}

std::string_view name_in(std::string_view step) { return core::trimmed(step.substr(0, step.find_first_of("[^"))); }

/// Type of a variable after the indices and ^ of a step; how many of them fit is for the lowering to say.
ir::TypeRef inner_type(const ir::TypeTable& types, ir::TypeRef type, std::string_view step) {
  const bool indexed = step.find('[') != std::string_view::npos;
  const bool followed = step.find('^') != std::string_view::npos;
  for (;;) {
    const ir::Type& t = types[type];
    const bool goes_on = (t.kind == ir::TypeKind::kArray && indexed) ||
                         (t.kind == ir::TypeKind::kReference && (followed || t.implicit)) ||
                         (t.kind == ir::TypeKind::kPointer && (followed || indexed));
    if (!goes_on) return type;
    type = t.element;
  }
}

ir::TypeRef declared_type(const ir::TypeTable& types, const ir::Variable& variable) {
  return variable.role == ir::Role::kInOut ? types[variable.type].element : variable.type;
}

std::optional<ir::TypeRef> type_of_path(const ir::Module& module, const ir::Pou& pou,
                                        const std::vector<std::string_view>& steps) {
  std::size_t next = 1;
  ir::TypeRef type;
  const std::string_view root = name_in(steps[0]);
  const Named named = find_name(module, pou, root);
  if (named.is_place()) {
    type = named.kind == Named::Kind::kVariable ? declared_type(module.types, pou.variables[named.index])
                                                : module.globals[named.index].variable.type;
  } else if (const auto program = find_program(module, root)) {
    type = module.pous[*program].instance_type;
  } else {
    if (steps.size() < 2) return std::nullopt;
    const auto global = module.global_by_name.find(std::string(root) + "." + std::string(name_in(steps[1])));
    if (global == module.global_by_name.end()) return std::nullopt;
    type = module.globals[global->second].variable.type;
    next = 2;
  }
  type = inner_type(module.types, type, steps[next - 1]);
  for (; next < steps.size(); ++next) {
    const ir::Type& t = module.types[type];
    const std::string_view name = name_in(steps[next]);
    if (t.kind == ir::TypeKind::kStruct) {
      const auto position = module.types.position_of(type, name);
      if (!position) return std::nullopt;
      type = t.fields[*position].type;
    } else if (t.kind == ir::TypeKind::kPou) {
      const ir::Variable* const variable = module.pous[t.pou].find(name);
      if (variable == nullptr) return std::nullopt;
      type = declared_type(module.types, *variable);
    } else {
      return std::nullopt;
    }
    type = inner_type(module.types, type, steps[next]);
  }
  return type;
}

}  // namespace

std::optional<ActionName> find_action(const ir::Module& module, const ir::Pou& pou, std::string_view path) {
  path = core::trimmed(path);
  std::vector<std::string_view> steps = steps_of(path);
  const std::string_view action = steps.back();
  steps.pop_back();
  if (steps.empty()) {
    const auto own = pou.actions.find(action);
    return own == pou.actions.end() ? std::nullopt : std::optional(ActionName{{}, own->second});
  }
  const auto type = type_of_path(module, pou, steps);
  if (!type || module.types[*type].kind != ir::TypeKind::kPou) return std::nullopt;
  const ir::Pou& owner = module.pous[module.types[*type].pou];
  const auto found = owner.actions.find(action);
  if (found == owner.actions.end()) return std::nullopt;
  const std::size_t dot = path.rfind('.', static_cast<std::size_t>(action.data() - path.data()));
  return ActionName{core::trimmed(path.substr(0, dot)), found->second};
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
  const auto qualified = [&](const EnumValueRef& one) { return types[one.type].qualified; };
  if (!std::all_of(out.begin(), out.end(), qualified)) std::erase_if(out, qualified);
  return out;
}

}  // namespace plc::st
