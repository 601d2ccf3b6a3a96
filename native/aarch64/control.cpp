// Control between instructions and bodies. Bodies keep the stack at a multiple of 16 bytes, as the processor wants it.
#include "native/assembly.h"
#include "native/machine_layout.h"

namespace plc::native {
namespace {

/// Registers that C++ wants back: the frame, then pairs.
constexpr std::uint32_t kSaved[] = {29, 19, 21, 23, 25};
constexpr std::int32_t kEntryBytes = 80;
constexpr std::uint32_t kCallRegister = 17;

a64::Mem member(std::int32_t offset) { return a64::ptr(a64::x(Assembly::kMachine), offset); }

}  // namespace

void Assembly::bind(const asmjit::Label& label) {
  forget_pages();
  Emitter::bind(label);
}

void Assembly::begin_entry(bool) {
  a.stp(a64::x29, a64::x30, a64::ptr_pre(a64::sp, -kEntryBytes));
  a.mov(a64::x29, a64::sp);
  for (std::int32_t i = 1; i < 5; ++i) a.stp(a64::x(kSaved[i]), a64::x(kSaved[i] + 1), a64::ptr(a64::sp, 16 * i));
  a.mov(a64::x(kMachine), a64::x0);
  constant(a64::x(kTable), table_);
}
void Assembly::end_entry(bool) {
  for (std::int32_t i = 1; i < 5; ++i) a.ldp(a64::x(kSaved[i]), a64::x(kSaved[i] + 1), a64::ptr(a64::sp, 16 * i));
  a.ldp(a64::x29, a64::x30, a64::ptr_post(a64::sp, kEntryBytes));
  a.ret(a64::x30);
}

void Assembly::begin_body(bool counts_events) {
  counts_events_ = counts_events;
  forget_pages();
  if (!relative && !counts_events) {
    a.str(a64::x30, a64::ptr_pre(a64::sp, -16));
    return;
  }
  a.stp(a64::x30, a64::x(kInstance), a64::ptr_pre(a64::sp, -32));
  if (relative) a.mov(a64::x(kInstance), a64::x0);
  if (counts_events) {
    a.str(a64::x(kEvents), a64::ptr(a64::sp, 16));
    a.ldr(a64::x(kEvents), member(machine::kEventCount));
  }
}
void Assembly::end_body() {
  if (!relative && !counts_events_) {
    a.ldr(a64::x30, a64::ptr_post(a64::sp, 16));
  } else {
    if (counts_events_) a.ldr(a64::x(kEvents), a64::ptr(a64::sp, 16));
    a.ldp(a64::x30, a64::x(kInstance), a64::ptr_post(a64::sp, 32));
  }
  forget();
}
void Assembly::leave_body(bool result) {
  a.mov(a64::w0, result ? 1 : 0);
  end_body();
  a.ret(a64::x30);
}
void Assembly::leave_to_body(const asmjit::Label& body) {
  end_body();
  a.b(body);
}

void Assembly::jump(const asmjit::Label& target) {
  a.b(target);
  forget();
}
void Assembly::jump_if(std::uint32_t operand, bool value, const asmjit::Label& target) {
  const std::uint32_t condition = this->value(free(0), operand, 1);
  a.cmp(a64::w(condition), 0);
  jump_on(value ? Condition::kNE : Condition::kEQ, target);
}
void Assembly::jump_if_result(bool value, const asmjit::Label& target) {
  // Rare: what was called failed, or raised an event.
  const asmjit::Label rare = label();
  a.tst(a64::w0, 0xff);
  a.b(value ? Condition::kNE : Condition::kEQ, rare);
  cold_path([this, rare, target] {
    land(rare);
    a.b(target);
  });
}
void Assembly::loop_back(std::uint32_t position, const asmjit::Label& head, const asmjit::Label& over, bool) {
  forget();
  a.ldr(a64::w0, member(machine::kLoopsLeft));
  note_place(position);
  a.cbz(a64::w0, over);
  a.sub(a64::w0, a64::w0, 1);
  a.str(a64::w0, member(machine::kLoopsLeft));
  jump(head);
}

void Assembly::pass(unsigned argument, std::uint64_t value) {
  const bool is_short = value <= 0xffffffffu;
  constant(gp(argument, is_short ? 4 : 8), value);
}
void Assembly::pass_machine(unsigned argument) { a.mov(a64::x(argument), a64::x(kMachine)); }
void Assembly::pass_step(unsigned argument) { a.add(a64::x(argument), a64::x(kMachine), machine::kStep); }
void Assembly::pass_address(unsigned argument, std::uint32_t operand) { address(a64::x(argument), operand); }
void Assembly::pass_instance_offset(unsigned argument) { a.sub(a64::x(argument), a64::x(kInstance), a64::x(kTable)); }
void Assembly::pass_result(unsigned argument) { a.uxtb(a64::w(argument), a64::w0); }

void Assembly::call_address(std::uint64_t address) {
  forget();
  constant(a64::x(kCallRegister), address);
  a.blr(a64::x(kCallRegister));
}
void Assembly::call_body(const asmjit::Label& body) {
  forget();
  a.bl(body);
  forget_pages();
}
void Assembly::call_kernel(std::uint64_t kernel, std::uint32_t result, std::span<const std::uint32_t> arguments) {
  const auto count = static_cast<std::uint32_t>(arguments.size());
  const std::uint32_t stack = (count * 8 + 15) / 16 * 16;
  if (stack != 0) a.sub(a64::sp, a64::sp, stack);
  for (std::uint32_t n = 0; n < count; ++n) {
    address(a64::x0, arguments[n]);
    a.str(a64::x0, a64::ptr(a64::sp, static_cast<std::int32_t>(n * 8)));
  }
  a.mov(a64::x1, a64::sp);
  address(a64::x0, result);
  pass(2, count);
  call_address(kernel);
  if (stack != 0) a.add(a64::sp, a64::sp, stack);
}

void Assembly::move(std::uint32_t to, std::uint32_t from, unsigned bytes) {
  forget();
  load(0, from, bytes);
  store(to, bytes, 0);
}
void Assembly::store_constant(std::uint32_t operand, unsigned bytes, std::uint64_t value) {
  forget();
  constant(gp(0, bytes), value);
  store_to(at(operand, bytes), bytes, 0);
}
void Assembly::note_place(std::uint32_t position) {
  constant(a64::w1, position);
  a.str(a64::w1, member(machine::kPlace));
}
void Assembly::mark_events() {
  if (counts_events_) a.ldr(a64::x(kEvents), member(machine::kEventCount));
}
void Assembly::store_no_event(std::uint32_t operand) {
  forget();
  a.ldr(a64::x0, member(machine::kEventCount));
  a.cmp(a64::x0, a64::x(kEvents));
  a.cset(a64::w0, Condition::kEQ);
  store(operand, 1, 0);
}

}  // namespace plc::native
