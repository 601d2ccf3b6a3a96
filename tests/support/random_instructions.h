// RandomInstructions: single instructions of a random image (random_image.h), and straight code of them.
//
// In: the body they go to. Out: instructions on variables of any type, with values and indices at their ends. Does not
// belong here: jumps (random_loops.h) and calls of what is in the image.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/support/random_variables.h"

namespace plc::test {

class RandomInstructions : protected RandomVariables {
 protected:
  using RandomVariables::RandomVariables;
  using Steps = std::vector<PouBuilder::Step>;

  /// What the interpreter arranges.
  void straight(Scope& scope) {
    static constexpr std::string_view kChoices[] = {"SEL", "LIMIT", "MIN", "MAX", "SHL", "SHR", "ROL", "ROR"};
    if (random_.once_in(4)) return ladder(scope);
    if (random_.once_in(3)) return chain(scope);
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

  /// Values of one type that go from instruction to instruction through a few variables, which are written again and
  /// again: what drawn arithmetic is made of.
  void chain(Scope& scope) {
    static constexpr std::string_view kFunctions[] = {"SEL", "LIMIT", "MIN", "MAX", "ABS", "NOT"};
    static constexpr TypeId kTypes[] = {TypeId::kBool,  TypeId::kSint, TypeId::kUsint, TypeId::kInt,   TypeId::kWord,
                                        TypeId::kDint,  TypeId::kDint, TypeId::kUdint, TypeId::kDword, TypeId::kLint,
                                        TypeId::kUlint, TypeId::kReal, TypeId::kReal,  TypeId::kLreal};
    const TypeId id = random_.one_of(kTypes);
    std::vector<Word> variables;
    for (std::size_t n = 1 + below(3); n > 0; --n) variables.push_back(declare(scope, type_of(id)));
    Word last = read(scope, id);
    const auto in = [&](TypeId wanted) {
      if (wanted != id || random_.once_in(3)) return read(scope, wanted);
      return random_.once_in(8) ? random_.one_of(variables) : last;
    };
    const auto out = [&](TypeId wanted) {
      if (wanted != id) return write(scope, wanted);
      return last = random_.once_in(6) ? write(scope, id) : random_.one_of(variables);
    };
    for (std::size_t n = 3 + below(30); n > 0; --n) {
      const auto overloads = stdlib::overloads_named(random_.one_of(kFunctions));
      const auto overload = std::find_if(overloads.begin(), overloads.end(),
                                         [&](const stdlib::Overload& o) { return o.result_type() == id; });
      if (random_.once_in(3) && overload != overloads.end()) {
        std::vector<Word> arguments;
        for (std::size_t i = 0; i < overload->spec->param_count; ++i) arguments.push_back(in(overload->param_type(i)));
        scope.pou.call_std(stdlib::key_of(*overload), out(id), std::move(arguments));
      } else {
        plain(scope, in, out, id);
      }
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
  /// Pointers of places, moved by a few bytes or from anywhere, and what is done through them.
  void through_pointer(Scope& scope) {
    const bool scalar = random_.once_in(2);
    const std::uint32_t root = scalar ? type_of(any_type()) : random_.one_of(aggregates_);
    const Word pointer = random_.once_in(8) ? read(scope, TypeId::kPointer) : point(scope);
    std::uint32_t end = root;
    const Steps steps = walk(scope, root, end);
    switch (below(8)) {
      case 0:
        scope.pou.path(Opcode::kAdrPtr, {write(scope, TypeId::kPointer), pointer, root}, steps);
        return;
      case 1: {
        const Word ref = whole(scope, ref_type(end));
        scope.pou.path(Opcode::kRefPtr, {ref, pointer, root}, steps);
        if (type(end).kind > TypeKind::kString) return;
        scope.pou.path(Opcode::kStoreVia, {ref, value(scope, end, false), end}, {});
        return;
      }
      case 2: {
        const Word address = write(scope, TypeId::kDword);
        scope.pou.op(Opcode::kPtrTo32, {address, pointer});
        scope.pou.op(Opcode::kPtrFrom32, {write(scope, TypeId::kPointer), address});
        return;
      }
      case 3:
      case 4:
        scope.pou.path(Opcode::kLoadPtr, {value(scope, end, true), pointer, root}, steps);
        return;
      default:
        scope.pou.path(Opcode::kStorePtr, {pointer, value(scope, end, false), root}, steps);
    }
  }
  /// A pointer to some part of a variable, close to it at least.
  Word point(Scope& scope) {
    const Word pointer = write(scope, TypeId::kPointer);
    const std::uint32_t target = random_.once_in(2) ? type_of(any_type()) : random_.one_of(aggregates_);
    std::uint32_t end = target;
    if (random_.once_in(5)) {
      const Word ref = whole(scope, ref_type(target));
      if (!random_.once_in(3)) refer(scope, ref, target);
      scope.pou.path(Opcode::kAdrVia, {pointer, ref, target}, walk(scope, target, end));
    } else {
      const Word base = type(target).kind >= TypeKind::kArray ? whole(scope, target) : declare(scope, target);
      scope.pou.path(Opcode::kAdrAt, {pointer, base, target}, walk(scope, target, end));
    }
    if (random_.once_in(2)) return pointer;
    const auto bytes = static_cast<std::int64_t>(below(24)) - 4;
    std::vector<std::byte> distance(sizeof bytes);
    std::memcpy(distance.data(), &bytes, sizeof bytes);
    const Word by = b_.constant_bytes(b_.type(TypeId::kLint), std::move(distance));
    scope.pou.op(Opcode::kAdd64, {pointer, pointer, by});
    return pointer;
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

  void copy(Scope& scope) {
    const std::uint32_t index = random_.one_of(aggregates_);
    scope.pou.op(Opcode::kCopy, {whole(scope, index), whole(scope, index), index});
  }

  /// An instruction all of whose operands are leaves.
  void plain(Scope& scope) {
    plain(
        scope, [&](TypeId id) { return read(scope, id); }, [&](TypeId id) { return write(scope, id); });
  }
  /// `id`: what it writes, and reads where it may.
  template <class In, class Out>
  void plain(Scope& scope, In in, Out out, std::optional<TypeId> id = std::nullopt) {
    const Plain* plain = nullptr;
    do {
      plain = &random_.one_of(plains());
    } while (id && !plain->writes(*id));
    std::vector<Word> words(plain->types.size());
    // What is written may be what is read next: operands that are read come first.
    for (const bool written : {false, true}) {
      for (std::size_t n = 0; n < words.size(); ++n) {
        if (plain->out[n] != written) continue;
        const TypeId type = id && plain->takes(n, *id) ? *id : random_.one_of(plain->types[n]);
        words[n] = written ? out(type) : in(type);
      }
    }
    scope.pou.list(plain->opcode, 0, std::move(words));
  }

 private:
  /// An opcode all of whose operands are leaves.
  struct Plain {
    Opcode opcode;
    std::vector<std::vector<TypeId>> types;  ///< of each operand
    std::vector<bool> out;

    [[nodiscard]] bool takes(std::size_t operand, TypeId id) const {
      return std::find(types[operand].begin(), types[operand].end(), id) != types[operand].end();
    }
    [[nodiscard]] bool writes(TypeId id) const { return out[0] && takes(0, id); }
  };
  static const std::vector<Plain>& plains() {
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
    return kPlain;
  }
};

}  // namespace plc::test
