// Assembly: the Emitter of x86-64, with operands and registers.
//
// In: what the compiler and the translators (translate_*.cpp) want done. Out: instructions. Registers: rbx = machine,
// r13 = the instance in bodies with several, r14 = events at the last CLEAR_EVENT in bodies with ENO; all others are
// free between instructions. Variables are named by their distance from the code (rip), never through a base register:
// twice as fast on the processors measured. Does not belong here: what instructions mean.
#pragma once

#include <asmjit/x86.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "native/emitter.h"

namespace plc::native {

namespace x86 = asmjit::x86;

/// Numbers of registers that every instruction may use; the first three have short forms for bytes.
namespace reg {
inline constexpr std::uint32_t kAx = 0, kCx = 1, kDx = 2, kSi = 6, kDi = 7;
}

/// Members of the machine, which rbx points to.
namespace machine {
x86::Mem loops_left();
x86::Mem place();
x86::Mem event_count();
x86::Mem step();  ///< the context that blocks are given
x86::Mem now();   ///< the time in it
}  // namespace machine

/// General register `number` as one of `bytes` bytes.
x86::Gp gp(std::uint32_t number, unsigned bytes);

class Assembly final : public Emitter {
 public:
  /// For code that starts at `address` and works on `table`.
  Assembly(std::byte* table, std::uint64_t address)
      : Emitter(a, table, address, std::numeric_limits<std::size_t>::max()) {
    attach();
  }

  x86::Assembler a;

  // ---- operands
  [[nodiscard]] x86::Mem at(std::uint32_t operand, unsigned bytes) const;
  /// Address of an operand's place.
  void address(const x86::Gp& to, std::uint32_t operand);

  // ---- integers and bits; upper bits of a register are not known for values of less than 4 bytes
  void load(std::uint32_t to, std::uint32_t operand, unsigned bytes);
  /// Extended to 4 bytes if it has less.
  void load_extended(std::uint32_t to, std::uint32_t operand, Type type);
  void store(std::uint32_t operand, unsigned bytes, std::uint32_t from);
  // ---- reals
  void load_real(std::uint32_t to, std::uint32_t operand, Type type);
  void store_real(std::uint32_t operand, Type type, std::uint32_t from);

  // ---- control (control.cpp)
  void begin_entry() override;
  void end_entry() override;
  void begin_body(bool counts_events) override;
  void leave_body(bool result) override;
  void jump(const asmjit::Label& target) override;
  void jump_if(std::uint32_t operand, bool value, const asmjit::Label& target) override;
  void jump_if_result(bool value, const asmjit::Label& target) override;
  void take_loop(std::uint32_t position, const asmjit::Label& over) override;
  void pass(unsigned argument, std::uint64_t value) override;
  void pass_machine(unsigned argument) override;
  void pass_step(unsigned argument) override;
  void pass_address(unsigned argument, std::uint32_t operand) override;
  void pass_instance_offset(unsigned argument) override;
  void pass_result(unsigned argument) override;
  void call_address(std::uint64_t address) override;
  void call_body(const asmjit::Label& body) override;
  void call_kernel(std::uint64_t kernel, std::uint32_t result, std::span<const std::uint32_t> arguments) override;
  void move(std::uint32_t to, std::uint32_t from, unsigned bytes) override;
  void store_constant(std::uint32_t operand, unsigned bytes, std::uint64_t value) override;
  void note_place(std::uint32_t position) override;
  void mark_events() override;
  void store_no_event(std::uint32_t operand) override;

 private:
  bool counts_events_ = false;  ///< in the body that is being written
};

}  // namespace plc::native
