#include "runtime/link_loops.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "runtime/link_operand.h"
#include "runtime/loop_plan.h"
#include "runtime/loop_run.h"
#include "runtime/operations.h"
#include "runtime/value_runs.h"
#include "stdlib/library.h"

namespace plc::runtime {
namespace {

/// Factors of indices stay small enough for run_loop() to count in 64 bits.
constexpr std::int64_t kMostFactor = 1 << 20;
/// Instructions of a body.
constexpr std::size_t kMostInstructions = 64;

constexpr std::uint32_t kNoStream = 0xffffffffu;

using Affine = LoopPlan::Affine;
using Index = LoopPlan::Index;
using Element = LoopPlan::Element;
using KnownRounds = LoopPlan::KnownRounds;
using LastValue = LoopPlan::LastValue;
using LastComputed = LoopPlan::LastComputed;
using StreamKind = LoopPlan::StreamKind;

/// One instruction of the body.
struct Step {
  const ValueOp* value = nullptr;              ///< one that computes
  const stdlib::Overload* function = nullptr;  ///< a call
  std::optional<Element> element;              ///< a move from or to an element
  std::uint32_t position = 0;
  OperandRange out;              ///< none when it stores an element
  std::vector<OperandRange> in;  ///< without indices
  stdlib::Kernel kernel = nullptr;
};

struct Record : LoopPlan::Record {
  const Step* step = nullptr;  ///< null: counts
  bool of_its_round = false;   ///< reads what its round changes
};

std::optional<std::uint32_t> scalar_bytes(core::TypeId type) {
  const core::Rep rep = core::rep_of(type);
  if (rep > core::Rep::kF64) return std::nullopt;
  return core::rep_bytes(rep);
}

std::optional<unsigned> number_in(ResolvedOp op, ResolvedOp first, unsigned count) {
  const auto number = static_cast<unsigned>(op) - static_cast<unsigned>(first);
  return op >= first && number < count ? std::optional(number) : std::nullopt;
}

/// One loop. Each of its steps says no by returning false.
class LoopLinker {
 public:
  LoopLinker(std::vector<std::uint32_t>& words, LinkedCode& code, const LinkedConstants& constants,
             std::uint32_t scratch)
      : words_(words), code_(code), constants_(constants), scratch_(scratch) {}

  void link(const LinkedLoop& loop) {
    if (!read_end(loop) || !read_body(loop) || !check_variables() || !check_elements() || !make_records()) return;
    leave_out_unread(loop.addressing);
    join_products();
    make_last_round();
    number_streams();
    if (plan_.variables.size() + plan_.values.size() + plan_.elements.size() > kMostStreams) return;
    plan_.records.assign(records_.begin(), records_.end());
    plan_.rounds = known_rounds();
    words_[loop.position + 1] = write_loop_run(words_, plan_, loop.addressing, scratch_);
    code_.arranged.push_back({words_[loop.position + 1], ResolvedOp::kLoopRun});
    ++code_.report.loops;
  }

 private:
  // ---- reading

  [[nodiscard]] std::uint32_t word(const LinkedInstruction& instruction, std::uint32_t i) const {
    return words_[instruction.position + i];
  }

  /// Comparison and way out, counting, jump.
  bool read_end(const LinkedLoop& loop) {
    if (loop.last < loop.first + 3) return false;
    const LinkedInstruction& jump = code_.instructions[loop.last];
    const LinkedInstruction& count = code_.instructions[loop.last - 1];
    const LinkedInstruction& compare = code_.instructions[loop.last - 2];
    plan_.wide = count.op == ResolvedOp::kAdd32 || count.op == ResolvedOp::kSub32;
    plan_.down = count.op == ResolvedOp::kSub16 || count.op == ResolvedOp::kSub32;
    const ResolvedOp counts = plan_.wide ? (plan_.down ? ResolvedOp::kSub32 : ResolvedOp::kAdd32)
                                         : (plan_.down ? ResolvedOp::kSub16 : ResolvedOp::kAdd16);
    const ResolvedOp compares = plan_.wide ? (plan_.down ? ResolvedOp::kGtI32Unless : ResolvedOp::kLtI32Unless)
                                           : (plan_.down ? ResolvedOp::kGtI16Unless : ResolvedOp::kLtI16Unless);
    plan_.control = word(count, 1);
    plan_.step = word(count, 3);
    plan_.limit = word(compare, 3);
    plan_.jump = jump.position;
    plan_.exit = word(compare, 4);
    plan_.head = words_[jump.position + 1];
    first_ = loop.first;
    const std::uint32_t bytes = plan_.wide ? 4 : 2;
    counted_ = {{plan_.control, bytes}, {plan_.step, bytes}, {plan_.limit, bytes}};
    plan_.result = {word(compare, 1), 1};
    return count.op == counts && compare.op == compares && word(count, 2) == plan_.control &&
           word(compare, 2) == plan_.control;
  }

