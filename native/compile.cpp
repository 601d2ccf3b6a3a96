#include "native/compile.h"

#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <span>
#include <unordered_map>
#include <utility>

#include "bytecode/image.h"
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
/// Initial values of a function's frame that are written by instructions of their own; more is copied.
constexpr std::uint32_t kInlineFrameBytes = 64;

/// Code of more records than this runs slower than the records themselves: a record takes about 40 bytes of code, and
/// from one and a half times the processor's second cache on fetching it costs more than looking up (bench/README.md).
std::size_t most_records_as_code() {
  constexpr long kUsualCache = 1024 * 1024;
  const long cache = ::sysconf(_SC_LEVEL2_CACHE_SIZE);
  return static_cast<std::size_t>(cache > 0 ? cache : kUsualCache) * 3 / 2 / 40;
}

class TaskCompiler {
 public:
  TaskCompiler(const LinkedCode& linked, std::byte* table, std::uint64_t address)
      : linked_(linked),
        s_(table, address),
        words_(linked.data(), linked.data() + linked.words.size() / sizeof(std::uint32_t)),
        marks_(linked.marks) {}

  void compile(const CompileOptions& options) {
    records_as_data_ = records() > options.most_records_as_code.value_or(most_records_as_code());
    for (const LinkedBody& body : linked_.bodies) entries_.emplace(body.entry, s_.label());
    entry();
    for (std::size_t b = 0; b < linked_.bodies.size(); ++b) {
      const std::size_t begin = s_.size();
      const bool last = b + 1 == linked_.bodies.size();
      body(linked_.bodies[b], last ? linked_.instructions.size() : linked_.bodies[b + 1].first);
      report_.bodies.push_back({linked_.bodies[b].pou, s_.size() - begin});
    }
    s_.write_data();
    report_.code_bytes = s_.size();
  }

  /// All boolean logic of the task.
  [[nodiscard]] std::size_t records() const {
    std::size_t count = 0;
    for (const LinkedInstruction& instruction : linked_.instructions) {
      const Form form = operation_of(instruction.op).form;
      const bool is_run = form == Form::kShortRecords4 || form == Form::kShortRecords5 || form == Form::kGeneralRecords;
      if (is_run) count += linked_.data()[instruction.position + 1];
    }
    return count;
  }

  [[nodiscard]] const std::string& problem() const { return s_.problem(); }
  std::vector<std::byte> code() { return s_.finish(); }
  std::unique_ptr<NativeTask> task(CodeMemory memory, const std::byte* at) {
    return std::make_unique<NativeTask>(std::move(memory), at, std::move(words_), std::move(marks_),
                                        std::move(report_));
  }

 private:
  /// What C++ calls: bool (Machine&).
  void entry() {
    s_.begin_entry();
    s_.call_body(entries_.at(linked_.entry));
    s_.end_entry();
  }

  // ---- one body

  void body(const LinkedBody& body, std::size_t end) {
    const std::span<const LinkedInstruction> instructions =
        std::span(linked_.instructions).subspan(body.first, end - body.first);
    s_.relative = body.addressing == Addressing::kRelative;
    bool counts_events = false;
    targets_.clear();
    for (const LinkedInstruction& instruction : instructions) {
      const Operation operation = operation_of(instruction.op);
      counts_events = counts_events || operation.form == Form::kEno;
      if (const auto target = target_of(operation.form, instruction.position)) {
        targets_.try_emplace(*target, s_.label());
      }
    }
    failed_ = s_.label();
    s_.land(entries_.at(body.entry));
    s_.begin_body(counts_events);
    for (std::size_t i = 0; i < instructions.size();) {
      if (const auto target = targets_.find(instructions[i].position); target != targets_.end()) {
        s_.land(target->second);
      }
      const Operation operation = operation_of(instructions[i].op);
      if (operation.form == Form::kInterpreted) {
        i = interpret(body, instructions, i);
      } else {
        const std::uint32_t position = instructions[i].position;
        // Not in words_, which grow while code behind the body (Emitter::aside) still reads the instruction.
        translate({linked_.data() + position, position, operation});
        ++i;
      }
      s_.keep_asides_near();
    }
    s_.write_asides();
    s_.land(failed_);
    s_.leave_body(false);
  }

  /// The scan ends here unless what was called returned TRUE.
  void check() { s_.jump_if_result(false, failed_); }

