#include "runtime/loop_plan.h"

#include <algorithm>
#include <cstring>

#include "runtime/link.h"
#include "runtime/loop_run.h"
#include "runtime/value_runs.h"

namespace plc::runtime {
namespace {

class Writer {
 public:
  Writer(std::vector<std::uint32_t>& words, const LoopPlan& plan) : words_(words), plan_(plan) {}

  std::uint32_t write(Addressing addressing, std::uint32_t scratch) {
    const auto start = static_cast<std::uint32_t>(words_.size());
    const auto size = [](const auto& list) { return static_cast<std::uint32_t>(list.size()); };
    // Where an index leaves its array, the rounds are not to be known: the loop is left to its code.
    std::optional<LoopPlan::KnownRounds> rounds = plan_.rounds;
    if (!std::all_of(plan_.elements.begin(), plan_.elements.end(),
                     [&](const LoopPlan::Element* e) { return begin_of(*e, rounds); })) {
      rounds.reset();
    }
    std::uint32_t indices[4] = {};
    for (const LoopPlan::Element* element : plan_.elements) {
      for (const LoopPlan::Index& index : element->indices) ++indices[static_cast<std::size_t>(by(index))];
    }
    if (rounds) indices[static_cast<std::size_t>(By::kControl)] = 0;
    const LoopPlan::KnownRounds known = rounds.value_or(LoopPlan::KnownRounds{});
    const auto of_4_bytes = std::count_if(plan_.last_values.begin(), plan_.last_values.end(),
                                          [](const LoopPlan::LastValue& value) { return value.bytes == 4; });
    words_.insert(words_.end(), {handler_word(addressing, ResolvedOp::kLoopRun),
                                 plan_.head,
                                 plan_.exit,
                                 plan_.jump,
                                 plan_.control,
                                 plan_.limit,
                                 plan_.step,
                                 static_cast<std::uint32_t>(plan_.result.operand),
                                 (plan_.wide ? kWide : 0) | (plan_.down ? kDown : 0) | (rounds ? kKnown : 0),
                                 static_cast<std::uint32_t>(known.start),
                                 static_cast<std::uint32_t>(known.added),
                                 static_cast<std::uint32_t>(known.jumps),
                                 size(plan_.values),
                                 size(plan_.variables) + size(plan_.elements),
                                 size(plan_.elements),
                                 indices[0],
                                 indices[1],
                                 indices[2],
                                 indices[3],
                                 size(plan_.records),
                                 static_cast<std::uint32_t>(of_4_bytes),
                                 size(plan_.last_values) - static_cast<std::uint32_t>(of_4_bytes),
                                 size(plan_.last_computed),
                                 scratch});
    words_.insert(words_.end(), plan_.values.begin(), plan_.values.end());
    for (const std::uint32_t operand : plan_.variables) words_.insert(words_.end(), {operand, 0});
    for (const LoopPlan::Element* element : plan_.elements) {
      const Begin begin = *begin_of(*element, rounds);
      words_.insert(words_.end(), {begin.operand, static_cast<std::uint32_t>(begin.step)});
    }
    if (!rounds) put_indices(By::kControl);
    for (const By kind : {By::kVariable, By::kBoth, By::kSum}) put_indices(kind);
    for (const LoopPlan::Record& record : plan_.records) {
      put_wide(record.run);
      const auto in = [&](std::size_t i) { return i < record.in.size() ? row(record.in[i]) : 0; };
      words_.insert(words_.end(), {row(record.out), in(0), in(1), in(2), record.arguments, record.position});
    }
    for (const LoopPlan::LastValue& value : plan_.last_values) {
      words_.insert(words_.end(), {value.operand, row(value.stream), value.bytes});
    }
    for (const LoopPlan::LastComputed& computed : plan_.last_computed) {
      put_wide(computed.run);
      words_.push_back(size(computed.operands));
      words_.insert(words_.end(), computed.operands.begin(), computed.operands.end());
    }
    return start;
  }

