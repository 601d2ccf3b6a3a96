#include "tools/plc/replay_case.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <system_error>

#include "io-drivers/csv.h"
#include "io-drivers/stimulus.h"
#include "io-drivers/trace.h"
#include "retain/gather.h"
#include "retain/store.h"
#include "runtime/access.h"
#include "runtime/value_text.h"
#include "stdlib/library.h"
#include "tools/command_line.h"
#include "tools/watched_paths.h"

namespace plc::tools {
namespace {

namespace fs = std::filesystem;
using core::Code;
using core::Problem;
using core::TimeNs;

/// How far back an instant at which all cyclic tasks are released is looked for.
constexpr TimeNs kFarthestAlignmentNs = 60'000'000'000;

Problem cannot_write(const fs::path& path, const std::string& why) {
  return {Code::P7203, "cannot write " + path.string() + ": " + why, {}};
}

std::optional<Problem> write_text(const fs::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  out.close();
  if (!out) return cannot_write(path, std::system_category().message(errno));
  return std::nullopt;
}

/// What others than tasks wrote into variables, in the records of scans.
class OutsideWrites {
 public:
  explicit OutsideWrites(shadow::Player& player) : player_(player), image_(player.resource().image()) {
    for (runtime::Listed& listed : runtime::Access(player.resource()).list_places()) {
      const runtime::Place& place = listed.place;
      if (place.constant) continue;
      if (place.task == runtime::Place::kGlobal) {
        globals_.push_back({place, std::move(listed.path), exporters_of(place)});
      } else {
        locals_.push_back({place, std::move(listed.path), {}});
      }
    }
    for (auto* const leaves : {&globals_, &locals_})
      std::sort(leaves->begin(), leaves->end(),
                [](const Leaf& a, const Leaf& b) { return a.place.offset < b.place.offset; });
  }

  /// Looks at the scan that comes next. `before`: the global table as it is. The writes join those of the time.
  void look_at(const shadow::Player::Upcoming& next, TimeNs at_ns, std::span<const std::byte> before) {
    std::span<const std::byte> rest = next.record.subspan(sizeof(runtime::RecordHead));
    while (rest.size() >= sizeof(runtime::EntryHead)) {
      runtime::EntryHead head;
      std::memcpy(&head, rest.data(), sizeof head);
      const std::size_t whole = sizeof head + runtime::padded(head.bytes);
      if (whole > rest.size()) return;
      if (head.kind == runtime::EntryKind::kBytes) bytes(next.task, head, rest.data() + sizeof head, at_ns, before);
      rest = rest.subspan(whole);
    }
  }

  [[nodiscard]] std::size_t columns() const { return columns_.size(); }
  /// As a stimulus; empty without a write.
  [[nodiscard]] std::string csv() const {
    if (rows_.empty()) return {};
    std::string text = "time_ms";
    std::vector<const std::string*> order(columns_.size());
    for (const auto& [path, column] : columns_) order[column] = &path;
    for (const std::string* const path : order) {
      text += ',';
      io::append_csv(text, *path);
    }
    text += '\n';
    for (const auto& [at_ns, cells] : rows_) {
      io::append_time_ms(text, at_ns);
      for (std::size_t column = 0; column < columns_.size(); ++column) {
        text += ',';
        const auto cell = cells.find(column);
        if (cell != cells.end()) io::append_csv(text, cell->second);
      }
      text += '\n';
    }
    return text;
  }

 private:
  struct Leaf {
    runtime::Place place;
    std::string path;
    std::vector<std::uint32_t> exporters;
  };

  [[nodiscard]] std::vector<std::uint32_t> exporters_of(const runtime::Place& place) const {
    const runtime::GlobalTable& globals = player_.resource().globals();
    return globals.exporters(globals.field_of(place.offset));
  }

