#include "native/assembly.h"

#include "native/machine_layout.h"

namespace plc::native {

namespace machine {
x86::Mem loops_left() { return x86::dword_ptr(x86::rbx, kLoopsLeft); }
x86::Mem place() { return x86::dword_ptr(x86::rbx, kPlace); }
x86::Mem event_count() { return x86::qword_ptr(x86::rbx, kEventCount); }
x86::Mem step() { return x86::ptr(x86::rbx, kStep); }
x86::Mem now() { return x86::qword_ptr(x86::rbx, kNow); }
}  // namespace machine

x86::Gp gp(std::uint32_t number, unsigned bytes) {
  switch (bytes) {
    case 1:
      return x86::gpb(number);
    case 2:
      return x86::gpw(number);
    case 4:
      return x86::gpd(number);
    default:
      return x86::gpq(number);
  }
}

x86::Mem Assembly::at(std::uint32_t operand, unsigned bytes) const {
  if (relative && (operand & runtime::kRelativeBit) != 0) {
    return x86::ptr(x86::r13, static_cast<std::int32_t>(operand & ~runtime::kRelativeBit), bytes);
  }
  return x86::ptr_rel(address_of(operand), bytes);
}

void Assembly::address(const x86::Gp& to, std::uint32_t operand) { a.lea(to, at(operand, 0)); }

void Assembly::load(std::uint32_t to, std::uint32_t operand, unsigned bytes) {
  if (holds(operand, bytes)) {
    if (to != held_.reg) a.mov(gp(to, bytes == 8 ? 8 : 4), gp(held_.reg, bytes == 8 ? 8 : 4));
    return;
  }
  overwrite(to, false);
  // Narrow loads are extended: a register that keeps its upper part would wait for who wrote it.
  if (bytes < 4) {
    a.movzx(gp(to, 4), at(operand, bytes));
  } else {
    a.mov(gp(to, bytes), at(operand, bytes));
  }
}

void Assembly::load_extended(std::uint32_t to, std::uint32_t operand, Type type) {
  const unsigned bytes = bytes_of(type);
  if (bytes >= 4) return load(to, operand, bytes);
  const bool held = holds(operand, bytes);
  const auto id = is_signed(type) ? x86::Inst::kIdMovsx : x86::Inst::kIdMovzx;
  if (held) {
    a.emit(id, gp(to, 4), gp(held_.reg, bytes));
  } else {
    overwrite(to, false);
    a.emit(id, gp(to, 4), at(operand, bytes));
  }
}

void Assembly::store(std::uint32_t operand, unsigned bytes, std::uint32_t from) {
  a.mov(at(operand, bytes), gp(from, bytes));
  held_ = {operand, bytes, false, from};
}

void Assembly::load_real(std::uint32_t to, std::uint32_t operand, Type type) {
  const bool f32 = type == Type::kF32;
  const x86::Xmm value = x86::xmm(to);
  if (holds_real(operand, type)) {
    if (to != held_.reg) a.movaps(value, x86::xmm(held_.reg));
    return;
  }
  overwrite(to, true);
  if (f32) {
    a.movss(value, at(operand, 4));
  } else {
    a.movsd(value, at(operand, 8));
  }
}

void Assembly::store_real(std::uint32_t operand, Type type, std::uint32_t from) {
  if (type == Type::kF32) {
    a.movss(at(operand, 4), x86::xmm(from));
  } else {
    a.movsd(at(operand, 8), x86::xmm(from));
  }
  held_ = {operand, bytes_of(type), true, from};
}

}  // namespace plc::native
