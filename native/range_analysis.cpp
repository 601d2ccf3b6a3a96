#include "native/range_analysis.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "native/loop_walk.h"
#include "native/nan_analysis.h"
#include "runtime/interpreter/operations.h"

namespace plc::native {

using runtime::LinkedInstruction;

namespace {

/// All values from one to another one.
struct Interval {
  std::int64_t least = 0, most = 0;
  friend bool operator==(const Interval&, const Interval&) = default;
  [[nodiscard]] bool is_empty() const { return least > most; }
};

/// Variables of up to four bytes as numbers with a sign.
class Integers {
 public:
  using State = std::vector<Interval>;  ///< by variable; one that is empty: not reached

  Integers(const Emitter& emitter, const LoopCode& loop, std::span<const LoopVariable> variables)
      : emitter_(emitter), loop_(loop) {
    for (const LoopVariable& variable : variables) {
      if (variable.real || variable.bytes > 4 || emitter.constant(variable.operand, variable.bytes)) continue;
      if (variables_.size() < kMostVariables) variables_.push_back({variable.operand, variable.bytes});
    }
    // Where a growing range may stop: at what the loop compares with.
    for (std::size_t i = loop.first(); i <= loop.last(); ++i) {
      const Instruction instruction = loop.at(i);
      const Form form = instruction.operation.form;
      if (form != Form::kCompare && form != Form::kCompareJumpUnless && form != Form::kCompareJumpIf) continue;
      for (const unsigned word : {2u, 3u}) {
        const auto known = number(instruction.words[word], bytes_of(instruction.operation.type));
        if (known && !is_real(instruction.operation.type)) {
          for (const std::int64_t stop : {*known - 1, *known, *known + 1}) stops_.push_back(stop);
        }
      }
    }
    std::sort(stops_.begin(), stops_.end());
  }

  /// Where the loop is entered.
  [[nodiscard]] State entry() {
    State state = anything();
    for (std::size_t i = loop_.straight_before(); i < loop_.first(); ++i) {
      switch (loop_.at(i).operation.form) {
        case Form::kBlockStart:
          break;
        case Form::kMove:
        case Form::kAdd:
        case Form::kSub:
          step(i, state);
          break;
        default:
          state = anything();
      }
    }
    return state;
  }
  [[nodiscard]] Interval range(const State& state, std::uint32_t operand, unsigned bytes) const {
    if (const auto known = number(operand, bytes)) return {*known, *known};
    for (std::size_t v = 0; v < variables_.size(); ++v) {
      if (variables_[v].operand == operand && variables_[v].bytes == bytes) return state[v];
    }
    return any(bytes);
  }

  std::optional<State> step(std::size_t i, State& state) {
    const Instruction instruction = loop_.at(i);
    const std::uint32_t* const w = instruction.words;
    const Type type = instruction.operation.type;
    const unsigned bytes = bytes_of(type);
    switch (instruction.operation.form) {
      case Form::kJump:
      case Form::kLoopJump:
      case Form::kJumpUnless:
      case Form::kJumpIf:
        return state;
      case Form::kMove:
        set(state, w[1], bytes, is_real(type) ? any(bytes) : range(state, w[2], bytes));
        return std::nullopt;
      case Form::kAdd:
      case Form::kSub: {
        if (is_real(type) || bytes > 4) break;
        const Interval x = range(state, w[2], bytes);
        const Interval y = range(state, w[3], bytes);
        const bool adds = instruction.operation.form == Form::kAdd;
        const Interval sum =
            adds ? Interval{x.least + y.least, x.most + y.most} : Interval{x.least - y.most, x.most - y.least};
        const Interval all = any(bytes);
        set(state, w[1], bytes, sum.least < all.least || sum.most > all.most ? all : sum);
        return std::nullopt;
      }
      case Form::kCompareJumpUnless:
      case Form::kCompareJumpIf: {
        const bool jumps_if = instruction.operation.form == Form::kCompareJumpIf;
        State jumped = state;
        compare(jumped, instruction, jumps_if);
        compare(state, instruction, !jumps_if);
        if (!possible(jumped)) return std::nullopt;
        return jumped;
      }
      default:
        break;
    }
    for (const Access& access : loop_.accesses(i)) {
      if (access.write) set(state, access.operand, access.bytes, any(4));
    }
    return std::nullopt;
  }
  [[nodiscard]] static bool possible(const State& state) {
    return std::none_of(state.begin(), state.end(), [](const Interval& range) { return range.is_empty(); });
  }
  bool join(State& into, const State& from, bool back, std::size_t) const {
    bool changed = false;
    for (std::size_t v = 0; v < into.size(); ++v) {
      Interval joined{std::min(into[v].least, from[v].least), std::max(into[v].most, from[v].most)};
      if (joined == into[v]) continue;
      if (back) joined = widened(into[v], joined, any(variables_[v].bytes));
      into[v] = joined;
      changed = true;
    }
    return changed;
  }

