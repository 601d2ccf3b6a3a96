// Filters against closed forms of their responses. The amplitude of a filtered sine is taken from its projection on
// sine and cosine over whole periods, so a test at one frequency knows nothing of how the filter is computed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "picard/testing.h"
#include "taskblocks/set.h"
#include "tests/support/count_allocations.h"

namespace plc::blocks {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::numbers::pi;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double out(picard::Instance& block) { return block.port<double>("OUT"); }

double fire(picard::Instance& block, double in) {
  block.port<double>("IN") = in;
  block.fire();
  return out(block);
}

/// What a settled block makes of a sine: `per_period` samples a period.
std::complex<double> response(picard::Instance& block, int per_period, int settle_periods) {
  std::complex<double> sum = 0;
  for (int i = 0; i < settle_periods * per_period; ++i) fire(block, std::sin(2 * pi * i / per_period));
  for (int i = 0; i < 10 * per_period; ++i) {
    const double angle = 2 * pi * (i % per_period) / per_period;
    sum += fire(block, std::sin(angle)) * std::polar(1.0, -angle);
  }
  return sum * std::complex<double>(0, 2) / (10.0 * per_period);
}

void expect_no_allocation(picard::Instance& block) {
  block.ready();
  const std::size_t before = test::allocations();
  for (int i = 0; i < 100; ++i) fire(block, i);
  EXPECT_EQ(test::allocations(), before);
}

// ---- LOWPASS

TEST(LowPass, FollowsAStepLikeTheExponential) {
  picard::Instance filter(filters_library(), "LOWPASS", milliseconds(10));
  filter.port<double>("CUTOFF") = 2.0;
  filter.fire();
  filter.port<double>("IN") = 1.0;
  for (int i = 1; i <= 100; ++i) {
    filter.fire();
    const double time = i * 0.01;
    EXPECT_NEAR(filter.port<double>("OUT"), 1 - std::exp(-2 * M_PI * 2.0 * time), 1e-12) << i;
  }
}

TEST(LowPass, StartsAtTheFirstNumberAndHoldsWhileThereIsNone) {
  picard::Instance filter(filters_library(), "LOWPASS", milliseconds(10));
  EXPECT_EQ(fire(filter, kNan), 0);
  EXPECT_EQ(fire(filter, 5), 5);
  EXPECT_EQ(fire(filter, kNan), 5);
  EXPECT_EQ(fire(filter, -kInfinity), 5);
  EXPECT_EQ(fire(filter, 5), 5);
}

TEST(LowPass, LimitsOfTheCutoff) {
  picard::Instance filter(filters_library(), "LOWPASS", milliseconds(10));
  fire(filter, 1);
  for (const double none : {0.0, -5.0, kNan}) {
    filter.port<double>("CUTOFF") = none;
    EXPECT_EQ(fire(filter, 100), 1) << none;
  }
  filter.port<double>("CUTOFF") = kInfinity;
  EXPECT_EQ(fire(filter, 2), 2);
}

TEST(LowPass, FollowsByTheCutoffOfTheMoment) {
  picard::Instance filter(filters_library(), "LOWPASS", milliseconds(10));
  fire(filter, 0);
  double left = 1;
  for (const double cutoff : {2.0, 2.0, 5.0, 0.5, 0.0, 2.0}) {
    filter.port<double>("CUTOFF") = cutoff;
    left *= std::exp(-2 * pi * cutoff * 0.01);
    EXPECT_NEAR(fire(filter, 1), 1 - left, 1e-15) << cutoff;
  }
}

TEST(LowPass, DoesNothingWhenNoTimePassed) {
  picard::Instance filter(filters_library(), "LOWPASS", milliseconds(0));
  filter.port<double>("CUTOFF") = kInfinity;
  fire(filter, 1);
  EXPECT_EQ(fire(filter, 100), 1);
}

TEST(LowPass, DoesNotAllocate) {
  picard::Instance filter(filters_library(), "LOWPASS", milliseconds(10));
  expect_no_allocation(filter);
}

// ---- LOWPASS2

/// |H| of the Butterworth filter of order 2 after the bilinear transform with prewarping: in Oppenheim, Schafer,
/// Discrete-Time Signal Processing, section 7.1.2: 1 / sqrt(1 + (tan(w / 2) / tan(wc / 2))^4).
double butterworth(double turns, double cutoff_turns) {
  return 1 / std::sqrt(1 + std::pow(std::tan(pi * turns) / std::tan(pi * cutoff_turns), 4));
}

TEST(LowPass2, HasTheMagnitudeOfButterworth) {
  for (const double cutoff : {10.0, 50.0, 200.0, 450.0}) {
    for (const int per_period : {4, 5, 10, 20, 40, 100, 200}) {
      picard::Instance filter(filters_library(), "LOWPASS2", milliseconds(1));
      filter.port<double>("CUTOFF") = cutoff;
      EXPECT_NEAR(std::abs(response(filter, per_period, 2000 / per_period + 20)),
                  butterworth(1.0 / per_period, cutoff * 1e-3), 1e-9)
          << cutoff << " Hz, 1/" << per_period;
    }
  }
}

TEST(LowPass2, DampsTheCutoffBy3DecibelsWithAQuarterTurn) {
  picard::Instance filter(filters_library(), "LOWPASS2", milliseconds(1));
  filter.port<double>("CUTOFF") = 50;
  const std::complex<double> there = response(filter, 20, 100);
  EXPECT_NEAR(std::abs(there), std::sqrt(0.5), 1e-9);
  EXPECT_NEAR(std::arg(there), -pi / 2, 1e-9);
}

TEST(LowPass2, FollowsAStepLikeTheAnalogueFilter) {
  // 1 - e^-x (cos x + sin x) with x = w t / sqrt(2); it overshoots by e^-pi.
  picard::Instance filter(filters_library(), "LOWPASS2", microseconds(100));
  filter.port<double>("CUTOFF") = 5;
  fire(filter, 0);
  double highest = 0;
  for (int i = 1; i <= 5000; ++i) {
    const double x = 2 * pi * 5 * (i - 0.5) * 1e-4 / std::sqrt(2.0);  // the trapezoidal rule steps within the interval
    highest = std::max(highest, fire(filter, 1));
    EXPECT_NEAR(out(filter), 1 - std::exp(-x) * (std::cos(x) + std::sin(x)), 2e-5) << i;
  }
  EXPECT_NEAR(highest, 1 + std::exp(-pi), 1e-5);
}

TEST(LowPass2, StartsSettledAndHoldsWhileThereIsNoNumber) {
  picard::Instance filter(filters_library(), "LOWPASS2", milliseconds(1));
  EXPECT_EQ(fire(filter, kNan), 0);
  for (int i = 0; i < 10; ++i) EXPECT_DOUBLE_EQ(fire(filter, 7), 7);
  EXPECT_DOUBLE_EQ(fire(filter, kNan), 7);
  EXPECT_DOUBLE_EQ(fire(filter, kInfinity), 7);
  EXPECT_DOUBLE_EQ(fire(filter, 7), 7);
}

TEST(LowPass2, LimitsOfTheCutoff) {
  picard::Instance filter(filters_library(), "LOWPASS2", milliseconds(1));
  filter.port<double>("CUTOFF") = 10;
  fire(filter, 1);
  for (const double none : {0.0, -5.0, kNan}) {
    filter.port<double>("CUTOFF") = none;
    EXPECT_EQ(fire(filter, 100), 1) << none;
  }
  for (const double all : {500.0, 1e9, kInfinity}) {
    filter.port<double>("CUTOFF") = all;
    EXPECT_EQ(fire(filter, all == kInfinity ? 3 : 2), all == kInfinity ? 3 : 2) << all;
  }
  filter.port<double>("CUTOFF") = 10;
  EXPECT_NEAR(fire(filter, 3), 3, 1e-12);
}

TEST(LowPass2, DoesNotJumpWhenItIsTuned) {
  picard::Instance filter(filters_library(), "LOWPASS2", milliseconds(1));
  filter.port<double>("CUTOFF") = 1;
  fire(filter, 0);
  for (int i = 0; i < 100; ++i) fire(filter, 1);
  const double before = out(filter);
  const double slope = fire(filter, 1) - before;
  filter.port<double>("CUTOFF") = 2;
  const double after = out(filter);
  EXPECT_NEAR(fire(filter, 1) - after, slope, 2 * slope);
}

TEST(LowPass2, DoesNothingWhenNoTimePassed) {
  picard::Instance filter(filters_library(), "LOWPASS2", milliseconds(0));
  fire(filter, 1);
  EXPECT_EQ(fire(filter, 100), 1);
}

TEST(LowPass2, DoesNotAllocate) {
  picard::Instance filter(filters_library(), "LOWPASS2", milliseconds(1));
  expect_no_allocation(filter);
}

// ---- NOTCH

picard::Instance& tuned(picard::Instance& notch, double frequency, double width) {
  notch.port<double>("FREQUENCY") = frequency;
  notch.port<double>("WIDTH") = width;
  return notch;
}

TEST(Notch, LeavesNothingOfItsFrequency) {
  for (const int per_period : {4, 5, 20, 100}) {
    picard::Instance notch(filters_library(), "NOTCH", milliseconds(1));
    tuned(notch, 1000.0 / per_period, 10);
    EXPECT_LT(std::abs(response(notch, per_period, 2000 / per_period)), 1e-9) << per_period;
  }
}

TEST(Notch, HasTheMagnitudeOfTheTextbook) {
  // R. Bristow-Johnson, Cookbook formulae for audio EQ biquad filter coefficients: notch with the bandwidth in Hz as
  // the digital one, alpha = tan(pi WIDTH dt).
  const double centre = 60;
  const double width = 20;
  const double alpha = std::tan(pi * width * 1e-3);
  const double w0 = 2 * pi * centre * 1e-3;
  for (const int per_period : {4, 8, 10, 16, 20, 25, 50, 100}) {
    picard::Instance notch(filters_library(), "NOTCH", milliseconds(1));
    tuned(notch, centre, width);
    const std::complex<double> z1 = std::polar(1.0, -2 * pi / per_period);
    const std::complex<double> expected =
        (1.0 - 2 * std::cos(w0) * z1 + z1 * z1) / ((1 + alpha) - 2 * std::cos(w0) * z1 + (1 - alpha) * z1 * z1);
    const std::complex<double> found = response(notch, per_period, 1000 / per_period);
    EXPECT_NEAR(std::abs(found - expected), 0, 1e-9) << per_period;
  }
}

TEST(Notch, TheEdgesAreWidthApartAndDampedBy3Decibels) {
  // Edges 100 and 125 Hz at 1 kHz; their centre in the transform is sqrt(tan(pi / 10) tan(pi / 8)).
  const double centre = std::atan(std::sqrt(std::tan(pi / 10) * std::tan(pi / 8))) / pi * 1000;
  for (const int per_period : {8, 10}) {
    picard::Instance notch(filters_library(), "NOTCH", milliseconds(1));
    tuned(notch, centre, 25);
    EXPECT_NEAR(std::abs(response(notch, per_period, 200)), std::sqrt(0.5), 1e-9) << per_period;
  }
}

TEST(Notch, PassesConstantsAndStartsSettled) {
  picard::Instance notch(filters_library(), "NOTCH", milliseconds(1));
  EXPECT_EQ(fire(notch, kNan), 0);
  for (int i = 0; i < 10; ++i) EXPECT_DOUBLE_EQ(fire(notch, -3), -3);
  EXPECT_DOUBLE_EQ(fire(notch, kNan), -3);
  EXPECT_DOUBLE_EQ(fire(notch, -3), -3);
}

TEST(Notch, OutsideOfItsLimitsPassesAll) {
  for (const auto& [frequency, width] : std::vector<std::pair<double, double>>{
           {0, 5}, {-50, 5}, {kNan, 5}, {500, 5}, {kInfinity, 5}, {50, 0}, {50, -1}, {50, kNan}, {50, 500}}) {
    picard::Instance notch(filters_library(), "NOTCH", milliseconds(1));
    tuned(notch, frequency, width);
    fire(notch, 0);
    EXPECT_EQ(fire(notch, 10), 10) << frequency << ' ' << width;
    EXPECT_EQ(fire(notch, -4), -4) << frequency << ' ' << width;
  }
}

TEST(Notch, DoesNotAllocate) {
  picard::Instance notch(filters_library(), "NOTCH", milliseconds(1));
  expect_no_allocation(notch);
}

// ---- BIQUAD

struct Coefficients {
  double b0, b1, b2, a1, a2;
};

void give(picard::Instance& biquad, const Coefficients& c) {
  biquad.port<double>("B0") = c.b0;
  biquad.port<double>("B1") = c.b1;
  biquad.port<double>("B2") = c.b2;
  biquad.port<double>("A1") = c.a1;
  biquad.port<double>("A2") = c.a2;
}

TEST(Biquad, IsTheDifferenceEquation) {
  const Coefficients c{0.3, -0.2, 0.7, -0.9, 0.5};
  picard::Instance biquad(filters_library(), "BIQUAD", milliseconds(1));
  give(biquad, c);
  fire(biquad, 0);
  double x1 = 0, x2 = 0, y1 = 0, y2 = 0;
  for (int i = 0; i < 1000; ++i) {
    const double x = std::sin(0.1 * i * i) + (i % 7);
    const double y = c.b0 * x + c.b1 * x1 + c.b2 * x2 - c.a1 * y1 - c.a2 * y2;
    EXPECT_NEAR(fire(biquad, x), y, 1e-12) << i;
    x2 = x1;
    x1 = x;
    y2 = y1;
    y1 = y;
  }
}

TEST(Biquad, AnswersAnImpulseWithADoublePoleLikeTheClosedForm) {
  // 1 / (1 - p z^-1)^2: (n + 1) p^n.
  const double p = 0.8;
  picard::Instance biquad(filters_library(), "BIQUAD", milliseconds(1));
  give(biquad, {1, 0, 0, -2 * p, p * p});
  fire(biquad, 0);
  for (int n = 0; n < 60; ++n) EXPECT_NEAR(fire(biquad, n == 0 ? 1 : 0), (n + 1) * std::pow(p, n), 1e-12);
  EXPECT_TRUE(biquad.port<bool>("STABLE"));
}

TEST(Biquad, WithTheCoefficientsOfADesignToolIsThatFilter) {
  // butter(2, 0.5): corner at a quarter of the rate; b = (1 2 1) / (2 + sqrt 2), a2 = (2 - sqrt 2) / (2 + sqrt 2).
  const double scale = 1 / (2 + std::sqrt(2.0));
  picard::Instance biquad(filters_library(), "BIQUAD", milliseconds(1));
  give(biquad, {scale, 2 * scale, scale, 0, (2 - std::sqrt(2.0)) * scale});
  EXPECT_NEAR(std::abs(response(biquad, 4, 100)), std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(std::abs(response(biquad, 10, 100)), butterworth(0.1, 0.25), 1e-12);
}

TEST(Biquad, StartsInTheStateOfAConstantInput) {
  picard::Instance biquad(filters_library(), "BIQUAD", milliseconds(1));
  give(biquad, {0.2, 0.1, 0.1, -0.5, 0.3});
  EXPECT_EQ(fire(biquad, kNan), 0);
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(fire(biquad, 10), 10 * 0.4 / 0.8, 1e-14);
  fire(biquad, 90);
  biquad.port<bool>("RESET") = true;
  EXPECT_NEAR(fire(biquad, 20), 10, 1e-14);
}

TEST(Biquad, AnIntegratorStartsAtRest) {
  picard::Instance biquad(filters_library(), "BIQUAD", milliseconds(1));
  give(biquad, {1, 0, 0, -1, 0});
  for (int i = 1; i <= 5; ++i) EXPECT_EQ(fire(biquad, 2), 2 * i);
  EXPECT_FALSE(biquad.port<bool>("STABLE"));
}

TEST(Biquad, TellsAStableFilterByItsPoles) {
  for (double a1 = -2.55; a1 < 2.6; a1 += 0.1) {
    for (double a2 = -1.55; a2 < 1.6; a2 += 0.1) {
      const std::complex<double> root = std::sqrt(std::complex<double>(a1 * a1 - 4 * a2));
      const bool inside = std::abs((-a1 + root) / 2.0) < 1 && std::abs((-a1 - root) / 2.0) < 1;
      picard::Instance biquad(filters_library(), "BIQUAD", milliseconds(1));
      give(biquad, {1, 0, 0, a1, a2});
      biquad.fire();
      EXPECT_EQ(biquad.port<bool>("STABLE"), inside) << a1 << ' ' << a2;
    }
  }
}

TEST(Biquad, ComesBackFromBadNumbers) {
  picard::Instance biquad(filters_library(), "BIQUAD", milliseconds(1));
  give(biquad, {1, 0, 0, -3, 0});
  for (int i = 0; i < 2000; ++i) EXPECT_TRUE(std::isfinite(fire(biquad, 1))) << i;
  give(biquad, {0.5, 0, 0, -0.5, 0});
  biquad.port<bool>("RESET") = true;
  EXPECT_EQ(fire(biquad, 4), 4);
  biquad.port<bool>("RESET") = false;
  EXPECT_EQ(fire(biquad, kNan), 4);
  give(biquad, {0.5, 0, kNan, -0.5, 0});
  EXPECT_EQ(fire(biquad, 8), 4);
  give(biquad, {0.5, 0, 0, -0.5, 0});
  EXPECT_EQ(fire(biquad, 8), 6);
}

TEST(Biquad, DoesNotAllocate) {
  picard::Instance biquad(filters_library(), "BIQUAD", milliseconds(1));
  expect_no_allocation(biquad);
}

// ---- MOVING_STATISTICS

/// The definitions, in long double, over the last samples.
void expect_definitions(picard::Instance& statistics, const std::vector<double>& samples, std::size_t window,
                        double tolerance) {
  const std::size_t n = std::min(window, samples.size());
  const std::vector<double> last(samples.end() - static_cast<std::ptrdiff_t>(n), samples.end());
  long double sum = 0, squares = 0, distances = 0;
  for (const double x : last) {
    sum += x;
    squares += static_cast<long double>(x) * x;
  }
  const long double mean = sum / static_cast<long double>(n);
  for (const double x : last) distances += (x - mean) * (x - mean);
  EXPECT_EQ(statistics.port<std::int32_t>("COUNT"), static_cast<std::int32_t>(n));
  EXPECT_NEAR(statistics.port<double>("MEAN"), static_cast<double>(mean), tolerance);
  EXPECT_NEAR(statistics.port<double>("RMS"), static_cast<double>(std::sqrt(squares / static_cast<long double>(n))),
              tolerance);
  EXPECT_NEAR(statistics.port<double>("DEVIATION"),
              n > 1 ? static_cast<double>(std::sqrt(distances / static_cast<long double>(n - 1))) : 0, tolerance);
  EXPECT_EQ(statistics.port<double>("LOWEST"), *std::min_element(last.begin(), last.end()));
  EXPECT_EQ(statistics.port<double>("HIGHEST"), *std::max_element(last.begin(), last.end()));
}

void take(picard::Instance& statistics, double sample) {
  statistics.port<double>("IN") = sample;
  statistics.fire();
}

TEST(MovingStatistics, AreTheDefinitionsForEverySizeOfTheWindow) {
  for (const std::int32_t window : {1, 2, 3, 7, 8, 100, 1000, 1024}) {
    picard::Instance statistics(filters_library(), "MOVING_STATISTICS", milliseconds(1));
    statistics.port<std::int32_t>("WINDOW") = window;
    std::vector<double> samples;
    for (int i = 0; i < 2500; ++i) {
      samples.push_back(10 * std::sin(0.7 * i * i) + 0.01 * i);
      take(statistics, samples.back());
      if (i < 20 || i % 37 == 0) expect_definitions(statistics, samples, static_cast<std::size_t>(window), 1e-12);
    }
  }
}

TEST(MovingStatistics, LeaveNothingBehindOfALargeSample) {
  picard::Instance statistics(filters_library(), "MOVING_STATISTICS", milliseconds(1));
  statistics.port<std::int32_t>("WINDOW") = 4;
  take(statistics, 1e15);
  for (const double x : {1.0, 2.0, 3.0, 4.0}) take(statistics, x);
  EXPECT_EQ(statistics.port<double>("MEAN"), 2.5);
  EXPECT_DOUBLE_EQ(statistics.port<double>("DEVIATION"), std::sqrt(5.0 / 3));
  EXPECT_DOUBLE_EQ(statistics.port<double>("RMS"), std::sqrt(7.5));
}

TEST(MovingStatistics, DoNotCancelAtALargeMean) {
  // NIST StRD, univariate summary statistics, data set NumAcc4: 10000000.2 once, then 10000000.1 and 10000000.3 in
  // turn; mean 10000000.2, standard deviation 0.1.
  picard::Instance statistics(filters_library(), "MOVING_STATISTICS", milliseconds(1));
  statistics.port<std::int32_t>("WINDOW") = 1001;
  take(statistics, 10000000.2);
  for (int i = 0; i < 500; ++i) {
    take(statistics, 10000000.1);
    take(statistics, 10000000.3);
  }
  EXPECT_DOUBLE_EQ(statistics.port<double>("MEAN"), 10000000.2);
  EXPECT_NEAR(statistics.port<double>("DEVIATION"), 0.1, 1e-9);
}

TEST(MovingStatistics, DoNotDrift) {
  picard::Instance statistics(filters_library(), "MOVING_STATISTICS", milliseconds(1));
  statistics.port<std::int32_t>("WINDOW") = 64;
  for (int i = 0; i < 1'000'000; ++i) take(statistics, 1e6 + std::sin(i) * 1e3);
  std::vector<double> samples;
  for (int i = 0; i < 64; ++i) {
    samples.push_back(0.1 * i);
    take(statistics, samples.back());
  }
  expect_definitions(statistics, samples, 64, 1e-14);
}

TEST(MovingStatistics, ForgetAndLeaveOut) {
  picard::Instance statistics(filters_library(), "MOVING_STATISTICS", milliseconds(1));
  statistics.port<std::int32_t>("WINDOW") = 10;
  take(statistics, kNan);
  EXPECT_EQ(statistics.port<std::int32_t>("COUNT"), 0);
  take(statistics, 3);
  take(statistics, kInfinity);
  EXPECT_EQ(statistics.port<std::int32_t>("COUNT"), 1);
  EXPECT_EQ(statistics.port<double>("HIGHEST"), 3);
  statistics.port<bool>("RESET") = true;
  take(statistics, 4);
  EXPECT_EQ(statistics.port<std::int32_t>("COUNT"), 0);
  EXPECT_EQ(statistics.port<double>("MEAN"), 0);
  statistics.port<bool>("RESET") = false;
  take(statistics, 5);
  EXPECT_EQ(statistics.port<double>("MEAN"), 5);
  EXPECT_EQ(statistics.port<double>("LOWEST"), 5);
}

TEST(MovingStatistics, RecoverFromSquaresThatAreTooLarge) {
  picard::Instance statistics(filters_library(), "MOVING_STATISTICS", milliseconds(1));
  statistics.port<std::int32_t>("WINDOW") = 3;
  take(statistics, 1);
  take(statistics, 1e200);
  EXPECT_EQ(statistics.port<double>("RMS"), kInfinity);
  EXPECT_EQ(statistics.port<double>("DEVIATION"), kInfinity);
  for (const double x : {1.0, 2.0, 3.0}) take(statistics, x);
  EXPECT_DOUBLE_EQ(statistics.port<double>("DEVIATION"), 1);
}

TEST(MovingStatistics, RefuseASizeOutsideOfTheRange) {
  for (const std::int32_t bad : {0, -1, 1025}) {
    picard::Instance statistics(filters_library(), "MOVING_STATISTICS", milliseconds(1));
    statistics.port<std::int32_t>("WINDOW") = bad;
    EXPECT_THROW(statistics.ready(), std::runtime_error) << bad;
  }
}

TEST(MovingStatistics, DoNotAllocate) {
  picard::Instance statistics(filters_library(), "MOVING_STATISTICS", milliseconds(1));
  statistics.ready();
  const std::size_t before = test::allocations();
  for (int i = 0; i < 300; ++i) take(statistics, i);
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace plc::blocks
