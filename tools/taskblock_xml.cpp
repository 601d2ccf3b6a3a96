#include "tools/taskblock_xml.h"

#include <fmt/format.h>

#include <unordered_set>

#include "core/text.h"
#include "core/types.h"
#include "tools/plcopen_text.h"
#include "tools/taskblock_text.h"

namespace plc::tools {
namespace {

std::string port_type_xml(const picard_type& type) {
  switch (type.kind) {
    case PICARD_STRING:
      return fmt::format("<{} length=\"{}\"/>", core::folded(type.name), type.capacity);
    case PICARD_ARRAY:
      return fmt::format("<array><dimension lower=\"0\" upper=\"{}\"/><baseType>{}</baseType></array>",
                         type.capacity - 1, port_type_xml(*type.element));
    case PICARD_STRUCT_TYPE:
    case PICARD_ENUM_TYPE:
      return fmt::format("<derived name=\"{}\"/>", type.name);
    default:
      return type_xml(*core::type_named(type.name));
  }
}

/// A queue port is an in-out; how long the array is that is named at it matters to editors alone.
std::string queue_type_xml(const picard_port& port) {
  const std::string type = port_type_xml(*port.type);
  if (port.direction != PICARD_QUEUE_READER && port.direction != PICARD_QUEUE_WRITER) return type;
  return fmt::format("<array><dimension lower=\"0\" upper=\"63\"/><baseType>{}</baseType></array>", type);
}

std::string data_type_xml(const picard_type& type) {
  std::string inside;
  if (type.kind == PICARD_ENUM_TYPE) {
    for (std::uint32_t i = 0; i < type.enumerator_count; ++i) {
      inside += fmt::format("<value name=\"{}\" value=\"{}\"/>", type.enumerators[i].name, type.enumerators[i].value);
    }
    inside = fmt::format("          <enum><values>{}</values><baseType>{}</baseType></enum>\n", inside,
                         port_type_xml(*type.element));
  } else {
    for (std::uint32_t i = 0; i < type.field_count; ++i) {
      inside += variable_xml(type.fields[i].name, port_type_xml(*type.fields[i].type), {});
    }
    inside = section_xml("struct", inside);
  }
  return fmt::format("      <dataType name=\"{}\">\n        <baseType>\n{}        </baseType>\n      </dataType>\n",
                     type.name, inside);
}

/// Meaning, unit, range and what else is known: what editors show of a pin.
std::string port_documentation(const picard_port& port) {
  std::string text = port.summary;
  for (const std::string& more : {std::string(port.unit), range_text(port)}) {
    if (!more.empty()) text += ", " + more;
  }
  // WHY here: an initial value of this kind is a tree of elements. The registry's counts, whatever the editor has.
  if (!is_simple(*port.type) && port.initial[0] != '\0') text += fmt::format(", default {}", port.initial);
  return text;
}

std::string block_xml(const picard_block& block) {
  const auto section = [&block](std::string_view element, std::uint32_t direction) {
    std::string variables;
    for (std::uint32_t i = 0; i < block.port_count; ++i) {
      const picard_port& port = block.ports[i];
      if (port.direction != direction) continue;
      variables += variable_xml(port.name, queue_type_xml(port), port_documentation(port),
                                is_simple(*port.type) ? port.initial : "");
    }
    return section_xml(element, variables);
  };
  return pou_xml(block.name, "functionBlock",
                 section("inputVars", PICARD_INPUT) + section("inputVars constant=\"true\"", PICARD_CONFIG) +
                     section("outputVars", PICARD_OUTPUT) + section("inOutVars", PICARD_QUEUE_WRITER) +
                     section("inOutVars constant=\"true\"", PICARD_QUEUE_READER),
                 block.summary, fmt::format("The runtime has the body: plc blocks {}", block.name));
}

}  // namespace

std::string taskblocks_xml(std::span<const taskblocks::Registry::Entry* const> entries) {
  std::string types, pous;
  std::unordered_set<std::string, core::NameHash, core::NameEqual> written;
  for (const taskblocks::Registry::Entry* entry : entries) {
    for (const picard_type* type : taskblocks::data_types_of(*entry->block)) {
      if (written.insert(type->name).second) types += data_type_xml(*type);
    }
    pous += block_xml(*entry->block);
  }
  return project_xml("picard-taskblocks", types, pous);
}

}  // namespace plc::tools
