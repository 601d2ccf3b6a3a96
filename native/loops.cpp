#include "native/loops.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "native/library_rows.h"
#include "native/records.h"
#include "runtime/interpreter/operations.h"

namespace plc::native {

using runtime::LinkedInstruction;

std::uint32_t target_of(Form form, const std::uint32_t* words) {
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
      return kNoTarget;
  }
}

namespace {

/// Words: kernel (2), arguments, result, then the arguments.
bool add_call(std::vector<Access>& found, const std::uint32_t* words) {
  const stdlib::Overload* const overload =
      stdlib::overload_with_kernel(runtime::load_pointer<stdlib::Kernel>(words + 1));
  if (overload == nullptr) return false;
  const auto number = [](Type type) { return is_real(type) ? Use::kReal : Use::kInteger; };
  for (std::uint32_t n = 0; n < words[3]; ++n) {
    const auto type = machine_type(overload->param_type(n));
    if (!type) return false;
    found.push_back({words[5 + n], bytes_of(*type), number(*type), false});
  }
  const auto type = machine_type(overload->result_type());
  if (!type) return false;
  found.push_back({words[4], bytes_of(*type), number(*type), true});
  return true;
}

}  // namespace

std::optional<std::vector<Access>> accesses_of(const std::uint32_t* code, const Instruction& i) {
  const Type type = i.operation.type;
  const unsigned bytes = bytes_of(type);
  const Use number = is_real(type) ? Use::kReal : Use::kInteger;
  std::vector<Access> found;
  const auto read = [&](unsigned word, unsigned size, Use use) { found.push_back({i.words[word], size, use, false}); };
  const auto write = [&](unsigned word, unsigned size, Use use) { found.push_back({i.words[word], size, use, true}); };
  switch (i.operation.form) {
    case Form::kReturn:
    case Form::kBlockStart:
    case Form::kArranged:
    case Form::kJump:
    case Form::kLoopJump:
      return found;
    case Form::kJumpUnless:
    case Form::kJumpIf:
      read(1, 1, Use::kInteger);
      return found;
    case Form::kMove:
      write(1, bytes, is_real(type) ? Use::kReal : Use::kBits);
      read(2, bytes, is_real(type) ? Use::kReal : Use::kBits);
      return found;
    case Form::kAdd:
    case Form::kSub:
    case Form::kMul:
    case Form::kDiv:
    case Form::kMod:
    case Form::kAnd:
    case Form::kOr:
    case Form::kXor:
      write(1, bytes, number);
      read(2, bytes, number);
      read(3, bytes, number);
      return found;
    case Form::kCompare:
    case Form::kCompareJumpUnless:
    case Form::kCompareJumpIf:
      write(1, 1, Use::kInteger);
      read(2, bytes, number);
      read(3, bytes, number);
      return found;
    case Form::kRange:
      write(1, bytes, Use::kInteger);
      for (unsigned word = 2; word <= 4; ++word) read(word, bytes, Use::kInteger);
      return found;
    case Form::kExtract:
      write(1, 1, Use::kInteger);
      read(2, 1, Use::kInteger);
      return found;
    case Form::kInsert:
      write(1, 1, Use::kInteger);
      read(1, 1, Use::kInteger);
      read(2, 1, Use::kInteger);
      return found;
    case Form::kLoadElement:
    case Form::kStoreElement: {
      const std::uint32_t* const index = i.words + 3;
      if (i.operation.form == Form::kLoadElement) {
        write(1, bytes, Use::kBits);
      } else {
        read(1, bytes, Use::kBits);
      }
      found.push_back({i.words[2], std::uint64_t{index[1]} * index[2], Use::kMemory, false});
      found.push_back({index[0], core::rep_bytes(static_cast<core::Rep>(index[5])), Use::kInteger, false});
      return found;
    }
    case Form::kLoadPath:
    case Form::kStorePath: {
      if (i.operation.form == Form::kLoadPath) {
        write(1, bytes, Use::kBits);
      } else {
        read(1, bytes, Use::kBits);
      }
      const std::uint32_t* index = i.words + 5;
      std::uint64_t parts = bytes;
      for (std::uint32_t n = 0; n < i.words[4]; ++n, index += runtime::kIndexWords) {
        if (index[1] != 0) parts += std::uint64_t{index[1] - 1} * index[2];
        found.push_back({index[0], core::rep_bytes(static_cast<core::Rep>(index[5])), Use::kInteger, false});
      }
      found.push_back({i.words[2] + i.words[3], parts, Use::kMemory, false});
      return found;
    }
    case Form::kShortRecords4:
    case Form::kShortRecords5:
    case Form::kGeneralRecords:
      for (std::uint32_t n = 0; n < i.words[1]; ++n) {
        const Record record = record_at(i, code, n);
        found.push_back({record.out, 1, Use::kMemory, false});
        for (unsigned k = 0; k < record.inputs; ++k) found.push_back({record.in[k], 1, Use::kMemory, false});
      }
      return found;
    case Form::kCallLibrary:
      return add_call(found, i.words) ? std::optional(std::move(found)) : std::nullopt;
    default:
      return std::nullopt;
  }
}

