#include "ir/reach.h"

#include <algorithm>

namespace plc::ir {

const Place& root_of(const Body& body, PlaceId place) {
  const Place* p = &body.places[place.index];
  while (p->parent.valid()) p = &body.places[p->parent.index];
  return *p;
}

std::vector<std::uint32_t> callees(const Module& module, std::uint32_t pou) {
  std::vector<std::uint32_t> found;
  std::vector<bool> seen(module.pous.size());
  const Body& body = module.pous[pou].body;
  for (const Inst& inst : body.insts) {
    std::uint32_t callee = 0;
    if (inst.op == Op::kCallPou) {
      callee = inst.a;
    } else if (inst.op == Op::kRun) {
      const Type& type = module.types[body.places[inst.a].type];
      if (type.kind != TypeKind::kPou) continue;
      callee = type.pou;
    } else {
      continue;
    }
    if (seen[callee]) continue;
    seen[callee] = true;
    found.push_back(callee);
  }
  return found;
}

std::vector<std::uint32_t> reached_pous(const Module& module, const Task& task) {
  struct Frame {
    std::uint32_t pou;
    std::vector<std::uint32_t> next;
    std::size_t at = 0;
  };
  std::vector<std::uint32_t> order;
  std::vector<bool> seen(module.pous.size());
  std::vector<Frame> stack;
  const auto enter = [&](std::uint32_t pou) {
    if (seen[pou]) return;
    seen[pou] = true;
    stack.push_back({pou, callees(module, pou)});
  };
  for (const ProgramInstance& program : task.programs) {
    enter(program.pou);
    while (!stack.empty()) {
      Frame& top = stack.back();
      if (top.at < top.next.size()) {
        enter(top.next[top.at++]);
      } else {
        order.push_back(top.pou);
        stack.pop_back();
      }
    }
  }
  return order;
}

namespace {

/// Calls visit(place, read, written) for every access of the body.
template <typename Visit>
void for_each_access(const Body& body, Visit&& visit) {
  // A partly written aggregate is exported whole: the rest of it has to be imported.
  const auto write = [&](std::uint32_t place) { visit(place, body.places[place].parent.valid(), true); };
  for (const Inst& inst : body.insts) {
    switch (inst.op) {
      case Op::kLoad:
        visit(inst.a, true, false);
        break;
      case Op::kStore:
        write(inst.a);
        break;
      case Op::kCopy:
        write(inst.a);
        visit(inst.b, true, false);
        break;
      case Op::kRun:
      case Op::kMakeRef:
        visit(inst.a, true, true);
        break;
      case Op::kCallPou:
        for (std::uint32_t i = 0; i < inst.count; ++i) {
          const CallArg& arg = body.call_args[inst.b + i];
          if (arg.kind == CallArg::Kind::kOutput) write(arg.place.index);
        }
        break;
      default:
        break;
    }
  }
}

/// References that stand in globals, where other tasks find them: what they may refer to.
struct SharedReferences {
  std::vector<bool> targets;                        ///< by type: some global holds a REF_TO it
  std::vector<std::vector<std::uint32_t>> globals;  ///< by type: those of which REF() is taken somewhere

