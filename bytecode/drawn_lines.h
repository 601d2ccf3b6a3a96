// DrawnLines: the lines of the text of a body, by their numbers in the file.
//
// In: a body, which outlives it. Out: pieces of its text. Does not belong here: what they mean.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "bytecode/drawings.h"

namespace plc::bytecode {

class DrawnLines {
 public:
  explicit DrawnLines(const DrawnBody& body) : body_(&body) {
    for (std::size_t i = 0; i < body.text.size(); ++i) {
      if (body.text[i] == '\n') starts_.push_back(i + 1);
    }
  }
  [[nodiscard]] std::size_t count() const { return starts_.size(); }
  /// From 0 on.
  [[nodiscard]] std::string_view line(std::size_t row) const {
    const std::size_t end = row + 1 < starts_.size() ? starts_[row + 1] - 1 : body_->text.size();
    return std::string_view(body_->text).substr(starts_[row], end - starts_[row]);
  }
  /// What stands from a place of the file to the end of its line; empty when that is not in the text.
  [[nodiscard]] std::string_view from(std::uint32_t line, std::uint32_t column) const {
    if (line < body_->text_line || line - body_->text_line >= starts_.size()) return {};
    const std::size_t row = line - body_->text_line;
    const std::uint32_t first = row == 0 ? body_->text_column : 1;
    const std::string_view text = this->line(row);
    return column < first || column - first > text.size() ? std::string_view() : text.substr(column - first);
  }
  /// The name, path or number that begins there; empty when there is none.
  [[nodiscard]] std::string_view name_at(std::uint32_t line, std::uint32_t column) const {
    constexpr std::string_view kOfNames = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.[]^%#";
    const std::string_view text = from(line, column);
    return text.substr(0, text.find_first_not_of(kOfNames));
  }

 private:
  const DrawnBody* body_;
  std::vector<std::size_t> starts_{0};
};

}  // namespace plc::bytecode
