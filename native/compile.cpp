#include "native/compile.h"

#include <algorithm>
#include <map>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>

#include "bytecode/image.h"
#include "native/dead_stores.h"
#include "native/helpers.h"
#include "native/if_conversion.h"
#include "native/library_rows.h"
#include "native/loops.h"
#include "native/naming.h"
#include "native/range_analysis.h"
#include "native/records.h"
#include "native/translate.h"
#include "runtime/interpreter/operations.h"
#include "runtime/link/link.h"

namespace plc::native {

using runtime::Addressing;
using runtime::LinkedBody;
using runtime::LinkedCode;
using runtime::LinkedInstruction;

namespace {

/// How many iterations of a loop without others inside are code at most, one after the other.
constexpr std::size_t kMostIterations = 4;

class TaskCompiler {
 public:
  TaskCompiler(const LinkedCode& linked, const Memory& memory)
      : linked_(linked),
        table_(memory.table),
        s_(memory),
        words_(linked.data(), linked.data() + linked.words.size() / sizeof(std::uint32_t)),
        marks_(linked.marks) {}

  void compile(const CompileOptions& options, Naming naming) {
    s_.baseline = options.baseline;
    s_.from_code = naming == Naming::kFromCode;
    for (const LinkedBody& body : linked_.bodies) entries_.emplace(body.entry, s_.label());
    entry();
    for (std::size_t b = 0; b < linked_.bodies.size(); ++b) {
      const std::size_t begin = s_.size();
      body(linked_.bodies[b], linked_.instructions_of(b));
      report_.bodies.push_back({linked_.bodies[b].pou, s_.size() - begin});
    }
    s_.write_data();
    report_.code_bytes = s_.size();
  }

  [[nodiscard]] const std::string& problem() const { return s_.problem(); }
  /// Executable memory with the code. Nothing when variables are named by their distance from it and are too far.
  core::Result<std::optional<CodeMemory>> write() {
    bool reached = true;
    auto memory = CodeMemory::make(s_.finish(), table_,
                                   [&](std::span<std::byte> to, std::uint64_t at) { reached = s_.write(to, at); });
    if (!memory) return memory.error();
    return reached ? std::optional(std::move(*memory)) : std::nullopt;
  }
  std::unique_ptr<NativeTask> task(CodeMemory memory) {
    return std::make_unique<NativeTask>(std::move(memory), std::move(words_), std::move(marks_), std::move(report_));
  }

 private:
  /// What C++ calls: bool (Machine&).
  void entry() {
    const bool loops = std::any_of(linked_.instructions.begin(), linked_.instructions.end(),
                                   [](const LinkedInstruction& i) { return i.op == runtime::ResolvedOp::kLoopJump; });
    s_.begin_entry(loops);
    s_.call_body(entries_.at(linked_.entry));
    s_.end_entry(loops);
  }

  // ---- one body

  void body(const LinkedBody& body, std::span<const LinkedInstruction> instructions) {
    s_.relative = body.addressing == Addressing::kRelative;
    bool counts_events = false;
    targets_.clear();
    for (const LinkedInstruction& instruction : instructions) {
      counts_events = counts_events || operation_of(instruction.op).form == Form::kEno;
      expect_target(instruction);
    }
    std::vector<Loop> loops;
    if (Assembly::kKeepsLoops) loops = find_loops(linked_.data(), instructions);
    auto loop = loops.cbegin();
    DeadStores dead_stores(instructions.size());
    if (!s_.relative) dead_stores = find_dead_stores(linked_, instructions);
    // Loops keep theirs in registers.
    for (const Loop& l : loops) {
      const auto part = std::span(dead_stores).subspan(l.first, l.last + 1 - l.first);
      std::fill(part.begin(), part.end(), std::nullopt);
    }
    failed_ = s_.label();
    s_.land(entries_.at(body.entry));
    s_.begin_body(counts_events);
    for (std::size_t i = 0; i < instructions.size();) {
      land_at(instructions[i]);
      s_.leave_out(dead_stores[i]);
      if (loop != loops.cend() && loop->first == i) {
        i = write_loop(*loop++, instructions);
        continue;
      }
      if (ends_with_body(instructions, i)) {
        s_.note_place(instructions[i].position);
        s_.leave_to_body(entries_.at(linked_.data()[instructions[i].position + 1]));
        ++i;
        continue;
      }
      const std::size_t next = next_of(instructions, i);
      if (is_interpreted(instructions[i]) || next - i >= kManyTaskblocks) {
        interpret(body, instructions, i, next);
      } else {
        translate(instructions[i]);
      }
      i = next;
      if (!dead_stores[i - 1]) s_.keep_cold_paths_near();
    }
    s_.write_cold_paths();
    s_.land(failed_);
    s_.leave_body(false);
  }

