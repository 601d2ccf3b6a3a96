// Functions of the library that cost less than a call: selection, conversions of numbers, absolute values, square root,
// NOT, shifts (stdlib/functions/). Each does what the kernel of its row does; what it leaves out, events above all, it
// leaves to the kernel.
#include "native/function_translator.h"
#include "native/if_conversion.h"
#include "native/translate.h"
#include "runtime/interpreter/operations.h"
#include "stdlib/library.h"

namespace plc::native {
namespace {

using core::TypeId;

class Translator final : public FunctionTranslator {
 public:
  Translator(Assembly& s, const Instruction& i, const FunctionRow& row, const std::function<void()>& call)
      : FunctionTranslator(i, row, call), s_(s) {}

 private:
  /// After the store of the result from register `to`: the code at `rare` has the kernel compute it instead.
  void leave_to_kernel(const asmjit::Label& rare, std::uint32_t to, Type type) {
    const asmjit::Label done = s_.a.newLabel();
    s_.a.bind(done);
    s_.cold_path([&s = s_, call = call_, rare, done, to, type, place = result()] {
      s.a.bind(rare);
      call();
      if (is_real(type)) {
        s.load_real(to, place, type);
      } else {
        s.load(to, place, bytes_of(type));
      }
      s.a.jmp(done);
    });
  }

  // ---- selection

  void select() override {
    // What is held first, before other loads overwrite it.
    const bool real_held = is_real(type_) && (s_.holds_real(argument(1), type_) || s_.holds_real(argument(2), type_));
    const unsigned wide = bytes_ == 8 ? 8 : 4;
    const std::uint32_t zero = reg::kAx;
    const std::uint32_t one = reg::kCx;
    const std::uint32_t g = reg::kDx;
    const std::uint32_t holder = s_.holder();
    if (real_held) {
      const bool is_zero = s_.holds_real(argument(1), type_);
      s_.a.emit(bytes_ == 8 ? x86::Inst::kIdMovq : x86::Inst::kIdMovd, gp(is_zero ? zero : one, bytes_),
                x86::xmm(holder));
      if (is_zero && argument(1) != argument(2)) {
        s_.load(one, argument(2), bytes_);
      } else if (is_zero) {
        s_.a.mov(gp(one, wide), gp(zero, wide));
      } else {
        s_.load(zero, argument(1), bytes_);
      }
    } else if (s_.holds(argument(0), 1)) {
      s_.load(g, argument(0), 1);
      s_.forget();
      s_.load(zero, argument(1), bytes_);
      s_.load(one, argument(2), bytes_);
      return choose(zero, one, g, wide);
    } else if (s_.holds(argument(2), bytes_)) {
      s_.load(one, argument(2), bytes_);
      s_.load(zero, argument(1), bytes_);
    } else {
      s_.load(zero, argument(1), bytes_);
      s_.load(one, argument(2), bytes_);
    }
    s_.load(g, argument(0), 1);
    choose(zero, one, g, wide);
  }
  void choose(std::uint32_t zero, std::uint32_t one, std::uint32_t g, unsigned wide) {
    s_.a.test(gp(g, 1), gp(g, 1));
    s_.a.cmovnz(gp(zero, wide), gp(one, wide));
    s_.store(result(), bytes_, zero);
    if (!is_real(type_) || s_.kept(result(), true)) return;
    // What is done with a real next wants it where reals are.
    s_.a.emit(bytes_ == 8 ? x86::Inst::kIdMovq : x86::Inst::kIdMovd, x86::xmm(0), gp(zero, bytes_));
    s_.hold_real(result(), type_, 0);
  }

