#include "runtime/link_choices.h"

#include <algorithm>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "runtime/link_operand.h"
#include "runtime/link_pairs.h"
#include "runtime/operations.h"
#include "runtime/value_runs.h"

namespace plc::runtime {
namespace {

/// What both branches compute and what is chosen is at most that much: a jump that is predicted costs less than more.
constexpr std::size_t kMostComputed = 4, kMostChosen = 4;
/// Of a loop that is copied: in longer rounds one jump costs little.
constexpr std::size_t kMostInstructions = 256;
/// Of a body that stands several times.
constexpr std::size_t kMostBodyWords = 128;

struct JumpForm {
  std::uint32_t target = 0;              ///< its word that is the target
  std::uint32_t condition = 0;           ///< its word that is a BOOL; 0: none
  bool when = false;                     ///< jumps when the BOOL is that
  std::optional<ResolvedOp> comparison;  ///< that is one with it
};

std::optional<JumpForm> jump_form(ResolvedOp op) {
  switch (op) {
    case ResolvedOp::kJump:
    case ResolvedOp::kLoopJump:
      return JumpForm{1, 0, false, std::nullopt};
    case ResolvedOp::kCondJump:
      return JumpForm{2, 1, false, std::nullopt};
    case ResolvedOp::kJumpIf:
      return JumpForm{2, 1, true, std::nullopt};
#define PLC_FUSED_JUMP(Name, T, expression)            \
  case ResolvedOp::k##Name##Unless:                    \
    return JumpForm{4, 1, false, ResolvedOp::k##Name}; \
  case ResolvedOp::k##Name##If:                        \
    return JumpForm{4, 1, true, ResolvedOp::k##Name};
#include "runtime/fused_jumps.def"
    default:
      return std::nullopt;
  }
}

/// An IF: instructions from..to of each branch, the one behind it.
struct Choice {
  std::size_t first[2] = {}, last[2] = {};  ///< where the jump is not taken, where it is taken
  std::size_t next = 0;
};

class ChoiceLinker {
 public:
  ChoiceLinker(std::vector<std::uint32_t>& words, LinkedCode& code, std::uint32_t scratch)
      : words_(words), code_(code), scratch_(scratch) {}

  void link(const LinkedLoop& loop) {
    if (words_[loop.position + 1] != loop.position + 2) return;  // runs instruction by instruction
    if (loop.last - loop.first > kMostInstructions) return;
    addressing_ = loop.addressing;
    const auto list = std::span(code_.instructions);
    for (std::size_t i = loop.first; i <= loop.last; ++i) {
      const ResolvedOp op = list[i].op;
      // These know where they lie.
      if (op == ResolvedOp::kStretch || op == ResolvedOp::kBoolRun4 || op == ResolvedOp::kBoolRun5) return;
    }
    const std::uint32_t start = position();
    const std::size_t marks = code_.marks.size(), arranged = code_.arranged.size();
    copies_.clear();
    jumps_.clear();
    last_ = loop.last;
    const std::uint64_t converted = put_instructions(loop.first, loop.last + 1);
    if (converted == 0) {
      words_.resize(start);
      code_.marks.resize(marks);
      code_.arranged.resize(arranged);
      return;
    }
    code_.report.choices += converted;
    const std::size_t left = jumps_.size();
    for (const std::uint32_t at : jumps_) {
      if (const auto copied = copies_.find(words_[at]); copied != copies_.end()) words_[at] = copied->second;
    }
    // Of the loop itself: out of it, and back.
    const std::uint32_t body = copies_.at(list[loop.last].position) - start;
    const auto count = left == 2 && body <= kMostBodyWords ? count_of(loop) : std::nullopt;
    words_[loop.position + 1] = count ? put_rounds(loop, *count, start) : start;
  }

 private:
  /// How a loop counts, whose body may stand several times with one look at the loop budget.
  struct Count {
    CountForm form;
    std::uint32_t control = 0, limit = 0, step = 0;  ///< operands
    bool seen = false;                               ///< the body looks at the control variable
  };

  /// Nothing that leaves the loop, calls, or touches what counts.
  [[nodiscard]] std::optional<Count> count_of(const LinkedLoop& loop) const {
    const auto list = std::span(code_.instructions);
    if (loop.last < loop.first + 3 || list[loop.last].op != ResolvedOp::kLoopJump) return std::nullopt;
    const std::size_t compares = loop.last - 2, counts = loop.last - 1;
    const auto form = count_form(list[compares].op, list[counts].op);
    if (!form || word(compares, 2) != word(counts, 1) || word(counts, 2) != word(counts, 1)) return std::nullopt;
    if (word(loop.last, 1) != list[loop.first].position) return std::nullopt;
    Count count{*form, word(counts, 1), word(compares, 3), word(counts, 3), false};
    const std::uint64_t bytes = form->bytes;
    const OperandRange going{word(compares, 1), 1}, control{count.control, bytes}, limit{count.limit, bytes},
        step{count.step, bytes};
    // The body may write what says whether it goes on, as comparisons of its IFs do: nobody reads that before the
    // loop's own comparison writes it.
    const auto counted = [&](const OperandRange& range) {
      return range.overlaps(control) || range.overlaps(limit) || range.overlaps(step);
    };
    const bool apart = !going.overlaps(control) && !going.overlaps(limit) && !going.overlaps(step) &&
                       !control.overlaps(limit) && !control.overlaps(step);
    if (!apart) return std::nullopt;
    for (std::size_t i = loop.first; i != compares; ++i) {
      // Jumps are those of IFs, which read a BOOL or compare; in the copy, nothing is left of them but that.
      const auto jump = jump_form(list[i].op);
      if (jump && !jump->comparison) {
        if (jump->condition != 0 && going.overlaps({word(i, jump->condition), 1})) return std::nullopt;
        continue;
      }
      const ValueOp* const op = value_op(jump ? *jump->comparison : list[i].op);
      if (op == nullptr) return std::nullopt;
      if (counted({word(i, op->first), op->out_bytes})) return std::nullopt;
      for (std::uint32_t in = 0; in < op->inputs; ++in) {
        const OperandRange read{word(i, op->first + 1u + in), op->in_bytes[in]};
        if (read.overlaps(going)) return std::nullopt;
        if (read.overlaps(control)) count.seen = true;
      }
    }
    return count;
  }

  /// Returns where they begin. `single`: the loop round by round.
  std::uint32_t put_rounds(const LinkedLoop& loop, const Count& count, std::uint32_t single) {
    const auto list = std::span(code_.instructions);
    const std::uint32_t start = position();
    const std::size_t compares = loop.last - 2, counts = loop.last - 1;
    mark(list[loop.first].position);
    put(count.form.rounds);
    ++code_.report.rounds;
    words_.insert(words_.end(), {count.control, count.limit, count.step, count.seen ? 0u : 1u, single});
    for (std::uint32_t round = 1; round <= kRoundsAtOnce; ++round) {
      put_instructions(loop.first, compares);
      if (count.seen && round != kRoundsAtOnce) put_instructions(counts, loop.last);
    }
    put_instructions(compares, loop.last + 1);
    words_.back() = start;
    return start;
  }

  /// Copies of instructions first..end, IFs as choices; returns how many.
  std::uint64_t put_instructions(std::size_t first, std::size_t end) {
    const auto list = std::span(code_.instructions);
    std::uint64_t converted = 0;
    for (std::size_t i = first; i < end;) {
      copies_.emplace(list[i].position, position());
      mark(list[i].position);
      if (const auto choice = choice_at(i, last_); choice && convert(i, *choice)) {
        i = choice->next;
        ++converted;
        continue;
      }
      copy(list[i], i == last_ ? list[i].position + 2 : list[i + 1].position);
      ++i;
    }
    return converted;
  }

  [[nodiscard]] std::uint32_t position() const { return static_cast<std::uint32_t>(words_.size()); }
  [[nodiscard]] std::uint32_t word(std::size_t instruction, std::uint32_t i) const {
    return words_[code_.instructions[instruction].position + i];
  }
  /// What is put next stands for the instruction at `original`.
  void mark(std::uint32_t original) {
    CodeMark mark = mark_at(code_.marks, original);
    mark.position = position();
    code_.marks.push_back(mark);
  }
  void put(ResolvedOp op) {
    code_.arranged.push_back({position(), op});
    words_.push_back(handler_word(addressing_, op));
  }
  void copy(const LinkedInstruction& instruction, std::uint32_t end) {
    if (const auto jump = jump_form(instruction.op)) jumps_.push_back(position() + jump->target);
    code_.arranged.push_back({position(), instruction.op});
    for (std::uint32_t at = instruction.position; at != end; ++at) words_.push_back(words_[at]);
  }

  /// The number of the instruction at `position`, between `from` and `last`.
  [[nodiscard]] std::optional<std::size_t> instruction_at(std::uint32_t position, std::size_t from,
                                                          std::size_t last) const {
    for (std::size_t i = from; i <= last; ++i) {
      if (code_.instructions[i].position == position) return i;
    }
    return std::nullopt;
  }
  /// The IF that the jump `at` makes, if its branches only compute.
  [[nodiscard]] std::optional<Choice> choice_at(std::size_t at, std::size_t last) const {
    const auto form = jump_form(code_.instructions[at].op);
    if (!form || form->condition == 0) return std::nullopt;
    const auto target = instruction_at(word(at, form->target), at + 1, last);
    if (!target) return std::nullopt;
    Choice choice;
    choice.first[0] = at + 1;
    choice.last[0] = choice.first[1] = choice.last[1] = choice.next = *target;
    if (*target > at + 1 && code_.instructions[*target - 1].op == ResolvedOp::kJump) {
      const auto next = instruction_at(word(*target - 1, 1), *target, last);
      if (!next) return std::nullopt;
      choice.last[0] = *target - 1;
      choice.last[1] = choice.next = *next;
    }
    std::size_t computed = 0;
    for (int branch = 0; branch < 2; ++branch) {
      for (std::size_t i = choice.first[branch]; i != choice.last[branch]; ++i, ++computed) {
        if (value_op(code_.instructions[i].op) == nullptr) return std::nullopt;
      }
    }
    if (computed == 0 || computed > kMostComputed) return std::nullopt;
    return choice;
  }

  /// What is written is the same bytes as what else is used, or other bytes; the condition is only read.
  [[nodiscard]] bool is_plain(const Choice& choice, const OperandRange& condition) const {
    std::vector<OperandRange> written, all{condition};
    for (int branch = 0; branch < 2; ++branch) {
      for (std::size_t i = choice.first[branch]; i != choice.last[branch]; ++i) {
        const ValueOp& op = *value_op(code_.instructions[i].op);
        written.push_back({word(i, op.first), op.out_bytes});
        for (std::uint32_t in = 0; in < op.inputs; ++in) all.push_back({word(i, op.first + 1u + in), op.in_bytes[in]});
      }
    }
    all.insert(all.end(), written.begin(), written.end());
    return std::all_of(written.begin(), written.end(), [&](const OperandRange& range) {
      return !range.overlaps(condition) && std::all_of(all.begin(), all.end(), [&](const OperandRange& other) {
        return range == other || !range.overlaps(other);
      });
    });
  }

  /// A value of a branch, in scratch memory.
  struct Value {
    std::size_t instruction = 0;
    std::vector<std::uint32_t> in;  ///< operands of its inputs
    std::uint32_t uses = 0;
  };
  [[nodiscard]] std::uint32_t place_of(std::size_t value) const {
    return scratch_ + 8 * static_cast<std::uint32_t>(value);
  }
  /// The one that lies there, if any.
  Value* value_at(std::uint32_t operand) {
    return operand < scratch_ || operand >= place_of(values_.size()) ? nullptr : &values_[(operand - scratch_) / 8];
  }
  std::uint32_t use(std::uint32_t operand) {
    if (Value* const value = value_at(operand)) ++value->uses;
    return operand;
  }

  /// Where the value of an instruction is going to lie, with what its branch has assigned so far.
  std::uint32_t value_of(std::size_t instruction, const std::map<std::uint32_t, std::uint32_t>& now) {
    const ResolvedOp kind = code_.instructions[instruction].op;
    const ValueOp& op = *value_op(kind);
    Value value{instruction, {}, 0};
    for (std::uint32_t i = 0; i < op.inputs; ++i) {
      const std::uint32_t operand = word(instruction, op.first + 1u + i);
      const auto known = now.find(operand);
      value.in.push_back(known == now.end() ? operand : known->second);
    }
    const auto same = std::find_if(values_.begin(), values_.end(), [&](const Value& v) {
      return code_.instructions[v.instruction].op == kind && v.in == value.in;
    });
    const auto number = static_cast<std::size_t>(same - values_.begin());
    if (same == values_.end()) {
      for (const std::uint32_t operand : value.in) use(operand);
      values_.push_back(std::move(value));
    }
    return place_of(number);
  }
  void compute(const Value& value, std::uint32_t out) {
    const ResolvedOp kind = code_.instructions[value.instruction].op;
    put(kind);
    for (std::uint32_t i = 1; i < value_op(kind)->first; ++i) words_.push_back(word(value.instruction, i));
    words_.push_back(out);
    words_.insert(words_.end(), value.in.begin(), value.in.end());
  }
  /// The comparison, which was put last, and an AND in front of it are one step. Returns where, if they are.
  std::optional<std::uint32_t> join_test(ResolvedOp comparison) {
    const std::uint32_t second = position() - 4, first = second - 4;
    if (code_.arranged.size() < 2) return std::nullopt;
    const LinkedInstruction& before = code_.arranged[code_.arranged.size() - 2];
    const auto test = test_op(before.op, comparison);
    if (!test || before.position != first || words_[first + 1] != words_[second + 2]) return std::nullopt;
    words_[first] = handler_word(addressing_, *test);
    code_.arranged.push_back({first, *test});
    return first;
  }
  /// The test of bits at `first`, a shift of the same word, and what assigns the word and the temporary of both, which
  /// were put last, are one step.
  void join_feedback(std::uint32_t first) {
    constexpr std::uint32_t kTestWords = 8, kShiftWords = 7, kMixWords = 6, kSelectWords = 8;
    const std::uint32_t shift = first + kTestWords, mix = shift + kShiftWords, select = mix + kMixWords;
    auto& put = code_.arranged;
    if (put.size() < 4 || position() != select + kSelectWords) return;
    auto* const test_put = &put[put.size() - 4];
    auto *const shift_put = test_put + 1, *const mix_put = test_put + 2, *const select_put = test_put + 3;
    if (test_put->position != first || shift_put->position != shift) return;
    if (select_put->position == mix + kSelectWords) {
      // Neither reads what the other assigns, see at_once.
      std::rotate(words_.begin() + mix, words_.begin() + mix + kSelectWords, words_.end());
      *select_put = {select, std::exchange(mix_put->op, select_put->op)};
    }
    const auto op = feedback_op(test_put->op, shift_put->op, mix_put->op);
    if (!op || mix_put->position != mix || select_put->position != select) return;
    const std::uint64_t bytes = value_op(shift_put->op)->out_bytes;
    if (select_put->op != of_size(ResolvedOp::kSelect8, static_cast<std::uint32_t>(bytes))) return;
    if (words_[first + 2] != words_[shift + 5]) std::swap(words_[first + 2], words_[first + 3]);
    const std::uint32_t shifted = words_[shift + 4];
    if (words_[mix + 3] != shifted) std::swap(words_[mix + 3], words_[mix + 4]);
    const std::uint32_t kept = words_[first + 1], word = words_[first + 2], expected = words_[first + 7];
    const std::uint32_t condition = words_[first + 5], taps = words_[mix + 4], out = words_[mix + 1];
    const bool mixes = words_[mix + 2] == condition && words_[mix + 3] == shifted && words_[mix + 5] == shifted;
    const bool keeps = words_[select + 4] == kept && words_[select + 5] == condition && words_[select + 6] == kept &&
                       words_[select + 7] == shifted;
    if (!mixes || !keeps || taps == shifted || word != words_[shift + 5]) return;
    const OperandRange temporary{kept, bytes};
    for (const std::uint32_t other : {word, expected, taps, out}) {
      if (temporary.overlaps({other, bytes})) return;
    }
    if (OperandRange{word, bytes}.overlaps({condition, 1})) return;
    words_[first] = handler_word(addressing_, *op);
    put.push_back({first, *op});
  }

  bool convert(std::size_t at, const Choice& choice) {
    const JumpForm form = *jump_form(code_.instructions[at].op);
    const OperandRange condition{word(at, form.condition), 1};
    if (!is_plain(choice, condition)) return false;
    std::map<std::uint32_t, std::uint32_t> chosen;  // bytes by operand
    for (int branch = 0; branch < 2; ++branch) {
      for (std::size_t i = choice.first[branch]; i != choice.last[branch]; ++i) {
        const ValueOp& op = *value_op(code_.instructions[i].op);
        chosen.emplace(word(i, op.first), op.out_bytes);
      }
    }
    if (chosen.size() > kMostChosen) return false;
    std::optional<std::uint32_t> test;
    if (form.comparison) {
      put(*form.comparison);
      for (std::uint32_t i = 1; i <= 3; ++i) words_.push_back(word(at, i));
      test = join_test(*form.comparison);
    }
    values_.clear();
    std::map<std::uint32_t, std::uint32_t> now[2];  // where what a branch assigns lies, by operand
    for (int branch = 0; branch < 2; ++branch) {
      for (std::size_t i = choice.first[branch]; i != choice.last[branch]; ++i) {
        const ValueOp& op = *value_op(code_.instructions[i].op);
        now[branch].insert_or_assign(word(i, op.first), value_of(i, now[branch]));
      }
    }
    struct Assigned {
      std::uint32_t operand = 0, bytes = 0;
      std::uint32_t from[2] = {};  ///< where the condition is FALSE, TRUE
    };
    std::vector<Assigned> assigned;
    for (const auto& [operand, bytes] : chosen) {
      const auto of = [&](bool taken) {
        const auto value = now[taken ? 1 : 0].find(operand);
        return use(value == now[taken ? 1 : 0].end() ? operand : value->second);
      };
      assigned.push_back({operand, bytes, {of(!form.when), of(form.when)}});
    }
    // What only one assignment uses is computed with it, unless another assignment comes before what it reads.
    const auto at_once = [&](const Assigned& a) -> const Value* {
      const Value* const value = value_at(a.from[1]);
      if (value == nullptr || value->uses != 1 || !when_op(code_.instructions[value->instruction].op)) return nullptr;
      const bool early = std::any_of(value->in.begin(), value->in.end(),
                                     [&](std::uint32_t in) { return in != a.operand && chosen.count(in) != 0; });
      return early ? nullptr : value;
    };
    std::vector<const Value*> joined;
    for (const Assigned& a : assigned) joined.push_back(at_once(a));
    for (std::size_t v = 0; v < values_.size(); ++v) {
      if (std::find(joined.begin(), joined.end(), &values_[v]) == joined.end()) compute(values_[v], place_of(v));
    }
    for (std::size_t i = 0; i < assigned.size(); ++i) {
      const Assigned& a = assigned[i];
      if (joined[i] != nullptr) {
        put(*when_op(code_.instructions[joined[i]->instruction].op));
        words_.insert(words_.end(), {a.operand, condition.operand, joined[i]->in[0], joined[i]->in[1], a.from[0]});
        continue;
      }
      put(of_size(ResolvedOp::kSelect8, a.bytes));
      // As CALL_STD: kernel (2) and number of arguments, which nobody reads.
      words_.insert(words_.end(), {0, 0, 3, a.operand, condition.operand, a.from[0], a.from[1]});
    }
    if (test) join_feedback(*test);
    return true;
  }

  std::vector<std::uint32_t>& words_;
  LinkedCode& code_;
  std::uint32_t scratch_;
  Addressing addressing_ = Addressing::kFixed;
  std::map<std::uint32_t, std::uint32_t> copies_;  ///< positions of copied instructions, by those they were copied of
  std::vector<std::uint32_t> jumps_;               ///< positions of targets
  std::vector<Value> values_;                      ///< of the IF at hand, each behind what it uses
  std::size_t last_ = 0;                           ///< instruction of the loop at hand
};

}  // namespace

void link_choices(std::vector<std::uint32_t>& words, LinkedCode& code, std::uint32_t scratch) {
  ChoiceLinker linker(words, code, scratch);
  for (const LinkedLoop& loop : code.loops) linker.link(loop);
}

}  // namespace plc::runtime
