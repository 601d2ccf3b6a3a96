// Instructions that are no boolean logic: parts of values, moves, calls, blocks.
#include <algorithm>
#include <cassert>
#include <cstring>
#include <utility>

#include "bytecode/codegen/body_generator.h"
#include "bytecode/codegen/select.h"
#include "core/text.h"

namespace plc::bytecode {

BodyGenerator::Access BodyGenerator::access(std::uint32_t place) {
  Access found;
  std::vector<std::uint32_t> steps;
  ir::PlaceId at{place};
  for (; !is_static(at.index) && body_.places[at.index].parent.valid(); at = body_.places[at.index].parent) {
    steps.push_back(at.index);
  }
  if (is_static(at.index)) {
    found.base = place_words_[at.index];
  } else {
    const std::uint32_t leads = body_.places[at.index].index;
    const bool pointer = types_[body_.insts[leads].type].kind == ir::TypeKind::kPointer;
    found.from = pointer ? Access::From::kPointer : Access::From::kReference;
    found.base = operand(leads);
  }
  found.type = image_type(type_of_place(at.index));
  const auto step = [&](PathStep kind, std::uint32_t number) {
    found.path.push_back(static_cast<std::uint32_t>(kind));
    found.path.push_back(number);
  };
  for (; !steps.empty(); steps.pop_back()) {
    const Place& to = body_.places[steps.back()];
    const ir::TypeRef from = type_of_place(to.parent.index);
    if (to.kind == Place::Kind::kField) {
      step(PathStep::kField, shared_.layout.field_index(from, to.index));
    } else if (const auto element = known_element(to)) {
      step(PathStep::kElement, *element);
    } else {
      step(PathStep::kIndex, operand(to.index));
    }
  }
  return found;
}

std::optional<std::uint32_t> BodyGenerator::known_element(const Place& place) {
  if (place.kind == Place::Kind::kElement) return place.index;
  const Inst& index = body_.insts[place.index];
  if (index.op != Op::kConst) return std::nullopt;
  const ir::Type& array = types_[type_of_place(place.parent.index)];
  const core::Rep rep = types_.rep_of(index.type).value_or(core::Rep::kI64);
  const std::uint64_t bits = body_.constants[index.a].bits;
  const unsigned shift = 64 - core::rep_bytes(rep) * 8;
  const bool is_signed = rep == core::Rep::kI8 || rep == core::Rep::kI16 || rep == core::Rep::kI32;
  const auto value = is_signed ? static_cast<std::int64_t>(bits << shift) >> shift : static_cast<std::int64_t>(bits);
  if (value < array.lower || value > array.upper || (rep == core::Rep::kU64 && value < 0)) return std::nullopt;
  return static_cast<std::uint32_t>(value - array.lower);
}

void BodyGenerator::make_ref(const Inst& inst) {
  const Access place = access(inst.a);
  if (place.from == Access::From::kReference && place.path.empty()) {
    move(inst.type, destination(true), place.base);
  } else {
    const Opcode opcode = place.pick(Opcode::kRefAt, Opcode::kRefVia, Opcode::kRefPtr);
    access_op(opcode, {destination(true), place.base, place.type}, place);
  }
}

void BodyGenerator::take_address(const Inst& inst) {
  const Access place = access(inst.a);
  if (place.from == Access::From::kPointer && place.path.empty()) {
    move(inst.type, destination(false), place.base);
  } else {
    const Opcode opcode = place.pick(Opcode::kAdrAt, Opcode::kAdrVia, Opcode::kAdrPtr);
    access_op(opcode, {destination(false), place.base, place.type}, place);
  }
}

void BodyGenerator::instruction(const Inst& inst) {
  switch (inst.op) {
    case Op::kConst:
    case Op::kNot:
      break;
    case Op::kLoad:
      load(inst);
      break;
    case Op::kStore:
      store(inst);
      break;
    case Op::kCopy:
      copy(inst);
      break;
    case Op::kAnd:
    case Op::kOr:
    case Op::kXor:
      logic(inst);
      break;
    case Op::kCall:
      call(inst);
      break;
    case Op::kCallPou:
      call_pou(inst);
      break;
    case Op::kRun:
      run_block(inst);
      break;
    case Op::kLabel:
      label_words_[inst.a] = writer_.here();
      if (notes_) notes_->label(inst.a, here());
      break;
    case Op::kJump:
      jump(inst.a);
      break;
    case Op::kJumpIf:
      jump_unless(values()[inst.b].literal ^ 1u, inst.a);
      break;
    case Op::kJumpIfNot:
      jump_unless(values()[inst.b].literal, inst.a);
      break;
    case Op::kReturn:
      writer_.op(Opcode::kReturn, {});
      break;
    case Op::kClearEvent:
      writer_.op(Opcode::kClearEvent, {});
      break;
    case Op::kEno:
      writer_.op(Opcode::kEno, {destination(false)});
      break;
    case Op::kMakeRef:
      make_ref(inst);
      break;
    case Op::kAddress:
      take_address(inst);
      break;
    case Op::kPointerRef: {
      const std::uint32_t pointer = operand(inst.a);
      writer_.op(Opcode::kRefPtr, {destination(true), pointer, image_type(types_[inst.type].element)});
      break;
    }
    case Op::kPointerTo32:
    case Op::kPointerFrom32: {
      const std::uint32_t given = operand(inst.a);
      const bool to = inst.op == Op::kPointerTo32;
      writer_.op(to ? Opcode::kPtrTo32 : Opcode::kPtrFrom32, {destination(false), given});
      break;
    }
    case Op::kExtract: {
      const std::uint32_t word = operand(inst.a);
      writer_.op(Opcode::kExtract, {destination(false), word, inst.b});
      break;
    }
    case Op::kInsert: {
      const std::uint32_t word = operand(inst.a);
      const std::uint32_t part = operand(inst.b);
      writer_.op(Opcode::kInsert, {destination(false), word, part, inst.count});
      break;
    }
    case Op::kSameRef: {
      const std::uint32_t a = operand(inst.a);
      const std::uint32_t b = operand(inst.b);
      writer_.op(Opcode::kSameRef, {destination(false), a, b});
      break;
    }
    case Op::kRange:
      range(inst);
      break;
  }
}

void BodyGenerator::load(const Inst& inst) {
  ValueInfo& v = values()[now_];
  if (!is_static(inst.a)) {
    const Access from = access(inst.a);
    load_part(destination(!types_.rep_of(inst.type)), from);
    return;
  }
  if (v.last_use <= v.hazard) return;  // read where it is used
  v.word = intermediate_of(image_type(inst.type), lifetime(now_));
  v.hazard = kUnset;
  if (inst.type == ir::kBoolType) {
    writer_.record(v.word, leaf_piece(place_words_[inst.a], false));
  } else {
    move(inst.type, v.word, place_words_[inst.a]);
  }
}

void BodyGenerator::store(const Inst& inst) {
  const ValueInfo& v = values()[inst.b];
  const bool logic_value = is_logic(body_.insts[inst.b].op) || body_.insts[inst.b].op == Op::kNot;
  if (!logic_value && v.link == now_) return;  // written by the instruction that made the value
  const ir::TypeRef type = type_of_place(inst.a);
  if (!is_static(inst.a)) {
    const Access to = access(inst.a);
    store_part(to, types_.rep_of(type) ? operand(inst.b) : operand_as(inst.b, type));
    return;
  }
  if (type == ir::kBoolType) {
    store_bool(inst);
  } else {
    move(type, place_words_[inst.a], operand(inst.b));
  }
}

void BodyGenerator::copy(const Inst& inst) {
  const ir::TypeRef type = type_of_place(inst.a);
  std::uint32_t from = 0;
  if (is_static(inst.b)) {
    from = place_words_[inst.b];
  } else {
    from = is_static(inst.a) ? place_words_[inst.a] : intermediate_of(image_type(type), now_);
    load_part(from, access(inst.b));
  }
  if (is_static(inst.a)) {
    move(type, place_words_[inst.a], from);
  } else {
    store_part(access(inst.a), from);
  }
}

void BodyGenerator::range(const Inst& inst) {
  const ir::Type& limits = types_[inst.type];
  const auto bound = [&](std::int64_t value) {
    ir::Constant constant;
    constant.type = ir::ref_of(limits.elementary);
    constant.bits = static_cast<std::uint64_t>(value);
    return shared_.constants.word(constant);
  };
  const std::uint32_t value = operand(inst.a);
  const std::uint32_t lower = bound(limits.lower);
  const std::uint32_t upper = bound(limits.upper);
  writer_.op(range_for(core::rep_of(limits.elementary)), {destination(false), value, lower, upper});
}

void BodyGenerator::call(const Inst& inst) {
  const stdlib::Overload& overload = *body_.functions[inst.a];
  std::vector<std::uint32_t> list(1);
  for (std::uint32_t k = 0; k < inst.count; ++k) list.push_back(operand(body_.args[inst.b + k].index));
  const std::optional<Opcode> opcode = inst.count >= 2 ? opcode_for(overload) : std::nullopt;
  const bool chained = opcode && inst.count > 2 && overload.result_type() == overload.param_type(0);
  if (opcode && inst.count == 2) {
    writer_.op(*opcode, {destination(false), list[1], list[2]});
  } else if (chained) {
    // The running result stays out of the destination: a later argument may be that variable.
    std::uint32_t sum = list[1];
    for (std::uint32_t k = 2; k < inst.count; ++k) {
      const std::uint32_t next = intermediate_of(image_type(inst.type), now_);
      writer_.op(*opcode, {next, sum, list[k]});
      sum = next;
    }
    writer_.op(*opcode, {destination(false), sum, list[inst.count]});
  } else {
    list[0] = destination(false);
    writer_.op(Opcode::kCallStd, {shared_.function(overload)}, list, static_cast<std::uint32_t>(list.size()));
  }
}

void BodyGenerator::call_pou(const Inst& inst) {
  const PouLayout& callee = shared_.layout.pou(inst.a);
  const std::vector<ir::Variable>& variables = shared_.module.pous[inst.a].variables;
  std::vector<std::uint32_t> list;
  struct Late {
    std::uint32_t place, word;
  };
  std::vector<Late> late;
  for (std::uint32_t k = 0; k < inst.count; ++k) {
    const ir::CallArg& arg = body_.call_args[inst.b + k];
    const ir::TypeRef type = variables[arg.variable].type;
    std::uint32_t word = 0;
    if (arg.kind != ir::CallArg::Kind::kOutput) {
      word = types_.rep_of(type) ? operand(arg.value.index) : operand_as(arg.value.index, type);
    } else if (is_static(arg.place.index)) {
      word = place_words_[arg.place.index];
    } else {
      word = intermediate_of(image_type(type_of_place(arg.place.index)), now_);
      late.push_back({arg.place.index, word});
    }
    list.push_back(callee.field[arg.variable]);
    list.push_back(word);
  }
  if (values()[now_].uses != 0) {
    const auto result = std::find_if(variables.begin(), variables.end(),
                                     [](const ir::Variable& v) { return v.role == ir::Role::kReturnValue; });
    assert(result != variables.end());
    list.push_back(callee.field[static_cast<std::size_t>(result - variables.begin())]);
    list.push_back(destination(false));
  }
  writer_.op(Opcode::kCallFn, {shared_.image_pou[inst.a]}, list, static_cast<std::uint32_t>(list.size() / 2));
  for (const Late& l : late) {
    store_part(access(l.place), l.word);
  }
}

void BodyGenerator::run_block(const Inst& inst) {
  const auto executed = shared_.module.pou_run_by(body_, inst);
  const bool pou = executed && shared_.module.pous[*executed].taskblock == 0;
  const std::uint32_t what = pou ? shared_.image_pou[*executed] : shared_.block(type_of_place(inst.a));
  if (is_static(inst.a)) {
    writer_.op(pou ? Opcode::kCallPou : Opcode::kRunTb, {what, place_words_[inst.a]});
  } else {
    const Access instance = access(inst.a);
    const bool placed = instance.from == Access::From::kPlace;  // pointers to instances are followed as references
    const Opcode opcode =
        pou ? (placed ? Opcode::kCallAt : Opcode::kCallVia) : (placed ? Opcode::kRunAt : Opcode::kRunVia);
    access_op(opcode, {what, instance.base, instance.type}, instance);
  }
}

}  // namespace plc::bytecode
