#include "doctor/process.h"

#include <algorithm>
#include <charconv>

#include "core/text.h"

namespace plc::doctor {

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t at = 0; (at = line.find_first_not_of(" \t", at)) != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(" \t", at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

std::optional<std::uint64_t> to_number(std::string_view text, int base) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::vector<int> parse_list(std::string_view text) {
  constexpr std::size_t kMost = 4096;
  std::vector<int> numbers;
  text = core::trimmed(text);
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(','), text.size());
    const std::string_view range = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::size_t dash = range.find('-');
    const auto first = to_number(range.substr(0, dash));
    const auto last = dash == std::string_view::npos ? first : to_number(range.substr(dash + 1));
    if (!first || !last) continue;
    for (std::uint64_t i = *first; i <= *last && i < kMost && numbers.size() < kMost; ++i) {
      numbers.push_back(static_cast<int>(i));
    }
  }
  return numbers;
}

Process::Process(const System& system, std::string_view id)
    : system_(system),
      folder_("/proc/" + std::string(id)),
      status_(system.read(folder_ + "/status").value_or("")),
      limits_(system.read(folder_ + "/limits").value_or("")) {}

std::optional<std::uint64_t> Process::limit(std::string_view name) const {
  for (const std::string_view line : lines_of(limits_)) {
    if (!line.starts_with(name)) continue;
    const auto words = words_of(line.substr(name.size()));
    if (words.empty()) return std::nullopt;
    return words[0] == "unlimited" ? kUnlimited : to_number(words[0]);
  }
  return std::nullopt;
}

std::optional<std::string> Process::status(std::string_view name) const {
  for (const std::string_view line : lines_of(status_)) {
    if (!line.starts_with(name) || line.size() <= name.size() || line[name.size()] != ':') continue;
    return std::string(core::trimmed(line.substr(name.size() + 1)));
  }
  return std::nullopt;
}

std::string Process::environment(std::string_view name) const {
  std::string text = system_.read(folder_ + "/environ").value_or("");
  std::replace(text.begin(), text.end(), '\0', '\n');
  for (const std::string_view line : lines_of(text)) {
    if (line.starts_with(name) && line.size() > name.size() && line[name.size()] == '=') {
      return std::string(line.substr(name.size() + 1));
    }
  }
  return {};
}

bool Process::has(Capability capability) const {
  const auto bits = to_number(status("CapEff").value_or(""), 16);
  return bits && (*bits >> static_cast<unsigned>(capability) & 1) != 0;
}

std::uint32_t Process::user() const {
  const std::string ids = status("Uid").value_or("");
  const auto words = words_of(ids);
  return words.size() < 2 ? 0 : static_cast<std::uint32_t>(to_number(words[1]).value_or(0));
}

bool Process::may(std::uint32_t access, const FileFacts& file) const {
  if (!known() || has(Capability::kDacOverride)) return true;
  if (file.owner == user()) return (file.mode >> 6 & access) == access;
  const std::string groups = status("Gid").value_or("") + " " + status("Groups").value_or("");
  for (const std::string_view group : words_of(groups)) {
    if (to_number(group) == file.group) return (file.mode >> 3 & access) == access;
  }
  return (file.mode & access) == access;
}

std::vector<int> Process::processors() const { return parse_list(status("Cpus_allowed_list").value_or("")); }

std::optional<std::string> Process::control(std::string_view controller, const std::string& file,
                                            bool (*limits)(const std::string& value)) const {
  const std::string groups = system_.read(folder_ + "/cgroup").value_or("");
  for (const std::string_view line : lines_of(groups)) {
    // "0::/system.slice/plc.service", "4:cpu,cpuacct:/docker/1234".
    const std::size_t first = line.find(':');
    const std::size_t second = first == std::string_view::npos ? first : line.find(':', first + 1);
    if (second == std::string_view::npos) continue;
    const std::string_view names = line.substr(first + 1, second - first - 1);
    if (!names.empty() &&
        ("," + std::string(names) + ",").find("," + std::string(controller) + ",") == std::string::npos)
      continue;
    std::string folder = "/sys/fs/cgroup" + (names.empty() ? std::string{} : "/" + std::string(names));
    const std::size_t top = folder.size();
    folder += line.substr(second + 1);
    for (;;) {
      auto value = system_.line(folder + "/" + file);
      if (value && limits(*value)) return value;
      if (folder.size() <= top) break;
      folder.resize(std::max(top, folder.rfind('/')));
    }
  }
  return std::nullopt;
}

std::optional<Process::Mount> Process::mount_of(const std::string& path) const {
  std::optional<Mount> found;
  std::size_t longest = 0;
  const std::string mounts = system_.read(folder_ + "/mounts").value_or("");
  for (const std::string_view line : lines_of(mounts)) {
    const auto words = words_of(line);
    if (words.size() < 4) continue;
    const std::string_view at = words[1];
    const bool below = at == "/" || (path.starts_with(at) && (path.size() == at.size() || path[at.size()] == '/'));
    if (!below || at.size() < longest) continue;
    longest = at.size();
    found = Mount{std::string(words[2]), std::string(words[3])};
  }
  return found;
}

}  // namespace plc::doctor