  [[nodiscard]] bool any() const { return std::find(targets.begin(), targets.end(), true) != targets.end(); }
};

void add_targets(const Module& module, TypeRef type, std::vector<bool>& seen, std::vector<bool>& targets) {
  if (seen[type.index]) return;
  seen[type.index] = true;
  const Type& t = module.types[type];
  if (t.kind == TypeKind::kReference) targets[t.element.index] = true;
  if (t.kind == TypeKind::kArray) add_targets(module, t.element, seen, targets);
  for (const TypeField& field : t.fields) add_targets(module, field.type, seen, targets);
  if (t.kind != TypeKind::kPou) return;
  for (const Variable& v : module.pous[t.pou].variables) {
    if (v.role != Role::kExternal && v.role != Role::kInOut) add_targets(module, v.type, seen, targets);
  }
}

/// By value: whether it is a handle for a VAR_IN_OUT, which never leaves its task.
std::vector<bool> in_out_handles(const Module& module, const Body& body) {
  std::vector<bool> found(body.insts.size());
  for (const CallArg& arg : body.call_args) {
    if (arg.kind == CallArg::Kind::kInOut) found[arg.value.index] = true;
  }
  for (const Inst& inst : body.insts) {
    if (inst.op != Op::kStore) continue;
    const Place& place = body.places[inst.a];
    if (place.kind != Place::Kind::kField) continue;
    const Type& owner = module.types[body.places[place.parent.index].type];
    if (owner.kind == TypeKind::kPou && module.pous[owner.pou].variables[place.index].role == Role::kInOut)
      found[inst.b] = true;
  }
  return found;
}

SharedReferences shared_references(const Module& module) {
  SharedReferences shared;
  shared.targets.resize(module.types.size());
  std::vector<bool> seen(module.types.size());
  for (const Global& global : module.globals) add_targets(module, global.variable.type, seen, shared.targets);
  if (!shared.any()) return shared;
  shared.globals.resize(module.types.size());
  for (const Pou& pou : module.pous) {
    const std::vector<bool> in_out = in_out_handles(module, pou.body);
    for (std::size_t i = 0; i < pou.body.insts.size(); ++i) {
      const Inst& inst = pou.body.insts[i];
      if (inst.op != Op::kMakeRef || in_out[i]) continue;
      const Place& root = root_of(pou.body, PlaceId{inst.a});
      const TypeRef target = pou.body.places[inst.a].type;
      if (root.kind != Place::Kind::kGlobal || !shared.targets[target.index]) continue;
      std::vector<std::uint32_t>& globals = shared.globals[target.index];
      if (std::find(globals.begin(), globals.end(), root.index) == globals.end()) globals.push_back(root.index);
    }
  }
  return shared;
}

/// Whether `place` is what a REF_TO refers to, and not what the POU got as VAR_IN_OUT.
bool is_referred(const Pou& pou, const Place& place) {
  if (place.kind != Place::Kind::kDeref) return false;
  const Inst& made = pou.body.insts[place.index];
  if (made.op != Op::kLoad) return true;
  const Place& from = pou.body.places[made.a];
  const bool variable = from.kind == Place::Kind::kInstance || from.kind == Place::Kind::kFrame;
  return !variable || pou.variables[from.index].role != Role::kInOut;
}

/// Adds the globals that the body of `pou` reads and writes, by name or through a reference.
void add_global_use(const Module& module, const Pou& pou, const SharedReferences& shared, GlobalUse& use) {
  const auto mark = [&](std::uint32_t global, bool read, bool written) {
    if (read) use.read[global] = true;
    // A handle of a constant is read through, never written.
    if (written && !module.globals[global].variable.constant) use.written[global] = true;
  };
  for_each_access(pou.body, [&](std::uint32_t place, bool read, bool written) {
    const Place& root = root_of(pou.body, PlaceId{place});
    if (root.kind == Place::Kind::kGlobal) mark(root.index, read, written);
    if (shared.globals.empty() || !is_referred(pou, root)) return;
    for (const std::uint32_t global : shared.globals[root.type.index]) mark(global, read, written);
  });
}

void add_located(const LocatedPart& part, GlobalUse& use) {
  use.read[part.global] = true;
  if (part.output) use.written[part.global] = true;
}

}  // namespace

GlobalUse global_use(const Module& module, const Task& task) {
  GlobalUse use;
  use.read.resize(module.globals.size());
  use.written.resize(module.globals.size());
  const SharedReferences shared = shared_references(module);
  for (const std::uint32_t pou : reached_pous(module, task)) add_global_use(module, module.pous[pou], shared, use);
  for (const ProgramInstance& program : task.programs) {
    for (const InstanceWire& wire : program.wires) (wire.output ? use.written : use.read)[wire.global] = true;
    for (const LocatedPart& part : program.located) add_located(part, use);
  }
  for (const LocatedInGlobal& located : module.located) {
    if (use.read[located.root] || use.written[located.root]) add_located(located.part, use);
  }
  return use;
}

}  // namespace plc::ir
