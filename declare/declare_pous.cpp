// POU interfaces, globals, externals and located variables.
#include <algorithm>
#include <utility>

#include "core/text.h"
#include "declare/declare.h"
#include "declare/declarer.h"
#include "frontend-st/any_types.h"
#include "frontend-st/foreign.h"
#include "frontend-st/names.h"
#include "ir/builder.h"

namespace plc::st {

using core::Code;
using ir::Role;
using ir::TypeKind;
using ir::TypeRef;
using plcopen::Section;

namespace {

std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

Role role_of(Section section) {
  switch (section) {
    case Section::kInput:
      return Role::kInput;
    case Section::kOutput:
      return Role::kOutput;
    case Section::kInOut:
      return Role::kInOut;
    case Section::kTemp:
      return Role::kTemp;
    case Section::kExternal:
    case Section::kGlobal:
      return Role::kExternal;
    default:
      return Role::kLocal;
  }
}

ir::PouKind kind_of(plcopen::PouKind kind) {
  switch (kind) {
    case plcopen::PouKind::kFunction:
      return ir::PouKind::kFunction;
    case plcopen::PouKind::kFunctionBlock:
      return ir::PouKind::kFunctionBlock;
    default:
      return ir::PouKind::kProgram;
  }
}

/// An action or transition of the POU `owner`: a body that works on its variables.
ir::Pou part_of(const plcopen::Pou& from, std::uint32_t owner, const plcopen::Pou& one) {
  ir::Pou part;
  part.name = from.name + "." + one.name;
  part.kind = kind_of(from.kind);
  part.at = one.at;
  part.owner = owner;
  part.from_library = from.from_library;
  return part;
}

}  // namespace

Declarer::Declarer(const plcopen::Project& project, const core::CompileOptions& options, core::Diagnostics& diagnostics,
                   ir::Module& module)
    : project_(project), options_(options), diagnostics_(diagnostics), module_(module) {}

void Declarer::run() {
  module_.options = options_;
  for (const plcopen::Attribute& one : project_.attributes) {
    module_.attributes.insert(ir::attribute_key(one.pou, one.variable, one.name));
  }
  module_.name = project_.name;
  declare_libraries();
  declare_pou_names();
  for (const plcopen::Configuration& configuration : project_.configurations) {
    const auto collect = [&](const std::vector<plcopen::Variable>& globals) {
      for (const plcopen::Variable& v : globals) {
        if (!v.constant) continue;
        global_constants_.emplace(v.list.empty() ? v.name : v.list + "." + v.name, &v);
        if (!v.prefix.empty()) global_constants_.emplace(v.prefix + "." + v.name, &v);
      }
    };
    collect(configuration.globals);
    for (const plcopen::Resource& resource : configuration.resources) collect(resource.globals);
  }
  declare_data_types();
  declare_globals();
  for (std::uint32_t i = 0; i < project_.pous.size(); ++i) declare_interface(i);
  for (std::uint32_t i = 0; i < project_.pous.size(); ++i) declare_transitions(i);
  initialize_all();
  for (std::uint32_t i = 0; i < project_.pous.size(); ++i) detect_edges(i);
  declare_configuration();
  report_uses();
}

std::unique_ptr<ir::Module> declare(const plcopen::Project& project, const core::CompileOptions& options,
                                    core::Diagnostics& diagnostics) {
  auto module = std::make_unique<ir::Module>();
  Declarer(project, options, diagnostics, *module).run();
  return module;
}

// Every POU has its type before any variable is typed: POUs may name each other in any order.
void Declarer::declare_pou_names() {
  for (std::uint32_t i = 0; i < project_.pous.size(); ++i) {
    const plcopen::Pou& from = project_.pous[i];
    ir::Pou pou;
    pou.name = from.name;
    pou.kind = kind_of(from.kind);
    pou.at = from.at;
    pou.from_library = from.from_library;
    pou.test = from.test;
    pou.taskblock = from.taskblock;
    pou.refused.insert(from.unread_members.begin(), from.unread_members.end());
    const bool circular = i < circular_.size() && circular_[i];
    const bool first = circular || module_.pou_by_name.emplace(from.name, i).second;
    if (circular) {
      // It has no type: that is reported where it is named.
    } else if (!first) {
      // The XML reader says so of two POUs of its file (P1012).
      const bool said = from.at.line != 0 && project_.version != plcopen::Version::kText &&
                        module_.pous[module_.pou_by_name.find(from.name)->second].at.file == from.at.file;
      if (!said) {
        const core::SourceRef& first_at = module_.pous[module_.pou_by_name.find(from.name)->second].at;
        report(Code::P4018, from.at, from.name,
               "POU " + quoted(from.name) + " is declared twice, first " + first_place(first_at, from.at),
               "rename one of them");
      }
    } else if (is_standard(from.name)) {
      report(Code::P4019, from.at, from.name,
             std::string(plcopen::pou_kind_name(from.kind)) + " " + quoted(from.name) + " hides the standard " +
                 (stdlib::block_named(from.name) != nullptr ? "function block" : "function") + " of this name",
             "rename it if the standard one is meant");
    } else if (core::type_named(from.name)) {
      report(Code::P4018, from.at, from.name, "POU " + quoted(from.name) + " has the name of an elementary type");
    }
    if (pou.kind != ir::PouKind::kFunction && !circular) pou.instance_type = types().pou(i, from.name);
    module_.pous.push_back(std::move(pou));
  }
  // After all of them: the place of a POU in both lists is the same.
  for (std::uint32_t i = 0; i < project_.pous.size(); ++i) declare_actions(i);
}

void Declarer::declare_actions(std::uint32_t owner) {
  const plcopen::Pou& from = project_.pous[owner];
  for (const plcopen::Pou& one : from.actions) {
    const std::string name = from.name + "." + one.name;
    if (from.kind == plcopen::PouKind::kFunction) {
      report(Code::P4050, one.at, name, "action " + quoted(one.name) + " belongs to the function " + quoted(from.name),
             "functions have no instance that an action could run on: make it a function block");
      continue;
    }
    const auto index = static_cast<std::uint32_t>(module_.pous.size());
    if (!module_.pous[owner].actions.emplace(one.name, index).second) {
      report(Code::P4018, one.at, name, "action " + quoted(one.name) + " is declared twice", "rename one of them");
      continue;
    }
    module_.pous.push_back(part_of(from, owner, one));
  }
}

void Declarer::declare_transitions(std::uint32_t owner) {
  const plcopen::Pou& from = project_.pous[owner];
  if (from.kind == plcopen::PouKind::kFunction) return;  // its chart is refused
  for (const plcopen::Pou& one : from.transitions) {
    const std::string name = from.name + "." + one.name;
    const auto index = static_cast<std::uint32_t>(module_.pous.size());
    if (module_.find_transition(owner, one.name)) {
      report(Code::P4018, one.at, name, "transition " + quoted(one.name) + " is declared twice", "rename one of them");
      continue;
    }
    ir::Variable result;
    result.name = "#transition." + std::to_string(index);
    result.type = ir::kBoolType;
    result.role = Role::kHidden;
    result.at = one.at;
    module_.transitions[index] = {owner, one.name, static_cast<std::uint32_t>(module_.pous[owner].variables.size())};
    module_.pous[owner].variables.push_back(std::move(result));
    module_.pous.push_back(part_of(from, owner, one));
  }
}

// ---- globals --------------------------------------------------------------------------------------------------

void Declarer::declare_globals() {
  for (const plcopen::Configuration& configuration : project_.configurations) {
    for (const plcopen::Variable& v : configuration.globals) declare_global(v);
    for (const plcopen::Resource& resource : configuration.resources) {
      for (const plcopen::Variable& v : resource.globals) declare_global(v);
    }
  }
  for (std::uint32_t i = 0; i < project_.pous.size(); ++i) {
    for (const plcopen::Variable& v : project_.pous[i].variables) {
      if (v.section == Section::kGlobal) declare_global(v);
    }
  }
  if (options_.stub_missing) supply_missing_globals();
}

// --stub-missing: all POUs that name an external variable without a global share one that nothing else writes.
void Declarer::supply_missing_globals() {
  std::unordered_set<std::string, core::NameHash, core::NameEqual> listed;  // in lists that must be named
  for (const ir::Global& global : module_.globals) {
    if (!global.list.empty()) listed.insert(global.variable.name);
  }
  for (const plcopen::Pou& pou : project_.pous) {
    for (const plcopen::Variable& variable : pou.variables) {
      if (variable.section != Section::kExternal || variable.type.kind == plcopen::TypeSpec::Kind::kMissing) continue;
      if (module_.global_by_name.contains(variable.name) || module_.refused.contains(variable.name)) continue;
      if (listed.contains(variable.name)) continue;  // it is there: an error where it is bound
      if (!pou.from_library) {
        report(Code::P4087, variable.at, pou.name,
               "external variable " + quoted(variable.name) +
                   " has no global variable: one is made that nobody else writes",
               (supplier_of(variable.name).empty() ? "" : std::string(supplier_of(variable.name)) + " brings it: ") +
                   "a file that declares it, given with --lib, makes it what it is");
      }
      declare_global(variable);
    }
  }
}

/// Where `name`, which means that global, is declared.
const core::SourceRef& Declarer::place_of_global(std::string_view name, std::uint32_t global) const {
  for (const ir::GlobalAlias& alias : module_.global_aliases) {
    const std::string own = alias.list.empty() ? alias.name : alias.list + "." + alias.name;
    if (alias.global == global && core::iequals(own, name)) return alias.at;
  }
  return module_.globals[global].variable.at;
}

void Declarer::declare_global(const plcopen::Variable& variable) {
  const Owner owner{{}, variable.name, variable.at};
  const std::string qualified = variable.list.empty() ? variable.name : variable.list + "." + variable.name;
  if (module_.global_by_name.find(qualified) != module_.global_by_name.end()) {
    const auto first = module_.global_by_name.find(qualified);
    report(Code::P4018, variable.at, {},
           "global variable " + quoted(qualified) + " is declared twice, first " +
               first_place(place_of_global(qualified, first->second), variable.at));
    return;
  }
  const auto type = variable.refused ? std::nullopt : resolve(variable.type, owner);
  if (!type) {
    // Those of a library stay unknown names: the reason is reported where one is used.
    if (is_library(variable.at)) return;
    module_.refused.insert(qualified);
    module_.refused.insert(variable.name);
    return;
  }
  ir::Global global;
  ir::Variable& out = global.variable;
  out.name = variable.name;
  out.type = *type;
  out.constant = variable.constant;
  out.retain = variable.retain;
  out.persistent = variable.persistent;
  out.nonretain = variable.nonretain;
  out.at = variable.at;
  global.list = variable.list;
  global.prefix = variable.prefix;
  global.file_prefix = variable.file_prefix;
  global.from_library = is_library(variable.at);
  const auto index = static_cast<std::uint32_t>(module_.globals.size());
  if (!variable.address.empty()) {
    const auto address = address_of(variable, *type, owner);
    if (address) out.address = address->text();
    if (address && !address->unlocated) {
      const auto [known, fresh] = module_.global_by_name.emplace(out.address, index);
      const ir::Global* other = fresh ? nullptr : &module_.globals[known->second];
      if (other != nullptr && other->variable.type == *type) {
        // Two names for one place.
        name_global(variable, known->second);
        module_.global_aliases.push_back({variable.name, variable.list, known->second, variable.at});
        if (!variable.prefix.empty())
          module_.global_aliases.push_back({variable.name, variable.prefix, known->second, variable.at});
        return;
      }
      if (other != nullptr && address->area != 'I') {
        report(Code::P4032, variable.at, {},
               quoted(variable.name) + " of type " + types().name_of(*type) + " and " + quoted(other->variable.name) +
                   " of type " + types().name_of(other->variable.type) + " are both at " + out.address,
               "give variables at one address one type");
      }
    }
  }
  name_global(variable, index);
  module_.globals.push_back(std::move(global));
  pending_.push_back({&variable, kNoPou, index});
}

// "x", or "GVL.x" alone where the list must be named; both where it may be.
void Declarer::name_global(const plcopen::Variable& variable, std::uint32_t index) {
  module_.global_by_name.emplace(variable.list.empty() ? variable.name : variable.list + "." + variable.name, index);
  if (!variable.prefix.empty()) module_.global_by_name.emplace(variable.prefix + "." + variable.name, index);
}

std::optional<Address> Declarer::address_of(const plcopen::Variable& variable, TypeRef type, const Owner& owner) {
  std::string problem;
  auto address = parse_address(core::trimmed(variable.address), problem);
  if (!address) {
    report(Code::P4023, variable.at, owner.pou,
           "address " + quoted(variable.address) + " of " + quoted(variable.name) + ": " + problem,
           "write it like %IX0.0, %QW3 or %MD10");
    return std::nullopt;
  }
  if (address->unlocated) return address;
  TypeRef scalar = type;
  while (types()[scalar].kind == TypeKind::kArray) scalar = types()[scalar].element;
  if (types()[scalar].stub) return address;
  const auto rep = types().rep_of(scalar);
  const bool has_bits = rep && *rep != core::Rep::kStr && *rep != core::Rep::kWstr && *rep != core::Rep::kRef;
  const std::uint32_t bits = !has_bits ? 0 : *rep == core::Rep::kBool ? 1 : core::rep_bytes(*rep) * 8;
  // Strings and structures begin at a byte or word and are as long as they are.
  const bool fits = bits == 0 ? address->size != 'X' : bits == address->bits();
  if (fits) return address;
  report(Code::P4024, variable.at, owner.pou,
         quoted(variable.name) + " of type " + types().name_of(type) + " is at " + address->text() + ", which has " +
             std::to_string(address->bits()) + (address->bits() == 1 ? " bit" : " bits"),
         "X is one bit, B 8, W 16, D 32 and L 64 bits");
  return std::nullopt;
}

// ---- interfaces -----------------------------------------------------------------------------------------------

void Declarer::declare_interface(std::uint32_t index) {
  const plcopen::Pou& from = project_.pous[index];
  enter_scope(index);
  if (from.kind == plcopen::PouKind::kFunction && from.return_type.kind != plcopen::TypeSpec::Kind::kMissing) {
    const auto type = resolve(from.return_type, {from.name, from.name, from.at});
    if (type) {
      ir::Pou& pou = module_.pous[index];
      pou.return_type = *type;
      ir::Variable result;
      result.name = from.name;
      result.type = *type;
      result.role = Role::kReturnValue;
      result.in_frame = true;
      result.at = from.at;
      pou.by_name.emplace(result.name, 0u);
      pou.variables.push_back(std::move(result));
    } else {
      module_.pous[index].refused.insert(from.name);
    }
  }
  for (const plcopen::Variable& v : from.variables) {
    if (v.section != Section::kAccess && v.section != Section::kConfig) declare_variable(index, v);
  }
  enter_scope(kNoPou);
  if (from.taskblock == 0) return;
  ir::Variable object;
  object.name = ir::kObjectName;
  object.type = ir::ref_of(core::TypeId::kUdint);
  object.role = Role::kHidden;
  object.at = from.at;
  module_.pous[index].variables.push_back(std::move(object));
}

void Declarer::declare_variable(std::uint32_t pou_index, const plcopen::Variable& variable) {
  const std::string& pou_name = project_.pous[pou_index].name;
  const bool in_function = project_.pous[pou_index].kind == plcopen::PouKind::kFunction;
  const Owner owner{pou_name, variable.name, variable.at};
  const auto known = module_.pous[pou_index].by_name.find(variable.name);
  if (known != module_.pous[pou_index].by_name.end()) {
    const ir::Variable& first = module_.pous[pou_index].variables[known->second];
    report(Code::P4018, variable.at, pou_name,
           "variable " + quoted(variable.name) +
               (first.role == Role::kReturnValue ? " has the name of the function's result"
                                                 : " is declared twice, first " + first_place(first.at, variable.at)));
    return;
  }
  if (const auto& actions = module_.pous[pou_index].actions; actions.find(variable.name) != actions.end()) {
    report(Code::P4018, variable.at, pou_name, quoted(variable.name) + " is a variable and an action of " + pou_name,
           "rename one of them");
  }
  if (variable.refused) {
    module_.pous[pou_index].refused.insert(variable.name);
    return;
  }
  ir::Variable out;
  out.name = variable.name;
  out.role = role_of(variable.section);
  out.constant = variable.constant;
  out.retain = variable.retain;
  out.persistent = variable.persistent;
  out.nonretain = variable.nonretain;
  out.at = variable.at;
  if ((variable.section == Section::kExternal || variable.section == Section::kInOut) &&
      variable.initial.kind != plcopen::InitialValue::Kind::kNone) {
    const bool external = variable.section == Section::kExternal;
    report(Code::P4086, variable.at, pou_name,
           "initial value of " + quoted(variable.name) + " has no effect: " +
               (external ? "an external variable is the global one" : "VAR_IN_OUT is the variable of the caller"),
           external ? "give the global variable its value" : "leave it out, or declare a VAR_INPUT");
  }
  if (variable.section == Section::kExternal || variable.section == Section::kGlobal) {
    if (!bind_external(out, variable, owner)) {
      module_.pous[pou_index].refused.insert(variable.name);
      return;
    }
  } else if (variable.section == Section::kStatic) {
    if (!bind_static(out, variable, owner)) {
      module_.pous[pou_index].refused.insert(variable.name);
      return;
    }
  } else {
    const bool is_taskblock = project_.pous[pou_index].taskblock != 0;
    open_allowed_ = (in_function && (out.role == Role::kInput || out.role == Role::kInOut)) ||
                    (is_taskblock && out.role == Role::kInOut);
    const bool generic = out.role == Role::kInput && variable.type.kind == plcopen::TypeSpec::Kind::kNamed;
    auto type = generic ? any_type(types(), core::trimmed(variable.type.name)) : std::nullopt;
    if (!type) type = resolve(variable.type, owner);
    open_allowed_ = false;
    if (!type) {
      module_.pous[pou_index].refused.insert(variable.name);
      return;
    }
    if (is_taskblock && types()[*type].open) {
      out.role = Role::kQueue;
    } else if (types()[*type].open) {
      module_.pous[pou_index].generic = true;
    }
    out.type = *type;
    out.in_frame = in_function || out.role == Role::kTemp;
    if (in_function && variable.section == Section::kInstance) {
      report(Code::P4045, variable.at, pou_name,
             quoted(variable.name) + " is VAR_INST in a function, which keeps nothing from call to call",
             "make the function a function block, or pass the variable as VAR_IN_OUT");
    }
    if (out.role == Role::kInOut) {
      out.type = types().reference(*type);
    } else if (out.in_frame && types().holds_instance(*type)) {
      report(
          Code::P4033, variable.at, pou_name,
          quoted(variable.name) + " of type " + types().name_of(*type) +
              " is declared where nothing is kept from call to call",
          in_function ? "pass the instance as VAR_IN_OUT, or make the function a function block" : "declare it as VAR");
    }
    if (!variable.address.empty()) {
      if (out.in_frame || out.role == Role::kInOut) {
        report(Code::P4023, variable.at, pou_name,
               quoted(variable.name) + " has an address, but lives only while its POU runs",
               "declare it as a global variable");
      } else if (!bind_located(out, variable, owner)) {
        out.address.clear();  // it stays a variable, so that its uses are no errors of their own
      }
    }
  }
  ir::Pou& pou = module_.pous[pou_index];
  if (out.role == Role::kTemp && !in_function && !pou.actions.empty()) {
    // Actions see it, and a frame is seen by one body alone.
    out.in_frame = false;
    if (out.constant) out.role = Role::kLocal;
  }
  const auto index = static_cast<std::uint32_t>(pou.variables.size());
  pou.by_name.emplace(out.name, index);
  pou.variables.push_back(std::move(out));
  pending_.push_back({&variable, pou_index, index});
}

// An edge input is an R_TRIG or F_TRIG at the beginning of the body, whose output the body sees by the input's name
// (IEC 61131-3:2013, 6.6.3.2).
void Declarer::detect_edges(std::uint32_t index) {
  for (const plcopen::Variable& variable : project_.pous[index].variables) {
    if (variable.edge == plcopen::Edge::kNone) continue;
    ir::Pou& pou = module_.pous[index];
    const auto found = pou.by_name.find(variable.name);
    if (found == pou.by_name.end()) continue;
    const std::uint32_t input = found->second;
    const ir::Variable& declared = pou.variables[input];
    if (declared.role != Role::kInput || declared.type != ir::kBoolType || pou.kind == ir::PouKind::kFunction) {
      report(Code::P4046, variable.at, pou.name,
             quoted(variable.name) + " has an edge, but is no BOOL input of a function block or program",
             pou.kind == ir::PouKind::kFunction ? "keep the edge in a function block, and give the function its output"
                                                : "call R_TRIG or F_TRIG in the body");
      continue;
    }
    const char* const block = variable.edge == plcopen::Edge::kRising ? "R_TRIG" : "F_TRIG";
    const stdlib::BlockSpec* const spec = stdlib::block_named(block);
    if (spec == nullptr) continue;
    ir::Builder builder(module_, index, diagnostics_);
    builder.set_source(variable.at);
    const std::uint32_t trigger = builder.hidden("edge", types().block(*spec));
    const std::uint32_t edge = builder.hidden("edge", ir::kBoolType);
    const ir::PlaceId instance = builder.variable(trigger);
    builder.store(*builder.member(instance, "CLK"), builder.load(builder.variable(input)));
    builder.run(instance);
    builder.store(builder.variable(edge), builder.load(*builder.member(instance, "Q")));
    module_.pous[index].edges.emplace(input, edge);
  }
}

bool Declarer::is_standard(std::string_view name) {
  const stdlib::BlockSpec* const block = stdlib::block_named(name);
  const std::span<const stdlib::Overload> functions = stdlib::overloads_named(name);
  const std::string_view clause = block != nullptr     ? block->clause
                                  : !functions.empty() ? functions.front().spec->clause
                                                       : std::string_view{};
  return stdlib::is_standard(clause);
}

std::string Declarer::first_place(const core::SourceRef& first, const core::SourceRef& second) const {
  const bool elsewhere = first.file != second.file && first.file < diagnostics_.file_count();
  if (first.line == 0) return elsewhere ? "in " + diagnostics_.file_name(first.file) : "elsewhere";
  const std::string line = std::to_string(first.line);
  return elsewhere ? "at " + diagnostics_.file_name(first.file) + ":" + line : "at line " + line;
}

// One variable for all instances and calls of its POU: a global that no other code can name.
bool Declarer::bind_static(ir::Variable& out, const plcopen::Variable& variable, const Owner& owner) {
  const auto type = resolve(variable.type, owner);
  if (!type) return false;
  if (!variable.address.empty()) {
    report(Code::P4023, variable.at, owner.pou, quoted(variable.name) + " is VAR_STAT and has an address",
           "declare it as a global variable");
  }
  out.type = *type;
  ir::Global global;
  global.variable = out;
  global.variable.name = std::string(owner.pou) + "." + variable.name;
  global.variable.role = Role::kLocal;
  global.from_library = is_library(variable.at);
  out.role = Role::kExternal;
  out.global = static_cast<std::uint32_t>(module_.globals.size());
  module_.globals.push_back(std::move(global));
  return true;
}

bool Declarer::bind_external(ir::Variable& out, const plcopen::Variable& variable, const Owner& owner) {
  auto found = module_.global_by_name.find(variable.name);
  if (found == module_.global_by_name.end() && !variable.list.empty()) {
    found = module_.global_by_name.find(variable.list + "." + variable.name);
  }
  // Its own declaration was reported as wrong.
  if (found == module_.global_by_name.end() && module_.refused.contains(variable.name)) return false;
  if (found == module_.global_by_name.end() && is_broken(variable.name, owner.at, variable.at, owner.pou)) return false;
  if (found == module_.global_by_name.end()) {
    const auto listed = std::find_if(module_.globals.begin(), module_.globals.end(), [&](const ir::Global& g) {
      return !g.list.empty() && core::iequals(g.variable.name, variable.name);
    });
    Guess guess(variable.name);
    for (const ir::Global& g : module_.globals) guess.offer(g.variable.name);
    std::string help = guess.help();
    if (listed != module_.globals.end()) {
      help = "the list " + listed->list + " must be named: write " + listed->list + "." + listed->variable.name +
             " where it is used";
    } else if (!supplier_of(variable.name).empty()) {
      help = supply_help(variable.name, "VAR_GLOBAL " + variable.name + " : T; END_VAR");
    } else if (help.empty()) {
      help = project_.version == plcopen::Version::kText
                 ? "declare it in VAR_GLOBAL of the configuration or resource"
                 : "declare it in a globalVars list of the configuration or resource";
      help += ", or in a library (--lib) where an extension of the tool brings it; --stub-missing makes one";
    }
    report(Code::P4021, variable.at, owner.pou,
           "external variable " + quoted(variable.name) + " has no global variable", help);
    // It stays usable, so that every use of it is not an error of its own.
    if (variable.type.kind == plcopen::TypeSpec::Kind::kMissing) return false;
    const auto type = resolve(variable.type, owner);
    if (!type) return false;
    out.type = *type;
    out.role = Role::kLocal;
    return true;
  }
  const ir::Variable& global = module_.globals[found->second].variable;
  const TypeRef global_type = global.type;
  note_use(owner.at, global.at, variable.at, owner.pou);
  out.role = Role::kExternal;
  out.global = found->second;
  out.address = global.address;
  out.constant = out.constant || global.constant;
  out.type = global_type;
  if (variable.section == Section::kGlobal || variable.type.kind == plcopen::TypeSpec::Kind::kMissing) return true;
  const auto type = resolve(variable.type, owner);
  if (type && *type != global_type && !types()[*type].stub) {
    report(Code::P4022, variable.at, owner.pou,
           "external variable " + quoted(variable.name) + " has type " + types().name_of(*type) +
               ", the global variable " + types().name_of(global_type),
           "give both one type");
  }
  return true;
}

}  // namespace plc::st
