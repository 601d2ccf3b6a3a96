// Lints of declarations: unused, never written, never read, never called; POUs that nothing uses.
//
// What the outside may read or write is left out: variables at addresses, outputs, retained ones. Constants are left
// out because array bounds and labels use them without a trace in the IR.
#include <fmt/format.h>

#include <algorithm>

#include "ir/lint_findings.h"
#include "ir/reach.h"

namespace plc::ir {
namespace {

using Use = std::uint8_t;
constexpr Use kRead = 1, kWritten = 2, kRun = 4;
constexpr Use kHandle = kRead | kWritten | kRun;  ///< code that gets a handle may do everything

/// What all bodies together do with every variable.
class Usage {
 public:
  explicit Usage(const Module& module) : module_(module), globals_(module.globals.size()) {
    for (const Pou& pou : module.pous) variables_.emplace_back(pou.variables.size());
    for (std::uint32_t p = 0; p < module.pous.size(); ++p) add_body(p);
    for (const Task& task : module.tasks) {
      auto single = module.global_by_name.find(task.single);
      if (single == module.global_by_name.end()) {
        single = module.global_by_name.find(std::string_view(task.single).substr(0, task.single.find('.')));
      }
      if (single != module.global_by_name.end()) globals_[single->second] |= kRead;
      for (const ProgramInstance& program : task.programs) add_instance(program);
    }
  }

  [[nodiscard]] Use variable(std::uint32_t pou, std::uint32_t index) const { return variables_[pou][index]; }
  [[nodiscard]] Use global(std::uint32_t index) const { return globals_[index]; }
  /// Whether the body of `pou` or one of its actions uses the global itself.
  [[nodiscard]] bool uses(std::uint32_t pou, std::uint32_t global) const {
    const auto in_body = [&](std::uint32_t body) {
      return std::binary_search(globals_of_[body].begin(), globals_of_[body].end(), global);
    };
    const auto& actions = module_.pous[pou].actions;
    return in_body(pou) ||
           std::any_of(actions.begin(), actions.end(), [&](const auto& a) { return in_body(a.second); });
  }

 private:
  /// What the configuration connects and initializes.
  void add_instance(const ProgramInstance& program) {
    for (const InstanceWire& wire : program.wires) globals_[wire.global] |= wire.output ? kWritten : kRead;
    for (const InitItem& item : program.initial) {
      std::uint32_t pou = program.pou;
      for (const std::uint32_t step : item.path) {
        variables_[pou][step] |= kWritten;
        const Type& type = module_.types[module_.pous[pou].variables[step].type];
        if (type.kind != TypeKind::kPou) break;
        pou = type.pou;
      }
    }
  }

  void add_body(std::uint32_t pou) {
    const Body& body = module_.pous[pou].body;
    globals_of_.emplace_back();
    std::vector<Use> uses(body.places.size());
    for (const Inst& inst : body.insts) {
      switch (inst.op) {
        case Op::kLoad:
          uses[inst.a] |= kRead;
          break;
        case Op::kStore:
          uses[inst.a] |= kWritten;
          break;
        case Op::kCopy:
          uses[inst.a] |= kWritten;
          uses[inst.b] |= kRead;
          break;
        case Op::kRun:
          uses[inst.a] |= kRun;
          break;
        case Op::kMakeRef:
        case Op::kAddress:
          uses[inst.a] |= kHandle;
          break;
        case Op::kCallPou:
          for (std::uint32_t i = 0; i < inst.count; ++i) {
            const CallArg& arg = body.call_args[inst.b + i];
            if (arg.kind == CallArg::Kind::kOutput) uses[arg.place.index] |= kWritten;
          }
          if (const auto& call = module_.pous[inst.a].queue_call) {
            add_global(pou, call->global, call->function == QueueFunction::kPut ? kWritten : kRead);
          }
          break;
        default:
          break;
      }
    }
    for (const QueuePort& port : module_.pous[pou].queue_ports) {
      const Type& block = module_.types[body.places[port.instance.index].type];
      add_global(pou, port.global, module_.pous[block.pou].variables[port.variable].constant ? kRead : kWritten);
    }
    // Parts come after what they are part of, so that one pass from the end reaches every root.
    for (std::size_t i = uses.size(); i-- > 0;) {
      if (uses[i] != 0) add_place(pou, body.places[i], uses[i], uses);
    }
    std::sort(globals_of_.back().begin(), globals_of_.back().end());
  }

