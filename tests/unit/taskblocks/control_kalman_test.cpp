// KALMAN against recursions written by hand, closed forms of the steady state, and what noise really does.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <random>
#include <string>

#include "picard/testing.h"
#include "taskblocks/set.h"
#include "tests/support/count_allocations.h"

namespace plc::blocks {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

class Filter : public picard::Instance {
 public:
  explicit Filter(nanoseconds period = milliseconds(1)) : Instance(control_library(), "KALMAN", period) {}
  double& operator[](const char* name) { return port<double>(name); }
  void size(const char* name, std::int16_t value) { port<std::int16_t>(name) = value; }
  template <std::size_t Count>
  void set(const char* name, std::initializer_list<double> values) {
    std::copy(values.begin(), values.end(), port<std::array<double, Count>>(name).begin());
  }
  double x(std::size_t i = 0) { return port<std::array<double, 8>>("X")[i]; }
  double variance(std::size_t i = 0) { return port<std::array<double, 8>>("VARIANCE")[i]; }
  double innovation(std::size_t i = 0) { return port<std::array<double, 4>>("INNOVATION")[i]; }
  double innovation_variance(std::size_t i = 0) { return port<std::array<double, 4>>("INNOVATION_VARIANCE")[i]; }
  bool& valid(int i) { return port<bool>("VALID" + std::to_string(i)); }
  bool bad() { return port<bool>("BAD"); }
};

void give_scalar(Filter& filter, double a, double b, double c, double q, double r, double x0, double p0) {
  filter.size("NU", 1);
  filter.set<64>("A", {a});
  filter.set<32>("B", {b});
  filter.set<32>("C", {c});
  filter.set<64>("Q", {q});
  filter.set<16>("R", {r});
  filter.set<8>("X0", {x0});
  filter.set<64>("P0", {p0});
}

TEST(Kalman, ScalarRecursion) {
  const double a = 0.95;
  const double b = 0.3;
  const double c = 2;
  const double q = 0.01;
  const double r = 0.4;
  Filter filter;
  give_scalar(filter, a, b, c, q, r, 1.5, 2);
  double x = 1.5;
  double p = 2;
  for (int k = 0; k < 100; ++k) {
    const double u = std::sin(0.3 * k);
    const double y = std::cos(0.1 * k);
    filter["U1"] = u;
    filter["Y1"] = y;
    filter.fire();
    if (k > 0) {
      x = a * x + b * u;
      p = a * a * p + q;
    }
    const double s = c * c * p + r;
    const double gain = p * c / s;
    const double innovation = y - c * x;
    x += gain * innovation;
    p *= 1 - gain * c;
    ASSERT_NEAR(filter.x(), x, 1e-13) << k;
    ASSERT_NEAR(filter.variance(), p, 1e-13);
    ASSERT_NEAR(filter.innovation(), innovation, 1e-13);
    ASSERT_NEAR(filter.innovation_variance(), s, 1e-13);
    ASSERT_NEAR(filter["NIS"], innovation * innovation / s, 1e-12);
  }
  EXPECT_FALSE(filter.bad());
}

// A constant measured again and again: after n measurements the estimate is their mean, shrunk toward X0, its variance
// 1 / (1 / P0 + n / R) (Simon, "Optimal State Estimation", 2006, 3.3: recursive least squares).
TEST(Kalman, AConstantIsTheWeightedMean) {
  Filter filter;
  give_scalar(filter, 1, 0, 1, 0, 0.5, 3, 4);
  double sum = 0;
  for (int n = 1; n <= 50; ++n) {
    const double y = std::sin(n) + 10;
    sum += y;
    filter["Y1"] = y;
    filter.fire();
    const double information = 1 / 4.0 + n / 0.5;
    EXPECT_NEAR(filter.variance(), 1 / information, 1e-13);
    EXPECT_NEAR(filter.x(), (3 / 4.0 + sum / 0.5) / information, 1e-12);
  }
}

// A random walk seen with noise, Q = R = 1: the steady variance solves p^2 + p - 1 = 0, the golden ratio
// (sqrt(5) - 1) / 2; it is the gain too.
TEST(Kalman, TheRandomWalkEndsAtTheGoldenRatio) {
  Filter filter;
  give_scalar(filter, 1, 0, 1, 1, 1, 0, 100);
  for (int k = 0; k < 50; ++k) filter.fire();
  const double golden = (std::sqrt(5) - 1) / 2;
  EXPECT_NEAR(filter.variance(), golden, 1e-14);
  EXPECT_NEAR(filter.innovation_variance(), golden + 2, 1e-14);
  const double before = filter.x();
  filter["Y1"] = 1;
  filter.fire();
  EXPECT_NEAR(filter.x() - before, golden * (1 - before), 1e-14);
}

// Position and speed, the acceleration is white noise: the steady gains of the alpha-beta filter as Kalata gives them
// ("The tracking index", IEEE Trans. AES 20, 1984), from the index L = sigma_w h^2 / sigma_v:
// r = (4 + L - sqrt(8 L + L^2)) / 4, alpha = 1 - r^2, beta = 2 (2 - alpha) - 4 sqrt(1 - alpha).
TEST(Kalman, SteadyGainsOfTheAlphaBetaFilter) {
  const double h = 0.1;
  const double w = 3;
  const double v = 0.05;
  Filter filter(milliseconds(100));
  filter.size("NX", 2);
  filter["TS"] = h;
  filter.set<64>("A", {1, h, 0, 1});
  filter.set<32>("C", {1, 0});
  filter.set<64>("Q", {w * w * h * h * h * h / 4, w * w * h * h * h / 2, w * w * h * h * h / 2, w * w * h * h});
  filter.set<16>("R", {v * v});
  filter.set<64>("P0", {1, 0, 0, 1});
  for (int k = 0; k < 500; ++k) filter.fire();
  const double index = w * h * h / v;
  const double r = (4 + index - std::sqrt(8 * index + index * index)) / 4;
  const double alpha = 1 - r * r;
  const double beta = 2 * (2 - alpha) - 4 * std::sqrt(1 - alpha);
  EXPECT_NEAR(filter.variance(0), alpha * v * v, 1e-12) << "p = alpha R";
  const double position = filter.x(0) + h * filter.x(1);
  const double speed = filter.x(1);
  filter["Y1"] = position + 1;
  filter.fire();
  EXPECT_NEAR(filter.innovation(), 1, 1e-12);
  EXPECT_NEAR(filter.x(0) - position, alpha, 1e-10);
  EXPECT_NEAR(filter.x(1) - speed, beta / h, 1e-9);
}

/// Two states, two measurements with correlated noise, one input; written out without a matrix library.
struct Reference {
  double a[2][2] = {{0.9, 0.2}, {-0.1, 0.8}};
  double b[2] = {0.5, 1};
  double c[2][2] = {{1, 0.5}, {0.2, 2}};
  double q[2][2] = {{0.2, 0.05}, {0.05, 0.1}};
  double r[2][2] = {{0.3, 0.1}, {0.1, 0.6}};
  double x[2] = {1, -1};
  double p[2][2] = {{3, 0.5}, {0.5, 2}};
  double nis = 0;