 private:
  struct Variable {
    std::uint32_t operand = 0;
    unsigned bytes = 0;
  };
  static Interval any(std::uint64_t bytes) {
    if (bytes > 4) return {std::numeric_limits<std::int64_t>::min() / 4, std::numeric_limits<std::int64_t>::max() / 4};
    const std::int64_t end = std::int64_t{1} << (8 * bytes - 1);
    return {-end, end - 1};
  }
  [[nodiscard]] State anything() const {
    State state;
    for (const Variable& variable : variables_) state.push_back(any(variable.bytes));
    return state;
  }
  /// A constant of up to four bytes.
  [[nodiscard]] std::optional<std::int64_t> number(std::uint32_t operand, unsigned bytes) const {
    if (bytes > 4) return std::nullopt;
    const auto known = emitter_.constant(operand, bytes);
    if (!known) return std::nullopt;
    const unsigned unused = 64 - 8 * bytes;
    return static_cast<std::int64_t>(*known << unused) >> unused;
  }
  /// Also forgets what overlaps with it, which before the loop something may.
  void set(State& state, std::uint32_t operand, std::uint64_t bytes, const Interval& range) const {
    for (std::size_t v = 0; v < variables_.size(); ++v) {
      const Variable& variable = variables_[v];
      if (variable.operand == operand && variable.bytes == bytes) {
        const Interval all = any(bytes);
        state[v] = range.least < all.least || range.most > all.most ? all : range;
      } else if (variable.operand < operand + bytes && operand < variable.operand + variable.bytes) {
        state[v] = any(variable.bytes);
      }
    }
  }
  /// The comparison gave `result`.
  void compare(State& state, const Instruction& i, bool result) const {
    const Type type = i.operation.type;
    const unsigned bytes = bytes_of(type);
    Relation relation = i.operation.relation;
    if (!is_real(type) && bytes <= 4) {
      Interval x = range(state, i.words[2], bytes);
      Interval y = range(state, i.words[3], bytes);
      const bool ordered = is_signed(type) || (x.least >= 0 && y.least >= 0);
      if (!result) relation = opposite(relation);
      if (relation == Relation::kEq) {
        x = y = {std::max(x.least, y.least), std::min(x.most, y.most)};
      } else if (ordered && (relation == Relation::kLt || relation == Relation::kLe)) {
        narrow(x, y, relation == Relation::kLt ? 1 : 0);
      } else if (ordered && (relation == Relation::kGt || relation == Relation::kGe)) {
        narrow(y, x, relation == Relation::kGt ? 1 : 0);
      }
      limit(state, i.words[2], bytes, x);
      limit(state, i.words[3], bytes, y);
    }
    set(state, i.words[1], 1, {result, result});
  }
  static Relation opposite(Relation relation) {
    switch (relation) {
      case Relation::kEq:
        return Relation::kNe;
      case Relation::kNe:
        return Relation::kEq;
      case Relation::kLt:
        return Relation::kGe;
      case Relation::kLe:
        return Relation::kGt;
      case Relation::kGt:
        return Relation::kLe;
      case Relation::kGe:
        break;
    }
    return Relation::kLt;
  }
  /// x + distance <= y
  static void narrow(Interval& x, Interval& y, std::int64_t distance) {
    x.most = std::min(x.most, y.most - distance);
    y.least = std::max(y.least, x.least + distance);
  }
  void limit(State& state, std::uint32_t operand, unsigned bytes, const Interval& range) const {
    for (std::size_t v = 0; v < variables_.size(); ++v) {
      if (variables_[v].operand == operand && variables_[v].bytes == bytes) state[v] = range;
    }
  }
  /// A range that grew, up to the next stops: it does not grow in small steps.
  [[nodiscard]] Interval widened(const Interval& old, const Interval& grown, const Interval& all) const {
    Interval range = grown;
    if (grown.most > old.most) {
      const auto stop = std::lower_bound(stops_.begin(), stops_.end(), grown.most);
      range.most = stop == stops_.end() ? all.most : std::min(*stop, all.most);
    }
    if (grown.least < old.least) {
      const auto above = std::upper_bound(stops_.begin(), stops_.end(), grown.least);
      range.least = above == stops_.begin() ? all.least : std::max(*std::prev(above), all.least);
    }
    return range;
  }

