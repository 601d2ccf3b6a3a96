#include "bytecode/codegen/analysis.h"

#include <algorithm>

namespace plc::bytecode {
namespace {

using ir::Inst;
using ir::Op;
using ir::Place;

class Analyser {
 public:
  Analyser(const ir::Module& module, const ir::Pou& pou, const ir::Body& body, Analysis& out)
      : module_(module), pou_(pou), body_(body), out_(out) {}

  void run() {
    out_.values.assign(body_.insts.size(), {});
    find_roots();
    forward();
    backward();
  }

 private:
  void find_roots() {
    out_.places.resize(body_.places.size());
    for (std::uint32_t p = 0; p < body_.places.size(); ++p) {
      const Place& place = body_.places[p];
      if (place.parent.valid()) {
        out_.places[p] = out_.places[place.parent.index];
        if (place.kind == Place::Kind::kElementAt && out_.places[p].array == kUnset)
          out_.places[p].array = place.parent.index;
      } else {
        out_.places[p] = {p, place.kind == Place::Kind::kDeref ? place.index : kUnset, kUnset};
      }
    }
  }

  // ---- aliases, labels ----

  void forward() {
    out_.label_at.assign(body_.label_count, kUnset);
    for (std::uint32_t i = 0; i < body_.insts.size(); ++i) {
      const Inst& inst = body_.insts[i];
      ValueInfo& v = out_.values[i];
      v.literal = i * 2;
      switch (inst.op) {
        case Op::kConst:
          if (inst.type == ir::kBoolType) v.literal = body_.constants[inst.a].bits ? kTrueLiteral : kFalseLiteral;
          break;
        case Op::kNot:
          v.literal = literal(inst.a) ^ 1u;
          break;
        case Op::kAnd:
        case Op::kOr:
        case Op::kXor:
          simplify(i, inst);
          break;
        case Op::kLabel:
          out_.label_at[inst.a] = i;
          break;
        default:
          break;
      }
    }
  }

  Literal literal(std::uint32_t value) const { return out_.values[value].literal; }

  void simplify(std::uint32_t i, const Inst& inst) {
    const Literal a = literal(inst.a);
    const Literal b = literal(inst.b);
    ValueInfo& v = out_.values[i];
    if (inst.op == Op::kXor) {
      if (is_constant(a)) {
        v.literal = b ^ (a & 1u);
      } else if (is_constant(b)) {
        v.literal = a ^ (b & 1u);
      } else if (value_of(a) == value_of(b)) {
        v.literal = a == b ? kFalseLiteral : kTrueLiteral;
      }
    } else {
      const Literal neutral = inst.op == Op::kAnd ? kTrueLiteral : kFalseLiteral;
      const Literal absorbing = neutral ^ 1u;
      if (a == absorbing || b == absorbing || (a ^ b) == 1u) {
        v.literal = absorbing;
      } else if (a == neutral || a == b) {
        v.literal = b;
      } else if (b == neutral) {
        v.literal = a;
      }
    }
    if (v.literal != i * 2) return;
    const std::uint32_t sum = std::uint32_t{out_.values[value_of(a)].leaves} + out_.values[value_of(b)].leaves;
    v.leaves = static_cast<std::uint8_t>(std::min<std::uint32_t>(sum, 255));
  }

  // ---- uses, hazards ----

  void backward() {
    next_whole_.assign(body_.places.size(), kUnset);
    next_any_.assign(body_.places.size(), kUnset);
    mark_loops();
    for (auto i = static_cast<std::uint32_t>(body_.insts.size()); i-- > 0;) {
      const Inst& inst = body_.insts[i];
      ValueInfo& v = out_.values[i];
      v.live = is_live(inst, v);
      if (!v.live) continue;
      v.pinned = next_loop_ <= v.evaluated;
      v.crosses_label = next_label_ <= v.last_use;
      if (inst.op == Op::kLoad || inst.op == Op::kStore) v.hazard = next_write(inst.a);
      use_operands(i, inst);
      write(i, inst);
    }
  }

  /// Marks the labels that a later jump goes back to.
  void mark_loops() {
    loop_head_.assign(body_.label_count, false);
    for (std::uint32_t i = 0; i < body_.insts.size(); ++i) {
      const Inst& inst = body_.insts[i];
      const bool jumps = inst.op == Op::kJump || inst.op == Op::kJumpIf || inst.op == Op::kJumpIfNot;
      if (jumps && out_.label_at[inst.a] < i) loop_head_[inst.a] = true;
    }
  }

  bool is_live(const Inst& inst, const ValueInfo& v) const {
    switch (inst.op) {
      case Op::kLoad:
      case Op::kMakeRef:
      case Op::kAddress:
        // A reference to nothing, an index outside: events, whoever reads the value.
        return v.uses != 0 || !out_.places[inst.a].is_static();
      case Op::kConst:
      case Op::kAnd:
      case Op::kOr:
      case Op::kXor:
      case Op::kNot:
      case Op::kPointerRef:
      case Op::kPointerTo32:
      case Op::kPointerFrom32:
      case Op::kExtract:
      case Op::kInsert:
      case Op::kSameRef:
      case Op::kEno:
        return v.uses != 0;
      case Op::kCall:
        return v.uses != 0 || !body_.functions[inst.a]->spec->events.empty();
      default:
        return true;
    }
  }

