// Evaluator of IR, the slow and obvious way: what generated code is compared with. Every instruction is executed where
// it stands, values are kept, memory is a map from paths to numbers.
//
// In: a module whose bodies use scalars, BOOL logic, standard functions of scalars, parts of words, subranges, arrays,
// references, function block POUs and jumps. Out: memory after a scan. Does not belong here: strings, standard blocks,
// layout.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "ir/ir.h"

namespace plc::test {

class IrEvaluator {
 public:
  struct Value;
  using Parts = std::map<std::string, Value>;
  struct Value {
    std::uint64_t bits = 0;
    std::string target;  ///< of references; empty = null
    Parts parts;         ///< of aggregates, by the rest of the path: ".N", "[2]"
  };

  explicit IrEvaluator(const ir::Module& module) : module_(module) {}

  /// Memory by path: globals by name, others "<instance>.<variable>", elements "a[2]" with declared indices. What was
  /// never written is 0.
  std::map<std::string, Value> memory;
  std::uint64_t steps = 0;
  std::uint64_t events = 0;

  /// One execution of the body of `pou` on instance `instance`. False when it took too many steps.
  bool run(std::uint32_t pou, const std::string& instance) {
    const ir::Pou& p = module_.pous[pou];
    std::vector<Value> values(p.body.insts.size());
    std::vector<std::size_t> labels(p.body.label_count);
    for (std::size_t i = 0; i < p.body.insts.size(); ++i) {
      if (p.body.insts[i].op == ir::Op::kLabel) labels[p.body.insts[i].a] = i;
    }
    for (std::size_t at = 0; at < p.body.insts.size(); ++at) {
      if (++steps > 1'000'000) return false;
      const ir::Inst& inst = p.body.insts[at];
      Value& result = values[at];
      const auto bit = [&](std::uint32_t v) { return values[v].bits & 1u; };
      switch (inst.op) {
        case ir::Op::kConst:
          result.bits = p.body.constants[inst.a].bits;
          break;
        case ir::Op::kLoad: {
          const std::string from = path(p, instance, values, inst.a);
          if (from.empty()) ++events;
          if (module_.types.rep_of(inst.type)) {
            result = from.empty() ? Value{} : memory[from];
          } else {
            result.parts = from.empty() ? Parts{} : parts_of(from);
          }
          break;
        }
        case ir::Op::kStore: {
          const std::string to = path(p, instance, values, inst.a);
          if (!to.empty() && module_.types.rep_of(p.body.insts[inst.b].type)) {
            memory[to] = values[inst.b];
          } else if (!to.empty()) {
            for (const auto& part : parts_of(to)) memory.erase(to + part.first);
            for (const auto& part : values[inst.b].parts) memory[to + part.first] = part.second;
          }
          if (to.empty()) ++events;
          break;
        }
        case ir::Op::kAnd:
          result.bits = bit(inst.a) & bit(inst.b);
          break;
        case ir::Op::kOr:
          result.bits = bit(inst.a) | bit(inst.b);
          break;
        case ir::Op::kXor:
          result.bits = bit(inst.a) ^ bit(inst.b);
          break;
        case ir::Op::kNot:
          result.bits = bit(inst.a) ^ 1u;
          break;
        case ir::Op::kCall:
          result.bits = call(p, inst, values);
          break;
        case ir::Op::kRun: {
          const std::string fb = path(p, instance, values, inst.a);
          const ir::Type& type = module_.types[p.body.places[inst.a].type];
          if (fb.empty()) ++events;
          if (!fb.empty() && !run(type.pou, fb)) return false;
          break;
        }
        case ir::Op::kJump:
          at = labels[inst.a];
          break;
        case ir::Op::kJumpIf:
          if (bit(inst.b) != 0) at = labels[inst.a];
          break;
        case ir::Op::kJumpIfNot:
          if (bit(inst.b) == 0) at = labels[inst.a];
          break;
        case ir::Op::kReturn:
          return true;
        case ir::Op::kMakeRef:
          result.target = path(p, instance, values, inst.a);
          if (result.target.empty()) ++events;
          break;
        case ir::Op::kSameRef:
          result.bits = values[inst.a].target == values[inst.b].target ? 1 : 0;
          break;
        case ir::Op::kExtract:
          result.bits = (values[inst.a].bits >> inst.b) & mask_of(inst.type);
          break;
        case ir::Op::kInsert: {
          const std::uint64_t mask = mask_of(p.body.insts[inst.b].type);
          result.bits = (values[inst.a].bits & ~(mask << inst.count)) | (values[inst.b].bits & mask) << inst.count;
          break;
        }
        case ir::Op::kRange: {
          const ir::Type& limits = module_.types[inst.type];
          const std::int64_t value = signed_value(inst.type, values[inst.a].bits);
          const std::int64_t held = std::clamp(value, limits.lower, limits.upper);
          if (held != value) ++events;
          result.bits = static_cast<std::uint64_t>(held);
          break;
        }
        default:
          break;
      }
    }
    return true;
  }

