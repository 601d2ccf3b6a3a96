// RandomImage: valid images made from a seed, that use every instruction on values of every type.
//
// Out: an image of one to three tasks, whose programs call functions and function blocks with one or several instances.
// All bodies are random instructions on random variables, so that results mean nothing and cover much. Variables are
// declared when an instruction first wants one, so images are small and their values meet often. Does not belong here:
// what they compute, inputs (random_inputs.h).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/support/random_variables.h"

namespace plc::test {

class RandomImage : private RandomVariables {
 public:
  /// With taskblocks of the registry, which whoever runs the image must have; null = those that come with PICARD.
  explicit RandomImage(std::uint64_t seed, const taskblocks::Registry* registry = nullptr)
      : RandomVariables(seed, registry) {}

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
  using Steps = std::vector<PouBuilder::Step>;

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
    switch (below(28)) {
      case 0:
      case 1:
        return records(scope);
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
  /// What the interpreter arranges.
  void straight(Scope& scope) {
    static constexpr std::string_view kChoices[] = {"SEL", "LIMIT", "MIN", "MAX", "SHL", "SHR", "ROL", "ROR"};
    if (random_.once_in(4)) return ladder(scope);
    for (std::size_t n = 6 + below(60); n > 0; --n) {
      switch (below(8)) {
        case 0:
        case 1:
          records(scope);
          break;
        case 2:
          call_library(scope, stdlib::overloads_named(random_.one_of(kChoices)));
          break;
        case 3:
          run_block(scope);
          break;
        default:
          plain(scope);
      }
    }
  }

  /// Rungs on variables that lie side by side, with blocks and other instructions on the same variables between them:
  /// bits in registers, if they do not wait for each other too often.
  void ladder(Scope& scope) {
    const std::size_t bools = 10 + below(120);
    const Word first = declare(scope, b_.array(b_.type(TypeId::kBool), static_cast<std::uint32_t>(bools)));
    decltype(scope.leaves) fields;  // of the blocks
    const auto variable = [&] {
      const std::vector<Word>& ports = fields[number(TypeId::kBool)];
      if (!ports.empty() && random_.once_in(10)) return random_.one_of(ports);
      return first + static_cast<Word>(below(bools));
    };
    const bool four = random_.once_in(2);
    const std::size_t others = random_.once_in(2) ? 0 : 1 + below(10);
    for (std::size_t n = 0; n <= others; ++n) {
      std::vector<Word> words;
      const std::size_t count = 10 + below(others == 0 ? 90 : 20);
      for (std::size_t i = 0; i < count; ++i) {
        const auto truth = static_cast<std::uint32_t>(random_.bits());
        words.push_back(four ? (truth & 0xffffu) * 0x10001u : truth);
        words.push_back(random_.once_in(20) ? write(scope, TypeId::kBool) : variable());
        for (int k = 0; k < 5; ++k) words.push_back(random_.once_in(40) ? read(scope, TypeId::kBool) : variable());
      }
      scope.pou.list(Opcode::kBoolRun, static_cast<std::uint32_t>(count), std::move(words));
      if (n == others) return;
      if (scope.kind == PouKind::kFunction || blocks_.empty() || random_.once_in(3)) {
        plain(
            scope, [&](TypeId id) { return id == TypeId::kBool ? variable() : read(scope, id); },
            [&](TypeId id) { return id == TypeId::kBool ? variable() : write(scope, id); });
        continue;
      }
      const Block& block = random_.one_of(blocks_);
      const Word at = instance(scope, block.type);
      note(fields, block.type, at);
      scope.pou.op(Opcode::kRunTb, {block.pou, at});
    }
  }

  void records(Scope& scope) {
    std::vector<Word> words;
    const std::size_t count = random_.once_in(400) ? 500 + below(3000) : 1 + below(random_.once_in(6) ? 40 : 8);
    // Mostly of four inputs and often what rungs are made of, else any function.
    static constexpr std::uint32_t kUsual[] = {0x80008000u, 0xfffefffeu, 0xf888f888u, 0xa8a8a8a8u,
                                               0x96969696u, 0xcacacacau, 0x88888888u, 0x55555555u,
                                               0xaaaaaaaau, 0u,          ~0u};
    std::vector<Word> in;
    for (int n = 0; n < 6; ++n) in.push_back(read(scope, TypeId::kBool));
    Word last = in.front();
    for (std::size_t i = 0; i < count; ++i) {
      const auto truth = static_cast<std::uint32_t>(random_.bits());
      words.push_back(random_.once_in(2)   ? random_.one_of(kUsual)
                      : random_.once_in(2) ? truth
                                           : (truth & 0xffffu) * 0x10001u);
      const Word out = write(scope, TypeId::kBool);
      words.push_back(out);
      for (int k = 0; k < 5; ++k) {
        words.push_back(random_.once_in(3)   ? last
                        : random_.once_in(6) ? read(scope, TypeId::kBool)
                                             : random_.one_of(in));
      }
      last = out;
    }
    scope.pou.list(Opcode::kBoolRun, static_cast<std::uint32_t>(count), std::move(words));
  }

  void call_library(Scope& scope) {
    // Most overloads are conversions; what engines have code of their own for is more often something else.
    static constexpr std::string_view kCommon[] = {"SEL", "MUX", "LIMIT", "MIN", "MAX", "ABS", "SQRT", "MOVE", "NOT",
                                                   "SHL", "SHR", "ROL",   "ROR", "ADD", "SUB", "MUL",  "DIV",  "GT"};
    call_library(scope, random_.once_in(2) ? stdlib::overloads() : stdlib::overloads_named(random_.one_of(kCommon)));
  }
  void call_library(Scope& scope, std::span<const stdlib::Overload> overloads) {
    const stdlib::Overload& overload = overloads[below(overloads.size())];
    std::vector<Word> arguments;
    const std::size_t count = overload.spec->param_count + (overload.spec->extensible ? below(3) : 0);
    for (std::size_t i = 0; i < count; ++i) arguments.push_back(read(scope, overload.param_type(i)));
    if (count == 2 && (overload.spec->name.starts_with("SH") || overload.spec->name.starts_with("RO"))) {
      // By a constant, most of the time.
      const TypeId id = overload.param_type(1);
      const bool integer = core::in_category(id, core::kAnyInt);
      if (integer && !random_.once_in(3)) {
        std::vector<std::byte> places(core::rep_bytes(core::rep_of(id)));
        places[0] = static_cast<std::byte>(below(70));
        arguments[1] = b_.constant_bytes(b_.type(id), std::move(places));
      }
    }
    scope.pou.call_std(stdlib::key_of(overload), write(scope, overload.result_type()), std::move(arguments));
  }

  // Standard blocks and taskblocks: in place, or the element of an array, directly or through a reference.
  void run_block(Scope& scope) {
    if (scope.kind == PouKind::kFunction || blocks_.empty()) return;
    const Block& block = random_.one_of(blocks_);
    if (!random_.once_in(3)) {
      scope.pou.op(Opcode::kRunTb, {block.pou, instance(scope, block.type)});
      return;
    }
    const Word row = instance(scope, block.row);
    const Steps steps = {index_step(scope, block.row)};
    if (random_.once_in(2)) {
      scope.pou.path(Opcode::kRunAt, {block.pou, row, block.row}, steps);
      return;
    }
    const bool element = random_.once_in(2);
    const Word ref = whole(scope, ref_type(element ? block.type : block.row));
    if (!random_.once_in(4)) scope.pou.path(Opcode::kRefAt, {ref, row, block.row}, element ? steps : Steps{});
    scope.pou.path(Opcode::kRunVia, {block.pou, ref, element ? block.type : block.row}, element ? Steps{} : steps);
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
  void move(Scope& scope, TypeId id, Word to, Word from) {
    static constexpr Opcode kMoves[] = {Opcode::kMoveBool, Opcode::kMove8,   Opcode::kMove8,   Opcode::kMove16,
                                        Opcode::kMove16,   Opcode::kMove32,  Opcode::kMove32,  Opcode::kMove64,
                                        Opcode::kMove64,   Opcode::kMoveF32, Opcode::kMoveF64, Opcode::kMoveStr,
                                        Opcode::kMoveWstr, Opcode::kMoveRef};
    scope.pou.op(kMoves[static_cast<std::size_t>(core::rep_of(id))], {to, from});
  }

  PouBuilder::Step index_step(Scope& scope, std::uint32_t array) {
    if (random_.once_in(5)) return {PathStep::kElement, static_cast<Word>(below(type(array).count))};
    static constexpr TypeId kIndices[] = {TypeId::kInt,   TypeId::kInt,   TypeId::kDint,  TypeId::kDint, TypeId::kSint,
                                          TypeId::kUsint, TypeId::kUint,  TypeId::kUdint, TypeId::kLint, TypeId::kUlint,
                                          TypeId::kByte,  TypeId::kDword, TypeId::kLword};
    const TypeId id = random_.one_of(kIndices);
    return {PathStep::kIndex, random_.once_in(2) ? read(scope, id) : inside(scope, id, array)};
  }
  /// A variable that is within the bounds before the instruction, most of the time.
  Word inside(Scope& scope, TypeId id, std::uint32_t array) {
    const std::int64_t wanted = type(array).lower + static_cast<std::int64_t>(below(type(array).count));
    const Word leaf = own(scope, id, 4);
    std::vector<std::byte> bytes(core::rep_bytes(core::rep_of(id)));
    std::memcpy(bytes.data(), &wanted, bytes.size());
    move(scope, id, leaf, b_.constant_bytes(b_.type(id), std::move(bytes)));
    return leaf;
  }
  /// Steps from a value of type `from` to some part of it; `end` is then the type of the part.
  Steps walk(Scope& scope, std::uint32_t from, std::uint32_t& end) {
    Steps steps;
    for (end = from; type(end).kind >= TypeKind::kArray && type(end).kind != TypeKind::kRef && !random_.once_in(8);) {
      if (type(end).kind == TypeKind::kArray) {
        steps.push_back(index_step(scope, end));
        end = type(end).element;
      } else {
        const std::size_t field = below(type(end).fields.size());
        steps.push_back({PathStep::kField, static_cast<Word>(field)});
        end = type(end).fields[field].type;
      }
    }
    return steps;
  }

  void part_of_value(Scope& scope) {
    const std::uint32_t root = random_.one_of(aggregates_);
    const Word base = whole(scope, root);
    std::uint32_t end = 0;
    const Steps steps = walk(scope, root, end);
    if (random_.once_in(2)) {
      scope.pou.path(Opcode::kLoadAt, {value(scope, end, true), base, root}, steps);
    } else {
      scope.pou.path(Opcode::kStoreAt, {base, value(scope, end, false), root}, steps);
    }
  }
  void through_reference(Scope& scope) {
    // To an aggregate or a scalar.
    const bool scalar = random_.once_in(3);
    const TypeId id = any_type();
    const std::uint32_t root = scalar ? type_of(id) : random_.one_of(aggregates_);
    const Word ref = whole(scope, ref_type(root));
    if (!random_.once_in(3)) refer(scope, ref, root);
    std::uint32_t end = root;
    const Steps steps = walk(scope, root, end);
    switch (below(5)) {
      case 0: {
        const Word other = whole(scope, ref_type(end));
        scope.pou.path(Opcode::kRefVia, {other, ref, root}, steps);
        if (type(end).kind > TypeKind::kString) return;
        scope.pou.path(Opcode::kStoreVia, {other, value(scope, end, false), end}, {});
        return;
      }
      case 1:
      case 2:
        scope.pou.path(Opcode::kLoadVia, {value(scope, end, true), ref, root}, steps);
        return;
      default:
        scope.pou.path(Opcode::kStoreVia, {ref, value(scope, end, false), root}, steps);
    }
  }
  /// Lets a reference refer to a variable, or to a part of one.
  void refer(Scope& scope, Word ref, std::uint32_t target) {
    if (type(target).kind >= TypeKind::kArray) {
      scope.pou.path(Opcode::kRefAt, {ref, whole(scope, target), target}, {});
      return;
    }
    // The type must be exactly this one: a variable of its own.
    scope.pou.path(Opcode::kRefAt, {ref, declare(scope, target), target}, {});
  }
  void references(Scope& scope) {
    const std::uint32_t target = random_.one_of(aggregates_);
    const Word a = whole(scope, ref_type(target));
    const Word b = whole(scope, ref_type(target));
    if (random_.once_in(3)) refer(scope, a, target);
    if (random_.once_in(2)) scope.pou.op(Opcode::kMoveRef, {b, a});
    scope.pou.op(Opcode::kSameRef, {write(scope, TypeId::kBool), a, b});
  }

  void bits(Scope& scope) {
    static constexpr TypeId kWords[][2] = {{TypeId::kByte, TypeId::kSint},
                                           {TypeId::kWord, TypeId::kInt},
                                           {TypeId::kDword, TypeId::kUdint},
                                           {TypeId::kLword, TypeId::kLint}};
    static constexpr TypeId kParts[] = {TypeId::kBool, TypeId::kByte, TypeId::kWord, TypeId::kDword};
    const std::size_t width = below(4);
    const TypeId word = kWords[width][below(2)];
    const std::size_t part = below(width + 1);
    const std::size_t part_bits = part == 0 ? 1 : std::size_t{4} << part;
    const auto bit = static_cast<Word>(below((std::size_t{8} << width) / part_bits) * part_bits);
    if (random_.once_in(2)) {
      scope.pou.op(Opcode::kExtract, {write(scope, kParts[part]), read(scope, word), bit});
    } else {
      scope.pou.op(Opcode::kInsert, {write(scope, word), read(scope, word), read(scope, kParts[part]), bit});
    }
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
      // Often of the kind that becomes one instruction with the jump behind it.
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
  struct Local {
    TypeId type;
    Word word;
  };
  /// Compares two numbers, most of the time of the types that have a form of their own before a jump.
  /// `counter`: what one of them is if its type fits.
  void compare(Scope& scope, Word result, const Local* counter = nullptr) {
    struct Comparison {
      Opcode opcode;
      TypeId type;
    };
    static const std::vector<Comparison> kUsual = [] {
      std::vector<Comparison> rows;
#define PLC_FUSED_JUMP(Name, T, expression) rows.push_back({Opcode::k##Name, type_named_in(#Name)});
#include "runtime/fused_jumps.def"
      return rows;
    }();
    if (random_.once_in(4)) {
      static constexpr Comparison kOthers[] = {{Opcode::kLtU16, TypeId::kUint}, {Opcode::kEq64, TypeId::kLint},
                                               {Opcode::kGeI64, TypeId::kLint}, {Opcode::kLtF64, TypeId::kLreal},
                                               {Opcode::kNe8, TypeId::kByte},   {Opcode::kGtU32, TypeId::kUdint}};
      const Comparison& c = random_.one_of(kOthers);
      scope.pou.op(c.opcode, {result, read(scope, c.type), read(scope, c.type)});
      return;
    }
    const Comparison& c = random_.one_of(kUsual);
    const Word a = counter != nullptr && counter->type == c.type ? counter->word : read(scope, c.type);
    scope.pou.op(c.opcode, {result, a, read(scope, c.type)});
  }
  static TypeId type_named_in(std::string_view comparison) {
    if (comparison.ends_with("F32")) return TypeId::kReal;
    return comparison.ends_with("16") ? TypeId::kInt : TypeId::kDint;
  }

  void inside_loop(Scope& scope, int depth) {
    if (random_.once_in(4)) return short_if(scope);
    statement(scope, depth + 1);
  }
  /// What the interpreter has forms of its own for in IFs.
  struct Width {
    TypeId type;
    Opcode ops[6];  ///< ADD, SUB, MUL, AND, OR, XOR
    Opcode equals, differs;
  };
  static const Width& width_of(std::size_t number) {
#define PLC_WIDTH(type, n)                                                                                     \
  {                                                                                                            \
    TypeId::type,                                                                                              \
        {Opcode::kAdd##n, Opcode::kSub##n, Opcode::kMul##n, Opcode::kAnd##n, Opcode::kOr##n, Opcode::kXor##n}, \
        Opcode::kEq##n, Opcode::kNe##n                                                                         \
  }
    static constexpr Width kWidths[] = {PLC_WIDTH(kSint, 8), PLC_WIDTH(kInt, 16), PLC_WIDTH(kDint, 32),
                                        PLC_WIDTH(kLint, 64)};
#undef PLC_WIDTH
    return kWidths[number];
  }
  /// An IF whose branches only compute: what the interpreter computes both ways in loops, and what almost is.
  /// `counter`: of the loop, which it may read.
  void short_if(Scope& scope, const Local* counter = nullptr) {
    PouBuilder& pou = scope.pou;
    const Width& width = width_of(random_.once_in(3) ? below(4) : 2);
    const bool counts = counter != nullptr && counter->type == width.type;
    const auto number = [&] { return counts && random_.once_in(4) ? counter->word : read(scope, width.type); };
    const Word condition = write(scope, TypeId::kBool);
    if (random_.once_in(4)) {
      // A test of bits.
      const Word masked = write(scope, width.type);
      const Word word = number(), mask = read(scope, width.type), expected = read(scope, width.type);
      pou.op(width.ops[3], {masked, word, mask});
      pou.op(random_.once_in(2) ? width.equals : width.differs, {condition, masked, expected});
    } else {
      compare(scope, condition, random_.once_in(2) ? counter : nullptr);
    }
    const Word first = write(scope, width.type), second = write(scope, width.type);
    const auto either = [&] { return random_.once_in(2) ? first : second; };
    const auto in = [&] { return random_.once_in(2) ? either() : number(); };
    const auto compute = [&] {
      if (random_.once_in(16)) return plain(scope);
      if (random_.once_in(8)) {
        const Word out = random_.once_in(3) ? condition : write(scope, TypeId::kBool);
        const Word value = read(scope, TypeId::kBool);
        pou.op(Opcode::kMoveBool, {out, value});
        return;
      }
      const Opcode opcode = random_.one_of(width.ops);
      const Word out = either(), a = in(), b = in();
      pou.op(opcode, {out, a, b});
    };
    const std::uint32_t jump = pou.jump(random_.once_in(3) ? Opcode::kJumpIf : Opcode::kCondJump, {condition});
    for (std::size_t n = 1 + below(2); n > 0; --n) compute();
    if (random_.once_in(2)) return pou.land(jump);
    const std::uint32_t end = pou.jump(Opcode::kJump);
    pou.land(jump);
    for (std::size_t n = below(3); n > 0; --n) compute();
    pou.land(end);
  }

  /// A step of a checksum: a shift register with feedback, and what almost is.
  void feedback(Scope& scope) {
    PouBuilder& pou = scope.pou;
    struct Register {
      TypeId type;
      std::string_view name;
      Opcode masks, mixes, differs, equals;
    };
    static constexpr Register kRegisters[] = {
        {TypeId::kByte, "BYTE", Opcode::kAnd8, Opcode::kXor8, Opcode::kNe8, Opcode::kEq8},
        {TypeId::kWord, "WORD", Opcode::kAnd16, Opcode::kXor16, Opcode::kNe16, Opcode::kEq16},
        {TypeId::kDword, "DWORD", Opcode::kAnd32, Opcode::kXor32, Opcode::kNe32, Opcode::kEq32},
        {TypeId::kLword, "LWORD", Opcode::kAnd64, Opcode::kXor64, Opcode::kNe64, Opcode::kEq64}};
    const Register& kind = kRegisters[below(4)];
    const auto two = [&](Opcode opcode, Word out, Word a, Word b) {
      const bool turned = random_.once_in(2);
      pou.op(opcode, {out, turned ? b : a, turned ? a : b});
    };
    const auto word = write(scope, kind.type);
    const auto fresh = [&](TypeId id) {
      if (random_.once_in(8)) return write(scope, id);
      return pou.frame(scope.name(), type_of(id), FieldRole::kTemp);
    };
    const auto masked = random_.once_in(8) ? word : fresh(kind.type);
    const auto condition = fresh(TypeId::kBool);
    const auto mask = read(scope, kind.type), expected = read(scope, kind.type), taps = read(scope, kind.type);
    two(kind.masks, masked, word, mask);
    pou.op(random_.once_in(2) ? kind.equals : kind.differs, {condition, masked, expected});
    const auto places = b_.constant_bytes(b_.type(TypeId::kInt), {static_cast<std::byte>(below(70)), std::byte{}});
    const std::string shift = (random_.once_in(2) ? "SHL:" : "SHR:") + std::string(kind.name) + ",INT";
    const bool when = random_.once_in(2);
    const auto mixes = [&] {
      const auto shifted = random_.once_in(8) ? write(scope, kind.type) : masked;
      pou.call_std(shift, shifted, {word, places});
      two(kind.mixes, word, shifted, random_.once_in(8) ? shifted : taps);
    };
    const auto shifts = [&] { pou.call_std(shift, word, {random_.once_in(8) ? masked : word, places}); };
    const std::uint32_t other = pou.jump(when ? Opcode::kJumpIf : Opcode::kCondJump, {condition});
    when ? shifts() : mixes();
    const std::uint32_t end = pou.jump(Opcode::kJump);
    pou.land(other);
    when ? mixes() : shifts();
    pou.land(end);
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

  /// A loop as FOR makes it, over arrays: what the interpreter runs instruction by instruction, and what almost is.
  void counted(Scope& scope) {
    PouBuilder& pou = scope.pou;
    const bool wide = random_.once_in(2), down = random_.once_in(4);
    const TypeId id = wide ? TypeId::kDint : TypeId::kInt;
    const auto number_of = [&](int n) {
      return wide ? b_.constant<std::int32_t>(id, n) : b_.constant<std::int16_t>(id, static_cast<std::int16_t>(n));
    };
    const auto temporary = [&](std::uint32_t index) { return pou.frame(scope.name(), index, FieldRole::kTemp); };
    const Word counter = temporary(b_.type(id));
    const Word more = temporary(b_.boolean());
    const int step = random_.once_in(3) ? 1 + static_cast<int>(below(4)) : 1;
    const int rounds = static_cast<int>(below(random_.once_in(4) ? 200 : 24));
    const int first = static_cast<int>(below(8)) - 3 + (down ? rounds * step : 0);
    const Word limit =
        random_.once_in(8) ? read(scope, id) : number_of(down ? first - rounds * step : first + rounds * step);

    std::vector<std::pair<TypeId, Word>> locals = {{id, counter}};
    const auto some_local = [&](TypeId type) -> std::optional<Word> {
      std::vector<Word> found;
      for (const auto& [local, word] : locals) {
        if (local == type) found.push_back(word);
      }
      return found.empty() ? std::nullopt : std::optional(random_.one_of(found));
    };
    const auto in = [&](TypeId type) {
      const auto local = some_local(type);
      return local && !random_.once_in(3) ? *local : read(scope, type);
    };
    const auto out = [&](TypeId type) {
      if (random_.once_in(10)) return write(scope, type);
      if (const auto local = some_local(type); local && *local != counter && random_.once_in(4)) return *local;
      locals.emplace_back(type, temporary(type_of(type)));
      return locals.back().second;
    };
    const auto index = [&] {
      if (!random_.once_in(3)) return counter;
      static constexpr Opcode kOps[][2] = {
          {Opcode::kAdd16, Opcode::kAdd32}, {Opcode::kSub16, Opcode::kSub32}, {Opcode::kMul16, Opcode::kMul32}};
      const Word other = random_.once_in(4) ? read(scope, id) : number_of(static_cast<int>(below(5)) - 1);
      const Word sum = temporary(b_.type(id));
      const bool turned = random_.once_in(3);
      pou.op(random_.one_of(kOps)[wide ? 1 : 0], {sum, turned ? other : counter, turned ? counter : other});
      locals.emplace_back(id, sum);
      return sum;
    };
    // Few arrays, so that accesses meet.
    static constexpr TypeId kElements[] = {TypeId::kReal, TypeId::kReal,  TypeId::kDint, TypeId::kInt,
                                           TypeId::kByte, TypeId::kLreal, TypeId::kBool};
    struct Array {
      TypeId element;
      std::uint32_t type;
      Word word;
      bool rows;
    };
    std::vector<Array> arrays;
    for (std::size_t n = 1 + below(2); n > 0; --n) {
      const TypeId element = random_.one_of(kElements);
      const bool rows = random_.once_in(4);
      const std::uint32_t row = b_.array(b_.type(element), static_cast<std::uint32_t>(20 + below(200)), -4);
      const std::uint32_t type = rows ? b_.array(row, 4, 0) : row;
      arrays.push_back({element, type, declare(scope, type), rows});
    }
    const auto steps = [&](const Array& array) {
      const PouBuilder::Step column{PathStep::kIndex, index()};
      if (!array.rows) return Steps{column};
      return Steps{{PathStep::kIndex, inside_row(scope)}, column};
    };

    move(scope, id, counter, number_of(first));
    const std::uint32_t top = pou.here();
    // Some loops have nothing but IFs in them.
    const bool only_choices = random_.once_in(4);
    const Local local{id, counter};
    for (std::size_t n = only_choices ? 1 + below(2) : 0; n > 0; --n) {
      if (random_.once_in(2)) {
        feedback(scope);
      } else {
        short_if(scope, &local);
      }
    }
    for (std::size_t n = only_choices ? 0 : 1 + below(6); n > 0; --n) {
      const Array& array = random_.one_of(arrays);
      switch (below(random_.once_in(6) ? 7 : 6)) {
        case 0:
        case 1: {
          const Steps path = steps(array);
          pou.path(Opcode::kLoadAt, {out(array.element), array.word, array.type}, path);
          break;
        }
        case 2: {
          const Steps path = steps(array);
          pou.path(Opcode::kStoreAt, {array.word, in(array.element), array.type}, path);
          break;
        }
        case 3: {
          // A sum, or what looks like one.
          const Word sum = random_.once_in(3) ? out(TypeId::kReal) : write(scope, TypeId::kReal);
          // Arguments of one call are drawn in any order.
          const Opcode opcode = random_.once_in(2) ? Opcode::kAddF32 : Opcode::kMulF32;
          pou.op(opcode, {sum, sum, in(TypeId::kReal)});
          break;
        }
        case 6:
          call_library(scope);
          break;
        default:
          plain(scope, in, out);
      }
    }
    pou.op(wide ? (down ? Opcode::kGtI32 : Opcode::kLtI32) : (down ? Opcode::kGtI16 : Opcode::kLtI16),
           {more, counter, limit});
    const std::uint32_t end = pou.jump(Opcode::kCondJump, {more});
    pou.op(wide ? (down ? Opcode::kSub32 : Opcode::kAdd32) : (down ? Opcode::kSub16 : Opcode::kAdd16),
           {counter, counter, number_of(step)});
    pou.op(Opcode::kLoopJump, {top});
    pou.land(end);
  }
  /// An index of four rows, within them most of the time, which nobody else writes.
  Word inside_row(Scope& scope) {
    return random_.once_in(20) ? read(scope, TypeId::kInt)
                               : b_.constant<std::int16_t>(TypeId::kInt, static_cast<std::int16_t>(below(4)));
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

  void copy(Scope& scope) {
    const std::uint32_t index = random_.one_of(aggregates_);
    scope.pou.op(Opcode::kCopy, {whole(scope, index), whole(scope, index), index});
  }

  /// An instruction all of whose operands are leaves.
  void plain(Scope& scope) {
    plain(
        scope, [&](TypeId id) { return read(scope, id); }, [&](TypeId id) { return write(scope, id); });
  }
  template <class In, class Out>
  void plain(Scope& scope, In in, Out out) {
    struct Plain {
      Opcode opcode;
      std::vector<std::vector<TypeId>> types;  ///< of each operand
      std::vector<bool> out;
    };
    static const std::vector<Plain> kPlain = [] {
      std::vector<Plain> found;
      for (std::size_t i = 0; i < bytecode::opcodes().size(); ++i) {
        const bytecode::Operands& operands = bytecode::opcodes()[i].operands;
        Plain plain{static_cast<Opcode>(i), {}, {}};
        bool leaves = operands.count >= 2;
        for (std::uint8_t n = 0; n < operands.count; ++n) {
          const auto& spec = operands.specs[n];
          const bool leaf = spec.kind == bytecode::OperandKind::kIn || spec.kind == bytecode::OperandKind::kOut;
          leaves = leaves && leaf && (spec.reps & bytecode::kMRef) == 0;
          plain.out.push_back(spec.kind == bytecode::OperandKind::kOut);
          plain.types.emplace_back();
          for (std::size_t t = 0; t < core::kTypeCount; ++t) {
            const auto id = static_cast<TypeId>(t);
            if ((spec.reps & bytecode::mask_of(core::rep_of(id))) != 0) plain.types.back().push_back(id);
          }
        }
        if (leaves) found.push_back(std::move(plain));
      }
      return found;
    }();
    const Plain& plain = random_.one_of(kPlain);
    std::vector<Word> words;
    for (std::size_t n = 0; n < plain.types.size(); ++n) {
      const TypeId id = random_.one_of(plain.types[n]);
      words.push_back(plain.out[n] ? out(id) : in(id));
    }
    scope.pou.list(plain.opcode, 0, std::move(words));
  }

  std::vector<Function> functions_;
  std::vector<Block> pous_;
  std::vector<std::vector<std::uint32_t>> users_;  ///< by program: the task of each instance
  std::vector<std::uint32_t> programs_;
  std::vector<Queue> queues_;
};

}  // namespace plc::test
