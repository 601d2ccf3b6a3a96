// Boolean runs: each look-up record as straight code, without branches.
//
// Every record stores its output, so that the table is the same whenever it is looked at. What is read again soon stays
// in registers as well (native/records.h).
#include <algorithm>
#include <cstddef>
#include <span>

#include "native/records.h"
#include "native/translate.h"

namespace plc::native {
namespace {

using Kind = BooleanExpression::Kind;

/// Temporary values of a record, and outputs that wait for their next reader: 0 or 1 in all bits.
constexpr std::uint32_t kRegisters[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

/// The expression of one record.
class Evaluation {
 public:
  Evaluation(Assembly& s, RecordRegisters& registers, const Record& record)
      : s_(s), registers_(registers), record_(record) {}

  /// Leaves the value in the register returned, which is taken.
  std::uint32_t value(const BooleanExpression& e) {
    switch (e.kind) {
      case Kind::kConstant: {
        const std::uint32_t to = registers_.take();
        s_.a.mov(a64::w(to), e.negated ? 1 : 0);
        return to;
      }
      case Kind::kInput: {
        const std::uint32_t to = first(e);
        if (e.negated) flip(to);
        return to;
      }
      case Kind::kAnd:
        return conjunction(e);
      case Kind::kOr:
        return disjunction(e);
      case Kind::kXor:
        return exclusive_or(e);
      case Kind::kTable:
        return table(e);
    }
    return 0;
  }

 private:
  using InstId = asmjit::InstId;
  static constexpr InstId kAnd = a64::Inst::kIdAnd, kOr = a64::Inst::kIdOrr, kXor = a64::Inst::kIdEor,
                          kAndNot = a64::Inst::kIdBic;

  void flip(std::uint32_t value) { s_.a.eor(a64::w(value), a64::w(value), 1); }
  /// The register that holds an input, if any does, or shall from now on: what is read again soon is loaded once.
  const std::uint32_t* held(const BooleanExpression& input) {
    const std::uint32_t operand = record_.in[input.input];
    if (const std::uint32_t* const holder = registers_.holder(operand)) return holder;
    const std::uint32_t next = record_.next[input.input];
    if (!registers_.worth_holding(next)) return nullptr;
    const std::uint32_t number = registers_.take();
    s_.a.ldrb(a64::w(number), s_.at(operand, 1));
    registers_.hold(number, operand, next);
    return registers_.holder(operand);
  }
  /// An input, whether negated or not, in a register that is taken.
  std::uint32_t first(const BooleanExpression& input) {
    const std::uint32_t* const holder = held(input);
    // Before a register is taken, which may be that one.
    const std::uint32_t from = holder != nullptr ? *holder : 0;
    const std::uint32_t to = registers_.take();
    if (holder == nullptr) {
      s_.a.ldrb(a64::w(to), s_.at(record_.in[input.input], 1));
    } else if (to != from) {
      s_.a.mov(a64::w(to), a64::w(from));
    }
    return to;
  }
  /// Another value joins the one in `to`, or is the first one there.
  void join(std::optional<std::uint32_t>& to, InstId id, const BooleanExpression& child) {
    if (child.kind != Kind::kInput) {
      const std::uint32_t part = value(child);
      if (!to) {
        to = part;
        return;
      }
      s_.a.emit(id, a64::w(*to), a64::w(*to), a64::w(part));
      registers_.give_back(part);
    } else if (!to) {
      to = first(child);
    } else if (const std::uint32_t* const holder = held(child)) {
      s_.a.emit(id, a64::w(*to), a64::w(*to), a64::w(*holder));
    } else {
      const std::uint32_t part = first(child);
      s_.a.emit(id, a64::w(*to), a64::w(*to), a64::w(part));
      registers_.give_back(part);
    }
  }
  static bool is_negated_input(const BooleanExpression& child) { return child.kind == Kind::kInput && child.negated; }
  /// All that are negated inputs, as if they were not, or all others.
  void join_all(std::optional<std::uint32_t>& to, InstId id, const BooleanExpression& e, bool negated) {
    for (const BooleanExpression& child : e.children) {
      if (is_negated_input(child) == negated) join(to, id, child);
    }
  }

  std::uint32_t conjunction(const BooleanExpression& e) {
    std::optional<std::uint32_t> to;
    join_all(to, kAnd, e, false);
    if (to) {
      join_all(to, kAndNot, e, true);
    } else {
      join_all(to, kOr, e, true);
      flip(*to);
    }
    return *to;
  }
  /// Negated inputs by De Morgan: together, and flipped once.
  std::uint32_t disjunction(const BooleanExpression& e) {
    std::optional<std::uint32_t> to;
    join_all(to, kAnd, e, true);
    if (to) flip(*to);
    join_all(to, kOr, e, false);
    return *to;
  }
  std::uint32_t exclusive_or(const BooleanExpression& e) {
    std::optional<std::uint32_t> to;
    join_all(to, kXor, e, false);
    if (e.negated) flip(*to);
    return *to;
  }

  /// The row's number as c0 + 2 (c1 + 2 (c2 + ..)), then its bit.
  std::uint32_t table(const BooleanExpression& e) {
    const std::uint32_t to = value(e.children.back());
    for (std::size_t i = e.children.size() - 1; i-- > 0;) {
      const std::uint32_t next = value(e.children[i]);
      s_.a.add(a64::w(to), a64::w(next), a64::w(to), asmjit::arm::lsl(1));
      registers_.give_back(next);
    }
    const std::uint32_t bits = registers_.take();
    s_.constant(a64::w(bits), e.table);
    s_.a.lsr(a64::w(to), a64::w(bits), a64::w(to));
    s_.a.and_(a64::w(to), a64::w(to), 1);
    registers_.give_back(bits);
    return to;
  }

  Assembly& s_;
  RecordRegisters& registers_;
  const Record& record_;
};

void translate(Assembly& s, std::span<const Record> records, BooleanExpressions& expressions) {
  RecordRegisters registers(kRegisters,
                            [&s](std::uint32_t number, std::uint32_t operand) { s.store(operand, 1, number); });
  if (const auto known = s.held_bit()) {
    registers.hold(known->number, known->operand, first_reader(records, known->operand));
  }
  for (const Record& r : records) {
    const std::uint32_t value = Evaluation(s, registers, r).value(expressions.of(r.truth, r.inputs));
    for (unsigned i = 0; i < r.inputs; ++i) registers.read(r.in[i], r.next[i]);
    if (registers.hold_out(value, r)) {
      s.store(r.out, 1, value);
    } else {
      s.forget();
    }
  }
}

}  // namespace

void translate_records(Assembly& s, const Instruction& i, const std::uint32_t* code, BooleanExpressions& expressions) {
  visit_records(i, code, [&](std::span<Record> records) {
    translate(s, records, expressions);
    s.keep_cold_paths_near();
  });
}

}  // namespace plc::native
