// Assembly: x86-64 code of one task while it is written: operands, the value stored last, calls, code out of the way.
//
// In: what the translators (translate_*.cpp) want done. Out: bytes for one known address. Registers: rbx = machine,
// r13 = the instance in bodies with several, r14 = events at the last CLEAR_EVENT in bodies with ENO; all others are
// free between instructions. Variables are named by their distance from the code (rip), never through a base register:
// twice as fast on the processors measured. Does not belong here: what instructions mean.
#pragma once

#include <asmjit/x86.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "native/operation.h"

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

class Assembly final : private asmjit::ErrorHandler {
 public:
  /// For code that starts at `address` and works on `table`.
  Assembly(std::byte* table, std::uint64_t address);

  x86::Assembler a;

  /// Whether operands may be relative to the instance, in the body that is being written.
  bool relative = false;

  // ---- operands
  [[nodiscard]] x86::Mem at(std::uint32_t operand, unsigned bytes) const;
  /// Address of an operand's place.
  void address(const x86::Gp& to, std::uint32_t operand);
  /// Offset in the table of the current instance.
  void instance_offset(const x86::Gp& to);

  // ---- integers and bits; upper bits of a register are not known for values of less than 4 bytes
  void load(std::uint32_t to, std::uint32_t operand, unsigned bytes);
  /// Extended to 4 bytes if it has less.
  void load_extended(std::uint32_t to, std::uint32_t operand, Type type);
  void store(std::uint32_t operand, unsigned bytes, std::uint32_t from);
  // ---- reals
  void load_real(std::uint32_t to, std::uint32_t operand, Type type);
  void store_real(std::uint32_t operand, Type type, std::uint32_t from);

  // ---- the value stored last is still in its register; nothing else is known of registers between instructions
  [[nodiscard]] bool holds(std::uint32_t operand, unsigned bytes) const {
    return held_.bytes == bytes && held_.operand == operand && !held_.real;
  }
  [[nodiscard]] bool holds_real(std::uint32_t operand, Type type) const {
    return held_.bytes == bytes_of(type) && held_.operand == operand && held_.real;
  }
  /// Its register, for values that holds() or holds_real().
  [[nodiscard]] std::uint32_t holder() const { return held_.reg; }
  void forget() { held_.bytes = 0; }

  // ---- control
  /// Others jump here: nothing is known of registers.
  void land(const asmjit::Label& label) {
    forget();
    a.bind(label);
  }
  /// Calls C++; arguments are in place. All registers but rbx, r13 and r14 are lost.
  template <class Result, class... Arguments>
  void call(Result (*function)(Arguments...) noexcept) {
    call_address(reinterpret_cast<std::uint64_t>(function));
  }
  void call_address(std::uint64_t address);
  /// Code for a rare case: written behind the body, where straight execution does not come by.
  void aside(std::function<void()> code) { asides_.push_back(std::move(code)); }
  /// Writes what was put aside. At the end of a body.
  void write_asides();
  /// Code for an event of the instruction at `position`; to be put aside. `event` < 0: it is in al.
  void raise(std::uint32_t position, int event);

  /// 64-bit words that the code refers to, behind all of it.
  asmjit::Label data(std::vector<std::uint64_t> words);
  void write_data();

  /// Where a label will lie; after finish().
  [[nodiscard]] const std::byte* place_of(const asmjit::Label& label) const;
  [[nodiscard]] std::uint64_t address_of(std::uint32_t operand) const { return table_ + operand; }
  [[nodiscard]] std::size_t size() const { return a.offset(); }
  /// What asmjit refused first, or empty.
  [[nodiscard]] const std::string& problem() const { return problem_; }
  /// Resolves all references; the code as it is to lie at its address.
  std::vector<std::byte> finish();

 private:
  void handleError(asmjit::Error error, const char* message, asmjit::BaseEmitter* origin) override;

  /// A register gets another value.
  void overwrite(std::uint32_t number, bool real) {
    if (held_.reg == number && held_.real == real) forget();
  }

  struct Held {
    std::uint32_t operand = 0;
    unsigned bytes = 0;  ///< 0 = nothing
    bool real = false;
    std::uint32_t reg = 0;
  };
  asmjit::CodeHolder code_;
  std::uint64_t table_;
  Held held_;
  std::vector<std::function<void()>> asides_;
  std::vector<std::pair<asmjit::Label, std::vector<std::uint64_t>>> data_;
  std::string problem_;
};

}  // namespace plc::native
