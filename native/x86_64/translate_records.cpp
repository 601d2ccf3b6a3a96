// Boolean runs: each look-up record as straight code on bytes, without branches.
//
// Every record stores its output, so that nothing differs for whoever looks at the table. What is read again soon stays
// in registers as well (native/records.h).
#include <algorithm>
#include <cstddef>
#include <iterator>
#include <span>

#include "native/records.h"
#include "native/translate.h"

namespace plc::native {
namespace {

using Kind = BooleanExpression::Kind;

/// Temporary values of a record, and outputs that wait for their next reader; upper bits of what is in them are not
/// known.
constexpr std::uint32_t kRegisters[] = {0, 1, 2, 6, 7, 8, 9, 10, 11};
/// Of them, those that loops leave.
constexpr std::size_t kRegistersInLoops = 5;

/// The expression of one record.
class Evaluation {
 public:
  Evaluation(Assembly& s, RecordRegisters& registers, const Record& record)
      : s_(s), registers_(registers), record_(record) {}

  /// Leaves the value as 0 or 1 in the low byte of the register returned, which is taken.
  std::uint32_t value(const BooleanExpression& e) {
    switch (e.kind) {
      case Kind::kConstant: {
        const std::uint32_t to = registers_.take();
        s_.a.mov(gp(to, 4), e.negated ? 1 : 0);
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
  /// The register that holds an input, if any does, or shall from now on: what is read again soon is loaded once.
  const std::uint32_t* held(const BooleanExpression& input) {
    const std::uint32_t operand = record_.in[input.input];
    if (const std::uint32_t* const holder = registers_.holder(operand)) return holder;
    const std::uint32_t next = record_.next[input.input];
    if (!registers_.worth_holding(next)) return nullptr;
    const std::uint32_t number = registers_.take();
    s_.a.movzx(gp(number, 4), s_.at(operand, 1));
    registers_.hold(number, operand, next);
    return registers_.holder(operand);
  }
  /// An input, whether negated or not; upper bits zero.
  std::uint32_t first(const BooleanExpression& input) {
    const std::uint32_t* const holder = held(input);
    // Before a register is taken, which may be that one.
    const std::uint32_t from = holder != nullptr ? *holder : 0;
    const std::uint32_t to = registers_.take();
    if (holder != nullptr) {
      s_.a.movzx(gp(to, 4), gp(from, 1));
    } else {
      s_.a.movzx(gp(to, 4), s_.at(record_.in[input.input], 1));
    }
    return to;
  }
  void combine(asmjit::InstId id, std::uint32_t to, const BooleanExpression& input) {
    if (const std::uint32_t* const holder = held(input)) {
      s_.a.emit(id, gp(to, 1), gp(*holder, 1));
    } else {
      s_.a.emit(id, gp(to, 1), s_.at(record_.in[input.input], 1));
    }
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

  /// Negated inputs by De Morgan: together, and flipped once.
  std::uint32_t and_or(const BooleanExpression& e) {
    const bool is_and = e.kind == Kind::kAnd;
    const asmjit::InstId opposite = is_and ? x86::Inst::kIdOr : x86::Inst::kIdAnd;
    if (!has_parts(e)) {
      if (!has_input(e, true)) return gather(e, false, id_of(e.kind));
      const std::uint32_t to = gather(e, true, opposite);
      flip(to);
      add(e, to);
      return to;
    }
    const std::uint32_t to = parts(e);
    add(e, to);
    // a AND NOT b is a > b; a OR NOT b is a >= b.
    const auto negated = [](const BooleanExpression& child) { return is_input(child, true); };
    const auto count = std::count_if(e.children.begin(), e.children.end(), negated);
    if (count == 0) return to;
    if (count == 1) {
      combine(x86::Inst::kIdCmp, to, *std::find_if(e.children.begin(), e.children.end(), negated));
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

  /// The row's number as c0 + 2 (c1 + 2 (c2 + ..)), then its bit.
  std::uint32_t table(const BooleanExpression& e) {
    const std::uint32_t to = value(e.children.back());
    s_.a.movzx(gp(to, 4), gp(to, 1));
    for (std::size_t i = e.children.size() - 1; i-- > 0;) {
      const std::uint32_t next = value(e.children[i]);
      s_.a.movzx(gp(next, 4), gp(next, 1));
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
  const Record& record_;
};

/// The register whose value the record only copies, if nobody else wants it.
const std::uint32_t* copied(const BooleanExpression& e, const Record& record, const RecordRegisters& registers) {
  const bool copies = e.kind == BooleanExpression::Kind::kInput && !e.negated && record.next[e.input] == kNever;
  return copies ? registers.holder(record.in[e.input]) : nullptr;
}

/// `last`: no others of the run behind them.
void translate(Assembly& s, const Instruction& i, std::span<const Record> records, bool last,
               BooleanExpressions& expressions) {
  const std::span<const std::uint32_t> numbers(kRegisters, s.in_loop() ? kRegistersInLoops : std::size(kRegisters));
  RecordRegisters registers(numbers,
                            [&s](std::uint32_t number, std::uint32_t operand) { s.store(operand, 1, number); });
  if (const auto known = s.held_bit())
    registers.hold(known->number, known->operand, first_reader(records, known->operand));
  for (const Record& r : records) {
    const BooleanExpression& e = expressions.of(r.truth, r.inputs);
    const std::uint32_t* const same = copied(e, r, registers);
    const std::uint32_t value = same != nullptr ? *same : Evaluation(s, registers, r).value(e);
    for (unsigned k = 0; k < r.inputs; ++k) registers.read(r.in[k], r.next[k]);
    if (last && i.may_owe(r.out) && r.next_of_out == kNever && !r.is_overwritten && registers.keep(value)) {
      s.forget();
      s.owe(r.out, value);
    } else if (!registers.hold_out(value, r)) {
      s.forget();
    } else if (i.is_port(r.out)) {
      // Blocks that do nothing see so in what their ports hold together, unless one was just written.
      s.store_change(r.out, 1, value);
      s.hold(r.out, value);
    } else {
      s.store(r.out, 1, value);
    }
  }
}

}  // namespace

void translate_records(Assembly& s, const Instruction& i, const std::uint32_t* code, BooleanExpressions& expressions) {
  std::size_t left = i.words[1];
  visit_records(i, code, [&](std::span<const Record> records) {
    left -= records.size();
    translate(s, i, records, left == 0, expressions);
  });
}

}  // namespace plc::native