  bool read_body(const LinkedLoop& loop) {
    steps_.clear();
    if (loop.last - loop.first > kMostInstructions) return false;
    for (std::size_t i = loop.first; i + 2 != loop.last; ++i) {
      const LinkedInstruction& instruction = code_.instructions[i];
      if (instruction.op == ResolvedOp::kStretch) continue;
      Step step;
      step.position = instruction.position;
      if (!read_value(instruction, step) && !read_element(instruction, step) && !read_call(instruction, step)) {
        return false;
      }
      steps_.push_back(std::move(step));
    }
    const auto calls = std::count_if(steps_.begin(), steps_.end(), [](const Step& s) { return s.function != nullptr; });
    return !steps_.empty() && calls <= 1;
  }
  bool read_value(const LinkedInstruction& instruction, Step& step) const {
    step.value = value_op(instruction.op);
    if (step.value == nullptr) return false;
    step.out = {word(instruction, step.value->first), step.value->out_bytes};
    for (std::uint32_t i = 0; i < step.value->inputs; ++i) {
      step.in.push_back({word(instruction, step.value->first + 1u + i), step.value->in_bytes[i]});
    }
    return true;
  }
  bool read_element(const LinkedInstruction& instruction, Step& step) const {
    const auto load = number_in(instruction.op, ResolvedOp::kLoadAt8I16, 12);
    const auto store = number_in(instruction.op, ResolvedOp::kStoreAt8I16, 12);
    const auto load_path = number_in(instruction.op, ResolvedOp::kLoadPath8, 4);
    const auto store_path = number_in(instruction.op, ResolvedOp::kStorePath8, 4);
    const bool one = load || store;
    if (!one && !load_path && !store_path) return false;
    Element element;
    element.write = store || store_path;
    element.bytes = 1u << (one ? (load ? *load : *store) / 3 : load_path ? *load_path : *store_path);
    element.array = {word(instruction, 2) + (one ? 0 : word(instruction, 3)), element.bytes};
    std::uint32_t at = one ? 3 : 5;
    for (std::uint32_t n = one ? 1 : word(instruction, 4); n != 0; --n, at += kIndexWords) {
      const auto rep = static_cast<core::Rep>(word(instruction, at + 5));
      if (rep != core::Rep::kI16 && rep != core::Rep::kI32) return false;
      Index index;
      index.count = word(instruction, at + 1);
      index.stride = word(instruction, at + 2);
      index.lower = plc::runtime::load<std::int64_t>(words_.data() + instruction.position + at + 3);
      // Who it is, is found out when what the loop writes is known.
      index.number.terms = {{word(instruction, at), 1}};
      index.number.bytes = core::rep_bytes(rep);
      element.array.bytes += std::uint64_t{index.count == 0 ? 0 : index.count - 1} * index.stride;
      element.indices.push_back(std::move(index));
    }
    const OperandRange value{word(instruction, 1), element.bytes};
    if (element.write) {
      step.in = {value};
    } else {
      step.out = value;
    }
    step.element = std::move(element);
    return !step.element->indices.empty();
  }
  bool read_call(const LinkedInstruction& instruction, Step& step) const {
    if (instruction.op != ResolvedOp::kCallStd || word(instruction, 3) == 0 || word(instruction, 3) > 3) return false;
    step.kernel = load_pointer<stdlib::Kernel>(words_.data() + instruction.position + 1);
    step.function = stdlib::overload_with_kernel(step.kernel);
    if (step.function == nullptr) return false;
    const auto result = scalar_bytes(step.function->result_type());
    if (!result) return false;
    step.out = {word(instruction, 4), *result};
    for (std::uint32_t i = 0; i < word(instruction, 3); ++i) {
      const auto bytes = scalar_bytes(step.function->param_type(i));
      if (!bytes) return false;
      step.in.push_back({word(instruction, 5 + i), *bytes});
    }
    return true;
  }

