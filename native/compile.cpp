#include "native/compile.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <unordered_map>
#include <utility>

#include "bytecode/image.h"
#include "native/changed_plan.h"
#include "native/helpers.h"
#include "native/translate.h"
#include "runtime/link.h"
#include "runtime/operations.h"

namespace plc::native {

using runtime::Addressing;
using runtime::LinkedBody;
using runtime::LinkedCode;
using runtime::LinkedInstruction;
using runtime::Machine;

namespace {

/// Machine code that any instruction takes at most, by word of resolved code; addresses cost nothing.
constexpr std::size_t kBytesPerWord = 64;
constexpr std::size_t kBytesBeside = 64 * 1024;
/// As many times of it with groups: some are there twice, and it takes code to leave them out.
constexpr std::size_t kCodeWithGroups = 3;
/// Initial values of a function's frame that are written by instructions of their own; more is copied.
constexpr std::uint32_t kInlineFrameBytes = 64;

class TaskCompiler {
 public:
  /// `plan` and `tracker` are null when each scan executes everything.
  TaskCompiler(const LinkedCode& linked, std::byte* table, std::uint64_t address, const ChangedPlan* plan,
               std::unique_ptr<ChangeTracker> tracker)
      : linked_(linked),
        plan_(plan),
        tracker_(std::move(tracker)),
        s_(table, address),
        words_(linked.data(), linked.data() + linked.words.size() / sizeof(std::uint32_t)),
        marks_(linked.marks) {}

  void compile() {
    for (const LinkedBody& body : linked_.bodies) entries_.emplace(body.entry, s_.a.newLabel());
    entry();
    for (std::size_t b = 0; b < linked_.bodies.size(); ++b) {
      const std::size_t begin = s_.size();
      const bool last = b + 1 == linked_.bodies.size();
      body(linked_.bodies[b], last ? linked_.instructions.size() : linked_.bodies[b + 1].first);
      report_.bodies.push_back({linked_.bodies[b].pou, s_.size() - begin});
    }
    if (plan_ != nullptr) code_groups();
    s_.write_data();
    report_.code_bytes = s_.size();
  }

  [[nodiscard]] const std::string& problem() const { return s_.problem(); }
  std::vector<std::byte> code() {
    std::vector<std::byte> bytes = s_.finish();
    if (tracker_) tell_places();
    return bytes;
  }
  std::unique_ptr<NativeTask> task(CodeMemory memory, const std::byte* at) {
    return std::make_unique<NativeTask>(std::move(memory), at, std::move(words_), std::move(marks_),
                                        std::move(tracker_), std::move(report_));
  }

 private:
  /// What C++ calls: bool (Machine&).
  void entry() {
    s_.a.push(x86::rbx);
    s_.a.mov(x86::rbx, x86::rdi);
    if (tracker_) {
      call_tracker(&begin_changed);
      s_.a.call(entries_.at(linked_.entry));
      s_.a.sub(x86::rsp, 16);
      s_.a.mov(x86::dword_ptr(x86::rsp), x86::eax);
      s_.a.mov(x86::rsi, x86::rbx);
      s_.a.movzx(x86::edx, x86::al);
      call_tracker(&end_changed);
      s_.a.mov(x86::eax, x86::dword_ptr(x86::rsp));
      s_.a.add(x86::rsp, 16);
    } else {
      s_.a.call(entries_.at(linked_.entry));
    }
    s_.a.pop(x86::rbx);
    s_.a.ret();
  }

  // ---- one body: bool (); in relative bodies the instance is in rdi

