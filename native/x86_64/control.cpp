// Control between instructions and bodies. Bodies keep the stack as C++ wants it for calls: a return address lies on it
// when they begin.
#include <array>

#include "native/assembly.h"
#include "native/translate.h"

namespace plc::native {
namespace {

/// General registers of arguments.
constexpr std::array<std::uint32_t, 4> kArguments = {reg::kDi, reg::kSi, reg::kDx, reg::kCx};

/// How much of the loop budget a loop with kept variables takes at a time. Others, who cut loops by setting the rest to
/// 0, wait for so many iterations at most.
constexpr std::uint32_t kPortion = 256;

}  // namespace

void Assembly::begin_entry(bool loops) {
  a.push(x86::rbx);
  a.push(x86::rbp);
  a.mov(x86::rbx, x86::rdi);
  a.mov(x86::rbp, table_);
  a.push(loops ? x86::r12 : x86::rax);  // an odd number of them, for the stack
  if (!loops) return;
  a.push(x86::r15);
  a.sub(x86::rsp, 8);
}
void Assembly::end_entry(bool loops) {
  if (loops) {
    a.add(x86::rsp, 8);
    a.pop(x86::r15);
  }
  a.pop(loops ? x86::r12 : x86::rcx);
  a.pop(x86::rbp);
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
void Assembly::end_body() {
  if (relative == counts_events_) a.add(x86::rsp, 8);
  if (counts_events_) a.pop(x86::r14);
  if (relative) a.pop(x86::r13);
  forget();
}
void Assembly::leave_body(bool result) {
  a.mov(x86::eax, result ? 1 : 0);
  end_body();
  a.ret();
}
void Assembly::leave_to_body(const asmjit::Label& body) {
  end_body();
  a.jmp(body);
}

void Assembly::jump(const asmjit::Label& target) {
  a.jmp(target);
  forget();
}
void Assembly::jump_if(std::uint32_t operand, bool value, const asmjit::Label& target) {
  if (const auto number = in_register(operand, 1)) {
    a.test(gp(*number, 1), gp(*number, 1));
  } else {
    a.cmp(at(operand, 1), 0);
  }
  a.j(value ? x86::CondCode::kNZ : x86::CondCode::kZ, target);
}
void Assembly::jump_if_result(bool value, const asmjit::Label& target) {
  a.test(x86::al, x86::al);
  a.j(value ? x86::CondCode::kNZ : x86::CondCode::kZ, target);
}
void Assembly::loop_back(std::uint32_t position, const asmjit::Label& head, const asmjit::Label& over, bool follows) {
  if (kept_ != nullptr) {
    const asmjit::Label more = label();
    a.sub(gp(kept_->budget, 4), 1);
    if (follows) {
      a.jb(more);
    } else {
      a.jae(head);
      a.jmp(more);
    }
    forget();
    return cold_path([this, position, head, over, more, portion = gp(kept_->budget, 4)] {
      bind(more);
      note_place(position);
      a.xor_(portion, portion);
      a.mov(x86::eax, machine::loops_left());
      a.test(x86::eax, x86::eax);
      a.jz(over);
      a.mov(x86::ecx, kPortion);
      a.cmp(x86::eax, x86::ecx);
      a.cmovb(x86::ecx, x86::eax);
      a.sub(x86::eax, x86::ecx);
      a.mov(machine::loops_left(), x86::eax);
      a.lea(portion, x86::ptr(x86::rcx, -1));
      a.jmp(head);
    });
  }
  forget();
  a.mov(x86::eax, machine::loops_left());
  note_place(position);
  a.sub(x86::eax, 1);
  a.jb(over);
  a.mov(machine::loops_left(), x86::eax);
  jump(head);
}

void Assembly::begin_iterations(const Instruction& compare, bool down, std::int64_t distance, std::uint32_t jumps,
                                const asmjit::Label& fewer) {
  const Type type = compare.operation.type;
  const unsigned bytes = bytes_of(type);
  const std::uint32_t control = compare.words[2], limit = compare.words[3];
  forget();
  const auto kept_control = bytes == 4 ? kept(control) : std::nullopt;
  if (!kept_control) load_extended(reg::kAx, control, type);
  const x86::Gp counted = gp(kept_control.value_or(reg::kAx), 4);
  const asmjit::Operand known = value(limit, bytes);
  const std::int64_t bound =
      known.isImm() ? known.as<asmjit::Imm>().value() + (down ? distance : -distance) : std::int64_t{0};
  if (known.isImm() && bound == static_cast<std::int32_t>(bound)) {
    a.cmp(counted, bound);
    a.j(down ? x86::CondCode::kLE : x86::CondCode::kGE, fewer);
  } else {
    load_extended(reg::kCx, limit, type);
    a.movsxd(x86::rax, counted);
    a.movsxd(x86::rcx, x86::ecx);
    a.sub(down ? x86::rax : x86::rcx, down ? x86::rcx : x86::rax);
    a.cmp(down ? x86::rax : x86::rcx, distance);
    a.jle(fewer);
  }
  const asmjit::Label less = label();
  a.sub(gp(kept_->budget, 4), jumps);
  a.jb(less);
  cold_path([this, less, fewer, jumps] {
    bind(less);
    a.add(gp(kept_->budget, 4), jumps);
    a.jmp(fewer);
  });
  forget();
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
  a.mov(to, x86::r13);
  a.sub(to, x86::rbp);
}
void Assembly::pass_result(unsigned argument) { a.movzx(gp(kArguments[argument], 4), x86::al); }

void Assembly::call_address(std::uint64_t address) {
  forget();
  forget_rows();
  write_back();
  a.mov(x86::rax, address);
  a.call(x86::rax);
  read_back();
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