  // ---- variables

  [[nodiscard]] bool is_written(const OperandRange& range) const {
    return std::any_of(steps_.begin(), steps_.end(), [&](const Step& s) { return s.out.overlaps(range); }) ||
           plan_.result.overlaps(range);
  }
  /// Variables are the same bytes or other bytes; none lies in an array, unless both are only read; the loop counts
  /// with what it does not change.
  [[nodiscard]] bool check_variables() const {
    std::vector<OperandRange> all = counted_;
    all.push_back(plan_.result);
    for (const Step& step : steps_) {
      if (step.out.bytes != 0) all.push_back(step.out);
      all.insert(all.end(), step.in.begin(), step.in.end());
      if (!step.element) continue;
      for (const Index& index : step.element->indices) {
        all.push_back({index.number.terms[0].operand, index.number.bytes});
      }
    }
    for (const OperandRange& range : all) {
      const bool written = is_written(range) || range.overlaps(counted_[0]);
      for (const OperandRange& other : all) {
        if (written && range.overlaps(other) && !(range == other)) return false;
      }
      for (const Step& step : steps_) {
        if (step.element && (written || step.element->write) && step.element->array.overlaps(range)) return false;
      }
    }
    return std::none_of(counted_.begin(), counted_.end(),
                        [this](const OperandRange& range) { return is_written(range); }) &&
           !(counted_[0] == counted_[1]) && !(counted_[0] == counted_[2]);
  }

  // ---- elements

