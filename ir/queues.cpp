#include "ir/queues.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "core/text.h"
#include "ir/reach.h"

namespace plc::ir {
namespace {

using core::Code;

constexpr std::array<std::pair<std::string_view, QueueFunction>, 4> kFunctions = {{
    {"QUEUE_PUT", QueueFunction::kPut},
    {"QUEUE_GET", QueueFunction::kGet},
    {"QUEUE_COUNT", QueueFunction::kCount},
    {"QUEUE_SPACE", QueueFunction::kSpace},
}};

bool holds_reference(const TypeTable& types, TypeRef ref) {
  const Type& type = types[ref];
  if (type.kind == TypeKind::kArray) return holds_reference(types, type.element);
  return type.kind == TypeKind::kReference ||
         std::any_of(type.fields.begin(), type.fields.end(),
                     [&types](const TypeField& field) { return holds_reference(types, field.type); });
}

/// The global that `place` is, as a queue. Nothing, and reported, when it cannot be one.
std::optional<std::uint32_t> queue_at(Builder& builder, PlaceId place, const SourceRef& at, std::string_view what) {
  const auto refuse = [&](std::string_view why, std::string_view help) -> std::optional<std::uint32_t> {
    builder.report(Code::P4111, at, fmt::format("{} {}", what, why), std::string(help));
    return std::nullopt;
  };
  constexpr std::string_view kHelp = "declare a global variable for it: an ARRAY [0..63] OF the elements' type";
  const Place root = builder.body().places[place.index];
  if (root.kind != Place::Kind::kGlobal) {
    return refuse(fmt::format("needs a queue, \"{}\" is no global variable", builder.describe(place)), kHelp);
  }
  Global& global = builder.module().globals[root.index];
  const TypeTable& types = builder.module().types;
  const TypeRef type = global.variable.type;
  if (types[type].kind != TypeKind::kArray) {
    return refuse(
        fmt::format("needs a queue, which is an array, \"{}\" is {}", global.variable.name, types.name_of(type)),
        kHelp);
  }
  if (types.holds_instance(type) || holds_reference(types, type)) {
    return refuse(fmt::format("needs a queue of values, \"{}\" is {}", global.variable.name, types.name_of(type)),
                  "instances and references belong to one task and cannot be passed on");
  }
  const Variable& v = global.variable;
  if (v.retain || v.persistent || v.constant || !v.address.empty() || !v.initial.empty()) {
    return refuse(
        fmt::format("makes \"{}\" a queue, which has no address, no initial value and is not retained", v.name),
        "declare it without RETAIN, CONSTANT, AT and :=");
  }
  global.queue = true;
  return root.index;
}

Variable parameter(std::string_view name, TypeRef type, Role role, const SourceRef& at) {
  Variable v;
  v.name = name;
  v.type = type;
  v.role = role;
  v.in_frame = true;
  v.at = at;
  return v;
}

}  // namespace

std::optional<QueueFunction> queue_function_named(std::string_view name) {
  for (const auto& [known, function] : kFunctions) {
    if (core::iequals(known, name)) return function;
  }
  return std::nullopt;
}

std::optional<std::uint32_t> queue_function(Builder& builder, QueueFunction function, PlaceId place,
                                            const SourceRef& at, std::string_view what) {
  const auto global = queue_at(builder, place, at, what);
  if (!global) return std::nullopt;
  Module& module = builder.module();
  const auto made = static_cast<std::uint32_t>(module.pous.size());
  const auto [known, fresh] = module.queue_functions.emplace(std::pair(function, *global), made);
  if (!fresh) return known->second;
  const Variable& queue = module.globals[*global].variable;
  const bool moves = function == QueueFunction::kPut || function == QueueFunction::kGet;
  Pou pou;
  // The name in errors and listings; a blank keeps it apart from all that can be declared.
  pou.name = fmt::format("{} {}", kFunctions[static_cast<std::size_t>(function)].first, queue.name);
  pou.kind = PouKind::kFunction;
  pou.return_type = moves ? kBoolType : ref_of(TypeId::kUdint);
  pou.compiled = true;
  pou.from_library = true;
  pou.at = queue.at;
  pou.queue_call = QueueCall{function, *global};
  pou.variables.push_back(parameter(pou.name, pou.return_type, Role::kReturnValue, queue.at));
  pou.variables.push_back(parameter("QUEUE", queue.type, Role::kQueue, queue.at));
  const TypeRef element = module.types[queue.type].element;
  if (function == QueueFunction::kPut) pou.variables.push_back(parameter("IN", element, Role::kInput, queue.at));
  if (function == QueueFunction::kGet) pou.variables.push_back(parameter("OUT", element, Role::kOutput, queue.at));
  for (std::uint32_t i = 0; i < pou.variables.size(); ++i) pou.by_name.emplace(pou.variables[i].name, i);
  module.pous.push_back(std::move(pou));
  return made;
}

bool connect_queue(Builder& builder, PlaceId instance, std::uint32_t variable, PlaceId place, const SourceRef& at,
                   std::string_view what) {
  const auto global = queue_at(builder, place, at, what);
  if (!global) return false;
  const auto refuse = [&](std::string why, std::string_view help) {
    builder.report(Code::P4111, at, fmt::format("{} {}", what, why), std::string(help));
    return false;
  };
  Module& module = builder.module();
  const Type& block = module.types[builder.type_of(instance)];
  const TypeRef wanted = module.types[module.pous[block.pou].variables[variable].type].element;
  const TypeRef given = module.types[module.globals[*global].variable.type].element;
  if (wanted != given) {
    return refuse(fmt::format("needs a queue of {}, \"{}\" is one of {}", module.types.name_of(wanted),
                              module.globals[*global].variable.name, module.types.name_of(given)),
                  "give the array the type of the port's elements");
  }
  PlaceId root = instance;
  for (; builder.body().places[root.index].parent.valid(); root = builder.body().places[root.index].parent) {
    const Place::Kind kind = builder.body().places[root.index].kind;
    if (kind != Place::Kind::kField && kind != Place::Kind::kElement) {
      return refuse("is a queue, and which instance is meant is not known before the program runs",
                    "call it by an index that is a constant");
    }
  }
  if (builder.body().places[root.index].kind != Place::Kind::kInstance) {
    return refuse("is a queue, and the instance is no variable of this POU",
                  "declare the instance in the program or function block that calls it");
  }
  for (const QueuePort& port : module.pous[builder.pou_index()].queue_ports) {
    if (port.instance != instance || port.variable != variable) continue;
    if (port.global == *global) return true;
    return refuse(fmt::format("is connected to queue \"{}\" elsewhere", module.globals[port.global].variable.name),
                  "a port has one queue");
  }
  module.pous[builder.pou_index()].queue_ports.push_back({instance, variable, *global});
  return true;
}

std::vector<QueueUse> queue_use(const Module& module, const Task& task) {
  std::vector<QueueUse> use(module.globals.size());
  for (const std::uint32_t index : reached_pous(module, task)) {
    const Pou& pou = module.pous[index];
    if (pou.queue_call) {
      QueueUse& queue = use[pou.queue_call->global];
      queue.takes = queue.takes || pou.queue_call->function == QueueFunction::kGet;
      // Who asks for space has a ring of its own that the space is in.
      queue.puts = queue.puts || pou.queue_call->function == QueueFunction::kPut ||
                   pou.queue_call->function == QueueFunction::kSpace;
    }
    for (const QueuePort& port : pou.queue_ports) {
      const Type& block = module.types[pou.body.places[port.instance.index].type];
      const bool takes = module.pous[block.pou].variables[port.variable].constant;
      (takes ? use[port.global].takes : use[port.global].puts) = true;
    }
  }
  return use;
}

void check_queues(const Module& module, core::Diagnostics& diagnostics) {
  std::vector<std::string> takers(module.globals.size());
  std::vector<bool> several(module.globals.size());
  for (const Task& task : module.tasks) {
    const std::vector<QueueUse> use = queue_use(module, task);
    for (std::size_t g = 0; g < use.size(); ++g) {
      if (!use[g].takes) continue;
      several[g] = several[g] || !takers[g].empty();
      takers[g] += (takers[g].empty() ? "" : " and ") + task.name;
    }
  }
  for (std::uint32_t g = 0; g < module.globals.size(); ++g) {
    const Variable& v = module.globals[g].variable;
    if (!module.globals[g].queue) continue;
    if (several[g]) {
      diagnostics.report(Code::P4205, v.at, "",
                         fmt::format("elements are taken out of queue {} by tasks {}", v.name, takers[g]),
                         "let one task take them; it may put them into queues of the others");
    }
    for (const Pou& pou : module.pous) {
      const auto at = first_access(pou.body, g);
      if (!at) continue;
      diagnostics.report(Code::P4112, *at, pou.name, fmt::format("\"{}\" is a queue and is used as a variable", v.name),
                         "put and take elements with QUEUE_PUT and QUEUE_GET, or at the queue ports of taskblocks");
    }
  }
}

}  // namespace plc::ir
