#include "bytecode/codegen/if_conversion.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace plc::bytecode {
namespace {

using ir::Body;
using ir::Inst;
using ir::Op;
using ir::Place;

/// Instructions of one branch at most: more are better jumped past.
constexpr std::uint32_t kMostInBranch = 16;

constexpr std::uint32_t kNone = 0xffffffffu;

/// One branch of an IF, or both. Instructions are numbers into Body::insts.
struct Conversion {
  std::uint32_t jump = 0;                        ///< past the first branch
  std::uint32_t first_end = 0;                   ///< past its last instruction
  std::uint32_t other_begin = 0, other_end = 0;  ///< of the ELSE branch, empty without one
  std::uint32_t end = 0;                         ///< past the last label
};

class Converter {
 public:
  explicit Converter(const Body& body) : body_(body) {}

  std::optional<Body> run() {
    find_labels();
    find_conversions();
    if (conversions_.empty()) return std::nullopt;
    out_ = body_;
    out_.insts.clear();
    value_.assign(body_.insts.size(), kNone);
    position_.assign(body_.insts.size() + 1, 0);
    when_.assign(body_.insts.size() + 1, kNone);
    auto next = conversions_.cbegin();
    for (std::uint32_t i = 0; i < body_.insts.size();) {
      if (next != conversions_.cend() && next->jump == i) {
        convert(*next);
        i = next++->end;
      } else {
        copy(i++);
      }
    }
    rename_values();
    position_[body_.insts.size()] = static_cast<std::uint32_t>(out_.insts.size());
    move_probes();
    return std::move(out_);
  }

 private:
  // ---- finding

  void find_labels() {
    label_at_.assign(body_.label_count, kNone);
    jumps_.assign(body_.label_count, 0);
    for (std::uint32_t i = 0; i < body_.insts.size(); ++i) {
      const Inst& inst = body_.insts[i];
      if (inst.op == Op::kLabel) label_at_[inst.a] = i;
      if (inst.op == Op::kJump || inst.op == Op::kJumpIf || inst.op == Op::kJumpIfNot) ++jumps_[inst.a];
    }
  }
  void find_conversions() {
    for (std::uint32_t i = 0; i < body_.insts.size();) {
      const auto found = conversion_at(i);
      if (found) conversions_.push_back(*found);
      i = found ? found->end : i + 1;
    }
  }
  [[nodiscard]] bool is_only_target(std::uint32_t label) const { return jumps_[label] == 1; }

  [[nodiscard]] std::optional<Conversion> conversion_at(std::uint32_t jump) const {
    const Inst& inst = body_.insts[jump];
    const bool is_if = (inst.op == Op::kJumpIf || inst.op == Op::kJumpIfNot) && inst.part == ir::Part::kPlain;
    if (!is_if || label_at_[inst.a] == kNone || label_at_[inst.a] < jump || !is_only_target(inst.a))
      return std::nullopt;
    Conversion c;
    c.jump = jump;
    c.first_end = end_of_branch(jump + 1);
    if (c.first_end == jump + 1) return std::nullopt;
    const std::uint32_t label = label_at_[inst.a];
    if (c.first_end == label) {
      c.other_begin = c.other_end = label;
      c.end = label + 1;
      return c;
    }
    const Inst& past = body_.insts[c.first_end];
    if (past.op != Op::kJump || c.first_end + 1 != label || !is_only_target(past.a)) return std::nullopt;
    c.other_begin = label + 1;
    c.other_end = end_of_branch(c.other_begin);
    if (label_at_[past.a] != c.other_end) return std::nullopt;
    c.end = c.other_end + 1;
    return c;
  }
  /// Past the instructions from `begin` on that may be part of a branch; `begin` when they are too many or store
  /// nothing.
  [[nodiscard]] std::uint32_t end_of_branch(std::uint32_t begin) const {
    bool stores = false;
    std::uint32_t i = begin;
    while (i < body_.insts.size() && fits(body_.insts[i])) stores = body_.insts[i++].op == Op::kStore || stores;
    return stores && i - begin <= kMostInBranch ? i : begin;
  }
  [[nodiscard]] bool fits(const Inst& inst) const {
    switch (inst.op) {
      case Op::kConst:
        return inst.type == ir::kBoolType;
      case Op::kLoad:
      case Op::kStore:
        return body_.places[inst.a].type == ir::kBoolType && is_known(ir::PlaceId{inst.a});
      case Op::kAnd:
      case Op::kOr:
      case Op::kXor:
      case Op::kNot:
        return true;
      default:
        return false;
    }
  }
  /// Whether the place is a variable, or a part of one that no value chooses.
  [[nodiscard]] bool is_known(ir::PlaceId place) const {
    for (; place.valid(); place = body_.places[place.index].parent) {
      const Place::Kind kind = body_.places[place.index].kind;
      if (kind == Place::Kind::kDeref || kind == Place::Kind::kElementAt || kind == Place::Kind::kPart ||
          kind == Place::Kind::kCharacter) {
        return false;
      }
    }
    return true;
  }