  /// Parts of structures in one array that have nothing in common.
  static bool are_other_parts(const Element& a, const Element& b) {
    if (!a.array.overlaps(b.array)) return true;
    if (a.indices.size() != 1 || b.indices.size() != 1 || a.indices[0].stride != b.indices[0].stride) return false;
    const std::uint32_t stride = a.indices[0].stride;
    if (stride == 0) return false;
    const std::uint32_t behind = (a.array.operand % stride + stride - b.array.operand % stride) % stride;
    return behind >= b.bytes && stride - behind >= a.bytes;
  }
  /// Whether all rounds of `first` may run before all rounds of `second`, which is behind it.
  [[nodiscard]] bool may_split(const Element& first, const Element& second) const {
    if ((!first.write && !second.write) || are_other_parts(first, second)) return true;
    if (first.indices.size() != 1 || second.indices.size() != 1) return false;
    const Index& a = first.indices[0];
    const Index& b = second.indices[0];
    if (first.array.operand != second.array.operand || a.stride != b.stride || a.lower != b.lower ||
        first.bytes != second.bytes || a.stride < first.bytes || a.number.factor != b.number.factor ||
        a.number.terms != b.number.terms) {
      return false;
    }
    // In later rounds, is the first one where the second one has been?
    const std::int64_t ahead = b.number.constant - a.number.constant;
    const std::int64_t per_round = plan_.down ? -a.number.factor : a.number.factor;
    return per_round == 0 ? ahead != 0 : ahead == 0 || (ahead > 0) != (per_round > 0);
  }
  /// Finds out what indices are, and whether elements keep out of each other's way.
  bool check_elements() {
    numbers_.clear();
    for (Step& step : steps_) {
      if (step.element) {
        for (Index& index : step.element->indices) {
          auto number = number_of({index.number.terms[0].operand, index.number.bytes});
          if (!number) return false;
          index.number = std::move(*number);
        }
      }
      if (step.out.bytes != 0) note_number(step);
    }
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      for (std::size_t j = i + 1; j < steps_.size(); ++j) {
        const auto &first = steps_[i].element, &second = steps_[j].element;
        if (first && second && !may_split(*first, *second)) return false;
      }
    }
    return true;
  }
  /// The value of a constant.
  [[nodiscard]] std::optional<std::int64_t> constant_at(const OperandRange& range) const {
    if (range.operand < constants_.at || range.operand - constants_.at + range.bytes > constants_.bytes.size()) {
      return std::nullopt;
    }
    const std::byte* const at = constants_.bytes.data() + (range.operand - constants_.at);
    return range.bytes == 4 ? plc::runtime::load<std::int32_t>(at) : plc::runtime::load<std::int16_t>(at);
  }
  [[nodiscard]] std::optional<Affine> number_of(const OperandRange& range) const {
    Affine number;
    number.bytes = static_cast<std::uint32_t>(range.bytes);
    if (range == counted_[0]) {
      number.factor = 1;
      return number;
    }
    if (const auto known = numbers_.find(range.operand);
        known != numbers_.end() && known->second.bytes == range.bytes) {
      return known->second;
    }
    if (is_written(range)) return std::nullopt;
    if (const auto constant = constant_at(range)) {
      number.constant = *constant;
    } else {
      number.terms = {{range.operand, 1}};
    }
    return number;
  }
  static Affine combined(const Affine& a, std::int64_t times_a, const Affine& b, std::int64_t times_b) {
    Affine sum;
    sum.bytes = a.bytes;
    sum.constant = a.constant * times_a + b.constant * times_b;
    sum.factor = a.factor * times_a + b.factor * times_b;
    std::map<std::uint32_t, std::int64_t> terms;
    for (const Affine::Term& term : a.terms) terms[term.operand] += term.factor * times_a;
    for (const Affine::Term& term : b.terms) terms[term.operand] += term.factor * times_b;
    for (const auto& [operand, factor] : terms) {
      if (factor != 0) sum.terms.push_back({operand, factor});
    }
    return sum;
  }
  static bool is_small(const Affine& number) {
    const auto small = [](std::int64_t factor) { return factor >= -kMostFactor && factor <= kMostFactor; };
    return number.constant == static_cast<std::int32_t>(number.constant) && small(number.factor) &&
           number.terms.size() <= 4 &&
           std::all_of(number.terms.begin(), number.terms.end(), [&](const auto& term) { return small(term.factor); });
  }
  /// Sums of what is known in each round are known in each round.
  void note_number(const Step& step) {
    numbers_.erase(step.out.operand);
    if (step.value == nullptr || (step.out.bytes != 2 && step.out.bytes != 4)) return;
    const ResolvedOp op = op_at(step.position);
    const bool two = step.in.size() == 2;
    const auto a = number_of(step.in[0]);
    const auto b = two ? number_of(step.in[1]) : std::optional<Affine>{Affine{}};
    if (!a || !b) return;
    std::optional<Affine> number;
    switch (op) {
      case ResolvedOp::kMove16:
      case ResolvedOp::kMove32:
        number = a;
        break;
      case ResolvedOp::kAdd16:
      case ResolvedOp::kAdd32:
        number = combined(*a, 1, *b, 1);
        break;
      case ResolvedOp::kSub16:
      case ResolvedOp::kSub32:
        number = combined(*a, 1, *b, -1);
        break;
      case ResolvedOp::kMul16:
      case ResolvedOp::kMul32:
        if (is_constant(*b) && b->constant <= kMostFactor && b->constant >= -kMostFactor) {
          number = combined(*a, b->constant, Affine{}, 0);
        } else if (is_constant(*a) && a->constant <= kMostFactor && a->constant >= -kMostFactor) {
          number = combined(*b, a->constant, Affine{}, 0);
        }
        break;
      default:
        break;
    }
    if (number && is_small(*number)) numbers_.emplace(step.out.operand, std::move(*number));
  }
  static bool is_constant(const Affine& number) { return number.factor == 0 && number.terms.empty(); }
  [[nodiscard]] ResolvedOp op_at(std::uint32_t position) const {
    return std::lower_bound(code_.instructions.begin(), code_.instructions.end(), position,
                            [](const LinkedInstruction& i, std::uint32_t p) { return i.position < p; })
        ->op;
  }

  // ---- records

