#include "frontend-fbd/ports.h"

#include "core/text.h"
#include "frontend-fbd/graph.h"

namespace plc::fbd {

using stdlib::Direction;

namespace {

std::optional<Direction> direction_of(ir::Role role) {
  switch (role) {
    case ir::Role::kInput:
      return Direction::kInput;
    case ir::Role::kOutput:
    case ir::Role::kReturnValue:
      return Direction::kOutput;
    case ir::Role::kInOut:
    case ir::Role::kQueue:
      return Direction::kInOut;
    default:
      return std::nullopt;
  }
}

void add_pou_ports(const ir::Module& module, const ir::Pou& pou, std::vector<Port>& ports) {
  for (std::uint32_t i = 0; i < pou.variables.size(); ++i) {
    const ir::Variable& v = pou.variables[i];
    const auto direction = direction_of(v.role);
    if (!direction) continue;
    const ir::TypeRef type = v.role == ir::Role::kInOut ? module.types[v.type].element : v.type;
    const Port port{v.name, {}, *direction, i, type, v.role == ir::Role::kQueue};
    if (v.role == ir::Role::kReturnValue) {
      ports.insert(ports.begin(), port);
    } else {
      ports.push_back(port);
    }
  }
}

}  // namespace

std::vector<Port> ports_of(const ir::Module& module, ir::TypeRef type) {
  std::vector<Port> ports;
  const ir::Type& t = module.types[type];
  if (t.kind == ir::TypeKind::kBlock) {
    for (std::uint32_t i = 0; i < t.block->fields.size(); ++i) {
      const stdlib::Field& f = t.block->fields[i];
      if (f.direction != Direction::kState) ports.push_back({f.name, f.alias, f.direction, i, ir::ref_of(f.type)});
    }
  } else if (t.kind == ir::TypeKind::kPou) {
    add_pou_ports(module, module.pous[t.pou], ports);
  }
  return ports;
}

std::vector<Port> ports_of_function(const ir::Module& module, const ir::Pou& pou) {
  std::vector<Port> ports;
  add_pou_ports(module, pou, ports);
  return ports;
}

std::vector<Port> ports_of_bundle(const stdlib::BundleSpec& bundle) {
  std::vector<Port> ports{{bundle.input.name, {}, Direction::kInput, 0, ir::ref_of(bundle.input.type.fixed)}};
  for (std::uint32_t i = 0; i < bundle.outputs.size(); ++i) {
    const stdlib::FunctionSpec& output = *bundle.outputs[i];
    ports.push_back({stdlib::output_name(output), {}, Direction::kOutput, i, ir::ref_of(output.result.fixed)});
  }
  return ports;
}

bool is_named(const Port& port, std::string_view pin) {
  if (pin.empty()) return false;
  return core::iequals(port.name, pin) || (!port.alias.empty() && core::iequals(port.alias, pin));
}

const Port* find_port(const std::vector<Port>& ports, Direction direction, std::string_view pin, std::size_t position) {
  for (const Port& port : ports) {
    if (port.direction == direction && is_named(port, pin)) return &port;
  }
  std::size_t seen = 0;
  for (const Port& port : ports) {
    if (port.direction == direction && seen++ == position) return &port;
  }
  return nullptr;
}

std::size_t output_position(const plcopen::Element& block, std::size_t pin) {
  std::size_t position = 0;
  for (std::size_t i = 0; i < pin; ++i) {
    if (!is_eno_name(block.outputs[i].name)) ++position;
  }
  return position;
}

std::size_t input_position(const plcopen::Element& block, const plcopen::Pin& pin) {
  std::size_t position = 0;
  for (const plcopen::Pin& p : block.inputs) {
    if (&p == &pin) break;
    if (!is_enable_name(p.name)) ++position;
  }
  return position;
}

std::optional<std::vector<Port>> ports_of_block(ir::Builder& builder, const plcopen::Element& block) {
  const ir::Module& module = builder.module();
  if (const auto pou = module.pou_by_name.find(block.text); pou != module.pou_by_name.end()) {
    return ports_of_function(module, module.pous[pou->second]);
  }
  if (const stdlib::BundleSpec* bundle = stdlib::bundle_named(block.text)) return ports_of_bundle(*bundle);
  return std::nullopt;
}

std::optional<ir::TypeRef> type_of_pin(ir::Builder& builder, const plcopen::Element& block, const plcopen::Pin& pin) {
  const ir::Module& module = builder.module();
  const ir::Variable* const instance = builder.pou().find(block.instance_name);
  const auto ports =
      instance != nullptr ? std::optional(ports_of(module, instance->type)) : ports_of_block(builder, block);
  if (!ports) return std::nullopt;
  const Port* port = find_port(*ports, Direction::kInput, pin.name, input_position(block, pin));
  if (port == nullptr || module.types[port->type].open) return std::nullopt;
  return port->type;
}

std::optional<ir::PlaceId> instance_output(ir::Builder& builder, const plcopen::Element& block, std::size_t pin) {
  const auto variable = builder.pou().by_name.find(block.instance_name);
  if (variable == builder.pou().by_name.end()) return std::nullopt;
  const ir::PlaceId instance = builder.variable(variable->second);
  const auto ports = ports_of(builder.module(), builder.type_of(instance));
  const Port* port = find_port(ports, Direction::kOutput, block.outputs[pin].name, output_position(block, pin));
  if (port == nullptr) return std::nullopt;
  return builder.field(instance, port->index);
}

}  // namespace plc::fbd
