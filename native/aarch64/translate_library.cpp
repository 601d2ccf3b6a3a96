// Functions of the library that cost less than a call: selection, conversions of numbers, absolute values, square root,
// NOT, shifts (stdlib/functions/). Each does what the kernel of its row does; what it leaves out, events above all, it
// leaves to the kernel.
#include "native/function_translator.h"
#include "native/translate.h"
#include "runtime/interpreter/operations.h"

namespace plc::native {
namespace {

using core::TypeId;

class Translator final : public FunctionTranslator {
 public:
  Translator(Assembly& s, const Instruction& i, const FunctionRow& row, const std::function<void()>& call)
      : FunctionTranslator(i, row, call), s_(s) {}

 private:
  /// An argument of the type, integers extended, in the register of that number for its kind; nothing else is held.
  void load(std::uint32_t to, std::uint32_t operand) {
    if (is_real(type_)) {
      s_.load_real(to, operand, type_);
    } else {
      s_.load_extended(to, operand, type_);
    }
    s_.forget();
  }
  void store() { store(type_); }
  void store(Type type) {
    if (is_real(type)) {
      s_.store_real(result(), type, 0);
    } else {
      s_.store(result(), bytes_of(type), 0);
    }
  }
  /// Before the store of the result: the code at `rare` has the kernel compute it instead.
  void leave_to_kernel(const asmjit::Label& rare, Type type) {
    const asmjit::Label done = s_.label();
    s_.bind(done);
    s_.cold_path([&s = s_, call = call_, rare, done, type, place = result()] {
      s.land(rare);
      call();
      if (is_real(type)) {
        s.load_real(0, place, type);
      } else {
        s.load(0, place, bytes_of(type));
      }
      s.jump(done);
    });
    store(type);
  }

  // ---- selection

  void select() override {
    const std::uint32_t g = s_.value(2, argument(0), 1);
    s_.a.cmp(a64::w(g), 0);
    // The flags stay: loads have none. What is held first, before the other is loaded.
    const bool held = s_.holds(argument(2), bytes_) || s_.holds_real(argument(2), type_);
    if (held) {
      load(1, argument(2));
      load(0, argument(1));
    } else {
      load(0, argument(1));
      load(1, argument(2));
    }
    choose(Condition::kNE);
    store();
  }
  /// Register 1 replaces register 0.
  void choose(Condition condition) {
    if (is_real(type_)) {
      s_.a.fcsel(vec(0, type_), vec(1, type_), vec(0, type_), condition);
    } else {
      s_.a.csel(gp(0, bytes_), gp(1, bytes_), gp(0, bytes_), condition);
    }
  }
  /// The least or greatest of the value in register 0 and an operand, there. Of two that are equal, or no numbers, the
  /// first stays.
  void fold(std::uint32_t operand, bool least) {
    load(1, operand);
    if (is_real(type_)) {
      s_.a.fcmp(vec(1, type_), vec(0, type_));
      return choose(least ? Condition::kMI : Condition::kGT);
    }
    s_.a.cmp(gp(1, bytes_), gp(0, bytes_));
    const bool with_sign = is_signed(type_);
    if (least) return choose(with_sign ? Condition::kLT : Condition::kLO);
    choose(with_sign ? Condition::kGT : Condition::kHI);
  }
  void extreme(bool least) override {
    load(0, argument(0));
    for (std::uint32_t n = 1; n < count(); ++n) fold(argument(n), least);
    store();
  }
  void limit() override {
    load(0, argument(1));
    fold(argument(0), false);
    fold(argument(2), true);
    store();
  }

  // ---- numbers

  void absolute() override {
    load(0, argument(0));
    const a64::Gp value = gp(0, bytes_);
    s_.a.cmp(value, 0);
    s_.a.csneg(value, value, value, Condition::kGE);
    store();
  }
  void square_root() override {
    const asmjit::Label rare = s_.label();
    load(0, argument(0));
    s_.a.fsqrt(vec(0, type_), vec(0, type_));
    s_.a.fcmp(vec(0, type_), vec(0, type_));
    s_.a.b(Condition::kVS, rare);
    leave_to_kernel(rare, type_);
  }
  void invert() override {
    load(0, argument(0));
    const a64::Gp value = gp(0, bytes_);
    if (overload_.t == TypeId::kBool) {
      s_.a.eor(value, value, 1);
    } else {
      s_.a.mvn(value, value);
    }
    store();
  }
  /// Jumps to `rare` for counts that are negative or, if there is one, not below the bound; the count in register 1.
  void load_count(std::uint32_t bound, const asmjit::Label& rare) {
    const Type by = *machine_type(overload_.u);
    s_.load_extended(1, argument(1), by);
    const a64::Gp count = gp(1, bytes_of(by));
    s_.a.cmp(count, bound);
    s_.a.b(bound != 0 ? Condition::kHS : Condition::kMI, rare);  // a negative one is very great
  }
  void shift(bool left) override {
    const asmjit::Label rare = s_.label();
    load(0, argument(0));
    load_count(bytes_ * 8, rare);
    const a64::Gp value = gp(0, bytes_);
    if (left) {
      s_.a.lsl(value, value, gp(1, bytes_));
    } else {
      s_.a.lsr(value, value, gp(1, bytes_));
    }
    leave_to_kernel(rare, type_);
  }
  void rotate(bool left) override {
    const asmjit::Label rare = s_.label();
    load(0, argument(0));
    load_count(0, rare);
    const a64::Gp value = gp(0, bytes_);
    const a64::Gp count = gp(1, bytes_);
    // Of what repeats itself within the register any width rotates like the register.
    if (bytes_ == 1) s_.a.orr(value, value, value, asmjit::arm::lsl(8));
    if (bytes_ <= 2) s_.a.orr(value, value, value, asmjit::arm::lsl(16));
    if (left) s_.a.neg(count, count);
    s_.a.ror(value, value, count);
    leave_to_kernel(rare, type_);
  }

