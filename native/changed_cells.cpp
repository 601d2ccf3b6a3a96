// ChangedPlan: cells, and who is told when one of them changes.
#include <algorithm>
#include <span>

#include "native/changed_plan.h"

namespace plc::native {

using runtime::GeneralRecord;

namespace {

/// Parts of the table that an instruction outside of groups may change and that are looked at one by one.
constexpr std::size_t kMostSpans = 32;
constexpr std::uint32_t kMarkOf = ChangeTables::kOutput * 2;

void sort_unique(std::vector<std::uint32_t>& numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

}  // namespace

void ChangedPlan::make_cells() {
  for (const auto* const accesses : {&reads_, &writes_}) {
    for (const Access& access : *accesses) {
      bounds_.push_back(access.range.begin);
      bounds_.push_back(access.range.begin + access.range.bytes);
    }
  }
  sort_unique(bounds_);
  tables_.cells.resize(bounds_.size());
  if (bounds_.empty()) return;
  std::vector<std::uint32_t> counts(bounds_.size() + 1);
  const auto each = [&](const std::vector<Access>& accesses, auto&& visit) {
    for (const Access& access : accesses)
      for_each_cell(access.range, [&](std::uint32_t cell) { visit(cell, access.group); });
  };
  // Places in marks: first how many, then from where on.
  const auto count = [&](std::uint32_t cell, std::uint32_t) { ++counts[cell]; };
  each(writes_, count);
  std::vector<std::uint32_t> writers(counts);
  each(reads_, count);
  std::uint32_t at = 0;
  for (std::size_t c = 0; c < tables_.cells.size(); ++c) {
    tables_.cells[c] = {at, at, at};
    at += counts[c];
  }
  tables_.marks.resize(at);
  const auto put = [&](std::uint32_t cell, std::uint32_t mark) {
    ChangeTables::Cell& to = tables_.cells[cell];
    if (to.end == to.others || tables_.marks[to.end - 1] != mark) tables_.marks[to.end++] = mark;
  };
  each(writes_, [&](std::uint32_t cell, std::uint32_t group) {
    put(cell, group * kMarkOf + (is_code(group) ? 0 : ChangeTables::kOutput));
  });
  for (std::size_t c = 0; c < tables_.cells.size(); ++c) {
    ChangeTables::Cell& cell = tables_.cells[c];
    writers[c] = cell.end - cell.begin;
    cell.others = cell.end;  // a group that reads what it writes is among the readers, too
  }
  each(reads_, [&](std::uint32_t cell, std::uint32_t group) {
    std::uint32_t inputs = 0;
    const GeneralRecord& record = tables_.records[group];
    for (std::uint32_t k = 0; k < std::size(record.in) && !is_code(group); ++k) {
      if (record.in[k] == bounds_[cell - 1]) inputs |= 1u << k;
    }
    put(cell, group * kMarkOf + inputs);
  });
  for (std::size_t c = 0; c < tables_.cells.size(); ++c) {
    if (writers[c] != 1) tables_.cells[c].others = tables_.cells[c].begin;
  }
  // Who writes beside groups.
  for (const OutsideWrites& who : outside_writes_) {
    const ChangeTables::List list = spans_in(who.ranges);
    if (list.count == 0) continue;
    for (std::uint32_t s = 0; s < list.count; ++s) ++writers[tables_.spans[list.first + s].cell];
    Outside outside{Outside::Effect::kAnywhere, 0};
    if (who.goes_on && list.count <= kMostSpans) {
      outside = {Outside::Effect::kList, static_cast<std::uint32_t>(tables_.outside.size())};
      tables_.outside.push_back(list);
    } else {
      tables_.spans.resize(list.first);
    }
    outside_.emplace(who.instruction, outside);
  }
  for (std::size_t c = 0; c < tables_.cells.size(); ++c) {
    const ChangeTables::Cell& cell = tables_.cells[c];
    for (std::uint32_t m = cell.begin; m < cell.end && writers[c] > 1; ++m) {
      if (is_code(tables_.marks[m] / kMarkOf)) tables_.contested.push_back(tables_.marks[m] / kMarkOf);
    }
  }
  sort_unique(tables_.contested);
  for (std::size_t i = 0; i < code_groups_.size(); ++i) tables_.codes[i].spans = spans_in(code_groups_[i].writes);
  tables_.groups.emplace_back();
  tables_.states.emplace_back();
  for (std::uint32_t number = 0; number + 1 < tables_.groups.size(); ++number) {
    const bool used = (tables_.used[number / kChunkGroups] >> number % kChunkGroups & 1u) != 0;
    if (used && !is_code(number)) place_marks(number);
  }
  make_areas();
}

bool ChangedPlan::is_code(std::uint32_t group) const { return tables_.groups[group].out == ChangeTables::kCode; }

/// Whom a record marks when its output changes.
void ChangedPlan::place_marks(std::uint32_t number) {
  ChangeTables::Group& group = tables_.groups[number];
  const ChangeTables::Cell cell = tables_.cells[cell_at(group.out)];
  const std::vector<std::uint32_t> all(tables_.marks.begin() + cell.others, tables_.marks.begin() + cell.end);
  std::vector<std::uint32_t> more;
  std::size_t near = 0;
  for (const std::uint32_t mark : all) {
    // Where several write, all of them are told, but for the one that wrote.
    if (mark == number * kMarkOf + ChangeTables::kOutput) continue;
    const bool input = mark % kMarkOf != 0 && mark % kMarkOf != ChangeTables::kOutput;
    if (input && near < std::size(group.near)) {
      group.near[near++] = mark;
    } else {
      more.push_back(mark);
    }
  }
  const auto nobody = static_cast<std::uint32_t>(tables_.groups.size() - 1) * kMarkOf;
  std::fill(group.near + near, std::end(group.near), nobody);
  if (more.empty()) return;
  group.more = static_cast<std::uint32_t>(tables_.marks.size());
  tables_.marks.push_back(static_cast<std::uint32_t>(more.size()));
  tables_.marks.insert(tables_.marks.end(), more.begin(), more.end());
}

std::uint32_t ChangedPlan::cell_at(std::uint32_t offset) const {
  const auto end = std::upper_bound(bounds_.begin(), bounds_.end(), offset);
  return end == bounds_.end() ? 0 : static_cast<std::uint32_t>(end - bounds_.begin());
}

template <class Visit>
void ChangedPlan::for_each_cell(const Range& range, Visit&& visit) const {
  const std::uint32_t end = range.begin + range.bytes;
  if (bounds_.empty() || range.begin >= bounds_.back() || end <= bounds_.front()) return;
  std::uint32_t cell = std::max(cell_at(range.begin), 1u);
  for (; cell < bounds_.size() && bounds_[cell - 1] < end; ++cell) visit(cell);
}

/// The parts of cells that groups use in these ranges.
ChangeTables::List ChangedPlan::spans_in(const std::vector<Range>& ranges) {
  ChangeTables::List list{static_cast<std::uint32_t>(tables_.spans.size()), 0};
  for (const Range& range : ranges) {
    for_each_cell(range, [&](std::uint32_t c) {
      const ChangeTables::Cell& cell = tables_.cells[c];
      if (cell.begin == cell.end) return;
      const std::uint32_t begin = std::max(range.begin, bounds_[c - 1]);
      const std::uint32_t end = std::min(range.begin + range.bytes, bounds_[c]);
      tables_.spans.push_back({begin, end - begin, c});
    });
  }
  list.count = static_cast<std::uint32_t>(tables_.spans.size()) - list.first;
  return list;
}

/// Lines that hold cells; where these are nothing but BOOLs for all of a block, it is kept as bits.
void ChangedPlan::make_areas() {
  enum Kind : std::uint8_t { kNobody, kBools, kBytes };
  const std::uint32_t end = bounds_.back() / TableCopy::kBlock + 1;
  std::vector<Kind> kinds(std::size_t{end} * TableCopy::kBlockLines);
  for (std::uint32_t c = 1; c < tables_.cells.size(); ++c) {
    const ChangeTables::Cell& cell = tables_.cells[c];
    if (cell.begin == cell.end) continue;
    // Records know what they read and write: BOOLs.
    const bool is_bool = std::any_of(tables_.marks.begin() + cell.begin, tables_.marks.begin() + cell.end,
                                     [](std::uint32_t mark) { return mark % kMarkOf != 0; });
    for (std::uint32_t line = bounds_[c - 1] / TableCopy::kLine; line * TableCopy::kLine < bounds_[c]; ++line) {
      kinds[line] = std::max(kinds[line], is_bool ? kBools : kBytes);
    }
  }
  for (std::uint32_t block = 0; block < end; ++block) {
    const auto lines = std::span(kinds).subspan(std::size_t{block} * TableCopy::kBlockLines, TableCopy::kBlockLines);
    const bool is_whole = std::uint64_t{block + 1} * TableCopy::kBlock <= table_bytes_;
    const bool bits = is_whole && *std::max_element(lines.begin(), lines.end()) == kBools;
    for (Kind& line : lines) {
      if (bits || line != kNobody) line = bits ? kBools : kBytes;
    }
  }
  for (std::uint32_t line = 0; line < kinds.size(); ++line) {
    if (kinds[line] == kNobody) continue;
    if (line == 0 || kinds[line] != kinds[line - 1]) {
      const auto cells = static_cast<std::uint32_t>(tables_.cell_of_byte.size());
      tables_.areas.push_back({line * TableCopy::kLine, 0, cells, kinds[line] == kBools});
    }
    ++tables_.areas.back().lines;
    for (std::uint32_t byte = line * TableCopy::kLine; byte < (line + 1) * TableCopy::kLine; ++byte) {
      const std::uint32_t cell = cell_at(byte);
      const bool is_used = cell != 0 && tables_.cells[cell].begin != tables_.cells[cell].end;
      tables_.cell_of_byte.push_back(is_used ? cell : 0);
    }
  }
}

}  // namespace plc::native
