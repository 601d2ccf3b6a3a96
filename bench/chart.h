// Chart: a line chart with logarithmic axes as SVG, for figures of the documentation.
//
// In: named lines of (x, y). Out: one SVG document, the same for the same lines. Does not belong here: measuring.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace plc::bench {

struct ChartLine {
  std::string name;
  std::string colour;  ///< as SVG has it
  bool dashed = false;
  std::vector<std::pair<double, double>> points;  ///< ascending x, all positive
};

/// A vertical line, named above the panel.
struct ChartMark {
  std::string name;
  double x = 1;         ///< outside of the axis it is left out
  std::string colour;   ///< as SVG has it
  std::size_t row = 0;  ///< of its name, counted upwards
};

struct Chart {
  std::string title, x_title, y_title;
  std::vector<ChartLine> lines;
  std::vector<ChartMark> marks = {};
};

/// A grid of 1, 2, 5 in each decade; as many panels as charts, one below the other.
std::string draw(const std::vector<Chart>& charts);

}  // namespace plc::bench
