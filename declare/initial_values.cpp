// Initial values: constants, arrays with repetition, structures, instances; defaults that come with types.
#include <algorithm>
#include <set>
#include <utility>

#include "core/text.h"
#include "declare/declarer.h"
#include "frontend-st/lexer.h"
#include "frontend-st/names.h"

namespace plc::st {

using core::Code;
using ir::TypeKind;
using ir::TypeRef;
using plcopen::InitialValue;
using plcopen::TypeSpec;

namespace {

/// Scalars that initial values of one variable may set one by one.
constexpr std::size_t kMaxItems = std::size_t{1} << 20;
constexpr std::size_t kMaxTotalItems = 8 * kMaxItems;

std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

std::size_t element_count(const ir::Type& array) { return static_cast<std::size_t>(array.upper - array.lower + 1); }

/// Later items win; the result has one item a path, in path order.
void keep_last(std::vector<ir::InitItem>& items) {
  std::stable_sort(items.begin(), items.end(),
                   [](const ir::InitItem& a, const ir::InitItem& b) { return a.path < b.path; });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i + 1 < items.size() && items[i].path == items[i + 1].path) continue;
    if (kept != i) items[kept] = std::move(items[i]);
    ++kept;
  }
  items.resize(kept);
}

}  // namespace

const Declarer::Items& Declarer::defaults_of(std::uint32_t user_type) {
  UserType& entry = user_types_[user_type];
  if (entry.has_defaults) return entry.defaults;
  entry.has_defaults = true;  // before the work: types that contain themselves were reported
  if (!entry.type) return entry.defaults;
  const plcopen::DataType& declaration = *entry.declaration;
  const TypeRef type = *entry.type;
  const Owner owner{{}, declaration.name, declaration.at};
  Items items = spec_defaults(declaration.type, type, owner);
  const TypeKind kind = types()[type].kind;
  const bool in_type =
      (kind == TypeKind::kEnum || kind == TypeKind::kSubrange) &&
      (declaration.type.kind == TypeSpec::Kind::kEnum || declaration.type.kind == TypeSpec::Kind::kSubrange);
  if (declaration.initial.kind != InitialValue::Kind::kNone && !in_type) {
    std::vector<std::uint32_t> path;
    add_items(declaration.initial, type, path, items, owner);
    keep_last(items);
  }
  user_types_[user_type].defaults = std::move(items);
  return user_types_[user_type].defaults;
}

// Initial values that `spec` brings along: those of the members of its structures and of its named types.
Declarer::Items Declarer::spec_defaults(const TypeSpec& spec, TypeRef type, const Owner& owner) {
  Items out;
  switch (spec.kind) {
    case TypeSpec::Kind::kNamed: {
      const auto user = user_type_by_name_.find(core::trimmed(spec.name));
      // Where resolving gave up, the place has another type: following the names would not end.
      if (user != user_type_by_name_.end() && user_types_[user->second].type == type) out = defaults_of(user->second);
      break;
    }
    case TypeSpec::Kind::kArray: {
      if (!spec.base) break;
      TypeRef element = type;
      std::size_t count = 1;
      std::vector<std::size_t> sizes;
      for (std::size_t i = 0; i < spec.dimensions.size() && types()[element].kind == TypeKind::kArray; ++i) {
        sizes.push_back(element_count(types()[element]));
        count *= sizes.back();
        element = types()[element].element;
      }
      const Items inner = spec_defaults(*spec.base, element, owner);
      if (inner.empty()) break;
      if (count > kMaxItems / inner.size()) {
        report(Code::P4020, place(spec.at, owner), owner.pou,
               "array " + quoted(owner.name) + " would need more than " + std::to_string(kMaxItems) + " initial values",
               "initialise it in a first cycle instead of in its type");
        break;
      }
      for (std::size_t i = 0; i < count; ++i) {
        std::vector<std::uint32_t> prefix(sizes.size());
        std::size_t rest = i;
        for (std::size_t d = sizes.size(); d-- > 0;) {
          prefix[d] = static_cast<std::uint32_t>(rest % sizes[d]);
          rest /= sizes[d];
        }
        for (const ir::InitItem& item : inner) {
          ir::InitItem placed{prefix, item.value};
          placed.path.insert(placed.path.end(), item.path.begin(), item.path.end());
          out.push_back(std::move(placed));
        }
      }
      break;
    }
    case TypeSpec::Kind::kStruct:
    case TypeSpec::Kind::kUnion: {
      const std::vector<ir::TypeField> fields = types()[type].fields;
      std::uint32_t index = 0;
      // A type is the same for all variables of it.
      const auto current = std::exchange(current_, kNoPending);
      auto* const references = std::exchange(references_, nullptr);
      for (const plcopen::Variable& member : spec.members) {
        if (index >= fields.size() || !core::iequals(fields[index].name, member.name)) continue;
        const std::string name = std::string(owner.name) + "." + member.name;
        Items inner = initial_of(member, fields[index].type, {owner.pou, name, place(member.at, owner)});
        if (inner.size() + out.size() > kMaxItems) {
          report(Code::P4020, place(member.at, owner), owner.pou,
                 "structure " + quoted(owner.name) + " would need more than " + std::to_string(kMaxItems) +
                     " initial values",
                 "initialise it in a first cycle instead of in its type");
          out.clear();
          break;
        }
        for (ir::InitItem& item : inner) {
          item.path.insert(item.path.begin(), index);
          out.push_back(std::move(item));
        }
        ++index;
      }
      current_ = current;
      references_ = references;
      break;
    }
    default:
      break;
  }
  return out;
}

