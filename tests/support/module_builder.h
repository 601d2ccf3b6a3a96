// ModuleBuilder: small IR modules for tests, without XML.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "core/diagnostics.h"
#include "ir/builder.h"
#include "ir/ir.h"

namespace plc::test {

struct ModuleBuilder {
  ir::Module module;
  core::Diagnostics diagnostics;

  std::uint32_t pou(std::string_view name, ir::PouKind kind = ir::PouKind::kProgram) {
    const auto index = static_cast<std::uint32_t>(module.pous.size());
    ir::Pou p;
    p.name = std::string(name);
    p.kind = kind;
    p.compiled = true;
    if (kind != ir::PouKind::kFunction) p.instance_type = module.types.pou(index, name);
    module.pous.push_back(std::move(p));
    module.pou_by_name.emplace(std::string(name), index);
    return index;
  }
  std::uint32_t variable(std::uint32_t pou, std::string_view name, ir::TypeRef type, ir::Role role = ir::Role::kLocal) {
    ir::Pou& p = module.pous[pou];
    ir::Variable v;
    v.name = std::string(name);
    v.type = role == ir::Role::kInOut ? module.types.reference(type) : type;
    v.role = role;
    v.in_frame = p.kind == ir::PouKind::kFunction || role == ir::Role::kTemp;
    const auto index = static_cast<std::uint32_t>(p.variables.size());
    if (role == ir::Role::kReturnValue) p.return_type = type;
    p.by_name.emplace(v.name, index);
    p.variables.push_back(std::move(v));
    return index;
  }
  std::uint32_t global(std::string_view name, ir::TypeRef type) {
    ir::Global g;
    g.variable.name = std::string(name);
    g.variable.type = type;
    const auto index = static_cast<std::uint32_t>(module.globals.size());
    module.global_by_name.emplace(g.variable.name, index);
    module.globals.push_back(std::move(g));
    return index;
  }
  ir::Task& task(std::string_view name, std::uint32_t pou, std::string_view instance) {
    ir::Task t;
    t.name = std::string(name);
    t.period_ns = 20'000'000;
    t.programs.push_back({std::string(instance), pou, {}});
    module.tasks.push_back(std::move(t));
    return module.tasks.back();
  }
  ir::Builder body(std::uint32_t pou) { return ir::Builder(module, pou, diagnostics); }
};

inline ir::TypeRef type(core::TypeId id) { return ir::ref_of(id); }

inline ir::Operand literal(std::int64_t value) {
  ir::Operand o;
  o.kind = ir::Operand::Kind::kIntLiteral;
  o.int_value = value;
  return o;
}
inline ir::Operand real_literal(double value) {
  ir::Operand o;
  o.kind = ir::Operand::Kind::kRealLiteral;
  o.real_value = value;
  return o;
}

}  // namespace plc::test