  /// Where a jump goes.
  [[nodiscard]] std::optional<std::uint32_t> target_of(Form form, std::uint32_t position) const {
    const std::uint32_t* const words = linked_.data() + position;
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

  // ---- instructions

  void translate(const Instruction& i) {
    const std::uint32_t* const w = i.words;
    switch (i.operation.form) {
      case Form::kReturn:
        return s_.leave_body(true);
      case Form::kJump:
        return s_.jump(targets_.at(w[1]));
      case Form::kJumpUnless:
        return s_.jump_if(w[1], false, targets_.at(w[2]));
      case Form::kJumpIf:
        return s_.jump_if(w[1], true, targets_.at(w[2]));
      case Form::kLoopJump:
        return loop_jump(i);
      case Form::kCompareJumpUnless:
      case Form::kCompareJumpIf:
        return translate_compare_jump(s_, i, targets_.at(w[4]));
      case Form::kShortRecords4:
      case Form::kShortRecords5:
      case Form::kGeneralRecords:
        if (records_as_data_ && !s_.relative) return call_records(i);
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

  /// Words: count, then the window and the position of short records, or general records.
  void call_records(const Instruction& i) {
    const bool general = i.operation.form == Form::kGeneralRecords;
    // Those of the program, which outlives its native code.
    const std::uint32_t* const records = linked_.data() + (general ? i.position + 2 : i.words[3]);
    s_.pass(2, i.words[1]);
    s_.pass(1, reinterpret_cast<std::uint64_t>(records));
    s_.pass_address(0, general ? 0 : i.words[2]);
    if (general) return s_.call(&run_general_records);
    s_.call(i.operation.form == Form::kShortRecords4 ? &run_records_of_4 : &run_records_of_5);
  }

  void loop_jump(const Instruction& i) {
    const asmjit::Label over = s_.label();
    s_.take_loop(i.position, over);
    s_.jump(targets_.at(i.words[1]));
    s_.aside([this, over, position = i.position] {
      s_.land(over);
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
    if (bytes > kInlineFrameBytes) {
      s_.pass(2, bytes);
      s_.pass(1, reinterpret_cast<std::uint64_t>(initial));
      s_.pass_address(0, frame);
      return s_.call_address(reinterpret_cast<std::uint64_t>(&std::memcpy));
    }
    for (std::uint32_t at = 0; at < bytes;) {
      const unsigned step = bytes - at >= 8 ? 8 : bytes - at >= 4 ? 4 : bytes - at >= 2 ? 2 : 1;
      std::uint64_t value = 0;
      std::memcpy(&value, initial + at, step);
      s_.store_constant(frame + at, step, value);
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
        return s_.move(argument[0], argument[1], argument[2]);
      case runtime::kPassStr:
      case runtime::kPassWstr:
        break;
      default:
        s_.pass(2, argument[2]);
        s_.pass_address(1, argument[1]);
        s_.pass_address(0, argument[0]);
        return s_.call_address(reinterpret_cast<std::uint64_t>(&std::memmove));
    }
    s_.pass(3, argument[2] == runtime::kPassStr ? 1 : 2);
    s_.pass(2, argument[3]);
    s_.pass_address(1, argument[1]);
    s_.pass_address(0, argument[0]);
    s_.call(&copy_text);
    const asmjit::Label cut = s_.label();
    const asmjit::Label done = s_.label();
    s_.jump_if_result(false, cut);
    s_.bind(done);
    s_.aside([this, cut, done, position] {
      s_.land(cut);
      s_.raise(position, static_cast<int>(stdlib::Event::kTruncated));
      s_.jump(done);
    });
  }

  /// Words: kernel (2), arguments, result, then the arguments.
  void call_library(const Instruction& i) {
    const std::uint32_t* const w = i.words;
    s_.call_kernel(runtime::load<std::uint64_t>(w + 1), w[4], {w + 5, w[3]});
    const asmjit::Label event = s_.label();
    const asmjit::Label done = s_.label();
    s_.jump_if_result(true, event);
    s_.bind(done);
    s_.aside([this, event, done, position = i.position] {
      s_.land(event);
      s_.raise(position, -1);
      s_.jump(done);
    });
  }

  /// Instructions from number `first` on that the interpreter runs, as far as nobody jumps between them: copied behind
  /// the resolved code, with a RETURN. Returns the number of the next one.
  std::size_t interpret(const LinkedBody& body, std::span<const LinkedInstruction> instructions, std::size_t first) {
    const auto start = static_cast<std::uint32_t>(words_.size());
    std::size_t i = first;
    do {
      const std::uint32_t position = instructions[i].position;
      const std::uint32_t end = end_of(instructions, i);
      const auto at = static_cast<std::uint32_t>(words_.size());
      const runtime::CodeMark& mark = runtime::mark_at(linked_.marks, position);
      marks_.push_back({at, mark.pou, mark.word});
      words_.resize(at + (end - position));
      std::copy(words_.begin() + position, words_.begin() + end, words_.begin() + at);
      ++report_.interpreted[instructions[i].op];
      ++i;
    } while (i < instructions.size() && operation_of(instructions[i].op).form == Form::kInterpreted &&
             !targets_.contains(instructions[i].position));
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
    return i;
  }
  /// Where the words of an instruction without records end.
  [[nodiscard]] std::uint32_t end_of(std::span<const LinkedInstruction> instructions, std::size_t i) const {
    if (i + 1 < instructions.size()) return instructions[i + 1].position;
    return instructions[i].position + 1;
  }

  const LinkedCode& linked_;
  Assembly s_;
  std::vector<std::uint32_t> words_;
  std::vector<runtime::CodeMark> marks_;
  BooleanExpressions expressions_;
  std::unordered_map<std::uint32_t, asmjit::Label> entries_;  ///< of bodies, by position
  std::unordered_map<std::uint32_t, asmjit::Label> targets_;  ///< of jumps in this body, by position
  asmjit::Label failed_;                                      ///< of this body: the scan is over
  bool records_as_data_ = false;                              ///< boolean logic is not made code
  CompileReport report_;
};

}  // namespace

core::Result<std::unique_ptr<NativeTask>> compile(runtime::Program& program, const CompileOptions& options) {
  const LinkedCode& linked = program.linked();
  const std::span<std::byte> table(program.table().data(), program.table().layout().total);
  auto memory = CodeMemory::reserve(table, linked.words.size() / sizeof(std::uint32_t) * kBytesPerWord + kBytesBeside);
  if (!memory) return memory.error();
  TaskCompiler compiler(linked, table.data(), memory->address());
  compiler.compile(options);
  const std::vector<std::byte> code = compiler.code();
  if (!compiler.problem().empty() || code.size() > memory->reserved()) {
    return core::Problem{core::Code::P9001, "native code could not be made: " + compiler.problem(), {}};
  }
  const auto at = memory->fill(code);
  if (!at) return at.error();
  return compiler.task(std::move(*memory), *at);
}

}  // namespace plc::native
