// SCARA: an arm of two links in a plane, its position from its joints and the other way round.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "picard/taskblock.h"

namespace plc::blocks {

class Scara final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "SCARA",
      .group = "Motion",
      .summary = "Joint angles of a two-link arm for a position, and its position from measured angles.",
      .details =
          "Both ways in one block. Forward: X_ACTUAL = L1 cos Q1_ACTUAL + L2 cos(Q1_ACTUAL + Q2_ACTUAL), Y_ACTUAL "
          "the same with sin. Inverse: Q2 = +-acos((X^2 + Y^2 - L1^2 - L2^2) / (2 L1 L2)), positive with ELBOW = "
          "FALSE (the elbow lies to the right of the line to the hand), negative with TRUE; Q1 = atan2(Y, X) - "
          "atan2(L2 sin Q2, L1 + L2 cos Q2).\n\n"
          "Q1 is the angle nearest to the Q1 before, so that a circle around the base turns on instead of jumping by "
          "2 pi; the first one is between -pi and pi.\n\n"
          "REACHABLE is FALSE for positions that are further than L1 + L2 or nearer than |L1 - L2|, and for numbers "
          "that are none: Q1 and Q2 stay what they were. SINGULAR tells that the arm is stretched or folded: |sin "
          "Q2| is below NEAR, where small movements of the hand need large ones of the joints. In the base itself (X "
          "= Y = 0, links of one length) Q1 stays what it was."};

  picard::Input<double> x{this, "X", "wanted position of the hand", {.unit = "u"}};
  picard::Input<double> y{this, "Y", "wanted position of the hand", {.unit = "u"}};
  picard::Input<bool> elbow{this, "ELBOW", "which of the two solutions: TRUE bends joint 2 to negative angles"};
  picard::Input<double> q1_actual{this, "Q1_ACTUAL", "measured angle of link 1 to the x axis", {.unit = "rad"}};
  picard::Input<double> q2_actual{this, "Q2_ACTUAL", "measured angle of link 2 to link 1", {.unit = "rad"}};
  picard::Config<double> l1{this, "L1", "length of link 1", {.unit = "u", .initial = "1.0"}};
  picard::Config<double> l2{this, "L2", "length of link 2", {.unit = "u", .initial = "1.0"}};
  picard::Config<double> near{
      this, "NEAR", "|sin Q2| below which SINGULAR is set", {.lowest = 0, .highest = 1, .initial = "0.05"}};
  picard::Output<double> q1{this, "Q1", "angle of link 1 for X, Y", {.unit = "rad"}};
  picard::Output<double> q2{this, "Q2", "angle of link 2 for X, Y", {.unit = "rad"}};
  picard::Output<bool> reachable{this, "REACHABLE", "Q1 and Q2 are those of X, Y"};
  picard::Output<bool> singular{this, "SINGULAR", "stretched or folded"};
  picard::Output<double> x_actual{this, "X_ACTUAL", "position of the hand from the measured angles", {.unit = "u"}};
  picard::Output<double> y_actual{this, "Y_ACTUAL", "position of the hand from the measured angles", {.unit = "u"}};

  void ready() override {
    if (!(std::isfinite(l1) && l1 > 0 && std::isfinite(l2) && l2 > 0)) {
      throw picard::Failure("SCARA: L1 and L2 must be lengths above zero");
    }
  }

  void fire() override {
    x_actual = l1 * std::cos(q1_actual) + l2 * std::cos(q1_actual + q2_actual);
    y_actual = l1 * std::sin(q1_actual) + l2 * std::sin(q1_actual + q2_actual);
    invert();
    singular = std::fabs(std::sin(q2)) < near;
  }

 private:
  /// How far, relative to the arm, a position may be outside because of rounding.
  static constexpr double kRounding = 1e-12;

  void invert() {
    const double cosine = (x * x + y * y - l1 * l1 - l2 * l2) / (2 * l1 * l2);
    reachable = std::fabs(cosine) <= 1 + kRounding;  // FALSE for NaN
    if (!reachable) return;
    const double bend = std::acos(std::clamp(cosine, -1.0, 1.0));
    q2 = elbow ? -bend : bend;
    if (x == 0 && y == 0) return;
    const double turn = std::atan2(y, x) - std::atan2(l2 * std::sin(q2), l1 + l2 * std::cos(q2));
    constexpr double kCircle = 2 * std::numbers::pi;
    q1 = turn + kCircle * std::round((q1 - turn) / kCircle);
  }
};

}  // namespace plc::blocks
