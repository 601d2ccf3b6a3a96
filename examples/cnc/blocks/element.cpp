#include "element.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace cnc {

namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
/// A tool passes at least a quarter of an element in a cycle: so a cycle has a handful of elements at most.
constexpr double kElementsPerCycle = 4;
/// The cosine of half the angle of turns by more than 168 degrees is below this: nothing is to be rounded there.
constexpr double kReversal = 0.1;
/// Of a line, what the rounding at one of its ends may take.
constexpr double kMostCut = 0.45;
/// On arcs the acceleration is shared between the direction along the path and the one across it:
/// (1/2)^2 + (sqrt(3)/2)^2 = 1.
constexpr double kAlong = 0.5;
const double kAcross = std::sqrt(3.0) / 2;

Vector scaled(const Vector& a, double by) noexcept { return {a[0] * by, a[1] * by, a[2] * by}; }
double norm(const Vector& a) noexcept { return std::sqrt(dot(a, a)); }

/// How far one can go in a direction until the first axis is at its limit.
double until_limit(const Vector& limits, const Vector& direction) noexcept {
  double least = kInfinite;
  for (std::size_t i = 0; i < 3; ++i) {
    if (std::fabs(direction[i]) > 1e-12) least = std::min(least, limits[i] / std::fabs(direction[i]));
  }
  return least;
}

void set_line_limits(Element& e, const PathLimits& limits) noexcept {
  e.acceleration = (1 - kStepShare) * until_limit(limits.acceleration, e.along);
  e.cap = std::min(until_limit(limits.speed, e.along), kElementsPerCycle * e.length / limits.period);
}

void set_arc_limits(Element& e, const PathLimits& limits) noexcept {
  // The most that an axis sees of a vector in the plane of the arc, whatever its direction there.
  Vector share{};
  for (std::size_t i = 0; i < 3; ++i) share[i] = std::hypot(e.along[i], e.across[i]);
  const double in_plane = e.radius * e.sweep / e.length;
  const Vector rising = scaled(e.rise, e.sweep / e.length);
  const double acceleration = (1 - kStepShare) * until_limit(limits.acceleration, share);
  e.acceleration =
      std::min(kAlong * acceleration / in_plane, (1 - kStepShare) * until_limit(limits.acceleration, rising));
  e.cap =
      std::min({std::sqrt(kAcross * acceleration * e.radius) / in_plane, until_limit(limits.speed, share) / in_plane,
                until_limit(limits.speed, rising), kElementsPerCycle * e.length / limits.period});
}

/// A line with another start or end.
void set_line(Element& e, const Vector& start, const Vector& end, const PathLimits& limits) noexcept {
  e.start = start;
  e.end = end;
  const Vector way = plus(end, start, -1);
  e.length = norm(way);
  e.along = scaled(way, 1 / e.length);
  set_line_limits(e, limits);
}

}  // namespace

bool PathLimits::valid() const noexcept {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
  return std::all_of(speed.begin(), speed.end(), positive) &&
         std::all_of(acceleration.begin(), acceleration.end(), positive) && positive(deviation) && positive(period);
}

Vector Element::point(double s) const noexcept {
  if (s <= 0) return start;
  if (s >= length) return end;
  if (radius == 0) return plus(start, along, s);
  const double angle = s / length * sweep;
  const Vector turned = plus(scaled(along, radius * std::cos(angle)), across, radius * std::sin(angle));
  return plus(plus(centre, turned), rise, angle);
}

Vector Element::tangent(double s) const noexcept {
  if (radius == 0) return along;
  const double angle = s / length * sweep;
  const Vector turning = plus(scaled(along, -radius * std::sin(angle)), across, radius * std::cos(angle));
  return scaled(plus(turning, rise), sweep / length);
}

double Element::distance(const Vector& p) const noexcept {
  double s = dot(plus(p, start, -1), along);
  if (radius != 0) {
    const Vector from_centre = plus(p, centre, -1);
    const double angle = std::atan2(dot(from_centre, across), dot(from_centre, along));
    s = (angle < 0 ? angle + 2 * std::numbers::pi : angle) / sweep * length;
  }
  // Beside an arc the angle may be nearer to the other end than it says: so both ends count as well.
  return std::min({norm(plus(p, point(s), -1)), norm(plus(p, start, -1)), norm(plus(p, end, -1))});
}

