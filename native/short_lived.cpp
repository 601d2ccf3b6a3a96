#include "native/short_lived.h"

#include <initializer_list>
#include <map>
#include <unordered_set>
#include <utility>

#include "native/library_rows.h"
#include "native/loops.h"
#include "runtime/bool_run.h"
#include "runtime/operations.h"
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
  /// Bit n: word n of the instruction is an operand that is in its register when the instruction uses it, if the one in
  /// front left it there.
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

/// Straight code, from behind.
class Finder {
 public:
  Finder(const LinkedCode& linked, Footprints& footprints, std::span<const LinkedInstruction> body)
      : linked_(linked), footprints_(footprints), body_(body), found_(body.size()) {
    for (const LinkedInstruction& instruction : body) {
      const std::uint32_t target = target_of(operation_of(instruction.op).form, words_of(instruction));
      if (target != kNoTarget) targets_.insert(target);
    }
  }

  ShortLived find() {
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
    const LinkedInstruction& instruction = body_[i];
    if (is_boolean_run(operation_of(instruction.op).form)) {
      if (overwritten_.empty()) return;
      for (const runtime::GeneralRecord& record : footprints_.records_of(instruction)) {
        for (const std::uint32_t in : record.in) read({in, 1}, i);
      }
      return;
    }
    const Footprint f = footprints_.of(instruction);
    if (!f.pure || f.target) return overwritten_.clear();
    if (f.always_writes && f.writes.size() == 1 && f.writes[0].bytes <= kMostBytes) {
      const Range& out = f.writes[0];
      const auto later = overwritten_.find(out.begin);
      if (later != overwritten_.end() && later->second.bytes == out.bytes && later->second.instruction == i + 1 &&
          leaves_to_next(i, out.begin)) {
        found_[i] = out.begin;
      }
      overwritten_[out.begin] = {out.bytes, std::nullopt};
    }
    for (const Range& range : f.reads) read(range, i);
  }

  /// Nobody but one may look at what is overwritten.
  void read(const Range& range, std::size_t i) {
    auto entry = overwritten_.lower_bound(range.begin < kMostBytes ? 0 : range.begin - kMostBytes + 1);
    while (entry != overwritten_.end() && entry->first < range.begin + range.bytes) {
      auto& [begin, reader] = *entry;
      if (begin + reader.bytes <= range.begin) {
        ++entry;
      } else if (begin == range.begin && reader.bytes == range.bytes && !reader.instruction) {
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
  Footprints& footprints_;
  std::span<const LinkedInstruction> body_;
  ShortLived found_;
  std::unordered_set<std::uint32_t> targets_;
  std::map<std::uint32_t, Reader> overwritten_;  ///< behind what is visited, by operand
};

}  // namespace

ShortLived find_short_lived(const LinkedCode& linked, Footprints& footprints, std::span<const LinkedInstruction> body) {
  return Finder(linked, footprints, body).find();
}

}  // namespace plc::native