  /// The scan ends here unless what was called returned TRUE.
  void check() { s_.jump_if_result(false, failed_); }

  /// Whether instruction `i` calls a body and nothing follows it.
  [[nodiscard]] bool ends_with_body(std::span<const LinkedInstruction> instructions, std::size_t i) const {
    const auto form = [&](std::size_t n) { return operation_of(instructions[n].op).form; };
    return form(i) == Form::kCallFixed && form(i + 1) == Form::kReturn;
  }

  // ---- loops (loops.h)

  struct LoopCode {
    std::uint32_t first = 0, last = 0;  ///< positions
    const LinkedInstruction* instructions = nullptr;
    LoopRanges facts;
    std::map<std::uint32_t, asmjit::Label> exits{};  ///< by position outside
    struct Round {
      asmjit::Label next;    ///< where its loop jump goes
      bool follows = false;  ///< what comes next
      bool goes_on = false;  ///< the iteration after it is known to come: no comparison, no jump
      bool in_group = false;
    };
    std::optional<Round> round{};  ///< that is being written
    [[nodiscard]] const InstructionRanges& of(const LinkedInstruction& instruction) const {
      return facts.instructions[static_cast<std::size_t>(&instruction - instructions)];
    }
  };

  /// A loop, with its variables in registers. Returns the number of the instruction after it.
  std::size_t write_loop(Loop loop, std::span<const LinkedInstruction> instructions) {
    LoopCode code{instructions[loop.first].position, instructions[loop.last].position, &instructions[loop.first],
                  analyse_ranges(s_, linked_.data(), instructions, loop)};
    std::erase_if(loop.variables, [&](const LoopVariable& variable) {
      return std::find(code.facts.unread.begin(), code.facts.unread.end(), variable.operand) != code.facts.unread.end();
    });
    s_.enter_loop(loop);
    loop_ = std::move(code);
    // Who jumps to the head from outside enters the loop; who does so inside goes on with it.
    const asmjit::Label entry = std::exchange(targets_.at(loop_->first).label, s_.label());
    auto inner = loop.inner.cbegin();
    for (std::size_t i = loop.first; i <= loop.last;) {
      if (inner != loop.inner.cend() && inner->first == i) {
        write_iterations(*inner++, instructions);
        i = std::prev(inner)->last + 1;
      } else {
        i = write_in_loop(instructions, i);
      }
    }
    for (const auto& [position, exit] : loop_->exits) {
      s_.land(exit);
      canonicalise(loop_->facts.exits[position]);
      s_.write_back();
      s_.jump(targets_.at(position).label);
    }
    targets_.at(loop_->first).label = entry;
    loop_.reset();
    s_.end_loop();
    return loop.last + 1;
  }
  /// Instruction `i` of a loop, or a short_if. Returns the number of the instruction after it.
  std::size_t write_in_loop(std::span<const LinkedInstruction> instructions, std::size_t i) {
    land_at(instructions[i]);
    const std::size_t after = write_short_if(instructions, i);
    if (after == i) translate(instructions[i]);
    return std::max(after, i + 1);
  }
  /// A short loop without others inside, several iterations of it one after the other: a processor sees more of what
  /// can be done at once, and guesses better where it ends.
  void write_iterations(const Loop::Inner& inner, std::span<const LinkedInstruction> instructions) {
    constexpr std::size_t kShort = 12, kNotLong = 24;
    const std::size_t size = inner.last - inner.first + 1;
    const std::size_t rounds = size <= kShort ? kMostIterations : size <= kNotLong ? kMostIterations / 2 : 1;
    const asmjit::Label head = targets_.at(instructions[inner.first].position).label;
    if (rounds > 1 && write_group(inner, instructions, head, rounds)) {
      write_round(inner, instructions, {head, false, false});
    } else {
      for (std::size_t round = 1; round < rounds; ++round) {
        write_round(inner, instructions, {s_.label(), true, false});
        take_new_labels(inner, instructions, loop_->round->next);
      }
      write_round(inner, instructions, {head, false, false});
    }
    targets_.at(instructions[inner.first].position).label = head;
    loop_->round.reset();
  }
  /// Of a counted loop, `iterations` iterations that are counted, and paid for with the loop budget, at once: only the
  /// last one looks whether it was the last. After it is where code for a single iteration belongs. False, and nothing
  /// was written, when the difference would be seen.
  bool write_group(const Loop::Inner& inner, std::span<const LinkedInstruction> instructions, const asmjit::Label& head,
                   std::size_t rounds) {
    constexpr std::uint64_t kLongStep = 1 << 20;
    if (!inner.counts) return false;
    const Instruction compare = instruction_of(instructions[inner.last - 2]);
    const std::uint32_t step_operand = linked_.data()[instructions[inner.last - 1].position + 3];
    const auto step = s_.constant(step_operand, bytes_of(compare.operation.type));
    if (!compare.known.unread || !step || *step == 0 || *step > kLongStep) return false;
    const asmjit::Label fewer = s_.label();
    const auto jumps = static_cast<std::uint32_t>(rounds - 1);
    s_.align_head();
    s_.land(head);
    s_.begin_iterations(compare, compare.operation.relation == Relation::kGt,
                        static_cast<std::int64_t>(*step) * (jumps - 1), jumps, fewer);
    for (std::size_t round = 1; round <= rounds; ++round) {
      write_round(inner, instructions, {head, false, round < rounds, true});
    }
    take_new_labels(inner, instructions, fewer);
    return true;
  }
  void write_round(const Loop::Inner& inner, std::span<const LinkedInstruction> instructions, LoopCode::Round round) {
    loop_->round = std::move(round);
    for (std::size_t i = inner.first; i <= inner.last;) {
      if (!loop_->round->in_group) {
        i = write_in_loop(instructions, i);
      } else if (loop_->round->goes_on && (i == inner.last - 2 || i == inner.last)) {
        ++i;
      } else {
        // No jump leads here: what is known of registers stays.
        translate(instructions[i++]);
      }
    }
  }
  /// The next iteration has labels of its own.
  void take_new_labels(const Loop::Inner& inner, std::span<const LinkedInstruction> instructions,
                       const asmjit::Label& head) {
    for (std::size_t i = inner.first; i <= inner.last; ++i) {
      if (const auto target = targets_.find(instructions[i].position); target != targets_.end()) {
        target->second.label = i == inner.first ? head : s_.label();
      }
    }
  }
  /// What is not read in the loop, for what reads it after the loop.
  void canonicalise(const LoopEnd& end) {
    for (const NonCanonicalReal& real : end.reals) s_.make_one_nan(real.operand, real.type);
    for (const auto& [operand, value] : end.results) s_.store_constant(operand, 1, value ? 1 : 0);
  }