 private:
  /// Everything below `path`, by the rest of the path.
  Parts parts_of(const std::string& path) const {
    Parts parts;
    for (auto it = memory.lower_bound(path); it != memory.end() && it->first.compare(0, path.size(), path) == 0; ++it) {
      const char next = it->first.size() > path.size() ? it->first[path.size()] : '\0';
      if (next == '.' || next == '[') parts.emplace(it->first.substr(path.size()), it->second);
    }
    return parts;
  }

  std::int64_t signed_value(ir::TypeRef type, std::uint64_t bits) const {
    const auto rep = module_.types.rep_of(type).value_or(core::Rep::kI64);
    const unsigned shift = 64 - core::rep_bytes(rep) * 8;
    const bool is_signed = rep == core::Rep::kI8 || rep == core::Rep::kI16 || rep == core::Rep::kI32;
    return is_signed ? static_cast<std::int64_t>(bits << shift) >> shift : static_cast<std::int64_t>(bits);
  }

  std::uint64_t mask_of(ir::TypeRef type) const {
    const auto rep = *module_.types.rep_of(type);
    const unsigned width = rep == core::Rep::kBool ? 1 : core::rep_bytes(rep) * 8;
    return width >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << width) - 1;
  }

  std::uint64_t call(const ir::Pou& p, const ir::Inst& inst, const std::vector<Value>& values) {
    const stdlib::Overload& overload = *p.body.functions[inst.a];
    std::vector<std::uint64_t> bits;
    std::vector<const void*> pointers;
    for (std::uint32_t i = 0; i < inst.count; ++i) bits.push_back(values[p.body.args[inst.b + i].index].bits);
    for (const std::uint64_t& b : bits) pointers.push_back(&b);
    std::uint64_t result = 0;
    if (overload.kernel(&result, pointers.data(), inst.count) != stdlib::Event::kNone) ++events;
    return result;
  }

  std::string path(const ir::Pou& p, const std::string& instance, const std::vector<Value>& values,
                   std::uint32_t place) const {
    const ir::Place& at = p.body.places[place];
    switch (at.kind) {
      case ir::Place::Kind::kGlobal:
        return module_.globals[at.index].variable.name;
      case ir::Place::Kind::kInstance:
      case ir::Place::Kind::kFrame:
        return instance + "." + p.variables[at.index].name;
      case ir::Place::Kind::kDeref:
        return values[at.index].target;
      case ir::Place::Kind::kField:
      case ir::Place::Kind::kElement:
      case ir::Place::Kind::kElementAt:
        break;
      case ir::Place::Kind::kSelf:
        return instance;
      case ir::Place::Kind::kPart:
      case ir::Place::Kind::kCharacter:
        return {};
    }
    const std::string base = path(p, instance, values, at.parent.index);
    if (base.empty()) return base;
    const ir::Type& type = module_.types[p.body.places[at.parent.index].type];
    if (at.kind == ir::Place::Kind::kElement) {
      return base + "[" + std::to_string(type.lower + static_cast<std::int64_t>(at.index)) + "]";
    }
    if (at.kind == ir::Place::Kind::kElementAt) {
      const std::int64_t index = signed_value(p.body.insts[at.index].type, values[at.index].bits);
      return index < type.lower || index > type.upper ? std::string() : base + "[" + std::to_string(index) + "]";
    }
    const std::string& field =
        type.kind == ir::TypeKind::kPou ? module_.pous[type.pou].variables[at.index].name : type.fields[at.index].name;
    return base + "." + field;
  }

  const ir::Module& module_;
};

}  // namespace plc::test
