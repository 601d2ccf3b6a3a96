// Look-up records of boolean runs, made ready for code on any processor: who reads what next, and what stays in
// registers for that reader.
//
// A chain of rungs would otherwise wait for memory at each link. In: BOOL_RUN instructions
// (runtime/interpreter/bool_run.h). Does not belong here: their functions (boolean_function.h), code.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "native/translate.h"

namespace plc::native {

/// No record.
inline constexpr std::uint32_t kNever = std::numeric_limits<std::uint32_t>::max();

struct Record {
  std::uint32_t truth = 0;
  std::uint32_t out = 0;
  std::array<std::uint32_t, 5> in{};  ///< distinct
  unsigned inputs = 0;
  std::array<std::uint32_t, 5> next{};  ///< which record reads the input next, if none writes it before
  std::uint32_t next_of_out = kNever;
  bool is_overwritten = false;  ///< the output, by a later record
};

/// Record `n` of a run; inputs that are the same variable have become one. `code`: all resolved code.
Record record_at(const Instruction& run, const std::uint32_t* code, std::uint32_t n);
/// All of them in order, as many at a time as are looked ahead: the next readers and writers are those among them.
void visit_records(const Instruction& run, const std::uint32_t* code,
                   const std::function<void(std::span<Record>)>& visit);
/// Forgets next readers of inputs that would have to give up their register, one of `registers`, before that reader
/// comes: those are better read from memory each time. Of values that may be in a register alone it forgets none.
void forget_late_readers(std::span<Record> records, std::size_t registers);
/// The first of the records that reads the operand, or kNever.
std::uint32_t first_reader(std::span<const Record> records, std::uint32_t operand);

/// The registers of a run: temporary values of a record, and outputs that wait for their next reader.
///
/// An output that a later record overwrites lives in its register alone: it is stored only when another value needs the
/// register before its last reader came.
class RecordRegisters {
 public:
  using Store = std::function<void(std::uint32_t number, std::uint32_t operand)>;
  /// `numbers`: those that may be used, by preference; they outlive this. `store` writes code that stores one.
  RecordRegisters(std::span<const std::uint32_t> numbers, Store store)
      : numbers_(numbers), slots_(numbers.size()), store_(std::move(store)) {}

  /// One for a temporary value: free, or that of the output that waits longest.
  std::uint32_t take();
  void give_back(std::uint32_t number) { slot(number) = {}; }
  /// One that holds a variable which is not read from it any more becomes one for a temporary value.
  void take_over(std::uint32_t number) { slot(number) = {true, kNever, 0}; }
  /// While it is pinned, what it holds stays where it is.
  void pin(std::uint32_t number, bool pinned) { slot(number).pinned = pinned; }
  /// The register stays taken to the end, whatever it held. False when it is none of these.
  bool keep(std::uint32_t number);
  /// A taken one, or one whose value was there before the run, holds a variable from now on. Others that are not among
  /// its numbers, as those that loops keep, are not noted.
  void hold(std::uint32_t number, std::uint32_t operand, std::uint32_t next);
  /// A taken one holds the output of a record. False when it is not stored, or not yet.
  bool hold_out(std::uint32_t number, const Record& record);
  /// The register that holds the operand, if any does.
  [[nodiscard]] const std::uint32_t* holder(std::uint32_t operand) const;
  /// Whether a value that is read next by that record is better held than what is.
  [[nodiscard]] bool worth_holding(std::uint32_t next) const;
  /// The operand was read, and will be next by that record.
  void read(std::uint32_t operand, std::uint32_t next);

 private:
  struct Slot {
    bool taken = false;
    std::uint32_t next = kNever;  ///< reader; kNever = nothing is held
    std::uint32_t operand = 0;
    bool is_stored = true;
    bool pinned = false;
  };
  Slot& slot(std::uint32_t number);
  void forget(std::uint32_t operand);

  std::span<const std::uint32_t> numbers_;
  std::vector<Slot> slots_;
  Store store_;
};

}  // namespace plc::native
