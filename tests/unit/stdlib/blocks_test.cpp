// Function blocks: the table of them, and bistables, edges, counters and timers feature by feature.
#include <gtest/gtest.h>

#include <cstring>
#include <set>
#include <string>
#include <vector>

#include "core/text.h"
#include "tests/unit/stdlib/block_table.h"

namespace plc::test {
namespace {

using stdlib::BlockSpec;
using stdlib::Direction;
using stdlib::Field;

// ---- the table --------------------------------------------------------------------------------------------------

TEST(Blocks, AreFoundInAnyCaseAndOnlyThose) {
  for (const BlockSpec& block : stdlib::blocks()) {
    EXPECT_EQ(stdlib::block_named(core::folded(block.name)), &block);
  }
  for (const char* name : {"SR",      "RS",       "R_TRIG",    "F_TRIG",     "CTU",       "CTD", "CTUD",
                           "CTU_INT", "CTU_DINT", "CTD_LINT",  "CTUD_UDINT", "CTU_ULINT", "TP",  "TON",
                           "TOF",     "TON_TIME", "TOF_LTIME", "SEMA",       "RTC",       "PID"}) {
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
      std::uint32_t bytes = core::rep_bytes(core::rep_of(field.type));
      std::uint32_t align = bytes;
      if (core::in_category(field.type, core::kAnyString)) {
        core::StringHeader header;
        std::memcpy(&header, static_cast<const std::byte*>(block.initial) + field.offset, sizeof header);
        EXPECT_EQ(header.capacity, core::kDefaultStringCapacity) << block.name << "." << field.name;
        bytes = sizeof header + header.capacity * (field.type == TypeId::kString ? 1u : 2u);
        align = alignof(core::StringHeader);
      }
      EXPECT_EQ(field.offset % align, 0u) << block.name << "." << field.name;
      EXPECT_LE(align, block.align) << block.name << "." << field.name;
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

TEST(Blocks, EveryBooleanStaysABooleanAndNothingIsWrittenPastIt) {
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

/// A block, what is shown of it, and a table as in stdlib::BlockExample.
struct Feature {
  std::vector<const char*> blocks;
  const char* title;
  const char* table;
};
void run(const Feature& feature) {
  for (const char* block : feature.blocks) run_table(block, feature.title, feature.table);
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

TEST(Edges, EverySequenceOfTwoScans) {
  const Feature kFeatures[] = {{{"R_TRIG"}, "first scan TRUE, then each change and none", R"(
at     CLK | Q
T#0ms  1   | 1
T#1ms  1   | 0
T#2ms  0   | 0
T#3ms  0   | 0
T#4ms  1   | 1
T#5ms  0   | 0
T#6ms  1   | 1
)"},
                               {{"R_TRIG"}, "first scan FALSE", R"(
at     CLK | Q
T#0ms  0   | 0
T#1ms  1   | 1
)"},
                               {{"F_TRIG"}, "first scan FALSE is an edge, as the standard writes it", R"(
at     CLK | Q
T#0ms  0   | 1
T#1ms  0   | 0
T#2ms  1   | 0
T#3ms  1   | 0
T#4ms  0   | 1
T#5ms  1   | 0
T#6ms  0   | 1
)"},
                               {{"F_TRIG"}, "first scan TRUE", R"(
at     CLK | Q
T#0ms  1   | 0
T#1ms  0   | 1
)"}};
  for (const Feature& feature : kFeatures) run(feature);
}

// ---- counters ---------------------------------------------------------------------------------------------------

const std::vector<const char*> kUp = {"CTU", "CTU_INT", "CTU_DINT", "CTU_LINT", "CTU_UINT", "CTU_UDINT", "CTU_ULINT"};
const std::vector<const char*> kDown = {"CTD", "CTD_INT", "CTD_DINT", "CTD_LINT", "CTD_UINT", "CTD_UDINT", "CTD_ULINT"};
const std::vector<const char*> kBoth = {"CTUD",      "CTUD_INT",   "CTUD_DINT", "CTUD_LINT",
                                        "CTUD_UINT", "CTUD_UDINT", "CTUD_ULINT"};
const std::vector<const char*> kBothSigned = {"CTUD", "CTUD_INT", "CTUD_DINT", "CTUD_LINT"};

TEST(Counters, FeatureByFeature) {
  const Feature kFeatures[] = {{kUp, "rising edges only: not levels, not falling edges", R"(
at     CU R PV | Q CV
T#0ms  0  0 2  | 0 0
T#1ms  1  . .  | 0 1
T#2ms  1  . .  | 0 1
T#3ms  0  . .  | 0 1
T#4ms  0  . .  | 0 1
T#5ms  1  . .  | 1 2
)"},
                               {kUp, "TRUE in the first scan is an edge", R"(
at     CU R PV | Q CV
T#0ms  1  0 5  | 0 1
T#1ms  1  . .  | 0 1
)"},
                               {kUp, "goes on beyond the preset", R"(
at     CU R PV | Q CV
T#0ms  1  0 1  | 1 1
T#1ms  0  . .  | 1 1
T#2ms  1  . .  | 1 2
)"},
                               {kUp, "Q follows a changed preset at once", R"(
at     CU R PV | Q CV
T#0ms  1  0 1  | 1 1
T#1ms  .  . 2  | 0 1
T#2ms  .  . 1  | 1 1
T#3ms  .  . 0  | 1 1
)"},
                               {kUp, "a fresh one with preset 0 has reached it", R"(
at     CU R PV | Q CV
T#0ms  0  0 0  | 1 0
)"},
                               {kUp, "R dominates, and the edge under it is gone", R"(
at     CU R PV | Q CV
T#0ms  1  0 1  | 1 1
T#1ms  0  1 .  | 0 0
T#2ms  1  1 .  | 0 0
T#3ms  1  0 .  | 0 0
T#4ms  0  0 .  | 0 0
T#5ms  1  0 .  | 1 1
)"},
                               {kUp, "R in the first scan, with CU", R"(
at     CU R PV | Q CV
T#0ms  1  1 1  | 0 0
T#1ms  1  0 .  | 0 0
)"},
                               {kDown, "rising edges only: not levels, not falling edges", R"(
at     CD LD PV | Q CV
T#0ms  0  1  3  | 0 3
T#1ms  0  0  .  | 0 3
T#2ms  1  .  .  | 0 2
T#3ms  1  .  .  | 0 2
T#4ms  0  .  .  | 0 2
T#5ms  1  .  .  | 0 1
T#6ms  0  .  .  | 0 1
T#7ms  1  .  .  | 1 0
)"},
                               {kDown, "not loaded it is at 0", R"(
at     CD LD PV | Q CV
T#0ms  0  0  3  | 1 0
)"},
                               {kDown, "LD is a level, dominates, and the edge under it is gone", R"(
at     CD LD PV | Q CV
T#0ms  0  1  3  | 0 3
T#1ms  1  1  .  | 0 3
T#2ms  1  0  .  | 0 3
T#3ms  0  1  5  | 0 5
T#4ms  0  1  4  | 0 4
)"},
                               {kDown, "a preset changed without LD does nothing", R"(
at     CD LD PV | Q CV
T#0ms  0  1  3  | 0 3
T#1ms  0  0  9  | 0 3
)"},
                               {kDown, "TRUE in the first scan is an edge, unless LD", R"(
at     CD LD PV | Q CV
T#0ms  1  1  3  | 0 3
T#1ms  1  0  .  | 0 3
)"},
                               {kBoth, "up and down", R"(
at     CU CD R LD PV | QU QD CV
T#0ms  0  0  0 0  2  | 0  1  0
T#1ms  1  0  . .  .  | 0  0  1
T#2ms  0  0  . .  .  | 0  0  1
T#3ms  1  0  . .  .  | 1  0  2
T#4ms  1  1  . .  .  | 0  0  1
T#5ms  1  0  . .  .  | 0  0  1
T#6ms  1  1  . .  .  | 0  1  0
)"},
                               {kBoth, "both edges at once cancel, also in the first scan", R"(
at     CU CD R LD PV | QU QD CV
T#0ms  1  1  0 0  2  | 0  1  0
T#1ms  0  0  0 1  .  | 1  0  2
T#2ms  1  1  0 0  .  | 1  0  2
T#3ms  1  1  . .  .  | 1  0  2
T#4ms  0  1  . .  .  | 1  0  2
T#5ms  1  1  . .  .  | 1  0  3
)"},
                               {kBoth, "R dominates LD, LD dominates counting; edges under them are gone", R"(
at     CU CD R LD PV | QU QD CV
T#0ms  0  0  0 1  5  | 1  0  5
T#1ms  1  0  0 1  .  | 1  0  5
T#2ms  1  0  1 1  .  | 0  1  0
T#3ms  1  1  1 0  .  | 0  1  0
T#4ms  1  1  0 0  .  | 0  1  0
T#5ms  0  0  0 1  4  | 1  0  4
T#6ms  0  1  0 1  .  | 1  0  4
T#7ms  0  1  0 0  .  | 1  0  4
)"},
                               {kBoth, "a preset of 0 is reached and left", R"(
at     CU CD R LD PV | QU QD CV
T#0ms  0  0  0 0  0  | 1  1  0
T#1ms  1  0  . .  .  | 1  0  1
)"},
                               {kBothSigned, "below zero, and presets below zero", R"(
at     CU CD R LD PV | QU QD CV
T#0ms  0  1  0 0  -2 | 1  1  -1
T#1ms  0  0  . .  .  | 1  1  -1
T#2ms  0  1  . .  .  | 1  1  -2
T#3ms  0  0  . .  .  | 1  1  -2
T#4ms  0  1  . .  .  | 0  1  -3
T#5ms  0  0  0 1  -7 | 1  1  -7
)"}};
  for (const Feature& feature : kFeatures) run(feature);
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
    // One below the end it counts once more, at the end it stays.
    const auto counts = [&](const char* input, std::int64_t from, std::int64_t to) {
      Instance c(block.name);
      c.set("CV", from), c.set(input, 1), c.step();
      EXPECT_EQ(c.get("CV"), to) << block.name;
      c.set(input, 0), c.step(), c.set(input, 1), c.step();
      EXPECT_EQ(c.get("CV"), to) << block.name;
    };
    if (stdlib::field_named(block, "CU") != nullptr) counts("CU", greatest - 1, greatest);
    if (stdlib::field_named(block, "CD") != nullptr) counts("CD", least + 1, least);
  }
}

// ---- timers -----------------------------------------------------------------------------------------------------

const std::vector<const char*> kOn = {"TON", "TON_TIME", "TON_LTIME"};
const std::vector<const char*> kOff = {"TOF", "TOF_TIME", "TOF_LTIME"};
const std::vector<const char*> kPulse = {"TP", "TP_TIME", "TP_LTIME"};

TEST(Timers, FeatureByFeature) {
  const Feature kFeatures[] = {{kOn, "Q when IN has been TRUE for PT; ET stays there", R"(
at      IN PT     | Q ET
T#100ms 0  T#30ms | 0 T#0ms
T#110ms 1  .      | 0 T#0ms
T#120ms 1  .      | 0 T#10ms
T#139ms 1  .      | 0 T#29ms
T#140ms 1  .      | 1 T#30ms
T#500ms 1  .      | 1 T#30ms
T#510ms 0  .      | 0 T#0ms
)"},
                               {kOn, "IN gone before PT starts from zero", R"(
at      IN PT     | Q ET
T#0ms   1  T#30ms | 0 T#0ms
T#29ms  0  .      | 0 T#0ms
T#30ms  1  .      | 0 T#0ms
T#59ms  1  .      | 0 T#29ms
T#60ms  1  .      | 1 T#30ms
)"},
                               {kOn, "a scan that comes late holds ET at PT", R"(
at      IN PT     | Q ET
T#0ms   1  T#30ms | 0 T#0ms
T#9s    1  .      | 1 T#30ms
)"},
                               {kOn, "several executions in one instant are as one", R"(
at      IN PT     | Q ET
T#0ms   1  T#30ms | 0 T#0ms
T#0ms   1  .      | 0 T#0ms
T#30ms  1  .      | 1 T#30ms
T#30ms  0  .      | 0 T#0ms
T#30ms  1  .      | 0 T#0ms
)"},
                               {kOn, "PT shorter while it runs: over at once when passed", R"(
at      IN PT      | Q ET
T#0ms   1  T#100ms | 0 T#0ms
T#40ms  1  .       | 0 T#40ms
T#50ms  1  T#50ms  | 1 T#50ms
T#60ms  1  T#200ms | 1 T#50ms
T#70ms  0  .       | 0 T#0ms
T#80ms  1  .       | 0 T#0ms
)"},
                               {kOn, "PT longer while it runs", R"(
at      IN PT      | Q ET
T#0ms   1  T#30ms  | 0 T#0ms
T#20ms  1  T#80ms  | 0 T#20ms
T#40ms  1  .       | 0 T#40ms
T#80ms  1  .       | 1 T#80ms
)"},
                               {kOn, "PT 0: Q is IN", R"(
at      IN PT     | Q ET
T#5ms   0  T#0ms  | 0 T#0ms
T#10ms  1  .      | 1 T#0ms
T#20ms  0  .      | 0 T#0ms
)"},
                               {kOn, "PT below 0 is as 0", R"(
at      IN PT     | Q ET
T#5ms   0  T#-5ms | 0 T#0ms
T#10ms  1  .      | 1 T#0ms
T#20ms  0  .      | 0 T#0ms
)"},
                               {kOn, "TRUE in the first scan starts at once", R"(
at      IN PT     | Q ET
T#7s    1  T#20ms | 0 T#0ms
T#7s20ms 1 .      | 1 T#20ms
)"},
                               {kOn, "a clock before the start counts as no time", R"(
at      IN PT     | Q ET
T#1s    1  T#50ms | 0 T#0ms
T#10ms  1  .      | 0 T#0ms
T#1s49ms 1 .      | 0 T#49ms
T#1s50ms 1 .      | 1 T#50ms
)"},
                               {kOff, "Q with IN, and PT longer", R"(
at      IN PT     | Q ET
T#0ms   0  T#30ms | 0 T#0ms
T#10ms  1  .      | 1 T#0ms
T#20ms  0  .      | 1 T#0ms
T#49ms  0  .      | 1 T#29ms
T#50ms  0  .      | 0 T#30ms
T#90ms  0  .      | 0 T#30ms
T#100ms 1  .      | 1 T#0ms
)"},
                               {kOff, "IN again before PT: the time starts anew", R"(
at      IN PT     | Q ET
T#0ms   1  T#30ms | 1 T#0ms
T#10ms  0  .      | 1 T#0ms
T#39ms  1  .      | 1 T#0ms
T#40ms  0  .      | 1 T#0ms
T#69ms  0  .      | 1 T#29ms
T#70ms  0  .      | 0 T#30ms
)"},
                               {kOff, "FALSE in the first scan times nothing", R"(
at      IN PT     | Q ET
T#7s    0  T#20ms | 0 T#0ms
T#8s    0  .      | 0 T#0ms
)"},
                               {kOff, "TRUE in the first scan", R"(
at      IN PT     | Q ET
T#7s    1  T#20ms | 1 T#0ms
T#7s1ms 0  .      | 1 T#0ms
T#7s21ms 0 .      | 0 T#20ms
)"},
                               {kOff, "PT changed while it runs, and after", R"(
at      IN PT      | Q ET
T#0ms   1  T#100ms | 1 T#0ms
T#10ms  0  .       | 1 T#0ms
T#40ms  0  T#60ms  | 1 T#30ms
T#50ms  0  T#20ms  | 0 T#20ms
T#60ms  0  T#500ms | 0 T#20ms
)"},
                               {kOff, "PT 0: Q is IN", R"(
at      IN PT     | Q ET
T#10ms  1  T#0ms  | 1 T#0ms
T#20ms  0  .      | 0 T#0ms
T#30ms  1  .      | 1 T#0ms
)"},
                               {kOff, "PT below 0 is as 0", R"(
at      IN PT     | Q ET
T#10ms  1  T#-1s  | 1 T#0ms
T#20ms  0  .      | 0 T#0ms
)"},
                               {kOff, "a clock before the start counts as no time", R"(
at      IN PT     | Q ET
T#1s    1  T#50ms | 1 T#0ms
T#2s    0  .      | 1 T#0ms
T#1s    0  .      | 1 T#0ms
T#2s50ms 0 .      | 0 T#50ms
)"},
                               {kPulse, "PT long whatever IN does; ET is held while IN is", R"(
at      IN PT     | Q ET
T#0ms   0  T#30ms | 0 T#0ms
T#10ms  1  .      | 1 T#0ms
T#20ms  0  .      | 1 T#10ms
T#30ms  1  .      | 1 T#20ms
T#40ms  1  .      | 0 T#30ms
T#50ms  1  .      | 0 T#30ms
T#60ms  0  .      | 0 T#0ms
T#70ms  1  .      | 1 T#0ms
)"},
                               {kPulse, "over with IN FALSE: ET back at once", R"(
at      IN PT     | Q ET
T#0ms   1  T#30ms | 1 T#0ms
T#10ms  0  .      | 1 T#10ms
T#30ms  0  .      | 0 T#0ms
T#40ms  1  .      | 1 T#0ms
)"},
                               {kPulse, "an edge in the scan in which it runs out is not seen", R"(
at      IN PT     | Q ET
T#0ms   1  T#30ms | 1 T#0ms
T#10ms  0  .      | 1 T#10ms
T#30ms  1  .      | 0 T#30ms
T#40ms  1  .      | 0 T#30ms
T#50ms  0  .      | 0 T#0ms
T#60ms  1  .      | 1 T#0ms
)"},
                               {kPulse, "PT changed while it runs, and after", R"(
at      IN PT      | Q ET
T#0ms   1  T#100ms | 1 T#0ms
T#40ms  1  T#80ms  | 1 T#40ms
T#50ms  1  T#20ms  | 0 T#20ms
T#60ms  1  T#500ms | 0 T#20ms
)"},
                               {kPulse, "PT 0: no pulse", R"(
at      IN PT     | Q ET
T#10ms  1  T#0ms  | 0 T#0ms
T#20ms  0  .      | 0 T#0ms
)"},
                               {kPulse, "PT below 0 is as 0", R"(
at      IN PT     | Q ET
T#10ms  1  T#-5ms | 0 T#0ms
T#20ms  1  .      | 0 T#0ms
T#30ms  0  .      | 0 T#0ms
)"},
                               {kPulse, "TRUE in the first scan starts at once", R"(
at      IN PT     | Q ET
T#7s    1  T#20ms | 1 T#0ms
T#7s20ms 1 .      | 0 T#20ms
)"},
                               {kPulse, "a clock before the start counts as no time", R"(
at      IN PT     | Q ET
T#1s    1  T#50ms | 1 T#0ms
T#0ms   1  .      | 1 T#0ms
T#1s50ms 1 .      | 0 T#50ms
)"}};
  for (const Feature& feature : kFeatures) run(feature);
}

}  // namespace
}  // namespace plc::test