  void predict(double u) {
    const double x0 = a[0][0] * x[0] + a[0][1] * x[1] + b[0] * u;
    const double x1 = a[1][0] * x[0] + a[1][1] * x[1] + b[1] * u;
    x[0] = x0;
    x[1] = x1;
    double next[2][2];
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) {
        next[i][j] = q[i][j];
        for (int k = 0; k < 2; ++k) {
          for (int l = 0; l < 2; ++l) next[i][j] += a[i][k] * p[k][l] * a[j][l];
        }
      }
    }
    std::copy(&next[0][0], &next[0][0] + 4, &p[0][0]);
  }
  /// Both measurements; the short form P - K S K'.
  void correct(const double (&y)[2]) {
    double s[2][2];
    double pc[2][2];  // P C'
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) pc[i][j] = p[i][0] * c[j][0] + p[i][1] * c[j][1];
    }
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) s[i][j] = c[i][0] * pc[0][j] + c[i][1] * pc[1][j] + r[i][j];
    }
    const double det = s[0][0] * s[1][1] - s[0][1] * s[1][0];
    const double inverse[2][2] = {{s[1][1] / det, -s[0][1] / det}, {-s[1][0] / det, s[0][0] / det}};
    const double e[2] = {y[0] - c[0][0] * x[0] - c[0][1] * x[1], y[1] - c[1][0] * x[0] - c[1][1] * x[1]};
    double gain[2][2];
    nis = 0;
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) {
        gain[i][j] = pc[i][0] * inverse[0][j] + pc[i][1] * inverse[1][j];
        nis += e[i] * inverse[i][j] * e[j];
      }
    }
    for (int i = 0; i < 2; ++i) {
      x[i] += gain[i][0] * e[0] + gain[i][1] * e[1];
      for (int j = 0; j < 2; ++j) p[i][j] -= gain[i][0] * pc[j][0] + gain[i][1] * pc[j][1];
    }
  }
  /// Measurement `m` alone.
  void correct_one(int m, double y) {
    const double pc[2] = {p[0][0] * c[m][0] + p[0][1] * c[m][1], p[1][0] * c[m][0] + p[1][1] * c[m][1]};
    const double s = c[m][0] * pc[0] + c[m][1] * pc[1] + r[m][m];
    const double e = y - c[m][0] * x[0] - c[m][1] * x[1];
    nis = e * e / s;
    for (int i = 0; i < 2; ++i) {
      x[i] += pc[i] / s * e;
      for (int j = 0; j < 2; ++j) p[i][j] -= pc[i] * pc[j] / s;
    }
  }
};

