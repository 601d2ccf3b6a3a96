// Boolean runs: each look-up record as straight code on bytes, without branches.
//
// A record that reads what the one before it wrote takes it from the register; every record stores its output, so that
// nothing differs for whoever looks at the table.
#include <algorithm>
#include <array>
#include <cstddef>

#include "native/translate.h"
#include "runtime/bool_run.h"

namespace plc::native {
namespace {

using Kind = BooleanExpression::Kind;

/// Expressions of one record, whose inputs are these operands.
class Evaluation {
 public:
  Evaluation(Assembly& s, const std::uint32_t* inputs) : s_(s), inputs_(inputs) {}

  /// Leaves the value as 0 or 1 in the register returned, upper bits zero. `depth` registers are in use.
  std::uint32_t value(const BooleanExpression& e, unsigned depth) {
    const std::uint32_t to = number(depth);
    switch (e.kind) {
      case Kind::kConstant:
        s_.a.mov(gp(to, 4), e.negated ? 1 : 0);
        break;
      case Kind::kInput:
        first(to, e);
        if (e.negated) flip(to);
        break;
      case Kind::kAnd:
      case Kind::kOr:
        and_or(e, depth);
        break;
      case Kind::kXor:
        exclusive_or(e, depth);
        break;
      case Kind::kTable:
        table(e, depth);
        break;
    }
    return to;
  }

 private:
  /// Register at this depth. The one that holds the last output stays as it is.
  [[nodiscard]] std::uint32_t number(unsigned depth) const {
    static constexpr std::array<std::uint32_t, 9> kNumbers = {0, 1, 2, 6, 7, 8, 9, 10, 11};
    const auto held = std::find(kNumbers.begin(), kNumbers.end(), s_.holder());
    const bool at_or_after = held != kNumbers.end() && depth >= static_cast<unsigned>(held - kNumbers.begin());
    return kNumbers[depth + (at_or_after ? 1 : 0)];
  }
  [[nodiscard]] bool is_held(const BooleanExpression& input) const { return s_.holds(inputs_[input.input], 1); }

  void flip(std::uint32_t value) { s_.a.xor_(gp(value, 1), 1); }
  /// An input, whether negated or not.
  void first(std::uint32_t to, const BooleanExpression& input) {
    if (is_held(input)) {
      s_.a.movzx(gp(to, 4), gp(s_.holder(), 1));
    } else {
      s_.a.movzx(gp(to, 4), s_.at(inputs_[input.input], 1));
    }
  }
  void combine(asmjit::InstId id, std::uint32_t to, const BooleanExpression& input) {
    if (is_held(input)) {
      s_.a.emit(id, gp(to, 1), gp(s_.holder(), 1));
    } else {
      s_.a.emit(id, gp(to, 1), s_.at(inputs_[input.input], 1));
    }
  }
  static asmjit::InstId id_of(Kind kind) {
    return kind == Kind::kAnd ? x86::Inst::kIdAnd : kind == Kind::kOr ? x86::Inst::kIdOr : x86::Inst::kIdXor;
  }
  /// Ands (or ors, ..) all inputs of these that are negated, or all that are not, in `to`; whether there was one.
  bool gather(const BooleanExpression& e, bool negated, asmjit::InstId id, std::uint32_t to) {
    bool any = false;
    for (const BooleanExpression& child : e.children) {
      if (child.kind != Kind::kInput || child.negated != negated) continue;
      if (any) {
        combine(id, to, child);
      } else {
        first(to, child);
      }
      any = true;
    }
    return any;
  }
  void add(const BooleanExpression& e, std::uint32_t to) {
    for (const BooleanExpression& child : e.children) {
      if (child.kind == Kind::kInput && !child.negated) combine(id_of(e.kind), to, child);
    }
  }
  /// The children that are not inputs; false when there are none.
  bool parts(const BooleanExpression& e, unsigned depth) {
    bool any = false;
    for (const BooleanExpression& child : e.children) {
      if (child.kind == Kind::kInput) continue;
      const std::uint32_t part = value(child, depth + (any ? 1 : 0));
      if (any) s_.a.emit(id_of(e.kind), gp(number(depth), 1), gp(part, 1));
      any = true;
    }
    return any;
  }

