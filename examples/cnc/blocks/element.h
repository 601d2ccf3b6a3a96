// A piece of the tool's path, a straight line or an arc anywhere in space, with the speeds and accelerations that the
// axes can do on it.
//
// In: geometry and the limits of the axes. Not here: how fast the tool really goes (interpolator.h).
#pragma once

#include <array>
#include <cstdint>

#include "segment.h"

namespace cnc {

using Vector = std::array<double, 3>;

struct PathLimits {
  Vector speed{100, 100, 100};            ///< mm/s, of each axis
  Vector acceleration{1000, 1000, 1000};  ///< mm/s2, of each axis
  double deviation = 0.01;                ///< mm, by how much a corner between two lines may be rounded
  double period = 0.001;                  ///< s, of the set points

  [[nodiscard]] bool valid() const noexcept;
};

/// What is kept back of the accelerations for the small steps of direction that are passed without rounding.
inline constexpr double kStepShare = 0.05;

struct Element {
  // Where. A line goes from `start` along `along`; an arc turns from `start` around `centre`, from the unit vector
  // `along` to `across`, by `sweep` > 0, and rises by `rise` with every radian.
  Vector start{};
  Vector end{};
  Vector along{};
  Vector across{};
  Vector centre{};
  Vector rise{};
  double radius = 0;  ///< 0: a line
  double sweep = 0;
  double length = 0;

  // How fast.
  double cap = 0;           ///< mm/s that axes and curvature allow
  double feed = 0;          ///< mm/s that the program asks for; infinite for rapids
  double acceleration = 0;  ///< mm/s2 along the path that is left beside the curvature
  double exit_cap = 0;      ///< mm/s at its end that the change of direction allows

  Segment::Kind kind = Segment::kEnd;
  std::int32_t line = 0;
  std::int32_t code = 0;
  double seconds = 0;
  double spindle = 0;

  [[nodiscard]] bool moves() const noexcept { return kind <= Segment::kArc; }
  [[nodiscard]] Vector point(double s) const noexcept;
  [[nodiscard]] Vector tangent(double s) const noexcept;
  /// mm from `p` to the nearest point of it; of a helix, to the one that is seen at the same angle.
  [[nodiscard]] double distance(const Vector& p) const noexcept;
};

/// The path of a segment that begins at `from`; its exit_cap is 0.
[[nodiscard]] Element element_of(const Segment& segment, const Vector& from, const PathLimits& limits) noexcept;

/// Where one element ends and the next one begins. The corner of two lines is rounded: both become shorter, and
/// `rounding` is the arc between them, tangent to both and not further from the corner than allowed. Other changes of
/// direction get a speed at which they are a step of kStepShare of the acceleration. `first_length` and `second`'s
/// length are those before any rounding, of which most of a half is cut off here at most.
/// False: there is no rounding.
bool join(Element& first, double first_length, Element& second, const PathLimits& limits, Element& rounding) noexcept;

[[nodiscard]] inline Vector plus(const Vector& a, const Vector& b, double times = 1) noexcept {
  return {a[0] + times * b[0], a[1] + times * b[1], a[2] + times * b[2]};
}
[[nodiscard]] inline double dot(const Vector& a, const Vector& b) noexcept {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

}  // namespace cnc
