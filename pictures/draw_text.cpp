// Texts: numbered lines, a bar beside statements that were executed, values behind the line that names them.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>

#include "pictures/canvas.h"

namespace plc::pictures {
namespace {

using bytecode::DrawnKey;
using bytecode::DrawnSide;

constexpr std::int32_t kLeft = 12;
constexpr std::int32_t kTab = 4;

/// With blanks in place of tabs.
std::string expanded(std::string_view line) {
  std::string out;
  std::int32_t column = 0;
  for (const char c : line) {
    if (c == '\t') {
      const std::int32_t blanks = kTab - column % kTab;
      out.append(static_cast<std::size_t>(blanks), ' ');
      column += blanks;
    } else if (c != '\r') {
      out += c;
      column += (static_cast<unsigned char>(c) & 0xc0u) != 0x80u ? 1 : 0;
    }
  }
  return out;
}

/// What is known of a line: the look of the first statement that begins in it, and values of names.
struct Line {
  Look look = Look::kPlain;
  bool statement = false;
  std::string values;
};

}  // namespace

void draw_text(Canvas& canvas, const bytecode::DrawnBody& body, const Known& known, std::int32_t top) {
  std::map<std::uint32_t, Line> lines;
  for (const bytecode::DrawnStatement& statement : body.statements) {
    const Mark* const mark = known.at(bytecode::key_of(known.pou(), statement));
    Line& line = lines[statement.line];
    if (mark == nullptr || line.statement) continue;
    line.statement = true;
    line.look = mark->look;
  }
  for (const auto& [key, mark] : known.all()) {
    if (key.pou != known.pou() || key.local_id >= 0 || key.side != DrawnSide::kOutput || mark.text.empty()) continue;
    std::string& values = lines[key.line].values;
    values += (values.empty() ? "" : "  ") + mark.text;
  }
  const std::string_view text = body.text;
  const std::int32_t pitch = bytecode::kDrawnLineHeight + 2;
  std::uint32_t count = 1;
  for (const char c : text) count += c == '\n' ? 1 : 0;
  const std::int32_t numbers = width_of(std::to_string(body.text_line + count));
  const std::int32_t left = kLeft + numbers + 18;
  std::int32_t y = top + kLeft + bytecode::kDrawnLineHeight;
  std::size_t begin = 0;
  for (std::uint32_t i = 0; i < count; ++i, y += pitch) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string shown = expanded(text.substr(begin, end - begin));
    begin = end + 1;
    const std::uint32_t number = body.text_line + i;
    const auto found = lines.find(number);
    canvas.text(kLeft + numbers, y, std::to_string(number), Anchor::kEnd, "quiet");
    const Line line = found == lines.end() ? Line{} : found->second;
    if (line.look != Look::kPlain) {
      canvas.put(fmt::format("<path class=\"shape{}\" d=\"M{},{}v{}\"><title>{}</title></path>", class_of(line.look),
                             kLeft + numbers + 9, y - bytecode::kDrawnLineHeight + 3, pitch, word_of(line.look)));
    }
    const bool quiet = line.look == Look::kNotRun;
    canvas.text(left, y, shown, Anchor::kStart, quiet ? "quiet" : "");
    canvas.text(left + width_of(shown) + 16, y, line.values, Anchor::kStart, "value");
    canvas.put("\n");
  }
}

}  // namespace plc::pictures
