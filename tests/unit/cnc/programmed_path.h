// The programmed geometry, and how far set points are from it: written anew, so that it shares no mistake with the
// interpolator.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "examples/cnc/blocks/gcode.h"

namespace cnc {

using Point = std::array<double, 3>;

struct Programmed {
  Point from;
  Segment segment;
};

inline double distance(const Point& a, const Point& b) {
  return std::sqrt(std::pow(a[0] - b[0], 2) + std::pow(a[1] - b[1], 2) + std::pow(a[2] - b[2], 2));
}

inline std::vector<Programmed> programmed(const std::string& program, Point at = {}) {
  Interpreter interpreter;
  interpreter.start(program, at);
  std::vector<Programmed> path;
  Interpreter::Segments some;
  while (!interpreter.finished()) {
    interpreter.next(some);
    for (std::size_t i = 0; i < some.count; ++i) {
      if (some.all[i].kind > Segment::kArc) continue;
      path.push_back({at, some.all[i]});
      at = some.all[i].end;
    }
  }
  return path;
}

inline double deviation(const Point& p, const Programmed& piece) {
  const Segment& s = piece.segment;
  if (s.kind != Segment::kArc) {
    double along = 0, square = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      along += (p[i] - piece.from[i]) * (s.end[i] - piece.from[i]);
      square += std::pow(s.end[i] - piece.from[i], 2);
    }
    const double part = square > 0 ? std::clamp(along / square, 0.0, 1.0) : 0;
    Point foot;
    for (std::size_t i = 0; i < 3; ++i) foot[i] = piece.from[i] + part * (s.end[i] - piece.from[i]);
    return distance(p, foot);
  }
  const double radius = std::hypot(piece.from[0] - s.centre[0], piece.from[1] - s.centre[1]);
  const double begin = std::atan2(piece.from[1] - s.centre[1], piece.from[0] - s.centre[0]);
  double turned = (std::atan2(p[1] - s.centre[1], p[0] - s.centre[0]) - begin) * (s.sweep > 0 ? 1 : -1);
  double least = std::min(distance(p, piece.from), distance(p, s.end));
  for (int turn = -1; turn <= 1; ++turn) {
    const double part = (turned + 2 * M_PI * turn) / std::fabs(s.sweep);
    if (part < 0 || part > 1) continue;
    const double z = piece.from[2] + part * (s.end[2] - piece.from[2]);
    least = std::min(least, std::hypot(std::hypot(p[0] - s.centre[0], p[1] - s.centre[1]) - radius, p[2] - z));
  }
  return least;
}

/// The greatest distance of a set point from the pieces next to the line of the program that it belongs to.
inline double worst_deviation(const std::vector<Point>& positions, const std::vector<std::int32_t>& lines,
                              const std::vector<Programmed>& path) {
  double worst = 0;
  for (std::size_t k = 0; k < positions.size(); ++k) {
    const auto before = [](const Programmed& piece, std::int32_t line) { return piece.segment.line < line; };
    const auto here = std::lower_bound(path.begin(), path.end(), lines[k], before);
    double least = std::numeric_limits<double>::infinity();
    for (auto piece = here - std::min<std::ptrdiff_t>(3, here - path.begin()); piece != path.end(); ++piece) {
      if (piece > here + 1) break;
      least = std::min(least, deviation(positions[k], *piece));
    }
    worst = std::max(worst, least);
  }
  return worst;
}

/// The greatest distance of a programmed end point from the nearest set point, in their order.
inline double worst_miss(const std::vector<Point>& positions, const std::vector<Programmed>& path) {
  double worst = 0;
  for (const Programmed& piece : path) {
    double least = std::numeric_limits<double>::infinity();
    for (const Point& p : positions) least = std::min(least, distance(p, piece.segment.end));
    worst = std::max(worst, least);
  }
  return worst;
}

}  // namespace cnc