  void body(const LinkedBody& body, std::size_t end) {
    const std::span<const LinkedInstruction> instructions =
        std::span(linked_.instructions).subspan(body.first, end - body.first);
    s_.relative = body.addressing == Addressing::kRelative;
    counts_events_ = false;
    targets_.clear();
    for (const LinkedInstruction& instruction : instructions) {
      const Operation operation = operation_of(instruction.op);
      counts_events_ = counts_events_ || operation.form == Form::kEno;
      expect_target(instruction);
    }
    failed_ = s_.a.newLabel();
    s_.land(entries_.at(body.entry));
    prologue();
    for (std::size_t i = 0; i < instructions.size();) {
      land_at(instructions[i]);
      const auto* const stretch = plan_ != nullptr ? plan_->stretch_at(body.first + i) : nullptr;
      if (stretch != nullptr) {
        run_stretch(*stretch);
        i = stretch->end - body.first;
        continue;
      }
      const std::size_t next = next_of(instructions, i);
      const ChangedPlan::Outside outside = outside_of(body.first + i, body.first + next);
      if (outside.effect == ChangedPlan::Outside::Effect::kAnywhere) expect_changes();
      if (is_interpreted(instructions[i])) {
        interpret(body, instructions, i, next);
      } else {
        translate(instructions[i]);
      }
      if (outside.effect == ChangedPlan::Outside::Effect::kList) settle(outside.list);
      i = next;
    }
    s_.write_asides();
    s_.a.bind(failed_);
    s_.a.xor_(x86::eax, x86::eax);
    epilogue();
  }

  /// Leaves the stack as C++ wants it for calls. A return address lies on it already.
  void prologue() {
    if (s_.relative) {
      s_.a.push(x86::r13);
      s_.a.mov(x86::r13, x86::rdi);
    }
    if (counts_events_) {
      s_.a.push(x86::r14);
      s_.a.mov(x86::r14, machine::event_count());
    }
    if (s_.relative == counts_events_) s_.a.sub(x86::rsp, 8);
  }
  void epilogue() {
    if (s_.relative == counts_events_) s_.a.add(x86::rsp, 8);
    if (counts_events_) s_.a.pop(x86::r14);
    if (s_.relative) s_.a.pop(x86::r13);
    s_.a.ret();
  }
  /// The scan ends here unless what was called returned TRUE.
  void check() {
    s_.a.test(x86::al, x86::al);
    s_.a.jz(failed_);
  }
  void note_place(std::uint32_t position) { s_.a.mov(machine::place(), position); }

  /// Where a jump goes.
  [[nodiscard]] std::optional<std::uint32_t> target_of(Form form, std::uint32_t position) const {
    const std::uint32_t* const words = words_.data() + position;
    switch (form) {
      case Form::kJump:
      case Form::kLoopJump:
        return words[1];
      case Form::kJumpUnless:
      case Form::kJumpIf:
        return words[2];
      case Form::kCompareJumpUnless:
      case Form::kCompareJumpIf:
        return words[4];
      default:
        return std::nullopt;
    }
  }

  // ---- scans that leave groups out (change_tracker.h)

  template <class Result, class... Arguments>
  void call_tracker(Result (*function)(ChangeTracker&, Arguments...) noexcept) {
    s_.a.mov(x86::rdi, reinterpret_cast<std::uint64_t>(tracker_.get()));
    s_.call(function);
  }
  void jump_if(const std::uint8_t& flag, const asmjit::Label& to) {
    s_.a.mov(x86::rax, reinterpret_cast<std::uint64_t>(&flag));
    s_.a.cmp(x86::byte_ptr(x86::rax), 0);
    s_.a.jne(to);
  }

  /// Groups: the dirty ones, by the tracker, or the straight code of all, from one of the chunks on.
  void run_stretch(const ChangedPlan::Stretch& stretch) {
    for (std::size_t c = 0; c < stretch.chunks.size(); ++c) chunks_.push_back(s_.a.newLabel());
    const asmjit::Label* const chunks = chunks_.data() + chunks_.size() - stretch.chunks.size();
    jump_if(tracker_->flags.whole, chunks[0]);
    s_.a.mov(x86::rsi, x86::rbx);
    s_.a.mov(x86::edx, stretch.number);
    call_tracker(&run_changed);
    s_.a.jmp(x86::rax);
    for (std::size_t c = 0; c < stretch.chunks.size(); ++c) {
      s_.land(chunks[c]);
      for (const ChangedPlan::Piece& piece : stretch.chunks[c]) {
        const LinkedInstruction& instruction = linked_.instructions[piece.instruction];
        if (piece.first_record == 0 && piece.instruction != stretch.begin) land_at(instruction);
        if (piece.records != 0) {
          translate_some(instruction, piece.first_record, piece.records);
        } else {
          translate(instruction);
        }
      }
    }
    exits_.push_back(s_.a.newLabel());
    s_.land(exits_.back());
  }
  /// Some records of a boolean run, as a run of their own.
  void translate_some(const LinkedInstruction& instruction, std::uint32_t first, std::uint32_t count) {
    const std::uint32_t* const w = words_.data() + instruction.position;
    std::vector<std::uint32_t> words(w, w + 2);
    words[1] = count;
    if (operation_of(instruction.op).form == Form::kGeneralRecords) {
      const std::uint32_t* const records = w + 2 + std::size_t{first} * runtime::kGeneralRecordWords;
      words.insert(words.end(), records, records + std::size_t{count} * runtime::kGeneralRecordWords);
    } else {
      words.insert(words.end(), {w[2], w[3] + first * runtime::kShortRecordWords});
    }
    translate({words.data(), instruction.position, operation_of(instruction.op)});
  }

