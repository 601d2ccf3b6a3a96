// FOR, WHILE, REPEAT, EXIT, CONTINUE (IEC 61131-3:2013, table 72). Conditions come after the statements of a loop, so
// that one jump back closes an iteration; each counts against the loop budget of the task.
#include "frontend-st/literals.h"
#include "frontend-st/lowering.h"

namespace plc::st {

using core::Code;
using ir::Operand;
using ir::PlaceId;
using ir::TypeKind;
using ir::TypeRef;
using ir::ValueId;

namespace {

std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

struct Range {
  std::int64_t least, greatest;
};
/// Values of an integer type, as its 64-bit patterns read with the sign the type has.
Range range_of(core::TypeId type) {
  const unsigned bits = core::rep_bytes(core::rep_of(type)) * 8;
  if (core::in_category(type, core::kAnySigned)) {
    return {static_cast<std::int64_t>(~std::uint64_t{0} << (bits - 1)),
            static_cast<std::int64_t>((std::uint64_t{1} << (bits - 1)) - 1)};
  }
  return {0, static_cast<std::int64_t>(~std::uint64_t{0} >> (64 - bits))};
}

}  // namespace

ValueId Lowering::integer(TypeRef type, std::int64_t value) {
  ir::Constant constant;
  constant.type = type;
  constant.bits = truncate_bits(static_cast<std::uint64_t>(value), core::rep_of(*types().elementary_of(type)));
  return builder_.constant(constant);
}

// Bit strings count as the integers without sign of their bits.
std::optional<ValueId> Lowering::counted(std::string_view function, ValueId a, ValueId b, NodeId where) {
  const core::TypeId type = *types().elementary_of(builder_.type_of(a));
  if (!core::in_category(type, core::kAnyBit)) return compare(function, a, b, where);
  const std::string bits(core::name_of(type));
  const std::string number(core::name_of(stdlib::unsigned_of(type)));
  const auto converted = [&](ValueId value, const std::string& from, const std::string& to) {
    const Operand given = operand(value, where);
    return builder_.call(from + "_TO_" + to, std::span(&given, 1), at(where));
  };
  const auto first = converted(a, bits, number);
  const auto second = converted(b, bits, number);
  const auto result = first && second ? compare(function, *first, *second, where) : std::nullopt;
  return result ? converted(*result, number, bits) : std::nullopt;
}

bool Lowering::loop_body(NodeId id, Loop loop) {
  loops_.push_back(loop);
  const ir::PartScope plain(builder_, ir::Part::kPlain);
  const bool fine = statements(node(id).b);
  loops_.pop_back();
  builder_.set_source(at(id));
  builder_.bind(loop.again);
  return fine;
}

bool Lowering::leave_loop(NodeId id) {
  const bool exit = node(id).kind == NodeKind::kExit;
  if (loops_.empty()) {
    report(Code::P4013, at(id), std::string(exit ? "EXIT" : "CONTINUE") + " is outside of a loop");
    return false;
  }
  builder_.jump(exit ? loops_.back().exit : loops_.back().again);
  return true;
}

bool Lowering::while_loop(NodeId id) {
  const Loop loop{builder_.new_label(), builder_.new_label()};
  const ir::LabelId body = builder_.new_label();
  builder_.jump(loop.again);
  builder_.bind(body);
  const bool fine = loop_body(id, loop);
  const auto again = condition(node(id).a, "condition of WHILE");
  if (again) builder_.jump_if(*again, body);
  builder_.bind(loop.exit);
  return fine && again;
}

bool Lowering::repeat_loop(NodeId id) {
  const Loop loop{builder_.new_label(), builder_.new_label()};
  const ir::LabelId body = builder_.new_label();
  builder_.bind(body);
  const bool fine = loop_body(id, loop);
  const auto done = condition(node(id).a, "condition of UNTIL");
  if (done) builder_.jump_if_not(*done, body);
  builder_.bind(loop.exit);
  return fine && done;
}

// Initial value, final value and increment are computed once, in this order, before the control variable is set.
bool Lowering::for_loop(NodeId id) {
  const NodeId initial_id = node(id).c;
  const NodeId final_id = initial_id == kNoNode ? kNoNode : node(initial_id).next;
  const NodeId step_id = final_id == kNoNode ? kNoNode : node(final_id).next;
  const auto control = node(id).a == kNoNode ? std::nullopt : place(node(id).a, true);
  const auto elementary = control ? types().elementary_of(builder_.type_of(*control)) : std::nullopt;
  const bool bits = elementary && core::in_category(*elementary, core::kAnyBit) && *elementary != core::TypeId::kBool;
  const bool integral = elementary && (bits || core::in_category(*elementary, core::kAnyInt)) &&
                        types()[builder_.type_of(*control)].kind != TypeKind::kEnum;
  if (control && !integral) {
    report(Code::P4071, at(node(id).a),
           "control variable " + quoted(text(node(id).a)) + " has type " + types().name_of(builder_.type_of(*control)),
           "count with a variable of an integer type");
  }
  if (!integral) {
    const Loop unused{builder_.new_label(), builder_.new_label()};
    loop_body(id, unused);  // its errors are its own
    builder_.bind(unused.exit);
    return false;
  }
  const TypeRef type = builder_.type_of(*control);
  const TypeRef base = ir::ref_of(*elementary);
  if (bits) {
    report(Code::P4333, at(node(id).a),
           "FOR counts with " + quoted(text(node(id).a)) + " of type " + types().name_of(type),
           "count with a variable of an integer type");
  }
  const auto bound = [&](NodeId bound_id, std::string_view what) {
    const auto given = value(bound_id, type);
    return given ? builder_.convert(*given, type, what) : std::nullopt;
  };
  const auto initial = bound(initial_id, "initial value of FOR");
  const auto final_value = bound(final_id, "final value of FOR");
  std::optional<std::int64_t> known_step = 1;
  std::optional<ValueId> step;
  if (step_id != kNoNode) {
    const auto given = value(step_id, base);
    known_step.reset();
    if (given && given->kind == Operand::Kind::kIntLiteral && !given->int_is_unsigned) {
      known_step = given->int_value;
      const std::int64_t size = given->int_value < 0 ? -(given->int_value + 1) : given->int_value;
      if (size > range_of(*elementary).greatest && range_of(*elementary).greatest > 0) {
        report(Code::P4107, at(step_id),
               "increment " + quoted(text(step_id)) + " of FOR does not fit into " + types().name_of(base));
        return false;
      }
    } else if (given) {
      step = builder_.convert(*given, base, "increment of FOR");
      if (step && builder_.body().insts[step->index].op == ir::Op::kConst) {
        known_step = signed_value(builder_.body().constants[builder_.body().insts[step->index].a].bits,
                                  core::rep_of(*elementary));
      }
    }
    if (known_step == 0) {
      report(Code::P4071, at(step_id), "increment of FOR is 0: the loop would not end");
      known_step.reset();
    }
  }
  if (!initial || !final_value || (!known_step && !step)) {
    const Loop unused{builder_.new_label(), builder_.new_label()};
    loop_body(id, unused);
    builder_.bind(unused.exit);
    return false;
  }
  const ir::PartScope counting(builder_, ir::Part::kForControl);
  builder_.store(*control, *initial);
  return known_step ? for_known_step(id, *control, *initial, *final_value, *known_step)
                    : for_any_step(id, *control, *final_value, *step);
}

// The loop goes on while the control variable lies a whole step before the final value; asking before counting, it ends
// at the limits of the type too. Afterwards the control variable is one step past the last value, but for
// subranges, which hold no such value.
bool Lowering::for_known_step(NodeId id, PlaceId control, ValueId initial, ValueId final_value, std::int64_t step) {
  const TypeRef type = builder_.type_of(control);
  const core::TypeId elementary = *types().elementary_of(type);
  const TypeRef base = ir::ref_of(elementary);
  const bool up = step > 0;
  const Range range = range_of(elementary);
  const NodeId head = node(id).a;
  // Of 64 bits without sign only the order of patterns differs, and no step reaches across the sign.
  const std::int64_t less = up ? step - 1 : -(step + 1);
  ValueId limit = final_value;
  if (less != 0) {
    const ValueId nearest = integer(base, up ? range.least : range.greatest);
    const ValueId room = integer(base, up ? range.least + less : range.greatest - less);
    const ValueId distance = integer(base, less);
    const auto too_near = compare(up ? "LT" : "GT", final_value, room, head);
    const auto moved = counted(up ? "SUB" : "ADD", final_value, distance, head);
    if (!too_near || !moved) return false;
    const Operand choice[] = {operand(*too_near, head), operand(*moved, head), operand(nearest, head)};
    const auto chosen = builder_.call("SEL", choice, at(head));
    if (!chosen) return false;
    limit = *chosen;
  }
  const Loop loop{builder_.new_label(), builder_.new_label()};
  const ir::LabelId body = builder_.new_label();
  const auto first = compare(up ? "LE" : "GE", initial, final_value, head);
  if (!first) return false;
  builder_.jump_if_not(*first, loop.exit);
  builder_.bind(body);
  const bool fine = loop_body(id, loop);
  // The jump directly after its comparison is one step of the interpreter; so the way out counts for itself.
  const auto more = compare(up ? "LT" : "GT", builder_.load(control), limit, head);
  if (!more) return false;
  const auto count = [&] {
    const auto next = counted(up ? "ADD" : "SUB", builder_.load(control), integer(base, less + 1), head);
    if (next) builder_.store(control, *next);
    return next.has_value();
  };
  const bool keeps_last = types()[type].kind == TypeKind::kSubrange;
  const ir::LabelId last = keeps_last ? loop.exit : builder_.new_label();
  builder_.jump_if_not(*more, last);
  if (!count()) return false;
  builder_.jump(body);
  if (!keeps_last) {
    builder_.bind(last);
    if (!count()) return false;
  }
  builder_.bind(loop.exit);
  return fine;
}

// The sign of the increment is known only when the loop runs.
bool Lowering::for_any_step(NodeId id, PlaceId control, ValueId final_value, ValueId step) {
  const NodeId head = node(id).a;
  const TypeRef base = ir::ref_of(*types().elementary_of(builder_.type_of(control)));
  const Loop loop{builder_.new_label(), builder_.new_label()};
  const ir::LabelId test = builder_.new_label();
  const auto up = compare("GE", step, integer(base, 0), head);
  if (!up) return false;
  builder_.bind(test);
  const ValueId at_test = builder_.load(control);
  const auto not_above = compare("LE", at_test, final_value, head);
  const auto not_below = compare("GE", at_test, final_value, head);
  if (!not_above || !not_below) return false;
  const ValueId rising = builder_.logic(ir::Op::kAnd, *up, *not_above);
  const ValueId falling = builder_.logic(ir::Op::kAnd, builder_.not_(*up), *not_below);
  builder_.jump_if_not(builder_.logic(ir::Op::kOr, rising, falling), loop.exit);
  const bool fine = loop_body(id, loop);
  const ValueId now = builder_.load(control);
  const auto next = counted("ADD", now, step, head);
  if (!next) return false;
  // Beyond the limits of the type the count wraps, and the loop is over.
  const auto grew = compare("GE", *next, now, head);
  if (!grew) return false;
  const ValueId wrapped = builder_.logic(ir::Op::kXor, *up, *grew);
  if (types()[builder_.type_of(control)].kind == TypeKind::kSubrange) {
    const auto above = compare("GT", *next, final_value, head);
    const auto below = compare("LT", *next, final_value, head);
    if (!above || !below) return false;
    const ValueId past = builder_.logic(ir::Op::kOr, builder_.logic(ir::Op::kAnd, *up, *above),
                                        builder_.logic(ir::Op::kAnd, builder_.not_(*up), *below));
    builder_.jump_if(past, loop.exit);
  }
  builder_.store(control, *next);
  builder_.jump_if_not(wrapped, test);
  builder_.bind(loop.exit);
  return fine;
}

}  // namespace plc::st