namespace {

/// Collects the variables of one loop.
class Variables {
 public:
  void add(const Access& access, std::uint64_t weight) {
    Variable& variable = variables_[access.operand];
    if (variable.bytes != 0 && variable.bytes != access.bytes) variable.in_memory = true;
    variable.bytes = std::max(variable.bytes, access.bytes);
    variable.weight += access.use == Use::kMemory ? 0 : weight;
    variable.integer = variable.integer || access.use == Use::kInteger;
    variable.real = variable.real || access.use == Use::kReal;
    variable.in_memory = variable.in_memory || access.use == Use::kMemory;
    variable.written = variable.written || access.write;
  }

  /// Those that may lie in a register.
  std::vector<LoopVariable> take() {
    // Ascending operands, so an overlap is with the one that has reached furthest.
    std::uint64_t reached = 0;
    Variable* furthest = nullptr;
    for (auto& [operand, variable] : variables_) {
      if (furthest != nullptr && operand < reached) furthest->in_memory = variable.in_memory = true;
      if (furthest == nullptr || operand + variable.bytes > reached) {
        reached = operand + variable.bytes;
        furthest = &variable;
      }
    }
    std::vector<LoopVariable> found;
    for (const auto& [operand, variable] : variables_) {
      if (variable.in_memory || (variable.integer && variable.real)) continue;
      found.push_back(
          {operand, static_cast<unsigned>(variable.bytes), variable.real, variable.written, variable.weight});
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const LoopVariable& a, const LoopVariable& b) { return a.weight > b.weight; });
    return found;
  }

 private:
  struct Variable {
    std::uint64_t bytes = 0, weight = 0;
    bool integer = false, real = false, in_memory = false, written = false;
  };
  std::map<std::uint32_t, Variable> variables_;  ///< by operand
};

class Finder {
 public:
  Finder(const std::uint32_t* code, std::span<const LinkedInstruction> instructions)
      : code_(code), instructions_(instructions) {}

  std::vector<Loop> find() {
    for (std::size_t i = 0; i < instructions_.size(); ++i) {
      if (form(i) == Form::kLoopJump) all_.push_back({index_at(words(i)[1]), i});
    }
    // Outer loops before those inside.
    std::stable_sort(all_.begin(), all_.end(), [](const Interval& a, const Interval& b) {
      return a.first != b.first ? a.first < b.first : a.last > b.last;
    });
    find_innermost();
    refuse_other_entries();
    std::vector<Loop> found;
    for (const Interval& loop : all_) {
      if (!loop.fit || (!found.empty() && loop.first <= found.back().last)) continue;
      if (auto known = variables_of(loop)) found.push_back(std::move(*known));
    }
    return found;
  }

 private:
  static constexpr std::size_t kNone = ~std::size_t{0};
  struct Interval {
    std::size_t first = 0, last = 0;
    std::size_t outer = kNone;  ///< the loop around it
    std::uint64_t weight = 8;   ///< of an instruction in it
    bool fit = true;
    [[nodiscard]] bool contains(std::size_t i) const { return first <= i && i <= last; }
  };