  /// What instructions outside of groups, [first, end), do to groups.
  [[nodiscard]] ChangedPlan::Outside outside_of(std::size_t first, std::size_t end) const {
    using Outside = ChangedPlan::Outside;
    if (plan_ == nullptr) return {};
    if (end == first + 1) return plan_->outside(first);
    for (std::size_t i = first; i < end; ++i) {
      if (plan_->outside(i).effect != Outside::Effect::kNone) return {Outside::Effect::kAnywhere, 0};
    }
    return {};
  }
  /// The next instruction may write anywhere.
  void expect_changes() {
    const asmjit::Label known = s_.a.newLabel();
    const asmjit::Label settling = s_.a.newLabel();
    s_.forget();
    jump_if(tracker_->flags.look, known);
    s_.a.mov(x86::byte_ptr(x86::rax), 1);
    jump_if(tracker_->flags.settling, settling);
    s_.a.bind(known);
    s_.aside([this, known, settling] {
      s_.a.bind(settling);
      call_tracker(&look_changed);
      s_.a.mov(x86::rax, reinterpret_cast<std::uint64_t>(&tracker_->flags.look));
      s_.a.mov(x86::byte_ptr(x86::rax), 1);
      s_.a.jmp(known);
    });
  }
  /// The instruction in front wrote what list `list` says.
  void settle(std::uint32_t list) {
    const asmjit::Label whole = s_.a.newLabel();
    s_.forget();
    jump_if(tracker_->flags.whole, whole);
    s_.a.mov(x86::esi, list);
    call_tracker(&settle_changed);
    s_.a.bind(whole);
  }

  /// Groups that are code once more, as functions: void (Machine&).
  void code_groups() {
    s_.relative = false;
    for (const ChangedPlan::CodeGroup& group : plan_->code_groups()) {
      counts_events_ = group.counts_events;
      targets_.clear();
      for (std::size_t i = group.begin; i < group.end; ++i) expect_target(linked_.instructions[i]);
      groups_.push_back(s_.a.newLabel());
      s_.land(groups_.back());
      s_.a.push(x86::rbx);
      s_.a.mov(x86::rbx, x86::rdi);
      if (counts_events_) {
        s_.a.push(x86::r14);
        s_.a.mov(x86::r14, machine::event_count());
        s_.a.sub(x86::rsp, 8);
      }
      for (std::size_t i = group.begin; i < group.end; ++i) {
        land_at(linked_.instructions[i]);
        translate(linked_.instructions[i]);
      }
      if (group.end < linked_.instructions.size()) land_at(linked_.instructions[group.end]);
      if (counts_events_) {
        s_.a.add(x86::rsp, 8);
        s_.a.pop(x86::r14);
      }
      s_.a.pop(x86::rbx);
      s_.a.ret();
      s_.write_asides();
    }
  }
  /// Where all of it lies.
  void tell_places() {
    ChangeTables& tables = tracker_->tables;
    for (const asmjit::Label& chunk : chunks_) tables.entries.push_back(s_.place_of(chunk));
    for (std::size_t i = 0; i < exits_.size(); ++i) tables.stretches[i].exit = s_.place_of(exits_[i]);
    for (std::size_t i = 0; i < groups_.size(); ++i) tables.codes[i].entry = s_.place_of(groups_[i]);
  }

