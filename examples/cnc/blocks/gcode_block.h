// GCODE: reads a part program and puts its segments into a queue.
#pragma once

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "gcode.h"
#include "picard/taskblock.h"

namespace cnc {

class GcodeBlock final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "GCODE",
      .group = "CNC",
      .summary = "Reads a part program and puts its segments into a queue.",
      .details =
          "G0 G1 G2 G3 (centre by I and J from the start, or R), G4 P with seconds, G17, G20 G21, G90 G91, F, S, N, "
          "M0 to M999, comments in parentheses or after a semicolon, a slash switches a block off. Modal words stay "
          "until they are said again. M0, M1, M2 and M30 follow the motion of their block, other M-codes precede "
          "it.\n\n"
          "The file is read once, when the task starts, and checked to its end: a program with a mistake sets ERROR, "
          "with MESSAGE, LINE and COLUMN, and is never begun. START (rising edge) begins at the first block, with X "
          "Y Z as the position of the tool. Each cycle reads BLOCKS blocks, as long as the queue has room. RUNNING "
          "ends when the last segment is in the queue. RESET ends it at once."};

  picard::Config<picard::Text<255>> file{this, "FILE", "the part program, from the folder in which the PLC runs"};
  picard::Config<std::int32_t> blocks{
      this, "BLOCKS", "blocks that are read in a cycle", {.lowest = 1, .highest = 1000, .initial = "8"}};
  picard::Input<bool> start{this, "START", "rising edge: from the first block on"};
  picard::Input<bool> reset{this, "RESET", "end at once"};
  picard::Input<double> x{this, "X", "position of the tool at START", {.unit = "mm"}};
  picard::Input<double> y{this, "Y", "position of the tool at START", {.unit = "mm"}};
  picard::Input<double> z{this, "Z", "position of the tool at START", {.unit = "mm"}};
  picard::QueueWriter<Segment> path{this, "PATH", "the segments"};
  picard::Output<bool> running{this, "RUNNING", "there are blocks left to read"};
  picard::Output<bool> error{this, "ERROR", "there is a mistake in the part program"};
  picard::Output<std::int32_t> line{this, "LINE", "line of the last block, or of the mistake"};
  picard::Output<std::int32_t> column{this, "COLUMN", "column of the mistake"};
  picard::Output<picard::Text<80>> message{this, "MESSAGE", "the mistake"};

  void ready() override {
    if (blocks < 1 || blocks > 1000) throw picard::Failure("GCODE: BLOCKS must be from 1 to 1000");
    const std::string name(file->view());
    std::ifstream in(name, std::ios::binary);
    if (!in) throw std::runtime_error("GCODE: cannot read part program '" + name + "': " + std::strerror(errno));
    program_.assign(std::istreambuf_iterator<char>(in), {});
    if (in.bad()) throw std::runtime_error("GCODE: cannot read part program '" + name + "' to its end");
    reader_.start(program_, {});
    while (!reader_.finished()) reader_.next(segments_);
    tell_mistake();
  }

  void fire() override {
    const bool begin = start && !started_;
    started_ = start;
    if (reset) {
      running = false;
    } else if (begin && !running && !error) {
      reader_.start(program_, {x, y, z});
      running = true;
    }
    for (std::int32_t i = 0; i < blocks && running && path.space() >= Interpreter::kMostSegments; ++i) {
      reader_.next(segments_);
      for (std::size_t k = 0; k < segments_.count; ++k) path.push(segments_.all[k]);
      line = reader_.line();
      running = !reader_.finished();
      tell_mistake();
    }
  }

 private:
  void tell_mistake() {
    const Mistake& mistake = reader_.mistake();
    if (mistake.text == nullptr) return;
    error = true;
    line = mistake.line;
    column = mistake.column;
    message->operator=(std::string_view(mistake.text));
  }

  std::string program_;
  Interpreter reader_;
  Interpreter::Segments segments_;
  bool started_ = false;
};

}  // namespace cnc
