#include "native/assembly.h"

#include "native/helpers.h"

namespace plc::native {

namespace machine {
// Machine holds atomics and a span, so the standard leaves its layout to the compiler; both compilers know it.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Winvalid-offsetof"
using runtime::Machine;
static_assert(sizeof(Machine::loops_left) == 4 && sizeof(Machine::place) == 4 && sizeof(Machine::event_count) == 8);
x86::Mem loops_left() { return x86::dword_ptr(x86::rbx, offsetof(Machine, loops_left)); }
x86::Mem place() { return x86::dword_ptr(x86::rbx, offsetof(Machine, place)); }
x86::Mem event_count() { return x86::qword_ptr(x86::rbx, offsetof(Machine, event_count)); }
x86::Mem step() { return x86::ptr(x86::rbx, offsetof(Machine, step)); }
x86::Mem now() { return x86::qword_ptr(x86::rbx, offsetof(Machine, step) + offsetof(stdlib::StepContext, now_ns)); }
#pragma GCC diagnostic pop
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

Assembly::Assembly(std::byte* table, std::uint64_t address) : table_(reinterpret_cast<std::uint64_t>(table)) {
  code_.init(asmjit::Environment::host(), address);
  code_.setErrorHandler(this);
  code_.attach(&a);
}

void Assembly::handleError(asmjit::Error, const char* message, asmjit::BaseEmitter*) {
  if (problem_.empty()) problem_ = message;
}

x86::Mem Assembly::at(std::uint32_t operand, unsigned bytes) const {
  if (relative && (operand & runtime::kRelativeBit) != 0) {
    return x86::ptr(x86::r13, static_cast<std::int32_t>(operand & ~runtime::kRelativeBit), bytes);
  }
  return x86::ptr_rel(address_of(operand), bytes);
}

void Assembly::address(const x86::Gp& to, std::uint32_t operand) { a.lea(to, at(operand, 0)); }

void Assembly::instance_offset(const x86::Gp& to) {
  a.lea(to, x86::ptr_rel(table_));
  a.neg(to);
  a.add(to, x86::r13);
}

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

void Assembly::call_address(std::uint64_t address) {
  forget();
  a.mov(x86::rax, address);
  a.call(x86::rax);
}

void Assembly::write_asides() {
  // Index by index: what is written may put more aside.
  for (std::size_t i = 0; i < asides_.size(); ++i) {
    const std::function<void()> code = std::move(asides_[i]);
    code();
  }
  asides_.clear();
  forget();
}

void Assembly::raise(std::uint32_t position, int event) {
  if (event < 0) {
    a.movzx(x86::edx, x86::al);
  } else {
    a.mov(x86::edx, event);
  }
  a.mov(x86::rdi, x86::rbx);
  a.mov(x86::esi, position);
  call(&raise_event);
}

asmjit::Label Assembly::data(std::vector<std::uint64_t> words) {
  const asmjit::Label label = a.newLabel();
  data_.emplace_back(label, std::move(words));
  return label;
}

void Assembly::write_data() {
  a.align(asmjit::AlignMode::kData, 8);
  for (const auto& [label, words] : data_) {
    a.bind(label);
    a.embed(words.data(), words.size() * sizeof(std::uint64_t));
  }
}

const std::byte* Assembly::place_of(const asmjit::Label& label) const {
  return reinterpret_cast<const std::byte*>(code_.baseAddress() + code_.labelOffset(label));
}

std::vector<std::byte> Assembly::finish() {
  code_.flatten();
  code_.resolveUnresolvedLinks();
  code_.relocateToBase(code_.baseAddress());
  std::vector<std::byte> bytes(code_.codeSize());
  code_.copyFlattenedData(bytes.data(), bytes.size());
  return bytes;
}

}  // namespace plc::native
