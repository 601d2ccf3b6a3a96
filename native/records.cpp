#include "native/records.h"

#include <algorithm>
#include <unordered_map>
#include <unordered_set>

#include "runtime/interpreter/bool_run.h"

namespace plc::native {
namespace {

/// How many records are looked ahead for the next reader of an output.
constexpr std::size_t kLookAhead = 1024;

/// A record of bit (i0 + 2 i1 + ..) of `truth`.
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

/// Fills in the next readers and writers, as far as they are among these.
void find_next_users(std::span<Record> records) {
  std::unordered_set<std::uint32_t> written;
  std::unordered_map<std::uint32_t, std::uint32_t> readers;
  const auto reader_of = [&readers](std::uint32_t operand) {
    const auto known = readers.find(operand);
    return known == readers.end() ? kNever : known->second;
  };
  for (std::size_t r = records.size(); r-- > 0;) {
    Record& record = records[r];
    record.next_of_out = reader_of(record.out);
    record.is_overwritten = !written.insert(record.out).second;
    readers.erase(record.out);
    for (unsigned i = 0; i < record.inputs; ++i) record.next[i] = reader_of(record.in[i]);
    for (unsigned i = 0; i < record.inputs; ++i) readers[record.in[i]] = static_cast<std::uint32_t>(r);
  }
}

}  // namespace

Record record_at(const Instruction& run, const std::uint32_t* code, std::uint32_t n) {
  if (run.operation.form == Form::kGeneralRecords) {
    const std::uint32_t* const words = run.words + 2 + std::size_t{n} * runtime::kGeneralRecordWords;
    return record_of(words[0], words[1], words + 2, 5);
  }
  const std::uint32_t window = run.words[2];
  const std::uint32_t* const words = code + run.words[3] + std::size_t{n} * runtime::kShortRecordWords;
  const auto r = runtime::load_field<runtime::ShortRecord>(reinterpret_cast<const unsigned char*>(words));
  std::array<std::uint32_t, 5> in{};
  for (std::size_t k = 0; k < in.size(); ++k) in[k] = window + r.in[k];
  return record_of(r.truth, window + r.out, in.data(), run.operation.form == Form::kShortRecords4 ? 4 : 5);
}

void visit_records(const Instruction& run, const std::uint32_t* code,
                   const std::function<void(std::span<Record>)>& visit) {
  std::vector<Record> records;
  for (std::uint32_t n = 0; n < run.words[1];) {
    records.clear();
    for (; n < run.words[1] && records.size() < kLookAhead; ++n) records.push_back(record_at(run, code, n));
    find_next_users(records);
    visit(records);
  }
}

void forget_late_readers(std::span<Record> records, std::size_t registers) {
  struct Held {
    std::uint32_t operand;
    std::uint32_t until;
    std::uint32_t* next;  ///< where that is; null when it must
  };
  std::vector<Held> held;
  std::unordered_set<std::uint32_t> in_register_alone;
  for (std::uint32_t r = 0; r < records.size(); ++r) {
    Record& record = records[r];
    std::erase_if(held, [r](const Held& h) { return h.until == r; });
    for (unsigned i = 0; i < record.inputs; ++i) {
      const bool alone = in_register_alone.contains(record.in[i]);
      if (record.next[i] != kNever) held.push_back({record.in[i], record.next[i], alone ? nullptr : &record.next[i]});
    }
    if (record.next_of_out != kNever) held.push_back({record.out, record.next_of_out, nullptr});
    if (record.is_overwritten) {
      in_register_alone.insert(record.out);
    } else {
      in_register_alone.erase(record.out);
    }
    while (held.size() > registers) {
      const auto latest =
          std::max_element(held.begin(), held.end(), [](const Held& a, const Held& b) { return a.until < b.until; });
      if (latest->next != nullptr) *latest->next = kNever;
      held.erase(latest);
    }
  }
}

std::uint32_t first_reader(std::span<const Record> records, std::uint32_t operand) {
  const auto reads = [operand](const Record& r) {
    return std::find(r.in.begin(), r.in.begin() + r.inputs, operand) != r.in.begin() + r.inputs;
  };
  const auto reader = std::find_if(records.begin(), records.end(), reads);
  return reader == records.end() ? kNever : static_cast<std::uint32_t>(reader - records.begin());
}

std::uint32_t RecordRegisters::take() {
  std::size_t best = 0;
  std::uint64_t latest = 0;
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    const Slot& slot = slots_[i];
    if (slot.taken || slot.pinned) continue;
    const std::uint64_t next = slot.next + std::uint64_t{1};  // kNever is the latest of all
    if (next <= latest) continue;
    latest = next;
    best = i;
  }
  // Without a reader that is still to come, it will not be looked for.
  if (!slots_[best].is_stored && slots_[best].next != kNever) store_(numbers_[best], slots_[best].operand);
  slots_[best] = {true, kNever, 0};
  return numbers_[best];
}

bool RecordRegisters::keep(std::uint32_t number) {
  if (std::find(numbers_.begin(), numbers_.end(), number) == numbers_.end()) return false;
  slot(number) = {true, kNever, 0};
  return true;
}

void RecordRegisters::hold(std::uint32_t number, std::uint32_t operand, std::uint32_t next) {
  forget(operand);
  if (std::find(numbers_.begin(), numbers_.end(), number) != numbers_.end()) slot(number) = {false, next, operand};
}

bool RecordRegisters::hold_out(std::uint32_t number, const Record& record) {
  hold(number, record.out, record.next_of_out);
  slot(number).is_stored = !record.is_overwritten;
  return !record.is_overwritten;
}

const std::uint32_t* RecordRegisters::holder(std::uint32_t operand) const {
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    if (slots_[i].next != kNever && slots_[i].operand == operand) return &numbers_[i];
  }
  return nullptr;
}

bool RecordRegisters::worth_holding(std::uint32_t next) const {
  return next != kNever && std::any_of(slots_.begin(), slots_.end(), [next](const Slot& slot) {
           return !slot.taken && !slot.pinned && slot.next > next;
         });
}

void RecordRegisters::read(std::uint32_t operand, std::uint32_t next) {
  if (const std::uint32_t* const number = holder(operand)) slot(*number).next = next;
}

RecordRegisters::Slot& RecordRegisters::slot(std::uint32_t number) {
  return slots_[static_cast<std::size_t>(std::find(numbers_.begin(), numbers_.end(), number) - numbers_.begin())];
}

void RecordRegisters::forget(std::uint32_t operand) {
  if (const std::uint32_t* const number = holder(operand)) slot(*number) = {};
}

}  // namespace plc::native
