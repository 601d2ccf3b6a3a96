// Time series as SVG: panels one above the other with a common time axis, for pages of docs/.
//
// In: points, names, colours. Out: the text of a file that looks the same everywhere: own background, no scripts, no
// fonts of its own, numbers of one decimal. Does not belong here: what is plotted.
#pragma once

#include <cstdio>
#include <string>
#include <utility>
#include <vector>

namespace plc::test {

/// Colours that people with any colour vision tell apart (Okabe and Ito), and that stand out from white.
inline constexpr const char* kBlue = "#0072b2";
inline constexpr const char* kOrange = "#d55e00";
inline constexpr const char* kGrey = "#6b7280";

struct PlotSeries {
  std::string name;
  const char* colour = kBlue;
  bool dashed = false;
  std::vector<std::pair<double, double>> points{};  ///< time and value, times ascending
};

/// One diagram: its axis goes from `low` to `high` with a line every `grid`.
struct PlotPanel {
  std::string label;
  double low = 0, high = 100, grid = 20;
  std::vector<PlotSeries> series{};
};

/// A basic block of time with a name above it, shaded.
struct PlotSpan {
  double from = 0, to = 0;
  std::string name;
};

struct Plot {
  std::string title;
  std::string time_label;
  double end = 0, grid = 60;  ///< the time axis goes from 0 to `end`
  std::vector<PlotPanel> panels{};
  std::vector<PlotSpan> spans{};
};

class SvgWriter {
 public:
  static std::string write(const Plot& plot) { return SvgWriter(plot).text_; }

 private:
  static constexpr double kWidth = 760, kLeft = 64, kRight = 16, kTop = 56, kHeight = 180, kGap = 28, kBottom = 44;

  explicit SvgWriter(const Plot& plot) : plot_(plot) {
    const double height = kTop + static_cast<double>(plot.panels.size()) * (kHeight + kGap) - kGap + kBottom;
    line("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + number(kWidth) + " " + number(height) +
         "\" font-family=\"sans-serif\" font-size=\"12\" fill=\"#1f2937\">");
    line("<title>" + plot.title + "</title>");
    line("<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>");
    text(kLeft, 20, "start", plot.title, "font-size=\"14\" font-weight=\"bold\"");
    for (const PlotSpan& span : plot.spans) {
      line("<rect x=\"" + number(x(span.from)) + "\" y=\"" + number(kTop) + "\" width=\"" +
           number(x(span.to) - x(span.from)) + "\" height=\"" + number(height - kTop - kBottom) +
           "\" fill=\"#eef2f7\"/>");
      text((x(span.from) + x(span.to)) / 2, kTop - 6, "middle", span.name, "fill=\"#4b5563\"");
    }
    double top = kTop;
    for (const PlotPanel& panel : plot.panels) {
      draw(panel, top);
      top += kHeight + kGap;
    }
    for (double t = 0; t <= plot.end; t += plot.grid) text(x(t), height - kBottom + 18, "middle", number(t, 0));
    text(x(plot.end / 2), height - 6, "middle", plot.time_label);
    line("</svg>");
  }

  void draw(const PlotPanel& panel, double top) {
    const auto y = [&](double v) { return top + kHeight * (panel.high - v) / (panel.high - panel.low); };
    for (double t = 0; t <= plot_.end; t += plot_.grid) rule(x(t), top, x(t), top + kHeight);
    for (double v = panel.low; v <= panel.high; v += panel.grid) {
      rule(x(0), y(v), x(plot_.end), y(v));
      text(kLeft - 6, y(v) + 4, "end", number(v, 0));
    }
    const double middle = top + kHeight / 2;
    text(16, middle, "middle", panel.label, "transform=\"rotate(-90 16 " + number(middle) + ")\"");
    double legend = kLeft + 12;
    for (const PlotSeries& series : panel.series) {
      std::string points;
      for (std::size_t i = 0; i < series.points.size(); ++i) {
        // Of a level basic block its ends will do.
        const auto height = [&](std::size_t at) { return number(y(series.points[at].second)); };
        const bool inside = i > 0 && i + 1 < series.points.size();
        if (inside && height(i - 1) == height(i) && height(i) == height(i + 1)) continue;
        points += (points.empty() ? "" : " ") + number(x(series.points[i].first)) + "," + height(i);
      }
      const std::string stroke = std::string("fill=\"none\" stroke=\"") + series.colour + "\" stroke-width=\"1.8\"" +
                                 (series.dashed ? " stroke-dasharray=\"6 3\"" : "");
      line("<polyline " + stroke + " points=\"" + points + "\"/>");
      line("<polyline " + stroke + " points=\"" + number(legend) + "," + number(top + 12) + " " + number(legend + 24) +
           "," + number(top + 12) + "\"/>");
      text(legend + 30, top + 16, "start", series.name);
      legend += 48 + 7.5 * static_cast<double>(series.name.size());
    }
    line("<rect x=\"" + number(x(0)) + "\" y=\"" + number(top) + "\" width=\"" + number(x(plot_.end) - x(0)) +
         "\" height=\"" + number(kHeight) + "\" fill=\"none\" stroke=\"#374151\"/>");
  }

  [[nodiscard]] double x(double t) const { return kLeft + (kWidth - kLeft - kRight) * t / plot_.end; }
  static std::string number(double v, int decimals = 1) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%.*f", decimals, v);
    return buffer;
  }
  void line(const std::string& s) { text_ += s + "\n"; }
  void rule(double x1, double y1, double x2, double y2) {
    line("<line x1=\"" + number(x1) + "\" y1=\"" + number(y1) + "\" x2=\"" + number(x2) + "\" y2=\"" + number(y2) +
         "\" stroke=\"#d1d5db\"/>");
  }
  void text(double at_x, double at_y, const char* anchor, const std::string& s, const std::string& more = "") {
    line("<text x=\"" + number(at_x) + "\" y=\"" + number(at_y) + "\" text-anchor=\"" + anchor + "\"" +
         (more.empty() ? "" : " " + more) + ">" + s + "</text>");
  }

  const Plot& plot_;
  std::string text_;
};

/// `plot` as the text of an SVG file.
inline std::string svg_of(const Plot& plot) { return SvgWriter::write(plot); }

}  // namespace plc::test
