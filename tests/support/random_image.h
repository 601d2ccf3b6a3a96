// RandomImage: valid images made from a seed, that use every instruction on values of every type.
//
// Out: an image of one task whose program calls a function, a function block with one instance and one with several;
// all bodies are random instructions on random variables, so that results mean nothing and cover much. Does not belong
// here: what they compute.
#pragma once

#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "tests/support/image_builder.h"

namespace plc::test {

class RandomImage {
 public:
  explicit RandomImage(std::uint32_t seed) : random_(seed) {}

  Image make(std::size_t statements) {
    declare_globals();
    const std::uint32_t function = make_function(statements / 4 + 1);
    const std::uint32_t shared = make_block("Shared", statements / 4 + 1);
    const std::uint32_t single = make_block("Single", statements / 4 + 1);
    PouBuilder main = b_.pou("Main", PouKind::kProgram);
    Scope scope = variables(main, false);
    const Word first = main.instance_of("first", shared);
    const Word second = main.instance_of("second", shared);
    const Word only = main.instance_of("only", single);
    const std::uint32_t row_type = b_.array(b_.image.pous[shared].instance_type, 3, -1);
    const Word row = main.variable("row", row_type);
    const std::uint32_t ref_type = b_.ref(b_.image.pous[shared].instance_type);
    const Word ref = main.variable("ref", ref_type);
    for (std::size_t i = 0; i < statements; ++i) {
      switch (below(12)) {
        case 0:
          main.op(Opcode::kCallPou, {shared, below(2) == 0 ? first : second});
          break;
        case 1:
          main.op(Opcode::kCallPou, {single, only});
          break;
        case 2:
          main.path(Opcode::kCallAt, {shared, row, row_type}, {{PathStep::kIndex, any(scope, TypeId::kInt)}});
          break;
        case 3:
          main.path(Opcode::kRefAt, {ref, row, row_type}, {{PathStep::kIndex, any(scope, TypeId::kSint)}});
          main.path(Opcode::kCallVia, {shared, ref, b_.image.pous[shared].instance_type}, {});
          break;
        case 4:
          main.list(Opcode::kCallFn, 5,
                    {function, 0, any(scope, TypeId::kDint), 1, any(scope, TypeId::kLreal), 2,
                     any(scope, TypeId::kString), 3, scope.array, 4, written(scope, TypeId::kDint)});
          break;
        default:
          statement(main, scope, 0);
      }
    }
    b_.task("Cyclic", 10'000'000, {main.finish()});
    return b_.build();
  }

 private:
  /// Variables that instructions of a body may name.
  struct Scope {
    std::vector<Word> all[core::kTypeCount];      ///< read; by type
    std::vector<Word> changed[core::kTypeCount];  ///< written
    Word array = 0;                               ///< of array_
    std::vector<std::pair<std::uint32_t, Word>> blocks;
    Word ref = 0;
  };

  std::size_t below(std::size_t n) { return random_() % n; }
  template <class T>
  T one_of(const std::vector<T>& items) {
    return items[below(items.size())];
  }
  Word any(const Scope& scope, TypeId id) { return one_of(scope.all[static_cast<std::size_t>(id)]); }
  Word written(const Scope& scope, TypeId id) { return one_of(scope.changed[static_cast<std::size_t>(id)]); }