TEST(Kalman, TwoStatesTwoMeasurementsSomeInvalid) {
  Filter filter;
  filter.size("NX", 2);
  filter.size("NY", 2);
  filter.size("NU", 1);
  filter.set<64>("A", {0.9, 0.2, -0.1, 0.8});
  filter.set<32>("B", {0.5, 1});
  filter.set<32>("C", {1, 0.5, 0.2, 2});
  filter.set<64>("Q", {0.2, 0.05, 0.05, 0.1});
  filter.set<16>("R", {0.3, 0.1, 0.1, 0.6});
  filter.set<8>("X0", {1, -1});
  filter.set<64>("P0", {3, 0.5, 0.5, 2});
  Reference reference;
  for (int k = 0; k < 200; ++k) {
    const double u = std::sin(0.2 * k);
    const double y[2] = {std::cos(0.7 * k), 3 * std::sin(0.4 * k)};
    filter["U1"] = u;
    filter["Y1"] = y[0];
    filter["Y2"] = y[1];
    filter.valid(1) = k % 5 != 1;
    filter.valid(2) = k % 3 != 1;
    const bool broken = k % 7 == 3;  // says so by NaN, not by VALID
    if (broken) filter["Y2"] = kNan;
    filter.fire();
    const bool first = filter.valid(1);
    const bool second = filter.valid(2) && !broken;
    if (k > 0) reference.predict(u);
    if (first && second) {
      reference.correct(y);
    } else if (first || second) {
      reference.correct_one(first ? 0 : 1, first ? y[0] : y[1]);
    } else {
      reference.nis = 0;
      EXPECT_EQ(filter.innovation(0), 0);
      EXPECT_EQ(filter.innovation_variance(0), 0);
    }
    for (std::size_t i = 0; i < 2; ++i) {
      ASSERT_NEAR(filter.x(i), reference.x[i], 1e-12) << k;
      ASSERT_NEAR(filter.variance(i), reference.p[i][i], 1e-12) << k;
    }
    ASSERT_NEAR(filter["NIS"], reference.nis, 1e-11) << k;
    EXPECT_EQ(filter.bad(), filter.valid(2) && broken);
  }
}

