#include "native/dead_stores.h"

#include <algorithm>
#include <initializer_list>
#include <map>
#include <unordered_set>
#include <utility>

#include "native/library_rows.h"
#include "native/loops.h"
#include "native/translate.h"
#include "runtime/interpreter/operations.h"
#include "stdlib/library.h"

namespace plc::native {
namespace {

using runtime::LinkedCode;
using runtime::LinkedInstruction;

/// What a result is, in the register that holds it.
struct Value {
  unsigned bytes = 0;
  bool real = false;
  friend bool operator==(const Value&, const Value&) = default;
};
Value value_of(Type type) { return {bytes_of(type), is_real(type)}; }

/// An instruction whose code leaves its result in a register, or takes operands from one.
struct Role {
  std::optional<Value> result;
  Value operand;
  /// Bit n: word n of the instruction is an operand that is in its register when the instruction uses it, if the one
  /// before left it there.
  std::uint32_t taken = 0;
};

constexpr std::uint32_t words(std::initializer_list<unsigned> numbers) {
  std::uint32_t bits = 0;
  for (const unsigned number : numbers) bits |= 1u << number;
  return bits;
}

/// Not those whose rare cases call a kernel: that one looks into the table.
Role role_of_function(const std::uint32_t* w) {
  constexpr unsigned kFirst = 5;  // argument
  const auto row = function_of(runtime::load_pointer<stdlib::Kernel>(w + 1));
  if (!row) return {};
  const Value value = value_of(row->type);
  switch (row->function) {
    case Function::kSelect:
      return {value, value, words({kFirst + 1, kFirst + 2})};
    case Function::kLimit:
      return {value, value, words({kFirst + 1})};
    case Function::kLeast:
    case Function::kGreatest:
    case Function::kAbsolute:
    case Function::kNot:
      return {value, value, words({kFirst})};
    default:
      return {};
  }
}

Role role_of(const LinkedInstruction& instruction, const std::uint32_t* w) {
  const Operation operation = operation_of(instruction.op);
  const Value value = value_of(operation.type);
  switch (operation.form) {
    case Form::kAdd:
    case Form::kSub:
    case Form::kMul:
    case Form::kDiv:
    case Form::kMod:
    case Form::kAnd:
    case Form::kOr:
    case Form::kXor:
      return {value, value, words({2, 3})};
    case Form::kCompare:
      return {Value{1, false}, value, words({2, 3})};
    case Form::kMove:
      // What it leaves in a register may be a real or not.
      return {std::nullopt, value, words({2})};
    case Form::kCallLibrary:
      return role_of_function(w);
    default:
      return {};
  }
}

/// Straight code, from after.
class Finder {
 public:
  Finder(const LinkedCode& linked, std::span<const LinkedInstruction> body)
      : linked_(linked), body_(body), found_(body.size()) {
    for (const LinkedInstruction& instruction : body) {
      const std::uint32_t target = target_of(operation_of(instruction.op).form, words_of(instruction));
      if (target != kNoTarget) targets_.insert(target);
    }
  }

  DeadStores find() {
    for (std::size_t i = body_.size(); i-- > 0;) {
      visit(i);
      if (targets_.contains(body_[i].position)) overwritten_.clear();
    }
    return std::move(found_);
  }

 private:
  /// Who looks before it is overwritten.
  struct Reader {
    unsigned bytes = 0;
    std::optional<std::size_t> instruction{};
  };
  static constexpr std::uint32_t kMostBytes = 8;

  [[nodiscard]] const std::uint32_t* words_of(const LinkedInstruction& instruction) const {
    return linked_.data() + instruction.position;
  }

  void visit(std::size_t i) {
    const Instruction instruction{words_of(body_[i]), body_[i].position, operation_of(body_[i].op)};
    const Form form = instruction.operation.form;
    if (form == Form::kRunBlock) return visit_block(instruction.words, i);
    const auto accesses = accesses_of(linked_.data(), instruction);
    const bool leaves = form == Form::kReturn || target_of(form, instruction.words) != kNoTarget;
    if (!accesses || leaves) return overwritten_.clear();
    for (const Access& access : *accesses) {
      if (!access.write) continue;
      const auto later = overwritten_.find(access.operand);
      if (later != overwritten_.end() && later->second.bytes == access.bytes && later->second.instruction == i + 1 &&
          leaves_to_next(i, access.operand)) {
        found_[i] = access.operand;
      }
      overwritten_[access.operand] = {static_cast<unsigned>(access.bytes), std::nullopt};
    }
    for (const Access& access : *accesses) {
      if (!access.write) read(access.operand, access.bytes, i);
    }
  }
  /// A block of the library looks at its ports alone.
  void visit_block(const std::uint32_t* w, std::size_t i) {
    const auto step = runtime::load_pointer<stdlib::Step>(w + 1);
    const auto blocks = stdlib::blocks();
    const auto spec =
        std::find_if(blocks.begin(), blocks.end(), [step](const auto& block) { return block.step == step; });
    if (spec == blocks.end()) return overwritten_.clear();
    read(w[3], spec->size, i);
  }

  /// Only one instruction may look at what is overwritten.
  void read(std::uint32_t operand, std::uint64_t bytes, std::size_t i) {
    auto entry = overwritten_.lower_bound(operand < kMostBytes ? 0 : operand - kMostBytes + 1);
    while (entry != overwritten_.end() && entry->first < operand + bytes) {
      auto& [begin, reader] = *entry;
      if (begin + reader.bytes <= operand) {
        ++entry;
      } else if (begin == operand && reader.bytes == bytes && !reader.instruction) {
        reader.instruction = i;
        ++entry;
      } else {
        entry = overwritten_.erase(entry);
      }
    }
  }

  /// Whether instruction `i` leaves its result in a register, and the next one takes it from there.
  [[nodiscard]] bool leaves_to_next(std::size_t i, std::uint32_t operand) const {
    const std::uint32_t* const w = words_of(body_[i + 1]);
    const Role to = role_of(body_[i + 1], w);
    if (to.taken == 0) return false;
    const Role from = role_of(body_[i], words_of(body_[i]));
    // A move takes whatever there is.
    const bool moves = operation_of(body_[i + 1].op).form == Form::kMove;
    if (!from.result || (moves ? from.result->bytes != to.operand.bytes : *from.result != to.operand)) return false;
    for (unsigned n = 0; to.taken >> n != 0; ++n) {
      if ((to.taken >> n & 1u) != 0 && w[n] == operand) return true;
    }
    return false;
  }

  const LinkedCode& linked_;
  std::span<const LinkedInstruction> body_;
  DeadStores found_;
  std::unordered_set<std::uint32_t> targets_;
  std::map<std::uint32_t, Reader> overwritten_;  ///< after what is visited, by operand
};

}  // namespace

DeadStores find_dead_stores(const LinkedCode& linked, std::span<const LinkedInstruction> body) {
  return Finder(linked, body).find();
}

}  // namespace plc::native
