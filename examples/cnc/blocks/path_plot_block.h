// PATH_PLOT: draws the path that a part program asks for and the one that the axes take.
#pragma once

#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <string>

#include "path_plot.h"
#include "picard/taskblock.h"

namespace cnc {

class PathPlotBlock final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "PATH_PLOT",
      .group = "CNC",
      .summary = "Draws the path of a part program and the one that the axes take, into an SVG file.",
      .details =
          "While RECORD is TRUE it takes a sample in each cycle in which something moves. When RECORD becomes FALSE, "
          "or the PLC stops, FILE is replaced by a picture: seen from above, the programmed path as wide as the tool, "
          "on it the one of the axes in colours of depth, rapids dashed. DEVIATION and FOLLOWING_ERROR tell how far "
          "set points were from the program, and axes from their set points.\n\n"
          "The program is taken to begin where the axes are at the rising edge of RECORD, as GCODE does at START.\n\n"
          "The task never waits: a thread draws, every 20 ms. When BUFFER samples wait for it, further ones are "
          "dropped and counted. When FILE cannot be written, ERROR is the number that Linux gives the reason."};

  picard::Config<picard::Text<255>> part{this, "PART", "the part program, from the folder in which the PLC runs"};
  picard::Config<picard::Text<255>> file{
      this, "FILE", "the picture, from the folder in which the PLC runs", {.initial = "'path.svg'"}};
  picard::Config<double> tool{
      this, "TOOL", "diameter of the tool", {.unit = "mm", .lowest = 0.01, .highest = 1000, .initial = "1.0"}};
  picard::Config<std::int32_t> buffer{
      this, "BUFFER", "samples that may wait", {.lowest = 1000, .highest = 10000000, .initial = "131072"}};
  picard::Input<bool> record{this, "RECORD", "TRUE: record; falling edge: draw"};
  picard::Input<double> set[3]{{this, "SET_X", "set point", {.unit = "mm"}},
                               {this, "SET_Y", "set point", {.unit = "mm"}},
                               {this, "SET_Z", "set point", {.unit = "mm"}}};
  picard::Input<double> actual[3]{{this, "X", "position of the axis", {.unit = "mm"}},
                                  {this, "Y", "position of the axis", {.unit = "mm"}},
                                  {this, "Z", "position of the axis", {.unit = "mm"}}};
  picard::Input<std::int32_t> line{this, "LINE", "of the part program, that is being travelled"};
  picard::Output<std::uint32_t> pictures{this, "PICTURES", "that were written"};
  picard::Output<double> deviation{this, "DEVIATION", "greatest, in the last picture", {.unit = "mm"}};
  picard::Output<double> following_error{
      this, "FOLLOWING_ERROR", "greatest of any axis, in the last picture", {.unit = "mm"}};
  picard::Output<std::uint32_t> dropped{this, "DROPPED", "samples that are lost"};
  picard::Output<std::int32_t> error{this, "ERROR", "why the last picture is missing, 0 = it is not"};

  void ready() override {
    if (!(tool >= 0.01 && tool <= 1000)) throw picard::Failure("PATH_PLOT: TOOL must be from 0.01 to 1000 mm");
    if (buffer < 1000 || buffer > 10000000) throw picard::Failure("PATH_PLOT: BUFFER must be from 1000 to 10000000");
    if (file->empty()) throw picard::Failure("PATH_PLOT: FILE has no name");
    PathPlot::Options options;
    options.title = std::string(part->view());
    options.file = std::string(file->view());
    options.tool = tool;
    options.samples = static_cast<std::size_t>(buffer.get());
    std::ifstream in(options.title, std::ios::binary);
    if (!in) {
      throw std::runtime_error("PATH_PLOT: cannot read part program '" + options.title + "': " + std::strerror(errno));
    }
    options.program.assign(std::istreambuf_iterator<char>(in), {});
    plot_.emplace(std::move(options));
  }

  void fire() override {
    if (record) {
      PathSample sample{{set[0], set[1], set[2]}, {actual[0], actual[1], actual[2]}, line, false};
      const bool moved = sample.set != before_.set || sample.actual != before_.actual;
      if (!unended_ || moved) take(sample);
      before_ = sample;
      unended_ = true;
    } else if (unended_) {
      // The end must not get lost: it waits for room.
      unended_ = !plot_->push({.last = true});
    }
    pictures = plot_->pictures();
    deviation = plot_->deviation();
    following_error = plot_->following_error();
    error = plot_->error();
  }

 private:
  void take(const PathSample& sample) {
    if (!plot_->push(sample)) dropped = dropped + 1;
  }

  std::optional<PathPlot> plot_;  ///< made in ready()
  PathSample before_;
  bool unended_ = false;  ///< samples were recorded, whose end was not told yet
};

}  // namespace cnc
