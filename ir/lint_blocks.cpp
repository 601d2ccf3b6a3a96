// Lints of function block instances: timers, counters and edge blocks called only under a condition, instances called
// twice in a scan, timers without a preset time.
//
// A block that remembers its inputs from call to call misses what happens between two calls. Those are the standard
// blocks with state beside their ports; SR and RS have none and are left out.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>
#include <unordered_map>

#include "core/text.h"
#include "ir/lint_findings.h"
#include "ir/text.h"

namespace plc::ir {
namespace {

using stdlib::Direction;

bool remembers(const stdlib::BlockSpec& block) {
  return std::any_of(block.fields.begin(), block.fields.end(),
                     [](const stdlib::Field& f) { return f.direction == Direction::kState; });
}

std::uint32_t field_index(const stdlib::BlockSpec& block, std::string_view name) {
  const auto found = std::find_if(block.fields.begin(), block.fields.end(),
                                  [&](const stdlib::Field& f) { return core::iequals(f.name, name); });
  return static_cast<std::uint32_t>(found - block.fields.begin());
}

/// Equal numbers for places that are written alike: "T[i]" read twice is loaded twice, an in-out each time it is used.
class PlaceNames {
 public:
  explicit PlaceNames(const Body& body) {
    names_.reserve(body.places.size());
    for (const Place& place : body.places) names_.push_back(name(body, place));
  }
  [[nodiscard]] std::uint32_t operator[](std::uint32_t place) const { return names_[place]; }

 private:
  std::uint32_t name(const Body& body, const Place& place) {
    const auto own = static_cast<std::uint32_t>(names_.size());
    std::uint32_t index = place.index;
    std::uint32_t parent = place.parent.valid() ? names_[place.parent.index] : own;
    // Most places are interned as they are.
    bool alike = place.parent.valid() && parent != place.parent.index;
    if (place.kind == Place::Kind::kElementAt) {
      index = index_name(body, ValueId{place.index});
      alike = true;
    }
    if (place.kind == Place::Kind::kDeref && body.insts[place.index].op == Op::kLoad) {
      index = 0;
      parent = names_[body.insts[place.index].a];
      alike = true;
    }
    if (!alike) return own;
    return known_.try_emplace({place.kind, index, parent}, own).first->second;
  }

  /// An index that loads a variable is named by the variable; others are names of their own, beyond those of places.
  [[nodiscard]] std::uint32_t index_name(const Body& body, ValueId index) const {
    const Inst& inst = body.insts[index.index];
    if (inst.op == Op::kLoad && inst.a < names_.size()) return names_[inst.a];
    return static_cast<std::uint32_t>(body.places.size()) + index.index;
  }

  std::vector<std::uint32_t> names_;
  std::map<std::tuple<Place::Kind, std::uint32_t, std::uint32_t>, std::uint32_t> known_;
};

/// The calls of one instance in one body.
struct Instance {
  std::uint32_t place;
  std::vector<std::uint32_t> calls;  ///< instructions that run, ascending
};

class Blocks {
 public:
  Blocks(const LintBody& body, Findings& findings) : b_(body), insts_(body.pou.body.insts), findings_(findings) {}

  void run() {
    const bool any = std::any_of(insts_.begin(), insts_.end(), [](const Inst& inst) { return inst.op == Op::kRun; });
    if (!any) return;
    const PlaceNames names(b_.body());
    std::unordered_map<std::uint32_t, std::size_t> index;
    std::vector<Instance> instances;
    for (std::uint32_t i = 0; i < insts_.size(); ++i) {
      // An action is no step of the block: calling it as often as one likes is what it is for.
      if (insts_[i].op != Op::kRun || insts_[i].b != 0) continue;
      if (!b_.flow.reached[i] || !is_named(insts_[i].a)) continue;
      const auto [it, fresh] = index.try_emplace(names[insts_[i].a], instances.size());
      if (fresh) instances.push_back({insts_[i].a, {}});
      instances[it->second].calls.push_back(i);
    }
    note_inputs(names);
    for (const Instance& instance : instances) look_at(instance, names[instance.place]);
  }

 private:
  /// What the body gives to one input of one instance.
  struct Given {
    bool something = false;
    bool literal_false = false;
  };

  void add(Lint lint, std::uint32_t index, std::string message, std::string help) {
    findings_.add(lint, b_.at(index), b_.pou.name, std::move(message), std::move(help));
  }
  [[nodiscard]] const Place& place(std::uint32_t id) const { return b_.body().places[id]; }