  /// In a loop: both parts of a short_if that begins with instruction `i`, and the values of one of them. Returns the
  /// number of the instruction after them, or `i` when there is no such short_if.
  std::size_t write_short_if(std::span<const LinkedInstruction> instructions, std::size_t i) {
    const auto short_if = short_if_at(linked_.data(), instructions, i, [this](std::uint32_t position) {
      const auto target = targets_.find(position);
      return target == targets_.end() ? 0 : target->second.jumps;
    });
    if (!short_if) return i;
    const auto written = written_by(s_, linked_.data(), instructions, *short_if);
    if (!written || !s_.keeps(*written)) return i;
    if (short_if->compares) translate_compare(s_, instruction_of(instructions[i]));
    s_.begin_both_branches(*written);
    for (std::size_t n = short_if->taken.first; n < short_if->taken.last; ++n) translate(instructions[n]);
    s_.other_branch();
    for (std::size_t n = short_if->other.first; n < short_if->other.last; ++n) translate(instructions[n]);
    s_.end_both_branches(short_if->condition, short_if->value);
    return short_if->end;
  }

  /// Where a jump to this position goes: out of a loop, through code that ends it.
  const asmjit::Label& target(std::uint32_t position) {
    if (!loop_ || (loop_->first <= position && position <= loop_->last)) return targets_.at(position).label;
    const auto [exit, is_new] = loop_->exits.try_emplace(position);
    if (is_new) exit->second = s_.label();
    return exit->second;
  }

