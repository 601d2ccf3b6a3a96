#include "tools/taskblock_declarations.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/text.h"
#include "frontend-st/read.h"

namespace plc::tools {
namespace {

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

bool is_declaration(const plcopen::Pou& pou, const picard_block& block) {
  if (pou.kind != plcopen::PouKind::kFunctionBlock || pou.has_actions) return false;
  const bool empty = std::all_of(pou.bodies.begin(), pou.bodies.end(), [](const plcopen::Body& body) {
    return body.drawn_elements == 0 && body.text.find_first_not_of(" \t\r\n;") == std::string::npos;
  });
  const auto is_port = [&block](const plcopen::Variable& variable) {
    return std::any_of(block.ports, block.ports + block.port_count,
                       [&](const picard_port& port) { return core::iequals(port.name, variable.name); });
  };
  return empty && pou.variables.size() == block.port_count &&
         std::all_of(pou.variables.begin(), pou.variables.end(), is_port);
}

}  // namespace

void add_taskblocks(plcopen::Project& project, const taskblocks::Registry& registry, core::Diagnostics& diagnostics) {
  const Names wanted = named_types(project);
  std::erase_if(project.pous, [&](const plcopen::Pou& pou) {
    const taskblocks::Registry::Entry* const entry = registry.find(pou.name);
    return entry != nullptr && is_declaration(pou, *entry->block);
  });
  Names taken;
  for (const plcopen::Pou& pou : project.pous) taken.insert(pou.name);
  for (const plcopen::DataType& type : project.data_types) taken.insert(type.name);
  std::string text;
  for (const taskblocks::Registry::Entry& entry : registry.entries()) {
    if (!wanted.contains(std::string_view(entry.block->name)) || taken.contains(std::string_view(entry.block->name)))
      continue;
    for (const picard_type* structure : taskblocks::structures_of(*entry.block)) {
      if (taken.insert(structure->name).second) text += taskblocks::declaration(*structure);
    }
    text += taskblocks::block_declaration(*entry.block);
  }
  if (text.empty()) return;
  const auto declared = st::read_memory(text, "taskblocks", diagnostics);
  if (!declared) return;
  for (plcopen::DataType& type : declared->data_types) project.data_types.push_back(std::move(type));
  for (plcopen::Pou& pou : declared->pous) {
    pou.from_library = true;
    pou.taskblock = taskblocks::layout_hash(*registry.find(pou.name)->block);
    project.pous.push_back(std::move(pou));
  }
}

}  // namespace plc::tools
