// RandomVariables: types and variables of a random image (random_image.h), declared when an instruction first wants
// one.
//
// In: a seed. Out: words of variables to read and to write, of any type. Does not belong here: instructions.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "taskblocks/registry.h"
#include "tests/support/failing_taskblock.h"
#include "tests/support/image_builder.h"
#include "tests/support/random_values.h"

namespace plc::test {

class RandomVariables {
 protected:
  RandomVariables(std::uint64_t seed, const taskblocks::Registry* registry)
      : random_(seed), registry_(registry != nullptr ? *registry : taskblocks::Registry::built_in()) {}

  /// Words of variables, by elementary type.
  using Leaves = std::array<std::vector<Word>, core::kTypeCount>;
  /// A variable of a type that instructions name as a whole.
  struct Whole {
    std::uint32_t type;
    Word word;
  };
  /// A body under construction, and the variables that it has so far.
  struct Scope {
    PouBuilder& pou;
    PouKind kind;
    std::vector<std::uint32_t> tasks{};  ///< programs: those that run it
    Leaves leaves{};
    std::array<std::optional<Word>, core::kTypeCount> last{};  ///< written by the body
    std::vector<Whole> wholes{};
    int names = 0;
    std::string name() { return "v" + std::to_string(names++); }
  };
  struct Block {
    std::uint32_t pou;
    std::uint32_t type;
    std::uint32_t row;                                     ///< array of its instances
    std::vector<std::pair<TypeId, std::uint32_t>> leaves;  ///< some of its variables: offsets in the instance
  };
  std::size_t below(std::size_t n) { return random_.below(n); }
  static std::size_t number(TypeId id) { return static_cast<std::size_t>(id); }

  // ---- types

  std::uint32_t type_of(TypeId id) {
    std::vector<std::uint32_t>& known = types_[number(id)];
    const bool text = core::rep_of(id) == core::Rep::kStr || core::rep_of(id) == core::Rep::kWstr;
    if (known.empty()) {
      if (!text) known.push_back(b_.type(id));
      for (std::uint16_t capacity = 1; text && capacity < 20; capacity = static_cast<std::uint16_t>(capacity * 4))
        known.push_back(b_.string(capacity, id));
    }
    return random_.one_of(known);
  }
  TypeId any_type() { return static_cast<TypeId>(below(core::kTypeCount)); }
  std::uint32_t ref_type(std::uint32_t target) {
    const auto [at, fresh] = refs_.emplace(target, 0);
    if (fresh) at->second = b_.ref(target);
    return at->second;
  }
  const ImageType& type(std::uint32_t index) const { return b_.image.types[index]; }

  void make_types() {
    for (std::size_t n = 2 + below(3); n > 0; --n) make_aggregate(0);
    // Components keep what they like; these few are told nothing before they run.
    for (const char* const name : {"LOWPASS", "RATE_LIMITER", "TRAPEZOID", "GEAR", kFailingTaskblock}) {
      if (random_.once_in(8)) declare_taskblock(name);
    }
    for (std::size_t n = 1 + below(3); n > 0; --n) {
      const stdlib::BlockSpec& block = stdlib::blocks()[below(stdlib::blocks().size())];
      declare_block(b_.block(block.name));
    }
    for (const char* const name : {"TON", "TOF", "TP", "CTU", "CTD", "CTUD", "SR", "RS", "R_TRIG", "F_TRIG"}) {
      if (random_.once_in(3)) declare_block(b_.block(name));
    }
  }
  void declare_block(std::uint32_t block) {
    const std::uint32_t ports = b_.image.blocks[block].type;
    blocks_.push_back({block, ports, b_.array(ports, 3, static_cast<std::int64_t>(below(3)) - 1), {}});
  }
  /// A taskblock of scalars.
  void declare_taskblock(const char* name) {
    if (const auto block = add_taskblock(b_, registry_, name)) declare_block(*block);
  }
  /// An array or structure, and what it is made of.
  std::uint32_t make_aggregate(int depth) {
    const auto part = [&] {
      if (depth < 2 && random_.once_in(3)) return make_aggregate(depth + 1);
      const std::uint32_t scalar = type_of(any_type());
      return random_.once_in(10) ? ref_type(scalar) : scalar;
    };
    std::uint32_t made = 0;
    if (random_.once_in(3)) {
      GrowingStruct s;
      for (std::size_t n = 2 + below(3); n > 0; --n) {
        const std::uint32_t field = part();
        s.add(b_.image, "m" + std::to_string(n), field, FieldRole::kMember, b_.fresh(field));
      }
      s.close();
      s.type.name = "S" + std::to_string(aggregates_.size());
      made = b_.add_type(std::move(s.type));
    } else {
      const std::uint32_t element = part();
      // One random number after the other: arguments of a call have no order of their own.
      const std::int64_t lower = static_cast<std::int64_t>(below(4)) - 2;
      made = b_.array(element, static_cast<std::uint32_t>(1 + below(6)), lower);
    }
    aggregates_.push_back(made);
    return made;
  }

  // ---- variables