Declarer::Items Declarer::initial_of(const plcopen::Variable& variable, TypeRef type, const Owner& owner) {
  Items items = spec_defaults(variable.type, type, owner);
  if (variable.initial.kind == InitialValue::Kind::kNone) return items;
  const bool had_defaults = !items.empty();
  std::vector<std::uint32_t> path;
  add_items(variable.initial, type, path, items, owner);
  if (had_defaults) keep_last(items);
  return items;
}

// Beremiz and OpenPLC Editor keep string values as typed, and add the quotes when they generate code.
std::optional<ConstantValue> Declarer::evaluate_text(std::string_view text, const core::SourceRef& at, TypeRef type,
                                                     const Owner& owner, core::Diagnostics& diagnostics) {
  if (text.find_first_of("'\"") == std::string_view::npos) {
    core::Diagnostics unheard;
    std::string problem;
    std::optional<Code> note;
    // A text that happens to be the name of a variable is a text there.
    const bool keeps_quotes = project_.version == plcopen::Version::kText;
    const auto current = current_;
    if (!keeps_quotes && is_identifier(core::trimmed(text))) current_ = kNoPending;
    auto value = evaluate(text, {}, unheard, owner.pou, type);  // a text may be anything
    current_ = current;
    if (value && constant_as(*value, type, types(), problem, note)) return value;
    if (use_.while_running) return std::nullopt;
    const std::string quote = types()[type].elementary == core::TypeId::kString ? "'" : "\"";
    return evaluate(quote + std::string(text) + quote, at, diagnostics, owner.pou, type);
  }
  return evaluate(text, at, diagnostics, owner.pou, type);
}