  std::uint32_t type_of(TypeId id) {
    if (core::rep_of(id) == core::Rep::kStr || core::rep_of(id) == core::Rep::kWstr) {
      return b_.string(static_cast<std::uint16_t>(3 + below(6)), id);
    }
    return b_.type(id);
  }
  /// Values that matter: ends of ranges, small numbers, numbers that are no numbers.
  std::vector<std::byte> value(TypeId id) {
    const auto integer = [&](auto zero) {
      using T = decltype(zero);
      const T edges[] = {0, 1, static_cast<T>(-1), 2, 7, std::numeric_limits<T>::min(), std::numeric_limits<T>::max()};
      return bytes_of(below(3) == 0 ? static_cast<T>(random_() * 0x9e3779b97f4a7c15ull)
                                    : edges[below(std::size(edges))]);
    };
    const auto real = [&](auto zero) {
      using T = decltype(zero);
      const T edges[] = {0,
                         static_cast<T>(-0.0),
                         1,
                         static_cast<T>(-2.5),
                         std::numeric_limits<T>::infinity(),
                         std::numeric_limits<T>::quiet_NaN(),
                         std::numeric_limits<T>::max(),
                         std::numeric_limits<T>::denorm_min()};
      return bytes_of(below(3) == 0 ? static_cast<T>(random_()) / 1000 : edges[below(std::size(edges))]);
    };
    switch (core::rep_of(id)) {
      case core::Rep::kBool:
        return bytes_of(static_cast<std::uint8_t>(below(2)));
      case core::Rep::kI8:
        return integer(std::int8_t{});
      case core::Rep::kU8:
        return integer(std::uint8_t{});
      case core::Rep::kI16:
        return integer(std::int16_t{});
      case core::Rep::kU16:
        return integer(std::uint16_t{});
      case core::Rep::kI32:
        return integer(std::int32_t{});
      case core::Rep::kU32:
        return integer(std::uint32_t{});
      case core::Rep::kI64:
        return integer(std::int64_t{});
      case core::Rep::kU64:
        return integer(std::uint64_t{});
      case core::Rep::kF32:
        return real(float{});
      case core::Rep::kF64:
        return real(double{});
      default:
        return {};
    }
  }
  static std::string name(const char* prefix, std::size_t type, std::size_t n) {
    return prefix + std::to_string(type) + "_" + std::to_string(n);
  }

  void declare_globals() {
    array_ = b_.array(b_.type(TypeId::kDint), 6, -2);
    for (std::size_t t = 0; t < core::kTypeCount; ++t) {
      const auto id = static_cast<TypeId>(t);
      globals_.all[t].push_back(b_.global(name("g", t, 0), type_of(id), value(id)));
      globals_.changed[t].push_back(globals_.all[t].back());
      const bool text = core::rep_of(id) == core::Rep::kStr || core::rep_of(id) == core::Rep::kWstr;
      for (int n = 0; n < 2 && !text; ++n) globals_.all[t].push_back(b_.constant_bytes(b_.type(id), value(id)));
    }
  }
  /// Variables of a body and all globals. A function has a frame alone, and no globals.
  Scope variables(PouBuilder& pou, bool function) {
    Scope scope = globals_;
    for (std::size_t t = 0; t < core::kTypeCount; ++t) {
      const auto id = static_cast<TypeId>(t);
      if (function) std::erase_if(scope.changed[t], [](Word w) { return bytecode::space_of(w) == Space::kGlobal; });
      const auto add = [&](Word word) {
        scope.all[t].push_back(word);
        scope.changed[t].push_back(word);
      };
      for (std::size_t n = 0; n < 2 && !function; ++n)
        add(pou.variable(name("v", t, n), type_of(id), FieldRole::kLocal, value(id)));
      add(pou.frame(name("f", t, 0), type_of(id), FieldRole::kTemp, value(id)));
    }
    scope.array = function ? pou.frame("array", array_) : pou.variable("array", array_);
    if (!function) {
      scope.ref = pou.variable("array_ref", b_.ref(array_));
      for (const char* block : {"TON", "TOF", "TP", "CTU", "CTD_DINT", "CTUD", "SR", "RS", "R_TRIG", "F_TRIG"}) {
        const Word ports = pou.variable(std::string("b_") + block, b_.block_type(block));
        scope.blocks.emplace_back(b_.block(block), ports);
        for (const stdlib::Field& field : stdlib::block_named(block)->fields) {
          const auto type = static_cast<std::size_t>(field.type);
          scope.all[type].push_back(ports + field.offset);
          scope.changed[type].push_back(ports + field.offset);
        }
      }
    }
    return scope;
  }