  void add_global(std::uint32_t pou, std::uint32_t global, Use use) {
    globals_[global] |= use;
    globals_of_[pou].push_back(global);
  }

  void add_place(std::uint32_t pou, const Place& place, Use use, std::vector<Use>& uses) {
    if (place.parent.valid()) {
      const Type& whole = module_.types[module_.pous[pou].body.places[place.parent.index].type];
      if (place.kind == Place::Kind::kField && whole.kind == TypeKind::kPou) variables_[whole.pou][place.index] |= use;
      uses[place.parent.index] |= use;
    } else if (place.kind == Place::Kind::kGlobal) {
      add_global(pou, place.index, use);
    } else if (place.kind == Place::Kind::kInstance || place.kind == Place::Kind::kFrame) {
      const std::uint32_t owner = module_.pous[pou].owner;
      variables_[owner == Pou::kDeclared ? pou : owner][place.index] |= use;
    }
  }

  const Module& module_;
  std::vector<Use> globals_;
  std::vector<std::vector<Use>> variables_;             ///< by POU and variable
  std::vector<std::vector<std::uint32_t>> globals_of_;  ///< by POU: globals its body touches, ascending
};

/// Names the instance type, if the variable is an instance or an array of them.
const Type* instance_type(const TypeTable& types, TypeRef ref) {
  while (types[ref].kind == TypeKind::kArray) ref = types[ref].element;
  const Type& type = types[ref];
  return type.kind == TypeKind::kBlock || type.kind == TypeKind::kPou ? &type : nullptr;
}

class VariableLints {
 public:
  VariableLints(const Module& module, Findings& findings) : module_(module), findings_(findings), usage_(module) {}

  void run() {
    bool whole = true;  // nothing is left out, so what is not seen does not happen
    for (std::uint32_t p = 0; p < module_.pous.size(); ++p) {
      const Pou& pou = module_.pous[p];
      const bool unused_library = pou.from_library && !pou.compiled;
      whole = whole && (unused_library || pou.generic || (pou.compiled && !pou.stub && !pou.partial));
      if (!findings_.is_linted(pou) || pou.partial || !is_written(pou)) continue;
      for (std::uint32_t v = 0; v < pou.variables.size(); ++v) {
        if (is_visible(pou.variables[v])) look_at_variable(p, v);
      }
    }
    if (!whole) return;
    for (std::uint32_t g = 0; g < module_.globals.size(); ++g) look_at_global(g);
    look_at_pous();
  }

 private:
  /// Whether something of the POU has instructions, and all of it is known.
  [[nodiscard]] bool is_written(const Pou& pou) const {
    bool any = !pou.body.insts.empty();
    for (const auto& [name, index] : pou.actions) {
      const Pou& action = module_.pous[index];
      if (!action.compiled || action.stub) return false;
      any = any || !action.body.insts.empty();
    }
    return any;
  }

  void add(Lint lint, const Variable& v, std::string_view pou, std::string message, std::string help) {
    findings_.add(lint, v.at, pou, std::move(message), std::move(help));
  }

