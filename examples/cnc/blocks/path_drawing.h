// A picture of a part program and of what the axes made of it, as SVG: seen from above, with depths as colours, and how
// far set points were from the program and axes from their set points.
//
// In: the program's text, one sample after the other. Out: the text of the picture, two figures. Not here: files,
// threads.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "element.h"

namespace cnc {

struct PathSample {
  Vector set{};           ///< mm, where the axes shall be
  Vector actual{};        ///< mm, where they are
  std::int32_t line = 0;  ///< of the part program, that `set` belongs to
  bool last = false;      ///< no sample: the recording is over
};

class PathDrawing {
 public:
  /// `program` begins at `start`. `tool` is the diameter of the tool, in mm.
  PathDrawing(std::string_view program, const Vector& start, double tool);

  void add(const PathSample& sample);

  [[nodiscard]] double deviation() const { return deviation_; }              ///< mm, greatest
  [[nodiscard]] double following_error() const { return following_error_; }  ///< mm, greatest of any axis
  /// The picture so far. `title` is a line of text.
  [[nodiscard]] std::string svg(std::string_view title) const;

 private:
  using Point = std::array<double, 2>;
  /// A line is drawn so exactly, in mm.
  static constexpr double kExact = 0.01;
  static constexpr std::size_t kDepths = 8;
  static constexpr std::size_t kRapid = kDepths;

  void plan(std::string_view program, const Vector& start);
  void reach(const Point& p);
  [[nodiscard]] std::size_t colour_of(const PathSample& sample) const;
  [[nodiscard]] std::vector<Element>::const_iterator first_of(std::int32_t line) const;
  void begin_line(const Point& p);
  void end_line();
  [[nodiscard]] bool extend(const Point& p);
  void put(char command, const Point& p);

  std::vector<Element> pieces_;  ///< of the program, that move
  std::string planned_rapids_;   ///< `d` of an SVG path
  std::string planned_cuts_;
  double tool_;
  double depth_step_ = 1;  ///< mm of one colour
  Point low_{};
  Point high_{};

  std::array<std::string, kDepths + 1> lines_;  ///< what the axes did: `d` for each colour, rapids after them
  std::size_t colour_ = kRapid;
  bool drawing_ = false;
  // The straight line that is being drawn: from `from_` to `to_`, and the directions that pass by all points between
  // them within kExact.
  Point from_{};
  Point to_{};
  bool has_direction_ = false;
  double direction_ = 0;  ///< rad; the bounds are relative to it
  double least_ = 0;
  double most_ = 0;
  double deviation_ = 0;
  double following_error_ = 0;
};

}  // namespace cnc