  std::uint32_t make_function(std::size_t statements) {
    PouBuilder f = b_.pou("Function", PouKind::kFunction);
    const Word a = f.frame("a", b_.type(TypeId::kDint), FieldRole::kInput);
    const Word c = f.frame("c", b_.type(TypeId::kLreal), FieldRole::kInput);
    f.frame("text", b_.string(2), FieldRole::kInput);
    f.frame("row", array_, FieldRole::kInput);
    const Word result = f.frame("Function", b_.type(TypeId::kDint), FieldRole::kReturnValue);
    Scope scope = variables(f, true);
    scope.all[static_cast<std::size_t>(TypeId::kDint)].push_back(a);
    scope.all[static_cast<std::size_t>(TypeId::kLreal)].push_back(c);
    scope.changed[static_cast<std::size_t>(TypeId::kDint)].push_back(result);
    for (std::size_t i = 0; i < statements; ++i) statement(f, scope, 0);
    return f.finish();
  }
  std::uint32_t make_block(const char* pou_name, std::size_t statements) {
    PouBuilder fb = b_.pou(pou_name, PouKind::kFunctionBlock);
    const Scope scope = variables(fb, false);
    for (std::size_t i = 0; i < statements; ++i) statement(fb, scope, 0);
    return fb.finish();
  }

  void statement(PouBuilder& pou, const Scope& scope, int depth) {
    switch (below(14)) {
      case 0:
        return records(pou, scope);
      case 1:
        return call_library(pou, scope);
      case 2:
        if (!scope.blocks.empty()) {
          const auto [block, ports] = one_of(scope.blocks);
          pou.op(Opcode::kRunTb, {block, ports});
        }
        return;
      case 3:
        return element(pou, scope);
      case 4:
        return part(pou, scope);
      case 5:
        pou.op(Opcode::kClearEvent);
        plain(pou, scope);
        pou.op(Opcode::kEno, {written(scope, TypeId::kBool)});
        return;
      case 6:
        if (depth < 3) return branch(pou, scope, depth);
        return;
      case 7:
        if (depth < 2) return loop(pou, scope, depth);
        return;
      default:
        return plain(pou, scope);
    }
  }

  void records(PouBuilder& pou, const Scope& scope) {
    std::vector<Word> words;
    const std::size_t count = 1 + below(40);
    Word last = any(scope, TypeId::kBool);
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t truth = static_cast<std::uint32_t>(random_());
      // Mostly of four inputs and often what rungs are made of, else any function.
      static constexpr std::uint32_t kUsual[] = {0x80008000u, 0xfffefffeu, 0xf888f888u, 0xa8a8a8a8u,
                                                 0x96969696u, 0xcacacacau, 0x88888888u};
      words.push_back(below(2) == 0   ? kUsual[below(std::size(kUsual))]
                      : below(2) == 0 ? truth
                                      : (truth & 0xffffu) * 0x10001u);
      const Word out = written(scope, TypeId::kBool);
      words.push_back(out);
      for (int k = 0; k < 5; ++k) words.push_back(below(3) == 0 ? last : any(scope, TypeId::kBool));
      last = out;
    }
    pou.list(Opcode::kBoolRun, static_cast<std::uint32_t>(count), std::move(words));
  }

  void call_library(PouBuilder& pou, const Scope& scope) {
    const auto overloads = stdlib::overloads();
    const stdlib::Overload& overload = overloads[below(overloads.size())];
    std::vector<Word> arguments;
    const std::size_t count = overload.spec->param_count + (overload.spec->extensible ? below(3) : 0);
    for (std::size_t i = 0; i < count; ++i) arguments.push_back(any(scope, overload.param_type(i)));
    pou.call_std(stdlib::key_of(overload), written(scope, overload.result_type()), std::move(arguments));
  }

  void element(PouBuilder& pou, const Scope& scope) {
    static constexpr TypeId kIndices[] = {TypeId::kSint,  TypeId::kUsint, TypeId::kInt,   TypeId::kUint, TypeId::kDint,
                                          TypeId::kUdint, TypeId::kLint,  TypeId::kUlint, TypeId::kInt,  TypeId::kDint};
    const Word index = any(scope, kIndices[below(std::size(kIndices))]);
    const std::vector<PouBuilder::Step> path = {{PathStep::kIndex, index}};
    switch (below(scope.ref == 0 ? 2 : 5)) {
      case 0:
        pou.path(Opcode::kLoadAt, {written(scope, TypeId::kDint), scope.array, array_}, path);
        return;
      case 1:
        pou.path(Opcode::kStoreAt, {scope.array, any(scope, TypeId::kDint), array_}, path);
        return;
      case 2:
        pou.path(Opcode::kRefAt, {scope.ref, scope.array, array_}, {});
        return;
      case 3:
        pou.path(Opcode::kLoadVia, {written(scope, TypeId::kDint), scope.ref, array_}, path);
        return;
      default:
        pou.path(Opcode::kStoreVia, {scope.ref, any(scope, TypeId::kDint), array_}, path);
    }
  }

