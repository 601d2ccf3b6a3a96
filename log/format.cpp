#include "log/format.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <ctime>

#include "core/utf8.h"

namespace plc::log {
namespace {

/// Of a character in UTF-8: those of ASCII, and U+0080 to U+009F, with which terminals do things, too.
bool is_control(std::string_view one) {
  const auto first = static_cast<unsigned char>(one.front());
  return first < 0x20 || first == 0x7f ||
         (first == 0xc2 && one.size() == 2 && static_cast<unsigned char>(one[1]) < 0xa0);
}

/// Details are lines: only the line feeds between them are as they were.
std::string printable_lines(std::string_view text) {
  std::string out;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    if (at != 0) out += '\n';
    out += printable(text.substr(at, end - at));
    at = end + 1;
  }
  return out;
}

/// Of printable text: quotes, backslashes and line feeds are what is left to escape.
std::string json_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    c == '\n' ? out += "\\n" : out += c;
  }
  return out + '"';
}

void add_field(std::string& to, std::string_view name, std::string_view value) {
  to += name;
  if (value.find('\n') == std::string_view::npos) {
    to += '=';
  } else {
    to += '\n';
    for (unsigned byte = 0; byte < 8; ++byte)
      to += static_cast<char>(static_cast<std::uint64_t>(value.size()) >> (8 * byte));
  }
  to += value;
  to += '\n';
}

}  // namespace

const char* word_of(core::Severity severity) {
  return severity == core::Severity::kError ? "error" : severity == core::Severity::kWarning ? "warning" : "note";
}

std::string printable(std::string_view text) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t begin = at;
    static_cast<void>(core::decode_utf8(text, at));
    const std::string_view one = text.substr(begin, at - begin);
    out += is_control(one) || !core::is_utf8(one) ? std::string_view("?") : one;
  }
  return out;
}

std::string time_text(core::TimeNs utc_ns) {
  constexpr core::TimeNs kMs = 1'000'000;
  const core::TimeNs ms = utc_ns / kMs;
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", fmt::gmtime(static_cast<std::time_t>(ms / 1000)), ms % 1000);
}

std::string text_line(const Record& record, bool with_time) {
  std::string out = with_time ? time_text(record.utc_ns) + ' ' : std::string();
  out += fmt::format("{}: {}\n", word_of(record.severity), printable(record.text));
  if (!record.details.empty()) out += printable_lines(record.details) + '\n';
  return out;
}

std::string json_line(const Record& record) {
  std::string out = fmt::format(R"({{"time": "{}", "severity": "{}", "message": {})", time_text(record.utc_ns),
                                word_of(record.severity), json_text(printable(record.text)));
  const auto add = [&out](std::string_view name, const std::string& value) {
    if (!value.empty()) out += fmt::format(R"(, "{}": {})", name, json_text(printable_lines(value)));
  };
  add("source", record.source);
  add("code", record.code);
  add("task", record.task);
  if (record.scan) out += fmt::format(R"(, "scan": {})", *record.scan);
  add("block", record.block);
  add("details", record.details);
  return out + "}\n";
}

std::string journal_datagram(const Record& record) {
  std::string out;
  add_field(out, "MESSAGE", printable(record.text));
  const bool error = record.severity == core::Severity::kError;
  add_field(out, "PRIORITY", error ? "3" : record.severity == core::Severity::kWarning ? "4" : "6");
  add_field(out, "SYSLOG_IDENTIFIER", "plc-run");
  const auto add = [&out](std::string_view name, const std::string& value) {
    if (!value.empty()) add_field(out, name, printable_lines(value));
  };
  add("PICARD_SOURCE", record.source);
  add("PICARD_CODE", record.code);
  add("PICARD_TASK", record.task);
  if (record.scan) add_field(out, "PICARD_SCAN", std::to_string(*record.scan));
  add("PICARD_BLOCK", record.block);
  add("PICARD_DETAILS", record.details);
  return out;
}

}  // namespace plc::log