// What the filter says of itself against what it does: the squared error of the estimate in the mean is VARIANCE, NIS
// in the mean the number of measurements.
TEST(Kalman, TheVarianceIsThatOfTheError) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  Filter filter;
  give_scalar(filter, 0.9, 0, 1, 0.25, 1, 0, 1);
  double x = normal(random);
  double error = 0;
  double nis = 0;
  constexpr int kSamples = 200000;
  for (int k = 0; k < kSamples; ++k) {
    filter["Y1"] = x + normal(random);
    filter.fire();
    error += (filter.x() - x) * (filter.x() - x);
    nis += filter["NIS"];
    x = 0.9 * x + 0.5 * normal(random);
  }
  EXPECT_NEAR(error / kSamples, filter.variance(), 0.02 * filter.variance());
  EXPECT_NEAR(nis / kSamples, 1, 0.02);
}

// Without noise of the process the filter fits a parabola to all measurements there are: the variance of its end after
// n of them is R (9 n^2 - 9 n + 6) / (n (n + 1) (n + 2)) (Brookner, "Tracking and Kalman Filtering Made Easy", 1998,
// ch. 7), whatever little was known at first: P0 is 12 orders of magnitude above R.
TEST(Kalman, AParabolaIsFittedFromNothing) {
  Filter filter;
  filter.size("NX", 3);
  filter.set<64>("A", {1, 1, 0.5, 0, 1, 1, 0, 0, 1});
  filter.set<32>("C", {1, 0, 0});
  filter.set<16>("R", {1e-6});
  filter.set<64>("P0", {1e6, 0, 0, 0, 1e6, 0, 0, 0, 1e6});
  for (int n = 1; n <= 1000; ++n) {
    filter["Y1"] = 3 - 2.0 * n + 0.5 * n * n;
    filter.fire();
    for (std::size_t i = 0; i < 3; ++i) ASSERT_GT(filter.variance(i), 0) << n;
    if (n < 3) continue;
    const double expected = 1e-6 * (9.0 * n * n - 9.0 * n + 6) / (n * (n + 1.0) * (n + 2.0));
    ASSERT_NEAR(filter.variance(0), expected, 1e-3 * expected) << n;
    ASSERT_NEAR(filter.x(0), filter["Y1"], 1e-3) << n;
  }
  EXPECT_NEAR(filter.x(1), -2 + 1000, 1e-6);
  EXPECT_NEAR(filter.x(2), 1, 1e-8);
}

TEST(Kalman, ResetAndNumbersThatAreNone) {
  Filter filter;
  give_scalar(filter, 1, 1, 1, 0.1, 1, 5, 2);
  filter["Y1"] = 5;
  filter.fire();
  const double variance = filter.variance();
  EXPECT_EQ(filter.x(), 5);
  filter["U1"] = 2;
  filter.valid(1) = false;
  filter.fire();
  EXPECT_EQ(filter.x(), 7);
  EXPECT_NEAR(filter.variance(), variance + 0.1, 1e-15);
  EXPECT_FALSE(filter.bad());
  filter["U1"] = kNan;
  filter.fire();
  EXPECT_EQ(filter.x(), 9);
  EXPECT_TRUE(filter.bad());
  filter["U1"] = 0;
  filter["Y1"] = kNan;
  filter.fire();
  EXPECT_FALSE(filter.bad()) << "nobody asked for that measurement";
  filter.valid(1) = true;
  filter["Y1"] = 5;
  filter.port<bool>("RESET") = true;
  for (int i = 0; i < 3; ++i) {
    filter.fire();
    EXPECT_EQ(filter.x(), 5);
    EXPECT_EQ(filter.variance(), variance);
  }
}