  void part(PouBuilder& pou, const Scope& scope) {
    const auto bit = static_cast<Word>(below(16));
    if (below(2) == 0) {
      pou.op(Opcode::kExtract, {written(scope, TypeId::kBool), any(scope, TypeId::kWord), bit});
    } else {
      pou.op(Opcode::kInsert,
             {written(scope, TypeId::kWord), any(scope, TypeId::kWord), any(scope, TypeId::kBool), bit});
    }
  }

  void branch(PouBuilder& pou, const Scope& scope, int depth) {
    std::uint32_t jump = 0;
    if (below(2) == 0) {
      // Of the kind that becomes one instruction.
      const Word result = written(scope, TypeId::kBool);
      static constexpr Opcode kReals[] = {Opcode::kEqF32, Opcode::kNeF32, Opcode::kLtF32,
                                          Opcode::kLeF32, Opcode::kGtF32, Opcode::kGeF32};
      static constexpr Opcode kIntegers[] = {Opcode::kEq16,  Opcode::kNe16,  Opcode::kLtI16,
                                             Opcode::kLeI16, Opcode::kGtI16, Opcode::kGeI16};
      // One random number after the other: arguments of a call have no order of their own.
      const bool real = below(2) == 0;
      const TypeId type = real ? TypeId::kReal : TypeId::kInt;
      const Opcode comparison = real ? kReals[below(6)] : kIntegers[below(6)];
      pou.op(comparison, {result, any(scope, type), any(scope, type)});
      jump = pou.jump(below(2) == 0 ? Opcode::kCondJump : Opcode::kJumpIf, {result});
    } else {
      const Opcode opcode = below(2) == 0 ? Opcode::kCondJump : Opcode::kJumpIf;
      jump = pou.jump(opcode, {any(scope, TypeId::kBool)});
    }
    for (std::size_t n = below(4); n > 0; --n) statement(pou, scope, depth + 1);
    pou.land(jump);
  }

  void loop(PouBuilder& pou, const Scope& scope, int depth) {
    const std::uint32_t top = pou.here();
    for (std::size_t n = 1 + below(3); n > 0; --n) statement(pou, scope, depth + 1);
    const std::uint32_t out = pou.jump(Opcode::kCondJump, {any(scope, TypeId::kBool)});
    pou.op(Opcode::kLoopJump, {top});
    pou.land(out);
  }

  /// An instruction all of whose operands are leaves.
  void plain(PouBuilder& pou, const Scope& scope) {
    static const std::vector<Opcode> kPlain = [] {
      std::vector<Opcode> found;
      for (std::size_t i = 0; i < bytecode::opcodes().size(); ++i) {
        const bytecode::Operands& operands = bytecode::opcodes()[i].operands;
        bool leaves = operands.count >= 2;
        for (std::uint8_t n = 0; n < operands.count; ++n) {
          const auto& spec = operands.specs[n];
          const bool leaf = spec.kind == bytecode::OperandKind::kIn || spec.kind == bytecode::OperandKind::kOut;
          leaves = leaves && leaf && (spec.reps & bytecode::kMRef) == 0;
        }
        if (leaves) found.push_back(static_cast<Opcode>(i));
      }
      return found;
    }();
    const Opcode opcode = one_of(kPlain);
    const bytecode::Operands& operands = bytecode::info(opcode).operands;
    std::vector<Word> words;
    for (std::uint8_t n = 0; n < operands.count; ++n) {
      std::vector<TypeId> types;
      for (std::size_t t = 0; t < core::kTypeCount; ++t) {
        const auto id = static_cast<TypeId>(t);
        if ((operands.specs[n].reps & bytecode::mask_of(core::rep_of(id))) != 0) types.push_back(id);
      }
      const TypeId type = one_of(types);
      words.push_back(operands.specs[n].kind == bytecode::OperandKind::kOut ? written(scope, type) : any(scope, type));
    }
    pou.list(opcode, 0, std::move(words));
  }

  std::mt19937 random_;
  ImageBuilder b_;
  Scope globals_;
  std::uint32_t array_ = 0;
};

}  // namespace plc::test
