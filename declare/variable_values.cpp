// What variables begin with, for initial values that name them: they are computed in the order of declaration, globals
// first, and of the other instances as their types have it. Where a value is known only when the POU runs (variables of
// calls, functions of the project), the POU computes it at its beginning, as it does with references.
#include <algorithm>
#include <cstring>
#include <utility>

#include "core/text.h"
#include "declare/declarer.h"
#include "frontend-st/parser.h"
#include "frontend-st/static_type.h"

namespace plc::st {

using core::TypeId;
using ir::TypeKind;
using ir::TypeRef;

namespace {

constexpr std::uint64_t key_of(std::uint32_t pou, std::uint32_t variable) {
  return std::uint64_t{pou} << 32 | variable;
}

bool begins_with(const std::vector<std::uint32_t>& path, std::span<const std::uint32_t> head) {
  return path.size() >= head.size() && std::equal(head.begin(), head.end(), path.begin());
}

}  // namespace

void Declarer::index_pending() {
  pending_state_.assign(pending_.size(), State::kNew);
  pending_of_pou_.assign(module_.pous.size(), {0, 0});
  for (std::uint32_t i = 0; i < pending_.size(); ++i) {
    const Pending& one = pending_[i];
    pending_of_.emplace(key_of(one.pou, one.variable), i);
    if (one.pou != kNoPou) {
      auto& [first, last] = pending_of_pou_[one.pou];
      if (first == last) first = i;
      last = i + 1;
    }
    if (one.pou == kNoPou || one.declaration->section == plcopen::Section::kExternal) continue;
    // The global of a located or static variable.
    const ir::Variable& variable = module_.pous[one.pou].variables[one.variable];
    if (variable.role == ir::Role::kExternal) pending_of_.emplace(key_of(kNoPou, variable.global), i);
  }
}

const ir::Pou* Declarer::scope_pou() const { return scope_pou_ == kNoPou ? nullptr : &module_.pous[scope_pou_]; }

std::optional<std::uint64_t> Declarer::size_of(const Ast& ast, const SourceText& source, NodeId id,
                                               std::string& problem) {
  return size_of_named(ast, source, id, module_, scope_pou(), problem);
}

bool Declarer::is_own_function(std::string_view name) {
  const auto pou = module_.pou_by_name.find(name);
  const bool function = pou != module_.pou_by_name.end() && module_.pous[pou->second].kind == ir::PouKind::kFunction;
  const bool clock = core::iequals(name, "TIME") || core::iequals(name, "LTIME");
  use_.while_running = use_.while_running || function || clock;
  return function || clock;
}

bool Declarer::names_place_of(std::string_view text, TypeRef type) {
  if (types().holds_instance(type) || text.size() > kMaxTextBytes) return false;
  const SourceText source(text);
  core::Diagnostics unheard;
  Parser parser(source, unheard, {});
  const NodeId root = parser.parse_expression();
  return root != kNoNode && static_type(parser.ast(), source, root, module_, scope_pou()) == type;
}

std::optional<ConstantValue> Declarer::variable_value(std::string_view root, std::span<const PathStep> path) {
  if (current_ == kNoPending) return std::nullopt;
  const Pending& asking = pending_[current_];
  const ir::Variable* variable = nullptr;
  std::uint64_t key = 0;
  if (asking.pou != kNoPou) {
    const ir::Pou& pou = module_.pous[asking.pou];
    const auto local = pou.by_name.find(root);
    if (local != pou.by_name.end()) {
      variable = &pou.variables[local->second];
      key = key_of(asking.pou, local->second);
      if (variable->role == ir::Role::kExternal) {
        key = key_of(kNoPou, variable->global);
        variable = &module_.globals[variable->global].variable;
      }
    }
  }
  if (variable == nullptr) {
    auto global = module_.global_by_name.find(root);
    if (global == module_.global_by_name.end() && !path.empty() && !path.front().member.empty()) {
      global = module_.global_by_name.find(std::string(root) + "." + std::string(path.front().member));
      path = path.subspan(1);
    }
    if (global == module_.global_by_name.end()) return std::nullopt;
    variable = &module_.globals[global->second].variable;
    key = key_of(kNoPou, global->second);
  }
  // constant_named() had the say about those that are one value.
  if (variable->constant && path.empty()) return std::nullopt;
  const bool each_call =
      asking.pou != kNoPou && module_.pous[asking.pou].variables[asking.variable].in_frame && !variable->constant;
  if (each_call || (variable->in_frame && !variable->constant) || variable->role == ir::Role::kInOut) {
    use_.while_running = true;
    return std::nullopt;
  }
  use_.variable = use_.variable || !variable->constant;
  const auto pending = pending_of_.find(key);
  bool later = false;
  if (pending != pending_of_.end() && pending_state_[pending->second] != State::kDone) {
    if (pending_state_[pending->second] == State::kInProgress) return std::nullopt;
    later = !variable->constant && pending_[pending->second].pou == asking.pou;
    if (later) use_.later = root;
    if (!later && !initialize_first(pending->second, pending->second + 1)) return std::nullopt;
  }
  return part_value(*variable, path, later);
}

std::optional<ConstantValue> Declarer::part_value(const ir::Variable& variable, std::span<const PathStep> path,
                                                  bool fresh) {
  // What an instance is given goes before what its type says: outermost first.
  struct Level {
    const ir::Variable* variable;
    std::size_t depth;
  };
  std::vector<Level> levels{{&variable, 0}};
  std::vector<std::uint32_t> steps;
  TypeRef type = variable.type;
  const stdlib::BlockSpec* block = nullptr;
  for (const PathStep& step : path) {
    const ir::Type t = types()[type];
    if (step.member.empty()) {
      if (t.kind != TypeKind::kArray || t.open || step.index < t.lower || step.index > t.upper) return std::nullopt;
      steps.push_back(static_cast<std::uint32_t>(step.index - t.lower));
      type = t.element;
    } else if (t.kind == TypeKind::kStruct) {
      const auto position = types().position_of(type, step.member);
      if (!position) return std::nullopt;
      steps.push_back(*position);
      type = t.fields[*position].type;
    } else if (t.kind == TypeKind::kBlock) {
      const stdlib::Field* const field = stdlib::field_named(*t.block, step.member);
      if (field == nullptr || field->direction == stdlib::Direction::kState) return std::nullopt;
      block = t.block;
      steps.push_back(static_cast<std::uint32_t>(field - t.block->fields.data()));
      type = ir::ref_of(field->type);
    } else if (t.kind == TypeKind::kPou) {
      const auto member = module_.pous[t.pou].by_name.find(step.member);
      if (member == module_.pous[t.pou].by_name.end()) return std::nullopt;
      const auto [first, last] = pending_of_pou_[t.pou];
      if (!initialize_first(first, last)) return std::nullopt;
      const ir::Variable& inner = module_.pous[t.pou].variables[member->second];
      if (inner.role == ir::Role::kExternal || inner.role == ir::Role::kInOut || inner.in_frame) return std::nullopt;
      steps.push_back(member->second);
      type = inner.type;
      levels.push_back({&inner, steps.size()});
    } else {
      return std::nullopt;
    }
  }
  // Structures, arrays and references are no values of expressions here; functions of the project take them.
  if (!types().rep_of(type) || types()[type].kind == TypeKind::kReference || types()[type].kind == TypeKind::kPointer) {
    use_.while_running = true;
    return std::nullopt;
  }
  for (const Level& level : levels) {
    if (fresh && level.depth == 0) continue;
    const std::span<const std::uint32_t> rest(steps.data() + level.depth, steps.size() - level.depth);
    for (const ir::ReferenceInit& made : level.variable->references) {
      if (!begins_with(std::vector(rest.begin(), rest.end()), made.path)) continue;
      use_.while_running = true;
      return std::nullopt;
    }
    const auto& items = level.variable->initial;
    const auto item = std::find_if(items.begin(), items.end(), [&](const ir::InitItem& one) {
      return one.path.size() == rest.size() && begins_with(one.path, rest);
    });
    if (item != items.end()) return value_of(item->value, type);
  }
  ir::Constant zero;
  zero.type = type;
  const ir::Type& scalar = types()[type];
  const core::Rep rep = *types().rep_of(type);
  if (block != nullptr && block->initial != nullptr) {
    const std::uint32_t offset = block->fields[steps.back()].offset;
    std::memcpy(&zero.bits, static_cast<const std::byte*>(block->initial) + offset, core::rep_bytes(rep));
  } else if (scalar.kind == TypeKind::kEnum || scalar.kind == TypeKind::kSubrange) {
    zero.bits = truncate_bits(static_cast<std::uint64_t>(scalar.initial), rep);
  }
  return value_of(zero, type);
}

ConstantValue Declarer::value_of(const ir::Constant& constant, TypeRef type) {
  Literal literal;
  literal.type = types()[type].elementary;
  literal.bits = constant.bits;
  literal.kind = Literal::Kind::kScalar;
  if (types()[type].kind == TypeKind::kEnum) {
    ConstantValue out;
    out.kind = ConstantValue::Kind::kTyped;
    out.constant = constant;
    out.constant.type = type;
    return out;
  }
  if (core::in_category(literal.type, core::kAnyChars)) {
    literal.kind = Literal::Kind::kText;
    literal.text = constant.text;
    const std::size_t width = literal.type == TypeId::kChar ? 1 : literal.type == TypeId::kWchar ? 2 : 0;
    for (std::size_t i = 0; i < width; ++i) literal.text += static_cast<char>(constant.bits >> (8 * i));
  }
  return constant_of_literal(literal, types());
}

bool Declarer::initialize_first(std::uint32_t first, std::uint32_t last) {
  constexpr std::uint32_t kMaxNested = 64;
  while (first != last && pending_state_[first] != State::kNew) ++first;
  if (first == last) return true;
  if (nested_initial_values_ == kMaxNested) return false;
  ++nested_initial_values_;
  NameMap<const plcopen::Variable*> constants;
  std::swap(constants, local_constants_);
  const auto current = std::exchange(current_, kNoPending);
  const auto scope = scope_pou_;
  auto* const references = std::exchange(references_, nullptr);
  const InitialUse use = std::exchange(use_, {});
  for (; first != last; ++first) {
    if (pending_state_[first] == State::kNew) initialize(first);
  }
  --nested_initial_values_;
  use_ = use;
  references_ = references;
  scope_pou_ = scope;
  current_ = current;
  std::swap(constants, local_constants_);
  return true;
}

void Declarer::enter_scope(std::uint32_t pou) {
  scope_pou_ = pou;
  local_constants_.clear();
  if (pou == kNoPou) return;
  for (const plcopen::Variable& v : project_.pous[pou].variables) {
    if (v.constant && v.section != plcopen::Section::kExternal) local_constants_.emplace(v.name, &v);
  }
}

}  // namespace plc::st