  // ---- instructions

  void land_at(const LinkedInstruction& instruction) {
    if (const auto target = targets_.find(instruction.position); target != targets_.end())
      s_.land(target->second.label);
  }
  void expect_target(const LinkedInstruction& instruction) {
    const std::uint32_t position = target_of(operation_of(instruction.op).form, linked_.data() + instruction.position);
    if (position == kNoTarget) return;
    Target& target = targets_[position];
    if (target.jumps++ == 0) target.label = s_.label();
  }
  static bool is_interpreted(const LinkedInstruction& instruction) {
    return operation_of(instruction.op).form == Form::kInterpreted;
  }
  /// Not in words_, which grow while code after the body (Emitter::aside) still reads the instruction.
  [[nodiscard]] Instruction instruction_of(const LinkedInstruction& instruction) const {
    Instruction i{linked_.data() + instruction.position, instruction.position, operation_of(instruction.op)};
    if (!loop_) return i;
    i.known = loop_->of(instruction).known;
    // The next iteration loads it anew; the last one leaves it to what reads it after the loop.
    i.known.passes_on = i.known.passes_on && loop_->round && loop_->round->goes_on;
    return i;
  }
  void translate(const LinkedInstruction& instruction) {
    Instruction i = instruction_of(instruction);
    if (loop_) {
      for (const NonCanonicalReal& real : loop_->of(instruction).before) s_.make_one_nan(real.operand, real.type);
    }
    // A block after a loop finds its ports in the table.
    if (!loop_) find_ports(i, std::span(&instruction + 1, linked_.instructions.data() + linked_.instructions.size()));
    translate(instruction, i);
  }
  /// The ports of the block of the library that runs soon after the instruction.
  void find_ports(Instruction& instruction, std::span<const LinkedInstruction> following) const {
    constexpr std::size_t kSoon = 4;
    for (const LinkedInstruction& next : following.first(std::min(kSoon, following.size()))) {
      if (operation_of(next.op).form != Form::kRunBlock) continue;
      const std::uint32_t* const words = linked_.data() + next.position;
      const auto block = block_of(runtime::load_pointer<stdlib::Step>(words + 1));
      if (!block) return;
      instruction.ports = words[3];
      instruction.port_bytes = block->spec->size;
      const auto between = following.first(static_cast<std::size_t>(&next - following.data()));
      if (leads_to_block(between, next, instruction)) instruction.deferred_bytes = deferred_bytes(block->block);
      return;
    }
  }
  /// Nothing but constants for ports of the block, `next`, lies between, and no jump leads there: what is in registers
  /// still is when the block runs.
  [[nodiscard]] bool leads_to_block(std::span<const LinkedInstruction> between, const LinkedInstruction& next,
                                    const Instruction& instruction) const {
    if (loop_ || targets_.contains(next.position)) return false;
    return std::all_of(between.begin(), between.end(), [&](const LinkedInstruction& i) {
      const Operation operation = operation_of(i.op);
      const std::uint32_t* const words = linked_.data() + i.position;
      return operation.form == Form::kMove && !targets_.contains(i.position) && instruction.is_port(words[1]) &&
             words[1] - instruction.ports >= kMostDeferredBytes && s_.constant(words[2], bytes_of(operation.type));
    });
  }
  void translate(const LinkedInstruction& linked, const Instruction& i) {
    const std::uint32_t* const w = i.words;
    s_.begin(i);
    switch (i.operation.form) {
      case Form::kReturn:
        if (loop_) canonicalise(loop_->of(linked).end);
        s_.write_back();
        return s_.leave_body(true);
      case Form::kBlockStart:
      case Form::kArranged:
        return;
      case Form::kJump:
        return s_.jump(target(w[1]));
      case Form::kJumpUnless:
        return s_.jump_if(w[1], false, target(w[2]));
      case Form::kJumpIf:
        return s_.jump_if(w[1], true, target(w[2]));
      case Form::kLoopJump:
        return loop_jump(i, loop_ ? loop_->of(linked).end : LoopEnd{});
      case Form::kCompareJumpUnless:
      case Form::kCompareJumpIf:
        return translate_compare_jump(s_, i, target(w[4]));
      case Form::kShortRecords4:
      case Form::kShortRecords5:
      case Form::kGeneralRecords:
        return translate_records(s_, i, linked_.data(), expressions_);
      case Form::kRunBlock:
        if (translate_block(s_, runtime::load_pointer<stdlib::Step>(w + 1), w[3])) return;
        s_.pass_step(1);
        s_.pass_address(0, w[3]);
        return s_.call_address(runtime::load<std::uint64_t>(w + 1));
      case Form::kRunTaskblock:
        s_.pass_address(2, w[1]);
        s_.pass(1, i.position);
        s_.pass_machine(0);
        s_.call(&run_taskblock);
        return check();
      case Form::kCallFixed:
        s_.note_place(i.position);
        return call_body(w[1]);
      case Form::kCallRelative:
        s_.pass_address(0, w[2]);
        return call_body(w[1]);
      case Form::kCallFunction:
        return call_function(i);
      case Form::kCallLibrary:
        // Written later, when the words may lie elsewhere.
        if (translate_library(s_, i, [this, position = i.position, operation = i.operation] {
              call_library({words_.data() + position, position, operation});
            })) {
          return;
        }
        return call_library(i);
      case Form::kClearEvent:
        return s_.mark_events();
      case Form::kEno:
        return s_.store_no_event(w[1]);
      default:
        return translate_data(s_, i);
    }
  }

