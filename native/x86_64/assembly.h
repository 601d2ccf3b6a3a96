// Assembly: the Emitter of x86-64, with operands and registers.
//
// In: what the compiler and the translators (translate_*.cpp) want done. Out: instructions. Registers: rbx = machine,
// rbp = the task's table, r13 = the instance in bodies with several, r14 = events at the last CLEAR_EVENT in bodies
// with ENO; in loops, r8 to r12, r15 and xmm2 to xmm15 are the loop's, and rsi and rdi may hold addresses of rows
// (below); all others are free between instructions. Variables are named by their distance from there, as compiled C
// does: an instruction that computes with memory at a distance from the code (rip) is two to the processor. Does not
// belong here: what instructions mean.
#pragma once

#include <asmjit/x86.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

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
  explicit Assembly(const Memory& memory) : Emitter(a, memory, std::numeric_limits<std::size_t>::max()) { attach(); }

  x86::Assembler a;

  /// Whether ANDN may be used: processors with BMI1, most since 2013.
  [[nodiscard]] bool has_andn() const { return !baseline && __builtin_cpu_supports("bmi") != 0; }

  /// Whether AVX may be used: processors since 2011, if the system saves its registers.
  [[nodiscard]] bool has_avx() const { return !baseline && __builtin_cpu_supports("avx") != 0; }

  // ---- operands
  /// In the table: not for a variable that lies in a register.
  [[nodiscard]] x86::Mem at(std::uint32_t operand, unsigned bytes);
  /// A register that holds an address `distance` bytes before the operand's place.
  x86::Gp base(std::uint32_t operand, std::int32_t& distance) const;
  /// The register that a loop keeps it in, if one does and it is one for integers (reals).
  [[nodiscard]] std::optional<std::uint32_t> kept(std::uint32_t operand, bool real = false) const;
  /// The register where it is kept or held, until something is written to that.
  [[nodiscard]] std::optional<std::uint32_t> in_register(std::uint32_t operand, unsigned bytes) const;
  [[nodiscard]] std::optional<std::uint32_t> in_register(std::uint32_t operand, Type real) const;
  /// That register, or the place in the table, or a constant if it is a short one: what instructions take as their
  /// second operand.
  [[nodiscard]] asmjit::Operand value(std::uint32_t operand, unsigned bytes);
  [[nodiscard]] asmjit::Operand real_value(std::uint32_t operand, Type type);
  /// real_value() of the operand is this place, once: it is not loaded by itself.
  void pass_on(std::uint32_t operand, const x86::Mem& place) { passed_ = {operand, place}; }
  /// Address of an operand's place.
  void address(const x86::Gp& to, std::uint32_t operand);

  // ---- integers and bits; upper bits of a register are not known for values of less than 4 bytes
  void load(std::uint32_t to, std::uint32_t operand, unsigned bytes);
  /// Extended to 4 bytes if it has less.
  void load_extended(std::uint32_t to, std::uint32_t operand, Type type);
  void store(std::uint32_t operand, unsigned bytes, std::uint32_t from);
  /// The same for a BOOL that seldom changes, and whose block looks at it together with others: a byte that was just
  /// written would have to be waited for.
  void store_change(std::uint32_t operand, std::uint32_t from);
  /// A constant for a port of the block after it; no register but an unused one is lost.
  void store_port(std::uint32_t operand, unsigned bytes, std::uint64_t value);
  /// The BOOL at `operand` is in this register, too.
  void hold_bit(std::uint32_t operand, std::uint32_t number) { hold({operand, 1, false, number}); }
  /// A BOOL in a register; `extended`: its upper bits are zero, else they are not known.
  struct DeferredStore {
    std::uint32_t operand, number;
    bool extended;
  };
  /// The BOOL is in this register alone: the block after, whose port it is, stores it. Until then, nothing but
  /// constants are stored.
  void defer_store(const DeferredStore& bit) { deferred_.push_back(bit); }
  /// A port, if it is owed; from now on it is not.
  std::optional<DeferredStore> take_deferred(std::uint32_t operand);
  /// A register that nothing is held or owed in.
  [[nodiscard]] std::uint32_t unused() const;
  // ---- reals
  void load_real(std::uint32_t to, std::uint32_t operand, Type type);
  void store_real(std::uint32_t operand, Type type, std::uint32_t from);
  /// Of all NaN, the one that arithmetic makes in a program: what the processor makes of an invalid operation has the
  /// sign bit. Loses rax then.
  void one_nan(std::uint32_t number, bool f32);

  // ---- rows: in loops, where an element lies is known from the one before, if they differ in the last index or in
  // what the loop counts
  struct Row {
    std::uint32_t base = 0;     ///< register that the distance of the array is from
    std::uint32_t operand = 0;  ///< its index, a variable of the loop,
    std::int64_t lower = 0;     ///< which begins with this,
    std::uint32_t count = 0;    ///< has so many values,
    std::uint32_t stride = 0;   ///< so many bytes apart
    std::int64_t ahead = 0;     ///< so much was added to it since
    std::uint32_t reg = 0;      ///< base + (index - lower) * stride, as the index was
    [[nodiscard]] bool is_like(const Row& other) const {
      return base == other.base && operand == other.operand && lower == other.lower && count == other.count &&
             stride == other.stride;
    }
  };
  [[nodiscard]] const Row* find_row(const Row& like) const;
  /// The row has a register, whose value is still to be made.
  const Row& add_row(Row row);
  void forget_rows() { rows_.clear(); }
  void begin(const Instruction& instruction) override;
  /// The instruction has written what it writes: after an instruction that leaves rows as they are.
  void end(const Instruction& instruction);

  // ---- loops
  static constexpr bool kKeepsLoops = true;
  void enter_loop(const Loop& loop) override;
  void write_back() override;
  void make_one_nan(std::uint32_t operand, Type type) override;
  void begin_iterations(const Instruction& compare, bool down, std::int64_t distance, std::uint32_t jumps,
                        const asmjit::Label& fewer) override;
  [[nodiscard]] bool keeps(std::span<const std::uint32_t> written) const override;
  void begin_both_branches(std::span<const std::uint32_t> written) override;
  void other_branch() override;
  void end_both_branches(std::uint32_t condition, bool value) override;

  // ---- control (control.cpp)
  void begin_entry(bool loops) override;
  void end_entry(bool loops) override;
  void begin_body(bool counts_events) override;
  void leave_body(bool result) override;
  void leave_to_body(const asmjit::Label& body) override;
  /// Others may come here, in whose registers are other rows.
  void bind(const asmjit::Label& label) override {
    forget_rows();
    Emitter::bind(label);
  }
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

 private:
  void end_body();
  [[nodiscard]] x86::Mem place(std::uint32_t operand, unsigned bytes) const;
  void read_back();
  void store_if_not_equal(const x86::Mem& to, const asmjit::Operand& value);

  std::vector<DeferredStore> deferred_;
  std::vector<Row> rows_;  ///< the one made last after the other
  std::optional<std::pair<std::uint32_t, x86::Mem>> passed_;
  std::shared_ptr<const Kept> other_;   ///< registers of the second way
  std::vector<std::uint32_t> written_;  ///< by one of the two

  bool counts_events_ = false;  ///< in the body that is being written
};

}  // namespace plc::native