  [[nodiscard]] const Place& root(std::uint32_t id) const {
    const Place* p = &place(id);
    while (p->parent.valid()) p = &place(p->parent.index);
    return *p;
  }
  [[nodiscard]] bool is_own(const Place& p) const {
    return p.kind == Place::Kind::kInstance || p.kind == Place::Kind::kFrame;
  }
  [[nodiscard]] bool is_named(std::uint32_t id) const {
    const Place& p = root(id);
    return !is_own(p) || is_visible(b_.variable(p.index));
  }
  /// True when the call may mean another instance each time it runs.
  [[nodiscard]] bool varies(std::uint32_t id) const {
    for (const Place* p = &place(id);; p = &place(p->parent.index)) {
      if (p->kind == Place::Kind::kElementAt || p->kind == Place::Kind::kDeref) return true;
      if (!p->parent.valid()) return false;
    }
  }
  [[nodiscard]] std::string text(std::uint32_t id) const { return quoted(place_text(b_.module, b_.pou, PlaceId{id})); }

  void note_inputs(const PlaceNames& names) {
    for (const Inst& inst : insts_) {
      if (inst.op == Op::kMakeRef || inst.op == Op::kAddress) given_out_[names[inst.a]] = true;
      if (inst.op != Op::kStore) continue;
      const Place& port = place(inst.a);
      if (port.kind != Place::Kind::kField || b_.module.types[place(port.parent.index).type].kind != TypeKind::kBlock)
        continue;
      Given& given = inputs_[{names[port.parent.index], port.index}];
      const Inst& value = insts_[inst.b];
      given.something = true;
      given.literal_false = given.literal_false || (value.op == Op::kConst && value.type == kBoolType &&
                                                    b_.body().constants[value.a].bits == 0);
    }
  }
  [[nodiscard]] Given given(std::uint32_t name, std::uint32_t field) const {
    const auto found = inputs_.find({name, field});
    return found == inputs_.end() ? Given{} : found->second;
  }

  void look_at(const Instance& instance, std::uint32_t name) {
    const Type& type = b_.module.types[place(instance.place).type];
    if (type.kind == TypeKind::kBlock && remembers(*type.block)) {
      look_at_preset(instance, name, *type.block);
      // Who calls it with FALSE too rearms it by hand: that is the way of state machines.
      if (given(name, 0).literal_false) return;
      look_at_conditions(instance, *type.block);
      look_at_repetition(instance, true);
    } else {
      look_at_repetition(instance, false);
    }
  }

  // ---- conditional-block ----

  void look_at_conditions(const Instance& instance, const stdlib::BlockSpec& block) {
    for (const std::uint32_t call : instance.calls) {
      if (b_.flow.skips[call] == 0) return;
    }
    if (!b_.flow.can_avoid(b_.body(), instance.calls)) return;
    const bool timer = field_index(block, "PT") != block.fields.size();
    add(Lint::kConditionalBlock, instance.calls.front(),
        fmt::format("{} {} is called only under a condition", block.name, text(instance.place)),
        timer
            ? "without the call Q and ET stand still, and a change of IN is missed: call it in every scan and put the "
              "condition into IN"
            : "an edge of its input is missed while it is not called: call it in every scan and put the condition into "
              "the input");
  }

  // ---- block-twice ----

  void look_at_repetition(const Instance& instance, bool standard) {
    if (varies(instance.place)) return;
    std::vector<std::uint32_t> always;
    for (const std::uint32_t call : instance.calls) {
      const bool drawn = b_.at(call).local_id >= 0;
      if (b_.flow.skips[call] == 0 && (standard || drawn)) always.push_back(call);
      if (standard && b_.flow.loops[call] != 0) {
        return add(Lint::kBlockTwice, call, fmt::format("instance {} is called inside a loop", text(instance.place)),
                   "it sees all turns of the loop as calls one after the other: use an array of instances");
      }
    }
    if (always.size() < 2) return;
    add(Lint::kBlockTwice, always[1],
        fmt::format("instance {} is called {} times in every scan; first in line {}", text(instance.place),
                    always.size(), b_.at(always[0]).line),
        "the calls disturb each other: declare one instance for each place");
  }

  // ---- missing-preset ----

  void look_at_preset(const Instance& instance, std::uint32_t name, const stdlib::BlockSpec& block) {
    if (!b_.module.owner_of(b_.pou).actions.empty()) return;  // another body of the POU may give it
    const std::uint32_t preset = field_index(block, "PT");
    const Place& variable = root(instance.place);
    if (preset == block.fields.size() || given(name, preset).something || !is_own(variable)) return;
    // Another name of the instance may be the one that gives it: an element by index, a handle.
    if (varies(instance.place) || place(instance.place).parent.valid() || given_out_.contains(name)) return;
    if (!b_.variable(variable.index).initial.empty()) return;
    add(Lint::kMissingPreset, instance.calls.front(),
        fmt::format("{} {} has no preset time: PT has no value", block.name, text(instance.place)),
        "it counts as T#0s; wire PT, or write PT := T#..");
  }

  const LintBody& b_;
  const std::vector<Inst>& insts_;
  Findings& findings_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Given> inputs_;  ///< by name of the instance and field
  std::unordered_map<std::uint32_t, bool> given_out_;                ///< instances whose handle goes elsewhere
};

}  // namespace

void lint_blocks(const LintBody& body, Findings& findings) { Blocks(body, findings).run(); }

}  // namespace plc::ir