  /// `end`: if there is no budget left.
  void loop_jump(const Instruction& i, const LoopEnd& end) {
    const asmjit::Label over = s_.label();
    if (loop_ && loop_->round) {
      s_.loop_back(i.position, loop_->round->next, over, loop_->round->follows);
    } else {
      s_.loop_back(i.position, target(i.words[1]), over, false);
    }
    s_.cold_path([this, over, end, position = i.position] {
      s_.land(over);
      canonicalise(end);
      s_.pass(1, position);
      s_.pass_machine(0);
      s_.call(&fail_loop);
      s_.jump(failed_);
    });
  }

  void call_body(std::uint32_t entry) {
    s_.call_body(entries_.at(entry));
    check();
  }

  /// Words: frame, frame bytes, initial bytes (2), entry, inputs, outputs, then 4 per argument: to, from, bytes or
  /// kind, capacities.
  void call_function(const Instruction& i) {
    const std::uint32_t* const w = i.words;
    reset_frame(s_, w[1], runtime::load_pointer<const std::byte*>(w + 3), w[2]);
    const std::uint32_t* argument = w + 8;
    for (const std::uint32_t* const end = argument + std::size_t{w[6]} * 4; argument != end; argument += 4) {
      pass_argument(s_, i.position, argument);
    }
    call_body(w[5]);
    for (const std::uint32_t* const end = argument + std::size_t{w[7]} * 4; argument != end; argument += 4) {
      pass_argument(s_, i.position, argument);
    }
  }

  /// Words: kernel (2), arguments, result, then the arguments.
  void call_library(const Instruction& i) {
    const std::uint32_t* const w = i.words;
    s_.call_kernel(runtime::load<std::uint64_t>(w + 1), w[4], {w + 5, w[3]});
    const asmjit::Label event = s_.label();
    const asmjit::Label done = s_.label();
    s_.jump_if_result(true, event);
    s_.bind(done);
    s_.cold_path([this, event, done, position = i.position] {
      s_.land(event);
      s_.raise(position, -1);
      s_.jump(done);
    });
  }