  // ---- instructions

  void land_at(const LinkedInstruction& instruction) {
    if (const auto target = targets_.find(instruction.position); target != targets_.end()) s_.land(target->second);
  }
  void expect_target(const LinkedInstruction& instruction) {
    if (const auto target = target_of(operation_of(instruction.op).form, instruction.position)) {
      targets_.try_emplace(*target, s_.a.newLabel());
    }
  }
  static bool is_interpreted(const LinkedInstruction& instruction) {
    return operation_of(instruction.op).form == Form::kInterpreted;
  }
  void translate(const LinkedInstruction& instruction) {
    translate({words_.data() + instruction.position, instruction.position, operation_of(instruction.op)});
  }
  void translate(const Instruction& i) {
    const std::uint32_t* const w = i.words;
    switch (i.operation.form) {
      case Form::kReturn:
        s_.a.mov(x86::eax, 1);
        epilogue();
        return s_.forget();
      case Form::kJump:
        s_.a.jmp(targets_.at(w[1]));
        return s_.forget();
      case Form::kJumpUnless:
      case Form::kJumpIf:
        return conditional_jump(i);
      case Form::kLoopJump:
        return loop_jump(i);
      case Form::kCompareJumpUnless:
      case Form::kCompareJumpIf:
        return translate_compare_jump(s_, i, targets_.at(w[4]));
      case Form::kShortRecords4:
      case Form::kShortRecords5:
      case Form::kGeneralRecords:
        return translate_records(s_, i, words_.data(), expressions_);
      case Form::kRunBlock:
        if (translate_block(s_, runtime::load_pointer<stdlib::Step>(w + 1), w[3])) return;
        s_.address(x86::rdi, w[3]);
        s_.a.lea(x86::rsi, machine::step());
        return s_.call_address(runtime::load<std::uint64_t>(w + 1));
      case Form::kRunTaskblock:
        s_.a.mov(x86::rdi, x86::rbx);
        s_.a.mov(x86::esi, i.position);
        s_.address(x86::rdx, w[1]);
        s_.call(&run_taskblock);
        return check();
      case Form::kCallFixed:
        note_place(i.position);
        return call_body(w[1]);
      case Form::kCallRelative:
        s_.address(x86::rdi, w[2]);
        return call_body(w[1]);
      case Form::kCallFunction:
        return call_function(i);
      case Form::kCallLibrary:
        return call_library(i);
      case Form::kClearEvent:
        if (counts_events_) s_.a.mov(x86::r14, machine::event_count());
        return;
      case Form::kEno:
        s_.a.cmp(x86::r14, machine::event_count());
        s_.a.sete(x86::al);
        return s_.store(w[1], 1, reg::kAx);
      default:
        return translate_data(s_, i);
    }
  }

  void conditional_jump(const Instruction& i) {
    const std::uint32_t condition = i.words[1];
    if (s_.holds(condition, 1)) {
      s_.a.test(gp(s_.holder(), 1), gp(s_.holder(), 1));
    } else {
      s_.a.cmp(s_.at(condition, 1), 0);
    }
    s_.a.j(i.operation.form == Form::kJumpIf ? x86::CondCode::kNZ : x86::CondCode::kZ, targets_.at(i.words[2]));
  }

  void loop_jump(const Instruction& i) {
    const asmjit::Label over = s_.a.newLabel();
    s_.a.mov(x86::eax, machine::loops_left());
    note_place(i.position);
    s_.a.sub(x86::eax, 1);
    s_.a.jb(over);
    s_.a.mov(machine::loops_left(), x86::eax);
    s_.a.jmp(targets_.at(i.words[1]));
    s_.forget();
    s_.aside([this, over, position = i.position] {
      s_.a.bind(over);
      s_.a.mov(x86::rdi, x86::rbx);
      s_.a.mov(x86::esi, position);
      s_.call(&fail_loop);
      s_.a.jmp(failed_);
    });
  }

  void call_body(std::uint32_t entry) {
    s_.forget();
    s_.a.call(entries_.at(entry));
    check();
  }