  void look_at_variable(std::uint32_t p, std::uint32_t index) {
    const Pou& pou = module_.pous[p];
    const Variable& v = pou.variables[index];
    if (v.constant || !v.address.empty() || module_.types[v.type].stub) return;
    const Use use = usage_.variable(p, index);
    const std::string name = quoted(v.name);
    switch (v.role) {
      case Role::kInput:
        if ((use & kRead) == 0 && !core::iequals(v.name, "EN")) {
          add(Lint::kUnusedVariable, v, pou.name, fmt::format("input {} is never read by {}", name, pou.name),
              "use it, or delete it from the interface");
        }
        return;
      case Role::kInOut:
        if (use == 0) {
          add(Lint::kUnusedVariable, v, pou.name, fmt::format("in-out {} is not used by {}", name, pou.name),
              "use it, or delete it from the interface");
        }
        return;
      case Role::kOutput:
      case Role::kReturnValue:
        if ((use & (kWritten | kRun)) != 0 || !v.initial.empty() || core::iequals(v.name, "ENO")) return;
        add(Lint::kNeverWritten, v, pou.name,
            v.role == Role::kOutput ? fmt::format("output {} is never written by {}", name, pou.name)
                                    : fmt::format("function {} never gives its result a value", pou.name),
            "the caller always gets the initial value; assign it");
        return;
      case Role::kExternal:
        // A global that is never used is reported once, where it is declared.
        if (!usage_.uses(p, v.global) && usage_.global(v.global) != 0 &&
            v.at != module_.globals[v.global].variable.at) {
          add(Lint::kUnusedVariable, v, pou.name, fmt::format("external variable {} is not used", name),
              "delete the declaration");
        }
        return;
      case Role::kLocal:
      case Role::kTemp:
        return look_at_local(pou, v, use);
      case Role::kHidden:
      case Role::kQueue:
        return;
    }
  }

  void look_at_local(const Pou& pou, const Variable& v, Use use) {
    const std::string name = quoted(v.name);
    if (use == 0) {
      add(Lint::kUnusedVariable, v, pou.name, fmt::format("variable {} is not used", name), "delete it");
      return;
    }
    if (const Type* block = instance_type(module_.types, v.type)) {
      const std::string type = block->kind == TypeKind::kBlock ? std::string(block->block->name) : block->name;
      if ((use & kRun) == 0) {
        add(Lint::kBlockNeverCalled, v, pou.name,
            fmt::format("instance {} of {} is used, but never called", name, type),
            "its outputs keep their initial values; call it");
      }
      return;
    }
    const bool kept = v.retain || v.persistent;
    if ((use & (kWritten | kRun)) == 0 && v.initial.empty() && !kept) {
      add(Lint::kNeverWritten, v, pou.name, fmt::format("variable {} is read, but never written", name),
          pou.kind == PouKind::kProgram ? "unless an HMI writes it, it keeps its default value; give it an initial "
                                          "value or an address, or assign it"
                                        : "it keeps its default value; give it an initial value, or assign it");
    }
    // What programs keep may be read by an HMI or by other tools, by its path.
    const bool seen_outside = pou.kind == PouKind::kProgram && v.role == Role::kLocal;
    if ((use & (kRead | kRun)) == 0 && !seen_outside && !kept) {
      add(Lint::kNeverRead, v, pou.name, fmt::format("variable {} is written, but never read", name),
          "delete it with what computes it, or make it an output");
    }
  }

  void look_at_global(std::uint32_t index) {
    const Global& global = module_.globals[index];
    const Variable& v = global.variable;
    if (global.from_library || global.program || !is_visible(v) || v.constant || !v.address.empty()) return;
    const Use use = usage_.global(index);
    const std::string path = global.list.empty() ? v.name : global.list + "." + v.name;
    if (findings_.is_used_outside(path) || findings_.is_used_outside(v.name)) return;
    const std::string name = quoted(path);
    if (use == 0) {
      add(Lint::kUnusedVariable, v, {}, fmt::format("global variable {} is not used", name),
          "delete it; one that plc.toml alone names is used with --config plc.toml");
    } else if (global.queue) {
      if (use == kRead || use == kWritten) {
        add(Lint::kOneWayGlobal, v, {},
            fmt::format("{} queue {}", use == kRead ? "nothing is put into" : "nothing is taken out of", name),
            use == kRead ? "put elements in, or delete it" : "it is full soon; take its elements, or delete it");
      }
    } else if (const Type* block = instance_type(module_.types, v.type)) {
      if ((use & kRun) != 0) return;
      const std::string type = block->kind == TypeKind::kBlock ? std::string(block->block->name) : block->name;
      add(Lint::kBlockNeverCalled, v, {}, fmt::format("instance {} of {} is used, but never called", name, type),
          "its outputs keep their initial values; call it");
    } else if ((use & (kWritten | kRun)) == 0 && v.initial.empty()) {
      add(Lint::kOneWayGlobal, v, {}, fmt::format("global variable {} is read, but the program never writes it", name),
          "fine when an HMI writes it; else it always has its default value");
    } else if ((use & (kRead | kRun)) == 0) {
      add(Lint::kOneWayGlobal, v, {},
          fmt::format("global variable {} is written, but the program never reads it", name),
          "fine when an HMI reads it; else delete it");
    }
  }

