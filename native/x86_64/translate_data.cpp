// Moves, arithmetic, comparisons, parts of integers, elements of arrays.
#include <cstring>
#include <limits>
#include <utility>

#include "native/translate.h"
#include "native/x86_64/parts.h"
#include "runtime/interpreter/operations.h"
#include "stdlib/library.h"

namespace plc::native {
namespace {

using stdlib::Event;
using InstId = asmjit::InstId;

constexpr int number(Event event) { return static_cast<int>(event); }

/// A register for a new value: not the one that holds the value stored last.
std::uint32_t fresh(const Assembly& s) { return s.holder() == reg::kAx ? reg::kCx : reg::kAx; }
std::uint32_t fresh_real(const Assembly& s) { return s.holder() == 0 ? 1 : 0; }

// ---- arithmetic

struct Integers {
  InstId id;
  bool commutes;
};
Integers integers_of(Form form) {
  switch (form) {
    case Form::kAdd:
      return {x86::Inst::kIdAdd, true};
    case Form::kSub:
      return {x86::Inst::kIdSub, false};
    case Form::kMul:
      return {x86::Inst::kIdImul, true};
    case Form::kAnd:
      return {x86::Inst::kIdAnd, true};
    case Form::kOr:
      return {x86::Inst::kIdOr, true};
    default:
      return {x86::Inst::kIdXor, true};
  }
}

void integer(Assembly& s, const Instruction& i) {
  const unsigned bytes = bytes_of(i.operation.type);
  const Integers what = integers_of(i.operation.form);
  std::uint32_t x = i.words[2];
  std::uint32_t y = i.words[3];
  const std::uint32_t out = i.words[1];
  if (what.commutes && (s.holds(y, bytes) || y == out)) std::swap(x, y);
  if (const auto sum = s.kept(out); sum && i.operation.form == Form::kAdd && bytes >= 4 && x != out && y != out) {
    const auto first = s.in_register(x, bytes);
    const asmjit::Operand second = s.value(y, bytes);
    if (first && !second.isMem()) {
      const x86::Gp base = gp(*first, 8);
      const x86::Mem place = second.isImm() ? x86::ptr(base, second.as<asmjit::Imm>().valueAs<std::int32_t>())
                                            : x86::ptr(base, gp(second.id(), 8));
      s.a.lea(gp(*sum, bytes), place);
      return s.forget();
    }
  }
  const bool narrow_product = i.operation.form == Form::kMul && bytes == 1;
  std::uint32_t to = s.holds(x, bytes) ? s.holder() : fresh(s);
  // In place, unless the second operand is there.
  if (const auto kept = s.kept(out); kept && (x == out || y != out) && !narrow_product) to = *kept;
  if (narrow_product) {
    // There is no product of two bytes in one byte.
    const std::uint32_t other = to == reg::kDx ? reg::kCx : reg::kDx;
    s.load(other, y, 1);
    s.load(to, x, 1);
    s.a.imul(gp(to, 4), gp(other, 4));
  } else {
    const asmjit::Operand second = s.value(y, bytes);
    s.load(to, x, bytes);
    s.a.emit(what.id, gp(to, bytes), second);
  }
  s.store(out, bytes, to);
}

struct Reals {
  InstId in_place;
  InstId of_two;  ///< the same with a register of its own for the result (AVX)
};
Reals reals_of(Form form, bool f32) {
  namespace Inst = x86::Inst;
  switch (form) {
    case Form::kAdd:
      return f32 ? Reals{Inst::kIdAddss, Inst::kIdVaddss} : Reals{Inst::kIdAddsd, Inst::kIdVaddsd};
    case Form::kSub:
      return f32 ? Reals{Inst::kIdSubss, Inst::kIdVsubss} : Reals{Inst::kIdSubsd, Inst::kIdVsubsd};
    case Form::kMul:
      return f32 ? Reals{Inst::kIdMulss, Inst::kIdVmulss} : Reals{Inst::kIdMulsd, Inst::kIdVmulsd};
    default:
      return f32 ? Reals{Inst::kIdDivss, Inst::kIdVdivss} : Reals{Inst::kIdDivsd, Inst::kIdVdivsd};
  }
}

void compare_reals(Assembly& s, const x86::Xmm& x, const asmjit::Operand& y, bool f32) {
  s.a.emit(f32 ? x86::Inst::kIdUcomiss : x86::Inst::kIdUcomisd, x, y);
}

void real(Assembly& s, const Instruction& i) {
  const Type type = i.operation.type;
  const bool f32 = type == Type::kF32;
  const std::uint32_t x = i.words[2];
  const std::uint32_t y = i.words[3];
  const std::uint32_t out = i.words[1];
  // Operands are not swapped: of two NaN the first would win, though all are canonical. The register of x is reused
  // unless y lies there.
  std::uint32_t to = s.holds_real(x, type) ? s.holder() : fresh_real(s);
  if (const auto kept = s.kept(out, true); kept && (x == out || y != out)) to = *kept;
  const asmjit::Operand second = s.real_value(y, type);
  const Reals what = reals_of(i.operation.form, f32);
  if (const auto first = s.in_register(x, type); first && *first != to && s.has_avx()) {
    s.a.emit(what.of_two, x86::xmm(to), x86::xmm(*first), second);
  } else {
    s.load_real(to, x, type);
    s.a.emit(what.in_place, x86::xmm(to), second);
  }
  if (!i.known.any_nan) s.one_nan(to, f32);
  s.store_real(out, type, to);
}

/// Quotient in eax, remainder in edx.
void division(Assembly& s, const Instruction& i) {
  const Type type = i.operation.type;
  const unsigned bytes = bytes_of(type);
  const unsigned wide = bytes == 8 ? 8 : 4;
  const bool quotient = i.operation.form == Form::kDiv;
  const x86::Gp dividend = gp(reg::kAx, wide);
  const x86::Gp divisor = gp(reg::kCx, wide);
  const x86::Gp rest = gp(reg::kDx, wide);
  const std::uint32_t result = quotient ? reg::kAx : reg::kDx;
  // Whichever is in a register first: loading the other may overwrite it.
  if (s.holds(i.words[3], bytes)) {
    s.load_extended(reg::kCx, i.words[3], type);
    s.load_extended(reg::kAx, i.words[2], type);
  } else {
    s.load_extended(reg::kAx, i.words[2], type);
    s.load_extended(reg::kCx, i.words[3], type);
  }
  const asmjit::Label by_zero = s.a.newLabel();
  const asmjit::Label done = s.a.newLabel();
  s.a.test(divisor, divisor);
  s.a.jz(by_zero);
  if (is_signed(type)) {
    // The least value by -1 stops the processor, where it does not fit; less than 4 bytes always fit.
    if (bytes >= 4) {
      const asmjit::Label by_minus_one = s.a.newLabel();
      s.a.cmp(divisor, -1);
      s.a.je(by_minus_one);
      s.cold_path([&s, by_minus_one, done, quotient, dividend, rest] {
        s.a.bind(by_minus_one);
        if (quotient) {
          s.a.neg(dividend);
        } else {
          s.a.xor_(rest.r32(), rest.r32());
        }
        s.a.jmp(done);
      });
    }
    if (wide == 8) {
      s.a.cqo();
    } else {
      s.a.cdq();
    }
    s.a.idiv(rest, dividend, divisor);
  } else {
    s.a.xor_(x86::edx, x86::edx);
    s.a.div(rest, dividend, divisor);
  }
  s.a.bind(done);
  s.cold_path([&s, by_zero, done, quotient, position = i.position, result] {
    s.a.bind(by_zero);
    if (quotient) s.raise(position, number(Event::kDivideByZero));
    s.a.xor_(gp(result, 4), gp(result, 4));
    s.a.jmp(done);
  });
  s.store(i.words[1], bytes, result);
}

// ---- comparison

x86::CondCode condition(Relation relation, bool with_sign) {
  switch (relation) {
    case Relation::kEq:
      return x86::CondCode::kE;
    case Relation::kNe:
      return x86::CondCode::kNE;
    case Relation::kLt:
      return with_sign ? x86::CondCode::kL : x86::CondCode::kB;
    case Relation::kLe:
      return with_sign ? x86::CondCode::kLE : x86::CondCode::kBE;
    case Relation::kGt:
      return with_sign ? x86::CondCode::kG : x86::CondCode::kA;
    case Relation::kGe:
      break;
  }
  return with_sign ? x86::CondCode::kGE : x86::CondCode::kAE;
}

/// Compares; the result is stored and is also what the returned condition says of the flags.
x86::CondCode compare_integers(Assembly& s, const Instruction& i) {
  const Type type = i.operation.type;
  const unsigned bytes = bytes_of(type);
  const std::uint32_t x = i.words[2];
  const std::uint32_t y = i.words[3];
  const x86::CondCode code = condition(i.operation.relation, is_signed(type));
  const auto right = s.in_register(y, bytes);
  if (right && !s.in_register(x, bytes)) {
    s.a.cmp(s.at(x, bytes), gp(*right, bytes));
  } else {
    const asmjit::Operand second = s.value(y, bytes);
    if (!s.in_register(x, bytes)) s.load(reg::kAx, x, bytes);
    s.a.emit(x86::Inst::kIdCmp, gp(s.in_register(x, bytes).value_or(reg::kAx), bytes), second);
  }
  if (i.known.unread) return code;
  const std::uint32_t to = s.kept(i.words[1]).value_or(reg::kAx);
  s.a.set(code, gp(to, 1));
  s.store(i.words[1], 1, to);
  return code;
}

x86::CondCode compare_reals(Assembly& s, const Instruction& i) {
  const Type type = i.operation.type;
  const bool f32 = type == Type::kF32;
  const Relation relation = i.operation.relation;
  // "Above" is the order that is false for NaN: less is above the other way iteration.
  const bool turned = relation == Relation::kLt || relation == Relation::kLe;
  const std::uint32_t x = i.words[turned ? 3 : 2];
  const std::uint32_t y = i.words[turned ? 2 : 3];
  const asmjit::Operand right = s.real_value(y, type);
  const std::uint32_t left = s.in_register(x, type).value_or(fresh_real(s));
  s.load_real(left, x, type);
  compare_reals(s, x86::xmm(left), right, f32);
  s.forget();  // ax and cx get flags, stored or not
  x86::CondCode code = x86::CondCode::kNZ;
  switch (relation) {
    case Relation::kEq:
      s.a.setnp(x86::cl);
      s.a.sete(x86::al);
      s.a.and_(x86::al, x86::cl);
      break;
    case Relation::kNe:
      s.a.setp(x86::cl);
      s.a.setne(x86::al);
      s.a.or_(x86::al, x86::cl);
      break;
    case Relation::kLt:
    case Relation::kGt:
      code = x86::CondCode::kA;
      break;
    case Relation::kLe:
    case Relation::kGe:
      code = x86::CondCode::kAE;
      break;
  }
  if (i.known.unread) return code;
  if (code != x86::CondCode::kNZ) s.a.set(code, x86::al);
  s.store(i.words[1], 1, reg::kAx);
  return code;
}

x86::CondCode compare(Assembly& s, const Instruction& i) {
  return is_real(i.operation.type) ? compare_reals(s, i) : compare_integers(s, i);
}

// ---- the rest

void move(Assembly& s, const Instruction& i) {
  const Type type = i.operation.type;
  const unsigned bytes = bytes_of(type);
  if (i.is_port(i.words[1])) {
    if (const auto known = s.constant(i.words[2], bytes)) return s.store_port(i.words[1], bytes, *known);
  }
  // A real in its register may be moved as an integer, which is what most moves are.
  for (const Type real_type : {Type::kF32, Type::kF64}) {
    if (bytes_of(real_type) != bytes) continue;
    const auto from = s.in_register(i.words[2], real_type);
    if (!from && !s.kept(i.words[1], true)) continue;
    const std::uint32_t value = from.value_or(s.kept(i.words[1], true).value_or(0));
    s.load_real(value, i.words[2], real_type);
    return s.store_real(i.words[1], real_type, value);
  }
  const std::uint32_t value = s.in_register(i.words[2], bytes).value_or(s.kept(i.words[1]).value_or(reg::kAx));
  s.load(value, i.words[2], bytes);
  s.store(i.words[1], bytes, value);
}

void extract(Assembly& s, const Instruction& i) {
  s.load(reg::kAx, i.words[2], 1);
  if (i.words[3] != 0) s.a.shr(x86::al, i.words[3]);
  s.a.and_(x86::al, 1);
  s.store(i.words[1], 1, reg::kAx);
}

void insert(Assembly& s, const Instruction& i) {
  // The part into cl first: the byte may be what is held.
  const std::uint32_t bit = i.words[3];
  if (s.holds(i.words[2], 1)) {
    s.load(reg::kCx, i.words[2], 1);
    s.load(reg::kAx, i.words[1], 1);
  } else {
    s.load(reg::kAx, i.words[1], 1);
    s.load(reg::kCx, i.words[2], 1);
  }
  if (bit != 0) s.a.shl(x86::cl, bit);
  s.a.and_(x86::al, static_cast<std::int32_t>(static_cast<std::int8_t>(~(1u << bit))));
  s.a.or_(x86::al, x86::cl);
  s.store(i.words[1], 1, reg::kAx);
}

void range(Assembly& s, const Instruction& i) {
  const Type type = i.operation.type;
  const unsigned bytes = bytes_of(type);
  const x86::Gp value = gp(reg::kAx, bytes);
  s.load(reg::kAx, i.words[2], bytes);
  const asmjit::Label done = s.a.newLabel();
  // Past this point no value is held in ax but the one looked at.
  for (const bool lower : {true, false}) {
    const std::uint32_t limit = i.words[lower ? 3 : 4];
    const asmjit::Label outside = s.a.newLabel();
    const asmjit::Operand bound = s.value(limit, bytes);
    s.a.emit(x86::Inst::kIdCmp, value, bound);
    s.a.j(condition(lower ? Relation::kLt : Relation::kGt, is_signed(type)), outside);
    s.cold_path([&s, outside, done, position = i.position, limit, bytes] {
      s.a.bind(outside);
      s.raise(position, number(Event::kOutOfRange));
      s.load(reg::kAx, limit, bytes);
      s.a.jmp(done);
    });
  }
  s.a.bind(done);
  s.store(i.words[1], bytes, reg::kAx);
}

void translate(Assembly& s, const Instruction& i) {
  switch (i.operation.form) {
    case Form::kMove:
      return move(s, i);
    case Form::kCopy:
      s.address(x86::rdi, i.words[1]);
      s.address(x86::rsi, i.words[2]);
      s.a.mov(x86::edx, i.words[3]);
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
      return load_part(s, i);
    case Form::kStoreElement:
    case Form::kStorePath:
      return store_part(s, i);
    default:
      return s.refuse("an instruction has a form, but no code");
  }
}

}  // namespace

void translate_data(Assembly& s, const Instruction& i) {
  translate(s, i);
  s.end(i);
}

void translate_compare(Assembly& s, const Instruction& i) { compare(s, i); }

void translate_compare_jump(Assembly& s, const Instruction& i, const asmjit::Label& target) {
  const x86::CondCode code = compare(s, i);
  s.a.j(i.operation.form == Form::kCompareJumpIf ? code : x86::negateCond(code), target);
}

}  // namespace plc::native
