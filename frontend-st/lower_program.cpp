// Programs by name: the one instance that a name means, and what others see of it.
#include "frontend-st/lowering.h"

namespace plc::st {

using core::Code;
using ir::PlaceId;
using ir::Role;

namespace {
std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }
}  // namespace

std::optional<PlaceId> Lowering::program_place(NodeId id, std::uint32_t program) {
  const ir::Module& module = builder_.module();
  const ir::Pou& named = module.pous[program];
  // Its own name means the instance that runs.
  if (&named == &builder_.pou()) return builder_.self();
  if (named.instance != ir::Pou::kDeclared) return builder_.global(named.instance);
  std::string instances;
  for (const ir::Task& task : module.tasks) {
    for (const ir::ProgramInstance& one : task.programs) {
      if (one.pou == program) instances += (instances.empty() ? "" : ", ") + one.name;
    }
  }
  if (instances.empty()) {
    report(Code::P7903, at(id), "no task of the project runs program " + quoted(named.name),
           "give the project a task that does, or --pou " + named.name + ", which runs it alone in a 20 ms task");
    return std::nullopt;
  }
  report(Code::P4052, at(id), "program " + quoted(named.name) + " has several instances: " + instances,
         "its name means its only instance: make it a function block, or give tasks one instance of it");
  return std::nullopt;
}

// Others read all that a program keeps, and write what it gets or keeps (CODESYS, TwinCAT).
std::optional<Lowering::Found> Lowering::program_variable(PlaceId parent, NodeId id, bool for_writing) {
  const ir::Type& type = types()[builder_.type_of(parent)];
  if (type.kind != ir::TypeKind::kPou) return std::nullopt;
  const ir::Pou& program = builder_.module().pous[type.pou];
  const bool own = builder_.body().places[parent.index].kind == ir::Place::Kind::kSelf;
  const bool test = builder_.pou().test;
  if (program.kind != ir::PouKind::kProgram && !own && (!test || program.taskblock != 0)) return std::nullopt;
  const std::string_view name = name_text(id);
  const auto known = program.by_name.find(name);
  if (known == program.by_name.end()) return std::nullopt;
  const ir::Variable& variable = program.variables[known->second];
  if (own) {
    if (for_writing && !check_writable(variable, name_at(id))) return Found{};
    const auto edge = program.edges.find(known->second);
    return Found{builder_.variable(edge == program.edges.end() ? known->second : edge->second)};
  }
  if (variable.role == Role::kTemp) {
    report(Code::P4005, name_at(id),
           quoted(name) + " is VAR_TEMP of program " + quoted(program.name) + " and exists only while it runs",
           "declare it as VAR");
    return Found{};
  }
  const bool constant = variable.constant || (variable.role == Role::kExternal &&
                                              builder_.module().globals[variable.global].variable.constant);
  if (for_writing && constant) {
    report(Code::P4007, name_at(id), quoted(text(id)) + " is a constant and is written here");
    return Found{};
  }
  if (variable.role == Role::kExternal) return Found{builder_.global(variable.global)};
  if (variable.role == Role::kInOut) return std::nullopt;
  if (for_writing && variable.role == Role::kOutput && !test) {
    report(Code::P4053, name_at(id),
           quoted(text(id)) + " is an output of program " + quoted(program.name) + " and is written here",
           "it keeps this value until the program writes its output again; an input or a local variable would say so");
  }
  return Found{builder_.field(parent, known->second)};
}

}  // namespace plc::st
