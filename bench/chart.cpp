#include "bench/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace plc::bench {
namespace {

constexpr double kWidth = 760, kPanel = 300, kLeft = 72, kRight = 190, kTop = 40, kBottom = 52, kMarkRow = 11;

/// A logarithmic axis around the values; it begins and ends at 1, 2 or 5 of a decade.
struct Axis {
  double low = std::numeric_limits<double>::max(), high = 0;
  double from = 0, to = 0;         ///< where low and high are drawn
  std::vector<double> steps = {};  ///< low to high

  void take(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  void round() {
    constexpr double kNearly = 1e-6;
    double decade = std::pow(10, std::floor(std::log10(low)));
    while (steps.empty() || steps.back() < high) {
      for (const double step : {decade, 2 * decade, 5 * decade}) {
        if (!steps.empty() && steps.back() >= high * (1 - kNearly)) break;
        if (step <= low * (1 + kNearly)) steps.clear();
        steps.push_back(step);
      }
      decade *= 10;
    }
    if (steps.size() == 1) steps.push_back(steps.front() * 2);
    low = steps.front();
    high = steps.back();
  }
  [[nodiscard]] double at(double value) const {
    return from + (to - from) * std::log10(value / low) / std::log10(high / low);
  }
};

std::string number(double value) {
  if (value < 1000) return fmt::format("{:g}", value);
  return value < 1e6 ? fmt::format("{:g}k", value / 1e3) : fmt::format("{:g}M", value / 1e6);
}

std::string panel(const Chart& chart, double top) {
  std::size_t rows = 0;
  for (const ChartMark& mark : chart.marks) rows = std::max(rows, mark.row + 1);
  Axis x{.from = kLeft, .to = kWidth - kRight};
  Axis y{.from = top + kPanel - kBottom, .to = top + kTop + kMarkRow * static_cast<double>(rows)};
  for (const ChartLine& line : chart.lines) {
    for (const auto& [px, py] : line.points) {
      x.take(px);
      y.take(py);
    }
  }
  x.round();
  y.round();
  std::string out = fmt::format("<text x=\"{}\" y=\"{}\" font-size=\"14\" font-weight=\"bold\">{}</text>\n", kLeft,
                                top + 22, chart.title);
  const auto grid = [&](double x1, double y1, double x2, double y2) {
    out += fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"#d1d5db\"/>\n", x1, y1,
                       x2, y2);
  };
  const auto text = [&](double px, double py, const char* anchor, const std::string& words) {
    out += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", px, py, anchor, words);
  };
  for (const double v : x.steps) {
    grid(x.at(v), y.from, x.at(v), y.to);
    text(x.at(v), y.from + 16, "middle", number(v));
  }
  for (const double v : y.steps) {
    grid(x.from, y.at(v), x.to, y.at(v));
    text(x.from - 6, y.at(v) + 4, "end", number(v));
  }
  text((x.from + x.to) / 2, y.from + 36, "middle", chart.x_title);
  out += fmt::format("<text transform=\"translate(16 {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                     (y.from + y.to) / 2, chart.y_title);
  for (const ChartMark& mark : chart.marks) {
    if (mark.x < x.low || mark.x > x.high) continue;
    const double name_y = y.to - 4 - kMarkRow * static_cast<double>(mark.row);
    out += fmt::format(
        "<line x1=\"{0:.1f}\" y1=\"{1:.1f}\" x2=\"{0:.1f}\" y2=\"{2:.1f}\" stroke=\"{3}\" stroke-dasharray=\"2 "
        "3\"/>\n<text x=\"{4:.1f}\" y=\"{2:.1f}\" font-size=\"10\" fill=\"{3}\">{5}</text>\n",
        x.at(mark.x), y.from, name_y, mark.colour, x.at(mark.x) + 2, mark.name);
  }
  double legend = y.to + 10;
  for (const ChartLine& line : chart.lines) {
    const std::string style = fmt::format(R"(fill="none" stroke="{}" stroke-width="2"{})", line.colour,
                                          line.dashed ? " stroke-dasharray=\"5 4\"" : "");
    std::string points;
    for (const auto& [px, py] : line.points) points += fmt::format("{:.1f},{:.1f} ", x.at(px), y.at(py));
    out += fmt::format("<polyline points=\"{}\" {}/>\n", points, style);
    out += fmt::format("<path d=\"M{:.1f} {:.1f}h22\" {}/>\n", x.to + 14, legend - 4, style);
    text(x.to + 42, legend, "start", line.name);
    legend += 18;
  }
  return out;
}

}  // namespace

std::string draw(const std::vector<Chart>& charts) {
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" font-size=\"12\" "
      "fill=\"#1f2937\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n",
      kWidth, kPanel * static_cast<double>(charts.size()));
  for (std::size_t i = 0; i < charts.size(); ++i) out += panel(charts[i], kPanel * static_cast<double>(i));
  return out + "</svg>\n";
}

}  // namespace plc::bench
