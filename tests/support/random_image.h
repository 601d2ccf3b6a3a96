// RandomImage: valid images made from a seed, that use every instruction on values of every type.
//
// Out: an image of one to three tasks, whose programs call functions and function blocks with one or several instances.
// All bodies are random instructions on random variables, so that results mean nothing and cover much. Variables are
// declared when an instruction first wants one, so images are small and their values meet often. Does not belong here:
// single instructions (random_instructions.h), loops with forms of their own (random_loops.h), inputs
// (random_inputs.h).
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/random_loops.h"

namespace plc::test {

class RandomImage : private RandomLoops {
 public:
  /// With taskblocks of the registry, which whoever runs the image must have; null = those that come with PICARD.
  explicit RandomImage(std::uint64_t seed, const taskblocks::Registry* registry = nullptr)
      : RandomLoops(seed, registry) {}

  /// `statements` in the programs and about as many in what they call.
  Image make(std::size_t statements) {
    static constexpr core::Coherence kProtocols[] = {core::Coherence::kWaitFree, core::Coherence::kWaitFree,
                                                     core::Coherence::kGlobalLock, core::Coherence::kPriorityCeiling};
    b_.image.options.coherence = random_.one_of(kProtocols);
    tasks_ = random_.once_in(4) ? 2 + below(2) : 1;
    // Now and then so much that most of a table is further away than 16 bits reach.
    if (random_.once_in(200)) b_.global("far", b_.array(b_.type(TypeId::kByte), 70'000), {}, {.constant = true});
    make_types();
    for (std::size_t n = below(3); n > 0; --n) make_function(1 + below(statements / 4 + 1));
    for (std::size_t n = below(4); n > 0; --n) make_block(1 + below(statements / 3 + 1));
    assign_programs();
    for (std::size_t n = 0; n < users_.size(); ++n) make_program(n, statements / users_.size() + 1);
    for (std::size_t task = 0; task < tasks_; ++task) {
      std::vector<std::uint32_t> programs;
      for (std::size_t n = 0; n < users_.size(); ++n) {
        programs.insert(programs.end(), static_cast<std::size_t>(std::count(users_[n].begin(), users_[n].end(), task)),
                        programs_[n]);
      }
      b_.task("T" + std::to_string(task), kPeriodNs, programs, static_cast<std::int32_t>(task));
    }
    for (Queue& queue : queues_) {
      std::sort(queue.puts.begin(), queue.puts.end());
      queue.puts.erase(std::unique(queue.puts.begin(), queue.puts.end()), queue.puts.end());
      b_.image.queues.push_back({queue.name, queue.type, queue.capacity, queue.puts, queue.takes});
    }
    return b_.build();
  }

  static constexpr std::int64_t kPeriodNs = 10'000'000;

 private:
  struct Parameter {
    Word number;  ///< among the variables of the frame
    FieldRole role;
    std::uint32_t type;
  };
  struct Function {
    std::uint32_t pou;
    std::vector<Parameter> parameters;
  };
  struct Queue {
    std::string name;
    std::uint32_t type;
    std::uint32_t capacity;
    std::vector<std::uint32_t> puts;
    std::uint32_t takes;
  };

  // ---- bodies

  void make_function(std::size_t statements) {
    PouBuilder pou = b_.pou("Function" + std::to_string(functions_.size()), PouKind::kFunction);
    Scope scope{pou, PouKind::kFunction};
    Function made;
    const auto parameter = [&](FieldRole role, std::uint32_t index) {
      const Word word = pou.frame(scope.name(), index, role, initial(index));
      made.parameters.push_back({static_cast<Word>(made.parameters.size()), role, index});
      if (type(index).kind == TypeKind::kRef || type(index).kind >= TypeKind::kArray)
        scope.wholes.push_back({index, word});
      note(scope.leaves, index, word);
    };
    for (std::size_t n = below(5); n > 0; --n) {
      const std::uint32_t index = random_.once_in(4) ? random_.one_of(aggregates_) : type_of(any_type());
      static constexpr FieldRole kRoles[] = {FieldRole::kInput, FieldRole::kInput, FieldRole::kOutput,
                                             FieldRole::kInOut};
      const FieldRole role = random_.one_of(kRoles);
      parameter(role, role == FieldRole::kInOut ? ref_type(index) : index);
    }
    parameter(FieldRole::kReturnValue, random_.once_in(6) ? random_.one_of(aggregates_) : type_of(any_type()));
    // Some frames are too large to be set up by instructions of their own.
    if (random_.once_in(4)) pou.frame(scope.name(), b_.array(b_.type(TypeId::kDint), 40), FieldRole::kTemp);
    for (std::size_t i = 0; i < statements; ++i) statement(scope, 0);
    made.pou = pou.finish();
    functions_.push_back(std::move(made));
  }
  void make_block(std::size_t statements) {
    PouBuilder pou = b_.pou("Block" + std::to_string(pous_.size()), PouKind::kFunctionBlock);
    Scope scope{pou, PouKind::kFunctionBlock};
    for (std::size_t i = 0; i < statements; ++i) statement(scope, 0);
    Block made;
    for (std::size_t t = 0; t < core::kTypeCount; ++t) {
      for (const Word word : scope.leaves[t]) {
        if (bytecode::space_of(word) != Space::kInstance || made.leaves.size() >= 6) continue;
        made.leaves.emplace_back(static_cast<TypeId>(t), bytecode::offset_of(word));
      }
    }
    made.pou = pou.finish();
    made.type = b_.image.pous[made.pou].instance_type;
    if (type(made.type).size == 0) return;  // no variable, no instance
    made.row = b_.array(made.type, 3, -1);
    pous_.push_back(std::move(made));
  }
  /// Which tasks run which programs; a program may have several instances.
  void assign_programs() {
    for (std::uint32_t task = 0; task < tasks_; ++task) users_.push_back({task});
    while (random_.once_in(4)) users_.push_back({static_cast<std::uint32_t>(below(tasks_))});
    if (random_.once_in(4)) users_[below(users_.size())].push_back(static_cast<std::uint32_t>(below(tasks_)));
  }
  void make_program(std::size_t n, std::size_t statements) {
    PouBuilder pou = b_.pou("Main" + std::to_string(n), PouKind::kProgram);
    Scope scope{pou, PouKind::kProgram, users_[n]};
    for (std::size_t i = 0; i < statements; ++i) statement(scope, 0);
    programs_.push_back(pou.finish());
  }

  // ---- statements

  void statement(Scope& scope, int depth) {
    switch (below(31)) {
      case 0:
      case 1:
        return records(scope);
      case 28:
      case 29:
      case 30:
        return through_pointer(scope);
      case 2:
      case 3:
        return call_library(scope);
      case 4:
      case 5:
        return run_block(scope);
      case 6:
      case 7:
        return part_of_value(scope);
      case 8:
      case 9:
        return through_reference(scope);
      case 10:
        return bits(scope);
      case 11:
        return with_eno(scope, depth);
      case 12:
      case 13:
        if (depth < 3) branch(scope, depth);
        return;
      case 14:
        if (depth < 2) loop(scope, depth);
        return;
      case 27:
        if (depth < 3) counted(scope);
        return;
      case 15:
        return call_function(scope);
      case 16:
      case 17:
        return call_block(scope);
      case 18:
        return references(scope);
      case 19:
        return exchange(scope);
      case 20:
        return copy(scope);
      case 21:
        if (depth > 0 && random_.once_in(4)) scope.pou.op(Opcode::kReturn);
        return;
      case 22:
        return straight(scope);
      default:
        return plain(scope);
    }
  }

  void call_block(Scope& scope) {
    if (scope.kind == PouKind::kFunction || pous_.empty()) return;
    const Block& block = random_.one_of(pous_);
    if (random_.once_in(2)) {
      const Word at = instance(scope, block.type);
      if (!block.leaves.empty() && random_.once_in(2)) {
        const auto& [id, offset] = random_.one_of(block.leaves);
        move(scope, id, at + offset, read(scope, id));
      }
      scope.pou.op(Opcode::kCallPou, {block.pou, at});
      if (!block.leaves.empty()) {
        const auto& [id, offset] = random_.one_of(block.leaves);
        move(scope, id, write(scope, id), at + offset);
      }
      return;
    }
    const Word row = instance(scope, block.row);
    const Steps steps = {index_step(scope, block.row)};
    if (random_.once_in(2)) {
      scope.pou.path(Opcode::kCallAt, {block.pou, row, block.row}, steps);
      return;
    }
    const bool element = random_.once_in(2);
    const Word ref = whole(scope, ref_type(element ? block.type : block.row));
    if (!random_.once_in(4)) scope.pou.path(Opcode::kRefAt, {ref, row, block.row}, element ? steps : Steps{});
    scope.pou.path(Opcode::kCallVia, {block.pou, ref, element ? block.type : block.row}, element ? Steps{} : steps);
  }

  void with_eno(Scope& scope, int depth) {
    scope.pou.op(Opcode::kClearEvent);
    for (std::size_t n = 1 + below(2); n > 0; --n) {
      if (random_.once_in(2)) {
        call_library(scope);
      } else {
        depth < 2 ? statement(scope, 2) : plain(scope);
      }
    }
    scope.pou.op(Opcode::kEno, {write(scope, TypeId::kBool)});
  }

  void branch(Scope& scope, int depth) {
    PouBuilder& pou = scope.pou;
    Word condition = 0;
    std::optional<std::uint32_t> early;
    if (random_.once_in(4)) {
      condition = read(scope, TypeId::kBool);
    } else {
      // Often of the kind that becomes one instruction with the jump after it.
      condition = write(scope, TypeId::kBool);
      const bool split = random_.once_in(8);
      if (split) early = pou.jump(Opcode::kJumpIf, {read(scope, TypeId::kBool)});
      compare(scope, condition);
    }
    if (early) pou.land(*early);
    const std::uint32_t jump = pou.jump(random_.once_in(2) ? Opcode::kCondJump : Opcode::kJumpIf, {condition});
    for (std::size_t n = 1 + below(3); n > 0; --n) statement(scope, depth + 1);
    if (!random_.once_in(3)) return pou.land(jump);
    const std::uint32_t end = pou.jump(Opcode::kJump);
    pou.land(jump);
    for (std::size_t n = below(3); n > 0; --n) statement(scope, depth + 1);
    pou.land(end);
  }

  void inside_loop(Scope& scope, int depth) {
    if (random_.once_in(4)) return short_if(scope);
    statement(scope, depth + 1);
  }

  void loop(Scope& scope, int depth) {
    PouBuilder& pou = scope.pou;
    if (random_.once_in(8)) {
      // Until somebody says so, or the loop budget is used up.
      const std::uint32_t top = pou.here();
      for (std::size_t n = below(3); n > 0; --n) inside_loop(scope, depth);
      const std::uint32_t out = pou.jump(Opcode::kCondJump, {read(scope, TypeId::kBool)});
      pou.op(Opcode::kLoopJump, {top});
      pou.land(out);
      return;
    }
    // A counter that nobody else writes.
    const bool wide = random_.once_in(2);
    const TypeId id = wide ? TypeId::kDint : TypeId::kInt;
    const Word counter = pou.frame(scope.name(), b_.type(id), FieldRole::kTemp);
    const Word more = pou.frame(scope.name(), b_.boolean(), FieldRole::kTemp);
    const auto number_of = [&](int n) {
      return wide ? b_.constant<std::int32_t>(id, n) : b_.constant<std::int16_t>(id, static_cast<std::int16_t>(n));
    };
    move(scope, id, counter, number_of(0));
    const std::uint32_t top = pou.here();
    for (std::size_t n = 1 + below(3); n > 0; --n) inside_loop(scope, depth);
    pou.op(wide ? Opcode::kAdd32 : Opcode::kAdd16, {counter, counter, number_of(1)});
    pou.op(wide ? Opcode::kLtI32 : Opcode::kLtI16, {more, counter, number_of(1 + static_cast<int>(below(4)))});
    const std::uint32_t out = pou.jump(Opcode::kCondJump, {more});
    pou.op(Opcode::kLoopJump, {top});
    pou.land(out);
  }

  void call_function(Scope& scope) {
    if (functions_.empty()) return;
    const Function& function = random_.one_of(functions_);
    std::vector<Word> words{function.pou};
    for (const Parameter& p : function.parameters) {
      if (random_.once_in(8)) continue;
      if (p.role == FieldRole::kInOut && random_.once_in(2)) {
        const Word ref = whole(scope, p.type);
        refer(scope, ref, type(p.type).element);
        words.insert(words.end(), {p.number, ref});
        continue;
      }
      const bool written = p.role == FieldRole::kOutput || p.role == FieldRole::kReturnValue;
      words.insert(words.end(), {p.number, value(scope, p.type, written)});
    }
    const auto count = static_cast<std::uint32_t>((words.size() - 1) / 2);
    scope.pou.list(Opcode::kCallFn, count, std::move(words));
  }

  /// Queues: a program of one task may take, all may put.
  void exchange(Scope& scope) {
    if (scope.kind != PouKind::kProgram) return;
    if (queues_.empty() || (queues_.size() < 3 && random_.once_in(3))) {
      const std::uint32_t index = random_.once_in(2) ? random_.one_of(aggregates_) : type_of(any_type());
      queues_.push_back({"q" + std::to_string(queues_.size()),
                         index,
                         static_cast<std::uint32_t>(1 + below(4)),
                         {},
                         bytecode::ImageQueue::kNoTask});
    }
    const std::size_t n = below(queues_.size());
    Queue& queue = queues_[n];
    const auto index = static_cast<Word>(n);
    const bool alone =
        std::all_of(scope.tasks.begin(), scope.tasks.end(), [&](std::uint32_t t) { return t == scope.tasks.front(); });
    const bool may_take = alone && (queue.takes == bytecode::ImageQueue::kNoTask || queue.takes == scope.tasks.front());
    // Queues hold values of exactly their type.
    const auto place = [&] {
      return type(queue.type).kind >= TypeKind::kArray ? whole(scope, queue.type) : declare(scope, queue.type);
    };
    switch (below(4)) {
      case 0:
        if (!may_take) return;
        queue.takes = scope.tasks.front();
        scope.pou.op(Opcode::kQueueGet, {write(scope, TypeId::kBool), index, place(), queue.type});
        return;
      case 1:
        scope.pou.op(Opcode::kQueueCount, {write(scope, TypeId::kUdint), index});
        return;
      case 2:
        scope.pou.op(Opcode::kQueueSpace, {write(scope, TypeId::kUdint), index});
        break;
      default:
        scope.pou.op(Opcode::kQueuePut, {write(scope, TypeId::kBool), index, place(), queue.type});
    }
    queue.puts.insert(queue.puts.end(), scope.tasks.begin(), scope.tasks.end());
  }

  std::vector<Function> functions_;
  std::vector<Block> pous_;
  std::vector<std::vector<std::uint32_t>> users_;  ///< by program: the task of each instance
  std::vector<std::uint32_t> programs_;
  std::vector<Queue> queues_;
};

}  // namespace plc::test
