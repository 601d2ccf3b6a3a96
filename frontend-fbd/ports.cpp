#include "frontend-fbd/ports.h"

#include <algorithm>
#include <utility>

#include "core/text.h"
#include "frontend-fbd/graph.h"
#include "frontend-fbd/order.h"
#include "frontend-st/names.h"
#include "ir/generic.h"
#include "ir/queues.h"
#include "stdlib/specials.h"

namespace plc::fbd {

using stdlib::Direction;

namespace {

/// Symbols that a box may show instead of the name of its function (IEC 61131-3:2013, tables 29, 30 and 33).
constexpr std::pair<std::string_view, std::string_view> kSymbols[] = {
    {"+", "ADD"}, {"-", "SUB"},  {"*", "MUL"},  {"/", "DIV"},     {"**", "EXPT"}, {":=", "MOVE"},
    {"&", "AND"}, {">=1", "OR"}, {"=1", "XOR"}, {"=2k+1", "XOR"}, {">", "GT"},    {">=", "GE"},
    {"=", "EQ"},  {"<=", "LE"},  {"<", "LT"},   {"<>", "NE"}};

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
    Port port{v.name, {}, *direction, i, type, v.role == ir::Role::kQueue, v.role == ir::Role::kReturnValue};
    port.constant = v.role == ir::Role::kInOut && v.constant;
    if (v.role == ir::Role::kReturnValue) {
      ports.insert(ports.begin(), port);
    } else {
      ports.push_back(port);
    }
  }
}

/// EN or ENO as a POU declares it.
bool is_enabling(const Port& port) {
  if (port.type != ir::kBoolType || port.result) return false;
  if (port.direction == Direction::kInput) return is_enable_name(port.name);
  return port.direction == Direction::kOutput && is_eno_name(port.name);
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
    ports.push_back(
        {stdlib::output_name(output), {}, Direction::kOutput, i, ir::ref_of(stdlib::usual_output_type(output))});
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
  // Editors call the result of a function OUT.
  const bool result = direction == Direction::kOutput && !ports.empty() && ports.front().result;
  if (result && core::iequals(pin, "OUT")) return &ports.front();
  std::size_t seen = 0;
  for (const Port& port : ports) {
    if (port.direction == direction && !is_enabling(port) && seen++ == position) return &port;
  }
  return nullptr;
}

const Port* declared_enable(const std::vector<Port>& ports) {
  const auto it = std::find_if(ports.begin(), ports.end(), [](const Port& port) {
    return is_enabling(port) && port.direction == Direction::kInput;
  });
  return it == ports.end() ? nullptr : &*it;
}

const Port* declared_eno(const std::vector<Port>& ports) {
  const auto it = std::find_if(ports.begin(), ports.end(), [](const Port& port) {
    return is_enabling(port) && port.direction == Direction::kOutput;
  });
  return it == ports.end() ? nullptr : &*it;
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

std::optional<NamedCall> named_call(ir::Builder& builder, const plcopen::Element& block) {
  const ir::Module& module = builder.module();
  if (block.has_code) return std::nullopt;
  const auto action = [&](std::string_view path) -> std::optional<NamedCall> {
    const auto found = st::find_action(module, builder.pou(), path);
    if (!found) return std::nullopt;
    return NamedCall{std::string(found->instance), found->action,
                     module.pous[module.pous[found->action].owner].instance_type};
  };
  const bool plain = block.instance_name.empty();
  const auto program = st::find_program(module, block.text);
  const bool hidden = program && st::find_name(module, builder.pou(), block.text).is_place();
  if (plain) {
    if (auto found = action(block.text)) return found;
  } else if (module.pou_by_name.find(block.text) == module.pou_by_name.end()) {
    if (auto found = action(block.instance_name + "." + block.text.substr(block.text.rfind('.') + 1))) return found;
  }
  if (!program || hidden || (!plain && !core::iequals(block.instance_name, block.text))) return std::nullopt;
  return NamedCall{block.text, ir::Pou::kDeclared, module.pous[*program].instance_type};
}

std::optional<std::vector<Port>> ports_of_block(ir::Builder& builder, const plcopen::Element& block) {
  ir::Module& module = builder.module();
  if (const auto named = named_call(builder, block)) return ports_of(module, named->type);
  if (const auto pou = module.pou_by_name.find(block.text); pou != module.pou_by_name.end()) {
    return ports_of_function(module, module.pous[pou->second]);
  }
  if (stdlib::block_named(block.text) != nullptr) return ports_of(module, *module.types.find(block.text));
  if (const stdlib::BundleSpec* bundle = stdlib::bundle_named(block.text)) return ports_of_bundle(*bundle);
  return std::nullopt;
}

std::optional<std::vector<Port>> outputs_of(ir::Builder& builder, const plcopen::Element& block) {
  auto ports = ports_of_block(builder, block);
  if (!ports) {
    const auto queue = ir::queue_function_named(block.text);
    if (!queue && !stdlib::is_function(block.text) && !is_delay(block) && !ir::array_bound_named(block.text)) {
      return std::nullopt;
    }
    ports.emplace();
    Port result{block.text, {}, Direction::kOutput, 0, {}};
    result.result = true;
    ports->push_back(result);
    if (queue == ir::QueueFunction::kGet) ports->push_back({"OUT", {}, Direction::kOutput, 0, {}});
  }
  std::erase_if(*ports, [](const Port& port) { return port.direction == Direction::kInput; });
  return ports;
}

std::string_view type_name(ir::Builder& builder, std::string_view name) {
  for (const auto& [symbol, function] : kSymbols) {
    if (name == symbol) return function;
  }
  ir::Module& module = builder.module();
  const auto is_known = [&](std::string_view text) {
    return module.pou_by_name.find(text) != module.pou_by_name.end() || stdlib::block_named(text) != nullptr ||
           stdlib::is_function(text);
  };
  const std::size_t dot = name.rfind('.');
  if (dot == std::string_view::npos || is_known(name) || !is_known(name.substr(dot + 1))) return name;
  // Not what belongs to a variable: an action of an instance.
  if (builder.pou().find(name.substr(0, dot)) != nullptr) return name;
  if (module.global_by_name.find(name.substr(0, dot)) != module.global_by_name.end()) return name;
  return name.substr(dot + 1);
}

std::optional<ir::TypeRef> type_of_pin(ir::Builder& builder, const plcopen::Element& block, const plcopen::Pin& pin) {
  const auto ports = ports_of_block(builder, block);
  if (!ports) return std::nullopt;
  const Port* port = find_port(*ports, Direction::kInput, pin.name, input_position(block, pin));
  if (port == nullptr || builder.module().types[port->type].open) return std::nullopt;
  return port->type;
}

std::vector<ir::InitItem> initial_of_output(ir::Builder& builder, const plcopen::Element& block, std::size_t pin,
                                            ir::TypeRef type) {
  const ir::Module& module = builder.module();
  const ir::Pou* pou = nullptr;
  if (const auto named = named_call(builder, block)) {
    const ir::Type& instance = module.types[named->type];
    if (instance.kind == ir::TypeKind::kPou) pou = &module.pous[instance.pou];
  } else if (const auto found = module.pou_by_name.find(block.text); found != module.pou_by_name.end()) {
    pou = &module.pous[found->second];
  }
  if (pou == nullptr) return {};
  const auto ports = ports_of_function(module, *pou);
  const Port* port = find_port(ports, Direction::kOutput, block.outputs[pin].name, output_position(block, pin));
  return port == nullptr || port->type != type ? std::vector<ir::InitItem>{} : pou->variables[port->index].initial;
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
