#include "io-drivers/config/read_historian.h"

#include "io-drivers/config/table_file.h"

namespace plc::io {
namespace {

using namespace key;

constexpr KeyInfo kKeys[] = {
    {"tags", texts(), required("[\"Level\"]"), "Paths, or patterns with * and ?, of variables that are kept."},
    {"interval", duration("10ms", "1h"), otherwise("\"100ms\""), "Between two samples."},
    {"days", integer(1, 36'500), otherwise("30"), "How long they are kept."},
    {"size", integer(10, 10'000'000), otherwise("5000"), "Megabytes that they take at most; the oldest go first."},
    {"folder", text(), otherwise("\"\""), "Where, relative to this file. Empty: the state folder."},
};
constexpr FileTable kTables[] = {{"historian", kKeys, false}};

}  // namespace

std::span<const KeyInfo> historian_keys() { return kKeys; }

std::optional<historian::Settings> read_historian(std::string_view text, std::string_view file,
                                                  core::Diagnostics& diagnostics) {
  const std::vector<ReadTable> tables = read_table_file(text, file, kTables, diagnostics);
  if (tables.empty()) return std::nullopt;
  const KeyValues& values = tables.front().values;
  historian::Settings settings;
  for (const Placed& tag : values.list("tags")) {
    settings.tags.push_back(tag.text);
    settings.tags_at.push_back(tag.at);
  }
  settings.interval_ns = values.number("interval");
  settings.days = static_cast<std::uint32_t>(values.number("days"));
  settings.most_bytes = static_cast<std::uint64_t>(values.number("size")) * 1'000'000;
  settings.folder = values.text("folder");
  return settings;
}

}  // namespace plc::io