  /// The least or greatest of the value in `value` and an operand, there; `other` is lost. Of two that are equal, or no
  /// numbers, the first stays.
  void fold(std::uint32_t value, std::uint32_t other, std::uint32_t operand, bool least) {
    const unsigned wide = bytes_ == 8 ? 8 : 4;
    s_.load(other, operand, bytes_);
    s_.a.cmp(gp(value, bytes_), gp(other, bytes_));
    const bool with_sign = is_signed(type_);
    const x86::CondCode code = least ? (with_sign ? x86::CondCode::kG : x86::CondCode::kA)
                                     : (with_sign ? x86::CondCode::kL : x86::CondCode::kB);
    s_.a.emit(asmjit::x86::Inst::cmovccFromCond(code), gp(value, wide), gp(other, wide));
  }
  /// MINSS and its like give the second operand when both are equal or one is no number: the value so far.
  std::uint32_t fold_real(std::uint32_t value, std::uint32_t operand, bool least) {
    const bool f32 = type_ == Type::kF32;
    const std::uint32_t other = value == 0 ? 1 : 0;
    s_.load_real(other, operand, type_);
    const auto id =
        least ? (f32 ? x86::Inst::kIdMinss : x86::Inst::kIdMinsd) : (f32 ? x86::Inst::kIdMaxss : x86::Inst::kIdMaxsd);
    s_.a.emit(id, x86::xmm(other), x86::xmm(value));
    return other;
  }
  void extreme(bool least) override {
    if (is_real(type_)) {
      std::uint32_t value = first_real(argument(0));
      for (std::uint32_t n = 1; n < count(); ++n) value = fold_real(value, argument(n), least);
      return s_.store_real(result(), type_, value);
    }
    const std::uint32_t value = first_integer(argument(0));
    for (std::uint32_t n = 1; n < count(); ++n) fold(value, reg::kCx, argument(n), least);
    s_.store(result(), bytes_, value);
  }
  void limit() override {
    if (is_real(type_)) {
      const std::uint32_t value = fold_real(first_real(argument(1)), argument(0), false);
      return s_.store_real(result(), type_, fold_real(value, argument(2), true));
    }
    const std::uint32_t value = first_integer(argument(1));
    fold(value, reg::kCx, argument(0), false);
    fold(value, reg::kCx, argument(2), true);
    s_.store(result(), bytes_, value);
  }
  /// In ax; nothing else is held.
  std::uint32_t first_integer(std::uint32_t operand) {
    s_.load(reg::kAx, operand, bytes_);
    s_.forget();
    return reg::kAx;
  }
  /// In 0 or 1; nothing else is held.
  std::uint32_t first_real(std::uint32_t operand) {
    s_.load_real(0, operand, type_);
    s_.forget();
    return 0;
  }

  // ---- numbers

  void absolute() override {
    const unsigned wide = bytes_ == 8 ? 8 : 4;
    s_.load_extended(reg::kAx, argument(0), type_);
    s_.a.mov(gp(reg::kCx, wide), gp(reg::kAx, wide));
    s_.a.neg(gp(reg::kAx, wide));
    s_.a.cmovs(gp(reg::kAx, wide), gp(reg::kCx, wide));
    s_.store(result(), bytes_, reg::kAx);
  }
  void square_root() override {
    const bool f32 = type_ == Type::kF32;
    const asmjit::Label rare = s_.a.newLabel();
    s_.load_real(0, argument(0), type_);
    s_.a.emit(f32 ? x86::Inst::kIdSqrtss : x86::Inst::kIdSqrtsd, x86::xmm0, x86::xmm0);
    s_.a.emit(f32 ? x86::Inst::kIdUcomiss : x86::Inst::kIdUcomisd, x86::xmm0, x86::xmm0);
    s_.a.jp(rare);
    s_.store_real(result(), type_, 0);
    leave_to_kernel(rare, 0, type_);
  }
  void invert() override {
    s_.load(reg::kAx, argument(0), bytes_);
    s_.a.xor_(gp(reg::kAx, bytes_), overload_.t == TypeId::kBool ? 1 : -1);
    s_.store(result(), bytes_, reg::kAx);
  }
  void shift(bool left) override { move_bits(left ? x86::Inst::kIdShl : x86::Inst::kIdShr, true); }
  void rotate(bool left) override { move_bits(left ? x86::Inst::kIdRol : x86::Inst::kIdRor, false); }
  /// `bounded`: by less than the width.
  void move_bits(asmjit::InstId id, bool bounded) {
    const auto by = machine_type(overload_.u);
    if (const auto known = plain_shift(s_, words_)) {
      const std::uint32_t to = s_.kept(result()).value_or(reg::kAx);
      s_.load(to, argument(0), bytes_);
      s_.a.emit(id, gp(to, bytes_), asmjit::imm(*known));
      return s_.store(result(), bytes_, to);
    }
    const asmjit::Label rare = s_.a.newLabel();
    // The value first: it may be what is held, and cx may be where that is.
    s_.load(reg::kAx, argument(0), bytes_);
    if (argument(0) == argument(1)) s_.forget();
    const unsigned wide = bytes_of(*by) == 8 ? 8 : 4;
    s_.load_extended(reg::kCx, argument(1), *by);
    if (bounded) {
      s_.a.cmp(gp(reg::kCx, wide), bytes_ * 8);
      s_.a.jae(rare);  // a negative one is very great
    } else {
      s_.a.test(gp(reg::kCx, wide), gp(reg::kCx, wide));
      s_.a.js(rare);
    }
    s_.a.emit(id, gp(reg::kAx, bytes_), x86::cl);
    s_.store(result(), bytes_, reg::kAx);
    leave_to_kernel(rare, reg::kAx, type_);
  }

  // ---- conversions

