// Data types: structures, enumerations, subranges, arrays, aliases, in any order, nested and anonymous.
#include <algorithm>
#include <unordered_map>
#include <utility>

#include "core/text.h"
#include "declare/declarer.h"
#include "frontend-st/foreign.h"
#include "frontend-st/lexer.h"
#include "frontend-st/literals.h"
#include "frontend-st/names.h"
#include "ir/foreign_size.h"

namespace plc::st {

using core::Code;
using core::SourceRef;
using ir::TypeKind;
using ir::TypeRef;
using plcopen::TypeSpec;

namespace {

/// Elements of one array, all dimensions. Larger ones cannot be laid out in a table.
constexpr std::int64_t kMaxElements = std::int64_t{1} << 28;
constexpr std::uint32_t kMaxTypeNesting = 64;

std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

}  // namespace

void Declarer::declare_data_types() {
  for (const plcopen::DataType& type : project_.data_types) {
    if (core::type_named(type.name) || module_.types.find(type.name).has_value()) {
      const bool hides = !core::type_named(type.name) && stdlib::block_named(type.name) != nullptr &&
                         module_.pou_by_name.find(type.name) == module_.pou_by_name.end();
      if (hides) {
        if (is_standard(type.name))
          report(Code::P4019, type.at, {},
                 "data type " + quoted(type.name) + " hides the standard function block of this name");
      } else {
        report(Code::P4018, type.at, {}, "data type " + quoted(type.name) + " has the name of another type");
        continue;
      }
    }
    const auto [known, fresh] = user_type_by_name_.emplace(type.name, static_cast<std::uint32_t>(user_types_.size()));
    if (!fresh) {
      report(Code::P4018, type.at, {},
             "data type " + quoted(type.name) + " is declared twice, first " +
                 first_place(user_types_[known->second].declaration->at, type.at));
      continue;
    }
    UserType entry;
    entry.declaration = &type;
    user_types_.push_back(std::move(entry));
  }
  for (std::uint32_t i = 0; i < user_types_.size(); ++i) {
    const plcopen::DataType& type = *user_types_[i].declaration;
    resolve_user_type(i, type.at, {{}, type.name, type.at});
  }
}

std::optional<TypeRef> Declarer::resolve_user_type(std::uint32_t index, const SourceRef& at, const Owner& owner) {
  if (user_types_[index].state == State::kDone) return user_types_[index].type;
  const plcopen::DataType& declaration = *user_types_[index].declaration;
  if (user_types_[index].state == State::kInProgress) {
    // A pointer to a type that is still being read closes a list or a tree; anything else would be infinitely large.
    if (pointers_ > user_types_[index].pointer_depth && user_types_[index].type) return user_types_[index].type;
    std::string path;
    bool inside = false;
    for (std::uint32_t step : resolving_) {
      inside = inside || step == index;
      if (inside) path += user_types_[step].declaration->name + " > ";
    }
    report(Code::P4016, at, owner.pou,
           "type " + quoted(declaration.name) + " contains itself: " + path + declaration.name,
           "break the circle with REF_TO");
    return std::nullopt;
  }
  user_types_[index].state = State::kInProgress;
  user_types_[index].pointer_depth = pointers_;
  resolving_.push_back(index);
  const Owner self{{}, declaration.name, declaration.at};
  std::optional<TypeRef> result;
  const TypeSpec& spec = declaration.type;
  switch (spec.kind) {
    case TypeSpec::Kind::kStruct:
    case TypeSpec::Kind::kUnion: {
      ir::Type type;
      type.kind = spec.kind == TypeSpec::Kind::kUnion ? TypeKind::kUnion : TypeKind::kStruct;
      type.at = declaration.at;
      types().declare(declaration.name, std::move(type));
      user_types_[index].type = types().find(declaration.name);
      fill_struct(*user_types_[index].type, spec, self);
      result = user_types_[index].type;
      break;
    }
    case TypeSpec::Kind::kEnum:
    case TypeSpec::Kind::kSubrange: {
      auto type = spec.kind == TypeSpec::Kind::kEnum ? make_enum(spec, self) : make_subrange(spec, self);
      if (!type) break;
      type->at = declaration.at;
      type->from_library = is_library(declaration.at);
      type->qualified = declaration.qualified;
      types().declare(declaration.name, std::move(*type));
      result = types().find(declaration.name);
      if (declaration.initial.kind != plcopen::InitialValue::Kind::kSimple) break;
      const auto value =
          evaluate(declaration.initial.text, place(declaration.initial.at, self), diagnostics_, {}, result);
      std::string problem;
      std::optional<Code> note;
      const auto constant = value ? constant_as(*value, *result, types(), problem, note) : std::nullopt;
      if (constant) {
        types().mutable_type(*result).initial = signed_value(constant->bits, core::rep_of(types()[*result].elementary));
      } else if (value) {
        report(Code::P4020, place(declaration.initial.at, self), {},
               "initial value of type " + quoted(declaration.name) + ": " + problem);
      }
      if (note) report(*note, place(declaration.initial.at, self), {}, quoted(declaration.name) + ": " + problem);
      break;
    }
    default:
      result = resolve(spec, self);
      if (result) types().declare_alias(declaration.name, *result);
      break;
  }
  resolving_.pop_back();
  user_types_[index].state = State::kDone;
  user_types_[index].type = result;
  return result;
}

std::optional<TypeRef> Declarer::unknown_type(std::string_view name, const SourceRef& at, const Owner& owner) {
  const std::string where =
      owner.pou.empty() ? quoted(owner.name) : quoted(owner.name) + " of POU " + std::string(owner.pou);
  if (options_.stub_missing) {
    report(Code::P4031, at, owner.pou, quoted(owner.name) + " has the unknown type " + quoted(name) + " and is a stub");
    ir::Type type;
    type.kind = TypeKind::kStruct;
    type.stub = true;
    type.at = at;
    types().declare(name, std::move(type));
    return types().find(name);
  }
  if (is_broken(name, owner.at, at, owner.pou)) return std::nullopt;
  Guess guess(name);
  for (const UserType& type : user_types_) guess.offer(type.declaration->name);
  for (const stdlib::BlockSpec& block : stdlib::blocks()) guess.offer(block.name);
  for (const std::string& offered : project_.offered_types) guess.offer(offered);
  for (const core::TypeInfo& info : core::kTypes) guess.offer(info.iec);
  std::string help = guess.help();
  if (const std::optional<Foreign> foreign = foreign_type(name)) {
    report(Code::P4014, at, owner.pou,
           where + " has the type " + quoted(name) + ", " + std::string(foreign->what) + ", which is not supported",
           std::string(foreign->help));
    return std::nullopt;
  }
  if (!supplier_of(name).empty()) {
    help = supply_help(
        name, "TYPE " + std::string(name) + " : STRUCT .. END_STRUCT; END_TYPE or FUNCTION_BLOCK " + std::string(name));
  } else if (help.empty()) {
    help =
        "neither the file nor the standard library declares it; add it to the project, name the file (--lib) or the "
        "configuration (--config plc.toml) that has it, or run with --stub-missing";
  }
  report(Code::P4014, at, owner.pou, where + " has the unknown type " + quoted(name), help);
  return std::nullopt;
}

std::optional<TypeRef> Declarer::resolve_name(std::string_view name, const SourceRef& at, const Owner& owner) {
  name = core::trimmed(name);
  const auto user = user_type_by_name_.find(name);
  if (user != user_type_by_name_.end()) {
    note_use(owner.at, user_types_[user->second].declaration->at, at, owner.pou);
    return resolve_user_type(user->second, at, owner);
  }
  const auto known = types().find(name);
  if (!known) {
    // Types of libraries are written with their namespace: "Tc2_Standard.TON". All share one space of names here.
    const std::size_t dot = name.rfind('.');
    const std::string_view own = dot == std::string_view::npos ? std::string_view() : name.substr(dot + 1);
    if (user_type_by_name_.count(own) != 0 || types().find(own)) return resolve_name(own, at, owner);
    return unknown_type(name, at, owner);
  }
  const ir::Type& type = types()[*known];
  if (type.kind == TypeKind::kPou) note_use(owner.at, module_.pous[type.pou].at, at, owner.pou);
  if (type.stub)
    report(Code::P4031, at, owner.pou, quoted(owner.name) + " has the unknown type " + quoted(name) + " and is a stub");
  if (type.kind == TypeKind::kPou && module_.pous[type.pou].kind == ir::PouKind::kProgram) {
    report(Code::P4014, at, owner.pou, quoted(owner.name) + " has the program " + quoted(name) + " as its type",
           "programs are instantiated by tasks; make it a function block to use it as a variable");
    return std::nullopt;
  }
  return known;
}

void Declarer::report_depth(const SourceRef& at, const Owner& owner) {
  report(Code::P4017, at, owner.pou,
         "type of " + quoted(owner.name) + " is nested more than " + std::to_string(kMaxTypeNesting) + " levels deep");
}

std::uint32_t Declarer::depth_of(TypeRef type) const { return type.index < depth_.size() ? depth_[type.index] : 0; }

void Declarer::set_depth(TypeRef type, std::uint32_t depth) {
  if (type.index >= depth_.size()) depth_.resize(types().size());
  depth_[type.index] = depth;
}

std::optional<TypeRef> Declarer::resolve(const TypeSpec& spec, const Owner& owner) {
  const SourceRef& at = place(spec.at, owner);
  const bool open_allowed = std::exchange(open_allowed_, false);
  if (++nesting_ > kMaxTypeNesting) {
    --nesting_;
    report_depth(at, owner);
    return std::nullopt;
  }
  std::optional<TypeRef> result;
  switch (spec.kind) {
    case TypeSpec::Kind::kNamed:
      result = resolve_name(spec.name, at, owner);
      break;
    case TypeSpec::Kind::kString:
      result = resolve_string(spec, owner);
      break;
    case TypeSpec::Kind::kArray:
      result = resolve_array(spec, owner, open_allowed);
      break;
    case TypeSpec::Kind::kStruct:
    case TypeSpec::Kind::kUnion: {
      const bool united = spec.kind == TypeSpec::Kind::kUnion;
      ir::Type type;
      type.kind = united ? TypeKind::kUnion : TypeKind::kStruct;
      type.at = at;
      result = anonymous(std::move(type), owner, united ? "union" : "struct");
      if (result) fill_struct(*result, spec, owner);
      break;
    }
    case TypeSpec::Kind::kEnum: {
      auto type = make_enum(spec, owner);
      if (type) result = anonymous(std::move(*type), owner, "enum");
      break;
    }
    case TypeSpec::Kind::kSubrange: {
      auto type = make_subrange(spec, owner);
      if (type) result = anonymous(std::move(*type), owner, "range");
      break;
    }
    case TypeSpec::Kind::kPointer:
    case TypeSpec::Kind::kReference:
    case TypeSpec::Kind::kReferenceTo: {
      if (!spec.base) break;
      ++pointers_;
      const auto target = resolve(*spec.base, owner);
      --pointers_;
      if (!target) break;
      result = spec.kind == TypeSpec::Kind::kPointer     ? types().pointer(*target)
               : spec.kind == TypeSpec::Kind::kReference ? types().reference(*target)
                                                         : types().reference_to(*target);
      break;
    }
    case TypeSpec::Kind::kMissing:
      report(Code::P4014, at, owner.pou, quoted(owner.name) + " has no type");
      break;
  }
  --nesting_;
  return result;
}

// Anonymous types are equal to nothing but themselves; their names contain a blank, which no source can spell.
std::optional<TypeRef> Declarer::anonymous(ir::Type type, const Owner& owner, std::string_view kind) {
  std::string name =
      std::string(kind) + " of " + (owner.pou.empty() ? "" : std::string(owner.pou) + ".") + std::string(owner.name);
  while (types().find(name))
    name = std::string(kind) + " " + std::to_string(++anonymous_count_) + " of " + std::string(owner.name);
  types().declare(name, std::move(type));
  return types().find(name);
}

bool Declarer::fill_struct(TypeRef type, const TypeSpec& spec, const Owner& owner) {
  std::vector<ir::TypeField> fields;
  std::unordered_map<std::string_view, core::SourceRef, core::NameHash, core::NameEqual> names;
  std::uint32_t deepest = 0;
  bool fine = true;
  for (const plcopen::Variable& member : spec.members) {
    const core::SourceRef at = place(member.at, owner);
    const auto [known, fresh] = names.emplace(member.name, at);
    if (!fresh) {
      report(Code::P4018, at, owner.pou,
             "member " + quoted(member.name) + " of " + quoted(owner.name) + " is declared twice, first " +
                 first_place(known->second, at));
      fine = false;
      continue;
    }
    const std::string path = std::string(owner.name) + "." + member.name;
    const Owner self{owner.pou, path, place(member.at, owner)};
    auto member_type = resolve(member.type, self);
    if (member_type && depth_of(*member_type) >= kMaxTypeNesting) {
      report_depth(self.at, self);
      member_type.reset();
    }
    if (member_type) deepest = std::max(deepest, depth_of(*member_type));
    fine = fine && member_type.has_value();
    // A member without a usable type keeps its place, so that later members keep theirs.
    fields.push_back({member.name, member_type.value_or(ir::kBoolType)});
  }
  types().mutable_type(type).fields = std::move(fields);
  set_depth(type, deepest + 1);
  if (spec.base) fine = refuse_extended(spec, owner) && fine;
  if (fine && types()[type].kind == TypeKind::kUnion) check_union(type, spec, owner);
  return fine;
}

// What a structure extends was not joined (extended_structures.h): it is unknown, no structure, or extends this one.
bool Declarer::refuse_extended(const TypeSpec& spec, const Owner& owner) {
  const core::SourceRef& at = place(spec.base->at, owner);
  if (nesting_ >= kMaxTypeNesting) {
    report_depth(at, owner);
    return false;
  }
  ++nesting_;
  const auto base = resolve_name(spec.base->name, at, owner);
  --nesting_;
  if (!base) return false;
  if (types()[*base].stub) return true;
  // One that is a structure was refused itself.
  const auto known = user_type_by_name_.find(core::trimmed(spec.base->name));
  const bool structure =
      known != user_type_by_name_.end() && user_types_[known->second].declaration->type.kind == TypeSpec::Kind::kStruct;
  if (!structure) {
    report(Code::P4017, at, owner.pou,
           quoted(owner.name) + " EXTENDS " + quoted(spec.base->name) + ", which is not declared as a structure",
           "only a structure extends a structure");
  } else if (user_types_[known->second].declaration->type.base == nullptr) {
    report(Code::P4017, at, owner.pou,
           quoted(owner.name) + " EXTENDS " + quoted(spec.base->name) +
               ", which has too many members: all such structures get at most 1000000 members and values",
           "give the structure a member of the other type");
  }
  return false;
}

// Members of a union share their bytes: what is checked where it is used, or has a state, cannot be among them.
void Declarer::check_union(TypeRef type, const TypeSpec& spec, const Owner& owner) {
  const core::SourceRef& at = place(spec.at, owner);
  if (types()[type].fields.empty()) {
    report(Code::P4209, at, owner.pou, "union " + quoted(owner.name) + " has no member");
    return;
  }
  for (std::size_t i = 0; i < spec.members.size(); ++i) {
    const TypeRef member = types()[type].fields[i].type;
    const bool reference = types().holds_reference(member);
    if (!reference && ir::foreign_size(types(), member)) continue;
    report(Code::P4209, place(spec.members[i].at, owner), owner.pou,
           "member " + quoted(spec.members[i].name) + " of union " + quoted(owner.name) + " has type " +
               types().name_of(member) + ", which shares its bytes with nothing",
           reference ? "references are checked handles: use POINTER TO" : "function blocks have a state of their own");
  }
}

std::optional<std::int64_t> Declarer::integer_constant(std::string_view text, const SourceRef& at, const Owner& owner,
                                                       std::string_view what) {
  const auto value = evaluate(text, at, diagnostics_, owner.pou);
  if (!value) return std::nullopt;
  if (value->kind == ConstantValue::Kind::kTyped && types()[value->constant.type].kind == TypeKind::kEnum) {
    return signed_value(value->constant.bits, core::rep_of(types()[value->constant.type].elementary));
  }
  if (value->kind != ConstantValue::Kind::kInt || value->is_unsigned) {
    report(Code::P4017, at, owner.pou,
           std::string(what) + " of " + quoted(owner.name) + ", " + quoted(text) + ", is not an integer");
    return std::nullopt;
  }
  return value->int_value;
}

std::optional<TypeRef> Declarer::resolve_string(const TypeSpec& spec, const Owner& owner) {
  const bool wide = core::iequals(core::trimmed(spec.name), "WSTRING");
  const core::TypeId id = wide ? core::TypeId::kWstring : core::TypeId::kString;
  if (core::trimmed(spec.length).empty()) return types().string(id, core::kDefaultStringCapacity);
  const auto length = integer_constant(spec.length, place(spec.length_at, spec.at, owner), owner, "length");
  if (!length) return std::nullopt;
  if (*length < 1 || *length > core::kMaxStringCapacity) {
    report(Code::P4017, place(spec.at, owner), owner.pou,
           "length " + std::to_string(*length) + " of " + quoted(owner.name) + " is not 1 to " +
               std::to_string(core::kMaxStringCapacity));
    return std::nullopt;
  }
  return types().string(id, static_cast<std::uint16_t>(*length));
}

std::optional<TypeRef> Declarer::resolve_array(const TypeSpec& spec, const Owner& owner, bool open_allowed) {
  const SourceRef& at = place(spec.at, owner);
  if (!spec.base || spec.dimensions.empty()) {
    report(Code::P4017, at, owner.pou,
           "array " + quoted(owner.name) + " has no " + (spec.base ? "dimensions" : "element type"));
    return std::nullopt;
  }
  const auto element = resolve(*spec.base, owner);
  const auto open = [](const plcopen::Dimension& d) { return core::trimmed(d.lower) == "*"; };
  const auto stars = std::count_if(spec.dimensions.begin(), spec.dimensions.end(), open);
  if (stars != 0) {
    if (!open_allowed || stars != static_cast<std::ptrdiff_t>(spec.dimensions.size())) {
      report(Code::P4043, at, owner.pou, quoted(owner.name) + " is an array of variable length",
             open_allowed ? "write [*] for all dimensions or for none"
                          : "VAR_INPUT and VAR_IN_OUT of functions may be ARRAY [*]; elsewhere write the bounds");
      return std::nullopt;
    }
    std::optional<TypeRef> type = element;
    for (auto i = stars; type && i > 0; --i) type = types().open_array(*type);
    return type;
  }
  std::vector<std::pair<std::int64_t, std::int64_t>> bounds;
  std::int64_t total = 1;
  bool fine = element.has_value();
  for (const plcopen::Dimension& dimension : spec.dimensions) {
    const auto lower =
        integer_constant(dimension.lower, place(dimension.lower_at, spec.at, owner), owner, "lower bound");
    const auto upper =
        integer_constant(dimension.upper, place(dimension.upper_at, spec.at, owner), owner, "upper bound");
    if (!lower || !upper) {
      fine = false;
      continue;
    }
    std::int64_t count = 0;
    const bool huge = *upper >= *lower &&
                      (__builtin_sub_overflow(*upper, *lower, &count) || __builtin_add_overflow(count, 1, &count) ||
                       __builtin_mul_overflow(total, count, &total) || total > kMaxElements);
    if (*lower > *upper || huge) {
      report(Code::P4017, at, owner.pou,
             "array " + quoted(owner.name) + " with bounds " + std::to_string(*lower) + ".." + std::to_string(*upper) +
                 (huge ? " has more than " + std::to_string(kMaxElements) + " elements" : " has no elements"),
             huge ? "" : "the lower bound comes first");
      return std::nullopt;
    }
    bounds.emplace_back(*lower, *upper);
  }
  if (!fine) return std::nullopt;
  TypeRef type = *element;
  if (bounds.size() > kMaxTypeNesting - std::min(depth_of(type), kMaxTypeNesting)) {
    report_depth(at, owner);
    return std::nullopt;
  }
  for (std::size_t i = bounds.size(); i-- > 0;) {
    const std::uint32_t depth = depth_of(type) + 1;
    type = types().array(type, bounds[i].first, bounds[i].second);
    set_depth(type, depth);
  }
  return type;
}

std::optional<ir::Type> Declarer::make_enum(const TypeSpec& spec, const Owner& owner) {
  ir::Type out;
  out.kind = TypeKind::kEnum;
  out.elementary = core::TypeId::kInt;
  out.at = place(spec.at, owner);
  bool fixed_base = false;
  if (spec.base && spec.base->kind != TypeSpec::Kind::kMissing) {
    const auto base = resolve(*spec.base, owner);
    if (!base) return std::nullopt;
    const auto id = types().is_elementary(*base) ? types().elementary_of(*base) : std::nullopt;
    if (!id || !core::in_category(*id, core::kAnyInt | core::kAnyBit) || *id == core::TypeId::kBool) {
      report(Code::P4017, out.at, owner.pou,
             "enumeration " + quoted(owner.name) + " is based on " + types().name_of(*base) +
                 ", which is no integer type");
      return std::nullopt;
    }
    out.elementary = *id;
    fixed_base = true;
  }
  if (spec.values.empty()) {
    report(Code::P4017, out.at, owner.pou, "enumeration " + quoted(owner.name) + " has no values");
    return std::nullopt;
  }
  earlier_values_.clear();
  std::int64_t next = 0;
  for (const plcopen::EnumValue& value : spec.values) {
    const SourceRef& at = place(value.at, owner);
    if (!core::trimmed(value.value).empty()) {
      const auto given = integer_constant(value.value, place(value.value_at, value.at, owner), owner, "a value");
      if (given) next = *given;
    }
    if (!int_fits(next, false, out.elementary) && !fixed_base) {
      // Values tell the size when no base type is declared.
      out.elementary = int_fits(next, false, core::TypeId::kDint) ? core::TypeId::kDint : core::TypeId::kLint;
    }
    if (!int_fits(next, false, out.elementary)) {
      report(Code::P4017, at, owner.pou,
             "value " + std::to_string(next) + " of " + quoted(value.name) + " does not fit into " +
                 std::string(core::name_of(out.elementary)));
    }
    if (!earlier_values_.emplace(value.name, next).second) {
      const auto first = std::find_if(spec.values.begin(), spec.values.end(), [&](const plcopen::EnumValue& other) {
        return core::iequals(other.name, value.name);
      });
      report(Code::P4018, at, owner.pou,
             "value " + quoted(value.name) + " of " + quoted(owner.name) + " is declared twice, first " +
                 first_place(place(first->at, owner), at));
      continue;
    }
    out.members.push_back({value.name, next});
    if (next != INT64_MAX) ++next;
  }
  earlier_values_.clear();
  out.initial = out.members.front().value;
  return out;
}

std::optional<ir::Type> Declarer::make_subrange(const TypeSpec& spec, const Owner& owner) {
  ir::Type out;
  out.kind = TypeKind::kSubrange;
  out.at = place(spec.at, owner);
  const auto base = spec.base ? resolve(*spec.base, owner) : std::nullopt;
  if (spec.base && !base) return std::nullopt;
  const auto id = base ? types().elementary_of(*base) : std::nullopt;
  if (!id || !core::in_category(*id, core::kAnyInt) || spec.dimensions.empty()) {
    report(Code::P4017, out.at, owner.pou, "subrange " + quoted(owner.name) + " is not a range of an integer type");
    return std::nullopt;
  }
  out.elementary = *id;
  const plcopen::Dimension& limits = spec.dimensions[0];
  const auto lower = integer_constant(limits.lower, place(limits.lower_at, spec.at, owner), owner, "lower limit");
  const auto upper = integer_constant(limits.upper, place(limits.upper_at, spec.at, owner), owner, "upper limit");
  if (!lower || !upper) return std::nullopt;
  if (*lower > *upper) {
    report(Code::P4017, out.at, owner.pou,
           "range " + std::to_string(*lower) + ".." + std::to_string(*upper) + " of " + quoted(owner.name) +
               " begins after its end");
    return std::nullopt;
  }
  if (!int_fits(*lower, false, *id) || !int_fits(*upper, false, *id)) {
    report(Code::P4017, out.at, owner.pou,
           "range " + std::to_string(*lower) + ".." + std::to_string(*upper) + " of " + quoted(owner.name) +
               " does not lie in " + std::string(core::name_of(*id)));
    return std::nullopt;
  }
  out.lower = *lower;
  out.upper = *upper;
  out.initial = *lower;
  return out;
}

}  // namespace plc::st
