#include "ir/reach.h"

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

void add_global_use(const Module& module, std::uint32_t pou, GlobalUse& use) {
  use.read.resize(module.globals.size());
  use.written.resize(module.globals.size());
  const Body& body = module.pous[pou].body;
  const auto mark = [&](std::uint32_t place, bool read, bool written) {
    const Place& root = root_of(body, PlaceId{place});
    if (root.kind != Place::Kind::kGlobal) return;
    if (read) use.read[root.index] = true;
    // A handle of a constant is read through, never written.
    if (written && !module.globals[root.index].variable.constant) use.written[root.index] = true;
  };
  for (const Inst& inst : body.insts) {
    switch (inst.op) {
      case Op::kLoad:
        mark(inst.a, true, false);
        break;
      case Op::kStore:
        // A partly written aggregate is exported whole: the rest of it has to be imported.
        mark(inst.a, body.places[inst.a].parent.valid(), true);
        break;
      case Op::kCopy:
        mark(inst.a, body.places[inst.a].parent.valid(), true);
        mark(inst.b, true, false);
        break;
      case Op::kRun:
      case Op::kMakeRef:
        mark(inst.a, true, true);
        break;
      case Op::kCallPou:
        for (std::uint32_t i = 0; i < inst.count; ++i) {
          const CallArg& arg = body.call_args[inst.b + i];
          if (arg.kind == CallArg::Kind::kOutput)
            mark(arg.place.index, body.places[arg.place.index].parent.valid(), true);
        }
        break;
      default:
        break;
    }
  }
}

GlobalUse global_use(const Module& module, const Task& task) {
  GlobalUse use;
  use.read.resize(module.globals.size());
  use.written.resize(module.globals.size());
  for (const std::uint32_t pou : reached_pous(module, task)) add_global_use(module, pou, use);
  for (const ProgramInstance& program : task.programs) {
    for (const InstanceWire& wire : program.wires) (wire.output ? use.written : use.read)[wire.global] = true;
  }
  return use;
}

}  // namespace plc::ir