  void bytes(std::uint32_t task, const runtime::EntryHead& head, const std::byte* from, TimeNs at_ns,
             std::span<const std::byte> before) {
    const std::byte* const table = player_.resource().program(task).table().data();
    const std::uint64_t end = std::uint64_t{head.at} + head.bytes;
    const auto each = [&](const std::vector<Leaf>& leaves, const auto& written) {
      auto leaf = std::partition_point(leaves.begin(), leaves.end(),
                                       [&](const Leaf& one) { return one.place.offset < head.at; });
      for (; leaf != leaves.end() && leaf->place.offset < end; ++leaf) {
        const bytecode::ImageType& type = image_.types[leaf->place.type];
        if (leaf->place.offset + std::uint64_t{type.size} > end || !written(*leaf, type)) continue;
        const auto column = columns_.emplace(leaf->path, columns_.size()).first->second;
        std::string& cell = rows_[at_ns][column];
        cell.clear();
        runtime::append_value(type, from + (leaf->place.offset - head.at), cell);
      }
    };
    each(globals_, [&](const Leaf& leaf, const bytecode::ImageType& type) {
      const std::byte* const now = from + (leaf.place.offset - head.at);
      // What another task may have written is no write from outside.
      const bool own = leaf.exporters.empty() || (leaf.exporters.size() == 1 && leaf.exporters.front() == task);
      return own && leaf.place.offset + type.size <= before.size() &&
             std::memcmp(now, before.data() + leaf.place.offset, type.size) != 0;
    });
    each(locals_, [&](const Leaf& leaf, const bytecode::ImageType& type) {
      const std::byte* const now = from + (leaf.place.offset - head.at);
      return leaf.place.task == task && std::memcmp(now, table + leaf.place.offset, type.size) != 0;
    });
  }

