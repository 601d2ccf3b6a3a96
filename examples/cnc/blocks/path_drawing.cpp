#include "path_drawing.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "gcode.h"

namespace cnc {

namespace {

/// Above the part, and deeper and deeper in it: from light to dark, so that any eye tells them apart.
constexpr std::array kColours{"#fbb61a", "#f1731d", "#d44842", "#a92e5e", "#7c1d6d", "#551f8f", "#3a2aa6", "#1d4fb8"};
constexpr const char* kGrey = "#6b7280";
/// Bytes of the lines of one colour at most: the picture of a program of hours can still be opened.
constexpr std::size_t kMostBytes = 4'000'000;

std::string number(double value, int decimals = 2) {
  char text[40];
  const int length = std::snprintf(text, sizeof text, "%.*f", decimals, value);
  std::string_view digits(text, std::min(static_cast<std::size_t>(length), sizeof text - 1));
  if (digits.find('.') != std::string_view::npos) {
    while (digits.back() == '0') digits.remove_suffix(1);
    if (digits.back() == '.') digits.remove_suffix(1);
  }
  return digits == "-0" ? "0" : std::string(digits);
}

/// SVG counts Y downwards.
std::string pair(double x, double y) { return number(x) + ' ' + number(-y); }

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '&' || c == '<' || c == '>' || c == '"') {
      result += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : "&quot;";
    } else {
      result += c >= ' ' && c <= '~' ? c : '?';
    }
  }
  return result;
}

std::string path(const std::string& d, const std::string& style) {
  return d.empty() ? "" : "<path d=\"" + d + "\" " + style + "/>\n";
}
std::string text_at(double x, double y, const std::string& text, const char* more = "") {
  return "<text x=\"" + number(x) + "\" y=\"" + number(y) + "\"" + more + ">" + text + "</text>\n";
}

/// 1, 2 or 5 times a power of ten, the greatest that is not above `most`.
double round_length(double most) {
  const double power = std::pow(10, std::floor(std::log10(most)));
  return power * (most >= 5 * power ? 5 : most >= 2 * power ? 2 : 1);
}

}  // namespace

PathDrawing::PathDrawing(std::string_view program, const Vector& start, double tool) : tool_(tool) {
  low_ = high_ = {start[0], start[1]};
  plan(program, start);
}

// ---- the program --------------------------------------------------------------------------------------------------

void PathDrawing::reach(const Point& p) {
  for (std::size_t i = 0; i < 2; ++i) {
    low_[i] = std::min(low_[i], p[i]);
    high_[i] = std::max(high_[i], p[i]);
  }
}

void PathDrawing::plan(std::string_view program, const Vector& start) {
  Interpreter interpreter;
  Interpreter::Segments segments;
  interpreter.start(program, start);
  Vector at = start;
  double deepest = 0;
  std::string* drawn_last = nullptr;
  while (!interpreter.finished()) {
    interpreter.next(segments);
    for (std::size_t i = 0; i < segments.count; ++i) {
      const Element e = element_of(segments.all[i], at, {});
      if (!e.moves() || !(e.length > 0)) continue;
      at = e.end;
      deepest = std::min(deepest, e.end[2]);
      pieces_.push_back(e);
      std::string& d = e.kind == Segment::kRapid ? planned_rapids_ : planned_cuts_;
      if (&d != drawn_last) d += (d.empty() ? "M" : "\nM") + pair(e.start[0], e.start[1]);
      drawn_last = &d;
      // An arc in two halves: no flag has to say which of two arcs is meant, and a circle has two ends.
      for (const double share : {0.5, 1.0}) {
        const Vector to = e.point(share * e.length);
        reach({to[0], to[1]});
        if (e.radius == 0) {
          if (share == 1) d += 'L' + pair(to[0], to[1]);
          continue;
        }
        const bool clockwise = e.along[0] * e.across[1] - e.along[1] * e.across[0] < 0;
        d += 'A' + number(e.radius) + ' ' + number(e.radius) + " 0 0 " + (clockwise ? '1' : '0') + ' ' +
             pair(to[0], to[1]);
      }
    }
  }
  depth_step_ = std::max(1.0, std::ceil(-deepest / (kDepths - 1)));
}

// ---- the axes -----------------------------------------------------------------------------------------------------

std::vector<Element>::const_iterator PathDrawing::first_of(std::int32_t line) const {
  return std::lower_bound(pieces_.begin(), pieces_.end(), line,
                          [](const Element& e, std::int32_t wanted) { return e.line < wanted; });
}

std::size_t PathDrawing::colour_of(const PathSample& sample) const {
  const auto piece = first_of(sample.line);
  if (piece == pieces_.end() || piece->kind == Segment::kRapid) return kRapid;
  const double depth = std::ceil(-sample.actual[2] / depth_step_);
  return static_cast<std::size_t>(std::clamp(depth, 0.0, static_cast<double>(kDepths - 1)));
}

void PathDrawing::add(const PathSample& sample) {
  // The line's own pieces and their neighbours: roundings belong to either, and a line of the program has one piece.
  const auto here = first_of(sample.line);
  double nearest = std::numeric_limits<double>::infinity();
  for (auto piece = here - std::min<std::ptrdiff_t>(3, here - pieces_.begin()); piece != pieces_.end(); ++piece) {
    if (piece > here + 1) break;
    nearest = std::min(nearest, piece->distance(sample.set));
  }
  if (std::isfinite(nearest)) deviation_ = std::max(deviation_, nearest);
  for (std::size_t i = 0; i < 3; ++i) {
    following_error_ = std::max(following_error_, std::fabs(sample.set[i] - sample.actual[i]));
  }

  const Point p{sample.actual[0], sample.actual[1]};
  if (!std::isfinite(p[0] + p[1])) return;
  reach(p);
  const std::size_t colour = colour_of(sample);
  if (drawing_ && colour == colour_) {
    if (!extend(p)) {
      end_line();
      begin_line(to_);
      if (!extend(p)) begin_line(p);
    }
    return;
  }
  const Point joint = drawing_ ? to_ : p;
  end_line();
  colour_ = colour;
  put('M', joint);
  begin_line(joint);
  drawing_ = true;
  if (!extend(p)) begin_line(p);
}

