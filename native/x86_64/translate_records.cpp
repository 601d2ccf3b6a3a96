// Boolean runs: each look-up record as straight code on bytes, without branches.
//
// Every record stores its output, so that the table is the same whenever it is looked at. What is read again soon stays
// in registers as well (native/records.h).
#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <optional>
#include <span>

#include "native/records.h"
#include "native/translate.h"

namespace plc::native {
namespace {

using Kind = BooleanExpression::Kind;

/// Temporary values of a record, and outputs that wait for their next reader.
constexpr std::uint32_t kRegisters[] = {0, 1, 2, 6, 7, 8, 9, 10, 11};
/// Of them, those that loops leave.
constexpr std::size_t kRegistersInLoops = 5;
/// Temporary values of a record that there are at a time, mostly.
constexpr std::size_t kTemporary = 2;

/// Registers whose upper bits are not known to be zero.
class Unclean {
 public:
  [[nodiscard]] bool operator[](std::uint32_t number) const { return (numbers_ >> number & 1u) != 0; }
  void set(std::uint32_t number, bool unclean) {
    numbers_ = (numbers_ & ~(1u << number)) | static_cast<std::uint32_t>(unclean) << number;
  }

 private:
  std::uint32_t numbers_ = 0;
};

/// The expression of one record.
class Evaluation {
 public:
  Evaluation(Assembly& s, RecordRegisters& registers, Unclean& unclean, const Record& record,
             const BooleanExpression& e)
      : s_(s), registers_(registers), unclean_(unclean), record_(record) {
    count_uses(e);
  }

  /// Leaves the value as 0 or 1 in the low byte of the register returned, which is taken.
  std::uint32_t value(const BooleanExpression& e) {
    switch (e.kind) {
      case Kind::kConstant: {
        const std::uint32_t to = registers_.take();
        s_.a.mov(gp(to, 4), e.negated ? 1 : 0);
        unclean_.set(to, false);
        return to;
      }
      case Kind::kInput: {
        const std::uint32_t to = first(e);
        if (e.negated) flip(to);
        return to;
      }
      case Kind::kAnd:
      case Kind::kOr:
        return and_or(e);
      case Kind::kXor:
        return exclusive_or(e);
      case Kind::kTable:
        return table(e);
    }
    return 0;
  }

 private:
  void flip(std::uint32_t value) { s_.a.xor_(gp(value, 1), 1); }
  /// Extended.
  void load(std::uint32_t to, const asmjit::Operand& from) {
    s_.a.emit(x86::Inst::kIdMovzx, gp(to, 4), from);
    unclean_.set(to, false);
  }
  /// The register that holds an input, if any does, or shall from now on: what is read again soon is loaded once.
  const std::uint32_t* held(const BooleanExpression& input) {
    const std::uint32_t operand = record_.in[input.input];
    if (const std::uint32_t* const holder = registers_.holder(operand)) return holder;
    const std::uint32_t next = record_.next[input.input];
    if (!registers_.worth_holding(next)) return nullptr;
    const std::uint32_t number = registers_.take();
    load(number, s_.at(operand, 1));
    registers_.hold(number, operand, next);
    return registers_.holder(operand);
  }
  void count_uses(const BooleanExpression& e) {
    if (e.kind == Kind::kInput) ++uses_[e.input];
    for (const BooleanExpression& child : e.children) count_uses(child);
  }
  /// An input was read, or is by the next instruction. Whether nothing else needs what holds it.
  bool is_last_use(const BooleanExpression& input) {
    return --uses_[input.input] == 0 && record_.next[input.input] == kNever;
  }

