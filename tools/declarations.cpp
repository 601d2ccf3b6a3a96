#include "tools/declarations.h"

#include <vector>

#include "core/text.h"

namespace plc::tools {
namespace {

using plcopen::TypeSpec;
using plcopen::Variable;

/// "main", "curves" of "main.curves[2]".
std::vector<std::string_view> names_of(std::string_view path) {
  std::vector<std::string_view> names;
  while (!path.empty()) {
    const std::size_t dot = path.find('.');
    const std::string_view step = path.substr(0, dot);
    names.push_back(step.substr(0, step.find('[')));
    path = dot == std::string_view::npos ? std::string_view{} : path.substr(dot + 1);
  }
  return names;
}

template <class T>
const T* named(const std::vector<T>& all, std::string_view name) {
  for (const T& one : all) {
    if (core::iequals(one.name, name)) return &one;
  }
  return nullptr;
}

/// The program of the instance called `name`; POUs that run alone (--pou) are called like themselves.
std::string_view program_of(const plcopen::Project& project, std::string_view name) {
  const auto type_of = [](const plcopen::PouInstance& instance) -> std::string_view {
    return instance.type_name.empty() ? instance.name : instance.type_name;
  };
  for (const plcopen::Configuration& configuration : project.configurations) {
    for (const plcopen::Resource& resource : configuration.resources) {
      if (const auto* instance = named(resource.instances, name)) return type_of(*instance);
      for (const plcopen::Task& task : resource.tasks) {
        if (const auto* instance = named(task.instances, name)) return type_of(*instance);
      }
    }
  }
  return name;
}

const Variable* global_named(const plcopen::Project& project, std::string_view name) {
  for (const plcopen::Configuration& configuration : project.configurations) {
    if (const Variable* found = named(configuration.globals, name)) return found;
    for (const plcopen::Resource& resource : configuration.resources) {
      if (const Variable* found = named(resource.globals, name)) return found;
    }
  }
  for (const plcopen::Pou& pou : project.pous) {
    for (const Variable& variable : pou.variables) {
      if (variable.section == plcopen::Section::kGlobal && core::iequals(variable.name, name)) return &variable;
    }
  }
  return nullptr;
}

/// What an array has elements of, and where names lead to.
const TypeSpec* innermost(const TypeSpec& type, const plcopen::Project& project) {
  const TypeSpec* inner = &type;
  for (int depth = 0; depth < 64; ++depth) {
    if (inner->kind == TypeSpec::Kind::kArray && inner->base != nullptr) {
      inner = inner->base.get();
      continue;
    }
    const auto* declared = inner->kind == TypeSpec::Kind::kNamed ? named(project.data_types, inner->name) : nullptr;
    if (declared == nullptr) break;
    inner = &declared->type;
  }
  return inner;
}

}  // namespace

std::optional<Declaration> declaration_of(const plcopen::Project& project, std::string_view path) {
  const std::vector<std::string_view> names = names_of(path);
  if (names.empty()) return std::nullopt;
  std::optional<Declaration> found;
  const TypeSpec* type = nullptr;
  const plcopen::Pou* pou = named(project.pous, program_of(project, names[0]));
  const Variable* global = global_named(project, names[0]);
  if (pou != nullptr) {
    found = {pou->at, pou->name};
  } else if (global != nullptr) {
    found = {global->at, {}};
    type = innermost(global->type, project);
  }
  for (std::size_t i = 1; i < names.size() && found; ++i) {
    const Variable* variable = nullptr;
    if (type != nullptr && type->kind == TypeSpec::Kind::kNamed) pou = named(project.pous, type->name);
    if (type != nullptr && type->kind == TypeSpec::Kind::kStruct) {
      variable = named(type->members, names[i]);
    } else if (pou != nullptr) {
      variable = named(pou->variables, names[i]);
    }
    if (variable == nullptr) break;
    if (variable->at.line != 0) found = {variable->at, pou != nullptr ? pou->name : std::string()};
    type = innermost(variable->type, project);
    pou = nullptr;
  }
  return found;
}

}  // namespace plc::tools