  [[nodiscard]] const std::uint32_t* words(std::size_t i) const { return code_ + instructions_[i].position; }
  [[nodiscard]] Form form(std::size_t i) const { return operation_of(instructions_[i].op).form; }
  [[nodiscard]] std::size_t index_at(std::uint32_t position) const {
    const auto at = std::lower_bound(instructions_.begin(), instructions_.end(), position,
                                     [](const LinkedInstruction& i, std::uint32_t p) { return i.position < p; });
    return static_cast<std::size_t>(at - instructions_.begin());
  }
  void find_innermost() {
    if (all_.empty()) return;
    constexpr std::uint64_t kVeryDeep = std::uint64_t{1} << 30;
    innermost_.resize(instructions_.size(), kNone);
    for (std::size_t l = 0; l < all_.size(); ++l) {
      Interval& loop = all_[l];
      loop.outer = innermost_[loop.first];
      if (loop.outer != kNone) {
        loop.weight = std::min(all_[loop.outer].weight * 8, kVeryDeep);
        // Loops that lie across each other are not what languages have.
        if (all_[loop.outer].last < loop.last) loop.fit = all_[loop.outer].fit = false;
      }
      std::fill(innermost_.begin() + static_cast<std::ptrdiff_t>(loop.first),
                innermost_.begin() + static_cast<std::ptrdiff_t>(loop.last) + 1, l);
    }
  }
  /// Loops that a jump enters past their heads.
  void refuse_other_entries() {
    if (all_.empty()) return;
    for (std::size_t i = 0; i < instructions_.size(); ++i) {
      const std::uint32_t target = target_of(form(i), words(i));
      if (target == kNoTarget) continue;
      const std::size_t at = index_at(target);
      for (std::size_t l = innermost_[at]; l != kNone && !all_[l].contains(i); l = all_[l].outer) {
        if (at != all_[l].first) all_[l].fit = false;
      }
    }
  }

  [[nodiscard]] std::optional<Loop> variables_of(const Interval& loop) const {
    Loop result{loop.first, loop.last, {}, {}};
    Variables variables;
    for (std::size_t i = loop.first; i <= loop.last; ++i) {
      const Instruction instruction{words(i), instructions_[i].position, operation_of(instructions_[i].op)};
      const auto accesses = accesses_of(code_, instruction);
      if (!accesses) return std::nullopt;
      for (const Access& access : *accesses) variables.add(access, all_[innermost_[i]].weight);
    }
    result.variables = variables.take();
    for (std::size_t l = 0; l < all_.size(); ++l) {
      const auto [first, last] = std::pair(all_[l].first, all_[l].last);
      if (!all_[l].fit || !loop.contains(first) || !loop.contains(last)) continue;
      if (std::all_of(innermost_.begin() + static_cast<std::ptrdiff_t>(first),
                      innermost_.begin() + static_cast<std::ptrdiff_t>(last) + 1,
                      [l](std::size_t innermost) { return innermost == l; })) {
        result.inner.push_back({first, last, counts(first, last)});
      }
    }
    return result;
  }

  [[nodiscard]] Operation operation(std::size_t i) const { return operation_of(instructions_[i].op); }
  /// Whether the loop [first, last] is as Loop::Inner::counts says.
  [[nodiscard]] bool counts(std::size_t first, std::size_t last) const {
    if (last < first + 2) return false;
    const std::size_t compare = last - 2;
    const Operation relation = operation(compare), count = operation(last - 1);
    const std::uint32_t control = words(compare)[2], limit = words(compare)[3], step = words(last - 1)[3];
    const bool up = relation.relation == Relation::kLt && count.form == Form::kAdd;
    const bool down = relation.relation == Relation::kGt && count.form == Form::kSub;
    if (relation.form != Form::kCompareJumpUnless || (!up && !down) ||
        (relation.type != Type::kI16 && relation.type != Type::kI32) || is_real(count.type) ||
        bytes_of(count.type) != bytes_of(relation.type) || words(last - 1)[1] != control ||
        words(last - 1)[2] != control) {
      return false;
    }
    const unsigned bytes = bytes_of(relation.type);
    for (std::size_t i = first; i <= last; ++i) {
      const bool goes_elsewhere = form(i) == Form::kReturn || target_of(form(i), words(i)) != kNoTarget;
      if (goes_elsewhere && i != compare && i != last) return false;
      const auto accesses = accesses_of(code_, {words(i), instructions_[i].position, operation(i)});
      if (!accesses) return false;
      for (const Access& access : *accesses) {
        if (!access.write && access.use != Use::kMemory) continue;
        for (const std::uint32_t operand : {control, limit, step}) {
          const bool overlaps =
              access.operand < std::uint64_t{operand} + bytes && operand < access.operand + access.bytes;
          if (overlaps && (i != last - 1 || operand != control)) return false;
        }
      }
    }
    return true;
  }

  const std::uint32_t* code_;
  std::span<const LinkedInstruction> instructions_;
  std::vector<Interval> all_;
  std::vector<std::size_t> innermost_;  ///< by instruction: into all_
};

}  // namespace

std::vector<Loop> find_loops(const std::uint32_t* code, std::span<const LinkedInstruction> instructions) {
  return Finder(code, instructions).find();
}

}  // namespace plc::native