  /// The number after an instruction, or after those that the interpreter runs at once: as far as no jump leads
  /// between them. Of taskblocks, those in a row that are many.
  [[nodiscard]] std::size_t next_of(std::span<const LinkedInstruction> instructions, std::size_t i) const {
    const auto after = [&](auto&& alike) {
      std::size_t next = i + 1;
      if (!alike(instructions[i])) return next;
      while (next < instructions.size() && alike(instructions[next]) && !targets_.contains(instructions[next].position))
        ++next;
      return next;
    };
    const std::size_t next =
        after([](const LinkedInstruction& one) { return operation_of(one.op).form == Form::kRunTaskblock; });
    return next - i >= kManyTaskblocks ? next : after(is_interpreted);
  }
  /// Instructions [first, next) run in the interpreter: copied after the resolved code, with a RETURN.
  void interpret(const LinkedBody& body, std::span<const LinkedInstruction> instructions, std::size_t first,
                 std::size_t next) {
    const auto start = static_cast<std::uint32_t>(words_.size());
    for (std::size_t i = first; i < next; ++i) {
      const std::uint32_t position = instructions[i].position;
      const std::uint32_t end = end_of(instructions, i);
      const auto at = static_cast<std::uint32_t>(words_.size());
      const runtime::CodeMark& mark = runtime::mark_at(linked_.marks, position);
      marks_.push_back({at, mark.pou, mark.word});
      words_.resize(at + (end - position));
      std::copy(words_.begin() + position, words_.begin() + end, words_.begin() + at);
      ++report_.interpreted[instructions[i].op];
    }
    words_.push_back(runtime::handler_word(body.addressing, runtime::ResolvedOp::kReturn));
    if (s_.relative) {
      s_.pass_instance_offset(3);
    } else {
      s_.pass(3, 0);
    }
    s_.pass(2, start);
    s_.pass(1, static_cast<std::uint64_t>(body.addressing));
    s_.pass_machine(0);
    s_.call(&runtime::run_body);
    check();
  }
  /// Where the words of an instruction without records end.
  [[nodiscard]] std::uint32_t end_of(std::span<const LinkedInstruction> instructions, std::size_t i) const {
    if (i + 1 < instructions.size()) return instructions[i + 1].position;
    return instructions[i].position + 1;
  }

  /// So many taskblocks in a row run in the interpreter. WHY: code that calls each of them has a place of its own for
  /// each, which a processor fetches and guesses anew; the interpreter's handler is one place (10,000 empty ones in a
  /// row take 9.6 ns each by code, 3.6 ns by the handler).
  static constexpr std::size_t kManyTaskblocks = 16;

  const LinkedCode& linked_;
  const std::byte* table_;
  Assembly s_;
  std::vector<std::uint32_t> words_;
  std::vector<runtime::CodeMark> marks_;
  BooleanExpressions expressions_;
  std::unordered_map<std::uint32_t, asmjit::Label> entries_;  ///< of bodies, by position
  struct Target {
    asmjit::Label label;
    std::size_t jumps = 0;  ///< that go there
  };
  std::unordered_map<std::uint32_t, Target> targets_;  ///< of jumps in this body, by position
  std::optional<LoopCode> loop_;                       ///< that is being written
  asmjit::Label failed_;                               ///< of this body: the scan is over
  CompileReport report_;
};

}  // namespace

core::Result<std::unique_ptr<NativeTask>> compile(runtime::Program& program, const CompileOptions& options) {
  const LinkedCode& linked = program.linked();
  const runtime::TaskLayout& layout = program.table().layout();
  const Naming wanted = options.naming.value_or(names_from_code() ? Naming::kFromCode : Naming::kFromRegister);
  for (const Naming naming : {wanted, Naming::kFromRegister}) {
    TaskCompiler compiler(linked, {program.table().data(), layout.constants, layout.instance});
    compiler.compile(options, naming);
    auto memory = compiler.write();
    if (!compiler.problem().empty()) {
      return core::Problem{core::Code::P9001, "native code could not be made: " + compiler.problem(), {}};
    }
    if (!memory) return memory.error();
    if (*memory) return compiler.task(std::move(**memory));
  }
  return core::Problem{core::Code::P9001, "native code could not be made: the table is out of reach", {}};
}

}  // namespace plc::native