  // ---- conversions

  bool convert() override {
    const Type to = *machine_type(overload_.u);
    if (is_real(type_) && overload_.u == TypeId::kBool) return false;
    load(0, argument(0));
    if (is_real(type_) && is_real(to)) {
      real_to_real(to);
    } else if (is_real(type_)) {
      real_to_integer(to);
    } else if (is_real(to)) {
      integer_to_real(to);
    } else {
      integer_to_integer(to);
    }
    return true;
  }
  void integer_to_integer(Type to) {
    if (overload_.u == TypeId::kBool) {
      s_.a.cmp(gp(0, bytes_), 0);
      s_.a.cset(a64::w0, Condition::kNE);
    } else if (bytes_of(to) == 8 && bytes_ < 8) {
      if (is_signed(type_)) {
        s_.a.sxtw(a64::x0, a64::w0);
      } else {
        s_.a.mov(a64::w0, a64::w0);  // the upper half is zero after this alone
      }
    }
    store(to);
  }
  void integer_to_real(Type to) {
    if (is_signed(type_)) {
      s_.a.scvtf(vec(0, to), gp(0, bytes_));
    } else {
      s_.a.ucvtf(vec(0, to), gp(0, bytes_));
    }
    store(to);
  }
  /// Rounded half to even by the processor; what does not fit, and NaN, is for the kernel.
  void real_to_integer(Type to) {
    const asmjit::Label rare = s_.label();
    const a64::Vec from = vec(0, type_);
    s_.a.fcmp(from, from);
    s_.a.b(Condition::kVS, rare);
    if (to == Type::kU64) {
      s_.a.fcvtnu(a64::x0, from);
    } else {
      s_.a.fcvtns(a64::x0, from);
    }
    switch (to) {
      case Type::kI8:
        s_.a.sxtb(a64::x1, a64::w0);
        break;
      case Type::kU8:
        s_.a.uxtb(a64::w1, a64::w0);
        break;
      case Type::kI16:
        s_.a.sxth(a64::x1, a64::w0);
        break;
      case Type::kU16:
        s_.a.uxth(a64::w1, a64::w0);
        break;
      case Type::kI32:
        s_.a.sxtw(a64::x1, a64::w0);
        break;
      case Type::kU32:
        s_.a.mov(a64::w1, a64::w0);
        break;
      default:
        // What does not fit has become the nearest that does, or what is not negative 0.
        s_.constant(a64::x1, to == Type::kU64 ? ~std::uint64_t{0} : ~std::uint64_t{0} >> 1);
        s_.a.cmp(a64::x0, a64::x1);
        s_.a.b(Condition::kEQ, rare);
        s_.constant(a64::x1, to == Type::kU64 ? 0 : std::uint64_t{1} << 63);
        s_.a.cmp(a64::x0, a64::x1);
        s_.a.b(Condition::kEQ, rare);
        return leave_to_kernel(rare, to);
    }
    s_.a.cmp(a64::x0, a64::x1);
    s_.a.b(Condition::kNE, rare);
    leave_to_kernel(rare, to);
  }
  void real_to_real(Type to) {
    if (type_ == to) return store();
    const asmjit::Label rare = s_.label();
    s_.a.fcvt(vec(0, to), vec(0, type_));
    s_.a.fcmp(vec(0, to), vec(0, to));
    s_.a.b(Condition::kVS, rare);
    leave_to_kernel(rare, to);
  }

  Assembly& s_;
};

}  // namespace

bool translate_library(Assembly& s, const Instruction& i, const std::function<void()>& call) {
  const auto row = function_of(runtime::load_pointer<stdlib::Kernel>(i.words + 1));
  return row && Translator(s, i, *row, call).translate(row->function);
}

}  // namespace plc::native
