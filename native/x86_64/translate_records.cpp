// Boolean runs: each look-up record as straight code on bytes, without branches.
//
// Every record stores its output, so that nothing differs for whoever looks at the table. Outputs that are read again
// soon stay in registers as well: a chain of rungs would otherwise wait for memory at each link.
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <unordered_map>
#include <vector>

#include "native/translate.h"
#include "runtime/bool_run.h"

namespace plc::native {
namespace {

using Kind = BooleanExpression::Kind;

constexpr std::uint32_t kNever = std::numeric_limits<std::uint32_t>::max();
/// How many records are looked ahead for the next reader of an output.
constexpr std::size_t kLookAhead = 1024;

struct Record {
  std::uint32_t truth = 0;
  std::uint32_t out = 0;
  std::array<std::uint32_t, 5> in{};  ///< distinct
  unsigned inputs = 0;
  std::array<std::uint32_t, 5> next{};  ///< which record reads the input next, if none writes it before
  std::uint32_t next_of_out = kNever;
};

/// A record of bit (i0 + 2 i1 + ..) of `truth`: inputs that are the same variable become one.
Record record_of(std::uint32_t truth, std::uint32_t out, const std::uint32_t* in, unsigned count) {
  Record record;
  record.out = out;
  std::array<unsigned, 5> index{};
  for (unsigned i = 0; i < count; ++i) {
    const auto end = record.in.begin() + record.inputs;
    const auto known = std::find(record.in.begin(), end, in[i]);
    index[i] = static_cast<unsigned>(known - record.in.begin());
    if (known == end) record.in[record.inputs++] = in[i];
  }
  for (std::uint32_t row = 0; row < 1u << record.inputs; ++row) {
    std::uint32_t whole = 0;
    for (unsigned i = 0; i < count; ++i) whole |= (row >> index[i] & 1u) << i;
    record.truth |= (truth >> whole & 1u) << row;
  }
  return record;
}

void find_next_readers(std::span<Record> records) {
  std::unordered_map<std::uint32_t, std::uint32_t> readers;
  const auto reader_of = [&readers](std::uint32_t operand) {
    const auto known = readers.find(operand);
    return known == readers.end() ? kNever : known->second;
  };
  for (std::size_t r = records.size(); r-- > 0;) {
    Record& record = records[r];
    record.next_of_out = reader_of(record.out);
    readers.erase(record.out);
    for (unsigned i = 0; i < record.inputs; ++i) record.next[i] = reader_of(record.in[i]);
    for (unsigned i = 0; i < record.inputs; ++i) readers[record.in[i]] = static_cast<std::uint32_t>(r);
  }
}

/// The registers of a run: temporary values of a record, and outputs that wait for their next reader.
class Registers {
 public:
  /// Upper bits of what is in them are not known.
  static constexpr std::array<std::uint32_t, 9> kNumbers = {0, 1, 2, 6, 7, 8, 9, 10, 11};

  /// One for a temporary value: free, or that of the output that waits longest.
  std::uint32_t take() {
    std::size_t best = 0;
    std::uint64_t latest = 0;
    for (std::size_t i = 0; i < slots_.size(); ++i) {
      const Slot& slot = slots_[i];
      if (slot.taken) continue;
      const std::uint64_t next = slot.next + std::uint64_t{1};  // kNever is the latest of all
      if (next <= latest) continue;
      latest = next;
      best = i;
    }
    slots_[best] = {true, kNever, 0};
    return kNumbers[best];
  }
  void give_back(std::uint32_t number) { slot(number) = {}; }
  /// A taken one holds the output from now on.
  void hold(std::uint32_t number, std::uint32_t operand, std::uint32_t next) {
    forget(operand);
    slot(number) = {false, next, operand};
  }
  /// The register that holds the operand, if any does.
  [[nodiscard]] const std::uint32_t* holder(std::uint32_t operand) const {
    for (std::size_t i = 0; i < slots_.size(); ++i) {
      if (slots_[i].next != kNever && slots_[i].operand == operand) return &kNumbers[i];
    }
    return nullptr;
  }
  /// Whether a value that is read next by that record is better held than what is.
  [[nodiscard]] bool worth_holding(std::uint32_t next) const {
    return next != kNever && std::any_of(slots_.begin(), slots_.end(),
                                         [next](const Slot& slot) { return !slot.taken && slot.next > next; });
  }
  /// The operand was read, and will be next by that record.
  void read(std::uint32_t operand, std::uint32_t next) {
    if (const std::uint32_t* const number = holder(operand)) slot(*number).next = next;
  }

 private:
  struct Slot {
    bool taken = false;
    std::uint32_t next = kNever;  ///< reader; kNever = nothing is held
    std::uint32_t operand = 0;
  };
  Slot& slot(std::uint32_t number) {
    return slots_[static_cast<std::size_t>(std::find(kNumbers.begin(), kNumbers.end(), number) - kNumbers.begin())];
  }
  void forget(std::uint32_t operand) {
    if (const std::uint32_t* const number = holder(operand)) slot(*number) = {};
  }

  std::array<Slot, kNumbers.size()> slots_{};
};

/// The expression of one record.
class Evaluation {
 public:
  Evaluation(Assembly& s, Registers& registers, const Record& record) : s_(s), registers_(registers), record_(record) {}

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
  Registers& registers_;
  const Record& record_;
};

void translate(Assembly& s, std::vector<Record>& records, BooleanExpressions& expressions) {
  if (records.empty()) return;
  find_next_readers(records);
  Registers registers;
  if (const auto known = s.held_bit()) {
    const auto reads = [operand = known->operand](const Record& r) {
      return std::find(r.in.begin(), r.in.begin() + r.inputs, operand) != r.in.begin() + r.inputs;
    };
    const auto reader = std::find_if(records.begin(), records.end(), reads);
    registers.hold(known->number, known->operand,
                   reader == records.end() ? kNever : static_cast<std::uint32_t>(reader - records.begin()));
  }
  for (const Record& r : records) {
    const std::uint32_t value = Evaluation(s, registers, r).value(expressions.of(r.truth, r.inputs));
    s.store(r.out, 1, value);
    for (unsigned i = 0; i < r.inputs; ++i) registers.read(r.in[i], r.next[i]);
    registers.hold(value, r.out, r.next_of_out);
  }
  records.clear();
}

}  // namespace

void translate_records(Assembly& s, const Instruction& i, const std::uint32_t* code, BooleanExpressions& expressions) {
  std::vector<Record> records;
  const auto add = [&](const Record& record) {
    records.push_back(record);
    if (records.size() == kLookAhead) translate(s, records, expressions);
  };
  if (i.operation.form == Form::kGeneralRecords) {
    const std::uint32_t* words = i.words + 2;
    for (std::uint32_t n = 0; n < i.words[1]; ++n, words += runtime::kGeneralRecordWords) {
      add(record_of(words[0], words[1], words + 2, 5));
    }
  } else {
    const unsigned inputs = i.operation.form == Form::kShortRecords4 ? 4 : 5;
    const std::uint32_t window = i.words[2];
    const std::uint32_t* words = code + i.words[3];
    for (std::uint32_t n = 0; n < i.words[1]; ++n, words += runtime::kShortRecordWords) {
      const auto r = runtime::load_field<runtime::ShortRecord>(reinterpret_cast<const unsigned char*>(words));
      std::array<std::uint32_t, 5> in{};
      for (std::size_t k = 0; k < in.size(); ++k) in[k] = window + r.in[k];
      add(record_of(r.truth, window + r.out, in.data(), inputs));
    }
  }
  translate(s, records, expressions);
}

}  // namespace plc::native
