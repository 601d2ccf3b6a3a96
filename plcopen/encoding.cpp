#include "plcopen/encoding.h"

#include "core/text.h"
#include "core/windows_1252.h"

namespace plc::plcopen {

namespace {

constexpr char32_t kReplacement = 0xFFFD;

std::size_t append(char32_t c, char* out) {
  const auto put = [&](std::size_t i, char32_t bits) {
    if (out != nullptr) out[i] = static_cast<char>(static_cast<unsigned char>(bits));
  };
  if (c < 0x80) return put(0, c), 1;
  if (c < 0x800) return put(0, 0xC0 | (c >> 6)), put(1, 0x80 | (c & 0x3F)), 2;
  if (c < 0x10000) {
    put(0, 0xE0 | (c >> 12));
    put(1, 0x80 | ((c >> 6) & 0x3F));
    put(2, 0x80 | (c & 0x3F));
    return 3;
  }
  put(0, 0xF0 | (c >> 18));
  put(1, 0x80 | ((c >> 12) & 0x3F));
  put(2, 0x80 | ((c >> 6) & 0x3F));
  put(3, 0x80 | (c & 0x3F));
  return 4;
}

/// The character at `i`, which moves past it.
char32_t next(std::string_view bytes, Encoding::Kind kind, std::size_t& i) {
  const auto byte = [&](std::size_t at) { return static_cast<char32_t>(static_cast<unsigned char>(bytes[at])); };
  if (kind == Encoding::Kind::kLatin1 || kind == Encoding::Kind::kWindows1252) {
    const char32_t c = byte(i++);
    return kind == Encoding::Kind::kWindows1252 ? char32_t{core::from_windows_1252(static_cast<std::uint8_t>(c))} : c;
  }
  const auto unit = [&](std::size_t at) {
    return kind == Encoding::Kind::kUtf16Le ? byte(at) | (byte(at + 1) << 8) : (byte(at) << 8) | byte(at + 1);
  };
  if (i + 1 >= bytes.size()) return i = bytes.size(), kReplacement;
  const char32_t high = unit(i);
  i += 2;
  if (high < 0xD800 || high > 0xDFFF) return high;
  if (high > 0xDBFF || i + 1 >= bytes.size()) return kReplacement;
  const char32_t low = unit(i);
  if (low < 0xDC00 || low > 0xDFFF) return kReplacement;
  i += 2;
  return 0x10000 + ((high - 0xD800) << 10) + (low - 0xDC00);
}

std::string declared_encoding(std::string_view bytes) {
  std::string_view head = bytes.substr(0, 256);
  if (!head.starts_with("<?xml")) return {};
  head = head.substr(0, head.find("?>"));
  std::size_t at = head.find("encoding");
  if (at == std::string_view::npos) return {};
  at = head.find_first_of("\"'", at);
  if (at == std::string_view::npos) return {};
  const std::size_t end = head.find(head[at], at + 1);
  return end == std::string_view::npos ? std::string() : std::string(head.substr(at + 1, end - at - 1));
}

}  // namespace

Encoding detect_encoding(std::string_view bytes) {
  using Kind = Encoding::Kind;
  if (bytes.starts_with("\xEF\xBB\xBF")) return {Kind::kUtf8, 3, "UTF-8"};
  if (bytes.starts_with("\xFF\xFE")) return {Kind::kUtf16Le, 2, "UTF-16LE"};
  if (bytes.starts_with("\xFE\xFF")) return {Kind::kUtf16Be, 2, "UTF-16BE"};
  if (bytes.starts_with(std::string_view("<\0", 2))) return {Kind::kUtf16Le, 0, "UTF-16LE"};
  if (bytes.starts_with(std::string_view("\0<", 2))) return {Kind::kUtf16Be, 0, "UTF-16BE"};
  struct Known {
    std::string_view name;
    Kind kind;
  };
  // A declared UTF-16 whose bytes are not (a .NET StringWriter saved as UTF-8) is what its bytes are.
  static constexpr Known kKnown[] = {
      {"utf-8", Kind::kUtf8},         {"utf8", Kind::kUtf8},        {"us-ascii", Kind::kUtf8},
      {"ascii", Kind::kUtf8},         {"utf-16", Kind::kUtf8},      {"unicode", Kind::kUtf8},
      {"iso-8859-1", Kind::kLatin1},  {"iso8859-1", Kind::kLatin1}, {"iso_8859-1", Kind::kLatin1},
      {"latin1", Kind::kLatin1},      {"latin-1", Kind::kLatin1},   {"windows-1252", Kind::kWindows1252},
      {"cp1252", Kind::kWindows1252},
  };
  std::string name = declared_encoding(bytes);
  if (name.empty()) return {};
  for (const Known& known : kKnown) {
    if (core::iequals(known.name, name)) return {known.kind, 0, std::move(name)};
  }
  return {Kind::kUnknown, 0, std::move(name)};
}

std::size_t utf8_size(std::string_view bytes, Encoding::Kind kind) {
  std::size_t size = 0;
  for (std::size_t i = 0; i < bytes.size();) size += append(next(bytes, kind, i), nullptr);
  return size;
}

void to_utf8(std::string_view bytes, Encoding::Kind kind, char* out) {
  for (std::size_t i = 0; i < bytes.size();) out += append(next(bytes, kind, i), out);
}

}  // namespace plc::plcopen
