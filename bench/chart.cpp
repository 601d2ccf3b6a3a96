#include "bench/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace plc::bench {
namespace {

constexpr double kWidth = 760, kPanel = 300, kLeft = 72, kRight = 190, kTop = 40, kBottom = 52;

/// A logarithmic axis of whole decades around the values.
struct Axis {
  double low = std::numeric_limits<double>::max(), high = 0;
  double from = 0, to = 0;  ///< where low and high are drawn

  void take(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  void round() {
    low = std::pow(10, std::floor(std::log10(low)));
    high = std::max(std::pow(10, std::ceil(std::log10(high))), low * 10);
  }
  [[nodiscard]] double at(double value) const {
    return from + (to - from) * std::log10(value / low) / std::log10(high / low);
  }
};

std::string decade(double value) {
  if (value < 1000) return fmt::format("{:g}", value);
  return value < 1e6 ? fmt::format("{:g}k", value / 1e3) : fmt::format("{:g}M", value / 1e6);
}

std::string panel(const Chart& chart, double top) {
  Axis x{.from = kLeft, .to = kWidth - kRight}, y{.from = top + kPanel - kBottom, .to = top + kTop};
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
  for (double v = x.low; v <= x.high * 1.001; v *= 10) {
    grid(x.at(v), y.from, x.at(v), y.to);
    text(x.at(v), y.from + 16, "middle", decade(v));
  }
  for (double v = y.low; v <= y.high * 1.001; v *= 10) {
    grid(x.from, y.at(v), x.to, y.at(v));
    text(x.from - 6, y.at(v) + 4, "end", decade(v));
  }
  text((x.from + x.to) / 2, y.from + 36, "middle", chart.x_title);
  out += fmt::format("<text transform=\"translate(16 {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                     (y.from + y.to) / 2, chart.y_title);
  for (const ChartMark& mark : chart.marks) {
    if (mark.x <= x.low || mark.x >= x.high) continue;
    out += fmt::format(
        "<line x1=\"{0:.1f}\" y1=\"{1:.1f}\" x2=\"{0:.1f}\" y2=\"{2:.1f}\" stroke=\"#6b7280\" "
        "stroke-dasharray=\"2 3\"/>\n",
        x.at(mark.x), y.from, y.to);
    text(x.at(mark.x) + 3, y.from - 6, "start", mark.name);
  }
  double legend = y.to + 10;
  for (const ChartLine& line : chart.lines) {
    const std::string style = fmt::format("fill=\"none\" stroke=\"{}\" stroke-width=\"2\"{}", line.colour,
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
