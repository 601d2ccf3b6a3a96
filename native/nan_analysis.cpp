#include "native/nan_analysis.h"

#include <bit>
#include <optional>
#include <utility>

#include "runtime/interpreter/operations.h"

namespace plc::native {
namespace {

/// Which reals may hold another NaN than in the interpreter. A variable is smooth when it holds what it would there,
/// and no NaN but the one that arithmetic makes; strange when it holds what it would there, perhaps a NaN from
/// elsewhere; non_canonical when it may hold any NaN for the one that arithmetic makes. What may be both strange and
/// non_canonical cannot be put right later: such variables are checked where they are computed.
class Reals {
 public:
  struct State {
    std::uint64_t strange = 0, non_canonical = 0;  ///< bits by variable
  };

  Reals(const Emitter& emitter, const LoopCode& loop, std::span<const LoopVariable> variables)
      : emitter_(emitter), loop_(loop) {
    for (const LoopVariable& variable : variables) {
      if (!variable.real || variables_.size() >= kMostVariables) continue;
      variables_.push_back({variable.operand, variable.bytes == 4 ? Type::kF32 : Type::kF64});
    }
    find_readers();
  }

  /// Where the loop is entered.
  [[nodiscard]] State entry() const { return {live_.front(), 0}; }
  [[nodiscard]] bool is_any() const { return !variables_.empty(); }
  /// Variables that were found to be strange and non_canonical; those are not non_canonical in a walk from now on.
  bool take_mixed() {
    const bool any = mixed_ != 0;
    checked_ |= std::exchange(mixed_, 0);
    return any;
  }
  [[nodiscard]] std::vector<NonCanonicalReal> list(std::uint64_t variables) const {
    std::vector<NonCanonicalReal> found;
    for (; variables != 0; variables &= variables - 1) {
      found.push_back(variables_[static_cast<std::size_t>(std::countr_zero(variables))]);
    }
    return found;
  }
  /// Those whose bits an instruction looks at.
  [[nodiscard]] std::uint64_t looked_at(std::size_t i) const { return looked_at_[i - loop_.first()]; }
  /// Whether an instruction may leave a NaN as it comes.
  [[nodiscard]] bool leaves_any_nan(std::size_t i) const {
    return is_arithmetic(i) && (bit(loop_.at(i).words[1]) & ~checked_) != 0;
  }

  std::optional<State> step(std::size_t i, State& state) {
    const Instruction instruction = loop_.at(i);
    state.non_canonical &= ~looked_at(i);
    const std::uint64_t written = written_[i - loop_.first()];
    std::uint64_t strange = written;
    if (is_arithmetic(i)) {
      strange = 0;
    } else if (instruction.operation.form == Form::kMove && is_smooth(instruction, state)) {
      strange = 0;
    }
    state.strange = (state.strange & ~written) | strange;
    state.non_canonical = (state.non_canonical & ~written) | (leaves_any_nan(i) ? written : 0);
    if (target_of(instruction.operation.form, instruction.words) == kNoTarget) return std::nullopt;
    return state;
  }
  static bool possible(const State&) { return true; }
  bool join(State& into, const State& from, bool, std::size_t i) {
    const State old = into;
    into.strange |= from.strange;
    into.non_canonical |= from.non_canonical;
    // After the loop everything counts, in it only what is read.
    const std::uint64_t counts = i > loop_.last() ? ~std::uint64_t{0} : live_[i - loop_.first()];
    into.strange &= counts;
    into.non_canonical &= counts;
    mixed_ |= into.strange & into.non_canonical;
    return into.strange != old.strange || into.non_canonical != old.non_canonical;
  }