 private:
  template <class T>
  void put_wide(T value) {
    static_assert(sizeof value == 8);
    std::uint32_t pair[2];
    std::memcpy(pair, &value, sizeof pair);
    words_.insert(words_.end(), {pair[0], pair[1]});
  }
  /// Where the stream stands, in bytes.
  [[nodiscard]] std::uint32_t row(std::uint32_t stream) const {
    const auto kind = static_cast<LoopPlan::StreamKind>(stream >> 16);
    const std::size_t before = kind == LoopPlan::StreamKind::kValue      ? 0
                               : kind == LoopPlan::StreamKind::kVariable ? plan_.values.size()
                                                                         : plan_.values.size() + plan_.variables.size();
    return (static_cast<std::uint32_t>(before) + (stream & 0xffffu)) * std::uint32_t{sizeof(Stream)};
  }

  /// What makes the number of an index; they stand in this order.
  enum class By : std::uint8_t { kControl, kVariable, kBoth, kSum };
  static By by(const LoopPlan::Index& index) {
    const LoopPlan::Affine& number = index.number;
    const std::int64_t start = number.constant - index.lower;
    const bool plain = start == static_cast<std::int32_t>(start) && (number.factor == 0 || number.factor == 1) &&
                       (number.terms.empty() || (number.terms.size() == 1 && number.terms[0].factor == 1));
    if (!plain || (number.factor == 0 && number.terms.empty())) return By::kSum;
    return number.terms.empty() ? By::kControl : number.factor == 0 ? By::kVariable : By::kBoth;
  }
  /// Where the stream of an element begins and how far it steps, but for the indices that it has when it runs: those
  /// of the control variable alone are known where the rounds are.
  struct Begin {
    std::uint32_t operand = 0;
    std::int32_t step = 0;
  };
  static std::optional<Begin> begin_of(const LoopPlan::Element& element,
                                       const std::optional<LoopPlan::KnownRounds>& rounds) {
    std::int64_t offset = 0, step = 0;
    for (const LoopPlan::Index& index : element.indices) {
      if (!rounds || by(index) != By::kControl) continue;
      const std::int64_t first = rounds->start + index.number.constant - index.lower;
      const std::int64_t last = first + rounds->added * rounds->jumps;
      if (std::min(first, last) < 0 || std::max(first, last) >= index.count) return std::nullopt;
      offset += first * index.stride;
      step += rounds->added * index.stride;
    }
    if (step != static_cast<std::int32_t>(step)) return std::nullopt;
    return Begin{static_cast<std::uint32_t>(element.array.operand + offset), static_cast<std::int32_t>(step)};
  }

  void put_index(std::uint32_t stream, const LoopPlan::Index& index) {
    const LoopPlan::Affine& number = index.number;
    const std::int64_t start = number.constant - index.lower;
    words_.insert(words_.end(), {stream, index.count, index.stride});
    if (by(index) != By::kSum) {
      const std::uint32_t operand = number.terms.empty() ? 0 : number.terms[0].operand;
      words_.insert(words_.end(), {static_cast<std::uint32_t>(start), operand, number.bytes});
      return;
    }
    words_.insert(words_.end(),
                  {static_cast<std::uint32_t>(number.factor), static_cast<std::uint32_t>(number.terms.size())});
    put_wide(start);
    for (const LoopPlan::Affine::Term& term : number.terms) {
      words_.insert(words_.end(), {term.operand, static_cast<std::uint32_t>(term.factor), number.bytes});
    }
  }
  void put_indices(By kind) {
    for (std::size_t i = 0; i < plan_.elements.size(); ++i) {
      for (const LoopPlan::Index& index : plan_.elements[i]->indices) {
        if (by(index) == kind) put_index(row(LoopPlan::stream(LoopPlan::StreamKind::kElement, i)), index);
      }
    }
  }

  std::vector<std::uint32_t>& words_;
  const LoopPlan& plan_;
};

}  // namespace

std::uint32_t write_loop_run(std::vector<std::uint32_t>& words, const LoopPlan& plan, Addressing addressing,
                             std::uint32_t scratch) {
  return Writer(words, plan).write(addressing, scratch);
}

}  // namespace plc::runtime
