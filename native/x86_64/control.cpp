// Control between instructions and bodies. Bodies keep the stack as C++ wants it for calls: a return address lies on it
// when they begin.
#include <array>

#include "native/assembly.h"

namespace plc::native {
namespace {

/// General registers of arguments.
constexpr std::array<std::uint32_t, 4> kArguments = {reg::kDi, reg::kSi, reg::kDx, reg::kCx};

}  // namespace

void Assembly::begin_entry() {
  a.push(x86::rbx);
  a.mov(x86::rbx, x86::rdi);
}
void Assembly::end_entry() {
  a.pop(x86::rbx);
  a.ret();
}

void Assembly::begin_body(bool counts_events) {
  counts_events_ = counts_events;
  if (relative) {
    a.push(x86::r13);
    a.mov(x86::r13, x86::rdi);
  }
  if (counts_events) {
    a.push(x86::r14);
    a.mov(x86::r14, machine::event_count());
  }
  if (relative == counts_events) a.sub(x86::rsp, 8);
}
void Assembly::leave_body(bool result) {
  a.mov(x86::eax, result ? 1 : 0);
  if (relative == counts_events_) a.add(x86::rsp, 8);
  if (counts_events_) a.pop(x86::r14);
  if (relative) a.pop(x86::r13);
  a.ret();
  forget();
}

void Assembly::jump(const asmjit::Label& target) {
  a.jmp(target);
  forget();
}
void Assembly::jump_if(std::uint32_t operand, bool value, const asmjit::Label& target) {
  if (holds(operand, 1)) {
    a.test(gp(holder(), 1), gp(holder(), 1));
  } else {
    a.cmp(at(operand, 1), 0);
  }
  a.j(value ? x86::CondCode::kNZ : x86::CondCode::kZ, target);
}
void Assembly::jump_if_result(bool value, const asmjit::Label& target) {
  a.test(x86::al, x86::al);
  a.j(value ? x86::CondCode::kNZ : x86::CondCode::kZ, target);
}
void Assembly::take_loop(std::uint32_t position, const asmjit::Label& over) {
  forget();
  a.mov(x86::eax, machine::loops_left());
  note_place(position);
  a.sub(x86::eax, 1);
  a.jb(over);
  a.mov(machine::loops_left(), x86::eax);
}

void Assembly::pass(unsigned argument, std::uint64_t value) {
  const bool is_short = value <= 0xffffffffu;
  a.mov(gp(kArguments[argument], is_short ? 4 : 8), value);
}
void Assembly::pass_machine(unsigned argument) { a.mov(gp(kArguments[argument], 8), x86::rbx); }
void Assembly::pass_step(unsigned argument) { a.lea(gp(kArguments[argument], 8), machine::step()); }
void Assembly::pass_address(unsigned argument, std::uint32_t operand) { address(gp(kArguments[argument], 8), operand); }
void Assembly::pass_instance_offset(unsigned argument) {
  const x86::Gp to = gp(kArguments[argument], 8);
  a.lea(to, x86::ptr_rel(table_));
  a.neg(to);
  a.add(to, x86::r13);
}
void Assembly::pass_result(unsigned argument) { a.movzx(gp(kArguments[argument], 4), x86::al); }

void Assembly::call_address(std::uint64_t address) {
  forget();
  a.mov(x86::rax, address);
  a.call(x86::rax);
}
void Assembly::call_body(const asmjit::Label& body) {
  forget();
  a.call(body);
}
void Assembly::call_kernel(std::uint64_t kernel, std::uint32_t result, std::span<const std::uint32_t> arguments) {
  const auto count = static_cast<std::uint32_t>(arguments.size());
  const std::uint32_t stack = relative ? (count * 8 + 15) / 16 * 16 : 0;
  if (relative) {
    a.sub(x86::rsp, stack);
    for (std::uint32_t n = 0; n < count; ++n) {
      address(x86::rax, arguments[n]);
      a.mov(x86::qword_ptr(x86::rsp, static_cast<std::int32_t>(n * 8)), x86::rax);
    }
    a.mov(x86::rsi, x86::rsp);
  } else {
    std::vector<std::uint64_t> addresses;
    for (const std::uint32_t argument : arguments) addresses.push_back(address_of(argument));
    a.lea(x86::rsi, x86::ptr(data(std::move(addresses))));
  }
  address(x86::rdi, result);
  pass(2, count);
  call_address(kernel);
  if (relative) a.add(x86::rsp, stack);
}

void Assembly::move(std::uint32_t to, std::uint32_t from, unsigned bytes) {
  forget();
  load(reg::kAx, from, bytes);
  store(to, bytes, reg::kAx);
}
void Assembly::store_constant(std::uint32_t operand, unsigned bytes, std::uint64_t value) {
  forget();
  a.mov(x86::rax, value);
  a.mov(at(operand, bytes), gp(reg::kAx, bytes));
}
void Assembly::note_place(std::uint32_t position) { a.mov(machine::place(), position); }
void Assembly::mark_events() {
  if (counts_events_) a.mov(x86::r14, machine::event_count());
}
void Assembly::store_no_event(std::uint32_t operand) {
  a.cmp(x86::r14, machine::event_count());
  a.sete(x86::al);
  store(operand, 1, reg::kAx);
}

}  // namespace plc::native