  const Emitter& emitter_;
  const LoopCode& loop_;
  std::vector<Variable> variables_;
  std::vector<std::int64_t> stops_;
};

/// Indices that lie within their arrays.
std::uint32_t inside(const Integers& integers, const Integers::State& state, const Instruction& i) {
  const std::uint32_t* index = nullptr;
  std::uint32_t count = 1;
  switch (i.operation.form) {
    case Form::kLoadElement:
    case Form::kStoreElement:
      index = i.words + 3;
      break;
    case Form::kLoadPath:
    case Form::kStorePath:
      count = i.words[4];
      index = i.words + 5;
      break;
    default:
      return 0;
  }
  std::uint32_t found = 0;
  for (std::uint32_t n = 0; n < std::min(count, 32u); ++n, index += runtime::kIndexWords) {
    const auto rep = static_cast<core::Rep>(index[5]);
    const unsigned bytes = core::rep_bytes(rep);
    if (bytes > 4) continue;
    const Interval range = integers.range(state, index[0], bytes);
    const bool is_signed = rep == core::Rep::kI8 || rep == core::Rep::kI16 || rep == core::Rep::kI32;
    const auto lower = runtime::load<std::int64_t>(index + 3);
    if (!is_signed && range.least < 0) continue;
    if (lower != static_cast<std::int32_t>(lower)) continue;
    if (range.least >= lower && range.most - lower < std::int64_t{index[1]}) found |= 1u << n;
  }
  return found;
}

/// The BOOLs of comparisons with a jump that are not read in the loop.
std::vector<std::uint32_t> unread_results(const Emitter& emitter, const LoopCode& loop,
                                          std::span<const LoopVariable> variables) {
  std::vector<std::uint32_t> found;
  for (const LoopVariable& variable : variables) {
    if (variable.bytes == 1 && variable.written && !variable.real) found.push_back(variable.operand);
  }
  for (std::size_t i = loop.first(); i <= loop.last() && !found.empty(); ++i) {
    const Form form = loop.at(i).operation.form;
    const bool compares = form == Form::kCompareJumpUnless || form == Form::kCompareJumpIf;
    for (const Access& access : loop.accesses(i)) {
      if (compares && access.write && !loop.is_choice(emitter, i)) continue;
      std::erase(found, access.operand);
    }
  }
  return found;
}

void find_ranges(const Emitter& emitter, const LoopCode& code, std::span<const LoopVariable> variables,
                 LoopRanges& facts) {
  Integers integers(emitter, code, variables);
  Walk walk(code, integers);
  if (!walk.run(integers.entry())) return;
  // A result is known where the loop is left, or it is written where it is made.
  std::vector<std::uint32_t> unread = unread_results(emitter, code, variables);
  const auto known = [&](const Integers::State& state, std::uint32_t operand) {
    const Interval range = integers.range(state, operand, 1);
    return range == Interval{0, 0} || range == Interval{1, 1};
  };
  const auto ends = [&](std::size_t i) {
    const Form form = code.at(i).operation.form;
    return form == Form::kLoopJump || form == Form::kReturn;
  };
  std::erase_if(unread, [&](std::uint32_t operand) {
    for (std::size_t i = code.first(); i <= code.last(); ++i) {
      if (ends(i) && walk.before(i) && !known(*walk.before(i), operand)) return true;
    }
    return std::any_of(walk.exits().begin(), walk.exits().end(),
                       [&](const auto& exit) { return !known(exit.second, operand); });
  });
  const auto results = [&](const Integers::State& state) {
    std::vector<std::pair<std::uint32_t, bool>> found;
    for (const std::uint32_t operand : unread) found.emplace_back(operand, integers.range(state, operand, 1).most == 1);
    return found;
  };
  for (std::size_t i = code.first(); i <= code.last(); ++i) {
    if (!walk.before(i)) continue;
    InstructionRanges& of = facts.instructions[i - code.first()];
    const Instruction instruction = code.at(i);
    of.known.inside = inside(integers, *walk.before(i), instruction);
    if (ends(i)) of.end.results = results(*walk.before(i));
  }
  for (std::size_t i = code.first(); i <= code.last(); ++i) {
    const Instruction instruction = code.at(i);
    const Form form = instruction.operation.form;
    if (form != Form::kCompareJumpUnless && form != Form::kCompareJumpIf) continue;
    facts.instructions[i - code.first()].known.unread =
        std::find(unread.begin(), unread.end(), instruction.words[1]) != unread.end();
  }
  for (const auto& [position, state] : walk.exits()) facts.exits[position].results = results(state);
  facts.unread = std::move(unread);
}

/// Real arithmetic whose second operand is the element that the instruction before it loads, in counted loops
/// where nothing else reads that.
void find_passed_elements(const LoopCode& code, const Loop& loop, LoopRanges& facts) {
  const auto touches = [&](std::size_t i, std::uint32_t operand) {
    const std::vector<Access> accesses = code.accesses(i);
    return std::any_of(accesses.begin(), accesses.end(),
                       [operand](const Access& access) { return access.operand == operand; });
  };
  const auto is_inside = [](const Instruction& load, const Known& known) {
    if (load.operation.form == Form::kLoadElement) return known.inside == 1;
    constexpr std::uint32_t kFew = 8;
    return load.operation.form == Form::kLoadPath && load.words[4] <= kFew && known.inside == (1u << load.words[4]) - 1;
  };
  for (const Loop::Inner& inner : loop.inner) {
    if (!inner.counts) continue;
    for (std::size_t i = inner.first; i + 3 < inner.last; ++i) {
      const Instruction load = code.at(i), next = code.at(i + 1);
      Known& known = facts.instructions[i - code.first()].known;
      if (!is_inside(load, known) || !is_real(next.operation.type)) continue;
      const std::uint32_t element = load.words[1];
      const Form form = next.operation.form;
      const bool computes = form == Form::kAdd || form == Form::kSub || form == Form::kMul || form == Form::kDiv;
      if (!computes || next.words[3] != element || next.words[2] == element || next.words[1] == element) continue;
      if (!facts.instructions[i + 1 - code.first()].before.empty()) continue;
      known.passes_on = true;
      for (std::size_t n = inner.first; n <= inner.last; ++n) {
        if (n != i && n != i + 1 && touches(n, element)) known.passes_on = false;
      }
    }
  }
}

}  // namespace

LoopRanges analyse_ranges(const Emitter& emitter, const std::uint32_t* code, std::span<const LinkedInstruction> body,
                          const Loop& loop) {
  LoopRanges facts;
  facts.instructions.resize(loop.last - loop.first + 1);
  if (facts.instructions.size() > kMostInstructions) return facts;
  const LoopCode known(code, body, loop);
  find_ranges(emitter, known, loop.variables, facts);
  find_non_canonical_reals(emitter, known, loop.variables, facts);
  find_passed_elements(known, loop, facts);
  return facts;
}

}  // namespace plc::native