  std::vector<std::byte> initial(std::uint32_t index) {
    std::vector<std::byte> bytes = b_.fresh(index);
    const TypeKind kind = type(index).kind;
    if (kind == TypeKind::kScalar || kind == TypeKind::kString) random_value(type(index), random_, bytes.data());
    return bytes;
  }
  /// A new variable of the body, or a global.
  Word declare(Scope& scope, std::uint32_t index) {
    if (scope.kind != PouKind::kFunction && random_.once_in(5)) return declare_global(index);
    const bool frame = scope.kind == PouKind::kFunction || random_.once_in(4);
    if (frame) return scope.pou.frame(scope.name(), index, FieldRole::kTemp, initial(index));
    return scope.pou.variable(scope.name(), index, FieldRole::kLocal, initial(index));
  }
  Word declare_global(std::uint32_t index) {
    ImageBuilder::GlobalOptions options;
    options.input = random_.once_in(6);
    if (tasks_ > 1 && !random_.once_in(3)) options.owner = static_cast<std::uint32_t>(below(tasks_));
    const Word word = b_.global("g" + std::to_string(globals_made_++), index, initial(index), options);
    note(global_leaves_, index, word);
    const TypeKind kind = type(index).kind;
    if (kind != TypeKind::kScalar && kind != TypeKind::kString) global_wholes_.push_back({index, word});
    return word;
  }
  /// Makes the leaves of a value known, of larger ones a few.
  void note(Leaves& leaves, std::uint32_t index, Word word, int depth = 0) {
    const ImageType& t = type(index);
    switch (t.kind) {
      case TypeKind::kScalar:
      case TypeKind::kString:
        leaves[number(t.elementary)].push_back(word);
        return;
      case TypeKind::kRef:
        return;
      case TypeKind::kArray:
        if (depth < 3 && t.size < 10'000) {
          note(leaves, t.element, word + static_cast<Word>(below(t.count)) * type(t.element).size, depth + 1);
        }
        return;
      case TypeKind::kStruct: {
        if (t.fields.empty() || depth >= 3) return;
        for (int n = 0; n < 3; ++n) {
          const ImageField& field = t.fields[below(t.fields.size())];
          if (field.name != bytecode::kObjectField) note(leaves, field.type, word + field.offset, depth + 1);
        }
      }
    }
  }
  Word read(Scope& scope, TypeId id) {
    // Often what an instruction before has just written: engines keep that at hand.
    if (scope.last[number(id)] && random_.once_in(4)) return *scope.last[number(id)];
    std::vector<Word>& constants = constants_[number(id)];
    const bool text = core::rep_of(id) == core::Rep::kStr || core::rep_of(id) == core::Rep::kWstr;
    if (random_.once_in(6)) {
      if (constants.empty() || random_.once_in(4)) {
        const std::uint32_t index = type_of(id);
        constants.push_back(b_.constant_bytes(index, initial(index)));
      }
      return random_.one_of(constants);
    }
    const std::vector<Word>& globals = global_leaves_[number(id)];
    if (scope.kind != PouKind::kFunction && !globals.empty() && random_.once_in(5)) return random_.one_of(globals);
    return own(scope, id, text ? 2 : 4);
  }
  Word write(Scope& scope, TypeId id) {
    const std::vector<Word>& globals = global_leaves_[number(id)];
    const bool global = scope.kind != PouKind::kFunction && !globals.empty() && random_.once_in(4);
    const Word word = global ? random_.one_of(globals) : own(scope, id, 4);
    scope.last[number(id)] = word;
    return word;
  }
  /// One of the leaves of the body; the fewer there are, the sooner a new one.
  Word own(Scope& scope, TypeId id, std::size_t enough) {
    std::vector<Word>& known = scope.leaves[number(id)];
    if (known.empty() || below(enough + known.size() * known.size()) < enough) {
      const Word word = declare(scope, type_of(id));
      if (bytecode::space_of(word) == Space::kGlobal) return word;
      known.push_back(word);
    }
    return random_.one_of(known);
  }
  /// A variable of exactly this type.
  Word whole(Scope& scope, std::uint32_t index) {
    std::vector<Word> found;
    const auto look = [&](const std::vector<Whole>& in) {
      for (const Whole& w : in) {
        if (w.type == index) found.push_back(w.word);
      }
    };
    look(scope.wholes);
    if (scope.kind != PouKind::kFunction) look(global_wholes_);
    if (!found.empty() && !random_.once_in(3 * found.size())) return random_.one_of(found);
    const Word word = declare(scope, index);
    if (bytecode::space_of(word) != Space::kGlobal) {
      scope.wholes.push_back({index, word});
      note(scope.leaves, index, word);
    }
    return word;
  }
  /// Where an instance is: never in a global or a frame, as the compiler has it.
  Word instance(Scope& scope, std::uint32_t index) {
    std::vector<Word> found;
    for (const Whole& w : scope.wholes) {
      if (w.type == index) found.push_back(w.word);
    }
    if (!found.empty() && !random_.once_in(4 * found.size())) return random_.one_of(found);
    const Word word = scope.pou.variable(scope.name(), index, FieldRole::kLocal);
    scope.wholes.push_back({index, word});
    note(scope.leaves, index, word);
    return word;
  }
  /// What an instruction reads or writes for a value of this type.
  Word value(Scope& scope, std::uint32_t index, bool written) {
    const ImageType& t = type(index);
    if (t.kind != TypeKind::kScalar && t.kind != TypeKind::kString) return whole(scope, index);
    return written ? write(scope, t.elementary) : read(scope, t.elementary);
  }

  Random random_;
  const taskblocks::Registry& registry_;
  ImageBuilder b_;
  std::size_t tasks_ = 1;
  std::vector<std::uint32_t> aggregates_;
  std::vector<Block> blocks_;  ///< of the library, and taskblocks; `pou` is the number of the block

 private:
  std::array<std::vector<std::uint32_t>, core::kTypeCount> types_;
  std::map<std::uint32_t, std::uint32_t> refs_;  ///< reference types by target
  Leaves global_leaves_;
  Leaves constants_;
  std::vector<Whole> global_wholes_;
  int globals_made_ = 0;
};

}  // namespace plc::test
