#include "core/excerpt.h"

#include <sys/stat.h>

#include <algorithm>
#include <fstream>

namespace plc::core {
namespace {

/// Larger files are not read a second time for the sake of a message.
constexpr std::int64_t kMaxBytes = std::int64_t{64} << 20;
/// Characters shown of a line; when the column lies beyond kLastWhole, those from kMaxBefore before it.
constexpr std::size_t kMaxShown = 100;
constexpr std::size_t kLastWhole = 80;
constexpr std::size_t kMaxBefore = 60;

bool is_continuation(char c) { return (static_cast<unsigned char>(c) & 0xC0u) == 0x80u; }

/// Bytes of the character at `i`, 1 where it is no UTF-8.
std::size_t character_length(std::string_view text, std::size_t i) {
  const auto lead = static_cast<unsigned char>(text[i]);
  const std::size_t length = lead < 0xC2 ? 1 : lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : lead < 0xF5 ? 4 : 1;
  if (text.size() - i < length) return 1;
  for (std::size_t k = 1; k < length; ++k) {
    if (!is_continuation(text[i + k])) return 1;
  }
  return length;
}

/// One character as it can be shown: control characters, and bytes that are no UTF-8, as '?'.
std::string_view shown(std::string_view character) {
  const auto c = static_cast<unsigned char>(character[0]);
  if (character.size() == 1 && c != '\t' && (c < 0x20 || c >= 0x7F)) return "?";
  // C1 controls, two bytes in UTF-8, end up in terminals too.
  if (character.size() == 2 && c == 0xC2 && static_cast<unsigned char>(character[1]) < 0xA0) return "?";
  return character;
}

}  // namespace

FileStamp stamp_of(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return {};
  return {status.st_size, std::int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec};
}

const Excerpts::File* Excerpts::open(const std::string& path, const FileStamp& stamp) {
  const auto [entry, fresh] = files_.try_emplace(path);
  std::optional<File>& file = entry->second;
  if (!fresh) return file ? &*file : nullptr;
  if (stamp.size < 0 || stamp.size > kMaxBytes || stamp_of(path) != stamp) return nullptr;
  std::ifstream in(path, std::ios::binary);
  File read;
  read.text.resize(static_cast<std::size_t>(stamp.size));
  in.read(read.text.data(), stamp.size);
  // UTF-16 is not worth the trouble here.
  if (!in || read.text.starts_with("\xFF\xFE") || read.text.starts_with("\xFE\xFF")) return nullptr;
  if (read.text.starts_with("\xEF\xBB\xBF")) read.text.erase(0, 3);
  read.lines.push_back(0);
  for (std::size_t i = read.text.find('\n'); i != std::string::npos; i = read.text.find('\n', i + 1)) {
    read.lines.push_back(i + 1);
  }
  file = std::move(read);
  return &*file;
}

std::string Excerpts::of(const std::string& path, const FileStamp& stamp, std::uint32_t line, std::uint32_t column) {
  if (line == 0 || column == 0) return {};
  const File* file = open(path, stamp);
  if (file == nullptr || line > file->lines.size()) return {};
  const std::size_t begin = file->lines[line - 1];
  const std::size_t end = line < file->lines.size() ? file->lines[line] - 1 : file->text.size();
  std::string_view text = std::string_view(file->text).substr(begin, end - begin);
  while (text.ends_with('\r')) text.remove_suffix(1);

  const std::size_t first = column > kLastWhole ? column - 1 - kMaxBefore : 0;
  std::string source;
  std::string caret;
  std::size_t character = 0;
  std::size_t i = 0;
  for (; i < text.size() && character < first + kMaxShown; ++character) {
    const std::string_view one = text.substr(i, character_length(text, i));
    i += one.size();
    if (character < first) continue;
    source += shown(one);
    if (character + 1 < column) caret += one == "\t" ? '\t' : ' ';
  }
  if (character + 1 < column) return {};  // the line is shorter: not the line that was read
  if (first != 0) {
    source.insert(0, "...");
    caret.insert(0, "   ");
  }
  if (i < text.size()) source += "...";
  const std::string number = std::to_string(line);
  std::string out = " " + number + " | " + source + '\n';
  out += std::string(number.size() + 1, ' ') + " | " + caret + "^\n";
  return out;
}

}  // namespace plc::core