 private:
  [[nodiscard]] std::uint64_t bit(std::uint32_t operand) const {
    for (std::size_t v = 0; v < variables_.size(); ++v) {
      if (variables_[v].operand == operand) return std::uint64_t{1} << v;
    }
    return 0;
  }
  [[nodiscard]] bool is_arithmetic(std::size_t i) const {
    const Operation operation = loop_.at(i).operation;
    switch (operation.form) {
      case Form::kAdd:
      case Form::kSub:
      case Form::kMul:
      case Form::kDiv:
        return is_real(operation.type);
      default:
        return false;
    }
  }
  [[nodiscard]] bool is_comparison(std::size_t i) const {
    const Form form = loop_.at(i).operation.form;
    return form == Form::kCompare || form == Form::kCompareJumpUnless || form == Form::kCompareJumpIf;
  }
  /// What a move moves: a number, or a variable that is smooth, or was made so.
  [[nodiscard]] bool is_smooth(const Instruction& move, const State& state) const {
    const unsigned bytes = bytes_of(move.operation.type);
    if (const auto known = emitter_.constant(move.words[2], bytes)) {
      constexpr std::uint64_t kExponent32 = 0x7f800000u, kExponent64 = 0x7ff0000000000000u;
      return bytes == 4 ? (*known & kExponent32) != kExponent32 : (*known & kExponent64) != kExponent64;
    }
    const std::uint64_t from = bit(move.words[2]);
    return from != 0 && (state.strange & from) == 0;
  }

  /// Which variables each instruction writes and looks at, and which are read later before they are written, or there
  /// where the loop is left.
  void find_readers() {
    const std::size_t size = loop_.last() - loop_.first() + 1;
    std::vector<std::uint64_t> read(size), kept(size, ~std::uint64_t{0});
    written_.resize(size);
    looked_at_.resize(size);
    live_.resize(size);
    for (std::size_t n = 0; n < size; ++n) {
      const std::size_t i = loop_.first() + n;
      for (const Access& access : loop_.accesses(i)) {
        const std::uint64_t variable = bit(access.operand);
        (access.write ? written_ : read)[n] |= variable;
        if (!access.write && !is_arithmetic(i) && !is_comparison(i)) looked_at_[n] |= variable;
      }
      // A function that raises an event may leave its result as it was.
      if (loop_.at(i).operation.form == Form::kCallLibrary) {
        read[n] |= written_[n];
        looked_at_[n] |= written_[n];
      } else {
        kept[n] = ~written_[n];
      }
    }
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t n = size; n-- > 0;) {
        const std::size_t i = loop_.first() + n;
        const Instruction instruction = loop_.at(i);
        const Form form = instruction.operation.form;
        std::uint64_t live_after = 0;
        if (loop_.goes_on(i)) live_after |= live_[n + 1];
        if (target_of(form, instruction.words) != kNoTarget) {
          const auto target = loop_.target(i);
          live_after |= target ? live_[*target - loop_.first()] : ~std::uint64_t{0};
        }
        // The scan may end here.
        if (form == Form::kLoopJump || form == Form::kReturn) live_after = ~std::uint64_t{0};
        const std::uint64_t live = (live_after & kept[n]) | read[n];
        changed = changed || live != live_[n];
        live_[n] = live;
      }
    }
  }

  const Emitter& emitter_;
  const LoopCode& loop_;
  std::vector<NonCanonicalReal> variables_;
  std::vector<std::uint64_t> written_, looked_at_, live_;  ///< by instruction; live: before it
  std::uint64_t mixed_ = 0, checked_ = 0;
};

}  // namespace

void find_non_canonical_reals(const Emitter& emitter, const LoopCode& code, std::span<const LoopVariable> variables,
                              LoopRanges& facts) {
  Reals reals(emitter, code, variables);
  if (!reals.is_any()) return;
  for (;;) {
    Walk walk(code, reals);
    if (!walk.run(reals.entry())) return;
    if (reals.take_mixed()) continue;
    for (std::size_t i = code.first(); i <= code.last(); ++i) {
      if (!walk.before(i)) continue;
      const std::uint64_t non_canonical = walk.before(i)->non_canonical;
      const Form form = code.at(i).operation.form;
      InstructionRanges& of = facts.instructions[i - code.first()];
      of.known.any_nan = reals.leaves_any_nan(i);
      of.before = reals.list(non_canonical & reals.looked_at(i));
      if (form == Form::kLoopJump || form == Form::kReturn) of.end.reals = reals.list(non_canonical);
    }
    for (const auto& [position, state] : walk.exits()) facts.exits[position].reals = reals.list(state.non_canonical);
    return;
  }
}

}  // namespace plc::native
