// Function blocks, driven as the runtime drives them: through the port struct and its fields, one call a cycle.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/text.h"
#include "stdlib/library.h"

namespace plc::test {
namespace {

using core::TypeId;
using stdlib::BlockSpec;
using stdlib::Direction;
using stdlib::Field;

constexpr std::int64_t kMs = 1'000'000;

/// An instance in memory that is no larger than the block says, with a canary behind it.
class Instance {
 public:
  explicit Instance(std::string_view name) : spec_(stdlib::block_named(name)) {
    if (spec_ == nullptr) throw std::runtime_error("no block " + std::string(name));
    memory_.assign(spec_->size / 8 + 2, 0xa5a5a5a5a5a5a5a5ull);
    std::memcpy(memory_.data(), spec_->initial, spec_->size);
  }
  void set(std::string_view field, std::int64_t value) { std::memcpy(at(field), &value, bytes(field)); }
  [[nodiscard]] std::int64_t get(std::string_view field) {
    std::uint64_t raw = 0;
    std::memcpy(&raw, at(field), bytes(field));
    const unsigned w = 8 * static_cast<unsigned>(bytes(field));
    const TypeId type = stdlib::field_named(*spec_, field)->type;
    const bool negative = core::in_category(type, core::kAnySigned) && w < 64 && (raw >> (w - 1)) != 0;
    return static_cast<std::int64_t>(negative ? raw | ~0ull << w : raw);
  }
  void step(std::int64_t now_ms = 0) { spec_->step(memory_.data(), stdlib::StepContext{now_ms * kMs}); }
  [[nodiscard]] bool canary_is_whole() const { return memory_.back() == 0xa5a5a5a5a5a5a5a5ull; }

