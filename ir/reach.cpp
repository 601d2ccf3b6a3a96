#include "ir/reach.h"

#include <algorithm>
#include <set>
#include <tuple>
#include <utility>

namespace plc::ir {

const Place& root_of(const Body& body, PlaceId place) {
  const Place* p = &body.places[place.index];
  while (p->parent.valid()) p = &body.places[p->parent.index];
  return *p;
}

const Place& reached_root(const Body& body, PlaceId place) {
  const Place* root = &root_of(body, place);
  while (root->kind == Place::Kind::kDeref && body.insts[root->index].op == Op::kAddress) {
    root = &root_of(body, PlaceId{body.insts[root->index].a});
  }
  return *root;
}

std::optional<std::uint32_t> callee_of(const Module& module, const Body& body, const Inst& inst) {
  if (inst.op == Op::kCallPou) return inst.a;
  return inst.op == Op::kRun ? module.pou_run_by(body, inst) : std::nullopt;
}

std::vector<std::uint32_t> callees(const Module& module, std::uint32_t pou) {
  std::vector<std::uint32_t> found;
  std::vector<bool> seen(module.pous.size());
  const Body& body = module.pous[pou].body;
  for (const Inst& inst : body.insts) {
    const auto callee = callee_of(module, body, inst);
    if (!callee || seen[*callee]) continue;
    seen[*callee] = true;
    found.push_back(*callee);
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

/// By value: whether the address of a place goes anywhere. That of a union serves its members alone.
std::vector<bool> kept_addresses(const Body& body) {
  std::vector<bool> kept(body.insts.size());
  for (const Inst& inst : body.insts) {
    if (inst.op == Op::kStore) kept[inst.b] = true;
    if (inst.op == Op::kPointerRef || inst.op == Op::kPointerTo32) kept[inst.a] = true;
  }
  for (const ValueId argument : body.args) kept[argument.index] = true;
  for (const CallArg& argument : body.call_args) {
    if (argument.value.valid()) kept[argument.value.index] = true;
  }
  return kept;
}

/// Calls visit(instruction, place, read, written) for every access of the body.
template <typename Visit>
void for_each_access(const Body& body, Visit&& visit) {
  const std::vector<bool> kept = kept_addresses(body);
  for (const Inst& inst : body.insts) {
    // A partly written aggregate is exported whole: the rest of it has to be imported.
    const auto write = [&](std::uint32_t place) { visit(inst, place, body.places[place].parent.valid(), true); };
    switch (inst.op) {
      case Op::kLoad:
        visit(inst, inst.a, true, false);
        break;
      case Op::kStore:
        write(inst.a);
        break;
      case Op::kCopy:
        write(inst.a);
        visit(inst, inst.b, true, false);
        break;
      case Op::kRun:
      case Op::kMakeRef:
        visit(inst, inst.a, true, true);
        break;
      case Op::kAddress:
        if (kept[static_cast<std::size_t>(&inst - body.insts.data())]) visit(inst, inst.a, true, true);
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

/// Whether a value of a structure or array goes anywhere.
bool is_passed_on(const Body& body, std::uint32_t value) {
  return std::any_of(body.insts.begin(), body.insts.end(),
                     [value](const Inst& inst) { return inst.op == Op::kStore && inst.b == value; }) ||
         std::any_of(body.call_args.begin(), body.call_args.end(), [value](const CallArg& arg) {
           return arg.kind == CallArg::Kind::kInput && arg.value.index == value;
         });
}

}  // namespace

std::optional<SourceRef> first_access(const Body& body, std::uint32_t global) {
  std::optional<SourceRef> found;
  for_each_access(body, [&](const Inst& inst, std::uint32_t place, bool, bool) {
    const Place& root = reached_root(body, PlaceId{place});
    if (found || root.kind != Place::Kind::kGlobal || root.index != global) return;
    // Drawings load what is wired to an in-out pin, and throw it away.
    const bool whole = inst.op == Op::kLoad && !body.places[place].parent.valid();
    const auto value = static_cast<std::uint32_t>(&inst - body.insts.data());
    if (!whole || is_passed_on(body, value)) found = body.sources[inst.source];
  });
  return found;
}

namespace {

void add_targets(const Module& module, TypeRef type, std::vector<bool>& seen, std::vector<bool>& targets) {
  if (seen[type.index]) return;
  seen[type.index] = true;
  const Type& t = module.types[type];
  if (t.kind == TypeKind::kReference) targets[t.element.index] = true;
  if (t.kind == TypeKind::kArray) add_targets(module, t.element, seen, targets);
  for (const TypeField& field : t.fields) add_targets(module, field.type, seen, targets);
  if (t.kind != TypeKind::kPou) return;
  for (const Variable& v : module.pous[t.pou].variables) {
    if (v.role != Role::kExternal) add_targets(module, v.type, seen, targets);
  }
}

/// Whether a value of this type, or the instance that it is, holds a pointer.
bool holds_pointer(const Module& module, TypeRef type, std::vector<bool>& seen) {
  if (seen[type.index]) return false;
  seen[type.index] = true;
  const Type& t = module.types[type];
  if (t.kind == TypeKind::kPointer) return true;
  if (t.kind == TypeKind::kArray && holds_pointer(module, t.element, seen)) return true;
  const auto field = [&](const TypeField& one) { return holds_pointer(module, one.type, seen); };
  if (std::any_of(t.fields.begin(), t.fields.end(), field)) return true;
  if (t.kind != TypeKind::kPou) return false;
  const std::vector<Variable>& variables = module.pous[t.pou].variables;
  return std::any_of(variables.begin(), variables.end(), [&](const Variable& v) {
    return v.role != Role::kExternal && holds_pointer(module, v.type, seen);
  });
}

/// Whether `place` is what a variable of the POU got as VAR_IN_OUT: its caller, in the same task, has named it.
bool is_in_out(const Module& module, const Pou& pou, const Place& place) {
  const Inst& made = pou.body.insts[place.index];
  if (made.op != Op::kLoad) return false;
  const Place& from = pou.body.places[made.a];
  const bool variable = from.kind == Place::Kind::kInstance || from.kind == Place::Kind::kFrame;
  return variable && module.owner_of(pou).variables[from.index].role == Role::kInOut;
}

/// By value: whether it is a handle for a VAR_IN_OUT that ends with the call. Those of instances that other tasks may
/// see stay.
std::vector<bool> passing_handles(const Module& module, const Pou& pou) {
  const Body& body = pou.body;
  std::vector<bool> found(body.insts.size());
  for (const CallArg& arg : body.call_args) {
    if (arg.kind == CallArg::Kind::kInOut) found[arg.value.index] = true;
  }
  for (const Inst& inst : body.insts) {
    if (inst.op != Op::kStore) continue;
    const Place& place = body.places[inst.a];
    if (place.kind != Place::Kind::kField) continue;
    const Type& owner = module.types[body.places[place.parent.index].type];
    const Place& root = root_of(body, PlaceId{inst.a});
    const bool own = root.kind == Place::Kind::kInstance || root.kind == Place::Kind::kFrame;
    if (own && owner.kind == TypeKind::kPou && module.pous[owner.pou].variables[place.index].role == Role::kInOut)
      found[inst.b] = true;
  }
  return found;
}

/// Whether `place`, a kDeref, is what a pointer leads to.
bool is_pointer(const Module& module, const Body& body, const Place& place) {
  const Inst& made = body.insts[place.index];
  return made.op == Op::kPointerRef || module.types[made.type].kind == TypeKind::kPointer;
}

/// Adds the globals that the body of `pou` reads and writes, by name or through a reference.
void add_global_use(const Module& module, const Pou& pou, const SharedReferences& shared, GlobalUse& use,
                    GlobalUse& through) {
  const auto mark = [&](const Inst& inst, std::uint32_t global, bool read, bool written) {
    if (read) use.read[global] = true;
    if (written && !module.globals[global].variable.constant) use.write(global, pou.body.sources[inst.source]);
  };
  for_each_access(pou.body, [&](const Inst& inst, std::uint32_t place, bool read, bool written) {
    const Place& root = reached_root(pou.body, PlaceId{place});
    if (root.kind == Place::Kind::kGlobal) mark(inst, root.index, read, written);
    if (root.kind == Place::Kind::kDeref && is_pointer(module, pou.body, root)) {
      // Made by this task it has named its global there; others find theirs in a global.
      for (const std::uint32_t global : shared.pointed) mark(inst, global, read, written);
      return;
    }
    if (root.kind != Place::Kind::kDeref || shared.globals.empty() || is_in_out(module, pou, root)) return;
    const std::uint32_t type = root.type.index;
    if (!(read && !through.read[type]) && !(written && !through.written[type])) return;
    through.read[type] = through.read[type] || read;
    through.written[type] = through.written[type] || written;
    for (const std::uint32_t global : shared.globals[type]) mark(inst, global, read, written);
  });
}

void add_located(const LocatedPart& part, bool written, const SourceRef& at, GlobalUse& use) {
  use.read[part.global] = true;
  if (written) use.write(part.global, at);
}

}  // namespace

namespace {

/// Globals whose address is taken anywhere, where pointers may go from task to task: a global holds one.
std::vector<std::uint32_t> pointed_globals(const Module& module) {
  std::vector<bool> seen(module.types.size());
  const bool shared = std::any_of(module.globals.begin(), module.globals.end(), [&](const Global& global) {
    return holds_pointer(module, global.variable.type, seen);
  });
  if (!shared) return {};
  std::set<std::uint32_t> pointed;
  for (const Pou& pou : module.pous) {
    const std::vector<bool> kept = kept_addresses(pou.body);
    for (std::size_t i = 0; i < pou.body.insts.size(); ++i) {
      const Inst& inst = pou.body.insts[i];
      if (inst.op != Op::kAddress && inst.op != Op::kMakeRef) continue;
      if (inst.op == Op::kAddress && !kept[i]) continue;
      const Place& root = reached_root(pou.body, PlaceId{inst.a});
      if (root.kind == Place::Kind::kGlobal) pointed.insert(root.index);
    }
  }
  return {pointed.begin(), pointed.end()};
}

}  // namespace

SharedReferences shared_references(const Module& module) {
  SharedReferences shared;
  shared.pointed = pointed_globals(module);
  std::vector<bool> targets(module.types.size());
  std::vector<bool> seen(module.types.size());
  for (const Global& global : module.globals) add_targets(module, global.variable.type, seen, targets);
  if (std::find(targets.begin(), targets.end(), true) == targets.end()) return shared;

  // By type: the globals that references of this type refer to, or to a part of; the same for in-outs, which end with
  // their call. A handle that is made from another one has all globals of that.
  enum Kind : std::uint8_t { kReference, kInOut };
  std::vector<std::set<std::uint32_t>> reached[2];
  for (auto& of_kind : reached) of_kind.resize(module.types.size());
  std::set<std::tuple<Kind, std::uint32_t, Kind, std::uint32_t>> derived;  // kind and type of the whole, of the part
  for (const Pou& pou : module.pous) {
    const std::vector<bool> passing = passing_handles(module, pou);
    for (std::size_t i = 0; i < pou.body.insts.size(); ++i) {
      const Inst& inst = pou.body.insts[i];
      if (inst.op != Op::kMakeRef) continue;
      const Place& root = root_of(pou.body, PlaceId{inst.a});
      const Kind kind = passing[i] ? kInOut : kReference;
      const std::uint32_t target = pou.body.places[inst.a].type.index;
      if (root.kind == Place::Kind::kGlobal) reached[kind][target].insert(root.index);
      if (root.kind != Place::Kind::kDeref) continue;
      derived.emplace(is_in_out(module, pou, root) ? kInOut : kReference, root.type.index, kind, target);
    }
  }
  for (bool grows = true; grows;) {
    grows = false;
    for (const auto& [from, whole, to, part] : derived) {
      std::set<std::uint32_t>& all = reached[to][part];
      const std::size_t before = all.size();
      const std::set<std::uint32_t> more = reached[from][whole];
      all.insert(more.begin(), more.end());
      grows = grows || all.size() != before;
    }
  }
  shared.globals.resize(module.types.size());
  for (std::size_t type = 0; type < targets.size(); ++type) {
    const std::set<std::uint32_t>& all = reached[kReference][type];
    if (targets[type]) shared.globals[type].assign(all.begin(), all.end());
  }
  return shared;
}

void GlobalUse::write(std::uint32_t global, const SourceRef& at) {
  if (!written[global]) written_at[global] = at;
  written[global] = true;
}

GlobalUse global_use(const Module& module, const Task& task, const SharedReferences& shared) {
  GlobalUse use(module.globals.size());
  GlobalUse through(shared.globals.size());  // by type: accesses through references that are marked already
  for (const std::uint32_t pou : reached_pous(module, task)) {
    add_global_use(module, module.pous[pou], shared, use, through);
  }
  for (const ProgramInstance& program : task.programs) {
    if (program.global != Pou::kDeclared) {
      use.read[program.global] = true;
      use.write(program.global, program.at);
    }
    for (const InstanceWire& wire : program.wires) {
      if (wire.output) use.write(wire.global, program.at);
      if (!wire.output) use.read[wire.global] = true;
    }
    for (const LocatedPart& part : program.located) add_located(part, part.output, program.at, use);
  }
  for (const LocatedInGlobal& located : module.located) {
    const bool written = use.written[located.root];
    if (!use.read[located.root] && !written) continue;
    add_located(located.part, written && located.part.output, use.written_at[located.root], use);
  }
  return use;
}

}  // namespace plc::ir