void PathDrawing::begin_line(const Point& p) {
  from_ = to_ = p;
  has_direction_ = false;
}

void PathDrawing::end_line() {
  if (drawing_) put('L', to_);  // a dot, where the tool only went down
}

// Makes the straight line longer, to `p`; false when it would miss a point between by more than kExact.
bool PathDrawing::extend(const Point& p) {
  const double distance = std::hypot(p[0] - from_[0], p[1] - from_[1]);
  if (!has_direction_) {
    to_ = p;
    if (distance <= kExact) return true;
    direction_ = std::atan2(p[1] - from_[1], p[0] - from_[0]);
    most_ = std::asin(kExact / distance);
    least_ = -most_;
    has_direction_ = true;
    return true;
  }
  if (distance < std::hypot(to_[0] - from_[0], to_[1] - from_[1])) return false;  // it turns back
  const double turn = std::remainder(std::atan2(p[1] - from_[1], p[0] - from_[0]) - direction_, 2 * std::numbers::pi);
  if (turn < least_ || turn > most_) return false;
  const double slack = std::asin(kExact / distance);
  least_ = std::max(least_, turn - slack);
  most_ = std::min(most_, turn + slack);
  to_ = p;
  return true;
}

void PathDrawing::put(char command, const Point& p) {
  std::string& d = lines_[colour_];
  if (d.size() >= kMostBytes) return;
  if (command == 'M' && !d.empty()) d += '\n';  // a picture in a repository has differences that can be read
  d += command + pair(p[0], p[1]);
}

// ---- the picture --------------------------------------------------------------------------------------------------

std::string PathDrawing::svg(std::string_view title) const {
  const double size = std::max({high_[0] - low_[0], high_[1] - low_[1], 1.0}) + tool_;
  const double unit = size / 55;  // of letters and margins
  const double left = low_[0] - tool_ / 2 - 2 * unit;
  const double top = -high_[1] - tool_ / 2 - 4 * unit;
  const double width = size + 4 * unit;
  const double legend = -low_[1] + tool_ / 2 + 4 * unit;
  const double height = legend + 6 * unit - top;

  std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"" + number(left) + ' ' + number(top) + ' ' +
                    number(width) + ' ' + number(height) + "\" width=\"900\" font-family=\"sans-serif\" font-size=\"" +
                    number(unit) + "\" fill=\"#1f2937\">\n";
  out += "<title>" + escaped(title) + "</title>\n";
  out += "<rect x=\"" + number(left) + "\" y=\"" + number(top) + "\" width=\"" + number(width) + "\" height=\"" +
         number(height) + "\" fill=\"#ffffff\"/>\n";
  out += text_at(left + 2 * unit, top + 2 * unit, escaped(title), " font-weight=\"bold\"");

  const auto stroke = [&](const char* colour, double wide) {
    return std::string("fill=\"none\" stroke=\"") + colour + "\" stroke-width=\"" + number(wide) +
           "\" stroke-linejoin=\"round\" stroke-linecap=\"round\"";
  };
  const double thin = size / 500;
  const std::string dashes = " stroke-dasharray=\"" + number(unit / 2) + ' ' + number(unit / 3) + "\"";
  const std::string rapid = stroke(kGrey, thin) + dashes;
  out += path(planned_cuts_, stroke("#e5e7eb", tool_));
  out += path(planned_rapids_, stroke("#d1d5db", 3 * thin));
  out += path(lines_[kRapid] + (colour_ == kRapid && drawing_ ? 'L' + pair(to_[0], to_[1]) : ""), rapid);
  for (std::size_t i = 0; i < kDepths; ++i) {
    out +=
        path(lines_[i] + (colour_ == i && drawing_ ? 'L' + pair(to_[0], to_[1]) : ""), stroke(kColours[i], 3 * thin));
  }

  const double bar = round_length(size / 5);
  const double right = left + width - 2 * unit;
  out += path('M' + number(right - bar) + ' ' + number(legend) + 'h' + number(bar), stroke("#1f2937", 2 * thin));
  out += text_at(right - bar, legend - unit / 2, number(bar, 6) + " mm");

  double x = left + 2 * unit;
  const auto entry = [&](const std::string& style, const std::string& words, double y) {
    out += path('M' + number(x) + ' ' + number(y - unit / 3) + 'h' + number(1.5 * unit), style);
    out += text_at(x + 2 * unit, y, words);
    x += (2.7 + 0.58 * static_cast<double>(words.size())) * unit;
  };
  entry(stroke("#d1d5db", 0.8 * unit), "programmed, tool of " + number(tool_) + " mm", legend);
  entry(rapid, "rapid", legend);
  x = left + 2 * unit;
  for (std::size_t i = 0; i < kDepths; ++i) {
    if (lines_[i].empty()) continue;
    entry(stroke(kColours[i], 3 * thin), i == 0 ? "Z above 0" : "to Z " + number(-depth_step_ * static_cast<double>(i)),
          legend + 2 * unit);
  }
  out += text_at(left + 2 * unit, legend + 4 * unit,
                 "Set points at most " + number(deviation_, 4) + " mm from the program, axes at most " +
                     number(following_error_, 4) + " mm from their set points.");
  return out + "</svg>\n";
}

}  // namespace cnc