  void look_at_pous() {
    if (!module_.options.pou.empty()) return;  // the user chose what runs
    std::vector<bool> used(module_.pous.size());
    bool runs = false;
    for (const Task& task : module_.tasks) {
      for (const ProgramInstance& program : task.programs) {
        used[program.pou] = true;
        runs = true;
      }
    }
    if (!runs) return;  // a library: everything is for others
    for (std::uint32_t p = 0; p < module_.pous.size(); ++p) {
      for (const std::uint32_t callee : callees(module_, p)) {
        const std::uint32_t owner = module_.pous[callee].owner;
        used[owner == Pou::kDeclared ? callee : owner] = true;
      }
    }
    // Types of instances that are declared, wherever they are inside arrays and structures.
    std::vector<bool> seen(module_.types.size());
    for (const Pou& pou : module_.pous) {
      for (const Variable& v : pou.variables) mark_instances(v.type, seen, used);
    }
    for (const Global& global : module_.globals) {
      if (!global.program) mark_instances(global.variable.type, seen, used);
    }
    constexpr std::size_t kNamed = 8;
    const Pou* first = nullptr;
    std::string names;
    std::size_t count = 0;
    for (std::uint32_t p = 0; p < module_.pous.size(); ++p) {
      const Pou& pou = module_.pous[p];
      if (used[p] || pou.from_library || pou.owner != Pou::kDeclared || !findings_.is_linted(pou)) continue;
      if (pou.kind == PouKind::kProgram) {
        findings_.add(Lint::kUnusedPou, pou.at, pou.name,
                      fmt::format("no task runs program {}, and nothing calls it", quoted(pou.name)),
                      "give a task an instance of it, call it by its name, or delete it");
        continue;
      }
      if (first == nullptr) first = &pou;
      if (++count <= kNamed) names += (names.empty() ? "" : ", ") + pou.name;
    }
    if (first == nullptr) return;
    // One finding for all: projects carry libraries in their own file, of which they use a few POUs.
    if (count > kNamed) names += fmt::format(" and {} more", count - kNamed);
    findings_.add(
        Lint::kUnusedPou, first->at, first->name,
        count == 1 ? fmt::format("nothing uses {}", names)
                   : fmt::format("nothing uses {} functions and function blocks: {}", count, names),
        count == 1 ? "delete it, or move it to a library (--lib)" : "delete them, or move them to a library (--lib)");
  }

  void mark_instances(TypeRef ref, std::vector<bool>& seen, std::vector<bool>& used) {
    if (!ref.valid() || seen[ref.index]) return;
    seen[ref.index] = true;
    const Type& type = module_.types[ref];
    if (type.kind == TypeKind::kPou) used[type.pou] = true;
    if (type.kind == TypeKind::kArray || type.kind == TypeKind::kReference) mark_instances(type.element, seen, used);
    for (const TypeField& field : type.fields) mark_instances(field.type, seen, used);
  }

  const Module& module_;
  Findings& findings_;
  Usage usage_;
};

}  // namespace

void lint_variables(const Module& module, Findings& findings) { VariableLints(module, findings).run(); }

}  // namespace plc::ir