  // ---- writing

  std::uint32_t put(const Inst& inst) {
    out_.insts.push_back(inst);
    return static_cast<std::uint32_t>(out_.insts.size() - 1);
  }
  /// New values are named by their new numbers at once, with kNew: rename_values() leaves those alone.
  static constexpr std::uint32_t kNew = 0x80000000u;
  std::uint32_t put_logic(Op op, std::uint32_t a, std::uint32_t b, const Inst& like) {
    return put({op, ir::Part::kPlain, 0, ir::kBoolType, a, b, like.source}) | kNew;
  }
  void copy(std::uint32_t i) {
    at(i);
    value_[i] = put(body_.insts[i]);
  }
  void at(std::uint32_t i) { position_[i] = static_cast<std::uint32_t>(out_.insts.size()); }

  void convert(const Conversion& c) {
    const Inst& jump = body_.insts[c.jump];
    at(c.jump);
    const std::uint32_t negated = put_logic(Op::kNot, jump.b, 0, jump);
    const bool unless = jump.op == Op::kJumpIfNot;
    const std::uint32_t taken = unless ? jump.b : negated, other = unless ? negated : jump.b;
    branch(c.jump + 1, c.first_end, taken, other);
    if (c.other_begin != c.first_end) branch(c.other_begin, c.other_end, other, taken);
  }
  /// The branch is executed where `when` is TRUE, which `unless` is the opposite of.
  void branch(std::uint32_t begin, std::uint32_t end, std::uint32_t when, std::uint32_t unless) {
    for (std::uint32_t i = begin; i <= end; ++i) {
      at(i);
      when_[i] = when;
      if (i == end) return;
      const Inst& inst = body_.insts[i];
      if (inst.op != Op::kStore) {
        copy(i);
        continue;
      }
      const std::uint32_t old = put({Op::kLoad, ir::Part::kPlain, 0, ir::kBoolType, inst.a, 0, inst.source}) | kNew;
      Inst store = inst;
      store.b = chosen(inst, old, when, unless);
      value_[i] = put(store);
    }
  }
  std::uint32_t chosen(const Inst& store, std::uint32_t old, std::uint32_t when, std::uint32_t unless) {
    const Inst& value = body_.insts[store.b];
    if (value.op == Op::kConst && body_.constants[value.a].bits != 0) return put_logic(Op::kOr, old, when, store);
    const std::uint32_t kept = put_logic(Op::kAnd, old, unless, store);
    if (value.op == Op::kConst) return kept;
    return put_logic(Op::kOr, put_logic(Op::kAnd, store.b, when, store), kept, store);
  }

  /// What is in a branch is to be seen where the branch is executed.
  void move_probes() {
    for (ir::Probe& probe : out_.probes) {
      std::uint32_t when = when_[probe.value.valid() ? probe.value.index : probe.before];
      if (when != kNone) rename(when);
      probe.when = {when};
      if (probe.value.valid()) rename(probe.value.index);
      probe.before = position_[probe.before];
    }
  }

  void rename(std::uint32_t& value) const {
    value = (value & kNew) != 0 && value != kNone ? value & ~kNew : value_[value];
  }
  /// Operands by their new numbers.
  void rename_values() {
    const auto rename = [this](std::uint32_t& value) { this->rename(value); };
    for (Inst& inst : out_.insts) {
      switch (inst.op) {
        case Op::kStore:
        case Op::kJumpIf:
        case Op::kJumpIfNot:
          rename(inst.b);
          break;
        case Op::kAnd:
        case Op::kOr:
        case Op::kXor:
        case Op::kInsert:
        case Op::kSameRef:
          rename(inst.a);
          rename(inst.b);
          break;
        case Op::kNot:
        case Op::kPointerRef:
        case Op::kPointerTo32:
        case Op::kPointerFrom32:
        case Op::kExtract:
        case Op::kRange:
          rename(inst.a);
          break;
        default:
          break;
      }
    }
    for (Place& place : out_.places) {
      if (place.kind == Place::Kind::kDeref || place.kind == Place::Kind::kElementAt) rename(place.index);
    }
    for (ir::ValueId& argument : out_.args) rename(argument.index);
    for (ir::CallArg& argument : out_.call_args) {
      if (argument.value.valid()) rename(argument.value.index);
    }
  }

  const Body& body_;
  std::vector<std::uint32_t> label_at_;  ///< by label: instruction, or kNone
  std::vector<std::uint32_t> jumps_;     ///< by label: how many go there
  std::vector<Conversion> conversions_;  ///< ascending, apart from each other
  Body out_;
  std::vector<std::uint32_t> value_;     ///< by old number: the new one
  std::vector<std::uint32_t> position_;  ///< by old number of the instruction that follows: the new one
  std::vector<std::uint32_t> when_;      ///< ..: the value that says whether control would come here, or kNone
};

}  // namespace

std::optional<ir::Body> convert_ifs(const ir::Body& body) { return Converter(body).run(); }

}  // namespace plc::bytecode
