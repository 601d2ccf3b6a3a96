// Excerpt: the line of a file that a message is about, and a caret under the column.
//
// In: the files as they are when messages are printed. Out: two lines of text. Does not belong here: what a message
// says.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace plc::core {

/// What tells a changed file from the one that was read.
struct FileStamp {
  std::int64_t size = -1;  ///< -1: there was no such file
  std::int64_t modified_ns = 0;
  friend bool operator==(const FileStamp&, const FileStamp&) = default;
};
FileStamp stamp_of(const std::string& path);

class Excerpts {
 public:
  /// " 212 |   Lvel := 3;\n     |   ^\n" for a line and column that count from 1; columns count characters. Tabs stay,
  /// long lines are cut around the column. Empty when the file cannot be read, is not the one that `stamp` was taken
  /// of, or has no such place.
  std::string of(const std::string& path, const FileStamp& stamp, std::uint32_t line, std::uint32_t column);

 private:
  struct File {
    std::string text;
    std::vector<std::size_t> lines;  ///< where each begins
  };
  const File* open(const std::string& path, const FileStamp& stamp);

  std::map<std::string, std::optional<File>> files_;
};

}  // namespace plc::core
