// Emitter: code of one task while it is written, as far as it is alike on all processors: labels, the value stored
// last, code out of the way, words after the code, and the control between instructions and bodies.
//
// In: what the compiler (compile.cpp) wants done. Out: bytes. Each processor has an Assembly,
// which is an Emitter with the operands, registers and instructions that its translators use (x86_64/, aarch64/).
// Does not belong here: what instructions of resolved code mean.
#pragma once

#include <asmjit/core.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "native/loops.h"
#include "native/operation.h"
#include "runtime/interpreter/interpreter.h"

namespace plc::native {

struct Instruction;

/// What code works on.
struct Memory {
  std::byte* table = nullptr;
  std::uint32_t constants = 0, constants_end = 0;  ///< offsets of what is never written
};

class Emitter : private asmjit::ErrorHandler {
 public:
  Emitter(const Emitter&) = delete;
  Emitter& operator=(const Emitter&) = delete;
  /// Whether operands may be relative to the instance, in the body that is being written.
  bool relative = false;
  /// No instructions but those that every processor of this kind has.
  bool baseline = false;
  /// Variables are named by their distance from the code, on processors that can (x86-64).
  bool from_code = false;

  /// The value of an operand of 1 to 8 bytes that is never written, zero-extended.
  [[nodiscard]] std::optional<std::uint64_t> constant(std::uint32_t operand, unsigned bytes) const;

  // ---- the value stored last is still in its register; nothing else is known of registers between instructions
  [[nodiscard]] bool holds(std::uint32_t operand, unsigned bytes) const {
    return held_.bytes == bytes && held_.operand == operand && !held_.real;
  }
  [[nodiscard]] bool holds_real(std::uint32_t operand, Type type) const {
    return held_.bytes == bytes_of(type) && held_.operand == operand && held_.real;
  }
  /// Its register, for values that holds() or holds_real().
  [[nodiscard]] std::uint32_t holder() const { return held_.reg; }
  struct HeldBit {
    std::uint32_t operand, number;
  };
  /// The value stored last, if it is one byte in a register.
  [[nodiscard]] std::optional<HeldBit> held_bit() const {
    if (held_.bytes != 1 || held_.real) return std::nullopt;
    return HeldBit{held_.operand, held_.reg};
  }
  /// The value stored last is in this register, too.
  void hold_real(std::uint32_t operand, Type type, std::uint32_t number) {
    hold({operand, bytes_of(type), true, number});
  }
  void forget() { held_.bytes = 0; }
  /// The result of the next instruction is only held, the one after it takes it from there (dead_stores.h):
  /// `left_out`, if there is one. To be called before each instruction.
  void leave_out(std::optional<std::uint32_t> left_out) { missing_ = std::exchange(left_out_, left_out); }

  /// Before each instruction: what is known of registers that its code loses is forgotten.
  virtual void begin(const Instruction&) {}

  // ---- loops: while one is written, variables of it lie in registers instead of in the table, but for calls
  /// Variables go into registers.
  virtual void enter_loop(const Loop&) {}
  /// Registers go back to the table: before a call, and where the loop is left, any number of times.
  virtual void write_back() {}
  /// Makes the NaN in a variable, if one is there, that of the interpreter.
  virtual void make_one_nan(std::uint32_t, Type) {}
  /// Two ways to compute integers, in a loop: the first one works on copies, the second one, after other_branch(), on
  /// the variables themselves; what the copies hold is taken if the BOOL `condition` is `value`. In between, nothing
  /// but what computes_integer(). `written`: by one of the two or both; keeps() says whether this can be done with
  /// them.
  [[nodiscard]] virtual bool keeps(std::span<const std::uint32_t>) const { return false; }
  virtual void begin_both_branches(std::span<const std::uint32_t>) {}
  virtual void other_branch() {}
  virtual void end_both_branches(std::uint32_t, bool) {}
  /// Several iterations of a counted loop at once: jumps to `fewer` unless the integer `limit` is more than `distance`
  /// above `control` (below it: `down`), and the part of the loop budget at hand has `jumps`, which are taken then.
  virtual void begin_iterations(const Instruction& /*compare*/, bool /*down*/, std::int64_t /*distance*/,
                                std::uint32_t /*jumps*/, const asmjit::Label& /*fewer*/) {}
  [[nodiscard]] bool in_loop() const { return kept_ != nullptr; }
  /// The loop's code ends here.
  void end_loop() { kept_.reset(); }