bool Declarer::add_items(const InitialValue& value, TypeRef type, std::vector<std::uint32_t>& path, Items& out,
                         const Owner& owner) {
  const core::SourceRef& at = place(value.at, owner);
  const ir::Type& target = types()[type];
  if (target.stub) return true;
  if (out.size() > kMaxItems) {
    report(Code::P4020, at, owner.pou,
           "initial value of " + quoted(owner.name) + " sets more than " + std::to_string(kMaxItems) + " elements");
    return false;
  }
  // Editors keep texts without quotes: "[pump]" is no list where the type is a string by another name.
  const bool is_text = target.kind == TypeKind::kString && !value.text.empty();
  switch (is_text ? InitialValue::Kind::kSimple : value.kind) {
    case InitialValue::Kind::kNone:
      return true;
    case InitialValue::Kind::kArray:
      return add_array_items(value, type, path, out, owner);
    case InitialValue::Kind::kStruct:
      return add_struct_items(value, type, path, out, owner);
    case InitialValue::Kind::kSimple:
      break;
  }
  if (core::trimmed(value.text).empty()) return true;
  if (!types().rep_of(type) && references_ != nullptr && names_place_of(value.text, type)) {
    report(Code::P4349, at, owner.pou,
           "initial value " + quoted(core::trimmed(value.text)) + " of " + quoted(owner.name) + " is a variable",
           "assign it in the first scan");
    references_->push_back({path, value.text, at});
    return true;
  }
  if (!types().rep_of(type)) {
    report(Code::P4020, at, owner.pou,
           "initial value " + quoted(value.text) + " of " + quoted(owner.name) + ", which has type " +
               types().name_of(type),
           target.kind == TypeKind::kArray ? "arrays take a list of values" : "structures take values by member");
    return false;
  }
  const bool leads = target.kind == TypeKind::kReference || target.kind == TypeKind::kPointer;
  const std::string_view written = core::trimmed(value.text);
  if (leads && !core::iequals(written, "NULL") && written != "0" && references_ != nullptr) {
    references_->push_back({path, value.text, at});
    return true;
  }
  return add_scalar(value, type, path, out, owner);
}

bool Declarer::add_scalar(const InitialValue& value, TypeRef type, const std::vector<std::uint32_t>& path, Items& out,
                          const Owner& owner) {
  const core::SourceRef& at = place(value.at, owner);
  use_ = {};
  core::Diagnostics heard;
  auto result = types()[type].kind == TypeKind::kString ? evaluate_text(value.text, at, type, owner, heard)
                                                        : evaluate(value.text, at, heard, owner.pou, type);
  const InitialUse use = use_;
  const bool while_running = !result && use.while_running && references_ != nullptr;
  for (const core::Diagnostic& d : heard.all()) {
    if (!while_running || d.severity == core::Severity::kNote) report(d.code, d.at, d.pou, d.message, d.help);
  }
  if (!use.later.empty()) {
    report(Code::P4055, at, owner.pou,
           "initial value of " + quoted(owner.name) + " names " + quoted(use.later) +
               ", which is declared later and still has its default value there",
           "declare " + quoted(use.later) + " first");
  }
  if (while_running || (result && use.variable)) {
    report(Code::P4349, at, owner.pou,
           "initial value " + quoted(core::trimmed(value.text)) + " of " + quoted(owner.name) + " is no constant",
           "make what it names CONSTANT, or assign it in the first scan");
  }
  if (while_running) references_->push_back({path, value.text, at});
  if (!result) return while_running;
  std::string problem;
  if (ltime_fits_ && result->kind == ConstantValue::Kind::kTyped &&
      result->constant.type == ir::ref_of(core::TypeId::kLtime)) {
    result->constant.type = type;
  }
  std::optional<Code> note;
  auto constant = constant_as(*result, type, types(), problem, note);
  if (!constant || note) {
    report(note.value_or(Code::P4020), at, owner.pou,
           "initial value " + quoted(core::trimmed(value.text)) + " of " + quoted(owner.name) + ": " + problem);
  }
  if (!constant) return false;
  // References are born as NULL.
  if (types()[type].kind != TypeKind::kReference) out.push_back({path, std::move(*constant)});
  return true;
}

