// LOG_MSG: a line for the log, from a drawing or ST.
//
// Its whole state is in its ports: so a replica that has them can tell the same again (runtime/taskblocks.cpp).
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "picard/taskblock.h"

namespace plc::blocks {

class LogMsg final : public picard::Taskblock {
 public:
  static constexpr std::size_t kValues = 4;
  static constexpr picard::Info info{
      .name = "LOG_MSG",
      .group = "Signals",
      .summary = "Tells the operator a line, in the log.",
      .details =
          "At each rising edge of EXECUTE, also in the first scan, TEXT becomes a message of the log: on the console, "
          "in the "
          "journal or a file, in `plc remote URL log --follow` and on the page Log, with the path of the block, the "
          "task, "
          "the scan and the time. In TEXT `{1}` to `{4}` stand for VALUE1 to VALUE4, whole numbers as they are and "
          "others with six "
          "digits; whatever else is in braces stays. A line has at most 159 bytes, the rest is cut off.\n\n"
          "The task never waits, and nothing is allocated: messages go through a ring of 128, which is emptied every "
          "20 ms. "
          "What finds no room is lost, and the log says how many. The log itself counts a line that comes again and "
          "again. "
          "SEVERITY is 0 for a note, 1 for a warning, 2 and more for an error.\n\n"
          "`plc sim` prints the same with the virtual time, and `plc replay` what was told in recorded scans. COUNT "
          "counts "
          "what was told since the start."};

  picard::Input<bool> execute{this, "EXECUTE", "its rising edge tells"};
  picard::Input<std::int32_t> severity{this, "SEVERITY", "0 note, 1 warning, 2 error"};
  picard::Input<picard::Text<159>> text{this, "TEXT", "the line; {1} to {4} stand for values"};
  picard::Input<double> value[kValues]{{this, "VALUE1", "for {1}"},
                                       {this, "VALUE2", "for {2}"},
                                       {this, "VALUE3", "for {3}"},
                                       {this, "VALUE4", "for {4}"}};
  picard::Output<bool> done{this, "DONE", "EXECUTE at the last execution"};
  picard::Output<std::uint32_t> count{this, "COUNT", "messages told"};

  void fire() override {
    const bool rises = execute.get() && !done.get();
    done = execute.get();
    if (!rises) return;
    count = count + 1;
    std::array<char, PICARD_TEXT_BYTES> line{};
    fill_in(line);
    tell(severity <= 0   ? picard::Severity::Note
         : severity == 1 ? picard::Severity::Warning
                         : picard::Severity::Error,
         "%s", line.data());
  }

 private:
  /// Whole numbers as they are, others with six digits.
  template <class Add>
  static void add_number(double number, const Add& add) {
    std::array<char, 32> digits{};
    char* const end = digits.data() + digits.size();
    const bool whole = std::abs(number) < 1e15 && number == std::trunc(number);
    const auto written = whole ? std::to_chars(digits.data(), end, static_cast<std::int64_t>(number))
                               : std::to_chars(digits.data(), end, number, std::chars_format::general, 6);
    add(std::string_view(digits.data(), static_cast<std::size_t>(written.ptr - digits.data())));
  }

  /// The last byte stays 0.
  void fill_in(std::array<char, PICARD_TEXT_BYTES>& line) const {
    std::size_t at = 0;
    const auto add = [&](std::string_view piece) {
      const std::size_t fits = std::min(piece.size(), line.size() - 1 - at);
      std::memcpy(line.data() + at, piece.data(), fits);
      at += fits;
    };
    std::string_view rest = text->view();
    while (!rest.empty()) {
      const bool stands_for = rest.size() >= 3 && rest[0] == '{' && rest[2] == '}' && rest[1] >= '1' &&
                              rest[1] < static_cast<char>('1' + kValues);
      if (stands_for) {
        add_number(value[rest[1] - '1'], add);
        rest.remove_prefix(3);
      } else {
        // A byte of 0 would end the line.
        add(rest[0] == '\0' ? std::string_view(" ") : rest.substr(0, 1));
        rest.remove_prefix(1);
      }
    }
  }
};

}  // namespace plc::blocks
