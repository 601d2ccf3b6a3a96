// A reader of part programs: the G-code that a three-axis mill needs, block by block, into segments. Form and order of
// execution follow ISO 6983-1 and T. Kramer, F. Proctor, E. Messina, The NIST RS274NGC Interpreter, NISTIR 6556.
//
// In: the text. Out: segments. Not here: files, ports, speeds of axes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "segment.h"

namespace cnc {

/// What is wrong with a part program. The text is a literal.
struct Mistake {
  const char* text = nullptr;  ///< null: nothing is
  std::int32_t line = 0;       ///< from 1
  std::int32_t column = 0;     ///< from 1
};

class Interpreter {
 public:
  /// Segments of one block at most: M-codes before and after the motion, the motion, the end.
  static constexpr std::size_t kMostSegments = 8;
  static constexpr std::size_t kMostWords = 32;
  struct Segments {
    std::array<Segment, kMostSegments> all;
    std::size_t count = 0;
  };

  /// From the beginning of `program`, with the tool at `position` and nothing modal set but G17 G21 G90. The text must
  /// outlive the interpreter.
  void start(std::string_view program, const std::array<double, 3>& position) noexcept;

  /// Reads the next block, one line. After a mistake, the end of the text or M2 there is nothing more to read.
  /// RT: bounded by the length of the line.
  void next(Segments& out) noexcept;

  [[nodiscard]] bool finished() const noexcept { return finished_; }
  [[nodiscard]] const Mistake& mistake() const noexcept { return mistake_; }
  [[nodiscard]] std::int32_t line() const noexcept { return line_; }

 private:
  struct Word {
    char letter = 0;
    double value = 0;
    std::int32_t column = 0;
  };
  struct Block {
    std::array<Word, kMostWords> words;
    std::size_t count = 0;
    [[nodiscard]] const Word* find(char letter) const noexcept;
  };
  /// What a block asks for besides what it sets.
  struct Request {
    const Word* dwell = nullptr;
    const Word* motion = nullptr;  ///< G0 to G3 in this block
    std::array<const Word*, 4> codes{};
    std::size_t code_count = 0;
  };

  bool fail(std::int32_t column, const char* text) noexcept;
  bool scan(std::string_view line, Block& block) noexcept;
  bool scan_number(std::string_view line, std::size_t& at, double& value) noexcept;
  bool interpret(const Block& block, Segments& out) noexcept;
  bool set_modes(const Block& block, Request& request) noexcept;
  bool set_g(const Word& word, Request& request) noexcept;
  bool move(const Block& block, const Request& request, Segments& out) noexcept;
  bool set_arc(const Block& block, const Word& where, Segment& segment) noexcept;
  void add_codes(const Request& request, bool after_motion, Segments& out) noexcept;
  void add(Segments& out, Segment segment) const noexcept;

  std::string_view rest_;
  std::array<double, 3> position_{};
  int motion_ = -1;  ///< G0 to G3, -1 before the first
  bool inches_ = false;
  bool incremental_ = false;
  double feed_ = 0;     ///< mm/s
  double spindle_ = 0;  ///< 1/min
  std::int32_t line_ = 0;
  bool finished_ = true;
  Mistake mistake_;
};

}  // namespace cnc