 private:
  std::byte* at(std::string_view field) {
    const Field* f = stdlib::field_named(*spec_, field);
    if (f == nullptr) throw std::runtime_error("no field " + std::string(field));
    return reinterpret_cast<std::byte*>(memory_.data()) + f->offset;
  }
  std::size_t bytes(std::string_view field) const {
    return core::rep_bytes(core::rep_of(stdlib::field_named(*spec_, field)->type));
  }
  const BlockSpec* spec_;
  std::vector<std::uint64_t> memory_;
};

// ---- the table --------------------------------------------------------------------------------------------------

TEST(Blocks, AreFoundInAnyCaseAndOnlyThose) {
  for (const BlockSpec& block : stdlib::blocks()) {
    EXPECT_EQ(stdlib::block_named(core::folded(block.name)), &block);
  }
  for (const char* name : {"SR", "RS", "R_TRIG", "F_TRIG", "CTU", "CTD", "CTUD", "CTU_INT", "CTU_DINT", "CTD_LINT",
                           "CTUD_UDINT", "CTU_ULINT", "TP", "TON", "TOF", "TON_TIME", "TOF_LTIME"}) {
    EXPECT_NE(stdlib::block_named(name), nullptr) << name;
  }
  EXPECT_EQ(stdlib::block_named("TO"), nullptr);
  EXPECT_EQ(stdlib::block_named("TONN"), nullptr);
  EXPECT_EQ(stdlib::block_named(""), nullptr);
}

TEST(Blocks, FieldsAreAlignedInsideAndApart) {
  for (const BlockSpec& block : stdlib::blocks()) {
    std::vector<bool> used(block.size, false);
    std::set<std::string> names;
    EXPECT_EQ(block.size % block.align, 0u) << block.name;
    for (const Field& field : block.fields) {
      const std::uint32_t bytes = core::rep_bytes(core::rep_of(field.type));
      EXPECT_EQ(field.offset % bytes, 0u) << block.name << "." << field.name;
      EXPECT_LE(bytes, block.align) << block.name << "." << field.name;
      ASSERT_LE(field.offset + bytes, block.size) << block.name << "." << field.name;
      for (std::uint32_t i = field.offset; i < field.offset + bytes; ++i) {
        EXPECT_FALSE(used[i]) << block.name << "." << field.name;
        used[i] = true;
      }
      EXPECT_TRUE(names.insert(core::folded(field.name)).second) << block.name << "." << field.name;
      if (!field.alias.empty()) {
        EXPECT_TRUE(names.insert(core::folded(field.alias)).second) << field.alias;
      }
      EXPECT_FALSE(field.summary.empty());
    }
  }
}

TEST(Blocks, EveryBooleanStaysABooleanAndNothingIsWrittenBehind) {
  for (const BlockSpec& block : stdlib::blocks()) {
    Instance instance(block.name);
    for (unsigned pattern = 0; pattern < 64; ++pattern) {
      unsigned bit = 0;
      for (const Field& field : block.fields) {
        if (field.direction == Direction::kInput && field.type == TypeId::kBool) {
          instance.set(field.name, pattern >> bit++ & 1);
        } else if (field.direction == Direction::kInput) {
          instance.set(field.name, static_cast<std::int64_t>(pattern) - 32);
        }
      }
      instance.step(pattern);
      for (const Field& field : block.fields) {
        if (field.type == TypeId::kBool) {
          EXPECT_LE(instance.get(field.name), 1) << block.name << "." << field.name;
        }
      }
    }
    EXPECT_TRUE(instance.canary_is_whole()) << block.name;
  }
}

/// Images carry these hashes: a change here makes old images unusable and must be meant.
TEST(Blocks, LayoutHashesAreStableAndDiffer) {
  std::set<std::uint64_t> hashes;
  for (const BlockSpec& block : stdlib::blocks())
    EXPECT_TRUE(hashes.insert(stdlib::layout_hash(block)).second) << block.name;
  EXPECT_EQ(stdlib::layout_hash(*stdlib::block_named("TON")), 13856669935031970076ull);
  EXPECT_EQ(stdlib::layout_hash(*stdlib::block_named("SR")), 9994078064627740707ull);
  EXPECT_EQ(stdlib::layout_hash(*stdlib::block_named("CTU")), 18079308996394677027ull);
}

TEST(Blocks, PinsAreFoundByTheirOtherNames) {
  const auto offset = [](const char* block, const char* pin) {
    const Field* field = stdlib::field_named(*stdlib::block_named(block), pin);
    return field == nullptr ? -1 : static_cast<int>(field->offset);
  };
  EXPECT_EQ(offset("SR", "SET1"), offset("SR", "S1"));
  EXPECT_EQ(offset("SR", "reset"), offset("SR", "R"));
  EXPECT_EQ(offset("RS", "SET"), offset("RS", "S"));
  EXPECT_EQ(offset("RS", "RESET1"), offset("RS", "R1"));
  EXPECT_EQ(offset("CTU", "RESET"), offset("CTU", "R"));
  EXPECT_EQ(offset("CTUD", "LOAD"), offset("CTUD", "LD"));
  EXPECT_EQ(offset("CTU", "LOAD"), -1);
}

// ---- bistables and edges ----------------------------------------------------------------------------------------

TEST(Bistable, SetOrResetDominates) {
  struct Row {
    int set, reset, before, sr, rs;
  };
  const Row kRows[] = {{0, 0, 0, 0, 0}, {0, 0, 1, 1, 1}, {1, 0, 0, 1, 1}, {1, 0, 1, 1, 1},
                       {0, 1, 0, 0, 0}, {0, 1, 1, 0, 0}, {1, 1, 0, 1, 0}, {1, 1, 1, 1, 0}};
  for (const Row& row : kRows) {
    Instance sr("SR"), rs("RS");
    sr.set("S1", row.set), sr.set("R", row.reset), sr.set("Q1", row.before), sr.step();
    rs.set("S", row.set), rs.set("R1", row.reset), rs.set("Q1", row.before), rs.step();
    EXPECT_EQ(sr.get("Q1"), row.sr) << row.set << row.reset << row.before;
    EXPECT_EQ(rs.get("Q1"), row.rs) << row.set << row.reset << row.before;
  }
}

std::string trace(std::string_view block, std::string_view input, std::string_view output, std::string_view signal) {
  Instance instance(block);
  std::string out;
  for (const char c : signal) {
    instance.set(input, c == '1');
    instance.step();
    out += instance.get(output) != 0 ? '1' : '0';
  }
  return out;
}
TEST(Edges, LastOneExecution) {
  EXPECT_EQ(trace("R_TRIG", "CLK", "Q", "0011101"), "0010001");
  EXPECT_EQ(trace("F_TRIG", "CLK", "Q", "1100010"), "0010001");
}
TEST(Edges, FirstExecutionIsAsTheStandardWritesIt) {
  EXPECT_EQ(trace("R_TRIG", "CLK", "Q", "11"), "10");
  EXPECT_EQ(trace("F_TRIG", "CLK", "Q", "00"), "10");
  EXPECT_EQ(trace("F_TRIG", "CLK", "Q", "10"), "01");
}

// ---- counters ---------------------------------------------------------------------------------------------------

TEST(Counters, UpCountsRisingEdgesToThePreset) {
  Instance c("CTU");
  c.set("PV", 2);
  std::string q;
  for (const char cu : std::string_view("1101001")) {
    c.set("CU", cu == '1');
    c.step();
    q += c.get("Q") != 0 ? '1' : '0';
  }
  EXPECT_EQ(c.get("CV"), 3);
  EXPECT_EQ(q, "0001111");
  c.set("R", 1), c.set("CU", 0), c.step();
  EXPECT_EQ(c.get("CV"), 0);
  c.set("CU", 1), c.step();
  EXPECT_EQ(c.get("CV"), 0) << "reset dominates";
  c.set("R", 0), c.step();
  EXPECT_EQ(c.get("CV"), 0) << "the edge under reset is gone";
}

TEST(Counters, DownCountsRisingEdgesToo) {
  Instance c("CTD");
  c.set("PV", 2), c.set("LD", 1), c.step();
  EXPECT_EQ(c.get("CV"), 2);
  EXPECT_EQ(c.get("Q"), 0);
  c.set("LD", 0), c.set("CD", 1), c.step(), c.step(), c.step();
  EXPECT_EQ(c.get("CV"), 1) << "held TRUE counts once";
  c.set("CD", 0), c.step(), c.set("CD", 1), c.step();
  EXPECT_EQ(c.get("CV"), 0);
  EXPECT_EQ(c.get("Q"), 1);
}

TEST(Counters, FreshOnesAreAtZero) {
  Instance up("CTU"), down("CTD"), both("CTUD");
  up.step(), down.step(), both.step();
  EXPECT_EQ(up.get("Q"), 1) << "0 >= 0";
  EXPECT_EQ(down.get("Q"), 1);
  EXPECT_EQ(both.get("QU"), 1);
  EXPECT_EQ(both.get("QD"), 1);
}

TEST(Counters, UpAndDownAtOnceCancelAndResetDominatesLoad) {
  Instance c("CTUD_DINT");
  c.set("PV", 5), c.set("LD", 1), c.step();
  EXPECT_EQ(c.get("CV"), 5);
  c.set("R", 1), c.step();
  EXPECT_EQ(c.get("CV"), 0);
  c.set("R", 0), c.set("LD", 0), c.set("CU", 1), c.set("CD", 1), c.step();
  EXPECT_EQ(c.get("CV"), 0);
  c.set("CU", 0), c.set("CD", 0), c.step(), c.set("CU", 1), c.step();
  EXPECT_EQ(c.get("CV"), 1);
  c.set("CD", 1), c.step(), c.set("CD", 0), c.step(), c.set("CD", 1), c.step();
  EXPECT_EQ(c.get("CV"), -1);
  EXPECT_EQ(c.get("QD"), 1);
}

TEST(Counters, StopAtTheEndsOfTheirType) {
  for (const BlockSpec& block : stdlib::blocks()) {
    if (!block.name.starts_with("CT")) continue;
    const TypeId type = stdlib::field_named(block, "CV")->type;
    const unsigned w = 8 * core::rep_bytes(core::rep_of(type));
    const bool is_signed = core::in_category(type, core::kAnySigned);
    const auto greatest = static_cast<std::int64_t>(is_signed ? (1ull << (w - 1)) - 1
                                                    : w == 64 ? ~0ull
                                                              : (1ull << w) - 1);
    const auto least = is_signed ? static_cast<std::int64_t>(~0ull << (w - 1)) : 0;
    if (block.name.starts_with("CTU")) {
      Instance c(block.name);
      c.set("CV", greatest), c.set("CU", 1), c.step();
      EXPECT_EQ(c.get("CV"), greatest) << block.name;
    }
    if (!block.name.starts_with("CTU_") && block.name != "CTU") {
      Instance c(block.name);
      c.set("CV", least), c.set("CD", 1), c.step();
      EXPECT_EQ(c.get("CV"), least) << block.name;
    }
  }
}

// ---- timers -----------------------------------------------------------------------------------------------------

/// One line per execution: time, IN, PT in ms; then Q and ET in ms.
struct Tick {
  std::int64_t now;
  int in;
  std::int64_t pt;
  int q;
  std::int64_t et;
};
void run(std::string_view block, const std::vector<Tick>& ticks) {
  Instance t(block);
  for (const Tick& tick : ticks) {
    t.set("IN", tick.in);
    t.set("PT", tick.pt * kMs);
    t.step(tick.now);
    EXPECT_EQ(t.get("Q"), tick.q) << block << " at " << tick.now << " ms";
    EXPECT_EQ(t.get("ET"), tick.et * kMs) << block << " at " << tick.now << " ms";
  }
}

TEST(Timers, OnDelay) {
  for (const char* block : {"TON", "TON_TIME", "TON_LTIME"}) {
    run(block, {{100, 0, 30, 0, 0},
                {110, 1, 30, 0, 0},
                {120, 1, 30, 0, 10},
                {139, 1, 30, 0, 29},
                {140, 1, 30, 1, 30},
                {500, 1, 30, 1, 30},
                {510, 0, 30, 0, 0},
                {520, 1, 30, 0, 0},
                {530, 1, 30, 0, 10},
                {540, 0, 30, 0, 0},
                {550, 1, 30, 0, 0},
                {600, 1, 30, 1, 30}});
  }
}
TEST(Timers, OffDelay) {
  for (const char* block : {"TOF", "TOF_TIME", "TOF_LTIME"}) {
    run(block, {{0, 0, 30, 0, 0},
                {10, 1, 30, 1, 0},
                {20, 0, 30, 1, 0},
                {40, 0, 30, 1, 20},
                {50, 0, 30, 0, 30},
                {90, 0, 30, 0, 30},
                {100, 1, 30, 1, 0},
                {110, 0, 30, 1, 0},
                {120, 1, 30, 1, 0},
                {130, 0, 30, 1, 0},
                {170, 0, 30, 0, 30}});
  }
}
TEST(Timers, Pulse) {
  for (const char* block : {"TP", "TP_TIME", "TP_LTIME"}) {
    run(block, {{0, 0, 30, 0, 0},
                {10, 1, 30, 1, 0},
                {20, 0, 30, 1, 10},  // IN does not matter meanwhile
                {30, 1, 30, 1, 20},  // nor does another edge
                {40, 1, 30, 0, 30},
                {50, 1, 30, 0, 30},  // ET is held while IN is
                {60, 0, 30, 0, 0},
                {70, 1, 30, 1, 0},
                {80, 0, 30, 1, 10},
                {100, 0, 30, 0, 0},  // over with IN FALSE: ET back at once
                {110, 1, 30, 1, 0}});
  }
}
TEST(Timers, TrueInTheFirstScanStartsAtOnce) {
  run("TON", {{7000, 1, 20, 0, 0}, {7020, 1, 20, 1, 20}});
  run("TP", {{7000, 1, 20, 1, 0}, {7020, 1, 20, 0, 20}});
  run("TOF", {{7000, 1, 20, 1, 0}, {7001, 0, 20, 1, 0}, {7021, 0, 20, 0, 20}});
  run("TOF", {{7000, 0, 20, 0, 0}, {7100, 0, 20, 0, 0}});
}
TEST(Timers, ZeroAndNegativePresetsRunOutAtOnce) {
  for (const std::int64_t pt : {0, -5}) {
    run("TON", {{5, 0, pt, 0, 0}, {10, 1, pt, 1, 0}, {20, 0, pt, 0, 0}});
    run("TOF", {{10, 1, pt, 1, 0}, {20, 0, pt, 0, 0}});
    run("TP", {{10, 1, pt, 0, 0}, {20, 0, pt, 0, 0}});
  }
}
TEST(Timers, ChangedPresetTakesEffectWhileTheTimeRuns) {
  run("TON", {{0, 1, 100, 0, 0}, {40, 1, 100, 0, 40}, {50, 1, 50, 1, 50}, {60, 1, 200, 1, 50}, {70, 0, 200, 0, 0}});
  run("TON", {{0, 1, 30, 0, 0}, {20, 1, 80, 0, 20}, {40, 1, 80, 0, 40}, {80, 1, 80, 1, 80}});
  run("TOF", {{0, 1, 100, 1, 0}, {10, 0, 100, 1, 0}, {40, 0, 20, 0, 20}});
  run("TP", {{0, 1, 100, 1, 0}, {40, 1, 20, 0, 20}});
}
TEST(Timers, ClockBehindTheStartCountsAsNoTime) {
  run("TON", {{1000, 1, 50, 0, 0}, {10, 1, 50, 0, 0}, {1049, 1, 50, 0, 49}, {1050, 1, 50, 1, 50}});
}

}  // namespace
}  // namespace plc::test
