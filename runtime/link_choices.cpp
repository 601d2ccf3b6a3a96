#include "runtime/link_choices.h"

#include <algorithm>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "runtime/link_operand.h"
#include "runtime/operations.h"
#include "runtime/value_runs.h"

namespace plc::runtime {
namespace {

/// What both branches compute and what is chosen is at most that much: a jump that is predicted costs less than more.
constexpr std::size_t kMostComputed = 4, kMostChosen = 4;
/// Of a loop that is copied: in longer rounds one jump costs little.
constexpr std::size_t kMostInstructions = 256;

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
    const std::size_t words = words_.size(), marks = code_.marks.size(), arranged = code_.arranged.size();
    std::uint64_t converted = 0;
    copies_.clear();
    jumps_.clear();
    const std::uint32_t end = list[loop.last].position + 2;
    for (std::size_t i = loop.first; i <= loop.last;) {
      copies_.emplace(list[i].position, position());
      mark(list[i].position);
      if (const auto choice = choice_at(i, loop.last); choice && convert(i, *choice)) {
        i = choice->next;
        ++converted;
        continue;
      }
      copy(list[i], i == loop.last ? end : list[i + 1].position);
      ++i;
    }
    if (converted == 0) {
      words_.resize(words);
      code_.marks.resize(marks);
      code_.arranged.resize(arranged);
      return;
    }
    for (const std::uint32_t at : jumps_) {
      if (const auto copied = copies_.find(words_[at]); copied != copies_.end()) words_[at] = copied->second;
    }
    words_[loop.position + 1] = static_cast<std::uint32_t>(words);
    code_.report.choices += converted;
  }

 private:
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

  /// A value that is computed already, or the words that compute it.
  std::uint32_t compute(std::size_t instruction, const std::map<std::uint32_t, std::uint32_t>& now) {
    const ResolvedOp kind = code_.instructions[instruction].op;
    const ValueOp& op = *value_op(kind);
    std::vector<std::uint32_t> in{static_cast<std::uint32_t>(kind)};
    for (std::uint32_t i = 0; i < op.inputs; ++i) {
      const std::uint32_t operand = word(instruction, op.first + 1u + i);
      const auto known = now.find(operand);
      in.push_back(known == now.end() ? operand : known->second);
    }
    const auto [known, fresh] = computed_.try_emplace(in, scratch_ + 8 * static_cast<std::uint32_t>(computed_.size()));
    if (!fresh) return known->second;
    put(kind);
    for (std::uint32_t i = 1; i < op.first; ++i) words_.push_back(word(instruction, i));
    words_.push_back(known->second);
    words_.insert(words_.end(), in.begin() + 1, in.end());
    return known->second;
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
    if (form.comparison) {
      put(*form.comparison);
      for (std::uint32_t i = 1; i <= 3; ++i) words_.push_back(word(at, i));
    }
    computed_.clear();
    std::map<std::uint32_t, std::uint32_t> now[2];  // where what a branch assigns lies, by operand
    for (int branch = 0; branch < 2; ++branch) {
      for (std::size_t i = choice.first[branch]; i != choice.last[branch]; ++i) {
        const ValueOp& op = *value_op(code_.instructions[i].op);
        const std::uint32_t value = compute(i, now[branch]);
        now[branch].insert_or_assign(word(i, op.first), value);
      }
    }
    for (const auto& [operand, bytes] : chosen) {
      const auto of = [&](bool taken) {
        const auto value = now[taken ? 1 : 0].find(operand);
        return value == now[taken ? 1 : 0].end() ? operand : value->second;
      };
      put(of_size(ResolvedOp::kSelect8, bytes));
      // As CALL_STD: kernel (2) and number of arguments, which nobody reads.
      words_.insert(words_.end(), {0, 0, 3, operand, condition.operand, of(!form.when), of(form.when)});
    }
    return true;
  }

  std::vector<std::uint32_t>& words_;
  LinkedCode& code_;
  std::uint32_t scratch_;
  Addressing addressing_ = Addressing::kFixed;
  std::map<std::uint32_t, std::uint32_t> copies_;  ///< positions of copied instructions, by those they were copied of
  std::vector<std::uint32_t> jumps_;               ///< positions of targets
  std::map<std::vector<std::uint32_t>, std::uint32_t> computed_;  ///< scratch places by instruction and inputs
};

}  // namespace

void link_choices(std::vector<std::uint32_t>& words, LinkedCode& code, std::uint32_t scratch) {
  ChoiceLinker linker(words, code, scratch);
  for (const LinkedLoop& loop : code.loops) linker.link(loop);
}

}  // namespace plc::runtime
