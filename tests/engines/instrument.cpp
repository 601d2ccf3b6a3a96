#include "tests/engines/instrument.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

namespace plc::test {
namespace {

using ir::Inst;
using ir::Op;
using ir::Place;

class Instrumenter {
 public:
  Instrumenter(ir::Module& module, std::uint32_t pou) : module_(module), pou_(pou), body_(module.pous[pou].body) {
    const ir::Pou& p = module.pous[pou];
    owner_ = p.owner == ir::Pou::kDeclared ? pou : p.owner;
    function_ = p.kind == ir::PouKind::kFunction;
  }

  std::vector<Instrumented> run() {
    std::multimap<std::uint32_t, std::uint32_t> after, before;
    std::set<std::tuple<std::int64_t, std::uint32_t, std::uint32_t, std::uint16_t, ir::ProbeSide>> seen;
    const std::vector<ir::Probe> probes = std::move(body_.probes);
    body_.probes.clear();
    for (const ir::Probe& probe : probes) {
      const auto& k = probe.key;
      if (!seen.emplace(k.local_id, k.line, k.column, k.pin, k.side).second) continue;
      const bool value = probe.value.valid();
      if (value ? !is_shown(body_.insts[probe.value.index].type)
                : probe.place.valid() && (!is_shown(body_.places[probe.place.index].type) || !is_static(probe.place))) {
        continue;
      }
      (value ? after : before)
          .emplace(value ? probe.value.index : probe.before, static_cast<std::uint32_t>(wanted_.size()));
      wanted_.push_back(&probe);
      declare(probe);
    }
    std::vector<Inst> old = std::move(body_.insts);
    body_.insts.clear();
    new_.assign(old.size(), 0);
    for (std::uint32_t i = 0; i <= old.size(); ++i) {
      const auto [b, e] = before.equal_range(i);
      for (auto it = b; it != e; ++it) note(it->second, ir::ValueId{});
      if (i == old.size()) break;
      new_[i] = static_cast<std::uint32_t>(body_.insts.size());
      source_ = old[i].source;
      body_.insts.push_back(rename(old[i]));
      const auto [b2, e2] = after.equal_range(i);
      for (auto it = b2; it != e2; ++it) note(it->second, ir::ValueId{new_[i]});
    }
    for (Place& place : body_.places) {
      if (place.kind == Place::Kind::kDeref || place.kind == Place::Kind::kElementAt) place.index = new_[place.index];
    }
    for (ir::ValueId& argument : body_.args) argument.index = new_[argument.index];
    for (ir::CallArg& argument : body_.call_args) {
      if (argument.value.valid()) argument.value.index = new_[argument.value.index];
    }
    return std::move(out_);
  }

 private:
  struct Places {
    ir::PlaceId value, ran, was_false, was_true;
  };

  [[nodiscard]] bool is_shown(ir::TypeRef type) const {
    const ir::TypeKind kind = module_.types[type].kind;
    return kind != ir::TypeKind::kReference && kind != ir::TypeKind::kPointer && module_.types.rep_of(type).has_value();
  }
  [[nodiscard]] bool is_static(ir::PlaceId place) const {
    for (; place.valid(); place = body_.places[place.index].parent) {
      const Place::Kind kind = body_.places[place.index].kind;
      if (kind == Place::Kind::kDeref || kind == Place::Kind::kElementAt) return false;
    }
    return true;
  }