Element element_of(const Segment& segment, const Vector& from, const PathLimits& limits) noexcept {
  Element e;
  const bool known = segment.kind >= Segment::kRapid && segment.kind <= Segment::kEnd;
  e.kind = known ? static_cast<Segment::Kind>(segment.kind) : Segment::kEnd;
  e.line = segment.line;
  e.code = segment.code;
  e.seconds = segment.seconds;
  e.spindle = segment.spindle;
  e.start = from;
  e.end = segment.end;
  if (!e.moves()) return e;
  e.feed = e.kind == Segment::kRapid ? kInfinite : segment.feed;
  if (e.kind == Segment::kArc) {
    const double dx = from[0] - segment.centre[0];
    const double dy = from[1] - segment.centre[1];
    e.radius = std::hypot(dx, dy);
    e.sweep = std::fabs(segment.sweep);
    const double turn = std::copysign(1.0, segment.sweep);
    e.along = {dx / e.radius, dy / e.radius, 0};
    e.across = {-turn * e.along[1], turn * e.along[0], 0};
    e.centre = {segment.centre[0], segment.centre[1], from[2]};
    e.rise = {0, 0, (segment.end[2] - from[2]) / e.sweep};
    e.length = e.sweep * std::hypot(e.radius, e.rise[2]);
    set_arc_limits(e, limits);
  } else if (from != segment.end) {
    set_line(e, from, segment.end, limits);
  }
  return e;
}

bool join(Element& first, double first_length, Element& second, const PathLimits& limits, Element& rounding) noexcept {
  const Vector in = first.tangent(first.length);
  const Vector out = second.tangent(0);
  // |out - in| = 2 sin(half the angle), exact for small angles, where the product of the two is not.
  const double half_sine = std::min(1.0, norm(plus(out, in, -1)) / 2);
  const double wanted = std::min({first.cap, first.feed, second.cap, second.feed});
  const double step =
      kStepShare * limits.period * *std::min_element(limits.acceleration.begin(), limits.acceleration.end());
  first.exit_cap = half_sine > 0 ? step / (2 * half_sine) : kInfinite;
  const double half_cosine = std::sqrt(1 - half_sine * half_sine);
  if (wanted <= first.exit_cap || first.radius != 0 || second.radius != 0 || half_cosine < kReversal) return false;

  const double angle = 2 * std::asin(half_sine);
  const double half_tangent = half_sine / half_cosine;
  const Vector corner = first.end;
  // The radius that the wanted speed needs, and one that is not passed in less than a cycle's share.
  Element arc = first;
  arc.along = scaled(plus(out, in, -1), 1 / (2 * half_sine));  // from the corner to the inside
  arc.across = scaled(plus(out, in), 1 / (2 * half_cosine));
  Vector share{};
  for (std::size_t i = 0; i < 3; ++i) share[i] = std::hypot(arc.along[i], arc.across[i]);
  const double across = kAcross * (1 - kStepShare) * until_limit(limits.acceleration, share);
  const double needed = std::max(wanted * wanted / across, wanted * limits.period / (kElementsPerCycle * angle));
  // As far from the corner as is allowed: radius (1 / half_cosine - 1) = deviation. 1 - cos = sin^2 / (1 + cos).
  const double allowed = limits.deviation * half_cosine * (1 + half_cosine) / (half_sine * half_sine);
  const double room = kMostCut * std::min(first_length, second.length) / half_tangent;
  arc.radius = std::min({needed, allowed, room});
  const double cut = arc.radius * half_tangent;

  arc.kind = Segment::kArc;
  arc.line = second.line;
  arc.spindle = first.spindle;
  arc.feed = std::min(first.feed, second.feed);
  arc.sweep = angle;
  arc.length = angle * arc.radius;
  arc.start = plus(corner, in, -cut);
  arc.end = plus(corner, out, cut);
  arc.centre = plus(corner, arc.along, arc.radius / half_cosine);
  arc.rise = {};
  // The first vector of the arc points from the centre to its start, the second one is the direction there.
  arc.along = scaled(plus(arc.start, arc.centre, -1), 1 / arc.radius);
  arc.across = in;
  set_arc_limits(arc, limits);
  arc.exit_cap = kInfinite;
  set_line(first, first.start, arc.start, limits);
  set_line(second, arc.end, second.end, limits);
  first.exit_cap = kInfinite;
  rounding = arc;
  return true;
}

}  // namespace cnc