  /// An input, whether negated or not, in a register that is taken.
  std::uint32_t first(const BooleanExpression& input) {
    const std::uint32_t* const holder = held(input);
    const bool last = is_last_use(input);
    if (holder == nullptr) {
      const std::uint32_t to = registers_.take();
      load(to, s_.at(record_.in[input.input], 1));
      return to;
    }
    // Before a register is taken, which may be that one.
    const std::uint32_t from = *holder;
    if (last) {
      registers_.take_over(from);
      return from;
    }
    const std::uint32_t to = registers_.take();
    load(to, gp(from, 1));
    return to;
  }
  void combine(asmjit::InstId id, std::uint32_t to, const BooleanExpression& input) {
    if (const std::uint32_t* const holder = held(input)) {
      s_.a.emit(id, gp(to, 1), gp(*holder, 1));
    } else {
      s_.a.emit(id, gp(to, 1), s_.at(record_.in[input.input], 1));
    }
    is_last_use(input);
  }
  /// A register to read: one that holds the input, or a temporary one. `taken` says which.
  std::uint32_t in_register(const BooleanExpression& input, bool& taken) {
    const std::uint32_t* const holder = held(input);
    taken = holder == nullptr || (uses_[input.input] == 1 && record_.next[input.input] == kNever);
    if (taken) return first(input);
    is_last_use(input);
    return *holder;
  }
  static asmjit::InstId id_of(Kind kind) {
    return kind == Kind::kAnd ? x86::Inst::kIdAnd : kind == Kind::kOr ? x86::Inst::kIdOr : x86::Inst::kIdXor;
  }
  static bool is_input(const BooleanExpression& child, bool negated) {
    return child.kind == Kind::kInput && child.negated == negated;
  }
  static bool has_input(const BooleanExpression& e, bool negated) {
    return std::any_of(e.children.begin(), e.children.end(),
                       [negated](const BooleanExpression& child) { return is_input(child, negated); });
  }
  /// Ands (or ors, ..) all inputs of these that are negated, or all that are not; there is one.
  std::uint32_t gather(const BooleanExpression& e, bool negated, asmjit::InstId id) {
    std::uint32_t to = 0;
    bool any = false;
    for (const BooleanExpression& child : e.children) {
      if (!is_input(child, negated)) continue;
      if (any) {
        combine(id, to, child);
      } else {
        to = first(child);
      }
      any = true;
    }
    return to;
  }
  void add(const BooleanExpression& e, std::uint32_t to) {
    for (const BooleanExpression& child : e.children) {
      if (is_input(child, false)) combine(id_of(e.kind), to, child);
    }
  }
  static bool has_parts(const BooleanExpression& e) {
    return std::any_of(e.children.begin(), e.children.end(),
                       [](const BooleanExpression& child) { return child.kind != Kind::kInput; });
  }
  /// The children that are not inputs; there is one.
  std::uint32_t parts(const BooleanExpression& e) {
    std::uint32_t to = 0;
    bool any = false;
    for (const BooleanExpression& child : e.children) {
      if (child.kind == Kind::kInput) continue;
      const std::uint32_t part = value(child);
      if (any) {
        s_.a.emit(id_of(e.kind), gp(to, 1), gp(part, 1));
        registers_.give_back(part);
      } else {
        to = part;
      }
      any = true;
    }
    return to;
  }