// Values fill an array in order. Several dimensions may be written nested or as one flat list (IEC
// 61131-3:2013, 6.4.4.5).
bool Declarer::add_array_items(const InitialValue& value, TypeRef type, std::vector<std::uint32_t>& path, Items& out,
                               const Owner& owner) {
  const core::SourceRef& at = place(value.at, owner);
  if (types()[type].kind != TypeKind::kArray) {
    report(Code::P4020, at, owner.pou,
           "list of values for " + quoted(owner.name) + ", which has type " + types().name_of(type));
    return false;
  }
  std::vector<std::size_t> sizes{element_count(types()[type])};
  TypeRef element = types()[type].element;
  const bool nested = std::any_of(value.values.begin(), value.values.end(),
                                  [](const InitialValue& v) { return v.kind == InitialValue::Kind::kArray; });
  while (!nested && types()[element].kind == TypeKind::kArray) {
    sizes.push_back(element_count(types()[element]));
    element = types()[element].element;
  }
  std::size_t total = 1;
  for (std::size_t size : sizes) total *= size;
  std::size_t position = 0;
  bool fine = true;
  for (const InitialValue& one : value.values) {
    std::int64_t repetition = 1;
    if (!core::trimmed(one.repetition).empty()) {
      const auto count = integer_constant(one.repetition, place(one.repetition_at, one.at, owner), owner, "repetition");
      if (!count) return false;
      repetition = *count;
    }
    if (repetition < 0 || static_cast<std::uint64_t>(repetition) > total - position) {
      report(Code::P4020, place(one.at, owner), owner.pou,
             "more initial values than the " + std::to_string(total) + " elements of " + quoted(owner.name));
      return false;
    }
    const std::size_t first = out.size();
    for (std::int64_t r = 0; r < repetition; ++r, ++position) {
      const std::size_t depth = path.size();
      path.resize(depth + sizes.size());
      std::size_t rest = position;
      for (std::size_t d = sizes.size(); d-- > 0;) {
        path[depth + d] = static_cast<std::uint32_t>(rest % sizes[d]);
        rest /= sizes[d];
      }
      // A repeated value is evaluated, and its errors reported, once; so it has to be known now.
      if (r == 0) {
        auto* const references = references_;
        if (repetition != 1) references_ = nullptr;
        fine = add_items(one, element, path, out, owner) && fine;
        references_ = references;
      } else {
        const std::size_t last = first + (out.size() - first) / static_cast<std::size_t>(r);
        for (std::size_t i = first; i < last; ++i) {
          ir::InitItem copy = out[i];
          std::copy(path.begin(), path.end(), copy.path.begin());
          out.push_back(std::move(copy));
        }
      }
      path.resize(depth);
      if (!fine) return false;
      if (out.size() > kMaxItems) {
        report(Code::P4020, at, owner.pou,
               "initial value of " + quoted(owner.name) + " sets more than " + std::to_string(kMaxItems) + " elements");
        return false;
      }
      if (r == 0 && out.size() == first) {
        position += static_cast<std::size_t>(repetition);
        break;
      }
    }
  }
  return fine;
}

bool Declarer::add_struct_items(const InitialValue& value, TypeRef type, std::vector<std::uint32_t>& path, Items& out,
                                const Owner& owner) {
  bool fine = true;
  for (const InitialValue& one : value.values) {
    const ir::Type& target = types()[type];
    std::optional<std::uint32_t> index;
    TypeRef member_type{};
    if (target.kind == TypeKind::kStruct || target.kind == TypeKind::kUnion) {
      for (std::uint32_t i = 0; i < target.fields.size(); ++i) {
        if (!core::iequals(target.fields[i].name, one.member)) continue;
        index = i;
        member_type = target.fields[i].type;
      }
    } else if (target.kind == TypeKind::kPou) {
      const ir::Pou& pou = module_.pous[target.pou];
      const auto found = pou.by_name.find(one.member);
      if (found != pou.by_name.end() && pou.variables[found->second].role != ir::Role::kExternal) {
        index = found->second;
        member_type = pou.variables[*index].type;
      }
    } else if (target.kind == TypeKind::kBlock) {
      const stdlib::Field* field = stdlib::field_named(*target.block, one.member);
      if (field != nullptr && field->direction != stdlib::Direction::kState) {
        index = static_cast<std::uint32_t>(field - target.block->fields.data());
        member_type = ir::ref_of(field->type);
      }
    }
    if (!index) {
      report(Code::P4020, place(one.at, owner), owner.pou,
             "initial value for member " + quoted(one.member) + " of " + quoted(owner.name) + ", which type " +
                 types().name_of(type) + " does not have");
      fine = false;
      continue;
    }
    path.push_back(*index);
    ltime_fits_ =
        target.kind == TypeKind::kBlock && target.block->any_duration && member_type == ir::ref_of(core::TypeId::kTime);
    fine = add_items(one, member_type, path, out, owner) && fine;
    ltime_fits_ = false;
    path.pop_back();
  }
  return fine;
}