TEST(Kalman, WhatCannotBeEstimatedStaysFinite) {
  Filter filter;
  give_scalar(filter, 1e30, 0, 0, 0, 1, 1, 1);
  for (int i = 0; i < 100; ++i) {
    filter.fire();
    ASSERT_TRUE(std::isfinite(filter.x()));
    ASSERT_TRUE(std::isfinite(filter.variance()));
  }
  EXPECT_TRUE(filter.bad());
  filter.port<bool>("RESET") = true;
  filter.fire();
  EXPECT_FALSE(filter.bad());
  EXPECT_EQ(filter.x(), 1);
}

TEST(Kalman, ConfigurationIsChecked) {
  const auto refused = [](auto set, nanoseconds period = milliseconds(10)) -> std::string {
    Filter filter(period);
    filter.set<16>("R", {1});
    set(filter);
    try {
      filter.ready();
    } catch (const std::exception& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_EQ(refused([](Filter&) {}), "none");
  EXPECT_EQ(refused([](Filter& f) { f.size("NX", 9); }), "NX is 9, its range is 1 .. 8");
  EXPECT_EQ(refused([](Filter& f) { f.size("NU", 5); }), "NU is 5, its range is 0 .. 4");
  EXPECT_EQ(refused([](Filter& f) { f.size("NY", 0); }), "NY is 0, its range is 1 .. 4");
  EXPECT_EQ(refused([](Filter& f) { f.set<32>("C", {kNan}); }), "a number in C is not finite");
  const char* const r = "R is not symmetric and positive definite";
  EXPECT_EQ(refused([](Filter& f) { f.set<16>("R", {0}); }), r);
  EXPECT_EQ(refused([](Filter& f) { f.set<16>("R", {-1}); }), r);
  EXPECT_EQ(refused([](Filter& f) { f.size("NY", 2); }), r) << "R22 is 0";
  const char* const q = "Q is not symmetric and positive semidefinite";
  const auto with_q = [&](std::initializer_list<double> values) {
    return refused([&](Filter& f) {
      f.size("NX", 2);
      f.set<64>("Q", values);
    });
  };
  EXPECT_EQ(with_q({1, 0.5, 0, 1}), q);
  EXPECT_EQ(with_q({1, 2, 2, 1}), q);
  EXPECT_EQ(with_q({0, 1, 1, 0}), q);
  EXPECT_EQ(with_q({1e-6, 2e-6, 2e-6, 4e-6}), "none") << "noise of one source is semidefinite";
  EXPECT_EQ(refused([](Filter& f) { f.set<64>("P0", {-1}); }), "P0 is not symmetric and positive semidefinite");
  EXPECT_EQ(refused([](Filter& f) { f["TS"] = 0.011; }),
            "TS, the sample time of the matrices, is not the period of the task");
  EXPECT_EQ(refused([](Filter& f) { f["TS"] = 0.01; }, nanoseconds(0)),
            "TS is given, but the task has no period: its executions are no samples");
}

TEST(Kalman, FireAllocatesNothing) {
  Filter filter;
  filter.size("NX", 8);
  filter.size("NU", 4);
  filter.size("NY", 4);
  for (std::size_t i = 0; i < 8; ++i) {
    for (const char* name : {"A", "Q", "P0"}) filter.port<std::array<double, 64>>(name)[9 * i] = 1;
  }
  for (std::size_t i = 0; i < 4; ++i) {
    filter.port<std::array<double, 16>>("R")[5 * i] = 1;
    filter.port<std::array<double, 32>>("C")[9 * i] = 1;
  }
  filter.ready();
  const std::size_t before = test::allocations();
  for (int i = 0; i < 10; ++i) filter.fire();
  EXPECT_EQ(test::allocations(), before);
  EXPECT_FALSE(filter.bad());
  EXPECT_GT(filter.variance(7), 8) << "not measured";
  EXPECT_LT(filter.variance(3), 1);
}

}  // namespace
}  // namespace plc::blocks
