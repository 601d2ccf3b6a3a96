// Bistables, edges, counters and timers against models written from the text and the time diagrams of the standard, not
// from our code: random inputs, time that stands still, creeps and leaps, 100,000 executions of each block.
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "tests/unit/stdlib/block_table.h"

namespace plc::test {
namespace {

using Limits = std::numeric_limits<std::int16_t>;

/// Random executions: booleans that stay for a while, and instants.
class Scans {
 public:
  explicit Scans(unsigned seed) : random_(seed) {}
  unsigned below(unsigned n) { return static_cast<unsigned>(random_() % n); }
  bool keep_or_toss(bool before, unsigned one_in) { return below(one_in) == 0 ? below(2) != 0 : before; }
  std::int64_t next_instant() {
    constexpr std::int64_t kSteps[] = {0, 1, 10 * kMs, 10 * kMs, 10 * kMs, 11 * kMs, 100 * kMs, 3'600'000 * kMs};
    return now_ += kSteps[below(8)];
  }

 private:
  std::mt19937_64 random_;
  std::int64_t now_ = 5'000 * kMs;
};

constexpr int kRuns = 20, kScansOfARun = 5'000;

// ---- bistables and edges ----------------------------------------------------------------------------------------

TEST(BlockModels, BistablesAndEdges) {
  for (unsigned run = 0; run < kRuns; ++run) {
    Scans scans(run);
    Instance sr("SR"), rs("RS"), rise("R_TRIG"), fall("F_TRIG");
    bool set_wins = false, reset_wins = false, before_rise = false, before_fall = true, a = false, b = false;
    for (int i = 0; i < kScansOfARun; ++i) {
      a = scans.keep_or_toss(a, 3);
      b = scans.keep_or_toss(b, 3);
      sr.set("S1", a), sr.set("R", b), sr.step();
      if (a) set_wins = true;
      if (b && !a) set_wins = false;
      ASSERT_EQ(sr.get("Q1") != 0, set_wins) << i;
      rs.set("S", a), rs.set("R1", b), rs.step();
      if (b) reset_wins = false;
      if (a && !b) reset_wins = true;
      ASSERT_EQ(rs.get("Q1") != 0, reset_wins) << i;
      rise.set("CLK", a), rise.step();
      ASSERT_EQ(rise.get("Q") != 0, a && !before_rise) << i;
      before_rise = a;
      fall.set("CLK", a), fall.step();
      // The standard's body counts a FALSE at the first execution as an edge: before it CLK was TRUE.
      ASSERT_EQ(fall.get("Q") != 0, !a && before_fall) << i;
      before_fall = a;
    }
  }
}

// ---- counters ---------------------------------------------------------------------------------------------------

/// An R_TRIG at an input, as the bodies of the standard have it.
struct Edge {
  bool before = false;
  bool operator()(bool now) {
    const bool edge = now && !before;
    before = now;
    return edge;
  }
};

TEST(BlockModels, CountersOfInt) {
  for (unsigned run = 0; run < kRuns; ++run) {
    Scans scans(100 + run);
    Instance up("CTU"), down("CTD"), both("CTUD");
    Edge up_edge, down_edge, both_up, both_down;
    int up_cv = 0, down_cv = 0, both_cv = 0;
    bool cu = false, cd = false;
    for (int i = 0; i < kScansOfARun; ++i) {
      cu = scans.keep_or_toss(cu, 2);
      cd = scans.keep_or_toss(cd, 2);
      const bool r = scans.below(200) == 0, ld = scans.below(100) == 0;
      // Presets at the ends of the type too, so that counting reaches them.
      constexpr int kPresets[] = {0, 3, 17, -5, Limits::max() - 2, Limits::min() + 2, Limits::max(), Limits::min()};
      const int pv = kPresets[scans.below(8)];

      up.set("CU", cu), up.set("R", r), up.set("PV", pv), up.step();
      const bool counted_up = up_edge(cu);
      if (r) {
        up_cv = 0;
      } else if (counted_up && up_cv < Limits::max()) {
        up_cv = up_cv + 1;
      }
      ASSERT_EQ(up.get("CV"), up_cv) << i;
      ASSERT_EQ(up.get("Q") != 0, up_cv >= pv) << i;

      down.set("CD", cd), down.set("LD", ld), down.set("PV", pv), down.step();
      const bool counted_down = down_edge(cd);
      if (ld) {
        down_cv = pv;
      } else if (counted_down && down_cv > Limits::min()) {
        down_cv = down_cv - 1;
      }
      ASSERT_EQ(down.get("CV"), down_cv) << i;
      ASSERT_EQ(down.get("Q") != 0, down_cv <= 0) << i;

      both.set("CU", cu), both.set("CD", cd), both.set("R", r), both.set("LD", ld), both.set("PV", pv), both.step();
      const bool u = both_up(cu), d = both_down(cd);
      if (r) {
        both_cv = 0;
      } else if (ld) {
        both_cv = pv;
      } else if (!(u && d)) {
        if (u && both_cv < Limits::max()) {
          both_cv = both_cv + 1;
        } else if (d && both_cv > Limits::min()) {
          both_cv = both_cv - 1;
        }
      }
      ASSERT_EQ(both.get("CV"), both_cv) << i;
      ASSERT_EQ(both.get("QU") != 0, both_cv >= pv) << i;
      ASSERT_EQ(both.get("QD") != 0, both_cv <= 0) << i;
    }
  }
}

// ---- timers -----------------------------------------------------------------------------------------------------

/// What the time diagrams show at an instant, from when IN rose and fell.
struct Shown {
  bool q;
  std::int64_t et;
};

/// Q while IN has been TRUE for PT.
struct OnDelayDiagram {
  bool before = false;
  std::int64_t rose = 0;
  Shown at(std::int64_t now, bool in, std::int64_t pt) {
    if (in && !before) rose = now;
    before = in;
    if (!in) return {false, 0};
    return {now - rose >= pt, std::min(now - rose, pt)};
  }
};
/// Q until IN has been FALSE for PT.
struct OffDelayDiagram {
  bool before = false, ever = false;
  std::int64_t fell = 0;
  Shown at(std::int64_t now, bool in, std::int64_t pt) {
    if (!in && before) fell = now;
    before = in;
    ever = ever || in;
    if (in) return {true, 0};
    if (!ever) return {false, 0};
    return {now - fell < pt, std::min(now - fell, pt)};
  }
};
/// A pulse of PT from a rising edge outside of a pulse on.
struct PulseDiagram {
  bool before = false, pulse = false;
  std::int64_t rose = 0, shown = 0;
  Shown at(std::int64_t now, bool in, std::int64_t pt) {
    if (in && !before && !pulse) {
      pulse = true;
      rose = now;
    }
    before = in;
    if (pulse) {
      shown = std::min(now - rose, pt);
      pulse = now - rose < pt;
    }
    if (!pulse && !in) shown = 0;
    return {pulse, shown};
  }
};

template <class Diagram>
void expect_as_drawn(const char* block) {
  constexpr std::int64_t kPresets[] = {0, 1, 10 * kMs, 25 * kMs, 100 * kMs, 3'600'000 * kMs};
  for (unsigned run = 0; run < kRuns; ++run) {
    Scans scans(1000 + run);
    Instance timer(block);
    Diagram diagram;
    const std::int64_t pt = kPresets[run % std::size(kPresets)];
    timer.set("PT", pt);
    bool in = run % 2 != 0;
    for (int i = 0; i < kScansOfARun; ++i) {
      const std::int64_t now = scans.next_instant();
      timer.set("IN", in);
      timer.step_ns(now);
      const Shown shown = diagram.at(now, in, pt);
      ASSERT_EQ(timer.get("Q") != 0, shown.q) << block << " run " << run << " scan " << i;
      ASSERT_EQ(timer.get("ET"), shown.et) << block << " run " << run << " scan " << i;
      in = scans.keep_or_toss(in, 4);
    }
  }
}
TEST(BlockModels, OnDelay) { expect_as_drawn<OnDelayDiagram>("TON"); }
TEST(BlockModels, OffDelay) { expect_as_drawn<OffDelayDiagram>("TOF"); }
TEST(BlockModels, Pulse) { expect_as_drawn<PulseDiagram>("TP"); }

}  // namespace
}  // namespace plc::test
