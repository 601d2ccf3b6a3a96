// Typed helpers of the builder: assignments, and configuration ports of taskblocks.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "ir/convert.h"

namespace plc::ir {

using core::Code;
using stdlib::Overload;

std::optional<ValueId> Builder::convert(const Operand& operand, TypeRef to, std::string_view what) {
  return convert_with(*this, operand, to, [&] { return std::string(what); });
}

bool Builder::assign(PlaceId place, const Operand& operand, std::string_view what) {
  const TypeRef type = type_of(place);
  if (!module_.types.rep_of(type)) {
    if (operand.kind != Operand::Kind::kValue || type_of(operand.value) != type) {
      const std::string given =
          operand.kind == Operand::Kind::kValue ? module_.types.name_of(type_of(operand.value)) : text_of(operand);
      report(Code::P4101, operand.at, fmt::format("{} needs {}, not {}", what, module_.types.name_of(type), given));
      return false;
    }
    // Instances hold time and edges of their own: a copy of one would be a second device.
    if (module_.types.holds_instance(type)) {
      report(Code::P4109, operand.at, fmt::format("{} holds a function block instance and cannot be assigned", what),
             "assign its members, or pass the instance to a VAR_IN_OUT");
      return false;
    }
    store(place, operand.value);
    return true;
  }
  const auto value = convert(takes_ltime(place) ? as_time(operand) : operand, type, what);
  if (!value) return false;
  store(place, *value);
  return true;
}

// TP, TON and TOF are overloaded for both durations (IEC 61131-3:2013, table 46). Both count nanoseconds.
bool Builder::takes_ltime(PlaceId place) {
  const Place& at = body().places[place.index];
  if (at.kind != Place::Kind::kField || at.type != ref_of(TypeId::kTime)) return false;
  const Type& parent = module_.types[type_of(at.parent)];
  return parent.kind == TypeKind::kBlock && parent.block->any_duration;
}

Operand Builder::as_time(const Operand& operand) {
  if (operand.kind != Operand::Kind::kValue || type_of(operand.value) != ref_of(TypeId::kLtime)) return operand;
  Operand out = operand;
  const Overload* const same = conversion(TypeId::kLtime, TypeId::kTime);
  out.value = call_or_fold(*this, *same, std::span(&operand.value, 1), ref_of(TypeId::kTime));
  return out;
}

bool Builder::assign_input(PlaceId instance, std::uint32_t index, const Operand& operand, std::string_view what) {
  const Type& type = module_.types[type_of(instance)];
  const bool configures = type.kind == TypeKind::kPou && module_.pous[type.pou].taskblock != 0 &&
                          module_.pous[type.pou].variables[index].constant;
  return configures ? configure(instance, index, operand, what) : assign(field(instance, index), operand, what);
}

// The constant becomes part of the initial value of the variable that holds the instance.
bool Builder::configure(PlaceId instance, std::uint32_t index, const Operand& operand, std::string_view what) {
  const TypeRef type = module_.pous[module_.types[type_of(instance)].pou].variables[index].type;
  const auto refuse = [&](std::string_view why, std::string_view help) {
    report(Code::P4110, operand.at, fmt::format("{} {}", what, why), std::string(help));
    return false;
  };
  std::vector<std::uint32_t> path = {index};
  PlaceId root = instance;
  for (; body().places[root.index].parent.valid(); root = body().places[root.index].parent) {
    const Place& step = body().places[root.index];
    if (step.kind != Place::Kind::kField && step.kind != Place::Kind::kElement) {
      return refuse("is a configuration port, and which instance is meant is not known before the program runs",
                    "call it by an index that is a constant");
    }
    path.insert(path.begin(), step.index);
  }
  const Place& place = body().places[root.index];
  Variable* variable = nullptr;
  if (place.kind == Place::Kind::kInstance) variable = &pou().variables[place.index];
  if (place.kind == Place::Kind::kGlobal) variable = &module_.globals[place.index].variable;
  if (variable == nullptr) {
    return refuse("is a configuration port, and the instance is the caller's",
                  "configure it where the instance is declared: initial values in brackets");
  }
  std::vector<InitItem> items;
  if (module_.types.rep_of(type)) {
    const auto value = convert(operand, type, what);
    if (!value) return false;
    const Inst& inst = body().insts[value->index];
    const Place* const from = inst.op == Op::kLoad ? &body().places[inst.a] : nullptr;
    if (inst.op == Op::kConst) {
      items.push_back({path, body().constants[inst.a]});
    } else if (from == nullptr) {
      return refuse("is a configuration port and takes a constant", "wire a constant, or a variable that is CONSTANT");
    }
  }
  if (items.empty()) {
    // A variable that is constant: its initial value.
    const Variable* source = nullptr;
    const std::uint32_t made = operand.kind == Operand::Kind::kValue ? operand.value.index : 0xffffffffu;
    if (made < body().insts.size() && body().insts[made].op == Op::kLoad) {
      const Place& from = body().places[body().insts[made].a];
      if (from.kind == Place::Kind::kInstance) source = &pou().variables[from.index];
      if (from.kind == Place::Kind::kGlobal) source = &module_.globals[from.index].variable;
    }
    if (source == nullptr || !source->constant || source->type != type) {
      return refuse("is a configuration port and takes a constant", "wire a constant, or a variable that is CONSTANT");
    }
    for (const InitItem& item : source->initial) {
      std::vector<std::uint32_t> to = path;
      to.insert(to.end(), item.path.begin(), item.path.end());
      items.push_back({std::move(to), item.value});
    }
  }
  for (InitItem& item : items) {
    const auto same = std::find_if(variable->initial.begin(), variable->initial.end(),
                                   [&](const InitItem& other) { return other.path == item.path; });
    if (same == variable->initial.end()) {
      variable->initial.push_back(std::move(item));
    } else {
      same->value = std::move(item.value);
    }
  }
  return true;
}

}  // namespace plc::ir