// ---- constants ------------------------------------------------------------------------------------------------

std::optional<ConstantValue> Declarer::evaluate(std::string_view text, const core::SourceRef& at,
                                                core::Diagnostics& diagnostics, std::string_view pou,
                                                std::optional<TypeRef> expected) {
  const core::SourceRef outer = std::exchange(asking_, at);
  auto value = evaluate_constant(text, at, types(), *this, diagnostics, pou, expected);
  asking_ = outer;
  return value;
}

std::optional<ConstantValue> Declarer::constant_named(std::string_view name) {
  const auto earlier = earlier_values_.find(name);
  if (earlier != earlier_values_.end()) {
    ConstantValue value;
    value.int_value = earlier->second;
    return value;
  }
  const plcopen::Variable* variable = nullptr;
  const auto local = local_constants_.find(name);
  const auto global = global_constants_.find(name);
  if (local != local_constants_.end()) {
    variable = local->second;
  } else if (global != global_constants_.end()) {
    variable = global->second;
  }
  if (variable != nullptr && is_library(variable->at) && !in_library() && is_project_enum_value(types(), name)) {
    return std::nullopt;
  }
  if (variable == nullptr) is_broken(name, asking_, asking_, {});
  if (variable == nullptr || variable->initial.kind != InitialValue::Kind::kSimple) return std::nullopt;
  note_use(asking_, variable->at, asking_, {});
  const bool is_local = local != local_constants_.end();
  if (chain_ != 0) return constant_value(variable, is_local);
  // What lies too deep for the stack is computed first, and the rest begun anew.
  std::vector<std::pair<const plcopen::Variable*, bool>> open = {{variable, is_local}};
  std::optional<ConstantValue> value;
  std::set<const plcopen::Variable*> waiting = {variable};
  while (!open.empty()) {
    too_deep_ = {};
    value = constant_value(open.back().first, open.back().second);
    if (too_deep_.first == nullptr) {
      open.pop_back();
    } else if (waiting.insert(too_deep_.first).second) {
      open.push_back(too_deep_);
    } else {
      constant_values_[too_deep_.first] = std::nullopt;  // it needs itself
    }
  }
  return value;
}

std::optional<ConstantValue> Declarer::constant_value(const plcopen::Variable* variable, bool is_local) {
  const auto [entry, fresh] = constant_values_.try_emplace(variable, std::nullopt);
  // A constant that needs itself finds no value here; its own errors are reported where it is declared.
  if (!fresh) return entry->second;
  constexpr std::uint32_t kMaxChain = 256;
  if (chain_ == kMaxChain) {
    constant_values_.erase(variable);
    too_deep_ = {variable, is_local};
    return std::nullopt;
  }
  ++chain_;
  // A global constant knows nothing of the POU that asks for it.
  NameMap<const plcopen::Variable*> hidden;
  const auto current = current_;
  if (!is_local) std::swap(hidden, local_constants_);
  if (!is_local) current_ = kNoPending;
  core::Diagnostics quiet;
  auto value = evaluate(variable->initial.text, variable->initial.at, quiet, {});
  if (!is_local) std::swap(hidden, local_constants_);
  current_ = current;
  --chain_;
  if (too_deep_.first != nullptr) {
    constant_values_.erase(variable);
    return std::nullopt;
  }
  const auto id = underlying_number(variable->type, 0);
  if (value && id) value = constant_of_type(*value, *id);
  constant_values_[variable] = value;
  return value;
}

