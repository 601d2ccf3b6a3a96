// ChangedPlan: which parts of a task are groups, that are left out of scans in which none of their inputs changed.
//
// In: resolved code. Out: stretches of chunks of groups for the compiler, and the tables of a ChangeTracker but for
// addresses of code. A group is one look-up record or a few other instructions whose footprint is known and pure
// (footprint.h), in a body that runs once a scan. Everything else runs in every scan, and is said to write what it may
// write. Compile time. Does not belong here: code, what happens in a scan (change_tracker.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "native/change_tracker.h"
#include "native/footprint.h"
#include "runtime/link.h"
#include "runtime/memory/table.h"

namespace plc::native {

class ChangedPlan {
 public:
  /// Some or all records of one boolean run (records != 0), or one other instruction.
  struct Piece {
    std::size_t instruction = 0;  ///< into LinkedCode::instructions, as all such numbers here
    std::uint32_t first_record = 0;
    std::uint32_t records = 0;
  };
  struct Stretch {
    std::size_t begin = 0, end = 0;          ///< instructions
    std::uint32_t number = 0;                ///< into ChangeTables::stretches
    std::vector<std::vector<Piece>> chunks;  ///< their straight code
  };
  /// A group that is code: the instructions [begin, end).
  struct CodeGroup {
    std::size_t begin = 0, end = 0;
    bool counts_events = false;  ///< there is an ENO in it
    std::vector<Range> writes;
  };
  /// What an instruction outside of groups may do to them.
  struct Outside {
    enum class Effect : std::uint8_t {
      kNone,
      kList,      ///< it writes the parts of ChangeTables::outside[list], and goes on behind itself
      kAnywhere,  ///< what it writes is not known, or not worth knowing
    } effect = Effect::kNone;
    std::uint32_t list = 0;
  };

  ChangedPlan(const runtime::LinkedCode& linked, const runtime::TaskLayout& layout);

  /// The stretch that begins with this instruction, or null.
  [[nodiscard]] const Stretch* stretch_at(std::size_t instruction) const;
  [[nodiscard]] Outside outside(std::size_t instruction) const;
  /// Parallel to ChangeTables::codes, in the order of the code.
  [[nodiscard]] const std::vector<CodeGroup>& code_groups() const { return code_groups_; }
  /// Once.
  ChangeTables take_tables() { return std::move(tables_); }

 private:
  struct Interval {
    std::size_t begin = 0, end = 0;
  };
  struct Body;
  struct Access {
    Range range;
    std::uint32_t group = 0;
  };
  static constexpr std::size_t kNone = ~std::size_t{0};

  [[nodiscard]] std::size_t index_at(std::uint32_t position) const;
  Body body_of(std::size_t number);
  void find_bodies_once_a_scan();
  void find_groups_with_jumps(Body& body) const;
  [[nodiscard]] std::size_t weight(const Body& body, const Interval& at) const;
  void plan_body(std::size_t number);

  std::uint32_t new_group(std::size_t instruction);
  void close(std::size_t instruction);
  void add_records(std::size_t instruction);
  void add_code(const Body& body, const Interval& at, bool straight);
  void add_outside(const Body& body, std::size_t i);
  void add(std::vector<Access>& accesses, std::uint32_t group, const Range& range) const;
  void add_inputs(std::uint32_t group, const runtime::GeneralRecord& record);

  void make_cells();
  [[nodiscard]] bool is_code(std::uint32_t group) const;
  void place_marks(std::uint32_t number);
  void make_areas();
  [[nodiscard]] std::uint32_t cell_at(std::uint32_t offset) const;
  template <class Visit>
  void for_each_cell(const Range& range, Visit&& visit) const;
  ChangeTables::List spans_in(const std::vector<Range>& ranges);

  const runtime::LinkedCode& linked_;
  std::uint64_t table_bytes_;
  Range constants_;
  Footprints footprints_;
  std::unordered_map<std::uint32_t, std::size_t> body_at_;  ///< by entry
  std::vector<bool> once_;                                  ///< bodies that run at most once a scan
  ChangeTables tables_;
  std::vector<Stretch> stretches_;
  bool open_ = false;                                        ///< the last stretch may grow
  std::unordered_map<std::size_t, std::size_t> stretch_at_;  ///< by instruction
  std::vector<CodeGroup> code_groups_;
  std::unordered_map<std::size_t, Outside> outside_;  ///< by instruction
  struct OutsideWrites {
    std::size_t instruction = 0;
    bool goes_on = false;  ///< behind itself, and once
    std::vector<Range> ranges;
  };
  std::vector<OutsideWrites> outside_writes_;
  std::vector<Access> reads_;
  std::vector<Access> writes_;
  std::vector<std::uint32_t> bounds_;  ///< of cells: number c lies between bounds c - 1 and c; 0 in front of all
};

}  // namespace plc::native