  // ---- bodies: bool (); in relative ones the instance is in argument 0
  /// The function that C++ calls, bool (Machine&): everything until end_entry(). `loops`: some
  /// body enters loops.
  virtual void begin_entry(bool loops) = 0;
  virtual void end_entry(bool loops) = 0;
  /// `counts_events`: the body may use mark_events() and store_no_event(). Its operands are as `relative` says.
  virtual void begin_body(bool counts_events) = 0;
  virtual void leave_body(bool result) = 0;
  /// Goes on with another body, which returns for this one.
  virtual void leave_to_body(const asmjit::Label& body) = 0;

  // ---- jumps
  asmjit::Label label() { return assembler_.newLabel(); }
  virtual void bind(const asmjit::Label& label) { assembler_.bind(label); }
  /// What comes next is the head of a loop. WHY 16 bytes: filters take a tenth less than anywhere; 32 or 64 gain
  /// nothing more, and short loops inside of others lose by what comes before their heads.
  void align_head() { assembler_.align(asmjit::AlignMode::kCode, 16); }
  /// Others jump here: nothing is known of registers.
  void land(const asmjit::Label& label) {
    forget();
    bind(label);
  }
  virtual void jump(const asmjit::Label& target) = 0;
  /// Jumps if the BOOL at `operand` is `value`.
  virtual void jump_if(std::uint32_t operand, bool value, const asmjit::Label& target) = 0;
  /// Jumps if the function called last returned `value`.
  virtual void jump_if_result(bool value, const asmjit::Label& target) = 0;
  /// To `head`, and takes one from the loop budget; to `over`, and nothing is taken, when there is none. Notes the
  /// place, if not in every iteration. `follows`: the code at `head` comes next.
  virtual void loop_back(std::uint32_t position, const asmjit::Label& head, const asmjit::Label& over,
                         bool follows) = 0;

  // ---- calls: arguments, of which the last ones first, then the call. Everything in registers is lost.
  virtual void pass(unsigned argument, std::uint64_t value) = 0;
  virtual void pass_machine(unsigned argument) = 0;
  /// StepContext&
  virtual void pass_step(unsigned argument) = 0;
  /// Address of an operand's place.
  virtual void pass_address(unsigned argument, std::uint32_t operand) = 0;
  /// Offset in the table of the current instance.
  virtual void pass_instance_offset(unsigned argument) = 0;
  /// The byte that the function called last returned; before other arguments.
  virtual void pass_result(unsigned argument) = 0;
  template <class Result, class... Arguments>
  void call(Result (*function)(Arguments...) noexcept) {
    call_address(reinterpret_cast<std::uint64_t>(function));
  }
  virtual void call_address(std::uint64_t address) = 0;
  virtual void call_body(const asmjit::Label& body) = 0;
  /// A kernel of the library (stdlib::Kernel).
  virtual void call_kernel(std::uint64_t kernel, std::uint32_t result, std::span<const std::uint32_t> arguments) = 0;

  // ---- data
  /// Copies 1, 2, 4 or 8 bytes.
  virtual void move(std::uint32_t to, std::uint32_t from, unsigned bytes) = 0;
  virtual void store_constant(std::uint32_t operand, unsigned bytes, std::uint64_t value) = 0;
  /// The instruction at `position` is where the scan is.
  virtual void note_place(std::uint32_t position) = 0;
  /// CLEAR_EVENT, and whether no event was raised since then.
  virtual void mark_events() = 0;
  virtual void store_no_event(std::uint32_t operand) = 0;