  bool convert() override {
    const Type to = *machine_type(overload_.u);
    if (is_real(type_) && is_real(to)) {
      real_to_real(to);
    } else if (is_real(type_)) {
      if (overload_.u == TypeId::kBool || to == Type::kU64) return false;
      real_to_integer(to);
    } else if (is_real(to)) {
      if (type_ == Type::kU64) return false;
      integer_to_real(to);
    } else {
      integer_to_integer(to);
    }
    return true;
  }
  void integer_to_integer(Type to) {
    const unsigned bytes = bytes_of(to);
    if (overload_.u == TypeId::kBool) {
      s_.load(reg::kAx, argument(0), bytes_);
      s_.a.test(gp(reg::kAx, bytes_), gp(reg::kAx, bytes_));
      s_.a.setne(x86::al);
    } else if (bytes == 8 && bytes_ == 4 && is_signed(type_)) {
      s_.load(reg::kAx, argument(0), 4);
      s_.a.movsxd(x86::rax, x86::eax);
    } else if (bytes == 8 && bytes_ < 4 && is_signed(type_)) {
      s_.load_extended(reg::kAx, argument(0), type_);
      s_.a.movsxd(x86::rax, x86::eax);
    } else if (bytes == 8 && bytes_ == 4) {
      s_.load(reg::kAx, argument(0), 4);
      s_.a.mov(x86::eax, x86::eax);  // the upper half is zero after this alone
    } else if (bytes > bytes_) {
      s_.load_extended(reg::kAx, argument(0), type_);
    } else {
      s_.load(reg::kAx, argument(0), bytes_);
    }
    s_.store(result(), bytes, reg::kAx);
  }
  void integer_to_real(Type to) {
    const unsigned from = type_ == Type::kU32 || bytes_ == 8 ? 8 : 4;
    s_.load_extended(reg::kAx, argument(0), type_);
    if (type_ == Type::kU32) s_.a.mov(x86::eax, x86::eax);
    s_.a.xorps(x86::xmm0, x86::xmm0);  // nothing to wait for
    s_.a.emit(to == Type::kF32 ? x86::Inst::kIdCvtsi2ss : x86::Inst::kIdCvtsi2sd, x86::xmm0, gp(reg::kAx, from));
    s_.store_real(result(), to, 0);
  }
  /// Rounded half to even by the processor; what does not fit, and NaN, is for the kernel.
  void real_to_integer(Type to) {
    const unsigned bytes = bytes_of(to);
    const asmjit::Label rare = s_.a.newLabel();
    s_.load_real(0, argument(0), type_);
    s_.a.emit(type_ == Type::kF32 ? x86::Inst::kIdCvtss2si : x86::Inst::kIdCvtsd2si, x86::rax, x86::xmm0);
    switch (to) {
      case Type::kI8:
        s_.a.movsx(x86::rcx, x86::al);
        break;
      case Type::kU8:
        s_.a.movzx(x86::ecx, x86::al);
        break;
      case Type::kI16:
        s_.a.movsx(x86::rcx, x86::ax);
        break;
      case Type::kU16:
        s_.a.movzx(x86::ecx, x86::ax);
        break;
      case Type::kI32:
        s_.a.movsxd(x86::rcx, x86::eax);
        break;
      case Type::kU32:
        s_.a.mov(x86::ecx, x86::eax);
        break;
      default:
        // What the processor gives for all that does not fit.
        s_.a.mov(x86::rcx, std::uint64_t{1} << 63);
        break;
    }
    s_.a.cmp(x86::rax, x86::rcx);
    s_.a.j(bytes == 8 ? x86::CondCode::kE : x86::CondCode::kNE, rare);
    s_.forget();
    s_.store(result(), bytes, reg::kAx);
    leave_to_kernel(rare, reg::kAx, to);
  }
  void real_to_real(Type to) {
    s_.load_real(0, argument(0), type_);
    if (type_ == to) return s_.store_real(result(), to, 0);
    const asmjit::Label rare = s_.a.newLabel();
    s_.a.emit(to == Type::kF64 ? x86::Inst::kIdCvtss2sd : x86::Inst::kIdCvtsd2ss, x86::xmm0, x86::xmm0);
    s_.a.emit(to == Type::kF64 ? x86::Inst::kIdUcomisd : x86::Inst::kIdUcomiss, x86::xmm0, x86::xmm0);
    s_.a.jp(rare);
    s_.store_real(result(), to, 0);
    leave_to_kernel(rare, 0, to);
  }

  Assembly& s_;
};

}  // namespace

bool translate_library(Assembly& s, const Instruction& i, const std::function<void()>& call) {
  const auto row = function_of(runtime::load_pointer<stdlib::Kernel>(i.words + 1));
  return row && Translator(s, i, *row, call).translate(row->function);
}

}  // namespace plc::native