// The number type that a declaration comes down to. Types need not be resolved yet.
std::optional<core::TypeId> Declarer::underlying_number(const plcopen::TypeSpec& spec, std::uint32_t depth) {
  constexpr std::uint32_t kMaxAliases = 64;
  if (depth == kMaxAliases) return std::nullopt;
  if (spec.kind == plcopen::TypeSpec::Kind::kSubrange && spec.base) return underlying_number(*spec.base, depth + 1);
  if (spec.kind != plcopen::TypeSpec::Kind::kNamed) return std::nullopt;
  if (const auto id = core::type_named(core::trimmed(spec.name))) {
    const bool number =
        *id != core::TypeId::kBool && core::in_category(*id, core::kAnyInt | core::kAnyBit | core::kAnyReal);
    return number ? id : std::nullopt;
  }
  const auto user = user_type_by_name_.find(core::trimmed(spec.name));
  if (user == user_type_by_name_.end()) return std::nullopt;
  return underlying_number(user_types_[user->second].declaration->type, depth + 1);
}

void Declarer::initialize_all() {
  for (std::uint32_t i = 0; i < user_types_.size(); ++i) {
    const Items& items = defaults_of(i);
    const bool own = user_types_[i].type &&
                     (types()[*user_types_[i].type].kind == TypeKind::kStruct ||
                      types()[*user_types_[i].type].kind == TypeKind::kUnion) &&
                     user_types_[i].declaration->type.kind != TypeSpec::Kind::kNamed;
    if (own && !items.empty()) module_.type_defaults.emplace(user_types_[i].type->index, items);
  }
  index_pending();
  std::uint32_t pou = kNoPou;
  enter_scope(pou);
  for (std::uint32_t i = 0; i < pending_.size() && initial_items_ <= kMaxTotalItems; ++i) {
    if (pending_[i].pou != pou) enter_scope(pou = pending_[i].pou);
    if (pending_state_[i] == State::kNew) initialize(i);
  }
  enter_scope(kNoPou);
  current_ = kNoPending;
  // A function's result begins with what its type begins with.
  for (std::uint32_t i = 0; i < module_.pous.size() && i < project_.pous.size(); ++i) {
    if (!module_.pous[i].return_type.valid()) continue;
    ir::Variable& result = module_.pous[i].variables[0];
    const std::string pou_name = project_.pous[i].name;
    result.initial =
        spec_defaults(project_.pous[i].return_type, result.type, {pou_name, pou_name, project_.pous[i].at});
  }
}

void Declarer::initialize(std::uint32_t number) {
  const Pending& pending = pending_[number];
  if (scope_pou_ != pending.pou) enter_scope(pending.pou);
  current_ = number;
  pending_state_[number] = State::kInProgress;
  const bool global = pending.pou == kNoPou;
  const auto target = [&]() -> ir::Variable& {
    return global ? module_.globals[pending.variable].variable : module_.pous[pending.pou].variables[pending.variable];
  };
  const Owner owner{global ? std::string_view{} : module_.pous[pending.pou].name, pending.declaration->name,
                    pending.declaration->at};
  ir::Variable& first = target();
  if (first.role == ir::Role::kExternal) {
    // A located or static variable lives in its global. An external takes the global's own value.
    const std::uint32_t index = first.global;
    if (pending.declaration->section != plcopen::Section::kExternal &&
        module_.globals[index].variable.initial.empty()) {
      Items items = initial_of(*pending.declaration, first.type, owner);
      module_.globals[index].variable.initial = std::move(items);
    }
  } else if (first.role != ir::Role::kInOut) {
    std::vector<ir::ReferenceInit> references;
    references_ = global ? nullptr : &references;
    Items items = initial_of(*pending.declaration, first.type, owner);
    references_ = nullptr;
    // EN without a value is TRUE, whether a POU declares it or not.
    const bool enables =
        first.role == ir::Role::kInput && first.type == ir::kBoolType && core::iequals(pending.declaration->name, "EN");
    if (enables && pending.declaration->initial.kind == InitialValue::Kind::kNone) {
      items.push_back({{}, {ir::kBoolType, 1, {}}});
    }
    initial_items_ += items.size();
    if (initial_items_ > kMaxTotalItems) {
      report(Code::P4020, pending.declaration->at, owner.pou,
             "the project sets more than " + std::to_string(kMaxTotalItems) + " initial values",
             "initialise large arrays in a first cycle");
    } else {
      target().initial = std::move(items);
      target().references = std::move(references);
    }
  }
  pending_state_[number] = State::kDone;
}

}  // namespace plc::st
