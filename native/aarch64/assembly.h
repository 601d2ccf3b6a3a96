// Assembly: the Emitter of AArch64, with operands and registers.
//
// In: what the compiler and the translators (translate_*.cpp) want done. Out: instructions. Registers: x19 = machine,
// x20 = table, x21 = the instance in bodies with several, x22 = events at the last CLEAR_EVENT in bodies with ENO,
// x23 .. x26 = pages of the table that were used last; x16 and x17 serve operands and calls; x0 .. x15 and v0 .. v7 are
// free between instructions. Variables are named by their distance from the table or from such a page. Does not belong
// here: what instructions mean.
#pragma once

#include <asmjit/arm/a64assembler.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "native/emitter.h"

namespace plc::native {

namespace a64 = asmjit::a64;
using Condition = a64::CondCode;

/// General register `number` as one of 8 bytes or, for less, of 4.
inline a64::Gp gp(std::uint32_t number, unsigned bytes) {
  return bytes == 8 ? a64::Gp(a64::x(number)) : a64::Gp(a64::w(number));
}
/// Vector register `number` as a real.
inline a64::Vec vec(std::uint32_t number, Type type) {
  return type == Type::kF32 ? a64::Vec(a64::s(number)) : a64::Vec(a64::d(number));
}

class Assembly final : public Emitter {
 public:
  explicit Assembly(const Memory& memory) : Emitter(a, memory, kReach) { attach(); }

  a64::Assembler a;

  // ---- operands
  /// Where an operand of `bytes` bytes is. Writes what its address takes; to be used at once.
  a64::Mem at(std::uint32_t operand, unsigned bytes);
  /// Address of an operand's place.
  void address(const a64::Gp& to, std::uint32_t operand);
  using Emitter::constant;
  void constant(const a64::Gp& to, std::uint64_t value);
  /// The first (0) or another register that holds no value.
  [[nodiscard]] std::uint32_t free(std::uint32_t n) const;

  // ---- integers and bits; upper bits of a register are not known for values of less than 4 bytes, but zero for BOOLs
  void load(std::uint32_t to, std::uint32_t operand, unsigned bytes);
  /// Extended to 4 bytes if it has less.
  void load_extended(std::uint32_t to, std::uint32_t operand, Type type);
  /// The register that holds the operand, or `to`, which it is loaded to then.
  std::uint32_t value(std::uint32_t to, std::uint32_t operand, unsigned bytes);
  std::uint32_t extended_value(std::uint32_t to, std::uint32_t operand, Type type);
  void store(std::uint32_t operand, unsigned bytes, std::uint32_t from);
  // ---- reals
  void load_real(std::uint32_t to, std::uint32_t operand, Type type);
  std::uint32_t real_value(std::uint32_t to, std::uint32_t operand, Type type);
  void store_real(std::uint32_t operand, Type type, std::uint32_t from);
  // ---- by address
  void load_from(const a64::Mem& from, unsigned bytes, std::uint32_t to);
  void store_to(const a64::Mem& to, unsigned bytes, std::uint32_t from);

  /// Jumps if the flags say so, anywhere. For targets of jumps in programs.
  void jump_on(Condition condition, const asmjit::Label& target);

  static constexpr bool kKeepsLoops = false;

  // ---- control (control.cpp)
  void bind(const asmjit::Label& label) override;
  void begin_entry(bool loops) override;
  void end_entry(bool loops) override;
  void begin_body(bool counts_events) override;
  void leave_body(bool result) override;
  void leave_to_body(const asmjit::Label& body) override;
  void jump(const asmjit::Label& target) override;
  void jump_if(std::uint32_t operand, bool value, const asmjit::Label& target) override;
  void jump_if_result(bool value, const asmjit::Label& target) override;
  void loop_back(std::uint32_t position, const asmjit::Label& head, const asmjit::Label& over, bool follows) override;
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

  /// Numbers of registers of the contract above.
  static constexpr std::uint32_t kMachine = 19, kTable = 20, kInstance = 21, kEvents = 22, kFirstPage = 23;
  /// The one that is always zero.
  static constexpr std::uint32_t kZero = a64::Gp::kIdZr;

 private:
  void end_body();
  /// Conditional jumps reach 1 MiB; what is put on a cold path has to be near enough with all that is put on a cold
  /// path besides.
  static constexpr std::size_t kReach = 128 * 1024;
  static constexpr std::uint32_t kPageBytes = 4096;

  /// Where operands count from, and the distance.
  struct Place {
    std::uint32_t base = kTable;
    std::uint32_t offset = 0;
  };
  [[nodiscard]] Place place_of(std::uint32_t operand) const;
  /// Register that holds the address of the page.
  std::uint32_t page(std::uint32_t base, std::uint32_t offset);
  void forget_pages() { pages_.fill({}); }

  struct Page {
    std::uint32_t base = 0;  ///< 0 = nothing
    std::uint32_t offset = 0;
  };
  std::array<Page, 4> pages_{};
  std::size_t next_page_ = 0;
  bool counts_events_ = false;  ///< in the body that is being written
};

}  // namespace plc::native