  shadow::Player& player_;
  const bytecode::Image& image_;
  std::vector<Leaf> globals_, locals_;  ///< ascending offsets
  std::map<std::string, std::size_t> columns_;
  std::map<TimeNs, std::map<std::size_t, std::string>> rows_;
};

bool is_cyclic(const bytecode::ImageTask& task) { return task.period_ns > 0; }

/// The last instant up to `from_ns` at which all cyclic tasks have a scan; nothing when there is none nearby.
std::optional<TimeNs> common_instant(shadow::Player& player, TimeNs from_ns) {
  const bytecode::Image& image = player.resource().image();
  std::size_t cyclic = 0;
  for (const bytecode::ImageTask& task : image.tasks) cyclic += is_cyclic(task) ? 1 : 0;
  std::optional<TimeNs> found;
  player.seek(from_ns - kFarthestAlignmentNs);
  while (const auto now_ns = player.next_ns()) {
    // The first instant at or after `from_ns` counts when there is none before it.
    if (*now_ns > from_ns && (found || *now_ns > from_ns + kFarthestAlignmentNs)) break;
    std::size_t ran = 0;
    while (player.next_ns() == now_ns) {
      const auto played = player.step();
      ran += is_cyclic(image.tasks[played->task]) ? 1 : 0;
    }
    if (ran == cyclic) found = *now_ns;
  }
  return found;
}

/// The values of all variables, by names and types, as a file of retained values.
std::optional<Problem> write_state(runtime::Resource& resource, const fs::path& folder, TimeNs now_ns, TimeNs utc_ns) {
  const retain::Kept kept = retain::find_kept(resource, retain::What::kEverything);
  std::vector<std::byte> values(kept.layout.bytes);
  retain::Gatherer(resource, kept).copy_initial(values);
  retain::Store store(folder.string(), kept.layout);
  const std::string wrong = store.write(values, now_ns, utc_ns);
  if (!wrong.empty()) return Problem{Code::P7203, wrong, {}};
  return std::nullopt;
}

std::map<std::string, std::uint64_t> events_of(const runtime::Resource& resource) {
  std::map<std::string, std::uint64_t> events;
  for (std::size_t task = 0; task < resource.task_count(); ++task) {
    for (const runtime::EventCount& event : resource.program(task).events())
      events[std::string(stdlib::event_name(event.last))] += event.count;
  }
  return events;
}

std::vector<std::string> paths_of_table(runtime::Resource& resource, const std::vector<std::string>& watch) {
  if (!watch.empty()) return watched_paths(watch, resource);
  std::vector<std::string> outputs = watched_paths({"%Q*"}, resource);
  return outputs.empty() ? watched_paths({}, resource) : outputs;
}

/// Copies a file or folder; `to` has no extension yet.
std::optional<Problem> copy_project(const fs::path& from, const fs::path& to) {
  std::error_code error;
  if (fs::is_directory(from, error)) {
    fs::copy(from, to, fs::copy_options::recursive | fs::copy_options::overwrite_existing, error);
  } else {
    fs::copy_file(from, to.string() + from.extension().string(), fs::copy_options::overwrite_existing, error);
  }
  if (error) return Problem{Code::P7001, from.string() + ": " + error.message(), {}};
  return std::nullopt;
}

}  // namespace

core::Result<WrittenCase> write_case(shadow::Player& player, const ReplayCase& request) {
  const fs::path folder = request.folder;
  runtime::Resource& resource = player.resource();
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return cannot_write(folder, error.message());
  if (auto problem = copy_project(request.project, folder / "project")) return *problem;
  WrittenCase out;
  // A simulation has no latencies.
  player.count_releases();
  const auto missing_from_ns = player.missing_from_ns();
  const auto common = common_instant(player, request.from_ns);
  out.aligned = common.has_value();
  out.begin_ns = common.value_or(request.from_ns);
  player.seek(out.begin_ns - 1);
  player.show_globals();
  const auto first = player.upcoming();
  if (!first) return Problem{Code::P7630, "the recording has no scan there", {}};
  runtime::RecordHead head;
  std::memcpy(&head, first->record.data(), sizeof head);
  if (auto problem = write_state(resource, folder / "start", out.begin_ns, head.utc_ns)) return *problem;

  const std::vector<std::string> paths = paths_of_table(resource, request.watch);
  auto table = io::TraceWriter::open((folder / "expected.csv").string(), paths, resource);
  if (!table) return table.error();
  out.variables = paths.size();
  OutsideWrites writes(player);
  std::string faults;
  std::vector<std::uint64_t> scans(resource.task_count());
  const auto events_before = events_of(resource);
  bool ends = false;
  while (const auto now_ns = player.next_ns()) {
    if (ends || (request.until_ns && *now_ns > *request.until_ns)) break;
    // Where the plant ended, one task may have run once more than another.
    if (missing_from_ns && *now_ns >= *missing_from_ns) break;
    const TimeNs at_ns = *now_ns - out.begin_ns;
    while (player.next_ns() == now_ns) {
      writes.look_at(*player.upcoming(), at_ns, player.replicas().globals());
      const auto played = player.step();
      out.different += played->outcome.equal ? 0 : 1;
      const std::uint64_t scan = scans[played->task]++;
      if (!played->outcome.fault) continue;
      ends = ends || request.until_fault;
      faults += fmt::format("fault: {} {} {}\n", core::info(runtime::fault_code(played->outcome.fault.kind)).name,
                            resource.program(played->task).task().name, scan);
    }
    player.show_globals();
    (*table)->record({out.instants++, at_ns, {}});
  }
  if (auto problem = (*table)->close()) return *problem;
  out.inputs = writes.columns();
  if (const std::string stimulus = writes.csv(); !stimulus.empty()) {
    if (auto problem = write_text(folder / "stimulus.csv", stimulus)) return *problem;
  }
  std::string manifest = "# A piece of a recording, written by plc replay --test.\nstart: start\n" + faults;
  for (const auto& [kind, count] : events_of(resource)) {
    const auto before = events_before.find(kind);
    const std::uint64_t here = count - (before == events_before.end() ? 0 : before->second);
    if (here != 0) manifest += fmt::format("event: {} {}\n", kind, here);
  }
  for (const std::string& library : request.libraries) {
    const fs::path name = fs::path(library).filename();
    fs::copy_file(library, folder / name, fs::copy_options::overwrite_existing, error);
    if (error) return Problem{Code::P7001, library + ": " + error.message(), {}};
    manifest += "lib: " + name.string() + '\n';
  }
  const std::string flags = compile_flags(request.options, {});
  if (!flags.empty()) manifest += "run: expected.csv" + flags + '\n';
  if (auto problem = write_text(folder / "case.txt", manifest)) return *problem;
  return out;
}

}  // namespace plc::tools