  void use(std::uint32_t user, const Inst& inst, std::uint32_t operand) {
    const Literal l = literal(operand);
    if (is_constant(l)) return;
    ValueInfo& v = out_.values[value_of(l)];
    ++v.uses;
    v.first_use = user;
    v.last_use = std::max(v.last_use, user);
    const ValueInfo& u = out_.values[user];
    const bool logic = is_logic(inst.op);
    v.evaluated = std::max(v.evaluated, logic ? u.evaluated : user);
    v.root_leaves = std::max(v.root_leaves, logic ? u.root_leaves : v.leaves);
  }

  void use_place(std::uint32_t user, const Inst& inst, std::uint32_t place) {
    const PlaceInfo& info = out_.places[place];
    if (info.reference != kUnset) use(user, inst, info.reference);
    if (info.array == kUnset) return;
    for (ir::PlaceId at{place}; at.index != info.array; at = body_.places[at.index].parent) {
      if (body_.places[at.index].kind == Place::Kind::kElementAt) use(user, inst, body_.places[at.index].index);
    }
  }

  void use_operands(std::uint32_t i, const Inst& inst) {
    switch (inst.op) {
      case Op::kStore:
        use(i, inst, inst.b);
        use_place(i, inst, inst.a);
        break;
      case Op::kCopy:
        use_place(i, inst, inst.a);
        use_place(i, inst, inst.b);
        break;
      case Op::kLoad:
      case Op::kRun:
      case Op::kMakeRef:
      case Op::kAddress:
        use_place(i, inst, inst.a);
        break;
      case Op::kPointerRef:
      case Op::kPointerTo32:
      case Op::kPointerFrom32:
      case Op::kExtract:
      case Op::kRange:
        use(i, inst, inst.a);
        break;
      case Op::kInsert:
      case Op::kSameRef:
        use(i, inst, inst.a);
        use(i, inst, inst.b);
        break;
      case Op::kAnd:
      case Op::kOr:
      case Op::kXor:
        if (out_.values[i].literal != i * 2) break;
        use(i, inst, inst.a);
        use(i, inst, inst.b);
        break;
      case Op::kCall:
        for (std::uint32_t k = 0; k < inst.count; ++k) use(i, inst, body_.args[inst.b + k].index);
        break;
      case Op::kCallPou:
        for (std::uint32_t k = 0; k < inst.count; ++k) {
          const ir::CallArg& arg = body_.call_args[inst.b + k];
          if (arg.kind == ir::CallArg::Kind::kOutput) {
            use_place(i, inst, arg.place.index);
          } else {
            use(i, inst, arg.value.index);
          }
        }
        break;
      case Op::kJumpIf:
      case Op::kJumpIfNot:
        use(i, inst, inst.b);
        break;
      default:
        break;
    }
  }

  /// First instruction known so far (that is, later than the current one) that may write into `place`.
  std::uint32_t next_write(std::uint32_t place) const {
    const Place& p = body_.places[place];
    // Copied where it is.
    if (!out_.places[place].is_static()) return kUnset;
    // The handle of an in-out stays the same while the body runs.
    const bool variable = p.kind == Place::Kind::kInstance || p.kind == Place::Kind::kFrame;
    if (variable && module_.owner_of(pou_).variables[p.index].role == ir::Role::kInOut) return kUnset;
    std::uint32_t next = next_world_;
    if (!module_.types.rep_of(p.type)) next = std::min(next, next_any_[out_.places[place].root]);
    for (ir::PlaceId at{place}; at.valid(); at = body_.places[at.index].parent) {
      next = std::min(next, next_whole_[at.index]);
    }
    return next;
  }

  void write_place(std::uint32_t i, std::uint32_t place) {
    if (out_.places[place].reference != kUnset) {
      next_world_ = i;  // a reference may point at any variable
      return;
    }
    // One element that only the running program knows: any of them.
    const std::uint32_t array = out_.places[place].array;
    next_whole_[array == kUnset ? place : array] = i;
    next_any_[out_.places[place].root] = i;
  }

  /// Standard blocks and taskblocks know no variable but their own.
  [[nodiscard]] bool touches_itself_only(const ir::Type& type) const {
    return type.kind == ir::TypeKind::kBlock ||
           (type.kind == ir::TypeKind::kPou && module_.pous[type.pou].taskblock != 0);
  }

  void write(std::uint32_t i, const Inst& inst) {
    switch (inst.op) {
      case Op::kStore:
      case Op::kCopy:
        write_place(i, inst.a);
        break;
      case Op::kRun:
        if (touches_itself_only(module_.types[body_.places[inst.a].type])) {
          write_place(i, inst.a);
        } else {
          next_world_ = i;
        }
        break;
      case Op::kCallPou:
        next_world_ = i;
        break;
      case Op::kLabel:
        // What follows runs again without what comes before.
        if (loop_head_[inst.a]) next_world_ = next_loop_ = i;
        next_label_ = i;
        break;
      default:
        break;
    }
  }

  const ir::Module& module_;
  const ir::Pou& pou_;
  const ir::Body& body_;
  Analysis& out_;
  std::vector<std::uint32_t> next_whole_;  ///< by place: next write of the whole place
  std::vector<std::uint32_t> next_any_;    ///< by root place: next write of any part
  std::vector<bool> loop_head_;
  std::uint32_t next_world_ = kUnset;  ///< next instruction that may write anything
  std::uint32_t next_loop_ = kUnset;   ///< next label that a later jump goes back to
  std::uint32_t next_label_ = kUnset;
};

}  // namespace

void analyse(const ir::Module& module, const ir::Pou& pou, const ir::Body& body, Analysis& out) {
  Analyser(module, pou, body, out).run();
}

}  // namespace plc::bytecode