  /// Words: frame, frame bytes, initial bytes (2), entry, inputs, outputs, then 4 per argument: to, from, bytes or
  /// kind, capacities.
  void call_function(const Instruction& i) {
    const std::uint32_t* const w = i.words;
    reset_frame(w[1], runtime::load_pointer<const std::byte*>(w + 3), w[2]);
    const std::uint32_t* argument = w + 8;
    for (const std::uint32_t* const end = argument + std::size_t{w[6]} * 4; argument != end; argument += 4) {
      pass(i.position, argument);
    }
    call_body(w[5]);
    for (const std::uint32_t* const end = argument + std::size_t{w[7]} * 4; argument != end; argument += 4) {
      pass(i.position, argument);
    }
  }
  void reset_frame(std::uint32_t frame, const std::byte* initial, std::uint32_t bytes) {
    s_.forget();
    if (bytes > kInlineFrameBytes) {
      s_.address(x86::rdi, frame);
      s_.a.mov(x86::rsi, reinterpret_cast<std::uint64_t>(initial));
      s_.a.mov(x86::edx, bytes);
      return s_.call_address(reinterpret_cast<std::uint64_t>(&std::memcpy));
    }
    for (std::uint32_t at = 0; at < bytes;) {
      const unsigned step = bytes - at >= 8 ? 8 : bytes - at >= 4 ? 4 : bytes - at >= 2 ? 2 : 1;
      std::uint64_t value = 0;
      std::memcpy(&value, initial + at, step);
      s_.a.mov(x86::rax, value);
      s_.a.mov(s_.at(frame + at, step), gp(reg::kAx, step));
      at += step;
    }
  }
  /// One argument of a function: words to, from, bytes or kind, capacities (runtime::pass).
  void pass(std::uint32_t position, const std::uint32_t* argument) {
    switch (argument[2]) {
      case 1:
      case 2:
      case 4:
      case 8:
        s_.forget();
        s_.load(reg::kAx, argument[1], argument[2]);
        return s_.store(argument[0], argument[2], reg::kAx);
      case runtime::kPassStr:
      case runtime::kPassWstr:
        break;
      default:
        s_.address(x86::rdi, argument[0]);
        s_.address(x86::rsi, argument[1]);
        s_.a.mov(x86::edx, argument[2]);
        return s_.call_address(reinterpret_cast<std::uint64_t>(&std::memmove));
    }
    const asmjit::Label cut = s_.a.newLabel();
    const asmjit::Label done = s_.a.newLabel();
    s_.address(x86::rdi, argument[0]);
    s_.address(x86::rsi, argument[1]);
    s_.a.mov(x86::edx, argument[3]);
    s_.a.mov(x86::ecx, argument[2] == runtime::kPassStr ? 1 : 2);
    s_.call(&copy_text);
    s_.a.test(x86::al, x86::al);
    s_.a.jz(cut);
    s_.a.bind(done);
    s_.aside([this, cut, done, position] {
      s_.a.bind(cut);
      s_.raise(position, static_cast<int>(stdlib::Event::kTruncated));
      s_.a.jmp(done);
    });
  }

  /// Words: kernel (2), arguments, result, then the arguments.
  void call_library(const Instruction& i) {
    const std::uint32_t* const w = i.words;
    const std::uint32_t count = w[3];
    const std::uint32_t stack = s_.relative ? (count * 8 + 15) / 16 * 16 : 0;
    if (s_.relative) {
      s_.a.sub(x86::rsp, stack);
      for (std::uint32_t n = 0; n < count; ++n) {
        s_.address(x86::rax, w[5 + n]);
        s_.a.mov(x86::qword_ptr(x86::rsp, static_cast<std::int32_t>(n * 8)), x86::rax);
      }
      s_.a.mov(x86::rsi, x86::rsp);
    } else {
      std::vector<std::uint64_t> arguments;
      for (std::uint32_t n = 0; n < count; ++n) arguments.push_back(s_.address_of(w[5 + n]));
      s_.a.lea(x86::rsi, x86::ptr(s_.data(std::move(arguments))));
    }
    s_.address(x86::rdi, w[4]);
    s_.a.mov(x86::edx, count);
    s_.call_address(runtime::load<std::uint64_t>(w + 1));
    if (s_.relative) s_.a.add(x86::rsp, stack);
    const asmjit::Label event = s_.a.newLabel();
    const asmjit::Label done = s_.a.newLabel();
    s_.a.test(x86::al, x86::al);
    s_.a.jnz(event);
    s_.a.bind(done);
    s_.aside([this, event, done, position = i.position] {
      s_.a.bind(event);
      s_.raise(position, -1);
      s_.a.jmp(done);
    });
  }