  [[nodiscard]] std::size_t readers_of(const OperandRange& range) const {
    std::size_t readers = 0;
    for (const Step& step : steps_) {
      bool reads = std::find(step.in.begin(), step.in.end(), range) != step.in.end();
      if (step.element) {
        for (const Index& index : step.element->indices) {
          reads = reads || std::any_of(index.number.terms.begin(), index.number.terms.end(), [&](const auto& term) {
                    return OperandRange{term.operand, index.number.bytes}.overlaps(range);
                  });
        }
      }
      readers += reads ? 1 : 0;
    }
    return readers;
  }
  [[nodiscard]] std::size_t writers_of(const OperandRange& range) const {
    return static_cast<std::size_t>(
        std::count_if(steps_.begin(), steps_.end(), [&](const Step& s) { return s.out == range; }) +
        (plan_.result == range ? 1 : 0));
  }
  /// Nobody jumps to the first round of a loop: what stands in front of it has set its variable.
  [[nodiscard]] std::optional<KnownRounds> known_rounds() const {
    std::size_t before = first_;
    while (before > 0 && code_.instructions[before - 1].op == ResolvedOp::kStretch) --before;
    if (before == 0) return std::nullopt;
    const LinkedInstruction& sets = code_.instructions[before - 1];
    if (sets.op != (plan_.wide ? ResolvedOp::kMove32 : ResolvedOp::kMove16) || word(sets, 1) != plan_.control)
      return std::nullopt;
    const auto start = constant_at({word(sets, 2), counted_[0].bytes});
    const auto step = constant_at(counted_[1]), limit = constant_at(counted_[2]);
    if (!start || !step || !limit) return std::nullopt;
    const std::int64_t jumps = plan_.wide ? jumps_of_loop<std::int32_t>(*start, *step, *limit, plan_.down)
                                          : jumps_of_loop<std::int16_t>(*start, *step, *limit, plan_.down);
    return KnownRounds{*start, plan_.down ? -*step : *step, jumps};
  }

  /// Whether somebody reads what `from` left there.
  [[nodiscard]] bool is_read_behind(const OperandRange& range, std::size_t from) const {
    for (std::size_t i = from; i < steps_.size(); ++i) {
      if (std::find(steps_[i].in.begin(), steps_[i].in.end(), range) != steps_[i].in.end()) return true;
      if (steps_[i].out == range) return false;
    }
    return false;
  }

  std::uint32_t variable(std::uint32_t operand) {
    const auto known = std::find(plan_.variables.begin(), plan_.variables.end(), operand);
    if (known == plan_.variables.end()) plan_.variables.push_back(operand);
    return LoopPlan::stream(StreamKind::kVariable, static_cast<std::size_t>(std::find(plan_.variables.begin(),
                                                                                      plan_.variables.end(), operand) -
                                                                            plan_.variables.begin()));
  }
  std::uint32_t new_value(std::uint64_t bytes) {
    plan_.values.push_back(static_cast<std::uint32_t>(bytes));
    return LoopPlan::stream(StreamKind::kValue, plan_.values.size() - 1);
  }
  std::uint32_t new_element(const Element& element) {
    plan_.elements.push_back(&element);
    return LoopPlan::stream(StreamKind::kElement, plan_.elements.size() - 1);
  }
  template <class Run>
  Record& add_record(Run run, std::uint32_t out, std::vector<std::uint32_t> in, const Step& step) {
    const auto arguments = static_cast<std::uint32_t>(step.function != nullptr ? in.size() : 0);
    records_.push_back(
        {{reinterpret_cast<std::uintptr_t>(run), out, std::move(in), arguments, step.position}, &step, false});
    return records_.back();
  }

  /// What `step`, number `at`, reads at `range`.
  std::optional<std::uint32_t> input(const OperandRange& range, std::size_t at) {
    if (range == counted_[0]) {
      if (counter_ == kNoStream) {
        counter_ = new_value(range.bytes);
        const auto run = reinterpret_cast<std::uintptr_t>(counting(plan_.wide, plan_.down));
        records_.insert(records_.begin(), Record{{run, counter_, {variable(plan_.control), variable(plan_.step)}}});
      }
      return counter_;
    }
    if (const auto now = now_.find(range.operand); now != now_.end()) return now->second;
    if (!is_written(range)) return variable(range.operand);
    // A sum: of one instruction alone.
    if (steps_[at].out == range && writers_of(range) == 1 && readers_of(range) == 1) return variable(range.operand);
    return std::nullopt;
  }

