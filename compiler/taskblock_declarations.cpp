#include "compiler/taskblock_declarations.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/text.h"
#include "core/types.h"
#include "declare/library_declarations.h"
#include "frontend-st/read.h"

namespace plc::compiler {
namespace {

using plcopen::Section;
using plcopen::TypeSpec;
using Names = std::unordered_set<std::string, core::NameHash, core::NameEqual>;

void collect(const plcopen::TypeSpec& type, Names& names) {
  if (!type.name.empty()) names.insert(type.name);
  if (type.base) collect(*type.base, names);
  for (const plcopen::Variable& member : type.members) collect(member.type, names);
}

/// Every type that a declaration of the project names.
Names named_types(const plcopen::Project& project) {
  Names names;
  const auto add = [&names](const std::vector<plcopen::Variable>& variables) {
    for (const plcopen::Variable& variable : variables) collect(variable.type, names);
  };
  for (const plcopen::DataType& type : project.data_types) collect(type.type, names);
  for (const plcopen::Pou& pou : project.pous) add(pou.variables);
  for (const plcopen::Configuration& configuration : project.configurations) {
    add(configuration.globals);
    for (const plcopen::Resource& resource : configuration.resources) add(resource.globals);
  }
  return names;
}

/// Types are not compared: those of the registry count, also when the declaration is of an older version.
bool is_declaration(const plcopen::Pou& pou, const picard_block& block) {
  if (pou.kind != plcopen::PouKind::kFunctionBlock || !st::declares_only(pou)) return false;
  std::size_t ports = 0;
  for (std::uint32_t i = 0; i < block.port_count; ++i) {
    const picard_port& port = block.ports[i];
    ++ports;
    const bool queue = port.direction == PICARD_QUEUE_READER || port.direction == PICARD_QUEUE_WRITER;
    const Section section = queue                             ? Section::kInOut
                            : port.direction == PICARD_OUTPUT ? Section::kOutput
                                                              : Section::kInput;
    const bool declared = std::any_of(pou.variables.begin(), pou.variables.end(), [&](const plcopen::Variable& v) {
      return v.section == section && core::iequals(v.name, port.name);
    });
    if (!declared) return false;
  }
  return ports == pou.variables.size();
}

bool same_type(const plcopen::TypeSpec& spec, const picard_type& type) {
  switch (type.kind) {
    case PICARD_STRING:
      return spec.kind == TypeSpec::Kind::kString && core::iequals(spec.name, type.name) &&
             spec.length == std::to_string(type.capacity);
    case PICARD_ARRAY:
      return spec.kind == TypeSpec::Kind::kArray && spec.dimensions.size() == 1 && spec.base != nullptr &&
             spec.dimensions[0].lower == "0" && spec.dimensions[0].upper == std::to_string(type.capacity - 1) &&
             same_type(*spec.base, *type.element);
    case PICARD_STRUCT_TYPE:
    case PICARD_ENUM_TYPE:
      return spec.kind == TypeSpec::Kind::kNamed && core::iequals(spec.name, type.name);
    default:
      return spec.kind == TypeSpec::Kind::kNamed && core::type_named(spec.name) == core::type_named(type.name);
  }
}

bool same_fields(const plcopen::TypeSpec& spec, const picard_type& structure) {
  if (spec.kind != TypeSpec::Kind::kStruct || spec.members.size() != structure.field_count) return false;
  for (std::uint32_t i = 0; i < structure.field_count; ++i) {
    const plcopen::Variable& member = spec.members[i];
    if (!core::iequals(member.name, structure.fields[i].name) || !same_type(member.type, *structure.fields[i].type) ||
        member.initial.kind != plcopen::InitialValue::Kind::kNone) {
      return false;
    }
  }
  return true;
}

bool same_values(const plcopen::TypeSpec& spec, const picard_type& enumeration) {
  if (spec.kind != TypeSpec::Kind::kEnum || spec.values.size() != enumeration.enumerator_count ||
      spec.base == nullptr || !same_type(*spec.base, *enumeration.element)) {
    return false;
  }
  for (std::uint32_t i = 0; i < enumeration.enumerator_count; ++i) {
    const picard_enumerator& one = enumeration.enumerators[i];
    if (!core::iequals(spec.values[i].name, one.name) || spec.values[i].value != std::to_string(one.value))
      return false;
  }
  return true;
}

bool is_declaration(const plcopen::DataType& declared, const picard_type& type) {
  return core::iequals(declared.name, type.name) && declared.initial.kind == plcopen::InitialValue::Kind::kNone &&
         (type.kind == PICARD_ENUM_TYPE ? same_values(declared.type, type) : same_fields(declared.type, type));
}

/// Drops what the registry has; reports what hides it.
std::size_t drop_declarations(plcopen::Project& project, const taskblocks::Registry& registry,
                              core::Diagnostics& diagnostics) {
  std::size_t dropped = std::erase_if(project.pous, [&](const plcopen::Pou& pou) {
    const taskblocks::Registry::Entry* const entry = registry.find(pou.name);
    if (entry == nullptr) return false;
    if (is_declaration(pou, *entry->block)) return true;
    diagnostics.report(
        core::Code::P4019, pou.at, pou.name,
        std::string(plcopen::pou_kind_name(pou.kind)) + " \"" + pou.name + "\" hides the taskblock of this name",
        "rename it if the taskblock is meant");
    return false;
  });
  for (const taskblocks::Registry::Entry& entry : registry.entries()) {
    for (const picard_type* type : taskblocks::data_types_of(*entry.block)) {
      dropped += std::erase_if(project.data_types,
                               [&](const plcopen::DataType& declared) { return is_declaration(declared, *type); });
    }
  }
  return dropped;
}

}  // namespace

std::size_t add_taskblocks(plcopen::Project& project, const taskblocks::Registry& registry,
                           core::Diagnostics& diagnostics) {
  const std::size_t dropped = drop_declarations(project, registry, diagnostics);
  const Names wanted = named_types(project);
  Names taken;
  for (const plcopen::Pou& pou : project.pous) taken.insert(pou.name);
  for (const plcopen::DataType& type : project.data_types) taken.insert(type.name);
  std::string text;
  for (const taskblocks::Registry::Entry& entry : registry.entries()) {
    const std::string_view name = entry.block->name;
    const bool declares = wanted.contains(name) && !taken.contains(name);
    const std::vector<const picard_type*> types = taskblocks::data_types_of(*entry.block);
    project.offered_types.emplace_back(name);
    for (const picard_type* type : types) project.offered_types.emplace_back(type->name);
    const bool names_one = std::any_of(types.begin(), types.end(), [&](const picard_type* type) {
      return wanted.contains(std::string_view(type->name));
    });
    if (!declares && !names_one) continue;
    for (const picard_type* type : types) {
      if (taken.insert(type->name).second) text += taskblocks::declaration(*type);
    }
    if (declares) text += taskblocks::block_declaration(*entry.block);
  }
  if (text.empty()) return dropped;
  const auto declared = st::read_memory(text, "taskblocks", diagnostics);
  if (!declared) return dropped;
  for (plcopen::DataType& type : declared->data_types) project.data_types.push_back(std::move(type));
  for (plcopen::Pou& pou : declared->pous) {
    pou.from_library = true;
    pou.taskblock = taskblocks::layout_hash(*registry.find(pou.name)->block);
    project.pous.push_back(std::move(pou));
  }
  return dropped;
}

}  // namespace plc::compiler
