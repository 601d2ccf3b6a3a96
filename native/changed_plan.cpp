#include "native/changed_plan.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "stdlib/blocks/timers.h"

namespace plc::native {

using runtime::Addressing;
using runtime::GeneralRecord;
using runtime::LinkedCode;
using runtime::LinkedInstruction;

namespace {

/// Instructions and records that jumps lead past at most inside of one group.
constexpr std::size_t kLongestSpan = 64;
/// Instructions of a group without jumps: what is drawn together mostly depends on each other.
constexpr std::size_t kLongestCode = 8;
/// Steps: an instruction, as code; calling a group of code and seeing what it changed.
constexpr std::uint32_t kInstructionEffort = 2;
constexpr std::uint32_t kCodeEffort = 12;

bool is_run(const LinkedInstruction& instruction) { return is_boolean_run(operation_of(instruction.op).form); }
bool is(const LinkedInstruction& instruction, Form form) { return operation_of(instruction.op).form == form; }

/// Entry of the body that a kCallFixed calls.
std::uint32_t callee(const LinkedCode& linked, const LinkedInstruction& call) {
  return linked.data()[call.position + 1];
}

bool overlap(const Range& x, const Range& y) { return x.begin < y.begin + y.bytes && y.begin < x.begin + x.bytes; }
bool inside(const Range& part, const Range& whole) {
  return part.begin >= whole.begin && part.begin + part.bytes <= whole.begin + whole.bytes;
}

/// A timer of a group: its ports, and how much the group has written when it ran.
struct OwnTimer {
  Range ports;
  std::size_t writes = 0;
};
/// Whether others of its group than the timer itself may start it anew: who writes what it remembers, or anything
/// behind it. Then time counts whatever STATE says.
bool is_disturbed(const OwnTimer& timer, const std::vector<Range>& writes) {
  using stdlib::fb::TimerPorts;
  const auto port = [&timer](std::size_t offset, std::size_t bytes) {
    return Range{timer.ports.begin + static_cast<std::uint32_t>(offset), static_cast<std::uint32_t>(bytes)};
  };
  const Range in = port(offsetof(TimerPorts, in), sizeof(TimerPorts::in));
  const Range pt = port(offsetof(TimerPorts, pt), sizeof(TimerPorts::pt));
  for (std::size_t w = 0; w < writes.size(); ++w) {
    const bool its_own = w + 1 == timer.writes;
    const bool is_input = w < timer.writes && (inside(writes[w], in) || inside(writes[w], pt));
    if (!its_own && !is_input && overlap(writes[w], timer.ports)) return true;
  }
  return false;
}

}  // namespace

// ---- bodies

/// What plan_body() works on: a body and what is known of its instructions, by their distance from its first one.
struct ChangedPlan::Body {
  std::size_t begin = 0, end = 0;
  std::vector<Footprint> footprints;
  std::vector<bool> in_loop;
  std::vector<bool> lands;       ///< a jump that is in no group goes there
  std::vector<Interval> groups;  ///< that jump inside of themselves, ascending
  [[nodiscard]] std::size_t size() const { return end - begin; }
};

ChangedPlan::ChangedPlan(const LinkedCode& linked, const runtime::TaskLayout& layout)
    : linked_(linked),
      table_bytes_(layout.total),
      constants_{layout.constants, layout.instance - layout.constants},
      footprints_(linked),
      once_(linked.bodies.size()) {
  tables_.constants = layout.constants;
  tables_.constants_end = layout.instance;
  for (std::size_t b = 0; b < linked.bodies.size(); ++b) body_at_.emplace(linked.bodies[b].entry, b);
  find_bodies_once_a_scan();
  for (std::size_t b = 0; b < linked.bodies.size(); ++b) {
    if (once_[b]) plan_body(b);
  }
  make_cells();
}

std::size_t ChangedPlan::index_at(std::uint32_t position) const {
  const auto found = std::lower_bound(linked_.instructions.begin(), linked_.instructions.end(), position,
                                      [](const LinkedInstruction& i, std::uint32_t p) { return i.position < p; });
  return static_cast<std::size_t>(found - linked_.instructions.begin());
}

ChangedPlan::Body ChangedPlan::body_of(std::size_t number) {
  Body body;
  body.begin = linked_.bodies[number].first;
  body.end = body.begin + linked_.instructions_of(number).size();
  body.in_loop.resize(body.size());
  body.lands.resize(body.size() + 1);
  for (std::size_t i = body.begin; i < body.end; ++i) {
    const LinkedInstruction& instruction = linked_.instructions[i];
    body.footprints.push_back(is_run(instruction) ? Footprint{} : footprints_.of(instruction));
    if (is_run(instruction)) body.footprints.back().pure = true;
    if (is(instruction, Form::kLoopJump)) {
      const std::size_t first = index_at(*body.footprints.back().target) - body.begin;
      std::fill(body.in_loop.begin() + static_cast<std::ptrdiff_t>(first),
                body.in_loop.begin() + static_cast<std::ptrdiff_t>(i - body.begin + 1), true);
    }
  }
  return body;
}

void ChangedPlan::find_bodies_once_a_scan() {
  std::unordered_map<std::uint32_t, std::size_t> calls;  // by entry
  for (const LinkedInstruction& instruction : linked_.instructions) {
    if (is(instruction, Form::kCallFixed)) ++calls[callee(linked_, instruction)];
  }
  std::vector<std::size_t> open = {body_at_.at(linked_.entry)};
  while (!open.empty()) {
    const std::size_t b = open.back();
    open.pop_back();
    once_[b] = true;
    const Body body = body_of(b);
    for (std::size_t i = 0; i < body.size(); ++i) {
      const LinkedInstruction& instruction = linked_.instructions[body.begin + i];
      if (!is(instruction, Form::kCallFixed) || body.in_loop[i]) continue;
      const std::uint32_t entry = callee(linked_, instruction);
      if (calls.at(entry) == 1) open.push_back(body_at_.at(entry));
    }
  }
}

/// Finds the instructions that jump forward past a few others, or count their events, and are groups together with
/// these; and where all other jumps go.
void ChangedPlan::find_groups_with_jumps(Body& body) const {
  struct Span {
    Interval at;
    bool alive = true;
  };
  std::vector<Span> spans;
  std::vector<std::size_t> span_of(body.size(), kNone);  // by the instruction that makes it: jump or ENO
  const auto target = [&](std::size_t i) { return index_at(*body.footprints[i].target) - body.begin; };
  struct Eno {
    std::size_t at = 0;
    Interval clears;  ///< CLEAR_EVENTs from which it may count lie here
  };
  std::vector<Eno> enos;
  std::vector<bool> clears_for_outside(body.size());
  std::size_t clear = kNone;
  for (std::size_t i = 0; i < body.size(); ++i) {
    const LinkedInstruction& instruction = linked_.instructions[body.begin + i];
    if (is(instruction, Form::kClearEvent)) clear = i;
    Interval at;
    if (is(instruction, Form::kEno) && clear != kNone) {
      at = {clear, i + 1};
      enos.push_back({i, {clear, clear + 1}});
      // Whoever jumps in between counts from an earlier CLEAR_EVENT on.
      for (std::size_t k = 0; k < clear; ++k) {
        const bool between = span_of[k] != kNone && spans[span_of[k]].at.end > clear && spans[span_of[k]].at.end <= i;
        if (between) at = {}, enos.back().clears.begin = 0;
      }
    } else if (body.footprints[i].target && !is(instruction, Form::kLoopJump)) {
      at = {i, target(i)};
    }
    if (at.end == at.begin) continue;
    span_of[i] = spans.size();
    spans.push_back({at, weight(body, at) <= kLongestSpan});
  }
  const auto may_be_inside = [&](std::size_t i) {
    if (body.in_loop[i]) return false;
    if (span_of[i] != kNone) return spans[span_of[i]].alive;
    if (clears_for_outside[i]) return false;
    return body.footprints[i].pure && !body.footprints[i].target;
  };
  for (bool changed = true; changed;) {
    changed = false;
    // What an ENO outside of groups counts from is outside, too.
    for (const Eno& eno : enos) {
      if (may_be_inside(eno.at)) continue;
      std::fill(clears_for_outside.begin() + static_cast<std::ptrdiff_t>(eno.clears.begin),
                clears_for_outside.begin() + static_cast<std::ptrdiff_t>(eno.clears.end), true);
    }
    const auto give_up = [&](Span& span) {
      changed = changed || span.alive;
      span.alive = false;
    };
    for (Span& span : spans) {
      for (std::size_t i = span.at.begin; i < span.at.end && span.alive; ++i) {
        if (!may_be_inside(i)) give_up(span);
      }
    }
    // Those that overlap become one group, unless others jump into it.
    std::vector<std::size_t> order;
    for (std::size_t s = 0; s < spans.size(); ++s) {
      if (spans[s].alive) order.push_back(s);
    }
    std::sort(order.begin(), order.end(),
              [&](std::size_t x, std::size_t y) { return spans[x].at.begin < spans[y].at.begin; });
    body.groups.clear();
    for (const std::size_t s : order) {
      const Interval at = spans[s].at;
      if (!body.groups.empty() && at.begin < body.groups.back().end) {
        body.groups.back().end = std::max(body.groups.back().end, at.end);
      } else {
        body.groups.push_back(at);
      }
    }
    std::fill(body.lands.begin(), body.lands.end(), false);
    for (std::size_t i = 0; i < body.size(); ++i) {
      if (body.footprints[i].target && (span_of[i] == kNone || !spans[span_of[i]].alive)) body.lands[target(i)] = true;
    }
    for (const Interval& group : body.groups) {
      bool fine = weight(body, group) <= 4 * kLongestSpan;
      for (std::size_t i = group.begin + 1; i < group.end; ++i) fine = fine && !body.lands[i];
      for (Span& span : spans) {
        if (!fine && span.at.begin >= group.begin && span.at.begin < group.end) give_up(span);
      }
    }
  }
}

std::size_t ChangedPlan::weight(const Body& body, const Interval& at) const {
  std::size_t sum = 0;
  for (std::size_t i = at.begin; i < at.end && sum <= 8 * kLongestSpan; ++i) {
    const LinkedInstruction& instruction = linked_.instructions[body.begin + i];
    sum += is_run(instruction) ? linked_.data()[instruction.position + 1] : 1;
  }
  return sum;
}

void ChangedPlan::plan_body(std::size_t number) {
  Body body = body_of(number);
  find_groups_with_jumps(body);
  const auto plain = [&](std::size_t i) {
    return !body.in_loop[i] && body.footprints[i].pure && !body.footprints[i].target &&
           !is(linked_.instructions[body.begin + i], Form::kClearEvent);
  };
  auto group = body.groups.begin();
  for (std::size_t i = 0; i < body.size();) {
    if (body.lands[i]) close(body.begin + i);
    if (group != body.groups.end() && group->begin == i) {
      add_code(body, *group, false);
      i = group->end;
      ++group;
    } else if (!plain(i)) {
      close(body.begin + i);
      add_outside(body, i);
      ++i;
    } else if (is_run(linked_.instructions[body.begin + i])) {
      add_records(body.begin + i);
      ++i;
    } else {
      std::size_t end = i + 1;
      while (end < body.size() && end - i < kLongestCode && plain(end) && !body.lands[end] &&
             !is_run(linked_.instructions[body.begin + end]) && (group == body.groups.end() || group->begin != end)) {
        ++end;
      }
      add_code(body, {i, end}, true);
      i = end;
    }
  }
  close(body.end);
}

// ---- groups

/// A new group whose first instruction this is. Its number.
std::uint32_t ChangedPlan::new_group(std::size_t instruction) {
  if (!open_) {
    stretch_at_.emplace(instruction, stretches_.size());
    stretches_.push_back({instruction, instruction, static_cast<std::uint32_t>(stretches_.size()), {}});
    tables_.stretches.push_back({static_cast<std::uint32_t>(tables_.used.size()),
                                 0,
                                 {static_cast<std::uint32_t>(tables_.codes.size()), 0},
                                 nullptr});
    open_ = true;
  }
  if (tables_.stretches.back().chunks == 0 || tables_.used.back() == ~std::uint64_t{0}) {
    stretches_.back().chunks.emplace_back();
    ++tables_.stretches.back().chunks;
    tables_.used.push_back(0);
    tables_.groups.resize(tables_.used.size() * kChunkGroups);
    tables_.states.resize(tables_.groups.size());
    tables_.records.resize(tables_.groups.size());
  }
  ++tables_.count;
  const std::uint64_t bit = tables_.used.back() + 1;
  tables_.used.back() |= bit;
  const auto in_chunk = static_cast<std::uint32_t>(__builtin_ctzll(bit));
  return static_cast<std::uint32_t>(tables_.used.size() - 1) * kChunkGroups + in_chunk;
}

void ChangedPlan::close(std::size_t instruction) {
  if (open_) stretches_.back().end = instruction;
  open_ = false;
}

void ChangedPlan::add_records(std::size_t instruction) {
  std::uint32_t n = 0;
  for (const GeneralRecord& record : footprints_.records_of(linked_.instructions[instruction])) {
    const std::uint32_t group = new_group(instruction);
    std::vector<Piece>& pieces = stretches_.back().chunks.back();
    if (pieces.empty() || pieces.back().instruction != instruction) pieces.push_back({instruction, n, 0});
    ++pieces.back().records;
    ++n;
    tables_.states[group].truth = record.truth;
    tables_.groups[group].out = record.out;
    tables_.records[group] = record;
    add_inputs(group, record);
    add(writes_, group, Range{record.out, 1});
    ++tables_.effort;
  }
}

/// `straight`: without jumps, so that what it wrote itself is no input of it.
void ChangedPlan::add_code(const Body& body, const Interval& at, bool straight) {
  const std::uint32_t number = new_group(body.begin + at.begin);
  std::vector<Piece>& pieces = stretches_.back().chunks.back();
  tables_.groups[number].out = ChangeTables::kCode;
  tables_.groups[number].more = static_cast<std::uint32_t>(code_groups_.size());
  CodeGroup group{body.begin + at.begin, body.begin + at.end, false, {}};
  ChangeTables::Code code;
  code.group = number;
  code.timers.first = static_cast<std::uint32_t>(tables_.timers.size());
  std::vector<Range> own;
  std::vector<OwnTimer> timers;
  for (std::size_t i = at.begin; i < at.end; ++i) {
    const LinkedInstruction& instruction = linked_.instructions[body.begin + i];
    pieces.push_back({body.begin + i, 0, 0});
    tables_.effort += kInstructionEffort;
    code.effort += kInstructionEffort;
    if (is_run(instruction)) {
      for (const GeneralRecord& record : footprints_.records_of(instruction)) {
        add_inputs(number, record);
        add(writes_, number, Range{record.out, 1});
        group.writes.push_back({record.out, 1});
        ++tables_.effort;
        ++code.effort;
      }
      continue;
    }
    const Footprint& f = body.footprints[i];
    for (const Range& range : f.reads) {
      const bool known = std::any_of(own.begin(), own.end(), [&](const Range& w) { return inside(range, w); });
      if (!known) add(reads_, number, range);
    }
    for (const Range& range : f.writes) {
      add(writes_, number, range);
      group.writes.push_back(range);
      if (straight && f.always_writes) own.push_back(range);
    }
    if (f.timer) {
      tables_.timers.push_back(*f.timer);
      timers.push_back({f.writes.front(), group.writes.size()});
    }
    code.raises = code.raises || f.raises;
    group.counts_events = group.counts_events || is(instruction, Form::kEno);
  }
  code.timers.count = static_cast<std::uint32_t>(tables_.timers.size()) - code.timers.first;
  code.effort += kCodeEffort;
  code.is_restless = std::any_of(timers.begin(), timers.end(),
                                 [&](const OwnTimer& timer) { return is_disturbed(timer, group.writes); });
  code_groups_.push_back(std::move(group));
  tables_.codes.push_back(code);
  ++tables_.stretches.back().codes.count;
}

void ChangedPlan::add_outside(const Body& body, std::size_t i) {
  const std::size_t number = body.begin + i;
  const LinkedInstruction& instruction = linked_.instructions[number];
  const Footprint& f = body.footprints[i];
  // The groups of a body that runs once look after themselves.
  if (is(instruction, Form::kCallFixed) && once_[body_at_.at(callee(linked_, instruction))]) return;
  const bool goes_on = !f.target && !body.in_loop[i];
  if (is_run(instruction)) {
    std::vector<Range> writes;
    for (const GeneralRecord& record : footprints_.records_of(instruction)) writes.push_back({record.out, 1});
    outside_writes_.push_back({number, goes_on, std::move(writes)});
  } else if (f.writes_known) {
    if (!f.writes.empty()) outside_writes_.push_back({number, goes_on, f.writes});
  } else {
    outside_.emplace(number, Outside{Outside::Effect::kAnywhere, 0});
  }
}

void ChangedPlan::add(std::vector<Access>& accesses, std::uint32_t group, const Range& range) const {
  if (range.bytes != 0 && !overlap(range, constants_)) accesses.push_back({range, group});
}
void ChangedPlan::add_inputs(std::uint32_t group, const GeneralRecord& record) {
  for (std::size_t i = 0; i < std::size(record.in); ++i) {
    // Records with fewer inputs repeat one.
    const bool again = std::find(record.in, record.in + i, record.in[i]) != record.in + i;
    if (!again) add(reads_, group, {record.in[i], 1});
  }
}

// ---- for the compiler

const ChangedPlan::Stretch* ChangedPlan::stretch_at(std::size_t instruction) const {
  const auto found = stretch_at_.find(instruction);
  return found == stretch_at_.end() ? nullptr : &stretches_[found->second];
}

ChangedPlan::Outside ChangedPlan::outside(std::size_t instruction) const {
  const auto found = outside_.find(instruction);
  return found == outside_.end() ? Outside{} : found->second;
}

}  // namespace plc::native