  /// Negated inputs by De Morgan: together, and flipped once.
  void and_or(const BooleanExpression& e, unsigned depth) {
    const bool is_and = e.kind == Kind::kAnd;
    const asmjit::InstId opposite = is_and ? x86::Inst::kIdOr : x86::Inst::kIdAnd;
    const std::uint32_t to = number(depth);
    if (!parts(e, depth)) {
      if (gather(e, true, opposite, to)) {
        flip(to);
        add(e, to);
      } else {
        gather(e, false, id_of(e.kind), to);
      }
      return;
    }
    add(e, to);
    // a AND NOT b is a > b; a OR NOT b is a >= b.
    const auto negated = [](const BooleanExpression& child) { return child.kind == Kind::kInput && child.negated; };
    const auto count = std::count_if(e.children.begin(), e.children.end(), negated);
    if (count == 0) return;
    if (count == 1) {
      combine(x86::Inst::kIdCmp, to, *std::find_if(e.children.begin(), e.children.end(), negated));
    } else {
      gather(e, true, opposite, number(depth + 1));
      s_.a.cmp(gp(to, 1), gp(number(depth + 1), 1));
    }
    s_.a.set(is_and ? x86::CondCode::kA : x86::CondCode::kAE, gp(to, 1));
  }

  void exclusive_or(const BooleanExpression& e, unsigned depth) {
    const std::uint32_t to = number(depth);
    if (parts(e, depth)) {
      add(e, to);
    } else {
      gather(e, false, x86::Inst::kIdXor, to);
    }
    if (e.negated) flip(to);
  }

  /// The row's number as c0 + 2 (c1 + 2 (c2 + ..)), then its bit.
  void table(const BooleanExpression& e, unsigned depth) {
    const std::uint32_t to = number(depth);
    const std::uint32_t next = number(depth + 1);
    value(e.children.back(), depth);
    for (std::size_t i = e.children.size() - 1; i-- > 0;) {
      value(e.children[i], depth + 1);
      s_.a.lea(gp(to, 4), x86::ptr(gp(next, 8), gp(to, 8), 1));
    }
    s_.a.mov(gp(next, 4), e.table);
    s_.a.bt(gp(next, 4), gp(to, 4));
    s_.a.setc(gp(to, 1));
  }

  Assembly& s_;
  const std::uint32_t* inputs_;
};

/// One record: bit (i0 + 2 i1 + ..) of the truth table of `count` operands.
void record(Assembly& s, std::uint32_t truth, std::uint32_t out, const std::uint32_t* in, unsigned count,
            BooleanExpressions& expressions) {
  // Inputs that are the same variable become one.
  std::array<std::uint32_t, 5> operands{};
  std::array<unsigned, 5> index{};
  unsigned distinct = 0;
  for (unsigned i = 0; i < count; ++i) {
    const auto end = operands.begin() + distinct;
    const auto known = std::find(operands.begin(), end, in[i]);
    index[i] = static_cast<unsigned>(known - operands.begin());
    if (known == end) operands[distinct++] = in[i];
  }
  std::uint32_t joined = 0;
  for (std::uint32_t row = 0; row < 1u << distinct; ++row) {
    std::uint32_t whole = 0;
    for (unsigned i = 0; i < count; ++i) whole |= (row >> index[i] & 1u) << i;
    joined |= (truth >> whole & 1u) << row;
  }
  const BooleanExpression& e = expressions.of(joined, distinct);
  Evaluation evaluation(s, operands.data());
  s.store(out, 1, evaluation.value(e, 0));
}

}  // namespace

void translate_records(Assembly& s, const Instruction& i, const std::uint32_t* code, BooleanExpressions& expressions) {
  if (i.operation.form == Form::kGeneralRecords) {
    const std::uint32_t* words = i.words + 2;
    for (std::uint32_t n = 0; n < i.words[1]; ++n, words += runtime::kGeneralRecordWords) {
      record(s, words[0], words[1], words + 2, 5, expressions);
    }
    return;
  }
  const unsigned inputs = i.operation.form == Form::kShortRecords4 ? 4 : 5;
  const std::uint32_t window = i.words[2];
  const std::uint32_t* words = code + i.words[3];
  for (std::uint32_t n = 0; n < i.words[1]; ++n, words += runtime::kShortRecordWords) {
    const auto r = runtime::load_field<runtime::ShortRecord>(reinterpret_cast<const unsigned char*>(words));
    std::array<std::uint32_t, 5> in{};
    for (std::size_t k = 0; k < in.size(); ++k) in[k] = window + r.in[k];
    record(s, r.truth, window + r.out, in.data(), inputs, expressions);
  }
}

}  // namespace plc::native