  bool make_records() {
    plan_.variables.clear();
    plan_.values.clear();
    plan_.elements.clear();
    records_.clear();
    now_.clear();
    counter_ = kNoStream;
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      const Step& step = steps_[i];
      std::vector<std::uint32_t> in;
      for (const OperandRange& range : step.in) {
        const auto stream = input(range, i);
        if (!stream) return false;
        in.push_back(*stream);
      }
      if (step.element) {
        put_element(step, i, in);
        continue;
      }
      const bool sum =
          std::find(step.in.begin(), step.in.end(), step.out) != step.in.end() && !now_.contains(step.out.operand);
      const std::uint32_t out = sum ? variable(step.out.operand) : new_value(step.out.bytes);
      if (step.function != nullptr) {
        add_record(step.kernel, out, std::move(in), step);
      } else {
        add_record(step.value->stream, out, std::move(in), step);
      }
      if (!sum) now_[step.out.operand] = out;
    }
    return true;
  }
  void put_element(const Step& step, std::size_t at, const std::vector<std::uint32_t>& in) {
    const Element& element = *step.element;
    const StreamRun move = value_op(of_size(ResolvedOp::kMove8, element.bytes))->stream;
    if (element.write) {
      const bool keeps =
          std::none_of(steps_.begin() + static_cast<std::ptrdiff_t>(at) + 1, steps_.end(), [&](const Step& other) {
            return other.element && other.element->write && !are_other_parts(*other.element, element);
          });
      // Straight from whoever computes it, if nobody else wants it; the last element tells what the variable has.
      if (!records_.empty() && records_.back().out == in[0] && is_value(in[0]) && in[0] != counter_ && keeps &&
          !is_read_behind(step.in[0], at + 1)) {
        records_.back().out = new_element(element);
        now_[step.in[0].operand] = records_.back().out;
      } else {
        add_record(move, new_element(element), in, step);
      }
      return;
    }
    const bool stays = std::none_of(steps_.begin(), steps_.end(), [&](const Step& other) {
      return other.element && other.element->write && !are_other_parts(*other.element, element);
    });
    std::uint32_t stream = new_element(element);
    if (!stays) {
      const std::uint32_t value = new_value(element.bytes);
      add_record(move, value, {stream}, step).of_its_round = true;
      stream = value;
    }
    now_[step.out.operand] = stream;
  }

  static bool is_value(std::uint32_t stream) { return stream >> 16 == static_cast<std::uint32_t>(StreamKind::kValue); }

  /// The variable that has `stream` behind the last round.
  [[nodiscard]] std::optional<std::uint32_t> home_of(std::uint32_t stream) const {
    if (stream == counter_) return plan_.control;
    if (stream >> 16 == static_cast<std::uint32_t>(StreamKind::kVariable)) return plan_.variables[stream & 0xffffu];
    const auto home = std::find_if(now_.begin(), now_.end(), [&](const auto& now) { return now.second == stream; });
    return home == now_.end() ? std::nullopt : std::optional(home->first);
  }
  /// Leaves what `record` computes to the end, if that is possible.
  bool compute_last(const Record& record, Addressing addressing) {
    if (record.step == nullptr || !home_of(record.out)) return true;  // nobody will ask
    LastComputed last;
    last.position = record.position;
    const ValueOp* const op = record.step->value;
    if (op == nullptr || record.of_its_round) return false;
    last.run = reinterpret_cast<std::uintptr_t>(op->run[static_cast<std::size_t>(addressing)]);
    last.operands.push_back(*home_of(record.out));
    for (const std::uint32_t in : record.in) {
      const auto home = home_of(in);
      if (!home) return false;
      last.operands.push_back(*home);
    }
    plan_.last_computed.push_back(std::move(last));
    computed_.push_back(record.out);
    return true;
  }
  /// What is only left in variables is computed in the last round alone.
  void leave_out_unread(Addressing addressing) {
    plan_.last_computed.clear();
    computed_.clear();
    std::vector<std::uint8_t> read(plan_.values.size(), 0);
    for (auto record = records_.rbegin(); record != records_.rend(); ++record) {
      if (is_value(record->out) && read[record->out & 0xffffu] == 0 && record->arguments == 0 &&
          compute_last(*record, addressing)) {
        record->run = 0;
        continue;
      }
      for (const std::uint32_t in : record->in) {
        if (is_value(in)) read[in & 0xffffu] = 1;
      }
    }
    std::erase_if(records_, [](const Record& record) { return record.run == 0; });
  }

