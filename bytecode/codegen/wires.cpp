#include "bytecode/codegen/wires.h"

#include <algorithm>

namespace plc::bytecode {
namespace {

using ir::Inst;
using ir::Op;
using ir::Place;

class Finder {
 public:
  Finder(const ir::Module& module, const ir::Pou& pou, const ir::Body& body, const Analysis& analysis)
      : module_(module), pou_(pou), body_(body), analysis_(analysis) {}

  std::vector<Wire> find() {
    std::vector<Wire> wires;
    if (pou_.owner != ir::Pou::kDeclared || !pou_.actions.empty()) return wires;  // other bodies may run the block too
    for (std::uint32_t run = 0; run < body_.insts.size(); ++run) {
      const Inst& inst = body_.insts[run];
      if (inst.op != Op::kRun || !is_taskblock(inst.a) || !in_instance(inst.a)) continue;
      if (uses_of(inst.a, Op::kRun) != 1 || uses_of(inst.a, Op::kMakeRef) != 0 || uses_of(inst.a, Op::kAddress) != 0) {
        continue;
      }
      add(run, inst.a, wires);
    }
    return wires;
  }

 private:
  [[nodiscard]] bool is_taskblock(std::uint32_t place) const {
    const ir::Type& type = module_.types[body_.places[place].type];
    return type.kind == ir::TypeKind::kPou && module_.pous[type.pou].taskblock != 0;
  }
  [[nodiscard]] bool in_instance(std::uint32_t place) const {
    const PlaceInfo& info = analysis_.places[place];
    return info.is_static() && body_.places[info.root].kind == Place::Kind::kInstance;
  }
  /// True when `inner` is `outer` or a part of it.
  [[nodiscard]] bool is_within(std::uint32_t inner, std::uint32_t outer) const {
    for (ir::PlaceId at{inner}; at.valid(); at = body_.places[at.index].parent) {
      if (at.index == outer) return true;
    }
    return false;
  }
  /// Instructions of this kind that name the place, a part of it, or what it is a part of.
  [[nodiscard]] std::size_t uses_of(std::uint32_t place, Op op) const {
    return static_cast<std::size_t>(std::count_if(body_.insts.begin(), body_.insts.end(), [&](const Inst& inst) {
      return inst.op == op && (is_within(inst.a, place) || is_within(place, inst.a));
    }));
  }
  /// Instructions that read or write the place, a part of it, or what it is a part of.
  [[nodiscard]] std::size_t accesses(std::uint32_t place) const {
    std::size_t count = 0;
    const auto meets = [&](std::uint32_t at) { return is_within(at, place) || is_within(place, at); };
    for (const Inst& inst : body_.insts) {
      const bool first = inst.op == Op::kLoad || inst.op == Op::kStore || inst.op == Op::kCopy ||
                         inst.op == Op::kMakeRef || inst.op == Op::kAddress;
      if (first && meets(inst.a)) ++count;
      if (inst.op == Op::kCopy && meets(inst.b)) ++count;
    }
    for (const ir::CallArg& arg : body_.call_args) {
      if (arg.kind == ir::CallArg::Kind::kOutput && meets(arg.place.index)) ++count;
    }
    return count;
  }

  /// Stores to inputs of the instance, back from where it runs to the first jump or label.
  void add(std::uint32_t run, std::uint32_t instance, std::vector<Wire>& wires) const {
    for (std::uint32_t i = run; i-- > 0;) {
      const Inst& store = body_.insts[i];
      if (store.op == Op::kLabel || store.op == Op::kJump || store.op == Op::kJumpIf || store.op == Op::kJumpIfNot ||
          store.op == Op::kReturn || store.op == Op::kRun) {
        return;
      }
      if (store.op != Op::kStore || body_.places[store.a].kind != Place::Kind::kField) continue;
      const Place& input = body_.places[store.a];
      if (input.parent.index != instance || accesses(store.a) != 1) continue;
      const Inst& load = body_.insts[store.b];
      if (load.op != Op::kLoad || load.type != input.type || body_.places[load.a].type != input.type) continue;
      if (!in_instance(load.a) || is_within(load.a, instance) || analysis_.values[store.b].hazard <= run) continue;
      wires.push_back({i, instance, input.index, load.a});
    }
  }

  const ir::Module& module_;
  const ir::Pou& pou_;
  const ir::Body& body_;
  const Analysis& analysis_;
};

}  // namespace

std::vector<Wire> find_wires(const ir::Module& module, const ir::Pou& pou, const ir::Body& body,
                             const Analysis& analysis) {
  return Finder(module, pou, body, analysis).find();
}

}  // namespace plc::bytecode