  /// The number behind an instruction, or behind those that the interpreter runs at once: as far as nobody jumps between
  /// them.
  [[nodiscard]] std::size_t next_of(std::span<const LinkedInstruction> instructions, std::size_t i) const {
    const bool interpreted = is_interpreted(instructions[i]);
    do {
      ++i;
    } while (interpreted && i < instructions.size() && is_interpreted(instructions[i]) &&
             !targets_.contains(instructions[i].position));
    return i;
  }
  /// Instructions [first, next) run in the interpreter: copied behind the resolved code, with a RETURN.
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
    s_.a.mov(x86::rdi, x86::rbx);
    s_.a.mov(x86::esi, static_cast<std::uint32_t>(body.addressing));
    s_.a.mov(x86::edx, start);
    if (s_.relative) {
      s_.instance_offset(x86::rcx);
    } else {
      s_.a.xor_(x86::ecx, x86::ecx);
    }
    s_.call(&runtime::run_body);
    check();
  }
  /// Where the words of an instruction without records end.
  [[nodiscard]] std::uint32_t end_of(std::span<const LinkedInstruction> instructions, std::size_t i) const {
    if (i + 1 < instructions.size()) return instructions[i + 1].position;
    return instructions[i].position + 1;
  }

  const LinkedCode& linked_;
  const ChangedPlan* plan_;
  std::unique_ptr<ChangeTracker> tracker_;
  Assembly s_;
  std::vector<std::uint32_t> words_;
  std::vector<runtime::CodeMark> marks_;
  BooleanExpressions expressions_;
  std::unordered_map<std::uint32_t, asmjit::Label> entries_;  ///< of bodies, by position
  std::unordered_map<std::uint32_t, asmjit::Label> targets_;  ///< of jumps in this body, by position
  asmjit::Label failed_;                                      ///< of this body: the scan is over
  bool counts_events_ = false;                                ///< this body has an ENO
  std::vector<asmjit::Label> chunks_;                         ///< by chunk: its straight code
  std::vector<asmjit::Label> exits_;                          ///< of stretches
  std::vector<asmjit::Label> groups_;                         ///< that are code
  CompileReport report_;
};

}  // namespace

core::Result<std::unique_ptr<NativeTask>> compile(runtime::Program& program, const CompileOptions& options) {
  const LinkedCode& linked = program.linked();
  const std::span<std::byte> table(program.table().data(), program.table().layout().total);
  std::unique_ptr<ChangedPlan> plan;
  std::unique_ptr<ChangeTracker> tracker;
  std::size_t bytes = linked.words.size() / sizeof(std::uint32_t) * kBytesPerWord + kBytesBeside;
  if (options.changed) {
    plan = std::make_unique<ChangedPlan>(linked, program.table().layout());
    tracker = std::make_unique<ChangeTracker>(table.data(), table.size(), plan->take_tables(), options.patience);
    bytes *= kCodeWithGroups;
  }
  auto memory = CodeMemory::reserve(table, bytes);
  if (!memory) return memory.error();
  TaskCompiler compiler(linked, table.data(), memory->address(), plan.get(), std::move(tracker));
  compiler.compile();
  const std::vector<std::byte> code = compiler.code();
  if (!compiler.problem().empty() || code.size() > memory->reserved()) {
    return core::Problem{core::Code::P9001, "native code could not be made: " + compiler.problem(), {}};
  }
  const auto at = memory->fill(code);
  if (!at) return at.error();
  return compiler.task(std::move(*memory), *at);
}

}  // namespace plc::native