  void declare(const ir::Probe& probe) {
    Instrumented one;
    one.key = probe.key;
    const std::string stem = "#probe." + std::to_string(pou_) + "." + std::to_string(out_.size());
    Places places;
    const auto add = [&](const char* part, ir::TypeRef type, ir::PlaceId& place) {
      ir::Variable variable;
      variable.name = stem + part;
      variable.type = type;
      variable.role = ir::Role::kHidden;
      Place made;
      made.type = type;
      if (function_) {
        made.kind = Place::Kind::kGlobal;
        made.index = static_cast<std::uint32_t>(module_.globals.size());
        ir::Global global;
        global.variable = variable;
        module_.globals.push_back(std::move(global));
      } else {
        made.kind = Place::Kind::kInstance;
        made.index = static_cast<std::uint32_t>(module_.pous[owner_].variables.size());
        module_.pous[owner_].variables.push_back(variable);
      }
      place = ir::PlaceId{static_cast<std::uint32_t>(body_.places.size())};
      body_.places.push_back(made);
      return variable.name;
    };
    ir::TypeRef type{};
    if (probe.value.valid()) type = body_.insts[probe.value.index].type;
    if (probe.place.valid()) type = body_.places[probe.place.index].type;
    one.ran = add(".ran", ir::kBoolType, places.ran);
    if (type.valid()) {
      one.is_bool = type == ir::kBoolType;
      one.value = add(".value", type, places.value);
    }
    if (one.is_bool) {
      one.was_false = add(".false", ir::kBoolType, places.was_false);
      one.was_true = add(".true", ir::kBoolType, places.was_true);
    }
    places_.push_back(places);
    out_.push_back(std::move(one));
  }

  std::uint32_t put(Op op, ir::TypeRef type, std::uint32_t a = 0, std::uint32_t b = 0) {
    Inst inst;
    inst.op = op;
    inst.type = type;
    inst.a = a;
    inst.b = b;
    inst.source = source_;
    body_.insts.push_back(inst);
    return static_cast<std::uint32_t>(body_.insts.size() - 1);
  }
  std::uint32_t load(ir::PlaceId place) { return put(Op::kLoad, body_.places[place.index].type, place.index); }
  void store(ir::PlaceId place, std::uint32_t value) { put(Op::kStore, {}, place.index, value); }

  void note(std::uint32_t number, ir::ValueId value) {
    const Places& places = places_[number];
    ir::Constant on;
    on.type = ir::kBoolType;
    on.bits = 1;
    body_.constants.push_back(on);
    store(places.ran, put(Op::kConst, ir::kBoolType, static_cast<std::uint32_t>(body_.constants.size() - 1)));
    if (!places.value.valid()) return;
    const std::uint32_t v = value.valid() ? value.index : load(wanted_[number]->place);
    store(places.value, v);
    if (!places.was_false.valid()) return;
    store(places.was_true, put(Op::kOr, ir::kBoolType, load(places.was_true), v));
    const std::uint32_t inverted = put(Op::kNot, ir::kBoolType, v);
    store(places.was_false, put(Op::kOr, ir::kBoolType, load(places.was_false), inverted));
  }

  [[nodiscard]] Inst rename(Inst inst) const {
    switch (inst.op) {
      case Op::kStore:
      case Op::kJumpIf:
      case Op::kJumpIfNot:
        inst.b = new_[inst.b];
        break;
      case Op::kAnd:
      case Op::kOr:
      case Op::kXor:
      case Op::kInsert:
      case Op::kSameRef:
        inst.a = new_[inst.a];
        inst.b = new_[inst.b];
        break;
      case Op::kNot:
      case Op::kPointerRef:
      case Op::kPointerTo32:
      case Op::kPointerFrom32:
      case Op::kExtract:
      case Op::kRange:
        inst.a = new_[inst.a];
        break;
      default:
        break;
    }
    return inst;
  }

  ir::Module& module_;
  std::uint32_t pou_, owner_ = 0;
  ir::Body& body_;
  bool function_ = false;
  std::vector<const ir::Probe*> wanted_;
  std::vector<Places> places_;
  std::vector<Instrumented> out_;
  std::vector<std::uint32_t> new_;  ///< by old number of an instruction
  std::uint32_t source_ = 0;
};

}  // namespace

std::vector<std::vector<Instrumented>> instrument(ir::Module& module) {
  std::vector<std::vector<Instrumented>> out(module.pous.size());
  for (std::uint32_t p = 0; p < module.pous.size(); ++p) out[p] = Instrumenter(module, p).run();
  module.probes = false;
  return out;
}

}  // namespace plc::test
