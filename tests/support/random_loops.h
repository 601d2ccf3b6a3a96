// RandomLoops: IFs and loops of a random image (random_image.h) as the interpreter and native code have forms of their
// own for, and what almost is one.
//
// In: the body they go to. Out: comparisons, short IFs, steps of a checksum, counted loops over arrays. Does not belong
// here: branches and loops around any statements (random_image.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/support/random_instructions.h"

namespace plc::test {

class RandomLoops : protected RandomInstructions {
 protected:
  using RandomInstructions::RandomInstructions;

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
#include "runtime/interpreter/fused_jumps.def"
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
};

}  // namespace plc::test