  /// Code for a rare case: written after the body, where straight execution does not come by.
  void cold_path(std::function<void()> code);
  /// Writes what was put on a cold path. At the end of a body.
  void write_cold_paths();
  /// Writes it here, after a jump, if the code that jumps to it would otherwise get out of reach. Between
  /// instructions.
  void keep_cold_paths_near();
  /// Code for an event of the instruction at `position`; to be put on a cold path. `event` < 0: it was returned by a
  /// call.
  void raise(std::uint32_t position, int event);

  /// 64-bit words that the code refers to, after all of it.
  asmjit::Label data(std::vector<std::uint64_t> words);
  void write_data();

  [[nodiscard]] std::uint64_t address_of(std::uint32_t operand) const { return table_ + operand; }
  [[nodiscard]] std::size_t size() const { return assembler_.offset(); }
  /// The code cannot be made.
  void refuse(const char* why) {
    if (problem_.empty()) problem_ = why;
  }
  /// What was refused first, here or by asmjit; or empty.
  [[nodiscard]] const std::string& problem() const { return problem_; }
  /// Resolves all references within the code. Its size.
  std::size_t finish();
  /// Writes it, to run at `address`. False when the table is too far from there for the form of its operands.
  bool write(std::span<std::byte> to, std::uint64_t address);

 protected:
  /// For code written by `assembler`, which attach() is for. `reach`: bytes of code after which what was put on a cold
  /// path has to be written.
  Emitter(asmjit::BaseAssembler& assembler, const Memory& memory, std::size_t reach);
  ~Emitter() override = default;
  void attach();

  /// A register gets another value.
  void overwrite(std::uint32_t number, bool real) {
    if (held_.reg == number && held_.real == real) forget();
  }

  /// What lies in registers in a loop.
  struct Kept {
    struct Variable {
      LoopVariable what;
      std::uint32_t reg = 0;
    };
    std::vector<Variable> variables;
    std::uint32_t budget = 0;  ///< register of a part of the loop budget that memory has not
  };
  std::shared_ptr<const Kept> kept_;  ///< null outside of loops

  /// An operand gets a value. Returns whether that has to be stored.
  bool begin_store(std::uint32_t operand) {
    if (missing_ == operand) missing_.reset();
    return left_out_ != operand;
  }
  /// An operand is about to be read in the table.
  void expect_stored(std::uint32_t operand) {
    if (missing_ == operand) refuse("a result that was not stored is not in the table");
  }

  struct Held {
    std::uint32_t operand = 0;
    unsigned bytes = 0;  ///< 0 = nothing
    bool real = false;
    std::uint32_t reg = 0;
  };
  std::uint64_t table_;
  Held held_;
  /// The value stored last is in this register, which may become that of the next value: not one in which a loop keeps
  /// a variable.
  void hold(const Held& value) {
    held_ = value;
    if (kept_ == nullptr) return;
    for (const Kept::Variable& variable : kept_->variables) {
      if (variable.reg == value.reg && variable.what.real == value.real) forget();
    }
  }

 private:
  void handleError(asmjit::Error error, const char* message, asmjit::BaseEmitter* origin) override;

  std::optional<std::uint32_t> left_out_;  ///< by the instruction that is being written
  std::optional<std::uint32_t> missing_;   ///< left out by the one before it
  Memory memory_;
  asmjit::CodeHolder code_;
  asmjit::BaseAssembler& assembler_;
  std::size_t reach_;
  struct ColdPath {
    std::function<void()> code;
    std::shared_ptr<const Kept> kept;
    std::optional<std::uint32_t> missing;
  };
  std::vector<ColdPath> cold_paths_;
  std::size_t first_cold_path_ = 0;  ///< where the code is that put the first of them aside
  std::vector<std::pair<asmjit::Label, std::vector<std::uint64_t>>> data_;
  std::string problem_;
};

}  // namespace plc::native