  static bool is_negated(const BooleanExpression& child) { return is_input(child, true); }
  static std::ptrdiff_t count_negated(const BooleanExpression& e) {
    return std::count_if(e.children.begin(), e.children.end(), is_negated);
  }
  static const BooleanExpression& only_negated(const BooleanExpression& e) {
    return *std::find_if(e.children.begin(), e.children.end(), is_negated);
  }
  /// An input that is not negated: one that is in a register, if possible.
  const BooleanExpression& best_plain(const BooleanExpression& e) const {
    const auto is_plain = [](const BooleanExpression& child) { return is_input(child, false); };
    auto best = std::find_if(e.children.begin(), e.children.end(), is_plain);
    for (auto child = best; child != e.children.end(); ++child) {
      if (is_plain(*child) && registers_.holder(record_.in[child->input]) != nullptr) best = child;
    }
    return *best;
  }
  /// All negated inputs, as if they were not, in a register to read.
  std::uint32_t negated(const BooleanExpression& e, asmjit::InstId id, bool& taken) {
    taken = true;
    return count_negated(e) == 1 ? in_register(only_negated(e), taken) : gather(e, true, id);
  }
  /// Inputs, negated ones and others.
  std::uint32_t and_not(const BooleanExpression& e) {
    const BooleanExpression& plain = best_plain(e);
    bool takes_other = false, takes_from = false;
    const std::uint32_t other = negated(e, x86::Inst::kIdOr, takes_other);
    if (!takes_other) registers_.pin(other, true);
    const std::uint32_t from = in_register(plain, takes_from);
    if (!takes_other) registers_.pin(other, false);
    const std::uint32_t to = takes_from ? from : takes_other ? other : registers_.take();
    s_.a.andn(gp(to, 4), gp(other, 4), gp(from, 4));
    unclean_.set(to, unclean_[from]);
    if (takes_other && takes_from) registers_.give_back(other);
    for (const BooleanExpression& child : e.children) {
      if (is_input(child, false) && &child != &plain) combine(x86::Inst::kIdAnd, to, child);
    }
    return to;
  }
  /// One negated input and others, as a comparison, if one of them is in a register and may stay there.
  std::optional<std::uint32_t> or_not(const BooleanExpression& e) {
    const BooleanExpression &plain = best_plain(e), &other = only_negated(e);
    const bool has_other = held(other) != nullptr;
    // Flipped where it is.
    if (has_other && uses_[other.input] == 1 && record_.next[other.input] == kNever) return std::nullopt;
    if (!has_other && registers_.holder(record_.in[plain.input]) == nullptr) return std::nullopt;
    const auto operand = [this](const BooleanExpression& input) -> asmjit::Operand {
      if (const std::uint32_t* const holder = registers_.holder(record_.in[input.input])) return gp(*holder, 1);
      return s_.at(record_.in[input.input], 1);
    };
    s_.a.emit(x86::Inst::kIdCmp, operand(plain), operand(other));
    is_last_use(plain);
    is_last_use(other);
    const std::uint32_t to = registers_.take();
    s_.a.setae(gp(to, 1));
    unclean_.set(to, true);
    for (const BooleanExpression& child : e.children) {
      if (is_input(child, false) && &child != &plain) combine(x86::Inst::kIdOr, to, child);
    }
    return to;
  }

  /// Negated inputs by De Morgan: together, and flipped once.
  std::uint32_t and_or(const BooleanExpression& e) {
    const bool is_and = e.kind == Kind::kAnd;
    const asmjit::InstId opposite = is_and ? x86::Inst::kIdOr : x86::Inst::kIdAnd;
    if (!has_parts(e)) {
      if (!has_input(e, true)) return gather(e, false, id_of(e.kind));
      // Loops leave few registers.
      if (is_and && s_.has_andn() && !s_.in_loop() && has_input(e, false)) return and_not(e);
      if (!is_and && !s_.in_loop() && count_negated(e) == 1 && has_input(e, false)) {
        if (const auto to = or_not(e)) return *to;
      }
      const std::uint32_t to = gather(e, true, opposite);
      flip(to);
      add(e, to);
      return to;
    }
    const std::uint32_t to = parts(e);
    add(e, to);
    // a AND NOT b is a > b; a OR NOT b is a >= b.
    const auto count = count_negated(e);
    if (count == 0) return to;
    if (is_and && s_.has_andn()) {
      bool taken = true;
      const std::uint32_t other = negated(e, x86::Inst::kIdOr, taken);
      s_.a.andn(gp(to, 4), gp(other, 4), gp(to, 4));
      if (taken) registers_.give_back(other);
      return to;
    }
    if (count == 1) {
      combine(x86::Inst::kIdCmp, to, only_negated(e));
    } else {
      const std::uint32_t other = gather(e, true, opposite);
      s_.a.cmp(gp(to, 1), gp(other, 1));
      registers_.give_back(other);
    }
    s_.a.set(is_and ? x86::CondCode::kA : x86::CondCode::kAE, gp(to, 1));
    return to;
  }

