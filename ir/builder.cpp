// Places and instructions: what appends to a body. The typed helpers
// are in assign.cpp, convert.cpp and named_call.cpp.
#include "ir/builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <utility>

#include "ir/text.h"

namespace plc::ir {
namespace {

/// Initial values beyond zero that structures bring, wherever they lie in a value of `type`.
void add_defaults(const Module& module, TypeRef ref, std::vector<std::uint32_t>& path, std::vector<InitItem>& out) {
  const Type& type = module.types[ref];
  if (type.kind == TypeKind::kArray) {
    path.push_back(0);
    for (std::int64_t i = type.lower; i <= type.upper; ++i, ++path.back()) {
      const std::size_t before = out.size();
      add_defaults(module, type.element, path, out);
      if (out.size() == before) break;  // nor do the other elements
    }
    path.pop_back();
  }
  const auto known = module.type_defaults.find(ref.index);
  if (known == module.type_defaults.end()) return;
  for (const InitItem& item : known->second) {
    out.push_back({path, item.value});
    out.back().path.insert(out.back().path.end(), item.path.begin(), item.path.end());
  }
}

}  // namespace

Builder::Builder(Module& module, std::uint32_t pou_index, core::Diagnostics& diagnostics)
    : module_(module), pou_index_(pou_index), owner_index_(pou_index), diagnostics_(diagnostics) {
  const Pou& built = module_.pous[pou_index_];
  if (built.owner != Pou::kDeclared) owner_index_ = built.owner;
  Body& b = body();
  if (b.sources.empty()) b.sources.push_back(built.at);
  source_ = static_cast<std::uint32_t>(b.sources.size() - 1);
  for (std::uint32_t i = 0; i < b.places.size(); ++i) interned_.emplace(b.places[i], PlaceId{i});
}

void Builder::set_source(const SourceRef& at) {
  Body& b = body();
  if (b.sources[source_] == at) return;
  b.sources.push_back(at);
  source_ = static_cast<std::uint32_t>(b.sources.size() - 1);
}

void Builder::report(core::Code code, const SourceRef& at, std::string message, std::string help) {
  diagnostics_.report(code, at, name(), std::move(message), std::move(help));
}

bool Builder::use_part(const SourceRef& declared, const SourceRef& at) {
  Library& library = module_.library;
  const auto part = library.at(declared);
  if (!part) return true;
  if (const auto own = library.at(pou().at)) library.need(*own, *part);
  return library.use(*part, at, pou().name, diagnostics_);
}

bool Builder::use_pou(std::uint32_t used, const SourceRef& at) { return use_part(module_.pous[used].at, at); }

bool Builder::is_broken(std::string_view name, const SourceRef& at) {
  Library& library = module_.library;
  name = name.substr(name.rfind('.') + 1);
  const auto part = library.broken(name, diagnostics_);
  if (!part) return false;
  if (const auto own = library.at(pou().at)) library.need(*own, *part);
  library.use(*part, at, pou().name, diagnostics_, name);
  return true;
}

std::uint32_t Builder::emit(Op op, TypeRef type, std::uint32_t a, std::uint32_t b, std::uint16_t count) {
  Body& target = body();
  Inst inst;
  inst.op = op;
  inst.part = part_;
  inst.count = count;
  inst.type = type;
  inst.a = a;
  inst.b = b;
  inst.source = source_;
  target.insts.push_back(inst);
  return static_cast<std::uint32_t>(target.insts.size() - 1);
}

// ---- places -------------------------------------------------------------------------------------------------------

PlaceId Builder::intern(const Place& place) {
  const auto [it, fresh] = interned_.try_emplace(place, PlaceId{});
  if (fresh) {
    it->second = PlaceId{static_cast<std::uint32_t>(body().places.size())};
    body().places.push_back(place);
  }
  return it->second;
}

void Builder::note_written_name(std::uint32_t global, std::string_view name, const SourceRef& at) {
  if (module_.globals[global].variable.address.empty()) return;
  std::vector<WrittenName>& names = module_.written_names[global];
  const bool known = std::any_of(names.begin(), names.end(), [&](const WrittenName& one) {
    return one.pou == pou_index_ && core::iequals(one.name, name);
  });
  if (!known) names.push_back({std::string(name), pou_index_, at});
}

void Builder::drop_written_names(std::uint32_t global) {
  const auto found = module_.written_names.find(global);
  if (found == module_.written_names.end()) return;
  bool first = true;
  std::erase_if(found->second,
                [&](const WrittenName& one) { return one.pou == pou_index_ && !std::exchange(first, false); });
}

PlaceId Builder::variable(std::uint32_t index) {
  if (index < variable_places_.size() && variable_places_[index].valid()) return variable_places_[index];
  const Variable& v = pou().variables[index];
  PlaceId id;
  if (v.role == Role::kExternal) {
    id = global(v.global);
  } else {
    Place place;
    place.kind = v.in_frame ? Place::Kind::kFrame : Place::Kind::kInstance;
    place.index = index;
    place.type = v.type;
    id = intern(place);
    // What an in-out refers to may change from call to call, so its reference is loaded each time.
    if (v.role == Role::kInOut) return deref(load(id));
  }
  if (index >= variable_places_.size()) variable_places_.resize(pou().variables.size());
  variable_places_[index] = id;
  return id;
}

PlaceId Builder::global(std::uint32_t index) {
  Place place;
  place.kind = Place::Kind::kGlobal;
  place.index = index;
  place.type = module_.globals[index].variable.type;
  if (module_.globals[index].from_library) use_part(module_.globals[index].variable.at, body().sources[source_]);
  return intern(place);
}

PlaceId Builder::self() {
  Place place;
  place.kind = Place::Kind::kSelf;
  place.type = pou().instance_type;
  return intern(place);
}

PlaceId Builder::field(PlaceId parent, std::uint32_t index) {
  const Type& type = module_.types[type_of(parent)];
  Place place;
  place.kind = Place::Kind::kField;
  place.index = index;
  place.parent = parent;
  switch (type.kind) {
    case TypeKind::kStruct:
      place.type = type.fields[index].type;
      break;
    case TypeKind::kBlock:
      place.type = ref_of(type.block->fields[index].type);
      break;
    case TypeKind::kPou:
      place.type = module_.pous[type.pou].variables[index].type;
      break;
    default:
      assert(false && "field of a type without fields");
  }
  return intern(place);
}

PlaceId Builder::element(PlaceId parent, std::uint32_t zero_based_index) {
  Place place;
  place.kind = Place::Kind::kElement;
  place.index = zero_based_index;
  place.parent = parent;
  place.type = module_.types[type_of(parent)].element;
  return intern(place);
}

PlaceId Builder::element_at(PlaceId array, ValueId index) {
  Place place;
  place.kind = Place::Kind::kElementAt;
  place.index = index.index;
  place.parent = array;
  place.type = module_.types[type_of(array)].element;
  return intern(place);
}

PlaceId Builder::deref(ValueId reference) {
  const Type& type = module_.types[type_of(reference)];
  if (type.kind == TypeKind::kPointer && module_.types.holds_instance(type.element)) {
    reference = {emit(Op::kPointerRef, module_.types.reference(type.element), reference.index)};
  }
  Place place;
  place.kind = Place::Kind::kDeref;
  place.index = reference.index;
  place.type = module_.types[type_of(reference)].element;
  return intern(place);
}

PlaceId Builder::part(PlaceId word, TypeRef part, unsigned bit_offset) {
  assert(part_fits(type_of(word), part, bit_offset));
  Place place;
  place.kind = Place::Kind::kPart;
  place.index = bit_offset;
  place.parent = word;
  place.type = part;
  return intern(place);
}

PlaceId Builder::character(PlaceId string, ValueId position) {
  const bool wide = module_.types[type_of(string)].elementary == core::TypeId::kWstring;
  Place place;
  place.kind = Place::Kind::kCharacter;
  place.index = position.index;
  place.parent = string;
  place.type = ref_of(wide ? core::TypeId::kWchar : core::TypeId::kChar);
  return intern(place);
}

std::optional<PlaceId> Builder::member(PlaceId parent, std::string_view name) {
  const Type& type = module_.types[type_of(parent)];
  switch (type.kind) {
    case TypeKind::kStruct:
      if (const auto position = module_.types.position_of(type_of(parent), name)) return field(parent, *position);
      return std::nullopt;
    case TypeKind::kUnion:
      // All members lie where the union does: one is read as what a pointer to it would lead to.
      if (const auto position = module_.types.position_of(type_of(parent), name)) {
        return deref(address(parent, type.fields[*position].type));
      }
      return std::nullopt;
    case TypeKind::kBlock:
      for (std::uint32_t i = 0; i < type.block->fields.size(); ++i) {
        const stdlib::Field& f = type.block->fields[i];
        if (f.direction != stdlib::Direction::kState && core::iequals(f.name, name)) return field(parent, i);
      }
      return std::nullopt;
    case TypeKind::kPou: {
      const Pou& callee = module_.pous[type.pou];
      const auto it = callee.by_name.find(name);
      if (it == callee.by_name.end()) return std::nullopt;
      const Role role = callee.variables[it->second].role;
      if (role != Role::kInput && role != Role::kOutput && role != Role::kInOut) return std::nullopt;
      return field(parent, it->second);
    }
    default:
      return std::nullopt;
  }
}

std::string Builder::describe(PlaceId place) { return place_text(module_, module_.pous[pou_index_], place); }

std::uint32_t Builder::hidden(std::string_view hint, TypeRef type) {
  Pou& p = pou();
  Variable v;
  v.name = fmt::format("#{}.{}", hint, p.variables.size());
  v.type = type;
  v.role = Role::kHidden;
  v.in_frame = p.kind == PouKind::kFunction;
  p.variables.push_back(std::move(v));
  return static_cast<std::uint32_t>(p.variables.size() - 1);
}

// ---- values -------------------------------------------------------------------------------------------------------

ValueId Builder::constant(const Constant& constant) {
  Body& b = body();
  // Runs of one constant (rails, literals in a column of rungs) share an entry; code generation pools the rest.
  if (b.constants.empty() || !(b.constants.back() == constant)) b.constants.push_back(constant);
  return {emit(Op::kConst, constant.type, static_cast<std::uint32_t>(b.constants.size() - 1))};
}

ValueId Builder::constant_bool(bool value) {
  Constant c;
  c.type = kBoolType;
  c.bits = value ? 1 : 0;
  return constant(c);
}

ValueId Builder::load(PlaceId place) {
  const Place at = body().places[place.index];
  if (at.kind == Place::Kind::kPart) return extract(load(at.parent), at.type, at.index);
  if (at.kind == Place::Kind::kCharacter) return character_of(load(at.parent), ValueId{at.index});
  const ValueId value{emit(Op::kLoad, at.type, place.index)};
  if (const auto narrow = narrow_hidden_.find(place.index); narrow != narrow_hidden_.end()) {
    set_narrow(value, narrow->second);
  }
  return value;
}

ValueId Builder::logic(Op and_or_xor, ValueId a, ValueId b) {
  assert(type_of(a) == kBoolType && type_of(b) == kBoolType);
  return {emit(and_or_xor, kBoolType, a.index, b.index)};
}

ValueId Builder::not_(ValueId a) {
  assert(type_of(a) == kBoolType);
  return {emit(Op::kNot, kBoolType, a.index)};
}

void Builder::store(PlaceId place, ValueId value) {
  assert(module_.types.elementary_of(type_of(place)) == module_.types.elementary_of(type_of(value)));
  const Place at = body().places[place.index];
  if (at.kind == Place::Kind::kPart) return store(at.parent, insert(load(at.parent), value, at.index));
  if (at.kind == Place::Kind::kCharacter) {
    return store(at.parent, with_character(load(at.parent), value, ValueId{at.index}));
  }
  emit(Op::kStore, {}, place.index, value.index);
  const Narrow* const narrow = narrow_of(value);
  const bool own = at.kind == Place::Kind::kInstance || at.kind == Place::Kind::kFrame;
  if (narrow != nullptr && own && pou().variables[at.index].role == Role::kHidden) {
    narrow_hidden_[place.index] = *narrow;
  }
}

void Builder::copy(PlaceId to, PlaceId from) {
  assert(type_of(to) == type_of(from));
  emit(Op::kCopy, {}, to.index, from.index);
}

void Builder::store_default(PlaceId place, std::vector<InitItem> initial) {
  const TypeRef ref = type_of(place);
  const Type& type = module_.types[ref];
  const auto rep = module_.types.rep_of(ref);
  if (rep && type.kind != TypeKind::kReference) {
    Constant begins{ref, static_cast<std::uint64_t>(type.initial), {}};
    if (!initial.empty()) begins = {ref, initial.back().value.bits, std::move(initial.back().value.text)};
    if (core::rep_bytes(*rep) < 8) begins.bits &= (std::uint64_t{1} << (core::rep_bytes(*rep) * 8)) - 1;
    return store(place, constant(begins));
  }
  // Aggregates and references: a variable that is never written holds it.
  if (initial.empty()) {
    std::vector<std::uint32_t> path;
    add_defaults(module_, ref, path, initial);
  }
  const std::uint32_t fresh = hidden("default", ref);
  pou().variables[fresh].initial = std::move(initial);
  if (rep) return store(place, load(variable(fresh)));
  copy(place, variable(fresh));
}

void Builder::run(PlaceId instance) {
  emit(Op::kRun, {}, instance.index);
  const Place at = body().places[instance.index];
  if (at.kind != Place::Kind::kInstance || pou().mocks.empty()) return;
  const std::vector<Mock> mocks = pou().mocks;
  for (const Mock& mock : mocks) {
    if (mock.variable != at.index) continue;
    const LabelId own = new_label();
    jump_if_not(load(variable(mock.active)), own);
    store(field(instance, mock.output), load(variable(mock.value)));
    bind(own);
  }
}

void Builder::run_action(PlaceId instance, std::uint32_t action) { emit(Op::kRun, {}, instance.index, action + 1); }

ValueId Builder::make_ref(PlaceId place) {
  assert(!is_part(place));
  return {emit(Op::kMakeRef, module_.types.reference(type_of(place)), place.index)};
}

ValueId Builder::same_ref(ValueId a, ValueId b) {
  assert(type_of(a) == type_of(b) && module_.types[type_of(a)].kind == TypeKind::kReference);
  return {emit(Op::kSameRef, kBoolType, a.index, b.index)};
}

ValueId Builder::address(PlaceId place, TypeRef target) {
  assert(!is_part(place));
  return {emit(Op::kAddress, module_.types.pointer(target), place.index)};
}

ValueId Builder::pointer_to_32(ValueId pointer, TypeRef to) {
  assert(module_.types[type_of(pointer)].kind == TypeKind::kPointer);
  return {emit(Op::kPointerTo32, to, pointer.index)};
}

ValueId Builder::pointer_from_32(ValueId address, TypeRef to) {
  assert(module_.types[to].kind == TypeKind::kPointer);
  return {emit(Op::kPointerFrom32, to, address.index)};
}

ValueId Builder::extract(ValueId word, TypeRef part, unsigned bit_offset) {
  assert(part_fits(type_of(word), part, bit_offset));
  return {emit(Op::kExtract, part, word.index, bit_offset)};
}

ValueId Builder::insert(ValueId word, ValueId part, unsigned bit_offset) {
  assert(part_fits(type_of(word), type_of(part), bit_offset));
  return {emit(Op::kInsert, type_of(word), word.index, part.index, static_cast<std::uint16_t>(bit_offset))};
}

ValueId Builder::range(ValueId value, TypeRef subrange) {
  assert(module_.types[subrange].kind == TypeKind::kSubrange);
  assert(module_.types.elementary_of(type_of(value)) == module_.types[subrange].elementary);
  return {emit(Op::kRange, subrange, value.index)};
}

bool Builder::part_fits(TypeRef word, TypeRef part, unsigned bit_offset) const {
  const auto bits_of = [this](TypeRef type) {
    const auto rep = module_.types.rep_of(type);
    return !rep ? 0u : *rep == Rep::kBool ? 1u : core::rep_bytes(*rep) * 8u;
  };
  const unsigned width = bits_of(part);
  return width != 0 && width < bits_of(word) && bit_offset % width == 0 && bit_offset < bits_of(word);
}

void Builder::clear_event() { emit(Op::kClearEvent, {}); }

ValueId Builder::eno() { return {emit(Op::kEno, kBoolType)}; }

ValueId Builder::call_overload(const stdlib::Overload& overload, std::span<const ValueId> args, TypeRef result_type) {
  Body& b = body();
  const auto known = std::find(b.functions.rbegin(), b.functions.rend(), &overload);
  std::uint32_t function = 0;
  if (known == b.functions.rend()) {
    function = static_cast<std::uint32_t>(b.functions.size());
    b.functions.push_back(&overload);
  } else {
    function = static_cast<std::uint32_t>(b.functions.rend() - known - 1);
  }
  const auto first = static_cast<std::uint32_t>(b.args.size());
  b.args.insert(b.args.end(), args.begin(), args.end());
  return {emit(Op::kCall, result_type, function, first, static_cast<std::uint16_t>(args.size()))};
}

ValueId Builder::call_pou(std::uint32_t pou, std::span<const CallArg> args) {
  Body& b = body();
  const auto first = static_cast<std::uint32_t>(b.call_args.size());
  b.call_args.insert(b.call_args.end(), args.begin(), args.end());
  const TypeRef result = module_.pous[pou].return_type;
  const std::uint32_t inst = emit(Op::kCallPou, result, pou, first, static_cast<std::uint16_t>(args.size()));
  return result.valid() ? ValueId{inst} : ValueId{};
}

// ---- control ------------------------------------------------------------------------------------------------------

LabelId Builder::new_label() { return {body().label_count++}; }
void Builder::bind(LabelId label) { emit(Op::kLabel, {}, label.index); }
void Builder::jump(LabelId label) { emit(Op::kJump, {}, label.index); }
void Builder::jump_if(ValueId condition, LabelId label) { emit(Op::kJumpIf, {}, label.index, condition.index); }
void Builder::jump_if_not(ValueId condition, LabelId label) { emit(Op::kJumpIfNot, {}, label.index, condition.index); }
void Builder::ret() { emit(Op::kReturn, {}); }

}  // namespace plc::ir
