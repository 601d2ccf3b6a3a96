// PATH_PLOT and what it is made of: distances from the path, lines that are drawn with few points, the file.
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <random>
#include <regex>
#include <string>
#include <thread>
#include <vector>

#include "examples/cnc/blocks/path_drawing.h"
#include "picard/testing.h"
#include "tests/support/count_allocations.h"
#include "tests/unit/cnc/programmed_path.h"

extern "C" const picard_library* picard_library_v1(void);

namespace cnc {
namespace {

using std::chrono::milliseconds;
using FileName = picard::Text<255>;

std::string text_of(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

// The nearest of many points of the piece, worked out from its definition and not from Element.
TEST(Element, DistanceIsThatOfTheNearestPoint) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int i = 0; i < 500; ++i) {
    const Vector from{10 * any(random), 10 * any(random), any(random)};
    Segment s{.kind = i % 2 == 0 ? Segment::kArc : Segment::kLine, .feed = 1};
    s.centre = {10 * any(random), 10 * any(random)};
    s.sweep = i % 10 == 0 ? 2 * M_PI : 2 * M_PI * any(random);
    const auto at = [&](double part) {
      if (s.kind == Segment::kLine) {
        return Vector{from[0] + part * (s.centre[0] - from[0]), from[1] + part * (s.centre[1] - from[1]), from[2]};
      }
      const double c = std::cos(part * s.sweep), q = std::sin(part * s.sweep);
      const double x = from[0] - s.centre[0], y = from[1] - s.centre[1];
      return Vector{s.centre[0] + c * x - q * y, s.centre[1] + q * x + c * y, from[2]};
    };
    s.end = at(1);
    const Element e = element_of(s, from, {});
    const Vector p{15 * any(random), 15 * any(random), any(random)};
    double nearest = 1e9;
    for (int k = 0; k <= 5000; ++k) nearest = std::min(nearest, distance(p, at(k / 5000.0)));
    EXPECT_NEAR(e.distance(p), nearest, 0.02) << i;
    EXPECT_LE(e.distance(p), nearest + 1e-9) << i;
    EXPECT_NEAR(e.distance(at(0.37)), 0, 1e-9) << i;
  }
}

/// Points of the paths that are drawn in this colour, but for those of the legend.
std::vector<Point> points_of(const std::string& svg, const std::string& colour) {
  std::vector<Point> points;
  const std::regex path("<path d=\"([^\"]*)\" fill=\"none\" stroke=\"" + colour);
  const std::regex point("[ML](-?[0-9.]+) (-?[0-9.]+)");
  for (std::sregex_iterator i(svg.begin(), svg.end(), path), none; i != none; ++i) {
    const std::string d = (*i)[1];
    if (d.find('h') != std::string::npos) continue;
    for (std::sregex_iterator k(d.begin(), d.end(), point); k != none; ++k) {
      points.push_back({std::stod((*k)[1]), -std::stod((*k)[2]), 0});
    }
  }
  return points;
}

TEST(PathDrawing, FewPointsDrawAnyPathExactly) {
  // Noise, a spiral, a way back over itself, a rest.
  std::mt19937 random(2);
  std::uniform_real_distribution<double> any(-0.002, 0.002);
  std::vector<Point> path;
  for (int i = 0; i < 3000; ++i) path.push_back({i * 0.01 + any(random), any(random), -0.5});
  for (int i = 3000; i > 0; --i) path.push_back({i * 0.01 + any(random), any(random), -0.5});
  for (int i = 0; i < 100; ++i) path.push_back({any(random), any(random), -0.5});
  for (int i = 0; i < 6000; ++i)
    path.push_back({i * 0.002 * std::cos(i * 0.005), i * 0.002 * std::sin(i * 0.005), -0.5});
  PathDrawing drawing("G1 X30 Z-1 F100\n", {0, 0, 0}, 1);
  for (const Point& p : path) drawing.add({p, p, 1, false});
  const std::vector<Point> drawn = points_of(drawing.svg("test"), "#f1731d");
  ASSERT_GT(drawn.size(), 10u);
  EXPECT_LT(drawn.size(), 700u);
  for (const Point& p : path) {
    double nearest = 1e9;
    for (std::size_t k = 1; k < drawn.size(); ++k) {
      Programmed line{drawn[k - 1], {}};
      line.segment.kind = Segment::kLine;
      line.segment.end = drawn[k];
      nearest = std::min(nearest, deviation({p[0], p[1], 0}, line));
    }
    EXPECT_LE(nearest, 0.01 + 0.0072) << p[0] << ' ' << p[1] << ": the tolerance, and two decimals";
  }
}

TEST(PathDrawing, TellsDeviationAndFollowingError) {
  PathDrawing drawing("G1 X10 F100\nG3 X0 R5 Z-2\n", {0, 0, 0}, 1);
  drawing.add({{5, 0.003, 0}, {5, 0.003, 0.0005}, 1, false});
  EXPECT_NEAR(drawing.deviation(), 0.003, 1e-12);
  EXPECT_NEAR(drawing.following_error(), 0.0005, 1e-12);
  drawing.add({{5, 5.004, -1.003}, {4.98, 5.004, -1.003}, 2, false});
  EXPECT_NEAR(drawing.deviation(), 0.005, 1e-6);
  EXPECT_NEAR(drawing.following_error(), 0.02, 1e-12);
  const std::string svg = drawing.svg("a <b> & \"c\"\x01");
  EXPECT_NE(svg.find("a &lt;b&gt; &amp; &quot;c&quot;?</title>"), std::string::npos) << svg;
  EXPECT_NE(svg.find("at most 0.005 mm from the program, axes at most 0.02 mm"), std::string::npos) << svg;
}

TEST(PathDrawing, ShowsRapidsDashedAndDepthsInColours) {
  PathDrawing drawing("G0 X10\nG1 X20 Z-1 F100\nX30\nG0 Z1\n", {0, 0, 0}, 1);
  for (int i = 0; i <= 300; ++i) {
    const double x = i * 0.1;
    const Vector p{x, 0, x < 10 ? 0 : std::max(-1.0, (10 - x) / 10)};
    drawing.add({p, p, x < 10 ? 1 : x < 20 ? 2 : 3, false});
  }
  const std::string svg = drawing.svg("test");
  EXPECT_EQ(points_of(svg, "#6b7280"), (std::vector<Point>{{0, 0, 0}, {9.9, 0, 0}})) << "rapid, dashed";
  EXPECT_NE(svg.find("#6b7280\" stroke-width"), std::string::npos);
  EXPECT_EQ(points_of(svg, "#f1731d").back(), (Point{30, 0, 0})) << "down to -1";
  EXPECT_EQ(points_of(svg, "#fbb61a"), (std::vector<Point>{{9.9, 0, 0}, {10, 0, 0}})) << "at Z = 0";
  EXPECT_EQ(count(svg, "stroke=\"#e5e7eb\" stroke-width=\"1\""), 1u) << "the programmed path, as wide as the tool";
}

class PathPlot : public testing::Test {
 protected:
  PathPlot() {
    std::ofstream(program) << "G1 X10 F100\nM30\n";
    plot.port<FileName>("PART") = std::string_view(program);
    plot.port<FileName>("FILE") = std::string_view(file);
  }
  void move(int cycles) {
    plot.port<bool>("RECORD") = true;
    for (int i = 0; i < cycles; ++i) {
      plot.port<double>("SET_X") = plot.port<double>("X") = i * 0.01;
      plot.port<std::int32_t>("LINE") = 1;
      plot.fire();
    }
  }
  void end() {
    plot.port<bool>("RECORD") = false;
    plot.fire();
  }
  [[nodiscard]] std::uint32_t pictures_after(std::uint32_t known) {
    for (int i = 0; i < 500; ++i) {
      plot.fire();
      if (plot.port<std::uint32_t>("PICTURES") != known || plot.port<std::int32_t>("ERROR") != 0) break;
      std::this_thread::sleep_for(milliseconds(10));
    }
    return plot.port<std::uint32_t>("PICTURES");
  }
  /// Files of this process, since tests run side by side; gone when the component is.
  struct Files {
    std::string program = testing::TempDir() + "path_plot." + std::to_string(::getpid()) + ".nc";
    std::string picture = testing::TempDir() + "path_plot." + std::to_string(::getpid()) + ".svg";
    ~Files() {
      for (const std::string& name : {program, picture}) std::remove(name.c_str());
    }
  };
  Files files;
  const std::string& program = files.program;
  const std::string& file = files.picture;
  picard::Instance plot{picard_library_v1(), "PATH_PLOT", milliseconds(1)};
};

TEST_F(PathPlot, WritesAPictureOfEachRecording) {
  for (std::uint32_t i = 0; i < 3; ++i) {
    move(500);
    end();
    EXPECT_EQ(pictures_after(i), i + 1);
    const std::string svg = text_of(file);
    EXPECT_EQ(points_of(svg, "#fbb61a").back(), (Point{4.99, 0, 0}));
    EXPECT_EQ(svg.substr(svg.size() - 7), "</svg>\n");
    EXPECT_EQ(plot.port<double>("DEVIATION"), 0);
  }
  EXPECT_EQ(plot.port<std::uint32_t>("DROPPED"), 0u);
  EXPECT_FALSE(std::ifstream(file + ".new").good());
}

TEST_F(PathPlot, ARecordingThatThePlcEndsIsDrawnAsWell) {
  {
    picard::Instance stopped{picard_library_v1(), "PATH_PLOT", milliseconds(1)};
    stopped.port<FileName>("PART") = std::string_view(program);
    stopped.port<FileName>("FILE") = std::string_view(file);
    stopped.port<bool>("RECORD") = true;
    stopped.fire();
  }
  EXPECT_NE(text_of(file).find("</svg>"), std::string::npos);
}

TEST_F(PathPlot, WhatDoesNotFitIsCountedAndTheEndIsKept) {
  plot.port<std::int32_t>("BUFFER") = 1000;
  move(300000);  // in no time for the thread
  end();
  EXPECT_GT(plot.port<std::uint32_t>("DROPPED"), 1000u);
  EXPECT_EQ(pictures_after(0), 1u);
}

TEST_F(PathPlot, AFileThatCannotBeWrittenIsAnError) {
  plot.port<FileName>("FILE") = std::string_view("/no/such/folder/path.svg");
  move(10);
  end();
  EXPECT_EQ(pictures_after(0), 0u);
  EXPECT_EQ(plot.port<std::int32_t>("ERROR"), ENOENT);
}

TEST_F(PathPlot, AtRestNothingIsRecordedAndNothingIsAllocated) {
  plot.port<std::int32_t>("BUFFER") = 1000;
  plot.ready();
  EXPECT_EQ(plc::test::allocations_of([this] {
              for (int i = 0; i < 100; ++i) move(1);
              end();
            }),
            0u);
  plot.port<bool>("RECORD") = true;
  for (int i = 0; i < 100000; ++i) plot.fire();
  EXPECT_EQ(plot.port<std::uint32_t>("DROPPED"), 0u);
}

TEST_F(PathPlot, WhatCannotWorkIsRefused) {
  plot.port<FileName>("PART") = std::string_view("/no/such/part.nc");
  EXPECT_THROW(plot.ready(), std::runtime_error);
  plot.port<FileName>("PART") = std::string_view(program);
  plot.port<double>("TOOL") = std::nan("");
  EXPECT_THROW(plot.ready(), std::runtime_error);
  plot.port<double>("TOOL") = 1;
  plot.port<std::int32_t>("BUFFER") = 0;
  EXPECT_THROW(plot.ready(), std::runtime_error);
}

}  // namespace
}  // namespace cnc