  std::uint32_t exclusive_or(const BooleanExpression& e) {
    std::uint32_t to = 0;
    if (has_parts(e)) {
      to = parts(e);
      add(e, to);
    } else {
      to = gather(e, false, x86::Inst::kIdXor);
    }
    if (e.negated) flip(to);
    return to;
  }

  /// With upper bits zero.
  std::uint32_t extended(const BooleanExpression& e) {
    const std::uint32_t to = value(e);
    if (unclean_[to]) load(to, gp(to, 1));
    return to;
  }
  /// The row's number as c0 + 2 (c1 + 2 (c2 + ..)), then its bit.
  std::uint32_t table(const BooleanExpression& e) {
    const std::uint32_t to = extended(e.children.back());
    for (std::size_t i = e.children.size() - 1; i-- > 0;) {
      const std::uint32_t next = extended(e.children[i]);
      s_.a.lea(gp(to, 4), x86::ptr(gp(next, 8), gp(to, 8), 1));
      registers_.give_back(next);
    }
    const std::uint32_t bits = registers_.take();
    s_.a.mov(gp(bits, 4), e.table);
    s_.a.bt(gp(bits, 4), gp(to, 4));
    registers_.give_back(bits);
    s_.a.setc(gp(to, 1));
    return to;
  }

  Assembly& s_;
  RecordRegisters& registers_;
  Unclean& unclean_;
  const Record& record_;
  std::array<std::uint32_t, 5> uses_{};  ///< of each input, still to come
};

/// The register whose value the record only copies, if nothing else needs it.
const std::uint32_t* copied(const BooleanExpression& e, const Record& record, const RecordRegisters& registers) {
  const bool copies = e.kind == BooleanExpression::Kind::kInput && !e.negated && record.next[e.input] == kNever;
  return copies ? registers.holder(record.in[e.input]) : nullptr;
}

/// `last`: no others of the run after them.
void translate(Assembly& s, const Instruction& i, std::span<Record> records, bool last,
               BooleanExpressions& expressions) {
  const std::span<const std::uint32_t> numbers(kRegisters, s.in_loop() ? kRegistersInLoops : std::size(kRegisters));
  forget_late_readers(records, numbers.size() - kTemporary);
  RecordRegisters registers(numbers,
                            [&s](std::uint32_t number, std::uint32_t operand) { s.store(operand, 1, number); });
  Unclean unclean;
  if (const auto known = s.held_bit()) {
    registers.hold(known->number, known->operand, first_reader(records, known->operand));
    unclean.set(known->number, true);
  }
  for (const Record& r : records) {
    const BooleanExpression& e = expressions.of(r.truth, r.inputs);
    const std::uint32_t* const same = copied(e, r, registers);
    const std::uint32_t value = same != nullptr ? *same : Evaluation(s, registers, unclean, r, e).value(e);
    for (unsigned k = 0; k < r.inputs; ++k) registers.read(r.in[k], r.next[k]);
    if (last && i.may_defer(r.out) && r.next_of_out == kNever && !r.is_overwritten && registers.keep(value)) {
      s.forget();
      s.defer_store({r.out, value, !unclean[value]});
    } else if (!registers.hold_out(value, r)) {
      s.forget();
    } else if (i.is_port(r.out)) {
      // Blocks that do nothing see so in what their ports hold together, unless one was just written.
      s.store_change(r.out, value);
      s.hold_bit(r.out, value);
    } else {
      s.store(r.out, 1, value);
    }
  }
}

}  // namespace

void translate_records(Assembly& s, const Instruction& i, const std::uint32_t* code, BooleanExpressions& expressions) {
  std::size_t left = i.words[1];
  visit_records(i, code, [&](std::span<Record> records) {
    left -= records.size();
    translate(s, i, records, left == 0, expressions);
  });
}

}  // namespace plc::native
