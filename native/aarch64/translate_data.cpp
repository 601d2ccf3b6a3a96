// Moves, arithmetic, comparisons, parts of integers, elements of arrays.
#include <cstring>
#include <utility>

#include "native/translate.h"
#include "runtime/interpreter/operations.h"
#include "stdlib/library.h"

namespace plc::native {
namespace {

using stdlib::Event;

constexpr int number(Event event) { return static_cast<int>(event); }

/// A vector register that holds no value: the first (0) or second (1).
std::uint32_t free_real(const Assembly& s, std::uint32_t n) { return s.free(n); }

// ---- arithmetic

void integer(Assembly& s, const Instruction& i) {
  const unsigned bytes = bytes_of(i.operation.type);
  const std::uint32_t to = s.free(0);
  const a64::Gp x = gp(s.value(s.free(1), i.words[2], bytes), bytes);
  const a64::Gp y = gp(s.value(s.free(2), i.words[3], bytes), bytes);
  const a64::Gp result = gp(to, bytes);
  switch (i.operation.form) {
    case Form::kAdd:
      s.a.add(result, x, y);
      break;
    case Form::kSub:
      s.a.sub(result, x, y);
      break;
    case Form::kMul:
      s.a.mul(result, x, y);
      break;
    case Form::kAnd:
      s.a.and_(result, x, y);
      break;
    case Form::kOr:
      s.a.orr(result, x, y);
      break;
    default:
      s.a.eor(result, x, y);
      break;
  }
  s.store(i.words[1], bytes, to);
}

void real(Assembly& s, const Instruction& i) {
  const Type type = i.operation.type;
  const std::uint32_t to = free_real(s, 0);
  const a64::Vec x = vec(s.real_value(free_real(s, 1), i.words[2], type), type);
  const a64::Vec y = vec(s.real_value(free_real(s, 2), i.words[3], type), type);
  const a64::Vec result = vec(to, type);
  switch (i.operation.form) {
    case Form::kAdd:
      s.a.fadd(result, x, y);
      break;
    case Form::kSub:
      s.a.fsub(result, x, y);
      break;
    case Form::kMul:
      s.a.fmul(result, x, y);
      break;
    default:
      s.a.fdiv(result, x, y);
      break;
  }
  // One NaN: the processor hands on what the operands were.
  const asmjit::Label nan = s.label();
  const asmjit::Label done = s.label();
  s.a.fcmp(result, result);
  s.a.b(Condition::kVS, nan);
  s.bind(done);
  s.cold_path([&s, nan, done, result, type] {
    s.land(nan);
    const a64::Gp bits = gp(0, bytes_of(type));
    s.constant(bits, type == Type::kF32 ? 0x7fc00000u : 0x7ff8000000000000u);
    s.a.fmov(result, bits);
    s.jump(done);
  });
  s.store_real(i.words[1], type, to);
}

/// The processor divides by zero to zero, and the least value by -1 to itself, as the language does.
void division(Assembly& s, const Instruction& i) {
  const Type type = i.operation.type;
  const unsigned bytes = bytes_of(type);
  const std::uint32_t to = s.free(0);
  const a64::Gp x = gp(s.extended_value(s.free(1), i.words[2], type), bytes);
  const a64::Gp y = gp(s.extended_value(s.free(2), i.words[3], type), bytes);
  const a64::Gp result = gp(to, bytes);
  if (is_signed(type)) {
    s.a.sdiv(result, x, y);
  } else {
    s.a.udiv(result, x, y);
  }
  if (i.operation.form == Form::kMod) {
    s.a.msub(result, result, y, x);
    s.a.cmp(y, 0);
    s.a.csel(result, result, gp(Assembly::kZero, bytes), Condition::kNE);
    return s.store(i.words[1], bytes, to);
  }
  const asmjit::Label by_zero = s.label();
  const asmjit::Label done = s.label();
  s.a.cbz(y, by_zero);
  s.bind(done);
  s.cold_path([&s, by_zero, done, result, position = i.position] {
    s.land(by_zero);
    s.raise(position, number(Event::kDivideByZero));
    s.constant(result, 0);
    s.jump(done);
  });
  s.store(i.words[1], bytes, to);
}

// ---- comparison

Condition condition(Relation relation, bool with_sign) {
  switch (relation) {
    case Relation::kEq:
      return Condition::kEQ;
    case Relation::kNe:
      return Condition::kNE;
    case Relation::kLt:
      return with_sign ? Condition::kLT : Condition::kLO;
    case Relation::kLe:
      return with_sign ? Condition::kLE : Condition::kLS;
    case Relation::kGt:
      return with_sign ? Condition::kGT : Condition::kHI;
    case Relation::kGe:
      break;
  }
  return with_sign ? Condition::kGE : Condition::kHS;
}
/// Those that are false for NaN, but for "not equal".
Condition real_condition(Relation relation) {
  switch (relation) {
    case Relation::kLt:
      return Condition::kMI;
    case Relation::kLe:
      return Condition::kLS;
    default:
      return condition(relation, true);
  }
}

/// Compares; the result is stored and is also what the returned condition says of the flags.
Condition compare(Assembly& s, const Instruction& i) {
  const Type type = i.operation.type;
  Condition code = Condition::kEQ;
  if (is_real(type)) {
    const a64::Vec x = vec(s.real_value(free_real(s, 0), i.words[2], type), type);
    const a64::Vec y = vec(s.real_value(free_real(s, 1), i.words[3], type), type);
    s.a.fcmp(x, y);
    code = real_condition(i.operation.relation);
  } else {
    const unsigned bytes = bytes_of(type);
    const a64::Gp x = gp(s.extended_value(s.free(0), i.words[2], type), bytes);
    const a64::Gp y = gp(s.extended_value(s.free(1), i.words[3], type), bytes);
    s.a.cmp(x, y);
    code = condition(i.operation.relation, is_signed(type));
  }
  s.a.cset(a64::w0, code);
  s.store(i.words[1], 1, 0);
  return code;
}

// ---- the rest

void move(Assembly& s, const Instruction& i) {
  const unsigned bytes = bytes_of(i.operation.type);
  // A real in its register may be moved as an integer, which is what most moves are.
  for (const Type real_type : {Type::kF32, Type::kF64}) {
    if (bytes_of(real_type) == bytes && s.holds_real(i.words[2], real_type)) {
      return s.store_real(i.words[1], real_type, s.holder());
    }
  }
  s.store(i.words[1], bytes, s.value(s.free(0), i.words[2], bytes));
}

void extract(Assembly& s, const Instruction& i) {
  const std::uint32_t to = s.free(0);
  const std::uint32_t byte = s.value(to, i.words[2], 1);
  s.a.ubfx(a64::w(to), a64::w(byte), i.words[3], 1);
  s.store(i.words[1], 1, to);
}

void insert(Assembly& s, const Instruction& i) {
  const std::uint32_t to = s.free(0);
  const std::uint32_t part = s.value(s.free(1), i.words[2], 1);
  s.load(to, i.words[1], 1);
  s.a.bfi(a64::w(to), a64::w(part), i.words[3], 1);
  s.store(i.words[1], 1, to);
}

void range(Assembly& s, const Instruction& i) {
  const Type type = i.operation.type;
  const unsigned bytes = bytes_of(type);
  const std::uint32_t to = 0;
  s.load_extended(to, i.words[2], type);
  s.forget();  // what was held may be a limit
  const asmjit::Label done = s.label();
  for (const bool lower : {true, false}) {
    const std::uint32_t limit = i.words[lower ? 3 : 4];
    const asmjit::Label outside = s.label();
    s.load_extended(1, limit, type);
    s.a.cmp(gp(to, bytes), gp(1, bytes));
    s.a.b(condition(lower ? Relation::kLt : Relation::kGt, is_signed(type)), outside);
    s.cold_path([&s, outside, done, position = i.position, limit, type] {
      s.land(outside);
      s.raise(position, number(Event::kOutOfRange));
      s.load_extended(to, limit, type);
      s.jump(done);
    });
  }
  s.bind(done);
  s.store(i.words[1], bytes, to);
}

/// The number of the element in x0, below the count; else to `outside`. `index`: six words
/// (runtime/interpreter/operations.h). Uses x1 as well.
void element_number(Assembly& s, const std::uint32_t* index, const asmjit::Label& outside) {
  const auto rep = static_cast<core::Rep>(index[5]);
  const a64::Gp element = a64::x0;
  switch (rep) {
    case core::Rep::kI8:
      s.a.ldrsb(element, s.at(index[0], 1));
      break;
    case core::Rep::kI16:
      s.a.ldrsh(element, s.at(index[0], 2));
      break;
    case core::Rep::kI32:
      if (s.holds(index[0], 4)) {
        s.a.sxtw(element, a64::w(s.holder()));
      } else {
        s.a.ldrsw(element, s.at(index[0], 4));
      }
      break;
    case core::Rep::kU8:
    case core::Rep::kU16:
    case core::Rep::kU32: {
      const unsigned bytes = core::rep_bytes(rep);
      s.load_from(s.at(index[0], bytes), bytes, 0);
      break;
    }
    default:
      s.load_from(s.at(index[0], 8), 8, 0);
      break;
  }
  if (rep == core::Rep::kU64) {
    s.a.cmp(element, 0);
    s.a.b(Condition::kMI, outside);
  }
  constexpr std::uint64_t kShort = 4096;
  if (const auto lower = runtime::load<std::uint64_t>(index + 3); lower != 0 && lower < kShort) {
    s.a.sub(element, element, lower);
  } else if (lower != 0 && std::uint64_t{0} - lower < kShort) {
    s.a.add(element, element, std::uint64_t{0} - lower);
  } else if (lower != 0) {
    s.constant(a64::x1, lower);
    s.a.sub(element, element, a64::x1);
  }
  if (index[1] < kShort) {
    s.a.cmp(element, index[1]);
  } else {
    s.constant(a64::x1, index[1]);
    s.a.cmp(element, a64::x1);
  }
  s.a.b(Condition::kHS, outside);
}

/// The element whose number is in x0. Uses x0 and x1.
a64::Mem element_place(Assembly& s, std::uint32_t place, std::uint32_t stride) {
  s.address(a64::x1, place);
  const bool is_power = stride == 1 || stride == 2 || stride == 4 || stride == 8;
  if (is_power) {
    const std::uint32_t shift = stride == 8 ? 3 : stride / 2;
    s.a.add(a64::x1, a64::x1, a64::x0, asmjit::arm::lsl(shift));
  } else {
    s.constant(a64::x(17), stride);
    s.a.madd(a64::x1, a64::x0, a64::x(17), a64::x1);
  }
  return a64::ptr(a64::x1);
}

/// Words: the value, place, index (6) or path. Uses x0, x1 and x17.
a64::Mem part_place(Assembly& s, const Instruction& i, const asmjit::Label& outside) {
  if (i.operation.form == Form::kLoadElement || i.operation.form == Form::kStoreElement) {
    element_number(s, i.words + 3, outside);
    return element_place(s, i.words[2], i.words[5]);
  }
  const a64::Gp distance = a64::x(17);
  s.constant(distance, 0);
  const std::uint32_t* index = i.words + 5;
  for (std::uint32_t n = 0; n < i.words[4]; ++n, index += runtime::kIndexWords) {
    element_number(s, index, outside);
    s.forget();
    s.constant(a64::x1, index[2]);
    s.a.madd(distance, a64::x0, a64::x1, distance);
  }
  s.address(a64::x1, i.words[2] + i.words[3]);
  s.a.add(a64::x1, a64::x1, distance);
  return a64::ptr(a64::x1);
}

void load_element(Assembly& s, const Instruction& i) {
  const unsigned bytes = bytes_of(i.operation.type);
  const asmjit::Label outside = s.label();
  const asmjit::Label done = s.label();
  s.load_from(part_place(s, i, outside), bytes, 2);
  s.bind(done);
  s.cold_path([&s, outside, done, position = i.position] {
    s.land(outside);
    s.raise(position, number(Event::kBadIndex));
    s.constant(a64::w2, 0);
    s.jump(done);
  });
  s.store(i.words[1], bytes, 2);
}

/// Words: in, place, index (6).
void store_element(Assembly& s, const Instruction& i) {
  const unsigned bytes = bytes_of(i.operation.type);
  const asmjit::Label outside = s.label();
  const asmjit::Label done = s.label();
  const Type real_type = bytes == 4 ? Type::kF32 : Type::kF64;
  const bool real_held = bytes >= 4 && s.holds_real(i.words[1], real_type);
  const std::uint32_t holder = s.holder();
  if (!real_held) s.load(2, i.words[1], bytes);
  const a64::Mem element = part_place(s, i, outside);
  if (real_held) {
    s.a.str(vec(holder, real_type), element);
  } else {
    s.store_to(element, bytes, 2);
  }
  s.land(done);  // any variable may be an element
  s.cold_path([&s, outside, done, position = i.position] {
    s.land(outside);
    s.raise(position, number(Event::kBadIndex));
    s.jump(done);
  });
}

}  // namespace

void translate_data(Assembly& s, const Instruction& i) {
  switch (i.operation.form) {
    case Form::kMove:
      return move(s, i);
    case Form::kCopy:
      s.pass(2, i.words[3]);
      s.pass_address(1, i.words[2]);
      s.pass_address(0, i.words[1]);
      return s.call_address(reinterpret_cast<std::uint64_t>(&std::memmove));
    case Form::kAdd:
    case Form::kSub:
    case Form::kMul:
    case Form::kAnd:
    case Form::kOr:
    case Form::kXor:
      return is_real(i.operation.type) ? real(s, i) : integer(s, i);
    case Form::kDiv:
    case Form::kMod:
      return is_real(i.operation.type) ? real(s, i) : division(s, i);
    case Form::kCompare:
      compare(s, i);
      return;
    case Form::kExtract:
      return extract(s, i);
    case Form::kInsert:
      return insert(s, i);
    case Form::kRange:
      return range(s, i);
    case Form::kLoadElement:
    case Form::kLoadPath:
      return load_element(s, i);
    case Form::kStoreElement:
    case Form::kStorePath:
      return store_element(s, i);
    default:
      return s.refuse("an instruction has a form, but no code");
  }
}

void translate_compare(Assembly& s, const Instruction& i) { compare(s, i); }

void translate_compare_jump(Assembly& s, const Instruction& i, const asmjit::Label& target) {
  const Condition code = compare(s, i);
  s.jump_on(i.operation.form == Form::kCompareJumpIf ? code : asmjit::arm::negateCond(code), target);
}

}  // namespace plc::native
