// A PID loop as tests see it, and the plants that it is held against.
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>
#include <deque>
#include <limits>

#include "picard/testing.h"
#include "taskblocks/set.h"

namespace plc::blocks {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

class Loop : public picard::Instance {
 public:
  explicit Loop(nanoseconds period) : Instance(control_library(), "PID_2DOF", period) { port<bool>("AUTO") = true; }
  double& operator[](const char* name) { return port<double>(name); }
  double out() { return port<double>("XOUT"); }
  bool bad() { return port<bool>("BAD"); }
  std::int16_t tune_state() { return port<std::int16_t>("TUNE_STATE"); }
};

/// K / (T s + 1) after a zero-order hold: exact.
struct FirstOrder {
  double gain;
  double decay;  ///< exp(-period / T)
  double y = 0;
  void step(double u) { y = decay * y + (1 - decay) * gain * u; }
};

/// 1 / (s + 1)^3, Euler in steps small enough.
struct ThreeLags {
  double x[3] = {};
  void step(double u, double h) {
    constexpr int kFine = 20;
    for (int i = 0; i < kFine; ++i) {
      x[2] += (x[1] - x[2]) * h / kFine;
      x[1] += (x[0] - x[1]) * h / kFine;
      x[0] += (u - x[0]) * h / kFine;
    }
  }
};

}  // namespace plc::blocks
