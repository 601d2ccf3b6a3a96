// Texts: numbered lines, a bar beside statements that were executed, values behind the line that names them.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "bytecode/drawn_lines.h"
#include "pictures/canvas.h"

namespace plc::pictures {
namespace {

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

/// A place whose value stands behind its line.
struct Shown {
  const Mark* mark = nullptr;
  std::uint32_t column = 0;
};

/// What is known of a line: the mark of the first statement that begins in it, and values of names.
struct Line {
  const Mark* statement = nullptr;
  std::vector<Shown> values;
};

class TextPieces final : public Pieces {
 public:
  TextPieces(const bytecode::DrawnBody& body, const Known& known, std::int32_t top)
      : body_(body), text_(body), known_(known), top_(top) {
    for (const bytecode::DrawnStatement& statement : body.statements) {
      const Mark* const mark = known.at(bytecode::key_of(known.pou(), statement));
      Line& line = lines_[statement.line];
      if (mark != nullptr && line.statement == nullptr) line.statement = mark;
    }
    for (const auto& [key, mark] : known.all()) {
      if (key.pou != known.pou() || key.local_id >= 0 || key.side != DrawnSide::kOutput) continue;
      if (mark.text.empty() && mark.id < 0) continue;
      lines_[key.line].values.push_back({&mark, key.column});
    }
    numbers_ = width_of(std::to_string(body.text_line + text_.count()));
  }

  [[nodiscard]] std::size_t count() const override { return text_.count(); }

  void draw(std::size_t piece, Canvas& canvas) const override {
    const std::int32_t pitch = bytecode::kDrawnLineHeight + 2;
    const std::int32_t left = kLeft + numbers_ + 18;
    const std::int32_t y = top_ + kLeft + bytecode::kDrawnLineHeight + static_cast<std::int32_t>(piece) * pitch;
    const std::string shown = expanded(text_.line(piece).substr(0, kMostColumns));
    const auto number = body_.text_line + static_cast<std::uint32_t>(piece);
    const auto found = lines_.find(number);
    canvas.text(kLeft + numbers_, y, std::to_string(number), Anchor::kEnd, "quiet");
    const Mark* const statement = found == lines_.end() ? nullptr : found->second.statement;
    if (statement != nullptr && (statement->look != Look::kPlain || statement->id >= 0)) {
      canvas.put(fmt::format("<path {} d=\"M{},{}v{}\"><title>{}</title></path>", attributes_of("shape", statement),
                             kLeft + numbers_ + 9, y - bytecode::kDrawnLineHeight + 3, pitch,
                             word_of(statement->look)));
    }
    if (known_.live()) {
      canvas.text(left, y, shown, Anchor::kStart, {}, statement);
    } else {
      const bool quiet = statement != nullptr && statement->look == Look::kNotRun;
      canvas.text(left, y, shown, Anchor::kStart, quiet ? "quiet" : "");
    }
    if (found != lines_.end()) draw_values(found->second, number, left + width_of(shown) + 16, y, canvas);
    canvas.put("\n");
  }

 private:
  void draw_values(const Line& line, std::uint32_t number, std::int32_t x, std::int32_t y, Canvas& canvas) const {
    if (!known_.live()) {
      std::string values;
      for (const Shown& one : line.values) values += (values.empty() ? "" : "  ") + one.mark->text;
      canvas.text(x, y, values, Anchor::kStart, "value");
      return;
    }
    std::string parts;
    std::size_t characters = 0;
    for (std::size_t i = 0; i < std::min(line.values.size(), kMostValues); ++i) {
      const std::string_view name = text_.name_at(number, line.values[i].column).substr(0, kMostName);
      if (!name.empty())
        parts += fmt::format("<tspan class=\"name\" data-name=\"{0}\" tabindex=\"-1\" role=\"button\">{0}</tspan> ",
                             escaped(name));
      parts += fmt::format("<tspan data-k=\"{}\" data-words=\"1\"></tspan>   ", line.values[i].mark->id);
      characters += name.size() + kValueWidth;
    }
    if (parts.empty()) return;
    canvas.put(fmt::format("<text class=\"value\" x=\"{}\" y=\"{}\">{}</text>", x, y, parts));
    canvas.cover(x, y - bytecode::kDrawnLineHeight,
                 x + static_cast<std::int32_t>(characters) * bytecode::kDrawnCharWidth, y + 4);
  }

  static constexpr std::size_t kMostColumns = 100'000, kMostValues = 50, kMostName = 100, kValueWidth = 14;

  const bytecode::DrawnBody& body_;
  const bytecode::DrawnLines text_;
  const Known known_;
  std::int32_t top_;
  std::int32_t numbers_ = 0;
  std::map<std::uint32_t, Line> lines_;
};

}  // namespace

std::unique_ptr<Pieces> pieces_of_text(const bytecode::DrawnBody& body, const Known& known, std::int32_t top) {
  return std::make_unique<TextPieces>(body, known, top);
}

}  // namespace plc::pictures