  /// Sums of products, as filters and matrices have them, keep the last product alone.
  void join_products() {
    for (std::size_t i = 0; i + 1 < records_.size(); ++i) {
      Record& product = records_[i];
      const Record& sum = records_[i + 1];
      const bool adds = sum.in.size() == 2 && sum.arguments == 0 && product.arguments == 0 &&
                        (sum.in == std::vector{sum.out, product.out} || sum.in == std::vector{product.out, sum.out}) &&
                        is_value(product.out);
      const auto readers = std::count_if(records_.begin(), records_.end(), [&](const Record& record) {
        return std::find(record.in.begin(), record.in.end(), product.out) != record.in.end();
      });
      if (!adds || readers != 1) continue;
      const StreamRun both =
          sum_of_products(reinterpret_cast<StreamRun>(product.run), reinterpret_cast<StreamRun>(sum.run));
      if (both == nullptr) continue;
      const std::optional<std::uint32_t> home = home_of(product.out);
      product.in.push_back(home ? variable(*home) : product.out);
      computed_.push_back(product.out);
      product.run = reinterpret_cast<std::uintptr_t>(both);
      product.out = sum.out;
      records_.erase(records_.begin() + static_cast<std::ptrdiff_t>(i) + 1);
    }
  }

  /// Values are copied to their variables behind the last round, where no stream has them computed.
  void make_last_round() {
    std::sort(plan_.last_computed.begin(), plan_.last_computed.end(),
              [](const LastComputed& a, const LastComputed& b) { return a.position < b.position; });
    plan_.last_values.clear();
    for (const auto& [operand, stream] : now_) {
      if (std::find(computed_.begin(), computed_.end(), stream) != computed_.end()) continue;
      const auto writer = std::find_if(steps_.begin(), steps_.end(),
                                       [&](const Step& s) { return s.out.bytes != 0 && s.out.operand == operand; });
      plan_.last_values.push_back({operand, stream, static_cast<std::uint32_t>(writer->out.bytes)});
    }
    std::stable_partition(plan_.last_values.begin(), plan_.last_values.end(),
                          [](const LastValue& value) { return value.bytes == 4; });
  }

  /// Variables and values that nobody keeps any more take no stream.
  void number_streams() {
    std::vector<std::uint32_t> kept[2], content[2];
    const auto renumber = [&](std::uint32_t& stream) {
      const std::uint32_t kind = stream >> 16;
      if (kind >= std::size(kept)) return;
      const auto known = std::find(kept[kind].begin(), kept[kind].end(), stream);
      const std::uint32_t renumbered =
          LoopPlan::stream(static_cast<StreamKind>(kind), static_cast<std::size_t>(known - kept[kind].begin()));
      if (known == kept[kind].end()) {
        kept[kind].push_back(stream);
        content[kind].push_back((kind == 0 ? plan_.variables : plan_.values)[stream & 0xffffu]);
      }
      stream = renumbered;
    };
    for (Record& record : records_) {
      renumber(record.out);
      for (std::uint32_t& in : record.in) renumber(in);
    }
    for (LastValue& value : plan_.last_values) renumber(value.stream);
    plan_.variables = std::move(content[0]);
    plan_.values = std::move(content[1]);
  }

  std::vector<std::uint32_t>& words_;
  LinkedCode& code_;
  const LinkedConstants& constants_;
  std::uint32_t scratch_;
  LoopPlan plan_;
  std::vector<Record> records_;        ///< of the plan
  std::size_t first_ = 0;              ///< its first instruction
  std::vector<OperandRange> counted_;  ///< control variable, step, limit
  std::vector<Step> steps_;
  std::map<std::uint32_t, Affine> numbers_;     ///< of variables, at this step of a round
  std::map<std::uint32_t, std::uint32_t> now_;  ///< streams of variables that the round has written
  std::uint32_t counter_ = kNoStream;
  std::vector<std::uint32_t> computed_;  ///< streams that nobody fills
};

}  // namespace

void link_loops(std::vector<std::uint32_t>& words, LinkedCode& code, const LinkedConstants& constants,
                std::uint32_t scratch) {
  LoopLinker linker(words, code, constants, scratch);
  for (const LinkedLoop& loop : code.loops) linker.link(loop);
}

}  // namespace plc::runtime
