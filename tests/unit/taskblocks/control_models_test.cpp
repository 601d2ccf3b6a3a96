// STATE_SPACE, STATE_FEEDBACK and OBSERVER against closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <string>

#include "picard/testing.h"
#include "taskblocks/set.h"
#include "tests/support/count_allocations.h"

namespace plc::blocks {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

class Block : public picard::Instance {
 public:
  Block(const char* type, nanoseconds period) : Instance(control_library(), type, period) {}
  double& operator[](const char* name) { return port<double>(name); }
  void size(const char* name, std::int16_t value) { port<std::int16_t>(name) = value; }
  template <std::size_t Count>
  void set(const char* name, std::initializer_list<double> values) {
    std::copy(values.begin(), values.end(), port<std::array<double, Count>>(name).begin());
  }
  double x(std::size_t i) { return port<std::array<double, 8>>("X")[i]; }
  bool bad() { return port<bool>("BAD"); }
};

template <class Set>
std::string complaint(const char* type, nanoseconds period, Set set) {
  Block block(type, period);
  set(block);
  try {
    block.ready();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "none";
}

/// s^2 + 2 D w s + w^2 over w^2, held inputs: the exact discrete form.
struct Oscillator {
  double w = 3;
  double damping = 0.2;
  double h = 0.05;
  double wd = w * std::sqrt(1 - damping * damping);

  /// State 1, its step response from rest.
  double response(double t) const {
    const double s = damping * w;
    return 1 - std::exp(-s * t) * (std::cos(wd * t) + s / wd * std::sin(wd * t));
  }
  double rate(double t) const { return std::exp(-damping * w * t) * w * w / wd * std::sin(wd * t); }
  void give(Block& block) const {
    const double s = damping * w;
    const double e = std::exp(-s * h);
    const double cosine = std::cos(wd * h);
    const double sine = std::sin(wd * h);
    block.size("NX", 2);
    block.set<64>("A", {e * (cosine + s / wd * sine), e * sine / wd,  //
                        -e * w * w / wd * sine, e * (cosine - s / wd * sine)});
    block.set<32>("B", {response(h), rate(h)});
    block.set<32>("C", {1, 0});
  }
};

TEST(StateSpace, StepResponseOfAnOscillator) {
  const Oscillator oscillator;
  Block model("STATE_SPACE", milliseconds(50));
  oscillator.give(model);
  model["TS"] = 0.05;
  model["U1"] = 2;
  for (int k = 0; k < 400; ++k) {
    model.fire();
    ASSERT_NEAR(model["Y1"], 2 * oscillator.response(k * 0.05), 1e-12) << k;
    ASSERT_NEAR(model.x(1), 2 * oscillator.rate(k * 0.05), 1e-11) << k;
  }
  EXPECT_FALSE(model.bad());
}

// A chain of eight delays, four inputs, four outputs: each number of each matrix is where it belongs.
TEST(StateSpace, AllSizesInUse) {
  Block model("STATE_SPACE", milliseconds(1));
  for (const char* name : {"NU", "NY"}) model.size(name, 4);
  model.size("NX", 8);
  auto& a = model.port<std::array<double, 64>>("A");
  auto& b = model.port<std::array<double, 32>>("B");
  auto& c = model.port<std::array<double, 32>>("C");
  auto& d = model.port<std::array<double, 16>>("D");
  for (std::size_t i = 0; i < 64; ++i) a[i] = 0.1 * std::sin(1.0 + static_cast<double>(i));
  for (std::size_t i = 0; i < 32; ++i) b[i] = std::cos(static_cast<double>(i));
  for (std::size_t i = 0; i < 32; ++i) c[i] = std::sin(3.0 * static_cast<double>(i));
  for (std::size_t i = 0; i < 16; ++i) d[i] = std::cos(5.0 * static_cast<double>(i));
  model.set<8>("X0", {1, 2, 3, 4, 5, 6, 7, 8});
  std::array<double, 8> x{1, 2, 3, 4, 5, 6, 7, 8};
  const char* const inputs[] = {"U1", "U2", "U3", "U4"};
  const char* const outputs[] = {"Y1", "Y2", "Y3", "Y4"};
  for (int k = 0; k < 20; ++k) {
    double u[4];
    for (int i = 0; i < 4; ++i) model[inputs[i]] = u[i] = std::sin(k + i);
    model.fire();
    for (std::size_t i = 0; i < 4; ++i) {
      double y = 0;
      for (std::size_t j = 0; j < 8; ++j) y += c[i * 8 + j] * x[j];
      for (std::size_t j = 0; j < 4; ++j) y += d[i * 4 + j] * u[j];
      ASSERT_NEAR(model[outputs[i]], y, 1e-12) << k;
    }
    std::array<double, 8> next{};
    for (std::size_t i = 0; i < 8; ++i) {
      ASSERT_NEAR(model.x(i), x[i], 1e-12);
      for (std::size_t j = 0; j < 8; ++j) next[i] += a[i * 8 + j] * x[j];
      for (std::size_t j = 0; j < 4; ++j) next[i] += b[i * 4 + j] * u[j];
    }
    x = next;
  }
}

TEST(StateSpace, LimitsResetAndBadInput) {
  Block model("STATE_SPACE", milliseconds(1));  // an integrator
  model.set<64>("A", {1});
  model.set<32>("B", {1});
  model.set<32>("C", {1});
  model.set<8>("X0", {-1});
  model.set<4>("YMIN", {-0.5});
  model.set<4>("YMAX", {2.5});
  model["U1"] = 1;
  for (const double expected : {-0.5, 0.0, 1.0, 2.0, 2.5, 2.5}) {
    model.fire();
    EXPECT_EQ(model["Y1"], expected);
  }
  EXPECT_EQ(model.x(0), 4) << "the state does not notice limits";
  model["U1"] = kNan;
  model.fire();
  EXPECT_TRUE(model.bad());
  EXPECT_EQ(model.x(0), 5);
  model["U1"] = -1;
  model.fire();
  EXPECT_FALSE(model.bad());
  EXPECT_EQ(model.x(0), 6) << "the last good input counted";
  model.port<bool>("RESET") = true;
  for (int i = 0; i < 2; ++i) {
    model.fire();
    EXPECT_EQ(model.x(0), -1);
  }
  model.port<bool>("RESET") = false;
  model.fire();
  EXPECT_EQ(model.x(0), -2);
}

TEST(StateSpace, AModelThatIsNotStableStaysFinite) {
  Block model("STATE_SPACE", milliseconds(1));
  model.set<64>("A", {1e100});
  model.set<32>("C", {1e100});
  model.set<8>("X0", {1});
  for (int i = 0; i < 10; ++i) model.fire();
  EXPECT_TRUE(model.bad());
  EXPECT_EQ(model.x(0), 1e300);
  EXPECT_EQ(model["Y1"], 1e300) << "1e400 is not given";
  model.port<bool>("RESET") = true;
  model.fire();
  EXPECT_FALSE(model.bad());
  EXPECT_EQ(model["Y1"], 1e100);
}

TEST(StateSpace, ConfigurationIsChecked) {
  const auto refused = [](auto set) { return complaint("STATE_SPACE", milliseconds(10), set); };
  EXPECT_EQ(refused([](Block&) {}), "none");
  EXPECT_EQ(refused([](Block& m) { m.size("NX", 9); }), "NX is 9, its range is 1 .. 8");
  EXPECT_EQ(refused([](Block& m) { m.size("NX", 0); }), "NX is 0, its range is 1 .. 8");
  EXPECT_EQ(refused([](Block& m) { m.size("NU", 5); }), "NU is 5, its range is 1 .. 4");
  EXPECT_EQ(refused([](Block& m) { m.size("NY", -1); }), "NY is -1, its range is 1 .. 4");
  EXPECT_EQ(refused([](Block& m) { m.set<64>("A", {kNan}); }), "a number in A is not finite");
  EXPECT_EQ(refused([](Block& m) { m.set<64>("A", {0, kNan}); }), "none") << "not in use";
  EXPECT_EQ(refused([](Block& m) { m.set<4>("YMAX", {kNan}); }), "a number in YMIN or YMAX is NaN");
  EXPECT_EQ(refused([](Block& m) { m["TS"] = 0.01; }), "none");
  EXPECT_EQ(refused([](Block& m) { m["TS"] = 0.02; }),
            "TS, the sample time of the matrices, is not the period of the task");
  EXPECT_EQ(complaint("STATE_SPACE", nanoseconds(0), [](Block& m) { m["TS"] = 0.02; }),
            "TS is given, but the task has no period: its executions are no samples");
  EXPECT_EQ(complaint("STATE_SPACE", nanoseconds(0), [](Block&) {}), "none");
}

/// Position and speed of a mass, force held: the double integrator.
void give_mass(Block& block, double h) {
  block.size("NX", 2);
  block.set<64>("A", {1, h, 0, 1});
  block.set<32>("B", {h * h / 2, h});
  block.set<32>("C", {1, 0});
}

// Deadbeat control of the double integrator, K = [1 / h^2, 3 / (2 h)] (Franklin, Powell, Workman, "Digital Control of
// Dynamic Systems"; both poles at 0): from anywhere it is at rest on the set-point after two samples, exactly.
TEST(StateFeedback, DeadbeatIsThereAfterTwoSamples) {
  const double h = 0.1;
  Block law("STATE_FEEDBACK", milliseconds(100));
  law.size("NX", 2);
  law.size("NR", 1);
  law.set<32>("K", {1 / (h * h), 1.5 / h});
  law.set<16>("N", {1 / (h * h)});
  law["R1"] = 5;
  double p = 3;
  double v = -1;
  for (int k = 0; k < 10; ++k) {
    law.set<8>("X", {p, v});
    law.fire();
    const double u = law["U1"];
    p += h * v + h * h / 2 * u;
    v += h * u;
    if (k >= 1) {
      EXPECT_NEAR(p, 5, 1e-12);
      EXPECT_NEAR(v, 0, 1e-11);
    }
  }
}

TEST(StateFeedback, SizesLimitsAndBadInput) {
  Block law("STATE_FEEDBACK", milliseconds(1));
  law.size("NX", 3);
  law.size("NU", 2);
  law.size("NR", 2);
  law.set<32>("K", {1, 2, 3, 4, 5, 6});
  law.set<16>("N", {10, 20, 30, 40});
  law.set<4>("UMIN", {0, -5});
  law.set<4>("UMAX", {0, 5});
  law["R1"] = 1;
  law["R2"] = 2;
  law.set<8>("X", {0.1, 0.2, 0.3, kNan});
  law.fire();
  EXPECT_DOUBLE_EQ(law["U1"], 10 + 40 - 0.1 - 0.4 - 0.9);
  EXPECT_EQ(law["U2"], 5);
  EXPECT_FALSE(law.bad()) << "a state that is not in use";
  law["R1"] = kNan;
  law.fire();
  EXPECT_TRUE(law.bad());
  EXPECT_EQ(law["U2"], 5);
  law["R1"] = 0;
  law["R2"] = 0;
  law.fire();
  EXPECT_DOUBLE_EQ(law["U2"], -0.4 - 1 - 1.8);
  const auto refused = [](auto set) { return complaint("STATE_FEEDBACK", milliseconds(10), set); };
  EXPECT_EQ(refused([](Block&) {}), "none");
  EXPECT_EQ(refused([](Block& m) { m.size("NX", 9); }), "NX is 9, its range is 1 .. 8");
  EXPECT_EQ(refused([](Block& m) { m.size("NU", 0); }), "NU is 0, its range is 1 .. 4");
  EXPECT_EQ(refused([](Block& m) { m.size("NR", 5); }), "NR is 5, its range is 0 .. 4");
  EXPECT_EQ(refused([](Block& m) { m.set<32>("K", {kNan}); }), "a number in K is not finite");
  EXPECT_EQ(refused([](Block& m) { m.set<4>("UMIN", {kNan}); }), "a number in UMIN or UMAX is NaN");
}

// Both eigenvalues of (I - L C) A at 0: L = [1, 1 / h]. After the second sample the estimate is the state.
TEST(Observer, DeadbeatKnowsTheStateAfterTwoSamples) {
  const double h = 0.1;
  Block observer("OBSERVER", milliseconds(100));
  give_mass(observer, h);
  observer.set<32>("L", {1, 1 / h});
  observer["TS"] = 0.1;
  double p = 4;
  double v = -2;
  double u = 0;
  for (int k = 0; k < 30; ++k) {
    observer["U1"] = u;
    observer["Y1"] = p;
    observer.fire();
    EXPECT_NEAR(observer.x(0), p, 1e-12);
    if (k >= 1) {
      EXPECT_NEAR(observer.x(1), v, 1e-11) << k;
    }
    u = std::sin(k);
    p += h * v + h * h / 2 * u;
    v += h * u;
  }
}

// The error decays with (I - L C) A; one state: e' = (1 - l) a e.
TEST(Observer, TheErrorDecaysAsPlaced) {
  Block observer("OBSERVER", milliseconds(10));
  observer.set<64>("A", {0.9});
  observer.set<32>("B", {0.5});
  observer.set<32>("C", {2});
  observer.set<32>("L", {0.2});
  observer.set<8>("X0", {7});
  observer["U1"] = 1;
  double x = 1;
  for (int k = 0; k < 50; ++k) {
    observer["Y1"] = 2 * x;
    observer.fire();
    const double error = (1 - 0.2 * 2) * (7 - 1) * std::pow((1 - 0.2 * 2) * 0.9, k);
    EXPECT_NEAR(observer.x(0) - x, error, 1e-12) << k;
    x = 0.9 * x + 0.5;
  }
  // a measurement that is none: the model alone
  const double before = observer.x(0);
  observer["Y1"] = kNan;
  observer.fire();
  EXPECT_TRUE(observer.bad());
  EXPECT_NEAR(observer.x(0), 0.9 * before + 0.5, 1e-12);
  EXPECT_EQ((observer.port<std::array<double, 4>>("INNOVATION")[0]), 0);
  observer.port<bool>("RESET") = true;
  observer["Y1"] = 10;
  observer.fire();
  EXPECT_FALSE(observer.bad());
  EXPECT_DOUBLE_EQ(observer.x(0), 7 + 0.2 * (10 - 14));
  EXPECT_EQ(complaint("OBSERVER", milliseconds(1), [](Block& m) { m.set<32>("L", {kNan}); }),
            "a number in L is not finite");
  EXPECT_EQ(complaint("OBSERVER", milliseconds(1), [](Block& m) { m["TS"] = 1; }),
            "TS, the sample time of the matrices, is not the period of the task");
}

TEST(Models, FireAllocatesNothing) {
  for (const char* type : {"STATE_SPACE", "STATE_FEEDBACK", "OBSERVER"}) {
    Block block(type, milliseconds(1));
    block.size("NX", 8);
    block.size("NU", 4);
    block.size(std::string(type) == "STATE_FEEDBACK" ? "NR" : "NY", 4);
    block.ready();
    const std::size_t before = test::allocations();
    for (int i = 0; i < 10; ++i) block.fire();
    EXPECT_EQ(test::allocations(), before) << type;
  }
}

}  // namespace
}  // namespace plc::blocks
